//! The simulation: it owns all state and runs from event to event.

use std::collections::BTreeMap;

use carom_detection::{Detection, Exact};
use carom_kinematics::{Inertia, Instant, Motion, kinetic_energy};
use carom_response::{ContactFrame, Elasticity, Impact, Response, struck};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    BodyName, Cells, CollisionReport, ContactEvent, Counters, ElasticityTable, Ledger, Observer, Parts,
    RunError, Scheduler, SchedulerCounters, Side, TagNames, View, World,
    guard::{Partner, note},
    wall::{arm, contact_frame},
};

/// Turns of the fastest rotor after which an epoch ends. Smaller: more epochs. Larger: angles lose digits.
const TURNS_PER_EPOCH: f64 = 64.0;

/// An epoch older than this many stretches of a body that has become so much faster ends with the contact that made it so:
/// at such a speed, the rounding of the time itself would be too coarse. Larger: places lose digits. Smaller: more epochs.
const STALE_STRETCHES: f64 = 4.0;

/// Contacts of one body at one instant after which a run counts as stalled. A body hit from all sides at once
/// needs a few; a fully inelastic pile needs more and more.
const MOST_CONTACTS_AT_ONCE: u32 = 1000;

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
        /// Square of the speed at which `limit` was set.
        fastest_squared: f64,
        /// Magnitude of the spin at which `limit` was set.
        fastest_spin: f64,
    },
}

/// Contacts at one instant, for each body that has had one since time last moved on.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct AtOnce {
    /// The instant, as an offset in the epoch.
    pub time: f64,
    pub counts: BTreeMap<u32, u32>,
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
        self.advance(until, u64::MAX, observer).map(|_| ())
    }

    /// Runs on to the next contact and through it, but not beyond `time`; tells whether there was one.
    ///
    /// # Errors
    /// As [`Self::run_until`].
    pub fn step<O: Observer>(&mut self, time: f64, observer: &mut O) -> Result<bool, RunError> {
        if !time.is_finite() {
            return Err(RunError::Time(time));
        }
        self.advance(Instant::from(time), 1, observer).map(|contacts| contacts == 1)
    }

    /// Runs to `until` or through so many contacts, whichever is first; tells how many there were.
    fn advance<O: Observer>(&mut self, until: Instant, most: u64, observer: &mut O) -> Result<u64, RunError> {
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
    pub fn observe_epoch<O: Observer>(&mut self, until: Instant, observer: &mut O) -> Result<bool, RunError> {
        self.advance_one_epoch(until, u64::MAX, &mut 0, observer)
    }

    /// Runs to the end of the epoch at most; tells whether `until`, or the last contact asked for, has been reached.
    fn advance_one_epoch<O: Observer>(
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
    fn advance_in_epoch<O: Observer>(
        &mut self,
        until: Instant,
        most: u64,
        contacts: &mut u64,
        observer: &mut O,
    ) -> Result<bool, RunError> {
        self.begin_epoch();
        let target = until.since(self.world.epoch);
        while let Epoch::Running { limit, .. } = self.epoch {
            match self.scheduler.next_contact(&self.world, &self.detection, target.min(limit)) {
                Some(contact) => {
                    self.resolve(contact, observer)?;
                    *contacts += 1;
                    if *contacts == most {
                        return Ok(true);
                    }
                }
                None if target < limit => {
                    self.offset = target;
                    return Ok(true);
                }
                None => {
                    let begun = self.world.epoch;
                    self.end_epoch(limit);
                    if self.world.epoch == begun {
                        return Err(RunError::TimeStandsStill { time: begun, stretch: limit });
                    }
                }
            }
        }
        Ok(false)
    }

    /// Brings the world up to date with the scheduler, whose motions are the true ones within an epoch.
    fn stand_by(&mut self) {
        if let Epoch::Running { .. } = self.epoch {
            self.scheduler.store(&mut self.world);
        }
        self.counters.scheduler = self.work_before + self.scheduler.counters();
    }

    /// Begins the epoch if it has not begun.
    fn begin_epoch(&mut self) {
        if let Epoch::Running { .. } = self.epoch {
            return;
        }
        let motions = &self.world.motions;
        let fastest_squared = motions.iter().map(|m| m.velocity.length_squared()).fold(0.0, f64::max);
        let fastest_spin = motions.iter().map(|m| m.angular_velocity.abs()).fold(0.0, f64::max);
        let limit = stretch(&self.world, fastest_squared, fastest_spin);
        let moving = self.world.bodies.iter().filter(|body| !body.is_fixed()).count() as u64;
        let contacts_left = (S::CONTACTS_PER_EPOCH * moving).div_ceil(2).max(1);
        self.epoch = Epoch::Running { limit, contacts_left, fastest_squared, fastest_spin };
        self.counters.epochs += 1;
        self.scheduler.begin_epoch(&self.world, &self.detection, limit);
    }

    /// Brings all bodies to `offset` and makes it the start of the next epoch.
    pub(crate) fn end_epoch(&mut self, offset: f64) {
        self.stand_by();
        self.world.rebase(offset);
        self.offset = 0.0;
        self.at_once.time -= offset;
        self.epoch = Epoch::ToBegin;
    }

    #[inline]
    fn resolve<O: Observer>(&mut self, contact: ContactEvent, observer: &mut O) -> Result<(), RunError> {
        self.offset = contact.time;
        self.bound_contacts_at_once(contact.bodies, contact.time)?;
        match contact.parts {
            Parts::Discs if self.elasticity.is_elastic() => self.resolve_discs(&contact, observer),
            _ => self.resolve_any(&contact, observer),
        }
    }

    /// The contact of two discs where all contacts are elastic: of what turns or loses energy, nothing is looked at.
    #[inline]
    fn resolve_discs<O: Observer>(
        &mut self,
        contact: &ContactEvent,
        observer: &mut O,
    ) -> Result<(), RunError> {
        let ContactEvent { time, bodies, image, .. } = *contact;
        let [a, b] = bodies;
        let [place_a, velocity_a] = self.scheduler.flight(a, time);
        let [place_b, velocity_b] = self.scheduler.flight(b, time);
        let (body_a, body_b) = (&self.world.bodies[a as usize], &self.world.bodies[b as usize]);
        let mut d = place_b - place_a;
        if image != [0, 0] {
            d += self.world.bounds.shift(image);
        }
        let inverse_masses = [body_a.kind.inertia.inverse_mass, body_b.kind.inertia.inverse_mass];
        let elasticity = Elasticity::ELASTIC;
        let impulse = self.response.impulse_of_discs(d, [velocity_a, velocity_b], inverse_masses, elasticity);
        let mut after = [velocity_a - impulse * inverse_masses[0], velocity_b + impulse * inverse_masses[1]];
        let met_fixed = (inverse_masses[0] == 0.0) | (inverse_masses[1] == 0.0);
        if met_fixed {
            after = reflect(&self.response, d, [velocity_a, velocity_b], inverse_masses);
        }
        self.epoch.accept(&self.world, &self.names, bodies, time, after, 0.0)?;
        self.counters.collisions += 1;
        self.counters.fixed_collisions += u64::from(met_fixed);
        if observer.is_watching() {
            let side = |body, position, before: DVec2, after| {
                let before = Motion { velocity: before, time, ..Motion::at_rest(position) };
                let after = Motion { velocity: after, ..before };
                Side { body, atom: Some(0), arm: DVec2::ZERO, before, after }
            };
            let normal = d.normalize_or(DVec2::X);
            observer.collision(&CollisionReport {
                time: self.world.epoch.after(time),
                sides: [
                    side(body_a, place_a, velocity_a, after[0]),
                    side(body_b, place_b, velocity_b, after[1]),
                ],
                point: place_a + body_a.kind.molecule.bounding_radius() * normal,
                normal,
                impulse,
                elasticity,
                image,
            });
        }
        let ended = self.epoch.count_contact();
        let flights = [[place_a, place_b], after];
        self.scheduler.flights_changed(&self.world, &self.detection, bodies, time, flights);
        if ended {
            self.end_epoch(time);
        }
        Ok(())
    }

    /// Any contact.
    #[inline(never)]
    fn resolve_any<O: Observer>(&mut self, contact: &ContactEvent, observer: &mut O) -> Result<(), RunError> {
        let ContactEvent { time, bodies, image, parts } = *contact;
        let [a, b] = bodies;
        let before = [self.scheduler.motion(a).at(time), self.scheduler.motion(b).at(time)];
        let (body_a, body_b) = (&self.world.bodies[a as usize], &self.world.bodies[b as usize]);
        let arms = match parts {
            Parts::Atoms(i, j) => [arm(body_a, i, &before[0]), arm(body_b, j, &before[1])],
            _ => [DVec2::ZERO; 2],
        };
        let mut d = (before[1].position - before[0].position) + (arms[1] - arms[0]);
        if image != [0, 0] {
            d += self.world.bounds.shift(image);
        }
        let between_centres = ContactFrame { line_of_centres: d, arms };
        let frame = contact_frame(&self.world, contact, &before).unwrap_or(between_centres);
        let arms = frame.arms;
        let mut elasticity = self.elasticity.between(body_a, body_b);
        if !self.world.last_contacts.is_empty() {
            let since = note(&mut self.world.last_contacts, bodies, time);
            if elasticity.coefficient() < 1.0 {
                let partner = |n: usize, body| Partner { body, motion: &before[n], since: since[n] };
                let pair = [partner(0, body_a), partner(1, body_b)];
                let (raised, spared) = self.elasticity.guard.raise(elasticity, &frame, pair);
                self.counters.guarded_collisions += u64::from(raised != elasticity);
                self.ledger.spared += spared;
                elasticity = raised;
            }
        }
        let (inertia_a, inertia_b) = (&body_a.kind.inertia, &body_b.kind.inertia);
        let impulse =
            self.response.impulse(&frame, [(&before[0], inertia_a), (&before[1], inertia_b)], elasticity);
        let mut after = [
            struck(&before[0], inertia_a, arms[0], -impulse),
            struck(&before[1], inertia_b, arms[1], impulse),
        ];
        let met_fixed = inertia_a.is_fixed() || inertia_b.is_fixed();
        let turns = |n: usize, inertia: &Inertia| {
            inertia.inverse_moment > 0.0 && arms[n].perp_dot(frame.line_of_centres) != 0.0
        };
        if met_fixed && elasticity == Elasticity::ELASTIC && !turns(0, inertia_a) && !turns(1, inertia_b) {
            let inverse_masses = [inertia_a.inverse_mass, inertia_b.inverse_mass];
            let velocities = before.map(|motion| motion.velocity);
            [after[0].velocity, after[1].velocity] =
                reflect(&self.response, frame.line_of_centres, velocities, inverse_masses);
        }
        let spin = after[0].angular_velocity.abs().max(after[1].angular_velocity.abs());
        self.epoch.accept(
            &self.world,
            &self.names,
            bodies,
            time,
            [after[0].velocity, after[1].velocity],
            spin,
        )?;
        self.counters.collisions += 1;
        self.counters.fixed_collisions += u64::from(met_fixed);
        if elasticity.coefficient() != 1.0 {
            let energy = |motions: &[Motion; 2]| {
                kinetic_energy(&motions[0], inertia_a) + kinetic_energy(&motions[1], inertia_b)
            };
            self.ledger.lost += energy(&before) - energy(&after);
        }
        if observer.is_watching() {
            let (atoms, radius) = parts.atoms_and_first_radius(body_a.molecule());
            let side = |n: usize, body| Side {
                body,
                atom: atoms[n],
                arm: arms[n],
                before: before[n],
                after: after[n],
            };
            let normal = frame.normal();
            observer.collision(&CollisionReport {
                time: self.world.epoch.after(time),
                sides: [side(0, body_a), side(1, body_b)],
                point: before[0].position + (arms[0] + radius * normal),
                normal,
                impulse,
                elasticity,
                image,
            });
        }
        let ended = self.epoch.count_contact();
        self.scheduler.motions_changed(&self.world, &self.detection, bodies, after);
        if ended {
            self.end_epoch(time);
        }
        Ok(())
    }

    /// Bounds the contacts of one body at one instant.
    fn bound_contacts_at_once(&mut self, bodies: [u32; 2], time: f64) -> Result<(), RunError> {
        if time > self.at_once.time {
            self.at_once.time = time;
            if !self.at_once.counts.is_empty() {
                self.at_once.counts.clear();
            }
            return Ok(());
        }
        self.count_contacts_at_once(bodies, time)
    }

    #[cold]
    fn count_contacts_at_once(&mut self, bodies: [u32; 2], time: f64) -> Result<(), RunError> {
        for index in bodies {
            let body = &self.world.bodies[index as usize];
            let contacts = self.at_once.counts.entry(index).or_default();
            *contacts += u32::from(!body.is_fixed());
            if *contacts > MOST_CONTACTS_AT_ONCE {
                let (time, contacts) = (self.world.epoch.after(time), *contacts);
                return Err(RunError::Stalled { time, body: BodyName::new(body, &self.names), contacts });
            }
        }
        Ok(())
    }
}

impl Epoch {
    /// Shortens the epoch if one of two bodies is now faster than any was before, and refuses what is too fast.
    #[inline]
    fn accept(
        &mut self,
        world: &World,
        names: &TagNames,
        bodies: [u32; 2],
        now: f64,
        velocities: [DVec2; 2],
        spin: f64,
    ) -> Result<(), RunError> {
        let Self::Running { fastest_squared, fastest_spin, .. } = self else { return Ok(()) };
        let speed_squared = velocities[0].length_squared().max(velocities[1].length_squared());
        // Written so that NaN counts as too fast.
        if (speed_squared <= *fastest_squared) & (spin <= *fastest_spin) {
            return Ok(());
        }
        self.shorten(world, now, speed_squared, spin);
        refuse_blow_up(world, names, bodies, now, velocities, spin)
    }

    #[cold]
    #[inline(never)]
    fn shorten(&mut self, world: &World, now: f64, speed_squared: f64, spin: f64) {
        let Self::Running { limit, contacts_left, fastest_squared, fastest_spin } = self else { return };
        (*fastest_squared, *fastest_spin) = (fastest_squared.max(speed_squared), fastest_spin.max(spin));
        let stretch = stretch(world, *fastest_squared, *fastest_spin);
        *limit = limit.min(now + stretch);
        if now > STALE_STRETCHES * stretch {
            *contacts_left = 1;
        }
    }

    /// Counts a contact; tells whether the epoch ends with it.
    #[inline]
    fn count_contact(&mut self) -> bool {
        let Self::Running { contacts_left, .. } = self else { return false };
        *contacts_left -= 1;
        *contacts_left == 0
    }
}

/// The velocities after an elastic contact with something fixed that turns neither body.
#[cold]
#[inline(never)]
fn reflect<R: Response>(
    response: &R,
    line_of_centres: DVec2,
    [velocity_a, velocity_b]: [DVec2; 2],
    [inverse_mass_a, inverse_mass_b]: [f64; 2],
) -> [DVec2; 2] {
    let of = |to_other: DVec2, velocity: DVec2, inverse_mass: f64| {
        if inverse_mass > 0.0 { response.reflected(to_other, velocity) } else { velocity }
    };
    [of(line_of_centres, velocity_a, inverse_mass_a), of(-line_of_centres, velocity_b, inverse_mass_b)]
}

/// How long a body of this speed and spin may fly before its place or angle has used up digits (time).
fn stretch(world: &World, speed_squared: f64, spin: f64) -> f64 {
    let side = world.bounds.sides().min_element();
    (side / speed_squared.sqrt()).min(TURNS_PER_EPOCH * std::f64::consts::TAU / spin)
}

#[cold]
#[inline(never)]
fn refuse_blow_up(
    world: &World,
    names: &TagNames,
    bodies: [u32; 2],
    now: f64,
    velocities: [DVec2; 2],
    spin: f64,
) -> Result<(), RunError> {
    for (body, velocity) in bodies.into_iter().zip(velocities) {
        let body = &world.bodies[body as usize];
        let speed = velocity.length() + spin * body.kind.molecule.bounding_radius();
        if !(speed <= carom_geometry::LARGEST && spin.is_finite()) {
            let (time, body) = (world.epoch.after(now), BodyName::new(body, names));
            return Err(RunError::BlowUp { time, body, speed });
        }
    }
    Ok(())
}
