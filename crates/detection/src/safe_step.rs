//! How far a pair can be followed without looking: the first zero of a bound from below on its gap.

use crate::tolerance::{MOST_DOUBLINGS, STEP_MARGIN};

/// How fast a gap can bend downwards.
pub(crate) struct Curvature {
    /// K: −n·d'' ≤ K at any time.
    pub(crate) largest: f64,
    /// A lower bound of a = n·d'' now.
    pub(crate) along_normal: f64,
    /// K₃: |d'''| ≤ K₃ at any time.
    pub(crate) jerk: f64,
    /// An upper bound of |d''| now.
    pub(crate) magnitude: f64,
    /// J: |d''| grows no faster than this.
    pub(crate) relative_jerk: f64,
}

impl Curvature {
    /// Only that it is at most K.
    pub(crate) fn at_most(largest: f64) -> Self {
        Self {
            largest,
            along_normal: -largest,
            jerk: f64::INFINITY,
            magnitude: largest,
            relative_jerk: f64::INFINITY,
        }
    }

    /// The least of the three bounds that holds for a time `h` from now on; never negative.
    #[inline]
    fn within(&self, h: f64) -> f64 {
        let by_normal = self.jerk * h - self.along_normal;
        let by_relative_rotation = self.magnitude + self.relative_jerk * h;
        // A bound that overflows or is no number is not below K.
        let mut least = self.largest;
        if by_normal < least {
            least = by_normal.max(0.0);
        }
        if by_relative_rotation < least {
            least = by_relative_rotation;
        }
        least
    }
}

/// The longest step found in which a gap that now has the positive value `gap` and the rate `rate` stays positive,
/// and whether the step ends at the root of gap + rate h − k h²/2 for a k that holds up to there.
///
/// While g falls straight, it takes g/|g'| to zero, and any curvature makes it sooner. So the bound on the curvature
/// within that time holds, and the root for it is certified. Where that bound is no better than K, the step for K is
/// lengthened by looking up to twice as far, and again: the bound for h₂ = 2 h holds up to h₂, so the sooner of h₂ and
/// the root for it is certified.
#[inline]
pub(crate) fn safe_step(gap: f64, rate: f64, curvature: &Curvature) -> (f64, bool) {
    let straight = if rate < 0.0 { gap / -rate } else { f64::INFINITY };
    let k = curvature.within(straight);
    let (step, is_root) = if k < curvature.largest {
        (root(gap, rate, k), true)
    } else {
        lengthened(root(gap, rate, curvature.largest), gap, rate, curvature)
    };
    (step * (1.0 - STEP_MARGIN), is_root)
}

fn lengthened(mut step: f64, gap: f64, rate: f64, curvature: &Curvature) -> (f64, bool) {
    let mut is_root = true;
    for _ in 0..MOST_DOUBLINGS {
        let reach = 2.0 * step;
        let k = curvature.within(reach);
        if k < curvature.largest && reach < f64::INFINITY {
            let longer = root(gap, rate, k);
            if longer <= reach {
                return (longer, true);
            }
            (step, is_root) = (reach, false);
        } else {
            break;
        }
    }
    (step, is_root)
}

/// The same with K alone.
#[inline]
pub(crate) fn plain_step(gap: f64, rate: f64, largest: f64) -> f64 {
    root(gap, rate, largest) * (1.0 - STEP_MARGIN)
}

/// The positive root of gap + rate h − k h²/2 for a positive gap, in the form that does not cancel.
#[inline]
fn root(gap: f64, rate: f64, k: f64) -> f64 {
    let square_root = (rate * rate + 2.0 * k * gap).sqrt();
    if rate < 0.0 {
        2.0 * gap / (square_root - rate)
    } else if k > 0.0 {
        (rate + square_root) / k
    } else {
        f64::INFINITY
    }
}
