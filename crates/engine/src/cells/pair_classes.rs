//! The distances at which discs of each class of tags meet those of every other class.
//!
//! A search in lanes takes one contact distance for eight discs, so the discs around one are sorted
//! by the distance at which it meets them. Where that cannot be, the pairs are searched one by one.

use smallvec::SmallVec;

use super::{cell_grid::CellGrid, simd::PairConstants};
use crate::world::{World, body::Body};

/// The rules of more classes of tags than this are looked up pair by pair. Larger: the tables, of
/// all pairs of classes, take more time in each epoch.
const MAX_CLASSES: usize = 16;

/// The class of the dummy, which no disc meets.
const OF_DUMMY: u8 = 31;

/// The classes of all bodies, and the distances at which their discs meet; empty where no rule for
/// pairs affects a body.
#[derive(Debug, Clone, Default)]
pub(super) struct PairClasses {
    /// By body, the dummy last.
    of_bodies: Vec<u8>,
    /// By class; `None` if the discs of a class meet others at several distances.
    meetings: Vec<Option<Meetings>>,
}

/// The classes that the discs of one class meet, by the contact distance.
pub(super) type Meetings = SmallVec<[Meeting; 2]>;

/// Classes of discs that are met at one distance, or at the sums of the radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Meeting {
    /// The classes, a bit each.
    classes: u32,
    /// The distance; `None` for sums of radii.
    pub pair_constants: Option<PairConstants>,
}

impl Meeting {
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
        self.meetings.clear();
        let classes = world.pairs.classes();
        if !grid.is_by_pair() || classes > MAX_CLASSES {
            return;
        }
        self.of_bodies.reserve_exact(world.bodies().len() + 1);
        let class = |body: &Body| body.kind.tag_class as u8;
        self.of_bodies.extend(world.bodies().iter().map(class));
        self.of_bodies.push(OF_DUMMY);
        let radii = radii_by_class(world, grid, classes);
        let meetings = |of: usize| {
            let mut meetings = Meetings::new();
            for (other, radius) in radii.iter().enumerate() {
                let factor = world.pairs.factor_outside_well(of, other);
                if factor == 0.0 || *radius == Radii::None {
                    continue;
                }
                let pair_constants = match (radii[of], *radius) {
                    (Radii::All(one), Radii::All(other)) => {
                        Some(PairConstants::at((one + other) * factor, separation_error))
                    }
                    _ if factor == 1.0 => None,
                    _ => return None,
                };
                let same = meetings
                    .iter_mut()
                    .find(|meeting: &&mut Meeting| meeting.pair_constants == pair_constants);
                let classes = 1 << other;
                match same {
                    Some(meeting) => meeting.classes |= classes,
                    None => meetings.push(Meeting {
                        classes,
                        pair_constants,
                    }),
                }
            }
            Some(meetings)
        };
        self.meetings.extend((0..classes).map(meetings));
    }

    /// The distances at which a disc meets others, if there are few.
    #[inline]
    pub fn meetings_of(&self, disc: u32) -> Option<&Meetings> {
        let &class = self.of_bodies.get(disc as usize)?;
        self.meetings[class as usize].as_ref()
    }

    /// The class of a body, or of the dummy.
    #[inline(always)]
    pub fn of(&self, body: u32) -> u8 {
        self.of_bodies[body as usize]
    }

    /// Reads the class of a body whose tags have changed.
    pub fn renew(&mut self, world: &World, body: u32) {
        if let Some(class) = self.of_bodies.get_mut(body as usize) {
            *class = world.bodies()[body as usize].kind.tag_class as u8;
        }
    }

    pub fn heap_bytes(&self) -> usize {
        self.of_bodies.capacity() + self.meetings.capacity() * size_of::<Option<Meetings>>()
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

fn radii_by_class(world: &World, grid: &CellGrid, classes: usize) -> Vec<Radii> {
    let mut radii = vec![Radii::None; classes];
    for body in world
        .bodies()
        .iter()
        .filter(|body| !grid.is_multi_cell(body))
    {
        let radius = body.molecule().bounding_radius();
        let of_class = &mut radii[body.kind.tag_class as usize];
        *of_class = match *of_class {
            Radii::None => Radii::All(radius),
            Radii::All(common) if common == radius => Radii::All(radius),
            _ => Radii::Several,
        };
    }
    radii
}
