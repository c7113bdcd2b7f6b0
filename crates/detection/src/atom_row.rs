//! Until when a disc is certainly apart from each of a few atoms of a turning molecule.
//!
//! With a the place of an atom in its molecule's frame, and a disc at p, as the [asking](crate::QueryBody) molecule sees it, the gap
//! g = |p − a| − s has the rate g' = (p − a)·p'/|p − a|, and seen from outside the atom's acceleration is never more than
//! K = ω² |a|. So there is no contact as long as g + g' h − K h²/2 is above 0: the shared step of
//! [`Exact`](crate::Exact). Where g widens that is at least up to h = 2 g'/K; and as a pair that has just met, with g = 0 to
//! rounding, is no nearer up to there than it is now, it is apart so long, too. Nothing is told of a pair that may be
//! [back so soon](crate::tolerance::SOON) that only a search can tell when.
//!
//! **Rounding.** Of g and g' as the asking molecule sees them, and for the normal, which is off by 2 E/|p − a|, as in
//! [`ErrorBound`](crate::ErrorBound). K g and g'² are of the order of a velocity squared, and so in range where all else is.

use carom_geometry::AtomRow;

use crate::{
    relative_disc::RelativeDisc,
    tolerance::{SOON, STEP_MARGIN},
};

/// When a disc may touch one of these atoms (time from now).
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
    let least =
        soonest.into_iter().fold(f64::INFINITY, |least, step| if step < least { step } else { least });
    least * (1.0 - STEP_MARGIN)
}

/// The number if it is positive; 0 if it is not, or no number.
#[inline(always)]
fn positive(x: f64) -> f64 {
    if x > 0.0 { x } else { 0.0 }
}
