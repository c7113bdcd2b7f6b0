//! Schedulers: they store the motions during an epoch, search for neighbours, and order the events.
//!
//! [`Simulation`](crate::Simulation) is generic over [`Scheduler`]. A scheduler holds the motions
//! during an epoch and passes its [`EventQueue`] to the [`EventLoop`] of the engine. The shortest
//! correct scheduler compares all pairs in all images; `tests/own_scheduler.rs` contains it in
//! full.
//!
//! # Ties
//!
//! Contacts of disjoint pairs at the same time commute: their order may be any that depends on the
//! state alone. Contacts at the same time that share a body do not commute. Among these, the
//! contact whose first body was inserted earlier comes first; if the first body is the same, the
//! contact whose second body was inserted earlier ([`ContactEvent::in_order`]). Within a pair,
//! detection decides: its body A is the body inserted first (see [`ordered`]), and it takes the
//! atoms with the lowest indices.
//!
//! # Walls
//!
//! A wall is a fixed body with a straight [`Edge`](carom_geometry::Edge) of any length through its
//! centre of mass. [`Body::reach`] of a wall is half the thickness of the face, and
//! [`World::largest_reach`] counts only this. Cells at least as wide as the largest reach therefore
//! hold each body that touches another body in the same or an adjacent cell; for a wall this holds
//! only near its centre. A scheduler with cells lists each wall in all cells that hold centres of
//! bodies that may touch it: [`StandingWall::cells_within`] the largest bounding radius of a moving
//! body. A scheduler that compares all pairs within their bounding radii
//! ([`Molecule::bounding_radius`](carom_geometry::Molecule::bounding_radius)) needs no special
//! case, since the bounding radius of a wall includes its length.
//!
//! The motion of a wall may have a velocity, and that of one with end points an angular velocity.
//! Contacts do not change it. [`StandingWall::during`] gives the cells of a wall for a span of
//! time. A wall may oscillate, and with a gravity all fixed bodies are accelerated, in a frame that
//! falls with the free ones: [`World::relative_drive`] gives what a pair then does beside its
//! [`World::relative_motion`]. A scheduler that takes this into account sets
//! [`Scheduler::RUNS_DRIVEN_BODIES`].
//!
//! A piston ([`Body::is_piston`]) is a wall across the box that contacts push like any other body
//! that moves. It meets no other wall. A scheduler that compares all bodies with it, and returns a
//! [`ContactEvent::stop`] at its [`World::stop_time`], sets [`Scheduler::RUNS_PISTONS`].
//!
//! # Shear
//!
//! Under shear the images above and below move: [`World::relative_motion`] knows them. A scheduler
//! that passes bodies through the upper and lower side of the box by [`World::pass_seam`] sets
//! [`Scheduler::RUNS_SHEAR`].
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
//! let wall = StandingWall::new(wall.body, &wall.motion).unwrap();
//! // The centres of discs of radius 0.01 that touch it are in these cells of side 0.1.
//! assert_eq!(wall.cells_within(0.01, DVec2::splat(0.1)), [[1, 5], [2, 5], [3, 5]]);
//! assert!((wall.gap(DVec2::new(0.2, 0.5)) - 0.05).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Tethers
//!
//! Two bodies may be tied by a bond ([`World::bonds`]), which reaches one of its bounds like a
//! contact, with [`TouchingParts::Bond`] as its parts. A scheduler that predicts the bonds of a
//! body whenever it predicts the body sets [`Scheduler::RUNS_TETHERS`].
//!
//! # Rounding
//!
//! The error of a position is a few roundings of the side of the box. [`separation_error`] bounds
//! the rounding of x − x′ + (v − v′) t + image within an epoch, for each way in which a scheduler
//! may store its motions. Calls of [`Detection`] with a
//! [`RelativeMotion`](carom_kinematics::RelativeMotion) from
//! [`RelativeMotion::between`](carom_kinematics::RelativeMotion::between) need no other bound; the
//! batches of [`DiscLanes`](carom_detection::DiscLanes) need this one.

use carom_detection::Detection;
use carom_kinematics::Motion;
use carom_response::Response;
use glam::DVec2;

pub use crate::{
    contact::separation_error::separation_error,
    window::{RestartState, TimeWindow, WindowJob},
    world::{
        contact_event::{ContactEvent, TouchingParts},
        wall::StandingWall,
    },
};
use crate::{
    scene::error::GridError,
    tiling::{TileCounters, TileUse, TileWork, Tiling},
    world::{World, body::Body, counters::SchedulerCounters},
};

/// A pair ordered so that the body inserted first is first, with the image of the second relative
/// to the first.
///
/// Predicted in this order, a pair gives the same contact for both bodies.
///
/// ```
/// use carom_engine::scheduler::ordered;
///
/// // Body 2 meets body 5 one box to its right, so body 5 meets body 2 one box to its left.
/// assert_eq!(ordered([5, 2], [-1, 0]), ([2, 5], [1, 0]));
/// ```
pub fn ordered(pair: [u32; 2], image: [i64; 2]) -> ([u32; 2], [i64; 2]) {
    if pair[0] <= pair[1] {
        (pair, image)
    } else {
        ([pair[1], pair[0]], image.map(|boxes| -boxes))
    }
}

/// Returns the contacts of an epoch in order of time and receives the new motions after each.
///
/// The engine guarantees: the new motions after a contact are passed on before the next contact is
/// requested; the world does not change in between; no contact is requested after the end of the
/// epoch, which is no later than the limit given at its beginning. The queue guarantees: the
/// present motions have no contact before the one returned.
#[doc(alias = "calendar")]
pub trait EventQueue {
    /// Advances to the next contact no later than `stop` (offset in the epoch, time); `None` if
    /// there is none.
    fn next_contact<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        stop: f64,
    ) -> Option<ContactEvent>;

    /// The present motion of a body; its subjective time is an offset in the epoch.
    fn motion(&self, body: u32) -> Motion;

    /// Stores the new motions of two bodies, which begin now, and predicts the bodies anew. The
    /// motion of a fixed body is ignored.
    fn motions_changed<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        bodies: [u32; 2],
        motions: [Motion; 2],
    );

    /// Variant of [`Self::motions_changed`] for one body: a piston that a stop has reflected.
    fn motion_changed<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        body: u32,
        motion: Motion,
    ) {
        self.motions_changed(world, detection, [body; 2], [motion; 2]);
    }

    /// Inverse masses of two single discs (1/mass). A queue that stores them next to its motions
    /// overrides this.
    #[inline]
    fn inverse_masses(&self, world: &World, bodies: [u32; 2]) -> [f64; 2] {
        world.inverse_masses(bodies)
    }

    /// Position and velocity of a body at `time` (offset in the epoch).
    #[inline]
    fn flight(&self, body: u32, time: f64) -> [DVec2; 2] {
        let motion = self.motion(body);
        [motion.position_at(time), motion.velocity]
    }

    /// Variant of [`Self::motions_changed`] for a change of velocities only: at `time` the two
    /// bodies are at `places`, with new `velocities`.
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
        let a = Motion {
            position: places[0],
            velocity: velocities[0],
            ..a
        };
        let b = Motion {
            position: places[1],
            velocity: velocities[1],
            ..b
        };
        self.motions_changed(world, detection, bodies, [a, b]);
    }
}

/// The engine's loop over the contacts of an epoch.
///
/// A scheduler with SIMD kernels runs the loop inside a `#[target_feature]` function, so that queue
/// and loop are compiled together for that instruction set. For this [`Self::run`] must be marked
/// `#[inline(always)]`.
pub trait EventLoop {
    /// How the loop ended.
    type End;

    /// Processes the contacts of `queue`.
    fn run<Q: EventQueue>(self, queue: &mut Q) -> Self::End;
}

/// The motions of the system between epochs, into which a scheduler writes its own.
///
/// A motion may have any subjective time in the epoch, and a position outside the box: at the end
/// of the epoch the engine wraps positions and counts the boxes crossed.
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

    /// Number of boxes that a body had crossed, per axis, when it was last stored.
    pub fn winding(&self, body: u32) -> [i64; 2] {
        self.world.windings[body as usize]
    }

    /// Stores the work of the shear ([`Ledger::sheared`](crate::Ledger::sheared)) where bodies have
    /// passed through the seam: [`World::work_of_shear`] at the start of the epoch plus that of
    /// [`World::pass_seam`] since then.
    pub fn set_work_of_shear(&mut self, work: f64) {
        self.world.work_of_shear = work;
    }

    /// Stores the motion of a body and the number of boxes that it has crossed, per axis, modulo
    /// 2¹⁶: in an epoch a body crosses only a few.
    pub(crate) fn set_wrapped(&mut self, body: u32, motion: Motion, winding: [i16; 2]) {
        let before = self.winding(body);
        let crossed = |axis: usize| i64::from(winding[axis].wrapping_sub(before[axis] as i16));
        self.set(
            body,
            motion,
            [0, 1].map(|axis| before[axis] + crossed(axis)),
        );
    }

    /// Stores the motion of a body and the number of boxes that it has crossed, per axis, since it
    /// was added: the value of [`World::windings`] at the start of the epoch plus the wraps of its
    /// position by the scheduler since then. The motion of a fixed body is ignored.
    pub fn set(&mut self, body: u32, motion: Motion, winding: [i64; 2]) {
        let index = body as usize;
        if !self.world.bodies[index].is_fixed() {
            self.world.motions[index] = motion;
            self.world.windings[index] = winding;
        }
    }
}

/// Finds the earliest contact, repeatedly, and holds the motions during an epoch.
///
/// Implementations: [`CellScheduler`](crate::CellScheduler) and
/// [`HeapScheduler`](crate::HeapScheduler).
///
/// The engine guarantees that it begins an epoch before any other call and after each edit.
pub trait Scheduler: Sized {
    /// Options of the scheduler.
    type Options: Clone + Default;

    /// Contacts per moving body after which an epoch ends and all events are predicted anew.
    /// Smaller: these predictions take more of the time. Larger: times within the epoch grow, and
    /// so does the number of entries that accumulate in the queue.
    const CONTACTS_PER_EPOCH: u64;

    /// Whether it takes the drives of fixed bodies into account ([`World::relative_drive`]).
    /// Default: false, and scenes with a gravity or walls that oscillate are refused.
    const RUNS_DRIVEN_BODIES: bool = false;

    /// Whether it runs pistons: walls that are not fixed, which are reflected at the times of
    /// [`World::stop_time`]. Default: false, and scenes with pistons are refused.
    const RUNS_PISTONS: bool = false;

    /// Whether it takes into account that images move ([`World::pass_seam`]). Default: false, and
    /// scenes with a shear are refused.
    const RUNS_SHEAR: bool = false;

    /// Whether it predicts the bonds of bodies ([`World::bonds_of`],
    /// [`World::first_bond_event`]) with every prediction of one of them. Default: false, and
    /// scenes with bonds are refused.
    const RUNS_TETHERS: bool = false;

    /// Whether it predicts the steps of discs in their wells ([`World::in_wells_of`],
    /// [`World::first_step`]) with every prediction of one of them. Default: false, and scenes with
    /// wells are refused.
    const RUNS_WELLS: bool = false;

    /// Creates a scheduler for this world, without an epoch.
    ///
    /// # Errors
    /// [`GridError`] if the options do not fit the bodies.
    fn new(options: &Self::Options, world: &World) -> Result<Self, GridError>;

    /// Creates a scheduler like [`Self::new`], unless bodies are driven, are pistons or are
    /// tethered or have wells, or images move, and it does not run that.
    ///
    /// # Errors
    /// Those of [`Self::new`], [`GridError::DrivenBodies`], [`GridError::Pistons`],
    /// [`GridError::Shear`], [`GridError::Tethers`] and [`GridError::Wells`].
    fn checked(options: &Self::Options, world: &World) -> Result<Self, GridError> {
        if world.is_driven() && !Self::RUNS_DRIVEN_BODIES {
            return Err(GridError::DrivenBodies);
        }
        if world.pistons().next().is_some() && !Self::RUNS_PISTONS {
            return Err(GridError::Pistons);
        }
        if world.is_sheared() && !Self::RUNS_SHEAR {
            return Err(GridError::Shear);
        }
        if world.is_tethered() && !Self::RUNS_TETHERS {
            return Err(GridError::Tethers);
        }
        if world.has_wells() && !Self::RUNS_WELLS {
            return Err(GridError::Wells);
        }
        Self::new(options, world)
    }

    /// Begins an epoch of at most `limit` (time): reads the motions, and predicts all events from
    /// the state of the world alone.
    fn begin_epoch<D: Detection>(&mut self, world: &World, detection: &D, limit: f64);

    /// Runs a loop on the queue of the present epoch.
    fn run<L: EventLoop>(&mut self, events: L) -> L::End;

    /// Runs and resolves all contacts of a part of the epoch at once, if this scheduler can. If
    /// not, it returns `None`, and [`Self::run`] must be able to continue from the present time, or
    /// from that of [`Self::take_restart`]. The engine calls this before each call of
    /// [`Self::run`].
    #[doc(hidden)]
    fn run_window<D: Detection, R: Response>(
        &mut self,
        _job: &WindowJob<'_, D, R>,
    ) -> Option<TimeWindow> {
        None
    }

    /// Whether the scheduler has run contacts later than the present.
    #[doc(hidden)]
    fn is_ahead(&self) -> bool {
        false
    }

    /// After [`Self::run_window`] has returned `None`: an earlier state, if the scheduler holds
    /// that. The engine then runs the contacts since that time once more, without recording them.
    #[doc(hidden)]
    fn take_restart(&mut self) -> Option<RestartState> {
        None
    }

    /// Sets how the box is divided into tiles that are run on their own. It changes the speed, and
    /// no bit of the results. The engine calls this before each call of [`Self::begin_epoch`]. By
    /// default it has no effect.
    fn set_tiling(&mut self, _tiling: &Tiling) {}

    /// Whether the bodies of this scheduler can be run in tiles with a division, and into how many.
    fn tile_use(&self, _tiling: &Tiling) -> TileUse {
        TileUse::Scheduler
    }

    /// The length of a window (time): shorter runs cost more for each contact; 0 without tiles.
    fn window_length(&self) -> f64 {
        0.0
    }

    /// The work of each tile in the last window; empty without one.
    fn tile_work(&self) -> Vec<TileWork> {
        Vec::new()
    }

    /// Counts of the work in tiles so far.
    fn tile_counters(&self) -> TileCounters {
        TileCounters::default()
    }

    /// Writes the present motions and windings into the state of the system.
    fn store(&self, state: &mut StoredMotions<'_>);

    /// Stores the changes since the last call of this or of [`Self::store`], at most one contact:
    /// the motions of its bodies (`contact`, empty if there was none), and of all bodies whose
    /// positions were wrapped. After [`Self::run_window`], any number of contacts.
    ///
    /// The engine calls this after a single step and after a window, which should not copy all
    /// bodies. The default copies them.
    fn store_changes(&mut self, state: &mut StoredMotions<'_>, contact: &[u32]) {
        let _ = contact;
        self.store(state);
    }

    /// Memory used on the heap (bytes).
    fn heap_bytes(&self) -> usize;

    /// Counts of the work done so far.
    fn counters(&self) -> SchedulerCounters;
}
