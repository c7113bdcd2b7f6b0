//! The distances at which discs of each class of tags meet those of every other class.
//!
//! A search in lanes takes one contact distance for eight discs, or the sums of their radii, so the
//! discs around one are sorted by the distance at which it meets them. If a factor on the distance
//! applies to a class without a single radius, the pairs are searched one by one.

use smallvec::SmallVec;

use super::{cell_grid::CellGrid, simd::PairConstants};
use crate::world::{World, body::Body};

/// The rules of more classes of tags than this are looked up pair by pair. Larger: the tables, of
/// all pairs of classes, take more time in each epoch.
const MAX_CLASSES: usize = 16;

/// The class of the dummy, which no disc meets.
const DUMMY_CLASS: u8 = 31;

/// The classes of all bodies, and the distances at which their discs meet; empty where no rule for
/// pairs affects a body.
#[derive(Debug, Clone, Default)]
pub(super) struct PairClasses {
    /// By body, the dummy last.
    of_bodies: Vec<u8>,
    /// By class; `None` if the discs of a class meet others at several distances.
    groups: Vec<Option<DistanceGroups>>,
}

/// The classes that the discs of one class meet, by the contact distance.
pub(super) type DistanceGroups = SmallVec<[DistanceGroup; 2]>;

/// Classes of discs that are met at one distance, or at the sums of the radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DistanceGroup {
    /// The classes, a bit each.
    classes: u32,
    /// The distance; `None` for sums of radii.
    pub pair_constants: Option<PairConstants>,
}

impl DistanceGroup {
    /// Whether discs of a class are among them.
    #[inline(always)]
    pub fn has(&self, class: u8) -> bool {
        self.classes >> class & 1 != 0
    }
}

impl PairClasses {
    /// Reads the classes and distances of the bodies in cells; `separation_error` bounds the
    /// rounding of a separation (length).
    pub fn lay_out(&mut self, world: &World, grid: &CellGrid, separation_error: f64) {
        self.of_bodies.clear();
        self.groups.clear();
        let classes = world.pairs.classes();
        if !grid.is_by_pair() || classes > MAX_CLASSES {
            return;
        }
        self.of_bodies.reserve_exact(world.bodies().len() + 1);
        let class = |body: &Body| body.kind.tag_class as u8;
        self.of_bodies.extend(world.bodies().iter().map(class));
        self.of_bodies.push(DUMMY_CLASS);
        let radii = radii_by_class(world, grid, classes);
        let common = match radii.iter().copied().fold(Radii::None, Radii::or) {
            Radii::All(radius) => Some(radius),
            Radii::None | Radii::Several => None,
        };
        let groups = |of: usize| {
            let mut groups = DistanceGroups::new();
            for (other, radius) in radii.iter().enumerate() {
                let factor = world.pairs.factor_outside_well(of, other);
                if factor == 0.0 || *radius == Radii::None {
                    continue;
                }
                let pair_constants = match (radii[of], *radius) {
                    // One group for all sums of radii: each takes a look at the whole list.
                    _ if factor == 1.0 => {
                        common.map(|radius| PairConstants::new(radius, separation_error))
                    }
                    (Radii::All(one), Radii::All(other)) => {
                        Some(PairConstants::at((one + other) * factor, separation_error))
                    }
                    _ => return None,
                };
                let is_same = |group: &&mut DistanceGroup| group.pair_constants == pair_constants;
                let classes = 1 << other;
                match groups.iter_mut().find(is_same) {
                    Some(group) => group.classes |= classes,
                    None => groups.push(DistanceGroup {
                        classes,
                        pair_constants,
                    }),
                }
            }
            Some(groups)
        };
        self.groups.extend((0..classes).map(groups));
    }

    /// Reads those of some bodies (indices among all) from those of all: a workspace numbers its
    /// bodies in this order.
    pub fn take_part(&mut self, all: &Self, bodies: impl Iterator<Item = u32>) {
        self.of_bodies.clear();
        self.groups.clone_from(&all.groups);
        if !all.of_bodies.is_empty() {
            self.of_bodies.extend(bodies.map(|body| all.class_of(body)));
            self.of_bodies.push(DUMMY_CLASS);
        }
    }

    /// The distances at which a disc meets others, if there are few.
    #[inline]
    pub fn groups_of(&self, disc: u32) -> Option<&DistanceGroups> {
        let &class = self.of_bodies.get(disc as usize)?;
        self.groups[class as usize].as_ref()
    }

    /// The class of a body, or of the dummy.
    #[inline(always)]
    pub fn class_of(&self, body: u32) -> u8 {
        self.of_bodies[body as usize]
    }

    /// Reads the class of a body whose tags have changed.
    pub fn update_class(&mut self, world: &World, body: u32) {
        if let Some(class) = self.of_bodies.get_mut(body as usize) {
            *class = world.bodies()[body as usize].kind.tag_class as u8;
        }
    }

    pub fn heap_bytes(&self) -> usize {
        self.of_bodies.capacity() + self.groups.capacity() * size_of::<Option<DistanceGroups>>()
    }
}

/// The radii of the discs of a class that live in cells.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Radii {
    None,
    /// All have this one (length).
    All(f64),
    Several,
}

/// The radii of the discs of each class. A reaction may give any disc any class: then every class
/// has those of all discs.
fn radii_by_class(world: &World, grid: &CellGrid, classes: usize) -> Vec<Radii> {
    let mut radii = vec![Radii::None; classes];
    let in_cells = world.bodies().iter();
    for body in in_cells.filter(|body| !grid.is_multi_cell(body)) {
        let class = body.kind.tag_class as usize;
        radii[class] = radii[class].or(Radii::All(body.molecule().bounding_radius()));
    }
    if world.has_reactions {
        let of_all = radii.iter().copied().fold(Radii::None, Radii::or);
        radii.fill(of_all);
    }
    radii
}

impl Radii {
    /// Those of two sets of discs together.
    fn or(self, other: Self) -> Self {
        match (self, other) {
            (Self::None, radii) | (radii, Self::None) => radii,
            (Self::All(one), Self::All(other)) if one == other => self,
            _ => Self::Several,
        }
    }
}
