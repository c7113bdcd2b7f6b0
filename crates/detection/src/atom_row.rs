//! Broad phase: a lower bound on the time at which a disc touches one of a few atoms of a turning
//! molecule.
//!
//! # Lemmas
//! In the frame that moves and turns with the molecule ([`query_body`](crate::query_body)) an atom
//! is at a and the disc at p. s is the sum of their radii.
//!
//! 1. **Closing gap.** The gap g = |p − a| − s has the rate g' = (p − a)·p'/|p − a|. In the
//!    inertial frame the acceleration of the atom is at most K = ω² |a|. So there is no contact
//!    while g + g' h − K h²/2 > 0. This is the shared step of [`Exact`](crate::Exact).
//! 2. **Widening gap.** Where g' > 0 the gap is at least g up to h = 2 g'/K. A pair that has just
//!    met, with g = 0 to rounding, is therefore free up to that time. If the pair may return [very
//!    soon](crate::tolerance::SOON), only a search resolves the time, and the bound is 0.
//! 3. **Rounding.** That of g and g' is bounded in [`query_body`](crate::query_body). The normal
//!    adds an error of 2 E/|p − a|, as in [`ErrorBound`](crate::ErrorBound). K g and g'² are of the
//!    order of a squared velocity, and so in range where all other numbers are.

use carom_geometry::AtomRow;

use crate::{
    relative_disc::RelativeDisc,
    tolerance::{SOON, STEP_MARGIN},
};

/// A lower bound on the time at which a disc touches one of these atoms (time from now).
#[inline(always)]
pub(crate) fn apart_from_atoms(rows: &[AtomRow], disc: &RelativeDisc, spin: f64) -> f64 {
    let [px, py] = disc.place;
    let [vx, vy] = disc.rate;
    // 2 E |p'|
    let over_distance = 2.0 * disc.error * (disc.speed + spin.abs() * disc.distance);
    let mut soonest = [f64::INFINITY; AtomRow::LANES];
    for row in rows {
        let mut steps = [0.0; AtomRow::LANES];
        for (lane, step) in steps.iter_mut().enumerate() {
            let (x, y) = (px - row.offset[0][lane], py - row.offset[1][lane]);
            let k = spin * spin * row.arm[lane];
            let length = (x * x + y * y).sqrt();
            let reach = disc.radius + row.radius[lane];
            let apart = length - reach;
            let gap = positive(apart - disc.error);
            let rate = ((x * vx + y * vy) - over_distance) / length - disc.rate_error;
            let root = (rate * rate + 2.0 * k * gap).sqrt() * (1.0 + STEP_MARGIN);
            let falling = positive(2.0 * gap / (root - rate));
            let touches = f64::from(u8::from(apart > -disc.error));
            let rising = 2.0 * touches * positive(rate) / k;
            let fastest = disc.speed + spin.abs() * row.arm[lane];
            let is_later = f64::from(u8::from(rising * fastest > SOON * reach));
            let rising = rising * is_later;
            *step = if rising > falling { rising } else { falling };
        }
        for (soonest, step) in soonest.iter_mut().zip(steps) {
            *soonest = if step < *soonest { step } else { *soonest };
        }
    }
    let least = soonest.into_iter().fold(
        f64::INFINITY,
        |least, step| if step < least { step } else { least },
    );
    least * (1.0 - STEP_MARGIN)
}

/// `x` if it is positive; 0 otherwise, also for NaN.
#[inline(always)]
fn positive(x: f64) -> f64 {
    if x > 0.0 { x } else { 0.0 }
}
