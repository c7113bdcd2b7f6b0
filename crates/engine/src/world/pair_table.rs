//! Which pairs of bodies see each other, by which factor the contact distance of two discs differs
//! from the sum of their radii, and which discs have wells.

use carom_geometry::{Molecule, gap_between};
use glam::DVec2;

use crate::{
    scene::{
        error::SceneError,
        pair_spec::{DiameterSpec, MAX_FACTOR, MIN_FACTOR, TransparentSpec},
        well_spec::WellSpec,
    },
    world::{
        body::Body,
        index_or_none::IndexOrNone,
        tags::{Tag, TagNames, Tags},
    },
};

/// The factor of two bodies that do not see each other.
const UNSEEN: f64 = 0.0;

/// The rules of a scene for pairs of tags. Every pair of bodies has a factor: 0 if the two do not
/// see each other, else that on the sum of the radii of two discs at their contact, which is 1
/// unless a rule of diameters applies.
#[derive(Debug, Clone, Default)]
pub(crate) struct PairTable {
    transparent: Vec<TransparentSpec>,
    diameter: Vec<DiameterSpec>,
    /// The rules of `transparent`, then those of `diameter`.
    rules: Vec<Rule>,
    /// Number of different sets of tags; bodies with equal tags are of one class.
    classes: usize,
    /// The factor for each pair of classes; empty if it is 1 for all.
    by_class: Vec<f64>,
    wells: Vec<WellSpec>,
    /// The tags of each well.
    tags_of_wells: Vec<[Tag; 2]>,
    /// The well for each pair of classes; empty if there is none.
    well_by_class: Vec<IndexOrNone>,
    /// The factor for each pair of classes at which two bodies outside their well meet: with its
    /// range. Empty if there are no wells.
    range_by_class: Vec<f64>,
}

#[derive(Debug, Clone)]
struct Rule {
    tags: [Tag; 2],
    factor: f64,
}

impl Rule {
    fn applies(&self, a: &Tags, b: &Tags) -> bool {
        are_between(self.tags, a, b)
    }
}

/// Whether one of two bodies carries the one tag, and the other body the other.
fn are_between([one, other]: [Tag; 2], a: &Tags, b: &Tags) -> bool {
    (a.contains(&one) && b.contains(&other)) || (a.contains(&other) && b.contains(&one))
}

impl PairTable {
    /// The table of these rules, for no bodies yet.
    ///
    /// # Errors
    /// A rule names no tag or more than two, or its factor is out of range.
    pub(crate) fn new(
        transparent: &[TransparentSpec],
        diameter: &[DiameterSpec],
        wells: &[WellSpec],
        names: &mut TagNames,
    ) -> Result<Self, SceneError> {
        let mut rules = Vec::new();
        for (index, rule) in transparent.iter().enumerate() {
            let tags = tags(&format!("transparent[{index}]"), &rule.between, names)?;
            rules.push(Rule {
                tags,
                factor: UNSEEN,
            });
        }
        for (index, rule) in diameter.iter().enumerate() {
            let entry = format!("diameter[{index}]");
            let tags = tags(&entry, &rule.between, names)?;
            if !(MIN_FACTOR..=MAX_FACTOR).contains(&rule.factor) {
                let problem = format!(
                    "`factor` must be from {MIN_FACTOR} to {MAX_FACTOR}, but is {}; discs that pass through each other \
                     are `[[transparent]]`",
                    rule.factor
                );
                return Err(SceneError::Entry { entry, problem });
            }
            rules.push(Rule {
                tags,
                factor: rule.factor,
            });
        }
        let mut tags_of_wells = Vec::new();
        for (index, well) in wells.iter().enumerate() {
            let entry = format!("well[{index}]");
            tags_of_wells.push(tags(&entry, &well.between, names)?);
            well.check()
                .map_err(|problem| SceneError::of_entry(&entry, problem))?;
        }
        Ok(Self {
            transparent: transparent.to_vec(),
            diameter: diameter.to_vec(),
            rules,
            wells: wells.to_vec(),
            tags_of_wells,
            ..Self::default()
        })
    }

    /// The rules as in a scene.
    pub(crate) fn specs(&self) -> (&[TransparentSpec], &[DiameterSpec], &[WellSpec]) {
        (&self.transparent, &self.diameter, &self.wells)
    }

    /// Whether there are rules, which may affect no body.
    pub(crate) fn has_rules(&self) -> bool {
        !self.rules.is_empty() || !self.wells.is_empty()
    }

    /// Whether there are rules of diameters, which may affect no body.
    pub(crate) fn has_diameters(&self) -> bool {
        !self.diameter.is_empty()
    }

    /// Whether discs may meet at another distance than the sum of their radii.
    pub(crate) fn changes_distances(&self) -> bool {
        self.has_diameters() || self.has_wells()
    }

    /// Whether a rule affects bodies of the world.
    #[inline]
    pub(crate) fn is_active(&self) -> bool {
        !self.by_class.is_empty() || self.has_wells()
    }

    /// Whether bodies of the world have wells: those of a world that is not yet complete have not.
    #[inline]
    pub(crate) fn has_wells(&self) -> bool {
        !self.well_by_class.is_empty()
    }

    /// An upper bound on the factors of all pairs, at least 1, with the ranges of wells.
    pub(crate) fn largest_factor(&self) -> f64 {
        let largest = self.rules.iter().map(|rule| rule.factor);
        largest.fold(1.0, f64::max) * self.largest_range()
    }

    /// The largest range of a well, in distances at contact; 1 without wells.
    fn largest_range(&self) -> f64 {
        if !self.has_wells() {
            return 1.0;
        }
        let ranges = self.wells.iter().map(|well| outermost(&well.steps)[0]);
        ranges.fold(1.0, f64::max)
    }

    /// The largest energy of a step of a well (mass × length² / time²), by magnitude; 0 without
    /// wells.
    pub(crate) fn largest_step(&self) -> f64 {
        let steps = |well: &WellSpec| {
            let outside = std::iter::once(0.0);
            let energies: Vec<f64> = well
                .steps
                .iter()
                .map(|step| step[1])
                .chain(outside)
                .collect();
            let step = |pair: &[f64]| (pair[1] - pair[0]).abs();
            energies.windows(2).map(step).fold(0.0, f64::max)
        };
        self.wells.iter().map(steps).fold(0.0, f64::max)
    }

    /// The steps of the well of two bodies, each a range in distances at contact and an energy
    /// (mass × length² / time²), from the inside outwards; none without a well.
    #[inline]
    pub(crate) fn steps(&self, a: &Body, b: &Body) -> Option<&[[f64; 2]]> {
        if self.well_by_class.is_empty() {
            return None;
        }
        let place = a.kind.tag_class as usize * self.classes + b.kind.tag_class as usize;
        let well = self.well_by_class[place].get()?;
        Some(&self.wells[well].steps)
    }

    /// The number of the well of two bodies with these tags that see each other.
    fn well_of_tags(&self, a: &Tags, b: &Tags) -> Option<usize> {
        let applies = |tags: &[Tag; 2]| are_between(*tags, a, b);
        let well = self.tags_of_wells.iter().position(applies)?;
        self.sees(a, b).then_some(well)
    }

    /// Whether bodies with the tags of `a` meet those of `other` as bodies with the tags of `b` do.
    pub(crate) fn are_alike(&self, a: &Tags, b: &Tags, other: &Tags) -> bool {
        let steps = |tags| Some(&self.wells[self.well_of_tags(tags, other)?].steps);
        self.factor_of_tags(a, other) == self.factor_of_tags(b, other) && steps(a) == steps(b)
    }

    /// The factor of two bodies, which must have been sorted into classes
    /// ([`crate::world::tag_classes`]).
    #[inline]
    pub(crate) fn factor(&self, a: &Body, b: &Body) -> f64 {
        if self.by_class.is_empty() {
            return 1.0;
        }
        self.by_class[a.kind.tag_class as usize * self.classes + b.kind.tag_class as usize]
    }

    /// Number of classes of bodies.
    pub(crate) fn classes(&self) -> usize {
        self.classes
    }

    /// The factor at which bodies of two classes meet outside their well, with its range.
    #[inline]
    pub(crate) fn factor_outside_well(&self, one: usize, other: usize) -> f64 {
        let by_class = if self.has_wells() {
            &self.range_by_class
        } else {
            &self.by_class
        };
        let factor = by_class.get(one * self.classes + other);
        factor.copied().unwrap_or(1.0)
    }

    /// The factor of two bodies with these tags.
    pub(crate) fn factor_of_tags(&self, a: &Tags, b: &Tags) -> f64 {
        let rule = self.rules.iter().find(|rule| rule.applies(a, b));
        rule.map_or(1.0, |rule| rule.factor)
    }

    /// Whether bodies with these tags see each other.
    pub(crate) fn sees(&self, a: &Tags, b: &Tags) -> bool {
        self.factor_of_tags(a, b) != UNSEEN
    }

    /// Finds the factor of each pair of classes once. `classes` has a body of each class.
    ///
    /// # Errors
    /// Two rules of diameters disagree, or one affects a body that is no disc.
    pub(crate) fn look_up(&mut self, classes: &[Tags], bodies: &[Body]) -> Result<(), SceneError> {
        self.classes = classes.len();
        let pairs = || {
            classes
                .iter()
                .flat_map(|a| classes.iter().map(move |b| (a, b)))
        };
        self.refuse_ambiguous(pairs())?;
        self.refuse_molecules(bodies)?;
        let factors: Vec<f64> = pairs().map(|(a, b)| self.factor_of_tags(a, b)).collect();
        // Rules that affect no existing body have no cost.
        self.by_class = if factors.iter().any(|&factor| factor != 1.0) {
            factors
        } else {
            Vec::new()
        };
        Ok(())
    }

    /// Finds the well of each pair of classes once, after [`Self::look_up`].
    ///
    /// # Errors
    /// Two wells apply to a pair, or one to a body that is no disc.
    pub(crate) fn look_up_wells(
        &mut self,
        classes: &[Tags],
        bodies: &[Body],
    ) -> Result<(), SceneError> {
        for (index, (tags, well)) in self.tags_of_wells.iter().zip(&self.wells).enumerate() {
            refuse_molecules(
                &format!("well[{index}]"),
                "a well",
                (*tags, &well.between),
                bodies,
            )?;
        }
        let pairs = classes
            .iter()
            .flat_map(|a| classes.iter().map(move |b| (a, b)));
        let mut by_class = Vec::with_capacity(classes.len() * classes.len());
        for (a, b) in pairs {
            let well = self.well_of_tags(a, b);
            if let Some(first) = well
                && let Some(second) = (first + 1..self.wells.len()).find(|&second| {
                    are_between(self.tags_of_wells[second], a, b)
                        && self.wells[second].steps != self.wells[first].steps
                })
            {
                return Err(SceneError::of_entry(
                    &format!("well[{second}]"),
                    format!(
                        "it applies to the same bodies as well[{first}] with other `steps`; make them equal or \
                         remove one"
                    ),
                ));
            }
            by_class.push(well.map_or(IndexOrNone::NONE, IndexOrNone::new));
        }
        let has_wells = by_class.iter().any(|well| well.get().is_some());
        self.well_by_class = if has_wells { by_class } else { Vec::new() };
        self.range_by_class = (0..self.well_by_class.len())
            .map(|place| {
                let factor = self.by_class.get(place).copied().unwrap_or(1.0);
                let well = self.well_by_class[place].get();
                well.map_or(factor, |well| {
                    factor * outermost(&self.wells[well].steps)[0]
                })
            })
            .collect();
        Ok(())
    }

    fn refuse_ambiguous<'a>(
        &self,
        mut pairs: impl Iterator<Item = (&'a Tags, &'a Tags)>,
    ) -> Result<(), SceneError> {
        let diameters = &self.rules[self.transparent.len()..];
        pairs.try_for_each(|(a, b)| {
            let mut applying = (0..diameters.len()).filter(|&rule| diameters[rule].applies(a, b));
            let Some(first) = applying.next().filter(|_| self.sees(a, b)) else {
                return Ok(());
            };
            match applying.find(|&rule| diameters[rule].factor != diameters[first].factor) {
                None => Ok(()),
                Some(second) => Err(SceneError::Entry {
                    entry: format!("diameter[{second}]"),
                    problem: format!(
                        "it applies to the same bodies as diameter[{first}] with another `factor`, {} instead of {}; \
                         make them equal or remove one",
                        diameters[second].factor, diameters[first].factor
                    ),
                }),
            }
        })
    }

    fn refuse_molecules(&self, bodies: &[Body]) -> Result<(), SceneError> {
        let diameters = self.rules[self.transparent.len()..].iter();
        for (index, (rule, spec)) in diameters.zip(&self.diameter).enumerate() {
            let entry = format!("diameter[{index}]");
            let between = (rule.tags, &spec.between[..]);
            refuse_molecules(&entry, "a factor on diameters", between, bodies)?;
        }
        Ok(())
    }
}

/// The last step of a list that is not empty.
fn outermost(steps: &[[f64; 2]]) -> [f64; 2] {
    steps.last().copied().unwrap_or([1.0, 0.0])
}

/// Refuses a rule for discs whose tags another body carries; `what` names the rule.
fn refuse_molecules(
    entry: &str,
    what: &str,
    (tags, between): ([Tag; 2], &[String]),
    bodies: &[Body],
) -> Result<(), SceneError> {
    let is_refused =
        |body: &&Body| !body.kind.molecule.is_disc() && tags.iter().any(|tag| body.has_tag(*tag));
    let Some(body) = bodies.iter().find(is_refused) else {
        return Ok(());
    };
    let other = if body.is_wall() {
        "a wall"
    } else {
        "a molecule"
    };
    let problem = format!(
        "{what} applies to discs alone, but {other} carries one of the tags {between:?}: give the discs a tag of \
         their own"
    );
    Err(SceneError::of_entry(entry, problem))
}

fn tags(entry: &str, between: &[String], names: &mut TagNames) -> Result<[Tag; 2], SceneError> {
    match between {
        [one] => Ok([names.intern(one); 2]),
        [one, other] => Ok([names.intern(one), names.intern(other)]),
        _ => Err(SceneError::Entry {
            entry: entry.to_owned(),
            problem: format!("`between` must name one or two tags, but is {between:?}"),
        }),
    }
}

/// The gap between two bodies with this factor, not 0 (length, negative for an overlap).
pub(crate) fn gap_with_factor(
    factor: f64,
    [a, b]: [&Molecule; 2],
    [turned_a, turned_b]: [DVec2; 2],
    separation: DVec2,
) -> f64 {
    if factor == 1.0 {
        return gap_between(a, turned_a, b, turned_b, separation);
    }
    separation.length() - factor * (a.bounding_radius() + b.bounding_radius())
}
