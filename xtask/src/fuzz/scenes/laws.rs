//! The rules of a scene for pairs of bodies, evaluated independently of the engine: which
//! coefficients a contact has, and at which distance two bodies touch.

use carom::engine::{DiameterSpec, ElasticitySpec, Restitution, Scene, TransparentSpec, WellSpec};

/// Relative rounding of a coefficient that depends on the speed: a power with an exponent up to 10
/// of a ratio of speeds multiplies the rounding of the logarithm of the ratio.
const ROUNDING_OF_POWER: f64 = 1e-12;

/// The rules of a scene that decide on contacts and on flights.
#[derive(Debug, Clone)]
pub struct SceneRules {
    /// Coefficients of contacts.
    pub elasticity: ElasticitySpec,
    /// Pairs of tags that do not see each other.
    pub transparent: Vec<TransparentSpec>,
    /// Pairs of tags of discs with a factor on their contact distance.
    pub diameter: Vec<DiameterSpec>,
    /// Pairs of tags of discs with a well.
    pub well: Vec<WellSpec>,
    /// Drag of all bodies (1 / time).
    pub drag: f64,
    /// Acceleration of free bodies by gravity (length per time²).
    pub gravity: [f64; 2],
    /// True if some wall has a motion, or had one before an edit.
    pub moves_walls: bool,
}

/// The coefficients of the contacts of two bodies.
#[derive(Debug, Clone)]
pub struct ContactLaw {
    /// Normal restitution.
    pub restitution: Restitution,
    /// Tangential restitution β.
    pub tangential: f64,
    /// Coefficient of friction μ; infinite if the surfaces never slide.
    pub friction: f64,
    /// Impulse across the normal (mass × length / time).
    pub kick: f64,
}

/// Returns true if a rule for one or two tags applies to two bodies, each of which must carry one
/// of two tags, or both the only one.
fn applies(between: &[String], a: &[String], b: &[String]) -> bool {
    let (Some(one), Some(other)) = (between.first(), between.last()) else {
        return false;
    };
    (a.contains(one) && b.contains(other)) || (a.contains(other) && b.contains(one))
}

impl SceneRules {
    /// The rules of a scene at its start.
    pub fn new(scene: &Scene) -> Self {
        Self {
            elasticity: scene.elasticity.clone(),
            transparent: scene.transparent.clone(),
            diameter: scene.diameter.clone(),
            well: scene.well.clone(),
            drag: scene.bounds.drag,
            gravity: scene.gravity.acceleration,
            moves_walls: scene.wall.iter().any(|wall| wall.motion.is_some()),
        }
    }

    /// The factor on the contact distance of two bodies with these tags: 0 if they do not see each
    /// other.
    pub fn factor(&self, a: &[String], b: &[String]) -> f64 {
        let is_blind = |rule: &TransparentSpec| applies(&rule.between, a, b);
        if self.transparent.iter().any(is_blind) {
            return 0.0;
        }
        let rule = self
            .diameter
            .iter()
            .find(|rule| applies(&rule.between, a, b));
        rule.map_or(1.0, |rule| rule.factor)
    }

    /// The steps of the well of two bodies with these tags, each a range in distances at contact
    /// and an energy (mass × length² / time²); none without a well.
    pub fn steps(&self, a: &[String], b: &[String]) -> Option<&[[f64; 2]]> {
        if self.factor(a, b) == 0.0 {
            return None;
        }
        let rule = self.well.iter().find(|rule| applies(&rule.between, a, b))?;
        Some(&rule.steps)
    }

    /// The coefficients from the most specific rule for two bodies with these tags.
    pub fn law(&self, a: &[String], b: &[String]) -> ContactLaw {
        let of_pair = self
            .elasticity
            .pair
            .iter()
            .find(|rule| rule.between.len() == 2 && applies(&rule.between, a, b));
        let of_one = || {
            self.elasticity.pair.iter().find(
                |rule| matches!(&rule.between[..], [one] if a.contains(one) || b.contains(one)),
            )
        };
        match of_pair.or_else(of_one) {
            Some(rule) => ContactLaw {
                restitution: rule.coefficient.clone(),
                tangential: rule.tangential,
                friction: rule.friction.unwrap_or(f64::INFINITY),
                kick: rule.kick,
            },
            None => ContactLaw {
                restitution: self.elasticity.default.into(),
                tangential: self.elasticity.tangential,
                friction: self.elasticity.friction.unwrap_or(f64::INFINITY),
                kick: 0.0,
            },
        }
    }
}

impl ContactLaw {
    /// Returns true if the impulse of a contact may have a part across the normal.
    pub fn is_rough(&self) -> bool {
        self.kick != 0.0 || (self.tangential > -1.0 && self.friction > 0.0)
    }

    /// The least and the greatest coefficient of restitution at speeds of approach from `slow` to
    /// `fast`, with the rounding of a law that depends on the speed (length per time).
    pub fn coefficients(&self, slow: f64, fast: f64) -> [f64; 2] {
        let mut values = match &self.restitution {
            Restitution::Number(number) => return [*number; 2],
            Restitution::Power { power, at } => {
                vec![power_law(slow / at, *power), power_law(fast / at, *power)]
            }
            Restitution::Table { speeds, values } => {
                let ends = [slow, fast].map(|speed| interpolated(speeds, values, speed));
                let inside = speeds.iter().zip(values);
                inside
                    .filter(|(speed, _)| (slow..=fast).contains(*speed))
                    .map(|(_, value)| *value)
                    .chain(ends)
                    .collect()
            }
        };
        values.sort_by(f64::total_cmp);
        let [least, most] = [values[0], values[values.len() - 1]];
        [
            least * (1.0 - ROUNDING_OF_POWER),
            most * (1.0 + ROUNDING_OF_POWER),
        ]
    }
}

/// The power of a ratio of speeds, at most 1; a ratio below 0 counts as 0.
fn power_law(ratio: f64, power: f64) -> f64 {
    if power == 0.0 || (ratio <= 0.0 && power < 0.0) {
        1.0
    } else if ratio <= 0.0 {
        0.0
    } else {
        libm::exp(power * libm::log(ratio)).min(1.0)
    }
}

/// The value of a table at a speed: that of a straight line between two points, and that of the
/// nearest point outside.
fn interpolated(speeds: &[f64], values: &[f64], speed: f64) -> f64 {
    let after = speeds.iter().position(|&point| point > speed);
    match after {
        Some(0) => values[0],
        None => values[values.len() - 1],
        Some(after) => {
            let [from, to] = [speeds[after - 1], speeds[after]];
            let [low, high] = [values[after - 1], values[after]];
            low + (high - low) * ((speed - from) / (to - from))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(restitution: Restitution) -> ContactLaw {
        ContactLaw {
            restitution,
            tangential: -1.0,
            friction: f64::INFINITY,
            kick: 0.0,
        }
    }

    #[test]
    fn laws_of_the_speed_agree_with_those_of_the_engine() {
        let laws = [
            Restitution::Power {
                power: -0.25,
                at: 0.1,
            },
            Restitution::Power {
                power: 1.5,
                at: 2.0,
            },
            Restitution::Table {
                speeds: vec![0.1, 0.5, 2.0],
                values: vec![1.0, 0.3, 0.7],
            },
        ];
        for restitution in laws {
            let law = law(restitution.clone());
            for step in 0..300 {
                let speed = 0.01 * f64::from(step);
                let [low, high] = law.coefficients(speed, speed);
                let theirs = restitution.at(speed);
                assert!((low..=high).contains(&theirs), "{restitution:?} {speed}");
                assert!(high - low <= 1e-11 * high);
            }
        }
    }

    #[test]
    fn a_range_of_speeds_contains_the_points_of_a_table() {
        let law = law(Restitution::Table {
            speeds: vec![1.0, 2.0, 3.0],
            values: vec![0.5, 0.9, 0.5],
        });
        let [low, high] = law.coefficients(1.5, 2.5);
        assert!((low - 0.7).abs() < 1e-11 && (high - 0.9).abs() < 1e-11);
    }

    #[test]
    fn transparent_pairs_come_before_diameters() {
        let tags = |names: &[&str]| -> Vec<String> {
            names.iter().map(|name| (*name).to_owned()).collect()
        };
        let mut scene = Scene::default();
        scene.transparent.push(TransparentSpec {
            between: tags(&["a"]),
        });
        scene.diameter.push(DiameterSpec {
            between: tags(&["a", "b"]),
            factor: 0.5,
        });
        let rules = SceneRules::new(&scene);
        let factor = |a: &[&str], b: &[&str]| rules.factor(&tags(a), &tags(b));
        assert_eq!(factor(&["a"], &["a"]), 0.0);
        assert_eq!(factor(&["b"], &["a"]), 0.5);
        assert_eq!(factor(&["a", "b"], &["a"]), 0.0);
        assert_eq!(factor(&["a"], &[]), 1.0);
    }
}
