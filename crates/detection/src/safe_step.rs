//! Certified steps: the first zero of a lower bound on the gap of a pair.

use glam::DVec2;

use crate::tolerance::{MAX_DOUBLINGS, MIN_SQUARE, STEP_MARGIN};

/// Bounds on the downward curvature of a gap.
#[derive(Clone, Copy)]
pub(crate) struct Curvature {
    /// K: −n·d'' ≤ K at all times.
    pub(crate) largest: f64,
    /// A lower bound of n·d'' at this time.
    pub(crate) along_normal: f64,
    /// K₃: |d'''| ≤ K₃ at all times.
    pub(crate) jerk: f64,
    /// A lower bound of g'' at this time.
    pub(crate) of_gap: f64,
    /// C₃: |g'''| ≤ C₃ up to the first contact.
    pub(crate) gap_jerk: f64,
    /// d'' at this time.
    pub(crate) acceleration: DVec2,
    /// Bound on the error of the computed |d''|.
    pub(crate) acceleration_error: f64,
    /// J: a bound on the growth rate of the bound |d''|, see Lemma 3 of
    /// [`gap_search`](crate::gap_search).
    pub(crate) relative_jerk: f64,
    /// K + |d'|²/|d|, a bound on g'' (the upward curvature of the gap).
    pub(crate) upwards: f64,
}

impl Curvature {
    /// The bound K alone.
    pub(crate) fn at_most(largest: f64) -> Self {
        Self {
            largest,
            along_normal: -largest,
            jerk: f64::INFINITY,
            of_gap: -largest,
            gap_jerk: f64::INFINITY,
            acceleration: DVec2::INFINITY,
            acceleration_error: 0.0,
            relative_jerk: f64::INFINITY,
            upwards: f64::INFINITY,
        }
    }

    /// For a gap whose second derivative is at least `least` now, at most `largest` in magnitude at
    /// all times, and changes at most at the rate `jerk`.
    pub(crate) fn of_smooth_gap(largest: f64, least: f64, jerk: f64) -> Self {
        Self {
            along_normal: least,
            of_gap: least,
            jerk,
            gap_jerk: jerk,
            upwards: largest,
            ..Self::at_most(largest)
        }
    }

    /// The least known k for which gap + rate h − k h²/2 is a lower bound of the gap up to `h`. It
    /// can be negative.
    ///
    /// Integrated twice, a bound that grows linearly in time counts with a third of its final
    /// value.
    #[inline]
    fn within(&self, h: f64) -> f64 {
        let magnitude = length(self.acceleration) + self.acceleration_error;
        lesser(
            self.along_normal_within(h),
            magnitude + self.relative_jerk * (h * (1.0 / 3.0)),
        )
    }

    /// The least such k without the bound by relative rotation.
    #[inline]
    fn along_normal_within(&self, h: f64) -> f64 {
        let third = h * (1.0 / 3.0);
        let by_normal = lesser(self.largest, self.jerk * third - self.along_normal);
        lesser(by_normal, self.gap_jerk * third - self.of_gap)
    }
}

/// The length of `v`, or |x| + |y| where its square has lost digits to underflow.
fn length(v: DVec2) -> f64 {
    let squared = v.length_squared();
    if squared < MIN_SQUARE {
        v.x.abs() + v.y.abs()
    } else {
        squared.sqrt()
    }
}

/// The first look-ahead for the root of a gap that bends upwards, in units of g/|g'|; and the share
/// of g'² left of the discriminant if the root is exactly there: (2/1.25 − 1)².
const BENT: (f64, f64) = (1.25, 0.36);

/// The longest step found in which a gap with the positive value `gap` and the rate `rate` stays
/// positive.
///
/// A bound on the curvature that holds up to H certifies the smaller of H and the root for that
/// bound. H is a little more than g/|g'|, where a gap that falls linearly is zero. For a gap that
/// bends upwards so much that it hardly reaches zero, H is 2 g/|g'|, beyond which there is no root.
/// Where the bound is no better than K, the step for K is lengthened by doubling H repeatedly.
#[inline]
pub(crate) fn safe_step(gap: f64, rate: f64, curvature: &Curvature) -> f64 {
    let (mut step, mut k) = (0.0, curvature.largest);
    if rate < 0.0 {
        let reach = BENT.0 * gap / -rate;
        k = curvature.within(reach);
        step = step_up_to(reach, gap, rate, k, curvature);
    }
    if k >= curvature.largest {
        step = lengthened(root(gap, rate, curvature.largest), gap, rate, curvature);
    }
    step * (1.0 - STEP_MARGIN)
}

/// A cheaper step for ordinary pairs, without lengthening and without the bound by relative
/// rotation. `slowness` is 1/|g'| where the gap falls, and negative where it widens.
///
/// With s = g/|g'| and x = k s/2|g'| the root is 2 s/(1 + √(1 + 4 x)), which is at least s (1 − x)
/// for any x > −1. The two differ by 2 x² s, so the second form is as good for small x, and
/// cheaper.
#[inline]
pub(crate) fn short_step(gap: f64, rate: f64, slowness: f64, curvature: &Curvature) -> f64 {
    let straight = gap * slowness;
    let k = curvature.along_normal_within(BENT.0 * straight);
    let x = 0.5 * k * straight * slowness;
    let step = if (straight > 0.0) & (x.abs() <= 0.125) {
        straight * (1.0 - x)
    } else {
        short_step_of_bent(gap, rate, curvature)
    };
    step * (1.0 - STEP_MARGIN)
}

#[inline(never)]
fn short_step_of_bent(gap: f64, rate: f64, curvature: &Curvature) -> f64 {
    if rate < 0.0 {
        let reach = BENT.0 * gap / -rate;
        step_up_to(
            reach,
            gap,
            rate,
            curvature.along_normal_within(reach),
            curvature,
        )
    } else {
        root(gap, rate, curvature.largest)
    }
}

/// The step of a falling gap for the bound `k` that holds up to `reach`.
#[inline]
fn step_up_to(reach: f64, gap: f64, rate: f64, k: f64, curvature: &Curvature) -> f64 {
    let discriminant = rate * rate + 2.0 * k * gap;
    if discriminant < BENT.1 * (rate * rate) {
        past_the_turn(gap, rate, curvature)
    } else {
        lesser(2.0 * gap / (discriminant.sqrt() - rate), reach)
    }
}

/// The step of a gap whose rate of fall decreases.
#[cold]
fn past_the_turn(gap: f64, rate: f64, curvature: &Curvature) -> f64 {
    let reach = 2.0 * gap / -rate;
    let certain = 0.5 * BENT.0 * reach;
    certain.max(lesser(root(gap, rate, curvature.within(reach)), reach))
}

/// The smaller of two numbers. Returns `one` if `other` is NaN or `one` is NaN.
#[inline]
fn lesser(one: f64, other: f64) -> f64 {
    if other < one { other } else { one }
}

fn lengthened(mut step: f64, gap: f64, rate: f64, curvature: &Curvature) -> f64 {
    for _ in 0..MAX_DOUBLINGS {
        let reach = 2.0 * step;
        let k = curvature.within(reach);
        if k < curvature.largest && reach < f64::INFINITY {
            let longer = root(gap, rate, k);
            if longer <= reach {
                return longer;
            }
            step = reach;
        } else {
            break;
        }
    }
    step
}

/// The positive root of gap + rate h − k h²/2 for a positive gap, in the form without cancellation;
/// infinite if there is none.
#[inline]
fn root(gap: f64, rate: f64, k: f64) -> f64 {
    let discriminant = rate * rate + 2.0 * k * gap;
    if rate < 0.0 {
        if discriminant < 0.0 {
            f64::INFINITY
        } else {
            2.0 * gap / (discriminant.sqrt() - rate)
        }
    } else if k > 0.0 {
        (rate + discriminant.sqrt()) / k
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Integrates a gap forwards that bends as fast as the bounds allow.
        #[test]
        fn no_gap_within_the_bounds_is_zero_before_the_end_of_the_step(
            gap in 1e-3..1.0f64, rate in -1.0..1.0f64, largest in 0.1..4.0f64, share in -1.0..1.0f64,
            jerk in 0.01..8.0f64, across in 0.0..2.0f64, gap_jerk in 0.01..30.0f64, relative in 0.0..8.0f64,
        ) {
            let along = share * largest;
            let acceleration = along.abs() + 0.1 * largest;
            let curvature = Curvature {
                largest,
                along_normal: along,
                jerk,
                of_gap: along + across,
                gap_jerk,
                acceleration: DVec2::new(acceleration, 0.0),
                acceleration_error: 0.0,
                relative_jerk: relative,
                upwards: f64::INFINITY,
            };
            let step = safe_step(gap, rate, &curvature);
            let short = short_step(gap, rate, -1.0 / rate, &curvature);
            prop_assert!(short <= step * (1.0 + 1e-12), "{short} {step}");
            // The bounds do not allow a gap that is below zero before the end of the step and
            // returns.
            let parts = 2000;
            let (h, mut now, mut slope) = (step / f64::from(parts), gap, rate);
            for part in 0..parts {
                let time = (f64::from(part) + 0.5) * h;
                let by_normal = (jerk * time - along).max(-largest);
                let by_gap = gap_jerk * time - (along + across);
                let fastest = largest.min(by_normal).min(by_gap).min(acceleration + relative * time);
                now += slope * h - 0.5 * fastest * h * h;
                slope -= fastest * h;
                prop_assert!(now > -1e-4 * (1.0 + step * step), "{now} at {time} of {step}");
            }
        }

        /// Compares s (1 − x) with the root.
        #[test]
        fn the_short_step_is_no_longer_than_the_root(
            gap in 1e-9..1e3f64, rate in -10.0..-1e-3f64, bend in -1.0..1.0f64,
        ) {
            let k = bend * rate * rate / gap;
            let curvature = Curvature {
                of_gap: -k,
                gap_jerk: 0.0,
                ..Curvature::at_most(k.abs().max(rate * rate / gap))
            };
            let step = short_step(gap, rate, -1.0 / rate, &curvature);
            prop_assert!(step <= root(gap, rate, k) * (1.0 - 2.0 * f64::EPSILON));
        }
    }

    #[test]
    fn matched_spins_are_passed_in_one_step() {
        let curvature = Curvature {
            along_normal: 0.0,
            jerk: 1.0,
            acceleration: DVec2::new(1e-30, 0.0),
            relative_jerk: 0.0,
            ..Curvature::at_most(1.0)
        };
        // K is large, but the gap is not curved.
        let step = safe_step(1e-12, 1e-30, &curvature);
        assert!(step > 1.0, "{step}");
        // The same pair closing: the root lies within the step.
        let step = safe_step(1e-12, -1e-3, &curvature);
        assert!((step - 1e-9).abs() < 1e-20, "{step}");
    }

    #[test]
    fn a_gap_that_widens_again_before_zero_gets_a_step_past_its_minimum() {
        // 1 − h + 0.3 h² has no root, and its minimum at h = 5/3.
        let curvature = Curvature {
            of_gap: 0.6,
            gap_jerk: 1e-6,
            ..Curvature::at_most(1.0)
        };
        assert!(short_step(1.0, -1.0, 1.0, &curvature) > 1.9);
        // 1 − h + 0.24 h² has a root at 5/3.
        let curvature = Curvature {
            of_gap: 0.48,
            gap_jerk: 1e-6,
            ..curvature
        };
        let step = short_step(1.0, -1.0, 1.0, &curvature);
        assert!(step < 5.0 / 3.0 && step > 5.0 / 3.0 - 1e-5, "{step}");
    }
}
