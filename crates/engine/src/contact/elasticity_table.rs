//! The elasticity of each pair of bodies: the most specific rule of the scene, by tags.

use carom_response::Elasticity;

use crate::{
    contact::guard::Guard,
    scene::{ElasticityRule, ElasticitySpec, error::SceneError},
    world::{
        World,
        body::Body,
        tag_classes::sort_into_classes,
        tags::{Tag, TagNames, Tags},
    },
};

/// Elasticity of each kind of contact. A rule for a pair of tags overrides a rule for one tag, and
/// that overrides the default; two rules of equal rank that both apply and disagree are an error.
#[derive(Debug, Clone, Default)]
pub struct ElasticityTable {
    default: Elasticity,
    pub(crate) guard: Guard,
    rules: Vec<Rule>,
    /// Number of different sets of tags; bodies with equal tags are of one class.
    classes: usize,
    /// Coefficient for each pair of classes; empty if the default applies to all.
    by_class: Vec<Elasticity>,
}

#[derive(Debug, Clone)]
struct Rule {
    tags: Vec<Tag>,
    names: Vec<String>,
    elasticity: Elasticity,
}

/// The shortest contact time c of a guard. Shorter: at e = 0 molecules in lasting contact bounce by
/// c² of their size, which is below the rounding of positions (seen at 2e-6, in a box of 30
/// diameters).
const MIN_CONTACT: f64 = 1e-5;

impl ElasticityTable {
    /// Whether the elasticity of each pair of existing bodies is 1.
    #[inline]
    pub fn is_elastic(&self) -> bool {
        self.by_class.is_empty() && self.default == Elasticity::ELASTIC
    }

    /// The elasticity of a contact between two bodies.
    pub fn between(&self, a: &Body, b: &Body) -> Elasticity {
        if self.by_class.is_empty() {
            return self.default;
        }
        self.by_class[a.kind.tag_class as usize * self.classes + b.kind.tag_class as usize]
    }

    /// The class of a body: bodies of one class have the same elasticity with each other body.
    pub(crate) fn class_of(&self, body: &Body) -> u32 {
        if self.by_class.is_empty() {
            0
        } else {
            body.kind.tag_class
        }
    }

    pub(crate) fn new(spec: &ElasticitySpec, names: &mut TagNames) -> Result<Self, SceneError> {
        let coefficient = |entry: String, value: f64| {
            Elasticity::new(value).map_err(|reason| SceneError::Elasticity { entry, reason })
        };
        let mut rules = Vec::new();
        for (index, rule) in spec.pair.iter().enumerate() {
            let entry = format!("elasticity.pair[{index}]");
            if !(1..=2).contains(&rule.between.len()) {
                let problem = format!(
                    "`between` must name one or two tags, but is {:?}",
                    rule.between
                );
                return Err(SceneError::Entry { entry, problem });
            }
            rules.push(Rule {
                tags: rule.between.iter().map(|name| names.intern(name)).collect(),
                names: rule.between.clone(),
                elasticity: coefficient(entry, rule.coefficient)?,
            });
        }
        let default = coefficient("elasticity.default".to_owned(), spec.default)?;
        if !(0.0..=1.0).contains(&spec.contact_time) {
            let problem = format!("it must be from 0 to 1, but is {}", spec.contact_time);
            return Err(SceneError::Entry {
                entry: "elasticity.contact_time".to_owned(),
                problem,
            });
        }
        if spec.contact_time > 0.0 && spec.contact_time < MIN_CONTACT {
            let problem = format!(
                "it must be 0 (no guard) or at least {MIN_CONTACT:e}, but is {:e}: turning molecules would \
                 bounce by less than the rounding of positions, and sink into each other",
                spec.contact_time
            );
            return Err(SceneError::Entry {
                entry: "elasticity.contact_time".to_owned(),
                problem,
            });
        }
        let guard = Guard {
            contact_time: spec.contact_time,
        };
        Ok(Self {
            default,
            guard,
            rules,
            classes: 0,
            by_class: Vec::new(),
        })
    }

    /// Prepares the table and that of the pairs for the bodies of a world, and lets the world keep
    /// the times that the guard needs.
    pub(crate) fn classify(&mut self, world: &mut World) -> Result<(), SceneError> {
        self.by_class.clear();
        if !self.rules.is_empty() || world.pairs.has_rules() {
            let classes = sort_into_classes(world);
            self.look_up(&classes)?;
            world.pairs.look_up(&classes, &world.bodies)?;
        }
        world.keep_last_contacts(self.is_guarded());
        world.has_thermal_walls = world
            .bodies
            .iter()
            .any(|body| body.kind.temperature.is_some());
        Ok(())
    }

    /// Whether the table has elasticities below 1, which a guard raises. A guarded contact has
    /// elasticity 1, which a response cannot distinguish from elasticity 1 in the table.
    fn is_guarded(&self) -> bool {
        self.loses_energy() && self.guard.contact_time > 0.0
    }

    /// Whether the table has elasticities below 1.
    pub(crate) fn loses_energy(&self) -> bool {
        let loses = |elasticity: Elasticity| elasticity.coefficient() < 1.0;
        loses(self.default) || self.rules.iter().any(|rule| loses(rule.elasticity))
    }

    /// The rules as in a scene.
    pub(crate) fn spec(&self) -> ElasticitySpec {
        let rule = |rule: &Rule| ElasticityRule {
            between: rule.names.clone(),
            coefficient: rule.elasticity.coefficient(),
        };
        ElasticitySpec {
            default: self.default.coefficient(),
            contact_time: self.guard.contact_time,
            pair: self.rules.iter().map(rule).collect(),
        }
    }

    /// Finds the elasticity of each pair of classes once.
    fn look_up(&mut self, classes: &[Tags]) -> Result<(), SceneError> {
        self.classes = classes.len();
        let mut by_class = Vec::with_capacity(self.classes * self.classes);
        for a in classes {
            for b in classes {
                by_class.push(self.resolve(a, b)?);
            }
        }
        // Rules that affect no existing body have no cost.
        if by_class
            .iter()
            .any(|elasticity| *elasticity != self.default)
        {
            self.by_class = by_class;
        }
        Ok(())
    }

    fn resolve(&self, a: &Tags, b: &Tags) -> Result<Elasticity, SceneError> {
        for rank in [2, 1] {
            let mut found: Option<&Rule> = None;
            for rule in self
                .rules
                .iter()
                .filter(|rule| rule.tags.len() == rank && rule.applies(a, b))
            {
                match found {
                    Some(first) if first.elasticity != rule.elasticity => {
                        return Err(SceneError::AmbiguousElasticity {
                            first: first.names.clone(),
                            second: rule.names.clone(),
                            one: first.elasticity.coefficient(),
                            other: rule.elasticity.coefficient(),
                        });
                    }
                    _ => found = Some(rule),
                }
            }
            if let Some(rule) = found {
                return Ok(rule.elasticity);
            }
        }
        Ok(self.default)
    }
}

impl Rule {
    fn applies(&self, a: &Tags, b: &Tags) -> bool {
        match self.tags[..] {
            [tag] => a.contains(&tag) || b.contains(&tag),
            [one, other] => {
                (a.contains(&one) && b.contains(&other)) || (a.contains(&other) && b.contains(&one))
            }
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use carom_detection::Exact;
    use carom_kinematics::{Inertia, Motion};
    use carom_response::{ContactFrame, Impact, Response};
    use glam::DVec2;

    use super::*;
    use crate::{
        cells::{CellScheduler, Instructions},
        run::simulation::Simulation,
        scene::{BumperSpec, Scene},
    };

    /// A response that loses energy at any elasticity below 2.
    struct Lossy;

    impl Response for Lossy {
        fn impulse(
            &self,
            frame: &ContactFrame,
            bodies: [(&Motion, &Inertia); 2],
            e: Elasticity,
        ) -> DVec2 {
            0.5 * Impact.impulse(frame, bodies, e)
        }
    }

    #[test]
    fn last_contacts_are_kept_only_where_the_guard_can_raise_an_elasticity() {
        let rule = |tag: &str, coefficient| ElasticityRule {
            between: vec![tag.to_owned()],
            coefficient,
        };
        let table = |default, pair| ElasticitySpec {
            default,
            pair,
            ..ElasticitySpec::default()
        };
        for (elasticity, kept) in [
            (table(1.0, vec![]), 0),
            (table(1.5, vec![]), 0),
            (table(1.0, vec![rule("a", 1.2)]), 0),
            (table(0.9, vec![]), 1),
            (table(1.0, vec![rule("a", 0.5)]), 1),
            (
                ElasticitySpec {
                    contact_time: 0.0,
                    ..table(0.5, vec![])
                },
                0,
            ),
        ] {
            let bumper = vec![BumperSpec {
                tags: Vec::new(),
                at: [0.5; 2],
                radius: 0.1,
            }];
            let scene = Scene {
                bumper,
                elasticity,
                ..Scene::default()
            };
            let options = Instructions::default();
            let simulation: Simulation<Exact, Lossy, CellScheduler> =
                Simulation::with(&scene, Exact::default(), Lossy, options).unwrap();
            assert_eq!(
                simulation.world.last_contacts().len(),
                kept,
                "{:?}",
                scene.elasticity
            );
        }
    }

    #[test]
    fn alternating_kinds_stay_shared_when_they_are_classified() {
        let bumper = |n: u32| BumperSpec {
            tags: vec![["a", "b"][n as usize % 2].to_owned()],
            at: [0.1 * f64::from(n % 10), 0.1 * f64::from(n / 10)],
            radius: 0.01,
        };
        let pair = vec![ElasticityRule {
            between: vec!["a".to_owned()],
            coefficient: 0.5,
        }];
        let elasticity = ElasticitySpec {
            pair,
            ..ElasticitySpec::default()
        };
        let scene = Scene {
            bumper: (0..100).map(bumper).collect(),
            elasticity,
            ..Scene::default()
        };
        let simulation: Simulation = Simulation::new(&scene).unwrap();
        assert_eq!(simulation.world.count_kinds(), 2);
    }
}
