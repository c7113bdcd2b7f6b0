//! A least speed of separation and outward rounding of positions: they keep touching bodies from
//! sinking into each other.
//!
//! A contact and its outcome are computed to rounding. Three causes could let a pair sink, contact
//! after contact:
//!
//! 1. *Closing speeds of rounding size.* At elasticity 0, and where two bodies approach as slowly
//!    as velocities are rounded, the surfaces may still close after the contact by a rounding,
//!    which no detector can distinguish from rest. So a contact that loses energy, or that follows
//!    another at the same instant, ends with the surfaces separating at [`LEAST_SEPARATION`] times
//!    the speed that detection resolves, E'. Elastic contacts separate as fast as they approach,
//!    which is already faster than E'. Two discs need only separate by more than the rounding of
//!    velocities, since separating straight flights do not meet again.
//! 2. *Steps of a search that fall by E.* Excluded by Lemma 9 of `carom_detection`
//!    (`gap_search.rs`), given 1.
//! 3. *Rounding of positions.* Each contact rounds two positions to the nearest float, inwards or
//!    outwards. A pair with 10⁵ contacts within a short time would do a random walk of 300
//!    roundings. So the positions of bodies that overlap by more than two roundings of the side at
//!    a contact are rounded away from each other, by at most the overlap and at most four
//!    roundings.
//!
//! With these measures, the depth of a pair is at most 5/4 E plus the roundings of one contact, at
//! any elasticity and for any number of contacts. Measure 1 adds a kinetic energy of the order of
//! E'² μ/2, a relative 10⁻²⁶, which the ledger counts. Positions change by rounding only, after the
//! observers have received the contact.

use carom_detection::{Touch, resolved_speed};
use carom_kinematics::{Inertia, Motion, RelativeMotion};
use carom_response::{ContactFrame, approach_speed, reduced_mass};
use glam::DVec2;

use crate::{Body, World, contact_event::Parts};

/// Least speed of separation of surfaces, in units of the speed that detection resolves. Smaller
/// than 2: detection may not see that a pair separates. Larger: energy is put into contacts at
/// elasticity 0.
const LEAST_SEPARATION: f64 = 4.0;

/// Overlaps at a contact up to this many roundings of the side are not corrected; most are not
/// deeper.
const TOLERATED: f64 = 2.0;

/// Largest correction of the positions of two bodies, in roundings of the side.
const MOST_OUTWARDS: f64 = 4.0;

/// The additional impulse on B (mass × length / time) with which the surfaces separate fast enough
/// to be resolved. `None` if they already do, or if the response leaves them closing at a resolved
/// speed. `separation_error` is that of the epoch (length).
#[cold]
pub(crate) fn missing_impulse(
    separation_error: f64,
    frame: &ContactFrame,
    parts: Parts,
    bodies: [&Body; 2],
    before: [&Motion; 2],
    after: [&Motion; 2],
) -> Option<DVec2> {
    let time = before[0].time;
    let mut relative = RelativeMotion::between(before[0], before[1], DVec2::ZERO, time);
    let least = if parts == Parts::Discs {
        // Discs fly straight: once separating they do not meet again, for any rounding of their
        // positions.
        2.0 * relative.velocity_error
    } else {
        // The scheduler may use another image or store positions with a larger error; this bounds
        // all cases.
        relative.separation_error = relative.separation_error.max(separation_error);
        let [a, b] = bodies.map(|body| body.kind.molecule.outline());
        LEAST_SEPARATION * resolved_speed(a, b, &relative, Touch::from(parts))
    };
    let approach = approach_speed(frame, after);
    let mass = reduced_mass(frame, bodies.map(|body| &body.kind.inertia));
    // Surfaces that still close faster do so because of the response, which is not overridden.
    (approach.abs() < least).then(|| (least + approach) * mass * frame.normal())
}

/// Rounds the positions of two bodies that overlap by `depth` (length) away from each other, if
/// their surfaces separate. Pairs that still close after their contact reach the limit on contacts
/// at one instant instead.
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
