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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Forward integration of a gap that bends as fast as the bounds allow.
        #[test]
        fn no_gap_within_the_bounds_is_zero_before_the_end_of_the_step(
            gap in 1e-3..1.0f64, rate in -1.0..1.0f64, largest in 0.1..4.0f64, share in -1.0..1.0f64,
            jerk in 0.01..8.0f64, relative in 0.0..8.0f64,
        ) {
            let along = share * largest;
            let curvature = Curvature {
                largest,
                along_normal: along,
                jerk,
                magnitude: along.abs() + 0.1 * largest,
                relative_jerk: relative,
            };
            let (step, is_root) = safe_step(gap, rate, &curvature);
            prop_assert!(step >= plain_step(gap, rate, largest));
            let parts = 2000;
            let (h, mut now, mut slope) = (step / f64::from(parts), gap, rate);
            for part in 0..parts {
                let time = (f64::from(part) + 0.5) * h;
                let by_normal = (jerk * time - along).max(-largest);
                let fastest = largest.min(by_normal).min(curvature.magnitude + relative * time);
                now += slope * h - 0.5 * fastest * h * h;
                slope -= fastest * h;
                prop_assert!(now > -1e-4 * (1.0 + step * step), "{now} at {time} of {step}");
            }
            // What is called a root is one for a curvature between 0 and the largest.
            let fall = gap + rate * step;
            let most = 0.5 * largest * step * step;
            prop_assert!(!is_root || (fall >= -1e-12 * gap && fall <= most * (1.0 + 1e-12) + 1e-12 * gap));
        }
    }

    #[test]
    fn a_step_cut_short_by_the_reach_of_its_bound_is_no_root() {
        // Matched spins: K is large, nothing bends. The last doubling ends the step, far from any zero.
        let curvature =
            Curvature { largest: 1.0, along_normal: 0.0, jerk: 1.0, magnitude: 1e-30, relative_jerk: 0.0 };
        let (step, is_root) = safe_step(1e-12, 1e-30, &curvature);
        assert!(!is_root && step > 1.0, "{step}");
        // The same pair closing: the root is within reach.
        let (step, is_root) = safe_step(1e-12, -1e-3, &curvature);
        assert!(is_root && (step - 1e-9).abs() < 1e-20, "{step}");
    }
}
