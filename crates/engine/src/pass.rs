//! The loop through an epoch: contact after contact is resolved and handed back to the queue, until the time asked for or
//! the end of the epoch.

use std::collections::BTreeMap;

use carom_detection::Detection;
use carom_kinematics::{Inertia, Motion, kinetic_energy};
use carom_response::{ContactFrame, Elasticity, Response, struck};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    Body, BodyName, CollisionReport, ContactEvent, Counters, ElasticityTable, EventLoop, EventQueue, Ledger,
    Observer, Parts, RunError, Side, TagNames, World,
    guard::Partner,
    limits::{ContactPlaces, Limits},
    separation::{missing_impulse, round_outwards},
    wall::{arm, contact_frame},
};

/// Contacts of one body at one instant after which a run counts as stalled. A body hit from all sides at once
/// needs a few; a fully inelastic pile needs more and more.
const MOST_CONTACTS_AT_ONCE: u32 = 1000;

/// Contacts, without a guard, that rounding alone separates, after which their rate is looked at.
const MOST_UNRESOLVED: u32 = 100_000;

/// They count as a collapse if they have come within this share of a natural time of the pair, (R_A + R_B)/L. Bodies that rest
/// on each other and turn have some 10¹² of them in a natural time.
const COLLAPSE: f64 = 1e-4;

/// Contacts at one instant, for each body that has had one since time last moved on.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct AtOnce {
    /// The instant, as an offset in the epoch; that of the last edit, if there was no contact since.
    pub time: f64,
    pub counts: BTreeMap<u32, u32>,
    /// Contacts that rounding alone separated, and since when they are counted (offset in the epoch).
    pub unresolved: u32,
    pub unresolved_since: f64,
}

impl AtOnce {
    /// Counts a contact that rounding alone separates; returns whether so many have come in so short a time that bodies
    /// will have them without end.
    #[cold]
    fn collapses(&mut self, time: f64, bodies: [&Body; 2], motions: &[Motion; 2]) -> bool {
        if self.unresolved == 0 {
            self.unresolved_since = time;
        }
        self.unresolved += 1;
        if self.unresolved < MOST_UNRESOLVED {
            return false;
        }
        self.unresolved = 0;
        let radii = bodies.map(|body| body.kind.molecule.bounding_radius());
        let rims: f64 = [0, 1].map(|n: usize| motions[n].angular_velocity.abs() * radii[n]).iter().sum();
        let speed = (motions[1].velocity - motions[0].velocity).length() + rims;
        // A wall may be of any length.
        let radius = [0, 1].map(|n: usize| if bodies[n].is_wall() { 0.0 } else { radii[n] });
        (time - self.unresolved_since) * speed < COLLAPSE * (radius[0] + radius[1])
    }

    /// Moves the origin of time by `offset`.
    pub fn rebase(&mut self, offset: f64) {
        self.time -= offset;
        self.unresolved_since -= offset;
    }

    /// Begins anew at the start of the epoch, unless this is the instant already.
    pub fn begin(&mut self) {
        if self.time < 0.0 {
            *self = Self::default();
        }
    }
}

/// All that a contact may ask for or change, the queue of events apart.
pub(crate) struct Pass<'a, D, R, O> {
    pub world: &'a mut World,
    pub detection: &'a D,
    pub response: &'a R,
    pub elasticity: &'a ElasticityTable,
    pub names: &'a TagNames,
    pub counters: &'a mut Counters,
    pub ledger: &'a mut Ledger,
    pub at_once: &'a mut AtOnce,
    pub limits: &'a mut Limits,
    /// How far the epoch has been run (time).
    pub now: &'a mut f64,
    pub observer: &'a mut O,
    /// How far it is to be run (offset in the epoch, time).
    pub target: f64,
    /// Contacts so far, and how many there may be.
    pub contacts: &'a mut u64,
    pub most: u64,
}

/// How a pass ended.
pub(crate) enum Ended {
    /// The time that was asked for has been reached.
    AtTime,
    /// The last contact that was asked for has been reached; of these bodies.
    AtContact([u32; 2]),
    /// The epoch ends with the contact at this offset (time).
    WithContact(f64),
    /// The epoch ends at this offset (time).
    AtLimit(f64),
}

impl<D: Detection, R: Response, O: Observer> EventLoop for Pass<'_, D, R, O> {
    type End = Result<Ended, RunError>;

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled in one piece with the queue, with its instructions")]
    fn run<Q: EventQueue>(mut self, queue: &mut Q) -> Self::End {
        let all_elastic = self.elasticity.is_elastic() && self.response.conserves_energy(Elasticity::ELASTIC);
        loop {
            let limit = self.limits.time();
            let stop = if limit < self.target { limit } else { self.target };
            let Some(contact) = queue.next_contact(self.world, self.detection, stop) else {
                if self.target < limit {
                    *self.now = self.target;
                    return Ok(Ended::AtTime);
                }
                return Ok(Ended::AtLimit(limit));
            };
            let ContactEvent { time, bodies, .. } = contact;
            *self.now = time;
            let repeats = self.bound_contacts_at_once(bodies, time)?;
            if contact.parts == Parts::Discs && all_elastic && !repeats {
                let (a, b) = (queue.flight(bodies[0], time), queue.flight(bodies[1], time));
                let after = self.resolve_discs(contact, [a, b])?;
                let flights = [[a[0], b[0]], after];
                queue.flights_changed(self.world, self.detection, bodies, time, flights);
            } else {
                // One by one: `map` would take them through memory more than once.
                let before = [queue.motion(bodies[0]).at(time), queue.motion(bodies[1]).at(time)];
                let after = self.resolve(contact, before, repeats)?;
                queue.motions_changed(self.world, self.detection, bodies, after);
            }
            *self.contacts += 1;
            if self.limits.count_contact() {
                return Ok(Ended::WithContact(time));
            }
            if *self.contacts == self.most {
                return Ok(Ended::AtContact(bodies));
            }
        }
    }
}

impl<D, R: Response, O: Observer> Pass<'_, D, R, O> {
    /// The contact of two discs where all contacts are elastic, of which only the velocities change: of what turns or loses
    /// energy, nothing is looked at. Gives the velocities after it.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled in one piece with the queue, with its instructions")]
    fn resolve_discs(
        &mut self,
        contact: ContactEvent,
        [[place_a, velocity_a], [place_b, velocity_b]]: [[DVec2; 2]; 2],
    ) -> Result<[DVec2; 2], RunError> {
        let ContactEvent { time, bodies, image, inverse_mass, .. } = contact;
        let (a, b) = (bodies[0] as usize, bodies[1] as usize);
        let (body_a, body_b) = (&self.world.bodies[a], &self.world.bodies[b]);
        let mut d = place_b - place_a;
        if image != [0, 0] {
            d += self.world.bounds.shift(image);
        }
        let inverse_masses = inverse_mass.map_or_else(
            || [body_a.kind.inertia.inverse_mass, body_b.kind.inertia.inverse_mass],
            |inverse_mass| [inverse_mass; 2],
        );
        let elasticity = Elasticity::ELASTIC;
        let impulse = self.response.impulse_of_discs(d, [velocity_a, velocity_b], inverse_masses, elasticity);
        let mut after = [velocity_a - impulse * inverse_masses[0], velocity_b + impulse * inverse_masses[1]];
        let met_fixed = (inverse_masses[0] == 0.0) | (inverse_masses[1] == 0.0);
        if met_fixed {
            reflect(self.response, d, velocity_a, inverse_masses[0], &mut after[0]);
            reflect(self.response, -d, velocity_b, inverse_masses[1], &mut after[1]);
        }
        if !self.limits.hold(after) {
            let places = ContactPlaces { bodies, time, places: [place_a, place_b] };
            self.limits.accept(self.world, self.names, places, after, 0.0)?;
        }
        self.counters.collisions += 1;
        self.counters.fixed_collisions += u64::from(met_fixed);
        if self.observer.watches([body_a, body_b]) {
            let side = |body, position, before: DVec2, after| {
                let before = Motion { velocity: before, time, ..Motion::at_rest(position) };
                let after = Motion { velocity: after, ..before };
                Side { body, atom: Some(0), arm: DVec2::ZERO, before, after }
            };
            let normal = ContactFrame { line_of_centres: d, arms: [DVec2::ZERO; 2] }.normal();
            self.observer.collision(&CollisionReport {
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
        Ok(after)
    }

    /// Any contact; `repeats` if another has happened at the same instant. Returns the motions after it.
    #[inline(never)]
    fn resolve(
        &mut self,
        contact: ContactEvent,
        before: [Motion; 2],
        repeats: bool,
    ) -> Result<[Motion; 2], RunError> {
        let ContactEvent { time, bodies, image, parts, .. } = contact;
        let [body_a, body_b] = bodies.map(|body| &self.world.bodies[body as usize]);
        let arms = match parts {
            Parts::Atoms(i, j) => [arm(body_a, i, &before[0]), arm(body_b, j, &before[1])],
            _ => [DVec2::ZERO; 2],
        };
        let mut d = (before[1].position - before[0].position) + (arms[1] - arms[0]);
        if image != [0, 0] {
            d += self.world.bounds.shift(image);
        }
        let between_centres = ContactFrame { line_of_centres: d, arms };
        let (frame, distance) =
            contact_frame(self.world, &contact, &before).unwrap_or_else(|| (between_centres, d.length()));
        let depth = parts.contact_distance([body_a.molecule(), body_b.molecule()]) - distance;
        let arms = frame.arms;
        let mut elasticity = self.elasticity.between(body_a, body_b);
        let (mut is_guarded, mut spared) = (false, 0.0);
        if !self.world.last_contacts.is_empty() && elasticity.coefficient() < 1.0 {
            let last = &self.world.last_contacts;
            let partner = |n: usize, body| {
                let since = time - last[bodies[n] as usize];
                Partner { body, motion: &before[n], since }
            };
            let pair = [partner(0, body_a), partner(1, body_b)];
            let raised;
            (raised, spared) = self.elasticity.guard.raise(elasticity, &frame, pair);
            is_guarded = raised != elasticity;
            elasticity = raised;
        }
        let (inertia_a, inertia_b) = (&body_a.kind.inertia, &body_b.kind.inertia);
        let mut impulse =
            self.response.impulse(&frame, [(&before[0], inertia_a), (&before[1], inertia_b)], elasticity);
        let act = |impulse: DVec2| {
            [
                struck(&before[0], inertia_a, arms[0], -impulse),
                struck(&before[1], inertia_b, arms[1], impulse),
            ]
        };
        let mut after = act(impulse);
        let met_fixed = inertia_a.is_fixed() || inertia_b.is_fixed();
        let d = frame.line_of_centres;
        let turns = |n: usize, inertia: &Inertia| inertia.inverse_moment > 0.0 && arms[n].perp_dot(d) != 0.0;
        if met_fixed && elasticity == Elasticity::ELASTIC && !turns(0, inertia_a) && !turns(1, inertia_b) {
            let [a, b] = &mut after;
            reflect(self.response, d, before[0].velocity, inertia_a.inverse_mass, &mut a.velocity);
            reflect(self.response, -d, before[1].velocity, inertia_b.inverse_mass, &mut b.velocity);
        }
        let changes_energy = repeats || !self.response.conserves_energy(elasticity);
        if changes_energy {
            let (pair, [a, b], [c, d]) = ([body_a, body_b], &before, &after);
            if let Some(missing) = missing_impulse(self.world, &frame, parts, pair, [a, b], [c, d]) {
                impulse += missing;
                after = act(impulse);
                // A guard has had its say, or there is none: nothing else will end a collapse.
                let is_unguarded = self.world.last_contacts.is_empty() || elasticity == Elasticity::ELASTIC;
                if is_unguarded && self.at_once.collapses(time, pair, &before) {
                    return Err(self.stalled(bodies[0], time, MOST_UNRESOLVED));
                }
            }
        }
        let spin = after[0].angular_velocity.abs().max(after[1].angular_velocity.abs());
        let velocities = after.map(|motion| motion.velocity);
        let places = ContactPlaces { bodies, time, places: before.map(|motion| motion.position) };
        self.limits.accept(self.world, self.names, places, velocities, spin)?;
        // Counted and booked only now: a contact that is refused has not taken place.
        if !self.world.last_contacts.is_empty() {
            for body in bodies {
                self.world.last_contacts[body as usize] = time;
            }
        }
        self.counters.guarded_collisions += u64::from(is_guarded);
        self.ledger.spared += spared;
        self.counters.collisions += 1;
        self.counters.fixed_collisions += u64::from(met_fixed);
        if changes_energy {
            let energy = |motions: &[Motion; 2]| {
                kinetic_energy(&motions[0], inertia_a) + kinetic_energy(&motions[1], inertia_b)
            };
            self.ledger.lost += energy(&before) - energy(&after);
        }
        if self.observer.watches([body_a, body_b]) {
            let (atoms, radius) = parts.atoms_and_first_radius(body_a.molecule());
            let side = |n: usize, body| Side {
                body,
                atom: atoms[n],
                arm: arms[n],
                before: before[n],
                after: after[n],
            };
            let normal = frame.normal();
            self.observer.collision(&CollisionReport {
                time: self.world.epoch.after(time),
                sides: [side(0, body_a), side(1, body_b)],
                point: before[0].position + (arms[0] + radius * normal),
                normal,
                impulse,
                elasticity,
                image,
            });
        }
        round_outwards(self.world, depth, &frame, [inertia_a, inertia_b], &mut after);
        Ok(after)
    }

    /// Bounds the contacts of one body at one instant; returns whether there has been one at this instant already.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    fn bound_contacts_at_once(&mut self, bodies: [u32; 2], time: f64) -> Result<bool, RunError> {
        if time > self.at_once.time {
            self.at_once.time = time;
            if !self.at_once.counts.is_empty() {
                self.at_once.counts.clear();
            }
            return Ok(false);
        }
        self.count_contacts_at_once(bodies, time)?;
        Ok(true)
    }

    #[cold]
    #[inline(never)]
    fn count_contacts_at_once(&mut self, bodies: [u32; 2], time: f64) -> Result<(), RunError> {
        for index in bodies {
            let body = &self.world.bodies[index as usize];
            let contacts = self.at_once.counts.entry(index).or_default();
            *contacts += u32::from(!body.is_fixed());
            if *contacts > MOST_CONTACTS_AT_ONCE {
                let contacts = *contacts;
                return Err(self.stalled(index, time, contacts));
            }
        }
        Ok(())
    }

    fn stalled(&self, body: u32, time: f64, contacts: u32) -> RunError {
        let body = BodyName::new(&self.world.bodies[body as usize], self.names);
        RunError::Stalled { time: self.world.epoch.after(time), body, contacts }
    }
}

/// Replaces the velocity of a body after an elastic contact with a fixed one by a better rounded one, if the response has
/// it; a fixed body keeps its own.
#[cold]
#[inline(never)]
fn reflect<R: Response>(response: &R, to_other: DVec2, before: DVec2, inverse_mass: f64, after: &mut DVec2) {
    if inverse_mass == 0.0 {
        *after = before;
    } else if let Some(reflected) = response.reflected(to_other, before) {
        *after = reflected;
    }
}
