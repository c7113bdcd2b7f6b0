//! What keeps bodies that touch from sinking into each other: a least speed of separation, and places rounded outwards.
//!
//! A contact is found to rounding, and so is what it leaves behind. Three causes could let a pair sink, contact after contact:
//!
//! 1. *Closing speeds of rounding size.* At elasticity 0, and wherever two bodies approach as slowly as velocities are
//!    rounded, the surfaces may go on closing after the contact by a rounding, which no detector can tell from rest. So a
//!    contact that loses energy, or that follows another at the same instant, ends with the surfaces separating at
//!    [`LEAST_SEPARATION`] times the speed that detection resolves, E'. Elastic contacts separate as fast as they
//!    approach, which is faster than E' already. Two discs need only separate by more than velocities are rounded,
//!    since straight flights that part do not come back.
//! 2. *Steps of a search that fall by E.* Excluded by Lemma 9 of `carom_detection` (`gap_search.rs`), given 1.
//! 3. *Rounding of places.* Each contact rounds two places to the nearest float, inwards or outwards. A pair that meets 10⁵
//!    times within a short time would do a random walk of 300 roundings. So the places of bodies that meet deeper than two
//!    roundings of the side are rounded away from each other, by no more than they overlap and than four roundings.
//!
//! With these, the depth of a pair is bounded by 5/4 E plus the roundings of one contact, at any elasticity and for any number
//! of contacts. The kinetic energy that 1 adds is of the order of E'² μ/2, some 10⁻²⁶ of what there is; the ledger counts
//! it. Places change by rounding only, after the observers have seen the contact.

use carom_detection::{Touch, resolved_speed};
use carom_kinematics::{Inertia, Motion, RelativeMotion};
use carom_response::{ContactFrame, approach_speed, reduced_mass};
use glam::DVec2;

use crate::{
    Body, World,
    scheduler::{Parts, separation_error},
};

/// Surfaces separate at least this many times as fast as detection resolves. Smaller than 2: a pair may not be seen to
/// part. Larger: energy is put into contacts at elasticity 0.
const LEAST_SEPARATION: f64 = 4.0;

/// Overlaps of a contact up to this many roundings of the side are left as they are: most contacts have none deeper.
const TOLERATED: f64 = 2.0;

/// By how many roundings of the side the places of two bodies are moved apart at most.
const MOST_OUTWARDS: f64 = 4.0;

/// The impulse on B (mass × length / time) that has to be added to one already acted, so that the surfaces separate fast
/// enough to be resolved. `None` if they do, or if the response leaves them closing at a resolved speed.
#[cold]
pub(crate) fn missing_impulse(
    world: &World,
    frame: &ContactFrame,
    parts: Parts,
    bodies: [&Body; 2],
    before: [&Motion; 2],
    after: [&Motion; 2],
) -> Option<DVec2> {
    let time = before[0].time;
    let mut relative = RelativeMotion::between(before[0], before[1], DVec2::ZERO, time);
    let least = if parts == Parts::Discs {
        // Discs fly straight: those that part do not come back, wherever exactly they are.
        2.0 * relative.velocity_error
    } else {
        // The image may be another, and a scheduler may know places less well: this bounds all of them.
        relative.separation_error = relative.separation_error.max(separation_error(world));
        let [a, b] = bodies.map(|body| body.kind.molecule.outline());
        LEAST_SEPARATION * resolved_speed(a, b, &relative, Touch::from(parts))
    };
    let approach = approach_speed(frame, after);
    let mass = reduced_mass(frame, bodies.map(|body| &body.kind.inertia));
    // Surfaces that still close faster do so by the will of the response, which is not replaced.
    (approach.abs() < least).then(|| (least + approach) * mass * frame.normal())
}

/// Rounds the places of two bodies that overlap by `depth` (length) away from each other, if their surfaces separate. Those
/// that close although they have had their contact run into the bound on contacts at one instant.
pub(crate) fn round_outwards(
    world: &World,
    depth: f64,
    frame: &ContactFrame,
    inertias: [&Inertia; 2],
    motions: &mut [Motion; 2],
) {
    let rounding = f64::EPSILON * world.bounds.sides().max_element();
    if depth > TOLERATED * rounding && approach_speed(frame, [&motions[0], &motions[1]]) < 0.0 {
        let [a, b] = inertias.map(|inertia| inertia.inverse_mass);
        let apart = depth.min(MOST_OUTWARDS * rounding) * frame.normal();
        motions[0].position -= a / (a + b) * apart;
        motions[1].position += b / (a + b) * apart;
    }
}
