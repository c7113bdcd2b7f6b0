//! The simulation: it owns all state and runs from event to event.

use carom_detection::{Detection, Exact, Touch};
use carom_kinematics::{Instant, Motion, kinetic_energy};
use carom_response::{ContactFrame, Impact, Response, struck};
use glam::DVec2;

use crate::{
    CollisionReport, ContactEvent, Counters, ElasticityTable, Ledger, Observer, RunError, Scheduler, Side,
    TagNames, Thesis, View, World,
};

/// Contacts per moving body after which an epoch ends: times are small numbers, and everything is predicted
/// anew from the state alone. Smaller: more time goes into that. Larger: more dead events in the calendar.
const CONTACTS_PER_EPOCH: u64 = 8;

/// Turns of the fastest rotor after which an epoch ends. Smaller: more epochs. Larger: angles lose digits.
const TURNS_PER_EPOCH: f64 = 64.0;

/// Contacts of one body at one instant after which a run counts as stalled. A body hit from all sides at once
/// needs a few; a fully inelastic pile needs more and more.
const MOST_CONTACTS_AT_ONCE: u32 = 1000;

/// A system of rigid molecules in a periodic box, at some time.
///
/// Generic over its seams: how contacts are found (`D`), what they change (`R`), and how events are ordered
/// (`S`). See the [crate] for an example.
#[derive(Debug, Clone)]
pub struct Simulation<D = Exact, R = Impact, S: Scheduler = Thesis> {
    pub(crate) world: World,
    pub(crate) detection: D,
    pub(crate) response: R,
    pub(crate) scheduler: S,
    pub(crate) scheduler_options: S::Options,
    pub(crate) elasticity: ElasticityTable,
    pub(crate) names: TagNames,
    pub(crate) counters: Counters,
    pub(crate) ledger: Ledger,
    /// How far the present epoch has been run (time).
    pub(crate) offset: f64,
    pub(crate) epoch: Epoch,
    /// Contacts of each body since time last moved on for it.
    pub(crate) at_once: Vec<u32>,
}

/// The present epoch.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Epoch {
    /// It has not begun: everything is to be predicted.
    ToBegin,
    Running {
        /// When it ends at the latest: the fastest body has gone one side of the box by then.
        limit: f64,
        contacts_left: u64,
    },
}

impl<D: Detection, R: Response, S: Scheduler> Simulation<D, R, S> {
    /// The present time.
    pub fn time(&self) -> Instant {
        self.world.epoch.after(self.offset)
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
    pub fn observe_until<O: Observer>(&mut self, time: f64, observer: &mut O) -> Result<(), RunError> {
        if !time.is_finite() {
            return Err(RunError::Time(time));
        }
        self.observe_until_instant(Instant::from(time), observer)
    }

    /// Runs to an instant of any age and tells `observer` of each collision.
    ///
    /// # Errors
    /// As [`Self::run_until`].
    pub fn observe_until_instant<O: Observer>(
        &mut self,
        until: Instant,
        observer: &mut O,
    ) -> Result<(), RunError> {
        while self.advance(until, observer)? {}
        Ok(())
    }

    /// Runs on to the next contact and through it, but not beyond `time`; tells whether there was one.
    ///
    /// # Errors
    /// As [`Self::run_until`].
    pub fn step<O: Observer>(&mut self, time: f64, observer: &mut O) -> Result<bool, RunError> {
        if !time.is_finite() {
            return Err(RunError::Time(time));
        }
        self.advance(Instant::from(time), observer)
    }

    /// The next contact, if there is one no later than `until`.
    fn advance<O: Observer>(&mut self, until: Instant, observer: &mut O) -> Result<bool, RunError> {
        while until.since(self.world.epoch) >= self.offset {
            let limit = self.begin_epoch();
            let target = until.since(self.world.epoch);
            let next = self.scheduler.next_contact(&mut self.world, &self.detection, target.min(limit));
            self.counters.scheduler = self.scheduler.counters();
            match next {
                Some(contact) => return self.resolve(contact, observer).map(|()| true),
                None if target < limit => {
                    self.offset = target;
                    return Ok(false);
                }
                None => self.end_epoch(limit),
            }
        }
        Ok(false)
    }

    /// Begins the epoch if it has not begun; tells when it ends at the latest.
    fn begin_epoch(&mut self) -> f64 {
        match self.epoch {
            Epoch::Running { limit, .. } => limit,
            Epoch::ToBegin => {
                let limit =
                    self.world.motions.iter().map(|motion| self.stretch(motion)).fold(f64::INFINITY, f64::min);
                let moving = self.world.bodies.iter().filter(|body| !body.is_fixed()).count() as u64;
                self.epoch =
                    Epoch::Running { limit, contacts_left: (CONTACTS_PER_EPOCH * moving).div_ceil(2).max(1) };
                self.counters.epochs += 1;
                self.scheduler.begin_epoch(&self.world, &self.detection, limit);
                limit
            }
        }
    }

    /// How long a body may fly before its place or angle has used up digits (time).
    fn stretch(&self, motion: &Motion) -> f64 {
        let side = self.world.bounds.sides().min_element();
        let turns = TURNS_PER_EPOCH * std::f64::consts::TAU / motion.angular_velocity.abs();
        (side / motion.velocity.length()).min(turns)
    }

    /// Brings all bodies to `offset` and makes it the start of the next epoch.
    pub(crate) fn end_epoch(&mut self, offset: f64) {
        self.world.rebase(offset);
        self.offset = 0.0;
        self.epoch = Epoch::ToBegin;
    }

    fn resolve<O: Observer>(&mut self, contact: ContactEvent, observer: &mut O) -> Result<(), RunError> {
        let ContactEvent { time, bodies: [a, b], .. } = contact;
        let (a, b) = (a as usize, b as usize);
        self.offset = time;
        self.count_at_once([a, b], time)?;
        let before = [self.world.motions[a].at(time), self.world.motions[b].at(time)];
        let (body_a, body_b) = (&self.world.bodies[a], &self.world.bodies[b]);
        let shift = self.world.bounds.shift(contact.image);
        let (arms, radius) = arms(&self.world, &contact, &before);
        let d = ((before[1].position - before[0].position) + shift) + (arms[1] - arms[0]);
        let frame = ContactFrame { normal: d.try_normalize().unwrap_or(DVec2::X), arms };
        let elasticity = self.elasticity.between(body_a, body_b);
        let impulse = self.response.impulse(
            &frame,
            [(&before[0], &body_a.inertia), (&before[1], &body_b.inertia)],
            elasticity,
        );
        let after = [
            struck(&before[0], &body_a.inertia, arms[0], -impulse),
            struck(&before[1], &body_b.inertia, arms[1], impulse),
        ];
        self.counters.collisions += 1;
        self.counters.fixed_collisions += u64::from(body_a.is_fixed() || body_b.is_fixed());
        if elasticity.coefficient() != 1.0 {
            let energy = |motions: &[Motion; 2]| {
                kinetic_energy(&motions[0], &body_a.inertia) + kinetic_energy(&motions[1], &body_b.inertia)
            };
            self.ledger.lost += energy(&before) - energy(&after);
        }
        if O::WATCHES_COLLISIONS {
            let atoms = match contact.touch {
                Touch::Atoms(i, j) => [Some(i), Some(j)],
                Touch::BoundingCircles => [None; 2],
            };
            let side = |n: usize, body| Side {
                body,
                atom: atoms[n],
                arm: arms[n],
                before: before[n],
                after: after[n],
            };
            observer.collision(&CollisionReport {
                time: self.world.epoch.after(time),
                sides: [side(0, body_a), side(1, body_b)],
                point: before[0].position + (arms[0] + radius * frame.normal),
                normal: frame.normal,
                impulse,
                image: contact.image,
                touch: contact.touch,
            });
        }
        for (index, motion) in [(a, after[0]), (b, after[1])] {
            self.change_motion(index, motion)?;
        }
        self.after_contact([a, b], time);
        Ok(())
    }

    /// Gives a body a new motion from its subjective time on.
    fn change_motion(&mut self, index: usize, motion: Motion) -> Result<(), RunError> {
        let body = &mut self.world.bodies[index];
        if body.is_fixed() {
            return Ok(());
        }
        body.version = body.version.wrapping_add(1);
        let rim = motion.angular_velocity.abs() * body.molecule.bounding_radius();
        let speed = motion.velocity.length() + rim;
        if speed.is_finite() && speed <= carom_geometry::LARGEST {
            self.world.motions[index] = motion;
            Ok(())
        } else {
            Err(RunError::BlowUp { time: self.world.epoch.after(motion.time), body: body.key, speed })
        }
    }

    fn after_contact(&mut self, bodies: [usize; 2], now: f64) {
        let stretch = bodies.map(|body| self.stretch(&self.world.motions[body])).into_iter().fold(f64::MAX, f64::min);
        let Epoch::Running { limit, contacts_left } = &mut self.epoch else { return };
        *limit = limit.min(now + stretch);
        *contacts_left -= 1;
        if *contacts_left == 0 {
            self.end_epoch(now);
        } else {
            let bodies = bodies.map(|body| body as u32);
            self.scheduler.motions_changed(&self.world, &self.detection, bodies, now);
        }
    }

    /// Bounds the contacts of one body at one instant.
    fn count_at_once(&mut self, bodies: [usize; 2], time: f64) -> Result<(), RunError> {
        for body in bodies {
            if self.world.bodies[body].is_fixed() {
                continue;
            }
            let since = self.world.motions[body].time;
            self.at_once[body] = if time > since { 0 } else { self.at_once[body] + 1 };
            if self.at_once[body] > MOST_CONTACTS_AT_ONCE {
                return Err(RunError::Stalled {
                    time: self.world.epoch.after(time),
                    body: self.world.bodies[body].key,
                    contacts: self.at_once[body],
                });
            }
        }
        Ok(())
    }
}

/// Arms from the centres of mass to the touching parts, and the radius of the part of the first body.
fn arms(world: &World, contact: &ContactEvent, motions: &[Motion; 2]) -> ([DVec2; 2], f64) {
    let [first, second] = contact.bodies.map(|body| &world.bodies[body as usize].molecule);
    match contact.touch {
        Touch::BoundingCircles => ([DVec2::ZERO; 2], first.bounding_radius()),
        Touch::Atoms(i, j) => {
            let atoms = [&first.atoms()[i as usize], &second.atoms()[j as usize]];
            let arm = |n: usize| match atoms[n].arm() {
                0.0 => DVec2::ZERO,
                _ => motions[n].orientation.cos_sin().rotate(atoms[n].offset()),
            };
            ([arm(0), arm(1)], atoms[0].radius())
        }
    }
}
