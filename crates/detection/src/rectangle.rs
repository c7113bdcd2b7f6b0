//! Until when discs are certainly beyond a side of the rectangle that holds a turning molecule.
//!
//! For the outward normal n of a side that is w from the centre of mass, and a disc of radius r at p, as the
//! [asking](crate::QueryBody) molecule sees it, the distance s = n·p − w − r has for all h ≤ H
//!
//! s(h) ≥ s + s' h − K h²/2,  K = 2 |ω| |V| + ω² (|d| + |V| H),
//!
//! since p'' = −R⁻¹ (2 ω J V + ω² d), and the disc is apart from the molecule as long as that is positive: the molecule is
//! behind its side. It is one certified step, like those of [`Exact`](crate::Exact), from a bound that is far tighter for rods
//! than their circle is.
//!
//! **Rounding.** Of s and s' as the asking molecule sees them; the sides are off by one.

use glam::DVec2;

use crate::{relative_disc::RelativeDisc, tolerance::STEP_MARGIN};

/// When a disc may be at the rectangle of these corners (time from now); steps beyond `horizon` say no more than that it
/// is not before.
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
    // What is no number is not later.
    let time = if across > 0.0 { across } else { 0.0 };
    if along > time { along } else { time }
}
