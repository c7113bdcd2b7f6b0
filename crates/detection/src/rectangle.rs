//! Broad phase: a lower bound on the time at which a disc reaches the rectangle that holds a
//! turning molecule.
//!
//! # Lemmas
//! In the frame that moves and turns with the molecule ([`query_body`](crate::query_body)) a disc
//! of radius r is at p. A side of the rectangle has the outward normal n and the distance w from
//! the centre of mass.
//!
//! 1. **Side.** The distance s = n·p − w − r of the disc from the side satisfies s(h) ≥ s + s' h −
//!    K h²/2 for all h ≤ H, with K = 2 |ω| |V| + ω² (|d| + |V| H). *Proof.* p'' = −R⁻¹ (2 ω J V +
//!    ω² d).
//! 2. **Certificate.** While s > 0 the disc does not touch the molecule, which lies behind all its
//!    sides. This is one step of conservative advancement, as in [`gap_search`](crate::gap_search).
//!    For rods the bound is much tighter than that of the bounding circle.
//! 3. **Rounding.** That of s and s' is bounded in [`query_body`](crate::query_body); the position
//!    of a side adds one rounding.

use glam::DVec2;

use crate::{relative_disc::RelativeDisc, tolerance::STEP_MARGIN};

/// A lower bound on the time at which a disc reaches the rectangle of these corners (time from
/// now). A value past `horizon` only excludes contacts before `horizon`.
#[inline(always)]
pub(crate) fn apart_from_rectangle(
    [low, high]: [DVec2; 2],
    disc: &RelativeDisc,
    spin: f64,
    horizon: f64,
) -> f64 {
    let bend = 2.0 * spin.abs() * disc.speed + spin * spin * (disc.distance + disc.speed * horizon);
    let step = |behind: f64, beyond: f64, rate: f64| {
        let is_beyond = beyond > behind;
        let gap = (if is_beyond { beyond } else { behind }) - disc.radius - disc.error;
        let rate = (if is_beyond { rate } else { -rate }) - disc.rate_error;
        let gap = if gap > 0.0 { gap } else { 0.0 };
        let root = (rate * rate + 2.0 * bend * gap).sqrt() * (1.0 + STEP_MARGIN);
        2.0 * gap / (root - rate) * (1.0 - STEP_MARGIN)
    };
    let [x, y] = disc.place;
    let across = step(low.y - y, y - high.y, disc.rate[1]);
    let along = step(low.x - x, x - high.x, disc.rate[0]);
    // NaN is not greater than 0 and gives the bound 0.
    let time = if across > 0.0 { across } else { 0.0 };
    if along > time { along } else { time }
}
