//! The seam of the order of events: data layout, neighbourhood and calendar together.

use carom_detection::{Detection, Touch};

use crate::{GridError, SchedulerCounters, World};

/// The next contact of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactEvent {
    /// Offset from the start of the epoch (time).
    pub time: f64,
    /// The two bodies, in the order of [`World::bodies`].
    pub bodies: [u32; 2],
    /// Which image of the second is touched, in boxes relative to its place.
    pub image: [i64; 2],
    /// The parts that touch.
    pub touch: Touch,
}

/// Finds the soonest contact, again and again.
///
/// The engine promises: an epoch is begun before anything else and after every edit; the motions of the
/// bodies of a contact are changed, and their versions raised, before [`Self::motions_changed`] is called;
/// nothing else changes. The scheduler promises: no contact of the present motions before the one it gives.
/// It may wrap positions at the border (with the winding), and changes nothing else of the world.
pub trait Scheduler: Sized {
    /// What can be chosen about it.
    type Options: Clone + Default;

    /// A scheduler for this world, still without an epoch.
    ///
    /// # Errors
    /// [`GridError`] if the bodies do not suit the options.
    fn new(options: &Self::Options, world: &World) -> Result<Self, GridError>;

    /// Begins an epoch of at most `limit` (time): everything is predicted anew from the state of the world
    /// alone.
    fn begin_epoch<D: Detection>(&mut self, world: &World, detection: &D, limit: f64);

    /// Goes on to the next contact no later than `stop` (offset in the epoch, time).
    fn next_contact<D: Detection>(
        &mut self,
        world: &mut World,
        detection: &D,
        stop: f64,
    ) -> Option<ContactEvent>;

    /// Predicts two bodies anew whose motions have changed at `now` (offset in the epoch, time).
    fn motions_changed<D: Detection>(&mut self, world: &World, detection: &D, bodies: [u32; 2], now: f64);

    /// What was done so far.
    fn counters(&self) -> SchedulerCounters;
}
