//! The loop over the contacts of an epoch, until the target time or the end of the epoch: it
//! resolves each contact and passes the new motions to the queue.

#![allow(
    clippy::inline_always,
    reason = "compiled with the instructions of the caller"
)]

use carom_detection::{Detection, TetherBound};
use carom_kinematics::Motion;
use carom_response::{ContactFrame, Elasticity, Response, approach_speed, reduced_mass};
use glam::DVec2;

use crate::{
    contact::{
        contact_geometry::contact_geometry,
        elasticity_table::ElasticityTable,
        limits::{ContactPlaces, Limits},
        reaction_table::{PendingReaction, ReactantFate, ReactionOutcome, ReactionTable},
        resolution::{ContactPair, Resolved, ResolvedDiscs, Rules, SmoothDiscs},
        simultaneous_contacts::SimultaneousContacts,
        thermal_wall,
        unresolved::Unresolved,
    },
    run::observer::Observer,
    scene::error::{RunError, StallCause},
    scheduler::{ContactEvent, EventLoop, EventQueue, TouchingParts},
    world::{
        World,
        body::BodyName,
        counters::{Counters, Ledger},
        report::{CollisionReport, Side},
        tags::TagNames,
    },
};

/// The data that contacts read or change, apart from the event queue.
pub(crate) struct EpochLoop<'a, D, R> {
    pub world: &'a mut World,
    pub detection: &'a D,
    pub response: &'a R,
    pub elasticity: &'a ElasticityTable,
    pub names: &'a TagNames,
    pub counters: &'a mut Counters,
    pub ledger: &'a mut Ledger,
    pub simultaneous: &'a mut SimultaneousContacts,
    pub unresolved: &'a mut Unresolved,
    pub reactions: &'a mut ReactionTable,
    pub limits: &'a mut Limits,
    /// The present time, as an offset in the epoch.
    pub now: &'a mut f64,
    /// The observer, if it wants to know of contacts.
    pub observer: Option<&'a mut dyn Observer>,
    /// The target time, as an offset in the epoch.
    pub target: f64,
    /// Number of contacts so far, and its maximum.
    pub contacts: &'a mut u64,
    pub most: u64,
}

/// How the loop ended.
pub(crate) enum EpochEnd {
    /// The target time has been reached.
    TargetReached,
    /// The maximum number of contacts has been reached, with a contact of these bodies.
    AtContact([u32; 2]),
    /// The epoch ends with the contact at this offset (time).
    WithContact(f64),
    /// The epoch ends at this offset (time).
    AtLimit(f64),
}

impl<D: Detection, R: Response> EventLoop for EpochLoop<'_, D, R> {
    type End = Result<EpochEnd, RunError>;

    #[inline(always)]
    fn run<Q: EventQueue>(mut self, queue: &mut Q) -> Self::End {
        // Contacts are resolved in the laboratory, but flights of discs are those of the falling
        // frame. Reactions are decided where any contact is resolved, and so is the motion of
        // images; the guard, here that of bonds, counts all contacts.
        let is_sheared = self.world.is_sheared();
        let has_wells = self.world.has_wells();
        let is_special = self.world.has_special_contacts | is_sheared | has_wells;
        let all_elastic = self.rules().all_elastic()
            && self.world.last_contacts.is_empty()
            && !self.world.has_gravity()
            && !self.world.has_reactions
            && !is_sheared;
        let may_be_smooth = !all_elastic && !self.world.keeps_spins;
        loop {
            let limit = self.limits.time();
            let stop = if limit < self.target {
                limit
            } else {
                self.target
            };
            let Some(mut contact) = queue.next_contact(self.world, self.detection, stop) else {
                if self.target < limit {
                    *self.now = self.target;
                    return Ok(EpochEnd::TargetReached);
                }
                return Ok(EpochEnd::AtLimit(limit));
            };
            let ContactEvent { time, bodies, .. } = contact;
            *self.now = time;
            if has_wells {
                contact.parts = self.world.parts_of(&contact);
            }
            let repeats = self.simultaneous.repeats(bodies, time);
            if repeats {
                self.count_repeated(bodies, time)?;
            }
            if contact.parts == TouchingParts::Discs && all_elastic && !repeats {
                let inverse_masses = queue.inverse_masses(self.world, bodies);
                let (a, b) = (queue.flight(bodies[0], time), queue.flight(bodies[1], time));
                let resolved = self
                    .rules()
                    .resolve_discs(contact.image, [a, b], inverse_masses);
                self.record_discs(contact, [a, b], resolved)?;
                let flights = [[a[0], b[0]], resolved.after];
                queue.flights_changed(self.world, self.detection, bodies, time, flights);
            } else if contact.is_stop() {
                self.stop_piston(queue, contact);
            } else {
                // Two separate calls: with `map` the motions are copied through memory more than
                // once.
                let before = [
                    self.world
                        .motion_at(bodies[0], &queue.motion(bodies[0]), time),
                    self.world
                        .motion_at(bodies[1], &queue.motion(bodies[1]), time),
                ];
                let encounter = ContactPair {
                    contact,
                    before,
                    last_contacts: self.last_contacts(bodies),
                    repeats,
                };
                let is_smooth = contact.parts == TouchingParts::Discs
                    && may_be_smooth
                    && !repeats
                    && !(is_sheared && contact.image[1] != 0);
                let mut onwards =
                    if is_smooth && let Some(after) = self.resolve_smooth_discs(&encounter) {
                        after
                    } else {
                        self.resolve_any(&encounter, is_special)?
                    };
                if self.world.accelerates() {
                    onwards = [0, 1].map(|n| self.world.enter_own_frame(bodies[n], &onwards[n]));
                }
                queue.motions_changed(self.world, self.detection, bodies, onwards);
            }
            *self.contacts += 1;
            if self.limits.count_contact() {
                return Ok(EpochEnd::WithContact(time));
            }
            if *self.contacts == self.most {
                return Ok(EpochEnd::AtContact(bodies));
            }
        }
    }
}

impl<D, R: Response> EpochLoop<'_, D, R> {
    pub(crate) fn rules(&self) -> Rules<'_, R> {
        Rules {
            world: self.world,
            response: self.response,
            elasticity: self.elasticity,
            separation_error: self.limits.separation_error(),
        }
    }

    /// Resolves and records any contact in a system with thermal walls, reactions, wells or a
    /// shear, and decides whether the bodies react.
    #[inline(never)]
    fn resolve_special(&mut self, encounter: &ContactPair) -> Result<Resolved, RunError> {
        if let TouchingParts::Step(bound) = encounter.contact.parts {
            return self.reach_step(encounter, bound);
        }
        let resolved = if self.world.is_sheared() && encounter.contact.image[1] != 0 {
            self.resolve_through_seam(encounter)?
        } else {
            self.resolve_with_thermal_walls(encounter)?
        };
        let is_bond = matches!(encounter.contact.parts, TouchingParts::Bond(..));
        if self.world.has_reactions && !is_bond {
            self.react(encounter);
        }
        Ok(resolved)
    }

    /// Resolves and records the arrival of two discs at a step of their well.
    fn reach_step(
        &mut self,
        encounter: &ContactPair,
        bound: TetherBound,
    ) -> Result<Resolved, RunError> {
        let ContactEvent { time, bodies, .. } = encounter.contact;
        let ahead = self.world.step_ahead(bodies, bound);
        let (resolved, passes) = self.rules().resolve_step(encounter, bound, ahead);
        self.record(encounter, &resolved)?;
        self.counters.step_collisions += 1;
        if passes {
            self.world.shells.set(bodies, ahead.shell);
            let slowing = self.world.clock.slowing(time);
            self.ledger.book_step(ahead.gain, slowing);
        }
        Ok(resolved)
    }

    /// Decides whether the bodies of a contact react. New tags are given at once; a reaction that
    /// removes or replaces bodies ends the epoch, and is carried out before the next one begins.
    fn react(&mut self, encounter: &ContactPair) {
        let ContactPair {
            contact, before, ..
        } = encounter;
        let world = &*self.world;
        let pair = contact.bodies.map(|body| &world.bodies[body as usize]);
        let energy = || approach_energy(world, contact, before);
        let reaction = self.reactions.decide(
            pair,
            contact.bodies,
            energy,
            world.random_key,
            &mut self.counters.reactive_collisions,
        );
        let Some(reaction) = reaction else {
            return;
        };
        if let ReactionOutcome::Each([ReactantFate::Tag(one), ReactantFate::Tag(other)]) =
            reaction.outcome
        {
            let changes = reaction.bodies.into_iter().zip(reaction.tags);
            for ((body, from), to) in changes.zip([one, other]) {
                let kind = &mut self.world.bodies[body as usize].kind;
                self.reactions.relabel(kind, from, to);
            }
            self.reactions.records[reaction.record].counts.reactions += 1;
            self.counters.reactions += 1;
            return;
        }
        let [a, b] = before.map(|motion| motion.position);
        let mut separation = b + world.shift_of(contact) - a;
        if reaction.bodies != contact.bodies {
            separation = -separation;
        }
        let pending = PendingReaction::new(reaction, &world.bodies, separation);
        self.reactions.pending = Some(pending);
        self.limits.end_with_contact();
    }

    /// Resolves and records any contact in a system that may have thermal walls.
    fn resolve_with_thermal_walls(
        &mut self,
        encounter: &ContactPair,
    ) -> Result<Resolved, RunError> {
        let number = self.counters.thermal_collisions;
        // No bond ties a wall.
        let Some((resolved, heat)) = thermal_wall::resolve(&self.rules(), encounter, number) else {
            let resolved = self.rules().resolve(encounter);
            return self.record(encounter, &resolved).map(|()| resolved);
        };
        self.record(encounter, &resolved)?;
        self.counters.thermal_collisions += 1;
        let slowing = self.world.clock.slowing(encounter.contact.time);
        self.ledger.book_heat(heat, slowing);
        Ok(resolved)
    }

    /// Resolves and records the contact of a body with one of the next box above or below, whose
    /// images move.
    fn resolve_through_seam(&mut self, encounter: &ContactPair) -> Result<Resolved, RunError> {
        let faster = self.world.image_velocity(encounter.contact.image);
        let mut touched = *encounter;
        touched.before[1].velocity += faster;
        let mut resolved = self.rules().resolve(&touched);
        let second = &self.world.bodies[encounter.contact.bodies[1] as usize];
        let gained = |before: &Motion, after: &Motion| World::gained(second, before, after);
        let of_image = gained(&touched.before[1], &resolved.after[1]);
        resolved.after[1].velocity -= faster;
        resolved.onwards[1].velocity -= faster;
        let in_box = gained(&encounter.before[1], &resolved.after[1]);
        self.record(encounter, &resolved)?;
        self.ledger.sheared += in_box - of_image;
        Ok(resolved)
    }

    /// Reflects a piston at one of its stops, and books the energy lost.
    #[cold]
    #[inline(never)]
    fn stop_piston<Q: EventQueue>(&mut self, queue: &mut Q, stop: ContactEvent)
    where
        D: Detection,
    {
        let ContactEvent { time, bodies, .. } = stop;
        let piston = bodies[0];
        let before = self.world.motion_at(piston, &queue.motion(piston), time);
        let contact_time = self.elasticity.guard.contact_time;
        let (after, lost) = self.world.leave_stop(piston, &before, contact_time);
        self.ledger.book_loss(lost, self.world.clock.slowing(time));
        let onwards = self.world.enter_own_frame(piston, &after);
        queue.motion_changed(self.world, self.detection, piston, onwards);
    }

    /// Resolves and records any contact; returns the motions in the laboratory with which the two
    /// bodies go on.
    #[inline(always)]
    fn resolve_any(
        &mut self,
        encounter: &ContactPair,
        is_special: bool,
    ) -> Result<[Motion; 2], RunError> {
        if is_special {
            return self
                .resolve_special(encounter)
                .map(|resolved| resolved.onwards);
        }
        let resolved = self.rules().resolve(encounter);
        self.record(encounter, &resolved)?;
        Ok(resolved.onwards)
    }

    /// Resolves and records the contact of two discs without spins, if that takes no more than an
    /// impulse; returns the motions in the laboratory with which they go on.
    #[inline(never)]
    fn resolve_smooth_discs(&mut self, encounter: &ContactPair) -> Option<[Motion; 2]> {
        let ContactPair {
            contact,
            before,
            last_contacts,
            ..
        } = encounter;
        let SmoothDiscs {
            discs,
            after,
            elasticity,
            lost,
        } = self.rules().resolve_smooth_discs(encounter)?;
        let [of_a, of_b] = discs.after;
        if !self.limits.within(of_a, of_b) {
            return None;
        }
        self.count_discs(discs.met_fixed);
        if self.watches(contact.bodies) {
            self.report_discs(*contact, *before, discs, elasticity);
        }
        if last_contacts.is_some() {
            for body in contact.bodies {
                self.world.last_contacts[body as usize] = contact.time;
            }
        }
        let slowing = self.world.clock.slowing(contact.time);
        self.ledger.book_loss(lost, slowing);
        if self.world.has_reactions {
            self.react(encounter);
        }
        Some(after)
    }

    /// The times of the last contacts of two bodies; `None` without a guard.
    pub(crate) fn last_contacts(&self, bodies: [u32; 2]) -> Option<[f64; 2]> {
        let last = &self.world.last_contacts;
        (!last.is_empty()).then(|| bodies.map(|body| last[body as usize]))
    }

    /// Accepts the contact of two discs, counts it and reports it to the observer.
    #[inline(always)]
    pub(crate) fn record_discs(
        &mut self,
        contact: ContactEvent,
        flights: [[DVec2; 2]; 2],
        resolved: ResolvedDiscs,
    ) -> Result<(), RunError> {
        // All parts by themselves, and put together where they are needed: an array or a struct
        // whose address is passed on stays in memory for each contact, and is read as a whole
        // before its parts have reached the cache.
        let ContactEvent {
            time,
            bodies: [a, b],
            image: [across, up],
            parts,
        } = contact;
        let ResolvedDiscs {
            line_of_centres,
            impulse,
            after: [after_a, after_b],
            met_fixed,
        } = resolved;
        let [[place_a, velocity_a], [place_b, velocity_b]] = flights;
        if !self.limits.within(after_a, after_b) {
            let places = ContactPlaces {
                bodies: [a, b],
                time,
                places: [place_a, place_b],
            };
            self.limits
                .accept(self.world, self.names, places, [after_a, after_b], 0.0)?;
        }
        self.count_discs(met_fixed);
        if self.watches([a, b]) {
            let contact = ContactEvent {
                time,
                bodies: [a, b],
                image: [across, up],
                parts,
            };
            let motion = |position: DVec2, velocity: DVec2| Motion {
                velocity,
                time,
                ..Motion::at_rest(position)
            };
            let before = [motion(place_a, velocity_a), motion(place_b, velocity_b)];
            let after = [after_a, after_b];
            let resolved = ResolvedDiscs {
                line_of_centres,
                impulse,
                after,
                met_fixed,
            };
            self.report_discs(contact, before, resolved, Elasticity::ELASTIC);
        }
        Ok(())
    }

    #[inline(always)]
    fn count_discs(&mut self, met_fixed: bool) {
        self.counters.collisions += 1;
        self.counters.fixed_collisions += u64::from(met_fixed);
    }

    /// Whether the observer wants to know of contacts of these bodies.
    #[inline(always)]
    fn watches(&self, bodies: [u32; 2]) -> bool {
        let Some(observer) = &self.observer else {
            return false;
        };
        observer.watches(bodies.map(|body| &self.world.bodies[body as usize]))
    }

    /// Reports the contact of two discs to the observer.
    // By value: references would keep both in memory in the loop, for contacts that are not
    // reported.
    #[inline(never)]
    fn report_discs(
        &mut self,
        contact: ContactEvent,
        before: [Motion; 2],
        resolved: ResolvedDiscs,
        elasticity: Elasticity,
    ) {
        let ContactEvent {
            time,
            bodies,
            image,
            ..
        } = contact;
        let ResolvedDiscs {
            line_of_centres,
            impulse,
            after,
            ..
        } = resolved;
        let slowing = self.world.clock.slowing(time);
        let side = |n: usize| {
            let before = before[n].slowed(slowing);
            Side {
                body: &self.world.bodies[bodies[n] as usize],
                atom: Some(0),
                edge: None,
                arm: DVec2::ZERO,
                before,
                after: Motion {
                    velocity: after[n] * slowing,
                    ..before
                },
            }
        };
        let sides = [side(0), side(1)];
        let normal = ContactFrame {
            line_of_centres,
            arms: [DVec2::ZERO; 2],
        }
        .normal();
        let [first, second] = [sides[0].body, sides[1].body];
        let factor = self.world.pairs.factor(first, second);
        let radius = factor * first.kind.molecule.bounding_radius();
        let report = CollisionReport {
            time: self.world.time_at(time),
            point: before[0].position + radius * normal,
            sides,
            normal,
            impulse: impulse * slowing,
            drag: self.world.clock.drag(),
            elasticity,
            image,
            shift: self.world.bounds.shift(image),
            points: 1,
            bond: None,
            is_step: false,
            work: 0.0,
        };
        if let Some(observer) = &mut self.observer {
            observer.collision(&report);
        }
    }

    /// Accepts any contact, counts it, enters its energy into the ledger and reports it to the
    /// observer. A refused contact changes no motion, counter or ledger entry, and is not reported.
    #[inline(never)]
    pub(crate) fn record(
        &mut self,
        encounter: &ContactPair,
        resolved: &Resolved,
    ) -> Result<(), RunError> {
        let ContactPair {
            contact, before, ..
        } = encounter;
        let ContactEvent {
            time,
            bodies,
            image,
            parts,
        } = *contact;
        let pair = bodies.map(|body| &self.world.bodies[body as usize]);
        let Resolved { frame, after, .. } = resolved;
        if resolved.is_unresolved
            && let Some(contacts) = self.unresolved.count(time, pair, before)
        {
            return Err(self.stalled(bodies[0], time, contacts));
        }
        let spin = after[0]
            .angular_velocity
            .abs()
            .max(after[1].angular_velocity.abs());
        let velocities = [after[0].velocity, after[1].velocity];
        let places = ContactPlaces {
            bodies,
            time,
            places: [0, 1].map(|n| self.world.in_own_frame(bodies[n], &before[n]).position),
        };
        self.limits
            .accept(self.world, self.names, places, velocities, spin)?;
        // Surfaces do not touch at a step: it is no contact to the guard against collapse.
        let is_step = matches!(parts, TouchingParts::Step(_));
        if !is_step && !self.world.last_contacts.is_empty() {
            for body in bodies {
                self.world.last_contacts[body as usize] = time;
            }
        }
        self.counters.collisions += 1;
        self.counters.guarded_collisions += u64::from(resolved.spared.is_some());
        self.counters.fixed_collisions += u64::from(resolved.met_fixed);
        self.counters.joint_collisions += u64::from(resolved.points > 1);
        self.counters.bond_collisions += u64::from(matches!(parts, TouchingParts::Bond(..)));
        let slowing = self.world.clock.slowing(time);
        self.ledger.spared += resolved.spared.unwrap_or(0.0) * (slowing * slowing);
        self.ledger.book_loss(resolved.lost.unwrap_or(0.0), slowing);
        self.ledger.work += resolved.work;
        if let Some(observer) = &mut self.observer
            && observer.watches(pair)
        {
            let (atoms, radius) = parts.atoms_and_first_radius(pair[0].molecule());
            let edges = parts.edges();
            let side = |n: usize| Side {
                body: pair[n],
                atom: atoms[n],
                edge: edges[n],
                arm: frame.arms[n],
                before: before[n].slowed(slowing),
                after: after[n].slowed(slowing),
            };
            let normal = frame.normal();
            let factor = self.world.pairs.factor(pair[0], pair[1]);
            let to_surface = if resolved.is_rough {
                0.0
            } else {
                factor * radius
            };
            observer.collision(&CollisionReport {
                time: self.world.time_at(time),
                sides: [side(0), side(1)],
                point: before[0].position + (frame.arms[0] + to_surface * normal),
                normal,
                impulse: resolved.impulse * slowing,
                elasticity: resolved.elasticity,
                image,
                shift: self.world.shift_of(contact),
                points: resolved.points,
                bond: match parts {
                    TouchingParts::Bond(bond, _) => Some(bond),
                    _ => None,
                },
                is_step,
                work: resolved.work,
                drag: self.world.clock.drag(),
            });
        }
        Ok(())
    }

    /// Counts a contact that follows another at the same instant; an error if a body has too many.
    #[cold]
    #[inline(never)]
    fn count_repeated(&mut self, bodies: [u32; 2], time: f64) -> Result<(), RunError> {
        self.counters.simultaneous_collisions += 1;
        match self.simultaneous.count(bodies, &self.world.bodies) {
            Some((body, contacts)) => Err(self.stalled(body, time, contacts)),
            None => Ok(()),
        }
    }

    fn stalled(&self, body: u32, time: f64, contacts: u32) -> RunError {
        let body = BodyName::new(&self.world.bodies[body as usize], self.names);
        RunError::Stalled {
            time: self.world.time_at(time),
            body,
            contacts,
            cause: self.stall_cause(),
        }
    }

    fn stall_cause(&self) -> StallCause {
        let loses =
            self.elasticity.loses_energy() || !self.response.conserves_energy(Elasticity::ELASTIC);
        match (loses, self.elasticity.guard.contact_time > 0.0) {
            (false, _) => StallCause::NoFreeSpace,
            (true, false) => StallCause::InelasticCollapse,
            (true, true) => StallCause::GuardedCollapse,
        }
    }
}

/// The energy of the approach of two surfaces along the normal, ½ μ u² (mass × length² / time²).
fn approach_energy(world: &World, contact: &ContactEvent, before: &[Motion; 2]) -> f64 {
    let (frame, _) = contact_geometry(world, contact, before);
    let inertias = contact
        .bodies
        .map(|body| world.bodies[body as usize].inertia());
    // Velocities are those of the clock of the drag.
    let slowing = world.clock.slowing(contact.time);
    let speed = slowing * approach_speed(&frame, [&before[0], &before[1]]);
    0.5 * reduced_mass(&frame, inertias) * (speed * speed)
}
