//! The simulation: it owns the state and advances it from event to event.

use carom_detection::{Detection, Exact};
use carom_kinematics::{EpochTime, HALF_ULP, Motion};
use carom_response::{Impact, Response};

use crate::{
    cells::CellScheduler,
    contact::{
        elasticity_table::ElasticityTable,
        limits::{Limits, longest_epoch, refuse_time_scales_too_far_apart, too_slow},
        reaction_table::ReactionTable,
        simultaneous_contacts::SimultaneousContacts,
        unresolved::Unresolved,
        wall_meeting::{first_meeting, longest_sweep},
    },
    run::{
        epoch_loop::{EpochEnd, EpochLoop},
        observer::Observer,
    },
    scene::{error::RunError, least_speed::MIN_SPEED, max_time::MAX_TIME},
    scheduler::{Scheduler, StoredMotions, separation_error},
    tiling::{TileCounters, TileUse, TileWork, Tiling},
    world::{
        World,
        body::{Body, BodyName},
        counters::{Counters, Ledger, SchedulerCounters},
        heat::HeatByTag,
        tags::TagNames,
        view::View,
        wall::wall_speed,
    },
};

/// Epochs for which meetings of walls are searched for at once. Smaller: more searches. Larger:
/// more images of the box in each.
const EPOCHS_OF_SEARCH: f64 = 4.0;

/// Largest ratio of the kinetic energy to that put into the system and that of all bodies at the
/// speed of the fastest wall, where walls have constant velocities: 2²⁰. A body between two walls
/// that close is then 2¹⁰ times as fast, in a gap 2¹⁰ times narrower, and a gas that is compressed
/// slowly has a millionth of its area. Smaller: a real compression is refused. Larger: more
/// contacts until the run ends, in proportion to its square root.
const MAX_COMPRESSION: f64 = 1_048_576.0;

/// Largest difference between two equal times, relative to them: each is rounded a few times.
const SAME_TIME: f64 = 4.0 * f64::EPSILON;

/// A system of rigid molecules in a periodic box, at some time.
///
/// Generic over how contacts are found (`D`), how they change the motions (`R`), and how events are
/// ordered (`S`). See the [crate] for an example.
#[derive(Debug, Clone)]
pub struct Simulation<D = Exact, R = Impact, S: Scheduler = CellScheduler> {
    pub(crate) world: World,
    pub(crate) detection: D,
    pub(crate) response: R,
    pub(crate) scheduler: S,
    pub(crate) scheduler_options: S::Options,
    /// Contacts per moving body after which an epoch ends.
    pub(crate) contacts_per_epoch: u64,
    pub(crate) tiling: Tiling,
    pub(crate) elasticity: ElasticityTable,
    pub(crate) names: TagNames,
    pub(crate) counters: Counters,
    /// Work counters of earlier schedulers, which an edit has replaced.
    pub(crate) work_before: SchedulerCounters,
    pub(crate) ledger: Ledger,
    pub(crate) heat: HeatByTag,
    pub(crate) reactions: ReactionTable,
    /// The present time, as an offset from the start of the epoch.
    pub(crate) offset: f64,
    pub(crate) epoch: Epoch,
    pub(crate) simultaneous: SimultaneousContacts,
    pub(crate) unresolved: Unresolved,
    /// No wall that moves meets a fixed body before this time. It saves searches and changes no
    /// result.
    pub(crate) walls_meet_after: EpochTime,
}

/// The state of the present epoch.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Epoch {
    /// The epoch has not begun: all events must be predicted.
    ToBegin,
    Running(Limits),
}

impl<D: Detection, R: Response, S: Scheduler> Simulation<D, R, S> {
    /// A simulation before its first epoch, with counters of 0.
    pub(crate) fn assemble(
        world: World,
        (detection, response): (D, R),
        (scheduler, scheduler_options): (S, S::Options),
        elasticity: ElasticityTable,
        names: TagNames,
    ) -> Self {
        Self {
            ledger: Ledger {
                initial: world.energy(),
                ..Ledger::default()
            },
            world,
            detection,
            response,
            scheduler,
            scheduler_options,
            contacts_per_epoch: S::CONTACTS_PER_EPOCH,
            tiling: Tiling::default(),
            elasticity,
            names,
            counters: Counters::default(),
            work_before: SchedulerCounters::default(),
            heat: HeatByTag::default(),
            reactions: ReactionTable::default(),
            offset: 0.0,
            epoch: Epoch::ToBegin,
            simultaneous: SimultaneousContacts::default(),
            unresolved: Unresolved::default(),
            walls_meet_after: EpochTime::ZERO,
        }
    }

    /// The present time.
    pub fn time(&self) -> EpochTime {
        self.world.time_at(self.offset)
    }

    /// Memory used by the bodies and their events (bytes), without the shapes that bodies share.
    pub fn heap_bytes(&self) -> usize {
        self.world.heap_bytes() + self.scheduler.heap_bytes()
    }

    /// A view of all bodies at the present time.
    pub fn view(&self) -> View<'_> {
        View {
            world: &self.world,
            names: &self.names,
            counters: &self.counters,
            ledger: &self.ledger,
            heat: &self.heat,
            reactions: &self.reactions.records,
            offset: self.offset,
        }
    }

    /// Changes the number of contacts per moving body after which an epoch ends, from the next
    /// epoch on; the default is the scheduler's own ([`Scheduler::CONTACTS_PER_EPOCH`]), and 0
    /// counts as 1. It changes the speed, and the trajectory by rounding. A checkpoint does not
    /// hold it.
    pub fn set_contacts_per_epoch(&mut self, contacts: u64) {
        self.contacts_per_epoch = contacts.max(1);
    }

    /// Changes how the box is divided into tiles, which are run on their own and on several
    /// threads, from the next epoch on; see [`Tiling`]. It changes the speed, and no bit of the
    /// results. A checkpoint does not hold it.
    pub fn set_tiling(&mut self, tiling: &Tiling) {
        self.tiling = *tiling;
    }

    /// Whether this system is divided into tiles, at its present state and [`Tiling`].
    pub fn tile_use(&self) -> TileUse {
        if !self.detection.decides_discs_in_closed_form() {
            return TileUse::Detector;
        }
        self.scheduler.tile_use(&self.tiling)
    }

    /// The length of a window (time); 0 without tiles. A run in shorter pieces costs more for each
    /// contact.
    pub fn window_length(&self) -> f64 {
        self.scheduler.window_length()
    }

    /// The work of each tile in the last window; empty without one.
    pub fn tile_work(&self) -> Vec<TileWork> {
        self.scheduler.tile_work()
    }

    /// Counts of the work in tiles since the present scheduler began.
    pub fn tile_counters(&self) -> TileCounters {
        self.scheduler.tile_counters()
    }

    /// Runs to `time`, including events at exactly `time`.
    ///
    /// # Errors
    /// [`RunError::Time`] if `time` is not finite or above [`MAX_TIME`](crate::MAX_TIME),
    /// [`RunError::Past`] if it is before the present, or another [`RunError`] if the run cannot
    /// continue; the system then remains at the event at which the run stopped.
    pub fn run_until(&mut self, time: f64) -> Result<(), RunError> {
        self.observe_until(time, &mut ())
    }

    /// Runs to `time` and reports each collision to `observer`.
    ///
    /// # Errors
    /// Those of [`Self::run_until`].
    pub fn observe_until(
        &mut self,
        time: f64,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        let end = self.end_of_run(time)?;
        self.observe_until_epoch_time(end, observer)
    }

    /// Runs to `until`, without the rounding of a single `f64`, and reports each collision to
    /// `observer`.
    ///
    /// # Errors
    /// Those of [`Self::run_until`].
    pub fn observe_until_epoch_time(
        &mut self,
        until: EpochTime,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        self.advance(until, u64::MAX, observer).map(|_| ())
    }

    /// Returns the end of a run at `time`, for [`Self::observe_until_epoch_time`].
    ///
    /// # Errors
    /// [`RunError::Time`] if it is not finite or above [`MAX_TIME`], and [`RunError::Past`] if it
    /// is
    /// before the present by more than rounding.
    pub fn end_of_run(&self, time: f64) -> Result<EpochTime, RunError> {
        if time > MAX_TIME {
            Err(RunError::Time(time))
        } else {
            self.end_of_step(time)
        }
    }

    /// The latest end of a step, at any finite `time` from the present on.
    fn end_of_step(&self, time: f64) -> Result<EpochTime, RunError> {
        let now = self.time().to_f64();
        if !time.is_finite() {
            Err(RunError::Time(time))
        } else if time < now - SAME_TIME * now.abs() {
            Err(RunError::Past {
                until: time,
                now: self.time(),
            })
        } else {
            Ok(EpochTime::from(time))
        }
    }

    /// Runs through the next contact, if it happens no later than `time`, which may be any finite
    /// time from the present on, else to `time`; returns whether there was a contact.
    ///
    /// The cost is O(log N) for N bodies, averaged over many steps: only the start of an epoch
    /// processes all bodies.
    ///
    /// # Errors
    /// Those of [`Self::run_until`].
    pub fn step(&mut self, time: f64, observer: &mut dyn Observer) -> Result<bool, RunError> {
        let end = self.end_of_step(time)?;
        self.advance(end, 1, observer).map(|contacts| contacts == 1)
    }

    /// Runs to `until`, but through at most `most` contacts; returns the number of contacts.
    pub(crate) fn advance(
        &mut self,
        until: EpochTime,
        most: u64,
        observer: &mut dyn Observer,
    ) -> Result<u64, RunError> {
        let mut contacts = 0;
        while !self.advance_one_epoch(until, most, &mut contacts, observer)? {}
        Ok(contacts)
    }

    /// Runs to `until`, but not past the end of the present epoch; returns whether `until` has been
    /// reached.
    ///
    /// At the end of an epoch the state alone determines the rest of the run, so that
    /// [`Self::checkpoint`] can be called. A run to `until` in such pieces gives the same result to
    /// the bit as a run in one piece.
    ///
    /// # Errors
    /// Those of [`Self::run_until`].
    pub fn observe_epoch(
        &mut self,
        until: EpochTime,
        observer: &mut dyn Observer,
    ) -> Result<bool, RunError> {
        self.advance_one_epoch(until, u64::MAX, &mut 0, observer)
    }

    /// Runs through at most `most` contacts, but not past `until` or the end of the present epoch;
    /// returns the number of contacts.
    ///
    /// The work is bounded whatever the speeds and `until`: in an epoch, no body crosses the box
    /// more than a few times.
    ///
    /// # Errors
    /// Those of [`Self::run_until`].
    pub fn observe_contacts(
        &mut self,
        until: EpochTime,
        most: u64,
        observer: &mut dyn Observer,
    ) -> Result<u64, RunError> {
        let mut contacts = 0;
        self.advance_one_epoch(until, most, &mut contacts, observer)?;
        Ok(contacts)
    }

    /// Runs to the end of the epoch at most; returns whether `until` or the number of contacts
    /// `most` has been reached.
    fn advance_one_epoch(
        &mut self,
        until: EpochTime,
        most: u64,
        contacts: &mut u64,
        observer: &mut dyn Observer,
    ) -> Result<bool, RunError> {
        if !until.to_f64().is_finite() {
            return Err(RunError::Time(until.to_f64()));
        }
        // `until` may lie in the past from the start, or after the rounding of the epoch's start.
        let reached = if *contacts == most || self.world.offset_at(until) < self.offset {
            Ok(true)
        } else if self.rests_with_drag() {
            self.wait(until);
            Ok(true)
        } else {
            self.advance_in_epoch(until, most, contacts, observer)
                .inspect_err(|_| {
                    // The queue no longer holds the contact. A new epoch predicts it again if the
                    // run continues.
                    self.end_epoch(self.offset);
                })
        };
        self.counters.scheduler = self.work_before + self.scheduler.counters();
        reached
    }

    /// Runs within one epoch; returns whether `until` or the number of contacts `most` has been
    /// reached.
    fn advance_in_epoch(
        &mut self,
        until: EpochTime,
        most: u64,
        contacts: &mut u64,
        observer: &mut dyn Observer,
    ) -> Result<bool, RunError> {
        let target = self.world.offset_at(until);
        // Whether the world holds the scheduler's motions, as after each call that ends within an
        // epoch.
        let is_stored = matches!(self.epoch, Epoch::Running(_));
        self.begin_epoch(target)?;
        let observer: Option<&mut dyn Observer> = if observer.watches_any() {
            Some(&mut *observer)
        } else {
            None
        };
        let Some((mut pass, scheduler)) = self.pass(observer, target, contacts, most) else {
            return Ok(false);
        };
        let ended_in_windows = pass.run_windows(scheduler)?;
        let in_windows = ended_in_windows.is_some();
        let ended = match ended_in_windows {
            Some(ended) => ended,
            None => pass.run_in_order(scheduler)?,
        };
        if matches!(ended, EpochEnd::TargetReached) && !self.world.clock.is_free() {
            self.world.stop = Some((target, until));
        }
        match ended {
            EpochEnd::TargetReached if in_windows || is_stored && *contacts == 0 => {
                self.scheduler
                    .store_changes(&mut StoredMotions::new(&mut self.world), &[]);
                return Ok(true);
            }
            EpochEnd::AtContact(bodies) if is_stored && *contacts == 1 => {
                self.scheduler
                    .store_changes(&mut StoredMotions::new(&mut self.world), &bodies);
                return Ok(true);
            }
            EpochEnd::TargetReached | EpochEnd::AtContact(_) => {
                self.scheduler
                    .store(&mut StoredMotions::new(&mut self.world));
                return Ok(true);
            }
            EpochEnd::WithContact(time) => {
                self.end_epoch_with_contact(time);
                self.carry_out_reaction()?;
                return Ok(*contacts == most);
            }
            EpochEnd::AtLimit(limit) => {
                let begun = self.world.epoch;
                self.end_epoch(limit);
                if self.world.epoch == begun {
                    return Err(RunError::TimeStandsStill {
                        time: begun,
                        stretch: limit,
                    });
                }
            }
        }
        Ok(false)
    }

    /// The loop over the contacts of the present epoch; none between two epochs.
    fn pass<'a>(
        &'a mut self,
        observer: Option<&'a mut dyn Observer>,
        target: f64,
        contacts: &'a mut u64,
        most: u64,
    ) -> Option<(EpochLoop<'a, D, R>, &'a mut S)> {
        let Epoch::Running(limits) = &mut self.epoch else {
            return None;
        };
        let pass = EpochLoop {
            world: &mut self.world,
            detection: &self.detection,
            response: &self.response,
            elasticity: &self.elasticity,
            names: &self.names,
            counters: &mut self.counters,
            ledger: &mut self.ledger,
            simultaneous: &mut self.simultaneous,
            unresolved: &mut self.unresolved,
            reactions: &mut self.reactions,
            limits,
            now: &mut self.offset,
            observer,
            target,
            contacts,
            most,
        };
        Some((pass, &mut self.scheduler))
    }

    /// Brings a scheduler that has run contacts later than the present back to it, before the rules
    /// of contacts change within an epoch.
    pub(crate) fn come_back_to_present(&mut self) {
        if self.scheduler.is_ahead() {
            let (offset, mut contacts) = (self.offset, 0);
            if let Some((pass, scheduler)) = self.pass(None, offset, &mut contacts, u64::MAX) {
                let ended = pass.come_back(scheduler);
                debug_assert!(
                    ended.is_ok(),
                    "these contacts have been accepted before: {ended:?}"
                );
            }
        }
    }

    /// Copies the motions and the counters of the scheduler into the world. Within an epoch, the
    /// scheduler holds the present motions.
    fn store_motions(&mut self) {
        if let Epoch::Running(_) = self.epoch {
            self.scheduler
                .store(&mut StoredMotions::new(&mut self.world));
        }
        self.counters.scheduler = self.work_before + self.scheduler.counters();
    }

    /// Books what drag, gravity and shear have done in the epoch that ends now. The world holds the
    /// present motions.
    pub(crate) fn book_flight(&mut self) {
        self.world.book_flight(&mut self.ledger, self.offset);
        self.world.work_of_shear = 0.0;
        if !self.world.clock.is_free() {
            self.ledger.restart_drag();
        }
    }

    /// Begins the epoch if it has not begun; the run continues to `target` (offset in the epoch,
    /// time).
    fn begin_epoch(&mut self, target: f64) -> Result<(), RunError> {
        if let Epoch::Running(_) = self.epoch {
            return Ok(());
        }
        self.world.advance_wall_tables();
        let motions = &self.world.motions;
        let mut fastest_squared = motions
            .iter()
            .map(|m| m.velocity.length_squared())
            .fold(0.0, f64::max);
        let fastest_spin = motions
            .iter()
            .map(|m| m.angular_velocity.abs())
            .fold(0.0, f64::max);
        // A sufficient test first: in most cases the fastest centre is fast enough.
        if fastest_squared < MIN_SPEED * MIN_SPEED
            && let Some((index, speed)) = too_slow(&self.world)
        {
            if self.comes_to_rest(speed) {
                self.stop_all();
                return self.begin_epoch(target);
            }
            let body = BodyName::new(&self.world.bodies[index], &self.names);
            return Err(RunError::TooSlow {
                time: self.world.epoch,
                body,
                speed,
            });
        }
        let moving = self
            .world
            .bodies
            .iter()
            .filter(|body| !body.is_fixed())
            .count() as u64;
        let contacts = self
            .contacts_per_epoch
            .saturating_mul(moving)
            .div_ceil(2)
            .max(1);
        let separation_error = separation_error(&self.world);
        if self.world.has_springs() {
            self.world.start_swings();
        }
        let longest_driven = self.world.longest_driven_epoch();
        if self.world.accelerates() {
            // The frame that falls gets that fast.
            let fastest =
                fastest_squared.sqrt() + longest_driven * self.world.largest_acceleration();
            fastest_squared = fastest * fastest;
        }
        // A wall near its turning point gets faster.
        let of_walls = self.world.fastest_oscillation();
        if self.world.is_sheared() {
            let fastest = fastest_squared.sqrt() + self.world.speed_of_images().abs();
            fastest_squared = fastest * fastest;
        }
        fastest_squared = fastest_squared.max(of_walls * of_walls);
        let mut limits = Limits::new(
            &self.world,
            separation_error,
            fastest_squared,
            fastest_spin,
            contacts,
        );
        limits.end_by(longest_driven.min(self.world.longest_sheared_epoch()));
        if self.world.moving_walls().next().is_some() {
            self.refuse_squeezed()?;
            limits.end_by(longest_sweep(&self.world));
            limits.end_by(self.meeting_of_walls(limits.time())?);
        }
        limits.end_by(self.world.next_change_of_walls());
        if self.world.accelerates() {
            self.ledger
                .restart_gravity(self.world.negative_potential_energy(0.0));
        }
        // A drag that ends the epoch lets no body move much farther, and the run ends.
        if limits.time() < longest_epoch(self.world.clock) {
            refuse_time_scales_too_far_apart(
                &self.world,
                &self.names,
                limits.time(),
                self.simultaneous.time,
                target,
            )?;
        }
        self.epoch = Epoch::Running(limits);
        self.counters.epochs += 1;
        self.scheduler.set_tiling(&self.tiling);
        self.scheduler
            .begin_epoch(&self.world, &self.detection, limits.time());
        Ok(())
    }

    /// The time of the first meeting of a wall that moves with a fixed body (offset in the epoch,
    /// time), if it is before `limit`; else any later time.
    fn meeting_of_walls(&mut self, limit: f64) -> Result<f64, RunError> {
        let limit = limit.min(self.world.next_change_of_walls());
        let apart_for = self.walls_meet_after.since(self.world.epoch);
        if limit < apart_for {
            return Ok(apart_for);
        }
        let meetings = first_meeting(&self.world, limit);
        match meetings.first {
            // Further meetings are searched for together, since an epoch may be short.
            None => {
                // Walls with tables have other velocities later, and walls that overlap may part.
                let horizon = EPOCHS_OF_SEARCH * limit;
                let are_lasting = self.world.wall_tables.is_empty() && !meetings.some_overlap;
                if are_lasting && first_meeting(&self.world, horizon).first.is_none() {
                    self.walls_meet_after = self.world.epoch.after(horizon);
                }
                Ok(limit)
            }
            Some(meeting) if meeting.time > 0.0 => Ok(meeting.time),
            Some(meeting) => {
                let [wall, other] = meeting
                    .bodies
                    .map(|body| BodyName::new(&self.world.bodies[body], &self.names));
                let (time, other) = (self.world.epoch, Box::new(other));
                Err(RunError::WallsMeet { time, wall, other })
            }
        }
    }

    /// Refuses to continue where walls have raised the energy beyond [`MAX_COMPRESSION`]; walls
    /// that come back may do so.
    fn refuse_squeezed(&self) -> Result<(), RunError> {
        let world = &self.world;
        let speed = |&wall: &usize| wall_speed(&world.bodies[wall], &world.motions[wall]);
        let fastest = world
            .moving_walls()
            .max_by(|one, other| speed(one).total_cmp(&speed(other)));
        let Some(fastest) = fastest
            .filter(|_| !world.is_driven() && !world.wall_tables.iter().any(|table| table.repeats))
        else {
            return Ok(());
        };
        let moving = world.bodies.iter().filter(|body| !body.is_fixed());
        let mass: f64 = moving.map(Body::mass).sum();
        let at_speed_of_wall = 0.5 * mass * speed(&fastest) * speed(&fastest);
        let Ledger {
            initial,
            put_in,
            heat,
            fallen,
            ..
        } = self.ledger;
        let given = put_in.max(0.0) + heat.max(0.0) + fallen.max(0.0);
        let limit = MAX_COMPRESSION * (initial + given + at_speed_of_wall);
        let energy = world.energy();
        if energy <= limit {
            return Ok(());
        }
        Err(RunError::Squeezed {
            time: world.epoch,
            wall: BodyName::new(&world.bodies[fastest], &self.names),
            energy,
            limit,
        })
    }

    /// Whether the fastest body, at this speed of centre or rim, comes to rest within the rounding
    /// of a position.
    fn comes_to_rest(&self, speed: f64) -> bool {
        let side = self.world.bounds.sides().min_element();
        let clock = self.world.clock;
        !clock.is_free() && speed / clock.drag() < HALF_ULP * side
    }

    /// Whether an epoch begins in which nothing moves, with a drag. Its clock would divide the rest
    /// of the run into epochs of ln 2/γ.
    fn rests_with_drag(&self) -> bool {
        !self.world.clock.is_free()
            && matches!(self.epoch, Epoch::ToBegin)
            && self.world.motions.iter().all(Motion::is_at_rest)
    }

    /// Lets time pass in which nothing moves. Contacts before then are as long ago as none.
    fn wait(&mut self, until: EpochTime) {
        self.world.epoch = until.new_epoch(0.0);
        self.world.last_contacts.fill(f64::NEG_INFINITY);
        (self.simultaneous, self.unresolved) =
            (SimultaneousContacts::default(), Unresolved::default());
    }

    /// Stops all bodies, which the drag has slowed to less than [`MIN_SPEED`].
    fn stop_all(&mut self) {
        for motion in &mut self.world.motions {
            *motion = motion.slowed(0.0);
        }
    }

    /// Ends the epoch with a contact at `time` (offset in the epoch).
    fn end_epoch_with_contact(&mut self, time: f64) {
        let Epoch::Running(limits) = self.epoch else {
            return;
        };
        self.store_motions();
        self.epoch = Epoch::ToBegin;
        // The scheduler's position of a body that has become this fast has too large a rounding
        // error.
        if let Some(contact) = limits.stale_contact() {
            for (&body, &position) in contact.bodies.iter().zip(&contact.places) {
                // Pistons are kept exactly, and a spring has another frame after the contact.
                let body_is = &self.world.bodies[body as usize];
                if !body_is.is_fixed() && !body_is.is_piston() {
                    let motion = &mut self.world.motions[body as usize];
                    *motion = Motion {
                        position,
                        ..motion.at(time)
                    };
                }
            }
        }
        self.end_epoch(time);
    }

    /// Moves all bodies to `offset` and makes it the start of the next epoch.
    pub(crate) fn end_epoch(&mut self, offset: f64) {
        self.store_motions();
        self.offset = offset;
        self.book_flight();
        self.world.rebase(offset);
        self.offset = 0.0;
        let clock = self.world.clock;
        self.simultaneous.rebase(offset, clock);
        self.unresolved.rebase(offset, clock);
        self.epoch = Epoch::ToBegin;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        cells::Instructions, grid::CellsPerSide, heap_scheduler::HeapScheduler, scene::Scene,
    };

    /// A dense gas; a dilute gas; molecules; and discs with a molecule and a bumper.
    const SCENES: [&str; 4] = [
        "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 1500",
        "[[gas]]\nradius = 0.001\nmass = 1.0\nenergy = 1.0\ncount = 1000",
        "[[gas]]\nshape = \"tee\"\natom_radius = 0.005\natom_mass = 1.0\nenergy = 1.0\ncount = 400",
        "[[molecule]]\nshape = \"tee\"\natom_radius = 0.05\natom_mass = 1.0\nat = [0.3, 0.3]\nvelocity = [3.0, 3.0]\n\
         [[bumper]]\nradius = 0.05\nat = [0.7, 0.7]\n\
         [[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 800",
    ];

    /// The bits of all motions and windings.
    fn bits<S: Scheduler>(simulation: &Simulation<Exact, Impact, S>) -> Vec<([u64; 7], [i64; 2])> {
        let world = &simulation.world;
        let of = |motion: &Motion| {
            let Motion {
                time,
                position,
                velocity,
                orientation,
                angular_velocity,
            } = motion;
            let [turn_x, turn_y] = [orientation.turns(), *angular_velocity];
            [
                *time, position.x, position.y, velocity.x, velocity.y, turn_x, turn_y,
            ]
            .map(f64::to_bits)
        };
        world
            .motions
            .iter()
            .map(of)
            .zip(world.windings.iter().copied())
            .collect()
    }

    fn check_steps<S: Scheduler + Clone>(options: &S::Options) {
        for scene in SCENES {
            let scene = Scene::from_toml(scene).unwrap();
            let mut simulation =
                Simulation::<_, _, S>::with(&scene, Exact::default(), Impact, options.clone())
                    .unwrap();
            let bodies = simulation.world.bodies.len();
            let (mut written, mut wraps, mut partial) = (0, 0, 0);
            for step in 0..3000 {
                let (epochs, before) = (simulation.counters.epochs, bits(&simulation));
                let mut marked = simulation.clone();
                // A write to a motion removes its mark.
                marked
                    .world
                    .motions
                    .iter_mut()
                    .for_each(|motion| motion.position.x += 1e3);
                assert!(simulation.step(1e9, &mut ()).unwrap());
                let stepped = bits(&simulation);
                if matches!(simulation.epoch, Epoch::Running(_)) {
                    // The reference: a copy of every body.
                    let mut copied = simulation.clone();
                    copied
                        .scheduler
                        .store(&mut StoredMotions::new(&mut copied.world));
                    assert!(stepped == bits(&copied), "step {step}");
                }
                // This also counts wraps before the first of these steps, where all bodies are
                // copied.
                wraps += before
                    .iter()
                    .zip(&stepped)
                    .filter(|(before, after)| before.1 != after.1)
                    .count();
                if simulation.counters.epochs > epochs || !matches!(marked.epoch, Epoch::Running(_))
                {
                    continue;
                }
                assert!(marked.step(1e9, &mut ()).unwrap());
                if !matches!(marked.epoch, Epoch::Running(_)) {
                    continue;
                }
                partial += 1;
                written += marked
                    .world
                    .motions
                    .iter()
                    .filter(|motion| motion.position.x < 5e2)
                    .count();
            }
            assert!(partial > 2500, "{partial}");
            // At most two bodies and those that have crossed the border of the box are written.
            assert!(
                wraps > 10 && written <= 2 * partial + wraps,
                "{written} of {bodies}: {partial}, {wraps}"
            );
        }
    }

    #[test]
    fn a_step_writes_only_changed_motions() {
        check_steps::<CellScheduler>(&Instructions::Widest);
        check_steps::<HeapScheduler>(&CellsPerSide::Automatic);
    }
}
