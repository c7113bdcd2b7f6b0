//! The simulation: it owns all state and runs from event to event.

use carom_detection::{Detection, Exact};
use carom_kinematics::{Instant, Motion};
use carom_response::{Impact, Response};

use crate::{
    BodyName, Cells, Counters, ElasticityTable, Ledger, Observer, RunError, Scheduler, SchedulerCounters,
    TagNames, View, World,
    at_once::AtOnce,
    limits::{LEAST_SPEED, Limits, refuse_outpaced, too_slow},
    pass::{Ended, Pass},
    scheduler::StoredMotions,
    unresolved::Unresolved,
};

/// A system of rigid molecules in a periodic box, at some time.
///
/// Generic over its seams: how contacts are found (`D`), what they change (`R`), and how events are ordered
/// (`S`). See the [crate] for an example.
#[derive(Debug, Clone)]
pub struct Simulation<D = Exact, R = Impact, S: Scheduler = Cells> {
    pub(crate) world: World,
    pub(crate) detection: D,
    pub(crate) response: R,
    pub(crate) scheduler: S,
    pub(crate) scheduler_options: S::Options,
    pub(crate) elasticity: ElasticityTable,
    pub(crate) names: TagNames,
    pub(crate) counters: Counters,
    /// Work of the schedulers before the present one.
    pub(crate) work_before: SchedulerCounters,
    pub(crate) ledger: Ledger,
    /// How far the present epoch has been run (time).
    pub(crate) offset: f64,
    pub(crate) epoch: Epoch,
    pub(crate) at_once: AtOnce,
    pub(crate) unresolved: Unresolved,
}

/// The present epoch.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Epoch {
    /// It has not begun: everything is to be predicted.
    ToBegin,
    Running(Limits),
}

impl<D: Detection, R: Response, S: Scheduler> Simulation<D, R, S> {
    /// The present time.
    pub fn time(&self) -> Instant {
        self.world.epoch.after(self.offset)
    }

    /// Memory kept for the bodies and their events (bytes), shapes that they share not included.
    pub fn heap_bytes(&self) -> usize {
        self.world.heap_bytes() + self.scheduler.heap_bytes()
    }

    /// All bodies at the present time.
    pub fn view(&self) -> View<'_> {
        View {
            world: &self.world,
            names: &self.names,
            counters: &self.counters,
            ledger: &self.ledger,
            offset: self.offset,
        }
    }

    /// Runs to `time`, events at exactly `time` included. A time that has passed already changes nothing.
    ///
    /// # Errors
    /// [`RunError`] if `time` is not finite, or the run cannot go on; the system then stands at the event
    /// where it stopped.
    pub fn run_until(&mut self, time: f64) -> Result<(), RunError> {
        self.observe_until(time, &mut ())
    }

    /// Runs to `time` and tells `observer` of each collision.
    ///
    /// # Errors
    /// As [`Self::run_until`].
    pub fn observe_until<O: Observer + ?Sized>(
        &mut self,
        time: f64,
        observer: &mut O,
    ) -> Result<(), RunError> {
        if !time.is_finite() {
            return Err(RunError::Time(time));
        }
        self.observe_until_instant(Instant::from(time), observer)
    }

    /// Runs to an instant of any age and tells `observer` of each collision.
    ///
    /// # Errors
    /// As [`Self::run_until`].
    pub fn observe_until_instant<O: Observer + ?Sized>(
        &mut self,
        until: Instant,
        observer: &mut O,
    ) -> Result<(), RunError> {
        self.advance(until, u64::MAX, observer).map(|_| ())
    }

    /// Runs on to the next contact and through it, but not beyond `time`; tells whether there was one.
    ///
    /// # Errors
    /// As [`Self::run_until`].
    pub fn step<O: Observer + ?Sized>(&mut self, time: f64, observer: &mut O) -> Result<bool, RunError> {
        if !time.is_finite() {
            return Err(RunError::Time(time));
        }
        self.advance(Instant::from(time), 1, observer).map(|contacts| contacts == 1)
    }

    /// Runs to `until` or through so many contacts, whichever is first; tells how many there were.
    fn advance<O: Observer + ?Sized>(
        &mut self,
        until: Instant,
        most: u64,
        observer: &mut O,
    ) -> Result<u64, RunError> {
        let mut contacts = 0;
        while !self.advance_one_epoch(until, most, &mut contacts, observer)? {}
        Ok(contacts)
    }

    /// Runs to `until`, but not beyond the end of the present epoch; tells whether `until` has been reached.
    ///
    /// At the end of an epoch the state is all there is to know of a run, so that [`Self::checkpoint`] can be asked for.
    /// To run to `until` in such pieces changes no bit.
    ///
    /// # Errors
    /// As [`Self::run_until`].
    pub fn observe_epoch<O: Observer + ?Sized>(
        &mut self,
        until: Instant,
        observer: &mut O,
    ) -> Result<bool, RunError> {
        self.advance_one_epoch(until, u64::MAX, &mut 0, observer)
    }

    /// Runs to the end of the epoch at most; tells whether `until`, or the last contact asked for, has been reached.
    fn advance_one_epoch<O: Observer + ?Sized>(
        &mut self,
        until: Instant,
        most: u64,
        contacts: &mut u64,
        observer: &mut O,
    ) -> Result<bool, RunError> {
        if !until.to_f64().is_finite() {
            return Err(RunError::Time(until.to_f64()));
        }
        // A time that has passed, whether before the call or by a rounding of the epoch's start.
        let reached = if *contacts == most || until.since(self.world.epoch) < self.offset {
            Ok(true)
        } else {
            self.advance_in_epoch(until, most, contacts, observer).inspect_err(|_| {
                // Its contact has left the calendar: predicted anew, it is there again for whoever goes on.
                self.end_epoch(self.offset);
            })
        };
        self.stand_by();
        reached
    }

    /// Runs within one epoch; tells whether `until`, or the last contact asked for, has been reached.
    fn advance_in_epoch<O: Observer + ?Sized>(
        &mut self,
        until: Instant,
        most: u64,
        contacts: &mut u64,
        observer: &mut O,
    ) -> Result<bool, RunError> {
        let target = until.since(self.world.epoch);
        self.begin_epoch(target)?;
        let Epoch::Running(limits) = &mut self.epoch else { return Ok(false) };
        let pass = Pass {
            world: &mut self.world,
            detection: &self.detection,
            response: &self.response,
            elasticity: &self.elasticity,
            names: &self.names,
            counters: &mut self.counters,
            ledger: &mut self.ledger,
            at_once: &mut self.at_once,
            unresolved: &mut self.unresolved,
            limits,
            now: &mut self.offset,
            observer,
            target,
            contacts,
            most,
        };
        match self.scheduler.run(pass)? {
            Ended::AsAsked => return Ok(true),
            Ended::WithContact(time) => {
                self.end_epoch_with_contact(time);
                return Ok(*contacts == most);
            }
            Ended::AtLimit(limit) => {
                let begun = self.world.epoch;
                self.end_epoch(limit);
                if self.world.epoch == begun {
                    return Err(RunError::TimeStandsStill { time: begun, stretch: limit });
                }
            }
        }
        Ok(false)
    }

    /// Brings the world up to date with the scheduler, whose motions are the true ones within an epoch.
    fn stand_by(&mut self) {
        if let Epoch::Running(_) = self.epoch {
            self.scheduler.store(&mut StoredMotions::new(&mut self.world));
        }
        self.counters.scheduler = self.work_before + self.scheduler.counters();
    }

    /// Begins the epoch if it has not begun; the run goes on to `target` (offset in it, time).
    fn begin_epoch(&mut self, target: f64) -> Result<(), RunError> {
        if let Epoch::Running(_) = self.epoch {
            return Ok(());
        }
        let motions = &self.world.motions;
        let fastest_squared = motions.iter().map(|m| m.velocity.length_squared()).fold(0.0, f64::max);
        let fastest_spin = motions.iter().map(|m| m.angular_velocity.abs()).fold(0.0, f64::max);
        // A sufficient test first: most often the fastest centre moves fast enough.
        if fastest_squared < LEAST_SPEED * LEAST_SPEED
            && let Some((index, speed)) = too_slow(&self.world)
        {
            let body = BodyName::new(&self.world.bodies[index], &self.names);
            return Err(RunError::TooSlow { time: self.world.epoch, body, speed });
        }
        let moving = self.world.bodies.iter().filter(|body| !body.is_fixed()).count() as u64;
        let contacts = (S::CONTACTS_PER_EPOCH * moving).div_ceil(2).max(1);
        let limits = Limits::new(&self.world, fastest_squared, fastest_spin, contacts);
        refuse_outpaced(&self.world, &self.names, limits.time(), self.at_once.time, target)?;
        self.epoch = Epoch::Running(limits);
        self.counters.epochs += 1;
        self.scheduler.begin_epoch(&self.world, &self.detection, limits.time());
        Ok(())
    }

    /// Ends the epoch with a contact at `time` (offset in it).
    fn end_epoch_with_contact(&mut self, time: f64) {
        let Epoch::Running(limits) = self.epoch else { return };
        self.stand_by();
        self.epoch = Epoch::ToBegin;
        // For a body that has become so fast, the place in the queue is rounded too coarsely.
        if let Some(contact) = limits.stale_contact() {
            for (&body, &position) in contact.bodies.iter().zip(&contact.places) {
                if !self.world.bodies[body as usize].is_fixed() {
                    let motion = &mut self.world.motions[body as usize];
                    *motion = Motion { position, ..motion.at(time) };
                }
            }
        }
        self.end_epoch(time);
    }

    /// Brings all bodies to `offset` and makes it the start of the next epoch.
    pub(crate) fn end_epoch(&mut self, offset: f64) {
        self.stand_by();
        self.world.rebase(offset);
        self.offset = 0.0;
        self.at_once.rebase(offset);
        self.unresolved.rebase(offset);
        self.epoch = Epoch::ToBegin;
    }
}
