//! How events are ordered: the seam behind which the data layout, the search for neighbours and the
//! calendar stand together.
//!
//! [`Scheduler`] is what [`Simulation`](crate::Simulation) is generic over. It keeps the motions
//! while an epoch runs and hands its [`EventQueue`] to the [`EventLoop`] of the engine. The smallest
//! one that is right compares all pairs in all images; `tests/own_scheduler.rs` has it in full.
//!
//! # Ties
//!
//! Contacts of disjoint pairs at the same time commute: they may come in any order that depends on
//! the state alone. Contacts at the same time that share a body do not commute. Of these, the one
//! with the first body inserted earlier comes first, and of two with the same first body, the one
//! with the second body inserted earlier ([`ContactEvent::in_order`]). Within a pair, detection
//! decides: it is given the body inserted first as A (see [`ordered`]) and takes the atoms with the
//! lowest indices.
//!
//! # Walls
//!
//! A wall is a fixed body with a straight [`Face`](carom_geometry::Face), of any length, that goes
//! through its centre of mass. [`Body::reach`] of a wall is half the thickness of the face, and
//! [`World::largest_reach`] counts this alone. So cells at least as wide as the largest reach hold
//! every body that touches another in the same or a neighbouring cell, but a wall only near its
//! centre. A scheduler with cells lists each wall in all cells that hold centres of bodies that may
//! touch it, [`StandingWall::cells_within`] the largest bounding radius of a body that moves. A
//! scheduler that compares all pairs within their bounding radii
//! ([`Molecule::bounding_radius`](carom_geometry::Molecule::bounding_radius)) needs nothing special:
//! that of a wall includes its length.
//!
//! ```
//! use carom_engine::{Scene, Simulation, scheduler::StandingWall};
//! use glam::DVec2;
//!
//! let scene = Scene::from_toml("[[wall]]\nfrom = [0.15, 0.55]\nto = [0.35, 0.55]")?;
//! let simulation = Simulation::new(&scene)?;
//! let view = simulation.view();
//! let wall = view.bodies().next().unwrap();
//! assert_eq!(wall.body.reach(), 0.0);
//! let wall = StandingWall::of(wall.body, &wall.motion).unwrap();
//! // The centres of discs of radius 0.01 that touch it are in these cells of side 0.1.
//! assert_eq!(wall.cells_within(0.01, DVec2::splat(0.1)), [[1, 5], [2, 5], [3, 5]]);
//! assert!((wall.gap(DVec2::new(0.2, 0.5)) - 0.05).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Rounding
//!
//! Positions are known to a few roundings of the side of the box. [`separation_error`] bounds the
//! rounding of x − x′ + (v − v′) t + image within an epoch, however a scheduler stores its motions.
//! [`Detection`] that is asked with a [`RelativeMotion`](carom_kinematics::RelativeMotion) formed
//! by [`RelativeMotion::between`](carom_kinematics::RelativeMotion::between) needs no other bound;
//! the batches of [`DiscLanes`](carom_detection::DiscLanes) do.

use std::cmp::Ordering;

use carom_detection::{Detection, Part, Touch};
use carom_geometry::Molecule;
use carom_kinematics::{HALF_ULP, Motion};
use glam::DVec2;

pub use crate::wall::StandingWall;
use crate::{Body, GridError, SchedulerCounters, World, limits::sides_per_epoch};

/// The next contact of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactEvent {
    /// Offset from the start of the epoch (time).
    pub time: f64,
    /// The two bodies, in the order of [`World::bodies`].
    pub bodies: [u32; 2],
    /// Which image of the second is touched, in boxes relative to the places of the two motions.
    pub image: [i64; 2],
    /// The parts that touch.
    pub parts: Parts,
}

impl ContactEvent {
    /// By time; of two at the same time, by the first and then by the second body.
    pub fn in_order(&self, other: &Self) -> Ordering {
        self.time.total_cmp(&other.time).then(self.bodies.cmp(&other.bodies))
    }
}

/// The parts of two bodies that touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parts {
    /// Both bodies are single discs: there are no arms, and nothing turns.
    Discs,
    /// An atom of each, by index.
    Atoms(u32, u32),
    /// Their bounding circles, in the model that knows nothing finer.
    BoundingCircles,
    /// The face of the first, a wall, and a part of the second.
    FaceOfA(Part),
    /// A part of the first, and the face of the second, a wall.
    FaceOfB(Part),
}

impl Parts {
    /// The distance at which the centres of what touches are in contact (length); that of a face is its plane.
    pub(crate) fn contact_distance(self, [a, b]: [&Molecule; 2]) -> f64 {
        let radius = |molecule: &Molecule, atom: u32| molecule.atoms()[atom as usize].radius();
        let of_face = |wall: &Molecule, other: &Molecule, part| {
            let face = wall.face().map_or(0.0, carom_geometry::Face::radius);
            let radius = match part {
                Part::Atom(index) => radius(other, index),
                Part::BoundingCircle => other.bounding_radius(),
            };
            face + radius
        };
        match self {
            Self::Discs => radius(a, 0) + radius(b, 0),
            Self::Atoms(i, j) => radius(a, i) + radius(b, j),
            Self::BoundingCircles => a.bounding_radius() + b.bounding_radius(),
            Self::FaceOfA(part) => of_face(a, b, part),
            Self::FaceOfB(part) => of_face(b, a, part),
        }
    }

    /// Indices of the touching atoms, and the radius of what touches of the first body (length).
    pub(crate) fn atoms_and_first_radius(self, first: &Molecule) -> ([Option<u32>; 2], f64) {
        match self {
            Self::Discs => ([Some(0); 2], first.bounding_radius()),
            Self::Atoms(i, j) => ([Some(i), Some(j)], first.atoms()[i as usize].radius()),
            Self::BoundingCircles | Self::FaceOfB(Part::BoundingCircle) => {
                ([None; 2], first.bounding_radius())
            }
            Self::FaceOfB(Part::Atom(i)) => ([Some(i), None], first.atoms()[i as usize].radius()),
            Self::FaceOfA(part) => {
                let atom = if let Part::Atom(j) = part { Some(j) } else { None };
                ([None, atom], first.face().map_or(0.0, carom_geometry::Face::radius))
            }
        }
    }
}

impl From<Touch> for Parts {
    fn from(touch: Touch) -> Self {
        match touch {
            Touch::Atoms(i, j) => Self::Atoms(i, j),
            Touch::BoundingCircles => Self::BoundingCircles,
            Touch::FaceOfA(part) => Self::FaceOfA(part),
            Touch::FaceOfB(part) => Self::FaceOfB(part),
        }
    }
}

impl From<Parts> for Touch {
    fn from(parts: Parts) -> Self {
        match parts {
            Parts::Discs => Self::Atoms(0, 0),
            Parts::Atoms(i, j) => Self::Atoms(i, j),
            Parts::BoundingCircles => Self::BoundingCircles,
            Parts::FaceOfA(part) => Self::FaceOfA(part),
            Parts::FaceOfB(part) => Self::FaceOfB(part),
        }
    }
}

/// Bound on the rounding of the separation of two bodies within an epoch (length).
///
/// The separation is (x − x′) + (v − v′) t + image, and each of these is at most two sides long for
/// each side of the box that the fastest body goes in an epoch.
pub fn separation_error(world: &World) -> f64 {
    HALF_ULP * 16.0 * (sides_per_epoch(world) * world.bounds().sides().element_sum())
}

/// A pair with the body inserted first in front, and the image of the second as seen from it.
///
/// Predicted in this order, a pair gives the same contact whichever of the two is asked about.
///
/// ```
/// use carom_engine::scheduler::ordered;
///
/// // Body 2 meets body 5 one box to its right, so body 5 meets body 2 one box to its left.
/// assert_eq!(ordered([5, 2], [-1, 0]), ([2, 5], [1, 0]));
/// ```
pub fn ordered(pair: [u32; 2], image: [i64; 2]) -> ([u32; 2], [i64; 2]) {
    if pair[0] <= pair[1] { (pair, image) } else { ([pair[1], pair[0]], image.map(|boxes| -boxes)) }
}

/// Gives the contacts in order of time and takes over what becomes of them, while an epoch runs.
///
/// The engine promises: after a contact the bodies' new motions are handed over before the next is asked for; the world
/// does not change meanwhile; nothing is asked for beyond the end of the epoch, which comes no later than was said at its
/// beginning. The queue promises: no contact of the present motions before the one it gives.
#[doc(alias = "calendar")]
pub trait EventQueue {
    /// Goes on to the next contact no later than `stop` (offset in the epoch, time).
    fn next_contact<D: Detection>(&mut self, world: &World, detection: &D, stop: f64)
    -> Option<ContactEvent>;

    /// The present motion of a body; its subjective time is an offset in the epoch.
    fn motion(&self, body: u32) -> Motion;

    /// Takes over the new motions of two bodies, which begin now, and predicts them anew. A fixed body's is
    /// ignored.
    fn motions_changed<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        bodies: [u32; 2],
        motions: [Motion; 2],
    );

    /// Inverse masses of two single discs (1/mass). A queue that keeps them near its motions
    /// overrides this.
    #[inline]
    fn inverse_masses(&self, world: &World, bodies: [u32; 2]) -> [f64; 2] {
        bodies.map(|body| world.bodies()[body as usize].inertia().inverse_mass)
    }

    /// Place of a body at `time` (offset in the epoch), and its velocity.
    #[inline]
    fn flight(&self, body: u32, time: f64) -> [DVec2; 2] {
        let motion = self.motion(body);
        [motion.position_at(time), motion.velocity]
    }

    /// [`Self::motions_changed`] for two bodies of which only the velocities have changed: at `time` they are at
    /// `places`, with new `velocities`.
    #[inline]
    fn flights_changed<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        bodies: [u32; 2],
        time: f64,
        [places, velocities]: [[DVec2; 2]; 2],
    ) {
        let [a, b] = bodies.map(|body| self.motion(body).at(time));
        let a = Motion { position: places[0], velocity: velocities[0], ..a };
        let b = Motion { position: places[1], velocity: velocities[1], ..b };
        self.motions_changed(world, detection, bodies, [a, b]);
    }
}

/// What the engine does with the contacts of an epoch: asks a queue for one after the other.
///
/// A scheduler that computes with instructions which not every processor has runs it in code compiled with them, queue and
/// loop in one piece; so [`Self::run`] is to be marked `#[inline(always)]`.
pub trait EventLoop {
    /// How it ended.
    type End;

    /// Goes through the contacts of this queue.
    fn run<Q: EventQueue>(self, queue: &mut Q) -> Self::End;
}

/// The motions of the system outside an epoch, into which a scheduler writes its own.
///
/// A motion may be stored with any subjective time in the epoch, and with a position outside the
/// box: the engine wraps positions, and counts the boxes left behind, at the end of the epoch.
#[derive(Debug)]
pub struct StoredMotions<'a> {
    world: &'a mut World,
}

impl<'a> StoredMotions<'a> {
    pub(crate) fn new(world: &'a mut World) -> Self {
        Self { world }
    }

    /// The bodies, in order of insertion.
    pub fn bodies(&self) -> &[Body] {
        &self.world.bodies
    }

    /// How many boxes a body had left behind, per axis, when it was last stored.
    pub fn winding(&self, body: u32) -> [i64; 2] {
        self.world.windings[body as usize]
    }

    /// Stores the motion of a body, and how many boxes it has left behind, per axis, since it was
    /// added: those that [`World::windings`] gave at the start of the epoch, and those that the
    /// scheduler has wrapped its position by since. The motion of a fixed body is ignored.
    pub fn set(&mut self, body: u32, motion: Motion, winding: [i64; 2]) {
        let index = body as usize;
        if !self.world.bodies[index].is_fixed() {
            self.world.motions[index] = motion;
            self.world.windings[index] = winding;
        }
    }
}

/// Finds the soonest contact, again and again, and keeps the motions while an epoch runs.
///
/// [`CellScheduler`](crate::CellScheduler) and [`HeapScheduler`](crate::HeapScheduler) are the two that are shipped.
///
/// The engine promises: an epoch is begun before anything else and after every edit.
pub trait Scheduler: Sized {
    /// What can be chosen about it.
    type Options: Clone + Default;

    /// Contacts per moving body after which an epoch ends, and everything is predicted anew. Smaller: more time goes
    /// into that. Larger: times grow, and whatever piles up in the calendar does.
    const CONTACTS_PER_EPOCH: u64;

    /// A scheduler for this world, still without an epoch.
    ///
    /// # Errors
    /// [`GridError`] if the bodies do not suit the options.
    fn new(options: &Self::Options, world: &World) -> Result<Self, GridError>;

    /// Begins an epoch of at most `limit` (time): takes over the motions, and predicts everything anew from the
    /// state of the world alone.
    fn begin_epoch<D: Detection>(&mut self, world: &World, detection: &D, limit: f64);

    /// Hands its queue of the present epoch's events to a loop.
    fn run<L: EventLoop>(&mut self, events: L) -> L::End;

    /// Writes the present motions, and the boxes left behind, into the state of the system.
    fn store(&self, state: &mut StoredMotions<'_>);

    /// Stores what has changed since the last call of this or of [`Self::store`], which is one
    /// contact at most: the motions of its bodies (`contact`, empty if there was none), and of all
    /// bodies whose positions were wrapped.
    ///
    /// Called after a single step, which should not cost a copy of all bodies. The default copies
    /// them.
    fn store_changes(&mut self, state: &mut StoredMotions<'_>, contact: &[u32]) {
        let _ = contact;
        self.store(state);
    }

    /// Memory kept on the heap (bytes).
    fn heap_bytes(&self) -> usize;

    /// What was done so far.
    fn counters(&self) -> SchedulerCounters;
}
