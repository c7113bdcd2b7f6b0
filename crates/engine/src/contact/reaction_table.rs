//! The reactions in force: which rule acts at a contact, and which tags bodies may get by them.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    sync::Arc,
};

use carom_geometry::MAX_MAGNITUDE;
use glam::DVec2;

use crate::{
    contact::philox::{open_unit, philox},
    scene::{
        MoleculeSpec,
        error::SceneError,
        reaction_spec::{NOTHING, ReactionSpec},
    },
    world::{
        World,
        body::{Body, BodyKey, BodyKind},
        pair_table::PairTable,
        reaction_record::{ReactionCounts, ReactionRecord},
        tags::{Tag, TagNames, Tags},
    },
};

/// Largest number of sets of tags that bodies may get. Larger: tables by pairs of sets take more
/// memory.
const MAX_SETS: usize = 1024;

/// Largest relative difference of the masses of a product and of the two bodies that it replaces:
/// each is rounded a few times.
const SAME_MASS: f64 = 1e-12;

/// Marks the random numbers of reactions among those of the same key: thermostats use 0 and 1.
const STREAM: u64 = 2;

/// What becomes of one of two bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ReactantFate {
    /// It gets this tag in place of that of the rule.
    Tag(Tag),
    /// It is removed.
    Nothing,
}

/// What becomes of both bodies.
#[derive(Debug, Clone)]
pub(crate) enum ReactionOutcome {
    Each([ReactantFate; 2]),
    /// One molecule replaces both.
    Product(Arc<Product>),
}

/// The molecule that replaces two bodies.
#[derive(Debug)]
pub(crate) struct Product {
    pub spec: MoleculeSpec,
    pub mass: f64,
    tags: Tags,
}

#[derive(Debug, Clone)]
struct Rule {
    tags: [Tag; 2],
    probability: f64,
    least_energy: f64,
    outcome: ReactionOutcome,
    /// The place of its record.
    record: usize,
}

/// A reaction that takes place at a contact: the bodies are in the order of the rule's tags.
#[derive(Debug, Clone)]
pub(crate) struct Reaction {
    pub bodies: [u32; 2],
    pub tags: [Tag; 2],
    pub outcome: ReactionOutcome,
    pub record: usize,
}

/// A reaction that has been decided at the last contact, and ends the epoch.
#[derive(Debug, Clone)]
pub(crate) struct PendingReaction {
    /// In the order of the rule's tags.
    pub bodies: [BodyKey; 2],
    pub tags: [Tag; 2],
    pub outcome: ReactionOutcome,
    pub record: usize,
    /// From the centre of the first body to that of the second (length).
    pub separation: DVec2,
}

impl PendingReaction {
    /// A reaction of bodies whose centres are apart by `separation` (length).
    pub(crate) fn new(reaction: Reaction, bodies: &[Body], separation: DVec2) -> Self {
        Self {
            bodies: reaction.bodies.map(|body| bodies[body as usize].key()),
            tags: reaction.tags,
            outcome: reaction.outcome,
            record: reaction.record,
            separation,
        }
    }
}

/// The reactions in force, and the records of all that have been.
#[derive(Debug, Clone, Default)]
pub(crate) struct ReactionTable {
    rules: Vec<Rule>,
    pub records: Vec<ReactionRecord>,
    /// The class of each set of tags; empty if bodies have no classes.
    classes: BTreeMap<Tags, u32>,
    /// Whether bodies of each class have rough contacts, and bodies without a class.
    rough: (Vec<bool>, bool),
    /// Descriptions with replaced tags, so that bodies of one kind continue to share one. The key
    /// is the address of the old description, which is kept alive.
    relabelled: HashMap<(usize, Tag, Tag), [Arc<BodyKind>; 2]>,
    /// The reaction of the last contact, if it is to be carried out before the next epoch.
    pub pending: Option<PendingReaction>,
}

impl ReactionTable {
    /// Puts these rules in force in place of the present ones; `entry` names the list in errors.
    /// The records of rules that are equal to earlier ones are continued.
    ///
    /// # Errors
    /// A rule names no tag or more than two, a number is out of range, or its outcome is not
    /// clear; then nothing changes, but `names` may have more tags.
    pub(crate) fn set(
        &mut self,
        entry: &str,
        specs: &[ReactionSpec],
        names: &mut TagNames,
    ) -> Result<(), SceneError> {
        let mut records = self.records.clone();
        for record in &mut records {
            record.is_in_force = false;
        }
        let mut rules = Vec::with_capacity(specs.len());
        for (index, spec) in specs.iter().enumerate() {
            let (tags, outcome) = spec.check(&format!("{entry}[{index}]"), names)?;
            let same = records.iter().position(|record| record.spec == *spec);
            let record = same.unwrap_or(records.len());
            if same.is_none() {
                records.push(ReactionRecord {
                    spec: spec.clone(),
                    is_in_force: true,
                    counts: ReactionCounts::default(),
                });
            }
            records[record].is_in_force = true;
            rules.push(Rule {
                tags,
                probability: spec.probability,
                least_energy: spec.least_energy,
                outcome,
                record,
            });
        }
        (self.rules, self.records) = (rules, records);
        self.forget_classes();
        Ok(())
    }

    /// Whether a rule is in force.
    pub(crate) fn is_active(&self) -> bool {
        !self.rules.is_empty()
    }

    /// The places of the records of the rules in force, in the order of the rules.
    pub(crate) fn in_force(&self) -> impl Iterator<Item = usize> {
        self.rules.iter().map(|rule| rule.record)
    }

    /// Decides whether two bodies react at a contact. `energy` is that of their approach
    /// (mass × length² / time²); `number` is that of contacts at which a reaction was possible
    /// before this one, and is raised by such a contact.
    ///
    /// The random numbers depend on the key, on this number and on the place of the rule alone:
    /// contacts take place in order of time, so that all schedulers draw the same numbers, and a
    /// run that is resumed draws those of a run in one piece.
    pub(crate) fn decide(
        &mut self,
        [a, b]: [&Body; 2],
        indices: [u32; 2],
        energy: impl Fn() -> f64,
        key: [u64; 2],
        number: &mut u64,
    ) -> Option<Reaction> {
        let mut draws = None;
        for (place, rule) in (0..).zip(&self.rules) {
            let [one, other] = rule.tags;
            let bodies = if a.has_tag(one) && b.has_tag(other) {
                indices
            } else if a.has_tag(other) && b.has_tag(one) {
                [indices[1], indices[0]]
            } else {
                continue;
            };
            let draw = *draws.get_or_insert_with(|| {
                *number += 1;
                *number - 1
            });
            let counts = &mut self.records[rule.record].counts;
            counts.contacts += 1;
            let has_energy = rule.least_energy == 0.0 || energy() >= rule.least_energy;
            let takes_place = has_energy
                && (rule.probability >= 1.0
                    || open_unit(philox(key, [draw, place, STREAM, 0])[0]) < rule.probability);
            if takes_place {
                return Some(Reaction {
                    bodies,
                    tags: rule.tags,
                    outcome: rule.outcome.clone(),
                    record: rule.record,
                });
            }
        }
        None
    }

    /// Replaces a tag of a body, in O(1) time on average.
    pub(crate) fn relabel(&mut self, kind: &mut Arc<BodyKind>, from: Tag, to: Tag) {
        if from == to {
            return;
        }
        let key = (Arc::as_ptr(kind).addr(), from, to);
        if let Some([_, after]) = self.relabelled.get(&key) {
            *kind = Arc::clone(after);
            return;
        }
        let tags = replaced(&kind.tags, from, to);
        let tag_class = self.classes.get(&tags).copied().unwrap_or(0);
        let (rough, by_default) = &self.rough;
        let of_class = rough.get(tag_class as usize).copied();
        let after = BodyKind {
            tags,
            tag_class,
            has_rough_contacts: of_class.unwrap_or(*by_default),
            ..BodyKind::clone(kind)
        };
        // A body that gets an earlier tag back gets the earlier description, so that their number
        // is that of the sets of tags, not of the reactions.
        let mut known = self.relabelled.values().flatten();
        let known = known.find(|known| known.is_like(&after)).cloned();
        let after = known.unwrap_or_else(|| Arc::new(after));
        self.relabelled
            .insert(key, [Arc::clone(kind), Arc::clone(&after)]);
        *kind = after;
    }

    /// All sets of tags that bodies have or may get, without classes yet.
    ///
    /// # Errors
    /// A rule in force cannot act on the bodies that it names: it would remove a wall, replace a
    /// fixed body or a piston, or not keep the mass. Or there are too many sets of tags.
    pub(crate) fn reachable(&self, world: &World) -> Result<Vec<Tags>, SceneError> {
        let groups = self.groups(world)?;
        for rule in &self.rules {
            self.check_removal(rule, &groups)?;
            self.check_product(rule, &groups)?;
        }
        let sets: BTreeSet<Tags> = groups.into_keys().map(|group| group.tags).collect();
        Ok(sets.into_iter().collect())
    }

    /// Refuses a change of tags that changes at which distance bodies see each other.
    ///
    /// # Errors
    /// A rule changes a factor of the pairs between these sets of tags.
    pub(crate) fn refuse_changed_pairs(
        &self,
        pairs: &PairTable,
        sets: &[Tags],
    ) -> Result<(), SceneError> {
        if !pairs.has_rules() {
            return Ok(());
        }
        for rule in &self.rules {
            let ReactionOutcome::Each(fates) = rule.outcome else {
                continue;
            };
            for (from, fate) in rule.tags.into_iter().zip(fates) {
                let ReactantFate::Tag(to) = fate else {
                    continue;
                };
                let changes = |before: &Tags| {
                    let after = replaced(before, from, to);
                    let differs = |other: &Tags| !pairs.are_alike(before, &after, other);
                    sets.iter().any(differs)
                };
                if sets.iter().any(|set| set.contains(&from) && changes(set)) {
                    return Err(self.refused(
                        rule,
                        "it changes which bodies see each other, or at which distance discs touch or attract each \
                         other: a reaction cannot give a tag that `[[transparent]]`, `[[diameter]]` or `[[well]]` \
                         treats in another way",
                    ));
                }
            }
        }
        Ok(())
    }

    /// Takes over the classes of all sets of tags, and which of them have rough contacts.
    pub(crate) fn set_classes(&mut self, classes: &[Tags], rough: (Vec<bool>, bool)) {
        self.forget_classes();
        self.classes = classes.iter().cloned().zip(0..).collect();
        self.rough = rough;
    }

    fn forget_classes(&mut self) {
        self.classes.clear();
        self.relabelled.clear();
    }

    /// The groups of bodies that are alike to reactions, present ones and those to come.
    fn groups(&self, world: &World) -> Result<BTreeMap<Group, Masses>, SceneError> {
        let mut groups: BTreeMap<Group, Masses> = BTreeMap::new();
        let mut last: Option<&Arc<BodyKind>> = None;
        for body in &world.bodies {
            if last.is_some_and(|kind| Arc::ptr_eq(kind, &body.kind)) {
                continue;
            }
            last = Some(&body.kind);
            Masses::add(&mut groups, Group::from_body(body), [body.mass(); 2]);
        }
        for rule in &self.rules {
            if let ReactionOutcome::Product(product) = &rule.outcome {
                let group = Group {
                    tags: product.tags.clone(),
                    is_wall: false,
                    is_fixed: false,
                };
                Masses::add(&mut groups, group, [product.mass; 2]);
            }
        }
        loop {
            let mut next = groups.clone();
            for rule in &self.rules {
                let ReactionOutcome::Each(fates) = rule.outcome else {
                    continue;
                };
                for (from, fate) in rule.tags.into_iter().zip(fates) {
                    let ReactantFate::Tag(to) = fate else {
                        continue;
                    };
                    for (group, masses) in &groups {
                        if group.tags.contains(&from) {
                            let tags = replaced(&group.tags, from, to);
                            let after = Group {
                                tags,
                                ..group.clone()
                            };
                            Masses::add(&mut next, after, masses.0);
                        }
                    }
                }
                if next.len() > MAX_SETS {
                    return Err(self.refused(
                        rule,
                        format!(
                            "bodies could get more than {MAX_SETS} different sets of tags by reactions"
                        ),
                    ));
                }
            }
            if next == groups {
                return Ok(groups);
            }
            groups = next;
        }
    }

    fn check_removal(
        &self,
        rule: &Rule,
        groups: &BTreeMap<Group, Masses>,
    ) -> Result<(), SceneError> {
        let ReactionOutcome::Each(fates) = rule.outcome else {
            return Ok(());
        };
        let removed = rule.tags.iter().zip(fates);
        let mut removed = removed.filter(|(_, fate)| *fate == ReactantFate::Nothing);
        let has_wall = |tag: &Tag| {
            let mut walls = groups.keys().filter(|group| group.is_wall);
            walls.any(|group| group.tags.contains(tag))
        };
        if removed.any(|(tag, _)| has_wall(tag)) {
            return Err(self.refused(
                rule,
                "it would remove a wall, which carries a tag of `between`: give the bodies that are removed a tag of \
                 their own",
            ));
        }
        Ok(())
    }

    fn check_product(
        &self,
        rule: &Rule,
        groups: &BTreeMap<Group, Masses>,
    ) -> Result<(), SceneError> {
        let ReactionOutcome::Product(product) = &rule.outcome else {
            return Ok(());
        };
        let mass = product.mass;
        let mut of_pair = [0.0; 2];
        for tag in rule.tags {
            let mut of_tag: Option<Masses> = None;
            for (group, masses) in groups.iter().filter(|(group, _)| group.tags.contains(&tag)) {
                if group.is_fixed || group.is_wall {
                    return Err(self.refused(
                        rule,
                        "a molecule cannot replace a fixed body or a piston, which carries a tag of `between`",
                    ));
                }
                of_tag = Some(of_tag.map_or(*masses, |known| known.with(masses.0)));
            }
            // No body carries the tag yet; the engine checks the mass at each reaction.
            let Some(Masses([least, most])) = of_tag else {
                return Ok(());
            };
            of_pair = [of_pair[0] + least, of_pair[1] + most];
        }
        let wrong = of_pair.iter().find(|pair| !is_same_mass(mass, **pair));
        wrong.map_or(Ok(()), |pair| {
            let problem = format!(
                "the mass of `into` must be that of the two bodies which it replaces, {pair}, but is {mass}"
            );
            Err(self.refused(rule, problem))
        })
    }

    fn refused(&self, rule: &Rule, problem: impl Into<String>) -> SceneError {
        let equation = self.records[rule.record].spec.equation();
        SceneError::Entry {
            entry: format!("reaction {equation}"),
            problem: problem.into(),
        }
    }
}

/// Bodies that are alike to reactions, apart from their masses.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Group {
    tags: Tags,
    is_wall: bool,
    is_fixed: bool,
}

impl Group {
    fn from_body(body: &Body) -> Self {
        Self {
            tags: body.kind.tags.clone(),
            is_wall: body.is_wall(),
            is_fixed: body.is_fixed(),
        }
    }
}

/// The least and the largest mass of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Masses([f64; 2]);

impl Masses {
    fn with(self, [least, most]: [f64; 2]) -> Self {
        Self([self.0[0].min(least), self.0[1].max(most)])
    }

    fn add(groups: &mut BTreeMap<Group, Self>, group: Group, masses: [f64; 2]) {
        let known = groups.entry(group).or_insert(Self(masses));
        *known = known.with(masses);
    }
}

/// Whether a product has the mass of the two bodies that it replaces, to rounding.
pub(crate) fn is_same_mass(product: f64, pair: f64) -> bool {
    (product - pair).abs() <= SAME_MASS * pair
}

/// Tags with one replaced.
fn replaced(tags: &Tags, from: Tag, to: Tag) -> Tags {
    let mut after: Tags = tags.iter().copied().filter(|tag| *tag != from).collect();
    after.push(to);
    after.sort_unstable();
    after.dedup();
    after
}

impl ReactionSpec {
    /// The tags and the outcome of a rule whose keys are in range.
    fn check(
        &self,
        entry: &str,
        names: &mut TagNames,
    ) -> Result<([Tag; 2], ReactionOutcome), SceneError> {
        let refuse = |problem: String| Err(SceneError::of_entry(entry, problem));
        if !(1..=2).contains(&self.between.len()) {
            return refuse(format!(
                "`between` must name one or two tags, but is {:?}",
                self.between
            ));
        }
        if self.between.iter().any(|tag| tag == NOTHING) {
            return refuse(format!(
                "`between` cannot name the tag {NOTHING:?}, which stands for a body that is removed"
            ));
        }
        if !(self.probability > 0.0 && self.probability <= 1.0) {
            return refuse(format!(
                "`probability` must be above 0 and at most 1, but is {}",
                self.probability
            ));
        }
        if !(0.0..=MAX_MAGNITUDE).contains(&self.least_energy) {
            return refuse(format!(
                "`least_energy` must be from 0 to {MAX_MAGNITUDE:e}, but is {:e}",
                self.least_energy
            ));
        }
        let ends = [&self.between[0], &self.between[self.between.len() - 1]];
        let tags = ends.map(|name| names.intern(name));
        match (&self.into, &self.becomes[..]) {
            (None, [one, other]) => {
                let mut fate = |name: &String| match name.as_str() {
                    NOTHING => ReactantFate::Nothing,
                    name => ReactantFate::Tag(names.intern(name)),
                };
                let fates = [fate(one), fate(other)];
                if fates == tags.map(ReactantFate::Tag) {
                    return refuse(format!(
                        "it changes nothing: `becomes` is {:?}, the tags that the bodies have",
                        self.becomes
                    ));
                }
                Ok((tags, ReactionOutcome::Each(fates)))
            }
            (None, becomes) => refuse(format!(
                "give `becomes`, one tag or {NOTHING:?} for each of the two bodies, or `into`, a molecule that replaces \
                 both; `becomes` is {becomes:?}"
            )),
            (Some(_), [_, ..]) => refuse("give `becomes` or `into`, not both".to_owned()),
            (Some(spec), []) => {
                let product = Product::new(&format!("{entry}.into"), spec, names)?;
                Ok((tags, ReactionOutcome::Product(Arc::new(product))))
            }
        }
    }
}

impl Product {
    fn new(entry: &str, spec: &MoleculeSpec, names: &mut TagNames) -> Result<Self, SceneError> {
        let is_placed = spec.at != [0.0; 2] || spec.velocity != [0.0; 2];
        if is_placed || spec.angular_velocity != 0.0 || spec.fixed {
            return Err(SceneError::of_entry(
                entry,
                "it moves on from the centre of mass of the two bodies with their momentum: leave out `at`, `velocity`, \
                 `angular_velocity` and `fixed`",
            ));
        }
        if spec.tags.iter().any(|tag| tag == NOTHING) {
            return Err(SceneError::of_entry(
                entry,
                format!("the tag {NOTHING:?} stands for a body that is removed"),
            ));
        }
        Ok(Self {
            mass: spec.molecule(entry)?.mass(),
            spec: spec.clone(),
            tags: names.intern_all(&spec.tags),
        })
    }
}
