//! The effect of a contact on its two bodies: a pure function of their motions and of the rules.
//!
//! Nothing here changes state, and the result of a [`Response`] depends on its arguments alone.
//! Contacts of different bodies can therefore be resolved in any order or in parallel. The changes
//! are recorded afterwards, in order of time (see [`crate::epoch_loop`]).

#![allow(
    clippy::inline_always,
    reason = "compiled with the instructions of the caller"
)]

use carom_detection::TetherBound;
use carom_kinematics::{Inertia, Motion, RelativeMotion, kinetic_energy};
use carom_response::{
    ContactFrame, Elasticity, Impact, Response, apply_impulse, approach_speed, impulse_at_step,
    reduced_mass,
};
use glam::DVec2;

use crate::{
    contact::{
        contact_geometry::contact_geometry,
        elasticity_table::ElasticityTable,
        guard::Partner,
        joint_contact::{JointContact, joint_contact, may_be_joint},
        separation::{
            is_deep, least_speed_at_step, least_speed_of_discs, missing_impulse, round_outwards,
        },
    },
    world::{
        World,
        body::Body,
        contact_event::{ContactEvent, TouchingParts},
        wells::StepAhead,
    },
};

/// The rules that determine the outcome of a contact, in addition to the motions of its two bodies.
pub(crate) struct Rules<'a, R> {
    pub world: &'a World,
    pub response: &'a R,
    pub elasticity: &'a ElasticityTable,
    /// Bound on the rounding of a separation in the epoch (length).
    pub separation_error: f64,
}

/// A contact of any two bodies, just before it takes place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPair {
    pub contact: ContactEvent,
    /// The motions at the time of the contact.
    pub before: [Motion; 2],
    /// The times of the two bodies' last contacts (offset in the epoch); `None` without a guard.
    pub last_contacts: Option<[f64; 2]>,
    /// Whether another contact has happened at the same instant.
    pub repeats: bool,
}

/// The outcome of a contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Resolved {
    pub frame: ContactFrame,
    pub elasticity: Elasticity,
    /// On the second body (mass × length / time).
    pub impulse: DVec2,
    /// The motions just after the contact, at the same positions.
    pub after: [Motion; 2],
    /// The motions with which the run continues: `after`, with positions rounded outwards if the
    /// bodies overlap.
    pub onwards: [Motion; 2],
    /// Kinetic energy that the contact would have lost in addition without the guard against
    /// inelastic collapse; `None` if the guard changes nothing.
    pub spared: Option<f64>,
    /// Kinetic energy lost; `None` if the response conserves it.
    pub lost: Option<f64>,
    /// Work of a wall that moves on the body that touches it (mass × length² / time²); 0 without
    /// one.
    pub work: f64,
    /// Whether one of the two bodies is fixed.
    pub met_fixed: bool,
    /// Whether rounding alone separates the surfaces, and no guard prevents more such contacts.
    pub is_unresolved: bool,
    /// Number of points at which the two bodies touch, if the impulse takes them all into account.
    pub points: u32,
    /// Whether the arms of the frame end at the point of contact, because the impulse may have a
    /// tangential part.
    pub is_rough: bool,
}

/// The outcome of a contact of two discs where all contacts are elastic.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ResolvedDiscs {
    /// From the centre of the first disc to that of the touched image of the second (length).
    pub line_of_centres: DVec2,
    /// On the second body (mass × length / time).
    pub impulse: DVec2,
    /// The velocities after the contact.
    pub after: [DVec2; 2],
    /// Whether one of the two bodies is fixed.
    pub met_fixed: bool,
}

/// The outcome of a contact of two discs without spins.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SmoothDiscs {
    pub discs: ResolvedDiscs,
    /// The motions just after the contact, with which the run continues.
    pub after: [Motion; 2],
    pub elasticity: Elasticity,
    /// Kinetic energy lost (mass × length² / time²).
    pub lost: f64,
}

impl<R: Response> Rules<'_, R> {
    /// Whether every contact of two bodies of the table is smooth and conserves the energy, and no
    /// disc has a spin.
    pub fn all_elastic(&self) -> bool {
        self.elasticity.is_elastic()
            && self.response.conserves_energy(Elasticity::ELASTIC)
            && !self.response.is_rough(Elasticity::ELASTIC)
            && !self.world.keeps_spins
    }

    /// Resolves the contact of two discs where all contacts are elastic: only velocities change.
    /// `flights` are the positions and velocities of the two at the time of the contact.
    #[inline(always)]
    pub fn resolve_discs(
        &self,
        image: [i64; 2],
        [[place_a, velocity_a], [place_b, velocity_b]]: [[DVec2; 2]; 2],
        inverse_masses: [f64; 2],
    ) -> ResolvedDiscs {
        let mut d = place_b - place_a;
        if image != [0, 0] {
            d += self.world.bounds.shift(image);
        }
        let velocities = [velocity_a, velocity_b];
        let impulse =
            self.response
                .impulse_of_discs(d, velocities, inverse_masses, Elasticity::ELASTIC);
        // By value: a velocity whose address is taken is copied through memory for each contact.
        let mut after_a = velocity_a - impulse * inverse_masses[0];
        let mut after_b = velocity_b + impulse * inverse_masses[1];
        let met_fixed = (inverse_masses[0] == 0.0) | (inverse_masses[1] == 0.0);
        // Discs of infinite mass are at rest.
        if met_fixed {
            after_a = self.reflected(d, velocity_a, inverse_masses[0], after_a);
            after_b = self.reflected(-d, velocity_b, inverse_masses[1], after_b);
        }
        ResolvedDiscs {
            line_of_centres: d,
            impulse,
            after: [after_a, after_b],
            met_fixed,
        }
    }

    /// Resolves the contact of two discs without spins, to the bit as [`Self::resolve`] does.
    /// `None` if it needs more than an impulse: with a fixed body, a rough contact, one whose
    /// elasticity depends on the speed, one that the guard spares, one that loses energy under a
    /// force, or where rounding has to be corrected.
    #[inline(never)]
    pub fn resolve_smooth_discs(&self, encounter: &ContactPair) -> Option<SmoothDiscs> {
        let ContactPair {
            contact,
            before,
            last_contacts,
            ..
        } = encounter;
        let [a, b] = contact.bodies.map(|body| &self.world.bodies[body as usize]);
        let elasticity = self.elasticity.at_any_speed(a, b)?;
        let inertias = [&a.kind.inertia, &b.kind.inertia];
        let met_fixed = inertias[0].is_fixed() || inertias[1].is_fixed();
        if met_fixed || !elasticity.is_smooth() || self.response.is_rough(elasticity) {
            return None;
        }
        let velocities = before.map(|motion| motion.velocity);
        let radii = [a, b].map(|body| body.molecule().bounding_radius());
        if let Some(last) = last_contacts
            && elasticity.coefficient() < 1.0
        {
            if self.world.accelerates() {
                return None;
            }
            let duration = |time: f64| self.world.clock.duration(time);
            let since = last.map(|last| duration(contact.time) - duration(last));
            let relative = velocities[1] - velocities[0];
            let guard = self.elasticity.guard;
            if guard.raises_for_discs(radii, relative, since) {
                return None;
            }
        }
        let mut d = before[1].position - before[0].position;
        if contact.image != [0, 0] {
            d += self.world.bounds.shift(contact.image);
        }
        let frame = ContactFrame {
            line_of_centres: d,
            arms: [DVec2::ZERO; 2],
        };
        let with_inertia = [(&before[0], inertias[0]), (&before[1], inertias[1])];
        let impulse = self.response.impulse(&frame, with_inertia, elasticity);
        let after = pushed(&frame, before, inertias, impulse);
        let rounding = RelativeMotion::velocity_error_of(velocities);
        // The margin exceeds the rounding of this speed.
        let is_parting =
            approach_speed(&frame, [&after[0], &after[1]]) < -2.0 * least_speed_of_discs(rounding);
        let contact_distance = self.world.pairs.factor(a, b) * (radii[0] + radii[1]);
        if !is_parting || is_deep(self.world, contact_distance - d.length()) {
            return None;
        }
        let lost = if self.response.conserves_energy(elasticity) {
            0.0
        } else {
            energy_of(before, inertias) - energy_of(&after, inertias)
        };
        Some(SmoothDiscs {
            discs: ResolvedDiscs {
                line_of_centres: d,
                impulse,
                after: after.map(|motion| motion.velocity),
                met_fixed,
            },
            after,
            elasticity,
            lost,
        })
    }

    /// The acceleration of the second body relative to the first (length / time²).
    fn fall(&self, bodies: [u32; 2]) -> DVec2 {
        let [of_first, of_second] = bodies.map(|body| {
            if self.world.bodies[body as usize].is_fixed() {
                DVec2::ZERO
            } else {
                self.world.acceleration(body as usize)
            }
        });
        of_second - of_first
    }

    /// Resolves any contact.
    #[inline(never)]
    pub fn resolve(&self, encounter: &ContactPair) -> Resolved {
        let ContactPair {
            contact,
            before,
            last_contacts,
            repeats,
        } = encounter;
        let ContactEvent {
            time,
            bodies,
            parts,
            ..
        } = *contact;
        let pair = bodies.map(|body| &self.world.bodies[body as usize]);
        let (frame, depth) = contact_geometry(self.world, contact, before);
        let (of_table, mut frame) = self.law(contact, frame, before);
        let is_rough = self.response.is_rough(of_table);
        let slowing = || self.world.clock.slowing(time);
        let mut elasticity = of_table;
        if let Some(last) = last_contacts
            && of_table.coefficient() < 1.0
        {
            let partner = |n: usize| Partner {
                body: pair[n],
                motion: &before[n],
                since: self.world.clock.duration(time) - self.world.clock.duration(last[n]),
            };
            let guard = self.elasticity.guard;
            let partners = [partner(0), partner(1)];
            let raised = guard.raise(of_table, (&frame, parts), partners, self.fall(bodies));
            elasticity = raised.unwrap_or(of_table);
        }
        let inertias = pair.map(|body| &body.kind.inertia);
        let with_inertia = [(&before[0], inertias[0]), (&before[1], inertias[1])];
        let mut impulse = self.response.impulse(&frame, with_inertia, elasticity);
        let mut after = self.act(&frame, before, inertias, impulse, elasticity);
        let mut spared = None;
        if elasticity != of_table {
            spared = self.spared(&frame, before, inertias, of_table, (impulse, &after));
        }
        let energy = |motions: &[Motion; 2]| energy_of(motions, inertias);
        let mut points = 1;
        if !is_rough
            && may_be_joint(pair, parts)
            && let Some(joint) = self.joint(encounter, &frame, with_inertia, elasticity)
        {
            if elasticity != of_table {
                let unguarded = self.joint(encounter, &frame, with_inertia, of_table);
                spared = unguarded.map(|unguarded| energy(&joint.after) - energy(&unguarded.after));
            }
            (frame, impulse, after, points) =
                (joint.frame, joint.impulse, joint.after, joint.points);
        }
        let changes_energy = *repeats || !self.response.conserves_energy(elasticity);
        let mut is_unresolved = false;
        if changes_energy
            && let Some(missing) = missing_impulse(
                self.world,
                self.separation_error,
                &frame,
                (parts, pair),
                [&before[0], &before[1]],
                [&after[0], &after[1]],
            )
        {
            impulse += missing;
            // The resultant of several points that cancel out has no frame.
            after = if points > 1 {
                pushed(&frame, &after, inertias, missing)
            } else {
                pushed(&frame, before, inertias, impulse)
            };
            // The guard has already acted, or there is none: nothing else ends a collapse.
            is_unresolved = last_contacts.is_none() || elasticity == Elasticity::ELASTIC;
        }
        let met_fixed = inertias[0].is_fixed() || inertias[1].is_fixed();
        // Impulses at several points of a wall that turns act on surfaces of different velocities;
        // no energy is then booked as lost.
        let turns = |n: usize| inertias[n].is_fixed() && before[n].angular_velocity != 0.0;
        let work = match met_fixed {
            true if points > 1 && (turns(0) || turns(1)) => energy(&after) - energy(before),
            true => work_of_wall(&frame, before, inertias, impulse),
            false => 0.0,
        };
        let lost = changes_energy.then(|| energy(before) + work - energy(&after));
        let mut onwards = after;
        round_outwards(self.world, contact, depth, &frame, inertias, &mut onwards);
        Resolved {
            frame,
            elasticity: elasticity.with_kick_times(slowing()),
            impulse,
            after,
            onwards,
            spared,
            lost,
            work,
            met_fixed,
            is_unresolved,
            points,
            is_rough,
        }
    }

    /// Resolves the arrival of two discs at the range of a step of their well, and returns whether
    /// they pass it.
    ///
    /// Along the line of centres, the speed u of approach to the range becomes √(u² + 2 ΔE/μ), with
    /// the kinetic energy ΔE that the pair gains and its reduced mass μ; if that is not real, the
    /// pair bounces back (B. J. Alder and T. E. Wainwright, J. Chem. Phys. 31 (1959) 459).
    #[cold]
    #[inline(never)]
    pub fn resolve_step(
        &self,
        encounter: &ContactPair,
        bound: TetherBound,
        ahead: StepAhead,
    ) -> (Resolved, bool) {
        let ContactPair {
            contact, before, ..
        } = encounter;
        let bodies = contact.bodies.map(|body| &self.world.bodies[body as usize]);
        let inertias = bodies.map(|body| &body.kind.inertia);
        let between = (before[1].position - before[0].position) + self.world.shift_of(contact);
        let frame = ContactFrame {
            line_of_centres: match bound {
                TetherBound::Shortest => between,
                TetherBound::Longest => -between,
            },
            arms: [DVec2::ZERO; 2],
        };
        // Velocities are those of the clock of the drag; the energies of steps are true ones.
        let slowing = self.world.clock.slowing(contact.time);
        let gain = ahead.gain / (slowing * slowing);
        let velocities = [before[0].velocity, before[1].velocity];
        let inverse_masses = inertias.map(|inertia| inertia.inverse_mass);
        let line = frame.line_of_centres;
        let over = impulse_at_step(line, velocities, inverse_masses, gain);
        let (impulse, after, lost) = match over {
            Some(impulse) => (impulse, pushed(&frame, before, inertias, impulse), None),
            None => self.bounce_off_step(encounter, &frame, inertias, bound),
        };
        let resolved = Resolved {
            frame,
            elasticity: Elasticity::ELASTIC,
            impulse,
            after,
            onwards: after,
            spared: None,
            lost,
            work: 0.0,
            met_fixed: inertias[0].is_fixed() || inertias[1].is_fixed(),
            is_unresolved: false,
            points: 1,
            is_rough: false,
        };
        (resolved, over.is_some())
    }

    /// The impulse on the second of two discs that bounce back from a step of their well, the
    /// motions after it, and the energy that they lose there (mass × length² / time²): none, unless
    /// they must leave faster than they have come to be seen to leave.
    fn bounce_off_step(
        &self,
        ContactPair {
            contact, before, ..
        }: &ContactPair,
        frame: &ContactFrame,
        inertias: [&Inertia; 2],
        bound: TetherBound,
    ) -> (DVec2, [Motion; 2], Option<f64>) {
        let approach = approach_speed(frame, [&before[0], &before[1]]).max(0.0);
        let least = least_speed_at_step(self.world, contact, bound, before);
        if approach >= least {
            let velocities = [before[0].velocity, before[1].velocity];
            let inverse_masses = inertias.map(|inertia| inertia.inverse_mass);
            let (line, law) = (frame.line_of_centres, Elasticity::ELASTIC);
            let impulse = Impact.impulse_of_discs(line, velocities, inverse_masses, law);
            let after = self.act(frame, before, inertias, impulse, law);
            return (impulse, after, Some(0.0));
        }
        let mass = reduced_mass(frame, inertias);
        let lost = 0.5 * mass * (approach * approach - least * least);
        let impulse = mass * (approach + least) * frame.normal();
        let after = pushed(frame, before, inertias, impulse);
        (impulse, after, Some(lost))
    }

    /// The elasticity of a contact by the rules, and its frame with arms to the point of contact if
    /// it is rough.
    #[inline]
    fn law(
        &self,
        contact: &ContactEvent,
        frame: ContactFrame,
        before: &[Motion; 2],
    ) -> (Elasticity, ContactFrame) {
        if let TouchingParts::Bond(bond, _) = contact.parts {
            return (self.world.bonds()[bond as usize].elasticity, frame);
        }
        let pair = contact.bodies.map(|body| &self.world.bodies[body as usize]);
        // Velocities are those of the clock of the drag; speeds and kicks of rules are true ones.
        let slowing = || self.world.clock.slowing(contact.time);
        let approach = || slowing() * approach_speed(&frame, [&before[0], &before[1]]);
        let mut of_table = self.elasticity.of_contact(pair[0], pair[1], approach);
        if of_table.kick() != 0.0 {
            of_table = of_table.with_kick_times(1.0 / slowing());
        }
        if !self.response.is_rough(of_table) {
            return (of_table, frame);
        }
        let factor = self.world.pairs.factor(pair[0], pair[1]);
        let reaches = contact.parts.reaches(pair.map(Body::molecule));
        (
            of_table,
            frame.extended_to_surfaces(reaches.map(|reach| factor * reach)),
        )
    }

    /// The outcome of a contact at several points, whose first is that of `frame`; `None` if there
    /// is one, or if the response resolves them one by one.
    fn joint(
        &self,
        encounter: &ContactPair,
        frame: &ContactFrame,
        bodies: [(&Motion, &Inertia); 2],
        elasticity: Elasticity,
    ) -> Option<JointContact> {
        let ContactPair {
            contact, before, ..
        } = encounter;
        let impulses =
            |frames: &[ContactFrame]| self.response.joint_impulses(frames, bodies, elasticity);
        let inertias = bodies.map(|(_, inertia)| inertia);
        joint_contact(
            self.world,
            contact,
            (before, inertias),
            frame,
            self.separation_error,
            impulses,
        )
    }

    /// The energy that the guard has saved, if the response depends on the guard: `impulse` and
    /// motions `after` are those with the raised elasticity.
    #[cold]
    #[inline(never)]
    fn spared(
        &self,
        frame: &ContactFrame,
        before: &[Motion; 2],
        inertias: [&Inertia; 2],
        of_table: Elasticity,
        (impulse, after): (DVec2, &[Motion; 2]),
    ) -> Option<f64> {
        let bodies = [(&before[0], inertias[0]), (&before[1], inertias[1])];
        let unguarded = self.response.impulse(frame, bodies, of_table);
        if unguarded == impulse {
            return None;
        }
        // The work of an impulse is its product with the mean velocity of the surfaces. A
        // difference of kinetic energies has a rounding error far larger than the energy saved in a
        // slow contact.
        let work = |impulse: DVec2, after: &[Motion; 2]| {
            let velocities = surface_velocity(frame, before) + surface_velocity(frame, after);
            0.5 * impulse.dot(velocities)
        };
        let without = self.act(frame, before, inertias, unguarded, of_table);
        Some(work(impulse, after) - work(unguarded, &without))
    }

    /// The motions after an impulse on the second body. A body that does not turn and meets a fixed
    /// body elastically gets the velocity of a reflection, which is rounded less, if the response
    /// provides one.
    fn act(
        &self,
        frame: &ContactFrame,
        before: &[Motion; 2],
        inertias: [&Inertia; 2],
        impulse: DVec2,
        elasticity: Elasticity,
    ) -> [Motion; 2] {
        let mut after = pushed(frame, before, inertias, impulse);
        let met_fixed = inertias[0].is_fixed() || inertias[1].is_fixed();
        let d = frame.line_of_centres;
        let turns = |n: usize| inertias[n].inverse_moment > 0.0 && frame.arms[n].perp_dot(d) != 0.0;
        if met_fixed && elasticity == Elasticity::ELASTIC && !turns(0) && !turns(1) {
            let [a, b] = &mut after;
            let fixed = usize::from(inertias[1].is_fixed());
            // Velocities are those in the frame of the surface of a wall that moves.
            let frame_velocity = if before[fixed].is_at_rest() {
                None
            } else {
                Some(before[fixed].velocity_of(frame.arms[fixed]))
            };
            let reflected = |to_other: DVec2, n: usize, after: DVec2| {
                let (velocity, inverse_mass) = (before[n].velocity, inertias[n].inverse_mass);
                match frame_velocity {
                    Some(w) if n != fixed => {
                        w + self.reflected(to_other, velocity - w, inverse_mass, after - w)
                    }
                    _ => self.reflected(to_other, velocity, inverse_mass, after),
                }
            };
            a.velocity = reflected(d, 0, a.velocity);
            b.velocity = reflected(-d, 1, b.velocity);
        }
        after
    }

    /// The velocity of a body after an elastic contact with a fixed body: one that is rounded less
    /// than `after`, if the response provides it; a fixed body keeps its velocity.
    #[cold]
    #[inline(never)]
    fn reflected(&self, to_other: DVec2, before: DVec2, inverse_mass: f64, after: DVec2) -> DVec2 {
        if inverse_mass == 0.0 {
            before
        } else {
            self.response.reflected(to_other, before).unwrap_or(after)
        }
    }
}

/// The velocity of the touching point of the second body relative to that of the first
/// (length / time).
fn surface_velocity(frame: &ContactFrame, motions: &[Motion; 2]) -> DVec2 {
    motions[1].velocity_of(frame.arms[1]) - motions[0].velocity_of(frame.arms[0])
}

/// The work of a fixed body that moves, by an impulse on the second body (mass × length² / time²):
/// J · w, with the impulse J on the other body and the velocity w of its surface at the contact.
#[cold]
#[inline(never)]
fn work_of_wall(
    frame: &ContactFrame,
    before: &[Motion; 2],
    inertias: [&Inertia; 2],
    impulse: DVec2,
) -> f64 {
    let work = |n: usize, impulse_on_other: DVec2| {
        if inertias[n].is_fixed() && !before[n].is_at_rest() {
            impulse_on_other.dot(before[n].velocity_of(frame.arms[n]))
        } else {
            0.0
        }
    };
    work(0, impulse) + work(1, -impulse)
}

/// Kinetic energy of two bodies (mass × length² / time²).
fn energy_of(motions: &[Motion; 2], inertias: [&Inertia; 2]) -> f64 {
    kinetic_energy(&motions[0], inertias[0]) + kinetic_energy(&motions[1], inertias[1])
}

/// The motions after an impulse on the second body and its opposite on the first.
fn pushed(
    frame: &ContactFrame,
    before: &[Motion; 2],
    inertias: [&Inertia; 2],
    impulse: DVec2,
) -> [Motion; 2] {
    [
        apply_impulse(&before[0], inertias[0], frame.arms[0], -impulse),
        apply_impulse(&before[1], inertias[1], frame.arms[1], impulse),
    ]
}
