//! The coefficients of contacts in a scene: restitution, roughness, friction and kicks, by tags.

use std::fmt;

use carom_response::{Elasticity, ElasticityError};
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{Error, MapAccess, Visitor},
    ser::SerializeMap,
};

use crate::scene::is_zero;

/// Elasticity of contacts.
///
/// After a contact that changes energy, surfaces separate at least at four times the speed that
/// rounding lets the search for contacts resolve. For atoms and the ends of walls this is a share
/// of 4·10⁻¹⁴ to 4·10⁻¹³ sides / s of their relative speed, with s the sum of the radii of the two
/// touching parts. A scene in which the share could exceed a thousandth is refused: s must be at
/// least 6·10⁻¹¹ sides, and up to 5·10⁻¹⁰ in a dilute scene or one with a single moving body. Two
/// discs, and the faces of walls, keep their coefficient to rounding at any size.
///
/// Two bodies that touch at several points at one instant, such as a rod that falls flat on a wall,
/// get one joint impulse: the smallest set of impulses along the normals after which each point
/// separates at least as fast as the coefficient demands, so that a symmetric contact stays
/// symmetric. Contacts of one body with several others at one instant are resolved one after the
/// other, in the order of the numbers of their two bodies; the result depends on that order, and
/// the run counts them. So are the points of a body on a wall that has a temperature, and the
/// points of rough contacts.
///
/// A body that meets the common end of two walls has its contact with one of them, and the last
/// digit of the two times decides with which. This matters only where the two walls differ in
/// elasticity, tags or temperature.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ElasticitySpec {
    /// Coefficient of restitution of contacts to which no rule applies.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1e6)))]
    pub default: f64,
    /// Tangential restitution β of contacts to which no rule applies; see `elasticity.pair`. From
    /// −1 (smooth, the default) to 1.
    #[serde(skip_serializing_if = "is_smooth")]
    #[cfg_attr(feature = "schema", schemars(range(min = -1.0, max = 1.0)))]
    pub tangential: f64,
    /// Friction μ of contacts to which no rule applies, at least 0; see `elasticity.pair`. Default:
    /// rough contacts never slide.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub friction: Option<f64>,
    /// Guard against inelastic collapse, for contacts of elasticity below 1. A contact loses no
    /// energy if it follows the last contacts of both bodies (of the moving body, if the other is
    /// fixed) within this time. The unit is the time in which the two bodies, at their relative
    /// speed (including rotation), move by the diameter of the smaller one. Molecules that turn
    /// also separate with at least this fraction of their relative speed, or with their speed of
    /// approach if that is less. Range: from 1e-5 to 1, or 0 for no guard.
    ///
    /// Larger: more contacts of a dense gas that should lose energy are guarded, in proportion (for
    /// discs at an area fraction of 0.5, the fraction of contacts is about this number). Smaller:
    /// bodies in lasting contact collide more often, and at last so slowly that turning molecules
    /// sink into each other by rounding; at 0 they may have contacts without end.
    /// [`Counters::guarded_collisions`](crate::Counters::guarded_collisions) and
    /// [`Ledger::spared`](crate::Ledger::spared) count the effect.
    #[doc(alias = "inelastic collapse")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1.0)))]
    pub contact_time: f64,
    /// Rules by tags, which override the default.
    pub pair: Vec<ElasticityRule>,
}

impl Default for ElasticitySpec {
    fn default() -> Self {
        Self {
            default: 1.0,
            tangential: SMOOTH,
            friction: None,
            contact_time: 1e-4,
            pair: Vec::new(),
        }
    }
}

impl ElasticitySpec {
    /// The coefficients of contacts to which no rule applies.
    ///
    /// # Errors
    /// [`ElasticityError`] if one is out of range.
    pub(crate) fn of_default(&self) -> Result<Elasticity, ElasticityError> {
        Elasticity::new(self.default)?
            .with_tangential(self.tangential)?
            .with_friction(self.friction.unwrap_or(f64::INFINITY))
    }

    /// Whether all contacts are smooth and elastic: no rule changes the energy or turns a disc.
    pub fn is_elastic(&self) -> bool {
        self.default == 1.0
            && self.pair.iter().all(|rule| rule.coefficient == 1.0)
            && !self.is_rough()
    }

    /// Whether some contacts have tangential impulses: β above −1 and μ above 0, or a kick.
    pub fn is_rough(&self) -> bool {
        let are_rough =
            |tangential: f64, friction: Option<f64>| tangential != SMOOTH && friction != Some(0.0);
        are_rough(self.tangential, self.friction)
            || self
                .pair
                .iter()
                .any(|rule| are_rough(rule.tangential, rule.friction) || rule.kick != 0.0)
    }

    /// Whether some contacts lose energy: a restitution below 1, or a roughness that is not
    /// perfect.
    pub fn loses_energy(&self) -> bool {
        let rubs = |tangential: f64, friction: Option<f64>| {
            friction != Some(0.0)
                && tangential != SMOOTH
                && (tangential != 1.0 || friction.is_some())
        };
        self.least_coefficient() < 1.0
            || rubs(self.tangential, self.friction)
            || self
                .pair
                .iter()
                .any(|rule| rubs(rule.tangential, rule.friction))
    }

    /// The least coefficient of restitution of any contact, at any speed.
    pub fn least_coefficient(&self) -> f64 {
        let of_rules = self.pair.iter().map(|rule| rule.coefficient.bounds()[0]);
        of_rules.fold(self.default, f64::min)
    }

    /// Whether some contacts can add energy: a restitution above 1, or a kick.
    pub fn adds_energy(&self) -> bool {
        let adds = |rule: &ElasticityRule| rule.coefficient.bounds()[1] > 1.0 || rule.kick != 0.0;
        self.default > 1.0 || self.pair.iter().any(adds)
    }
}

/// β of smooth contacts.
const SMOOTH: f64 = -1.0;

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_smooth(tangential: &f64) -> bool {
    *tangential == SMOOTH
}

fn smooth() -> f64 {
    SMOOTH
}

/// Elasticity of contacts between bodies of certain tags.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ElasticityRule {
    /// Two tags: contacts between bodies with these tags. One tag: contacts of bodies with this tag
    /// with any body.
    #[cfg_attr(feature = "schema", schemars(length(min = 1, max = 2)))]
    pub between: Vec<String>,
    /// The coefficient of restitution: a number, `{ power = p, at = speed }` or `{ speeds = [...],
    /// values = [...] }`.
    pub coefficient: Restitution,
    /// Tangential restitution β, the ratio of the tangential velocities of the surfaces after and
    /// before a contact that sticks, with opposite sign: −1 smooth (the default), 0 the surfaces
    /// roll on each other, 1 the tangential velocity is reversed. Discs with rough contacts have
    /// spins.
    #[serde(default = "smooth", skip_serializing_if = "is_smooth")]
    #[cfg_attr(feature = "schema", schemars(range(min = -1.0, max = 1.0)))]
    #[doc(alias = "rough")]
    pub tangential: f64,
    /// Coefficient of friction μ, at least 0: surfaces slide where the tangential impulse of a
    /// contact that sticks would exceed μ times the normal one. Default: they never slide. It has
    /// no effect without `tangential`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub friction: Option<f64>,
    /// Impulse across the normal that each contact gives to the two bodies, in opposite directions
    /// (mass × length / time, from −1e60 to 1e60): positive drives them counter-clockwise around
    /// each other, as chiral discs. It acts at the point of contact, and so turns bodies whose
    /// rotation is free; it adds energy. Default: 0.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[cfg_attr(feature = "schema", schemars(range(min = -1e60, max = 1e60)))]
    #[doc(alias = "chiral")]
    pub kick: f64,
}

/// A smooth elastic rule for no tag.
impl Default for ElasticityRule {
    fn default() -> Self {
        Self {
            between: Vec::new(),
            coefficient: Restitution::Number(1.0),
            tangential: SMOOTH,
            friction: None,
            kick: 0.0,
        }
    }
}

impl ElasticityRule {
    /// The coefficients in words, for an error.
    pub(crate) fn coefficients(&self) -> String {
        let restitution = match &self.coefficient {
            Restitution::Number(number) => number.to_string(),
            Restitution::Power { power, at } => format!("power {power} at {at}"),
            Restitution::Table { speeds, .. } => format!("a table of {} speeds", speeds.len()),
        };
        let tangential = (self.tangential != SMOOTH).then_some(("tangential", self.tangential));
        let friction = self.friction.map(|friction| ("friction", friction));
        let kick = (self.kick != 0.0).then_some(("kick", self.kick));
        let given = [tangential, friction, kick].into_iter().flatten();
        let others = given.map(|(name, value)| format!("{name} {value}"));
        let words: Vec<String> = std::iter::once(restitution).chain(others).collect();
        words.join(", ")
    }

    /// The coefficients of contacts to which the rule applies; of a restitution that depends on the
    /// speed, with that at speed 0.
    ///
    /// # Errors
    /// [`ElasticityError`] if one is out of range.
    pub(crate) fn elasticity(&self) -> Result<Elasticity, ElasticityError> {
        Elasticity::new(self.coefficient.at(0.0))?
            .with_tangential(self.tangential)?
            .with_friction(self.friction.unwrap_or(f64::INFINITY))?
            .with_kick(self.kick)
    }
}

/// A coefficient of restitution, which may depend on the speed of approach u.
///
/// ```
/// use carom_engine::Restitution;
///
/// // Plastic spheres (Johnson): e = (u / u₁)^(−1/4) above the speed u₁ of yield, 1 below.
/// let plastic = Restitution::Power { power: -0.25, at: 0.1 };
/// assert_eq!((plastic.at(0.05), plastic.at(1.6)), (1.0, 0.5));
/// let table = Restitution::Table { speeds: vec![0.0, 1.0], values: vec![1.0, 0.6] };
/// assert_eq!((table.at(0.5), table.at(3.0)), (0.8, 0.6));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Restitution {
    /// The same at each speed, from 0 to 10⁶.
    Number(f64),
    /// (u / `at`)^`power`, and 1 where that is above 1. The power is from −10 to 10, and `at` is a
    /// positive speed (length / time) from 10⁻⁶⁰ to 10⁶⁰. In a file: `{ power = p, at = speed }`.
    Power {
        /// The power.
        power: f64,
        /// The speed at which the coefficient is 1 (length / time).
        at: f64,
    },
    /// Linear between the points of a table, and constant outside it. In a file: `{ speeds = [...],
    /// values = [...] }`.
    Table {
        /// Speeds of approach (length / time), from 0 to 10⁶⁰ in ascending order, at least one.
        speeds: Vec<f64>,
        /// The coefficient at each, from 0 to 10⁶.
        values: Vec<f64>,
    },
}

const FORMS: &str = "a number, `{ power = p, at = speed }` or `{ speeds = [...], values = [...] }`";

/// Largest power of a power law: more is most likely an error.
const MAX_POWER: f64 = 10.0;

impl Restitution {
    /// The coefficient at a speed of approach (length / time).
    pub fn at(&self, speed: f64) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::Power { power, at } => {
                // The square root of the largest number is far beyond any speed.
                let share = libm::pow((speed / at).max(0.0), *power);
                if share < 1.0 { share } else { 1.0 }
            }
            Self::Table { speeds, values } => {
                let next = speeds.partition_point(|&point| point <= speed);
                match (next.checked_sub(1), speeds.get(next)) {
                    (Some(before), Some(&end)) => {
                        let start = speeds[before];
                        let share = (speed - start) / (end - start);
                        (1.0 - share) * values[before] + share * values[next]
                    }
                    (Some(last), None) => values[last],
                    (None, _) => values.first().copied().unwrap_or(1.0),
                }
            }
        }
    }

    /// The coefficient, if it is the same at each speed.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Power { .. } | Self::Table { .. } => None,
        }
    }

    /// The least and the greatest coefficient.
    pub fn bounds(&self) -> [f64; 2] {
        match self {
            Self::Number(number) => [*number; 2],
            Self::Power { power: 0.0, .. } => [1.0; 2],
            Self::Power { .. } => [0.0, 1.0],
            Self::Table { values, .. } => [
                values.iter().copied().fold(f64::INFINITY, f64::min),
                values.iter().copied().fold(0.0, f64::max),
            ],
        }
    }

    /// Refuses a law out of range; the message does not name the entry. A number is refused where
    /// it becomes an [`Elasticity`].
    pub(crate) fn check(&self) -> Result<(), String> {
        match self {
            Self::Power { power, at }
                if !(-MAX_POWER..=MAX_POWER).contains(power) || !(1e-60..=1e60).contains(at) =>
            {
                Err(format!(
                    "`coefficient` must have a `power` from -{MAX_POWER} to {MAX_POWER} and a speed `at` from 1e-60 \
                     to 1e60 (length / time), but they are {power:?} and {at:?}"
                ))
            }
            Self::Table { speeds, values } => {
                if speeds.is_empty() || speeds.len() != values.len() {
                    return Err(format!(
                        "`coefficient` has {} `speeds` and {} `values`: give at least one, and as many of both",
                        speeds.len(),
                        values.len()
                    ));
                }
                let in_range = speeds.iter().all(|speed| (0.0..=1e60).contains(speed));
                if !in_range || !speeds.is_sorted_by(|one, next| one < next) {
                    return Err(format!(
                        "the `speeds` of `coefficient` must ascend from 0 or more to 1e60 or less, but are {speeds:?}"
                    ));
                }
                match values.iter().find(|value| !(0.0..=1e6).contains(*value)) {
                    Some(value) => Err(format!(
                        "the `values` of `coefficient` must be from 0 to 1e6, but one is {value:?}"
                    )),
                    None => Ok(()),
                }
            }
            Self::Number(_) | Self::Power { .. } => Ok(()),
        }
    }
}

impl From<f64> for Restitution {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl PartialEq<f64> for Restitution {
    fn eq(&self, number: &f64) -> bool {
        self.number() == Some(*number)
    }
}

impl Serialize for Restitution {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = match self {
            Self::Number(number) => return serializer.serialize_f64(*number),
            Self::Power { .. } | Self::Table { .. } => serializer.serialize_map(Some(2))?,
        };
        match self {
            Self::Power { power, at } => {
                map.serialize_entry("power", power)?;
                map.serialize_entry("at", at)?;
            }
            Self::Table { speeds, values } => {
                map.serialize_entry("speeds", speeds)?;
                map.serialize_entry("values", values)?;
            }
            Self::Number(_) => {}
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Restitution {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(RestitutionVisitor)
    }
}

/// As the visitor reads it.
#[cfg(feature = "schema")]
impl schemars::JsonSchema for Restitution {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Restitution".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "anyOf": [
                { "type": "number", "minimum": 0.0, "maximum": 1e6 },
                {
                    "type": "object",
                    "properties": {
                        "power": { "type": "number", "minimum": -10.0, "maximum": 10.0 },
                        "at": { "type": "number", "minimum": 1e-60, "maximum": 1e60 },
                        "speeds": { "type": "array", "items": { "type": "number" } },
                        "values": { "type": "array", "items": { "type": "number" } }
                    },
                    "additionalProperties": false
                }
            ]
        })
    }
}

struct RestitutionVisitor;

impl<'de> Visitor<'de> for RestitutionVisitor {
    type Value = Restitution;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(FORMS)
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Restitution, E> {
        Ok(Restitution::Number(number))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Restitution, E> {
        Ok(Restitution::Number(number as f64))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Restitution, E> {
        Ok(Restitution::Number(number as f64))
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Restitution, M::Error> {
        let (mut power, mut at, mut speeds, mut values) = (None, None, None, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "power" => power = Some(map.next_value()?),
                "at" => at = Some(map.next_value()?),
                "speeds" => speeds = Some(map.next_value()?),
                "values" => values = Some(map.next_value()?),
                _ => {
                    return Err(M::Error::custom(format!(
                        "unexpected key `{key}`: give {FORMS}"
                    )));
                }
            }
        }
        match (power, at, speeds, values) {
            (Some(power), Some(at), None, None) => Ok(Restitution::Power { power, at }),
            (None, None, Some(speeds), Some(values)) => Ok(Restitution::Table { speeds, values }),
            _ => Err(M::Error::custom(format!("give {FORMS}"))),
        }
    }
}
