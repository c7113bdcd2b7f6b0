//! A pair that parts from a contact and is back very soon: its gap relative to that contact.

use carom_kinematics::{HALF_ULP as U, Orientation};
use glam::DVec2;

use crate::{
    atom_pair::{AtomPair, Gap},
    flight::Placement,
    safe_step::safe_step,
    tolerance::{MOST_RECONTACT_STEPS, STEP_MARGIN},
};

/// When a pair in contact at the placement `at` that parts is in contact again (`Ok`, a time), or how long it is
/// certainly not (`Err`, a duration).
///
/// The gap itself is lost in E while the pair is so near. What has been gained since the contact is not: with
/// δ = d(h) − d(0) = V h + (R(ω_B h) − 1) r_B − (R(ω_A h) − 1) r_A, where (R(φ) − 1) r = −2 sin²(φ/2) r + sin φ r^⊥,
///
/// g(h) − g(0) = δ·(2 d(0) + δ) / (|d(h)| + |d(0)|)
///
/// is a sum of terms that are each known to a few roundings of themselves. It is off by at most h (E' + 8 u L): the
/// normal by 2 E/|d| and the arms by their share of E, as in E', and twenty roundings at most. The search is
/// the ordinary one with this in place of E, as long as it is smaller. The contact is taken to be at g(0), which is
/// within 2 E of 0 as any contact is.
pub(crate) fn recontact(
    pair: &AtomPair<'_>,
    at: &Placement,
    start: &Gap,
    limit: f64,
    evaluations: &mut u32,
) -> Result<f64, f64> {
    let away = start.rate - start.rate_error;
    // Up to 2 g'/K the gap is not below what it was.
    let mut elapsed = 2.0 * away / pair.curvature(start).largest * (1.0 - STEP_MARGIN);
    for _ in 0..MOST_RECONTACT_STEPS {
        if at.time + elapsed > limit {
            break;
        }
        let now = relative_gap(pair, at, start, elapsed);
        *evaluations += 1;
        let error = (now.rate_error + 8.0 * U * pair.error.speed()) * elapsed;
        if error >= now.error || error.is_nan() {
            break;
        }
        if now.value > error {
            let curvature = pair.curvature(&now);
            if let Some(landing) = now.landing(&curvature, error) {
                return Ok(at.time + (elapsed + landing));
            }
            let step = safe_step(now.value, now.rate - now.rate_error, &curvature);
            elapsed = (elapsed + step).max(elapsed.next_up());
        } else if now.rate < -now.rate_error {
            return Ok(at.time + (elapsed + pair.polish(&now, error)));
        } else {
            break;
        }
    }
    Err(elapsed)
}

/// The pair after `elapsed`, with its gap less the one at the start.
fn relative_gap(pair: &AtomPair<'_>, at: &Placement, start: &Gap, elapsed: f64) -> Gap {
    let arms = [0, 1].map(|body| at.arm(body, pair.offsets[body]));
    let swings = [0, 1].map(|body| swing(pair.flight.spin[body], elapsed, arms[body]));
    let moved = pair.flight.motion.velocity * elapsed + (swings[1] - swings[0]);
    let d = start.d + moved;
    let gap = moved.dot(2.0 * start.d + moved) / (d.length() + start.d.length());
    let mut now = pair.gap_from(d, [arms[0] + swings[0], arms[1] + swings[1]], at.time + elapsed);
    now.value = gap;
    now
}

/// (R(ω h) − 1) r without cancellation.
pub(crate) fn swing(spin: f64, elapsed: f64, arm: DVec2) -> DVec2 {
    let sine = |rate: f64| Orientation::default().turned(rate, elapsed).cos_sin().y;
    let half = sine(0.5 * spin);
    sine(spin) * arm.perp() - (2.0 * half * half) * arm
}
