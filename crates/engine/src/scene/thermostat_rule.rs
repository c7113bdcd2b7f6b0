//! The rule of a thermostat, from the keys of its table: each kind has its own keys.

use carom_geometry::MAX_MAGNITUDE;

use crate::scene::{
    error::SceneError,
    kick_momentum::KickMomentum,
    stage_spec::{HeatSpec, ThermostatKind, ThermostatSpec},
    thermostat_target::ThermostatTarget,
};

/// What a thermostat does to each body of its tag in one action.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ThermostatRule {
    /// Velocity and angular velocity are scaled to this kinetic energy. Fixed bodies and bodies at
    /// rest are left out.
    EnergyReset(ThermostatTarget),
    /// Velocity and angular velocity are drawn from Maxwell's distribution at rest. Fixed bodies
    /// are left out.
    #[doc(alias = "Andersen")]
    Maxwell(ThermostatTarget),
    /// The velocity is set along an axis that diffuses.
    Active(SelfPropulsion),
    /// Velocity and angular velocity take an exact step of the Ornstein–Uhlenbeck process.
    Langevin(LangevinStep),
    /// The direction of the velocity is drawn anew; the speed and the angular velocity remain.
    /// Bodies at rest are left out.
    Rotate,
    /// A momentum is added; the angular velocity remains.
    Kick(KickMomentum),
    /// Velocities relative to the centre of mass of all bodies, and to the flow under shear, and
    /// angular velocities are scaled by one factor, so that the bodies of the tag have this kT
    /// (mass × length² / time²).
    #[doc(alias = "isokinetic")]
    Rescale(f64),
}

/// Self-propulsion: in each action the velocity of a body is set to `speed` along its axis.
///
/// The axis of a body that contacts turn is its orientation: its angular velocity is set so that
/// until the next action the body turns by a normal angle of variance 2 D_r τ, unless a contact
/// intervenes. A round body has an axis of its own ([`View::axis`](crate::View::axis)), at first in
/// a random direction, which turns by such an angle in the action itself. The axis of a locked body
/// is its orientation, which does not diffuse.
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(alias = "active Brownian particle")]
pub struct SelfPropulsion {
    /// Speed along the axis (length per time), from 0 to 10⁶⁰.
    pub speed: f64,
    /// Rotational diffusion coefficient D_r (radians² per time), from 0 to 10⁶⁰.
    pub rotational_diffusion: f64,
    /// Translational diffusion coefficient D_T (length² per time), from 0 to 10⁶⁰: a velocity of
    /// variance 2 D_T/τ per component is added.
    pub translational_diffusion: f64,
    /// Time τ between two actions, above 0.
    pub every: f64,
}

/// A step of the Langevin equation without forces, v' = −γ v + √(2 γ kT/m) ξ(t), over the time τ:
/// v becomes v e^(−γτ) + √((1 − e^(−2γτ)) kT/m) times a normal vector. Bodies that contacts turn
/// have the same γ for their angular velocity, with I in place of m.
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(alias = "Ornstein-Uhlenbeck")]
pub struct LangevinStep {
    /// Friction γ (1 / time), above 0 and at most 10⁶⁰.
    pub friction: f64,
    /// Temperature kT of the bath (mass × length² / time²), above 0 and at most 10⁶⁰.
    pub temperature: f64,
    /// Time τ between two actions, above 0.
    pub every: f64,
}

impl ThermostatKind {
    /// The name in a scene file.
    pub fn name(self) -> &'static str {
        match self {
            Self::EnergyReset => "energy-reset",
            Self::Maxwell => "maxwell",
            Self::Active => "active",
            Self::Langevin => "langevin",
            Self::Rotate => "rotate",
            Self::Kick => "kick",
            Self::Rescale => "rescale",
        }
    }

    /// The keys that belong to it.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::EnergyReset | Self::Maxwell => &["energy", "temperature"],
            Self::Active => &["speed", "rotational_diffusion", "translational_diffusion"],
            Self::Langevin => &["friction", "temperature"],
            Self::Rotate => &[],
            Self::Kick => &["momentum"],
            Self::Rescale => &["temperature"],
        }
    }
}

impl ThermostatSpec {
    /// The rule by which it acts.
    ///
    /// # Errors
    /// [`SceneError::Entry`] with the name `entry` if a key is missing, does not belong to the
    /// kind, or is out of range.
    pub fn rule(&self, entry: &str) -> Result<ThermostatRule, SceneError> {
        let keys = Keys {
            kind: self.kind,
            entry,
        };
        keys.refuse_others([
            ("energy", self.energy.is_some()),
            ("temperature", self.temperature.is_some()),
            ("speed", self.speed.is_some()),
            ("rotational_diffusion", self.rotational_diffusion.is_some()),
            (
                "translational_diffusion",
                self.translational_diffusion.is_some(),
            ),
            ("friction", self.friction.is_some()),
            ("momentum", self.momentum.is_some()),
        ])?;
        Ok(match self.kind {
            ThermostatKind::EnergyReset => ThermostatRule::EnergyReset(self.target(entry)?),
            ThermostatKind::Maxwell => ThermostatRule::Maxwell(self.target(entry)?),
            ThermostatKind::Active => ThermostatRule::Active(self.self_propulsion(&keys)?),
            ThermostatKind::Langevin => ThermostatRule::Langevin(LangevinStep {
                friction: keys.positive("friction", self.friction)?,
                temperature: keys.positive("temperature", self.temperature)?,
                every: self.every,
            }),
            ThermostatKind::Rotate => ThermostatRule::Rotate,
            ThermostatKind::Kick => ThermostatRule::Kick(keys.momentum(self.momentum)?),
            ThermostatKind::Rescale => {
                ThermostatRule::Rescale(keys.positive("temperature", self.temperature)?)
            }
        })
    }

    fn target(&self, entry: &str) -> Result<ThermostatTarget, SceneError> {
        target(self.energy, self.temperature, entry)
    }

    fn self_propulsion(&self, keys: &Keys<'_>) -> Result<SelfPropulsion, SceneError> {
        let diffusion = self.translational_diffusion.unwrap_or(0.0);
        let rule = SelfPropulsion {
            speed: keys.not_negative("speed", self.speed)?,
            rotational_diffusion: keys
                .not_negative("rotational_diffusion", self.rotational_diffusion)?,
            translational_diffusion: keys
                .not_negative("translational_diffusion", Some(diffusion))?,
            every: self.every,
        };
        if rule.speed == 0.0 && diffusion == 0.0 {
            return Err(keys.problem(
                "`speed` and `translational_diffusion` are both 0, so that no body moves: give one of them",
            ));
        }
        Ok(rule)
    }
}

impl HeatSpec {
    /// The rule by which it acts.
    ///
    /// # Errors
    /// [`SceneError::Entry`] with the name `entry` if the kind acts at regular times only, or if
    /// [`Self::target`] is refused.
    pub fn rule(&self, entry: &str) -> Result<ThermostatRule, SceneError> {
        let rule = match self.kind {
            ThermostatKind::EnergyReset => ThermostatRule::EnergyReset,
            ThermostatKind::Maxwell => ThermostatRule::Maxwell,
            other => {
                return Err(SceneError::Entry {
                    entry: entry.to_owned(),
                    problem: format!(
                        "kind = \"{}\" acts at regular times: give it as [[stage.thermostat]]",
                        other.name()
                    ),
                });
            }
        };
        Ok(rule(self.target(entry)?))
    }

    /// The energy or temperature to which it brings the bodies.
    ///
    /// # Errors
    /// [`SceneError::Entry`] with the name `entry` if there is not exactly one of both, or if it is
    /// not above 0 and at most 1e60.
    pub fn target(&self, entry: &str) -> Result<ThermostatTarget, SceneError> {
        target(self.energy, self.temperature, entry)
    }
}

fn target(
    energy: Option<f64>,
    temperature: Option<f64>,
    entry: &str,
) -> Result<ThermostatTarget, SceneError> {
    let problem = |problem: String| SceneError::Entry {
        entry: entry.to_owned(),
        problem,
    };
    let (key, value, target) = match (energy, temperature) {
        (Some(energy), None) => ("energy", energy, ThermostatTarget::Energy(energy)),
        (None, Some(kt)) => ("temperature", kt, ThermostatTarget::Temperature(kt)),
        _ => return Err(problem("give either `energy` or `temperature`".to_owned())),
    };
    if value > 0.0 && value <= MAX_MAGNITUDE {
        Ok(target)
    } else {
        Err(problem(format!(
            "`{key}` must be above 0 and at most {MAX_MAGNITUDE:e}, but is {value:?}"
        )))
    }
}

/// Reads the keys of one kind.
struct Keys<'a> {
    kind: ThermostatKind,
    entry: &'a str,
}

impl Keys<'_> {
    fn problem(&self, problem: impl Into<String>) -> SceneError {
        SceneError::Entry {
            entry: self.entry.to_owned(),
            problem: problem.into(),
        }
    }

    /// Refuses keys that are given and belong to another kind.
    fn refuse_others(
        &self,
        keys: impl IntoIterator<Item = (&'static str, bool)>,
    ) -> Result<(), SceneError> {
        let own = self.kind.keys();
        let mut given = keys.into_iter().filter(|(_, is_given)| *is_given);
        let Some((key, _)) = given.find(|(key, _)| !own.contains(key)) else {
            return Ok(());
        };
        let quoted: Vec<String> = own.iter().map(|key| format!("`{key}`")).collect();
        let takes = if quoted.is_empty() {
            "no further keys".to_owned()
        } else {
            quoted.join(", ")
        };
        Err(self.problem(format!(
            "`{key}` does not belong to kind = \"{}\", which takes {takes}: remove it or change `kind`",
            self.kind.name()
        )))
    }

    fn given<T>(&self, key: &str, value: Option<T>) -> Result<T, SceneError> {
        value.ok_or_else(|| {
            self.problem(format!(
                "`{key}` is missing: kind = \"{}\" needs it",
                self.kind.name()
            ))
        })
    }

    fn positive(&self, key: &str, value: Option<f64>) -> Result<f64, SceneError> {
        let value = self.given(key, value)?;
        if value > 0.0 && value <= MAX_MAGNITUDE {
            return Ok(value);
        }
        Err(self.problem(format!(
            "`{key}` must be above 0 and at most {MAX_MAGNITUDE:e}, but is {value:?}"
        )))
    }

    fn not_negative(&self, key: &str, value: Option<f64>) -> Result<f64, SceneError> {
        let value = self.given(key, value)?;
        if (0.0..=MAX_MAGNITUDE).contains(&value) {
            return Ok(value);
        }
        Err(self.problem(format!(
            "`{key}` must be from 0 to {MAX_MAGNITUDE:e}, but is {value:?}"
        )))
    }

    fn momentum(&self, value: Option<KickMomentum>) -> Result<KickMomentum, SceneError> {
        let momentum = self.given("momentum", value)?;
        match momentum {
            KickMomentum::Magnitude(magnitude) => {
                self.positive("momentum", Some(magnitude))?;
            }
            KickMomentum::Vector([x, y]) => {
                let largest = x.abs().max(y.abs());
                // `max` drops a NaN.
                if !(x.is_finite() && y.is_finite() && largest > 0.0 && largest <= MAX_MAGNITUDE) {
                    return Err(self.problem(format!(
                        "`momentum` must be a vector other than 0 with components of at most {MAX_MAGNITUDE:e}, \
                         but is [{x:?}, {y:?}]"
                    )));
                }
            }
        }
        Ok(momentum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec(kind: ThermostatKind) -> ThermostatSpec {
        ThermostatSpec {
            tag: "a".to_owned(),
            every: 0.1,
            kind,
            ..ThermostatSpec::default()
        }
    }

    fn refusal(spec: &ThermostatSpec) -> String {
        spec.rule("here").unwrap_err().to_string()
    }

    #[test]
    fn keys_of_another_kind_are_refused_by_name() {
        let rotate = ThermostatSpec {
            speed: Some(1.0),
            ..spec(ThermostatKind::Rotate)
        };
        assert_eq!(
            refusal(&rotate),
            "here: `speed` does not belong to kind = \"rotate\", which takes no further keys: remove it or change \
             `kind`"
        );
        let maxwell = ThermostatSpec {
            friction: Some(1.0),
            temperature: Some(1.0),
            ..spec(ThermostatKind::Maxwell)
        };
        assert_eq!(
            refusal(&maxwell),
            "here: `friction` does not belong to kind = \"maxwell\", which takes `energy`, `temperature`: remove it \
             or change `kind`"
        );
    }

    #[test]
    fn missing_keys_and_values_out_of_range_are_refused_by_name() {
        let langevin = ThermostatSpec {
            temperature: Some(1.0),
            ..spec(ThermostatKind::Langevin)
        };
        assert_eq!(
            refusal(&langevin),
            "here: `friction` is missing: kind = \"langevin\" needs it"
        );
        for friction in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
            let found = refusal(&ThermostatSpec {
                friction: Some(friction),
                ..langevin.clone()
            });
            assert_eq!(
                found,
                format!("here: `friction` must be above 0 and at most 1e60, but is {friction:?}")
            );
        }
        let active = ThermostatSpec {
            speed: Some(0.0),
            rotational_diffusion: Some(-0.5),
            ..spec(ThermostatKind::Active)
        };
        assert_eq!(
            refusal(&active),
            "here: `rotational_diffusion` must be from 0 to 1e60, but is -0.5"
        );
        let still = ThermostatSpec {
            rotational_diffusion: Some(0.5),
            ..active
        };
        assert!(refusal(&still).contains("are both 0"));
        for momentum in [[0.0, 0.0], [f64::NAN, 1.0], [1e61, 0.0]] {
            let kick = ThermostatSpec {
                momentum: Some(KickMomentum::Vector(momentum)),
                ..spec(ThermostatKind::Kick)
            };
            assert!(refusal(&kick).contains("a vector other than 0"));
        }
    }

    #[test]
    fn a_momentum_is_read_as_a_number_or_as_a_vector() {
        let read = |momentum: &str| {
            let text = format!(
                "[[stage]]\nuntil = 1.0\n[[stage.thermostat]]\ntag = \"a\"\nevery = 0.1\nkind = \"kick\"\n\
                 momentum = {momentum}"
            );
            crate::Scene::from_toml(&text).map(|scene| scene.stage[0].thermostat[0].momentum)
        };
        for number in ["2", "2.0", "\"sqrt(4)\""] {
            assert_eq!(read(number).unwrap(), Some(KickMomentum::Magnitude(2.0)));
        }
        assert_eq!(
            read("[1, -0.5]").unwrap(),
            Some(KickMomentum::Vector([1.0, -0.5]))
        );
        let refused = read("[1, 2, 3]").unwrap_err().to_string();
        assert!(refused.contains("there are 3"), "{refused}");
    }
}
