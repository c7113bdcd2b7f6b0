//! The elasticity of each pair of bodies: the most specific rule of the scene, by tags; and which
//! bodies have rough contacts.

use carom_response::{Elasticity, ElasticityError, Response};

use crate::{
    contact::{guard::Guard, reaction_table::ReactionTable},
    scene::{
        Scene,
        elasticity_spec::{ElasticityRule, ElasticitySpec},
        error::SceneError,
    },
    world::{
        World,
        body::{Body, BodyKind},
        tag_classes::{replace_kinds, sort_into_classes},
        tags::{Tag, TagNames, Tags},
        tethers::Bond,
    },
};

/// Elasticity of each kind of contact. A rule for a pair of tags overrides a rule for one tag, and
/// that overrides the default; two rules of equal rank that both apply and disagree are an error.
#[derive(Debug, Clone, Default)]
pub struct ElasticityTable {
    default: Elasticity,
    /// The scene's entry, without its rules.
    spec: ElasticitySpec,
    pub(crate) guard: Guard,
    rules: Vec<Rule>,
    /// Number of different sets of tags; bodies with equal tags are of one class.
    classes: usize,
    /// Coefficients for each pair of classes; empty if the default applies to all.
    by_class: Vec<PairElasticity>,
}

#[derive(Debug, Clone)]
struct Rule {
    tags: Vec<Tag>,
    spec: ElasticityRule,
    /// Of a restitution that depends on the speed, with that at speed 0.
    elasticity: Elasticity,
}

/// The coefficients of a pair of bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PairElasticity {
    elasticity: Elasticity,
    /// The rule whose restitution depends on the speed of approach.
    by_speed: Option<u32>,
}

/// The shortest contact time c of a guard. Shorter: at e = 0 molecules in lasting contact bounce by
/// c² of their size, which is below the rounding of positions (seen at 2e-6, in a box of 30
/// diameters).
const MIN_CONTACT: f64 = 1e-5;

impl ElasticityTable {
    /// Whether each pair of existing bodies is smooth and elastic.
    #[inline]
    pub fn is_elastic(&self) -> bool {
        self.by_class.is_empty() && self.default == Elasticity::ELASTIC
    }

    /// The elasticity of a contact between two bodies whose surfaces approach at this speed
    /// (length / time).
    #[inline]
    pub fn of_contact(&self, a: &Body, b: &Body, speed: impl FnOnce() -> f64) -> Elasticity {
        let Some(pair) = self.entry(a, b) else {
            return self.default;
        };
        match pair.by_speed {
            Some(rule) => self.at_speed(pair.elasticity, rule, speed()),
            None => pair.elasticity,
        }
    }

    /// Whether contacts between two bodies can change the energy along the normal, and the least
    /// coefficient of restitution.
    pub(crate) fn least_coefficient(&self, a: &Body, b: &Body) -> f64 {
        let Some(pair) = self.entry(a, b) else {
            return self.default.coefficient();
        };
        match pair.by_speed {
            Some(rule) => self.rules[rule as usize].spec.coefficient.bounds()[0],
            None => pair.elasticity.coefficient(),
        }
    }

    /// The elasticity of contacts between two bodies, if their speed has no effect on it.
    #[inline]
    pub(crate) fn at_any_speed(&self, a: &Body, b: &Body) -> Option<Elasticity> {
        match self.entry(a, b) {
            None => Some(self.default),
            Some(pair) => pair.by_speed.is_none().then_some(pair.elasticity),
        }
    }

    #[inline]
    fn entry(&self, a: &Body, b: &Body) -> Option<&PairElasticity> {
        let [a, b] = [a, b].map(|body| body.kind.tag_class as usize);
        self.by_class.get(a * self.classes + b)
    }

    #[cold]
    fn at_speed(&self, elasticity: Elasticity, rule: u32, speed: f64) -> Elasticity {
        let coefficient = self.rules[rule as usize].spec.coefficient.at(speed);
        // A law in range gives a coefficient in range.
        elasticity
            .with_coefficient(coefficient)
            .unwrap_or(elasticity)
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
        let rules = (spec.pair.iter().enumerate())
            .map(|(index, rule)| Rule::new(index, rule, names))
            .collect::<Result<_, _>>()?;
        let default = spec.of_default().map_err(|reason| SceneError::Elasticity {
            entry: match reason {
                ElasticityError::Coefficient(_) => "elasticity.default",
                _ => "elasticity",
            }
            .to_owned(),
            reason,
        })?;
        Ok(Self {
            default: simplified(default),
            spec: ElasticitySpec {
                pair: Vec::new(),
                ..spec.clone()
            },
            guard: guard_of(spec.contact_time)?,
            rules,
            classes: 0,
            by_class: Vec::new(),
        })
    }

    /// Prepares the table, that of the pairs and that of reactions for the bodies of a world and a
    /// response, and lets the world keep the times that the guard needs and the spins that rough
    /// contacts change.
    pub(crate) fn classify<R: Response>(
        &mut self,
        world: &mut World,
        response: &R,
        reactions: &mut ReactionTable,
    ) -> Result<(), SceneError> {
        self.by_class.clear();
        let reachable = if reactions.is_active() {
            reactions.reachable(world)?
        } else {
            Vec::new()
        };
        let mut classes = Vec::new();
        if !self.rules.is_empty() || world.pairs.has_rules() {
            classes = sort_into_classes(world, &reachable);
            self.look_up(&classes)?;
            reactions.refuse_changed_pairs(&world.pairs, &classes)?;
            world.pairs.look_up(&classes, &world.bodies)?;
            world.pairs.look_up_wells(&classes, &world.bodies)?;
        }
        let rough = self.mark_rough(world, response, reactions.is_active());
        reactions.set_classes(&classes, rough);
        world.has_reactions = reactions.is_active();
        world.keep_last_contacts(self.is_guarded(world));
        world.has_thermal_walls = world
            .bodies
            .iter()
            .any(|body| body.kind.temperature.is_some());
        world.has_special_contacts = world.has_thermal_walls || world.has_reactions;
        Ok(())
    }

    /// Whether the table or a bond has elasticities below 1, which a guard raises. A guarded
    /// contact has elasticity 1, which a response cannot distinguish from elasticity 1 in the
    /// table.
    fn is_guarded(&self, world: &World) -> bool {
        let loses = |bond: &Bond| bond.elasticity.coefficient() < 1.0;
        (self.loses_energy() || world.bonds().iter().any(loses)) && self.guard.contact_time > 0.0
    }

    /// Whether the table has elasticities below 1.
    pub(crate) fn loses_energy(&self) -> bool {
        let loses = |rule: &Rule| rule.spec.coefficient.bounds()[0] < 1.0;
        self.default.coefficient() < 1.0 || self.rules.iter().any(loses)
    }

    /// The rules as in a scene.
    pub(crate) fn spec(&self) -> ElasticitySpec {
        ElasticitySpec {
            pair: self.rules.iter().map(|rule| rule.spec.clone()).collect(),
            ..self.spec.clone()
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
        let default = self.of_default();
        if by_class.iter().any(|pair| *pair != default) {
            self.by_class = by_class;
        }
        Ok(())
    }

    fn of_default(&self) -> PairElasticity {
        PairElasticity {
            elasticity: self.default,
            by_speed: None,
        }
    }

    /// Marks the bodies that have rough contacts with an existing body, or with one that reactions
    /// may give. Returns whether bodies of each class have, and bodies without a class.
    fn mark_rough<R: Response>(
        &self,
        world: &mut World,
        response: &R,
        may_react: bool,
    ) -> (Vec<bool>, bool) {
        let is_rough = |pair: &PairElasticity| response.is_rough(pair.elasticity);
        let by_default = is_rough(&self.of_default());
        let rough: Vec<bool> = if self.by_class.is_empty() {
            Vec::new()
        } else {
            let rows = self.by_class.chunks(self.classes);
            rows.map(|row| row.iter().any(is_rough)).collect()
        };
        let of_kind = |kind: &BodyKind| {
            let of_class = rough.get(kind.tag_class as usize);
            of_class.copied().unwrap_or(by_default)
        };
        world.has_rough_contacts = by_default
            || self
                .rules
                .iter()
                .any(|rule| response.is_rough(rule.elasticity));
        if world
            .bodies
            .iter()
            .any(|body| body.kind.has_rough_contacts != of_kind(&body.kind))
        {
            replace_kinds(world, |kind| BodyKind {
                has_rough_contacts: of_kind(kind),
                ..kind.clone()
            });
        }
        // By the rules alone, as in a run that is resumed, whose bodies have other tags.
        let may_become_rough = may_react && world.has_rough_contacts;
        world.keeps_spins = world
            .bodies
            .iter()
            .zip(&world.motions)
            .any(|(body, motion)| {
                // Locked discs too: they can be unlocked within a run.
                let is_disc = !body.is_fixed() && body.kind.molecule.is_disc();
                let is_rough = body.kind.has_rough_contacts || may_become_rough;
                is_disc && (is_rough || motion.angular_velocity != 0.0)
            })
            || world.ties_discs_beside_their_centres();
        (rough, by_default)
    }

    fn resolve(&self, a: &Tags, b: &Tags) -> Result<PairElasticity, SceneError> {
        for rank in [2, 1] {
            let mut found: Option<(u32, &Rule)> = None;
            for (index, rule) in (0..)
                .zip(&self.rules)
                .filter(|(_, rule)| rule.tags.len() == rank && rule.applies(a, b))
            {
                match found {
                    Some((_, first)) if !first.agrees_with(rule) => {
                        return Err(SceneError::AmbiguousElasticity {
                            first: first.spec.between.clone(),
                            second: rule.spec.between.clone(),
                            one: first.spec.coefficients(),
                            other: rule.spec.coefficients(),
                        });
                    }
                    _ => found = Some((index, rule)),
                }
            }
            if let Some((index, rule)) = found {
                let by_speed = rule.spec.coefficient.number().is_none();
                return Ok(PairElasticity {
                    elasticity: rule.elasticity,
                    by_speed: by_speed.then_some(index),
                });
            }
        }
        Ok(self.of_default())
    }
}

/// The guard with this duration of a contact (share of the natural time of a pair).
fn guard_of(contact_time: f64) -> Result<Guard, SceneError> {
    let problem = if !(0.0..=1.0).contains(&contact_time) {
        format!("it must be from 0 to 1, but is {contact_time}")
    } else if contact_time > 0.0 && contact_time < MIN_CONTACT {
        format!(
            "it must be 0 (no guard) or at least {MIN_CONTACT:e}, but is {contact_time:e}: turning molecules would \
             bounce by less than the rounding of positions, and sink into each other"
        )
    } else {
        return Ok(Guard { contact_time });
    };
    Err(SceneError::of_entry("elasticity.contact_time", problem))
}

/// The same elasticity, in the one form that all smooth contacts of a coefficient have.
fn simplified(elasticity: Elasticity) -> Elasticity {
    if elasticity.is_smooth() {
        Elasticity::new(elasticity.coefficient()).unwrap_or(elasticity)
    } else {
        elasticity
    }
}

/// For each gas of a scene, whether its molecules have rough contacts with any body of the scene.
///
/// # Errors
/// Those of [`ElasticityTable::new`], and rules that disagree.
pub(crate) fn rough_gases(scene: &Scene) -> Result<Vec<bool>, SceneError> {
    if !scene.elasticity.is_rough() {
        return Ok(vec![false; scene.gas.len()]);
    }
    let mut names = TagNames::default();
    let table = ElasticityTable::new(&scene.elasticity, &mut names)?;
    let mut tags = |requested: &[String]| names.intern_all(requested);
    let gases: Vec<Tags> = scene.gas.iter().map(|gas| tags(&gas.tags)).collect();
    let singles = scene.molecule.iter().map(|spec| &spec.tags);
    let singles = singles.chain(scene.bumper.iter().map(|spec| &spec.tags));
    let singles = singles.chain(scene.wall_tags());
    let mut others: Vec<Tags> = singles.map(|requested| tags(requested)).collect();
    let present = scene.gas.iter().zip(&gases);
    others.extend(
        present
            .filter(|(gas, _)| gas.count != Some(0))
            .map(|(_, tags)| tags.clone()),
    );
    let is_rough = |one: &Tags| {
        for other in &others {
            if !table.resolve(one, other)?.elasticity.is_smooth() {
                return Ok(true);
            }
        }
        Ok(false)
    };
    gases.iter().map(is_rough).collect()
}

impl Rule {
    /// The rule at this index of a scene.
    fn new(index: usize, rule: &ElasticityRule, names: &mut TagNames) -> Result<Self, SceneError> {
        let entry = format!("elasticity.pair[{index}]");
        if !(1..=2).contains(&rule.between.len()) {
            let problem = format!(
                "`between` must name one or two tags, but is {:?}",
                rule.between
            );
            return Err(SceneError::Entry { entry, problem });
        }
        if let Err(problem) = rule.coefficient.check() {
            return Err(SceneError::Entry { entry, problem });
        }
        let elasticity = rule
            .elasticity()
            .map_err(|reason| SceneError::Elasticity { entry, reason })?;
        Ok(Self {
            tags: rule.between.iter().map(|name| names.intern(name)).collect(),
            spec: rule.clone(),
            elasticity: simplified(elasticity),
        })
    }

    /// Whether two rules have the same effect.
    fn agrees_with(&self, other: &Self) -> bool {
        self.elasticity == other.elasticity && self.spec.coefficient == other.spec.coefficient
    }

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
        scene::{BumperSpec, Scene, elasticity_spec::Restitution},
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
            coefficient: Restitution::Number(coefficient),
            ..ElasticityRule::default()
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
            coefficient: 0.5.into(),
            ..ElasticityRule::default()
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
