//! Cropping: segments of time in which the distance of two atoms has at most one minimum.

use std::f64::consts::FRAC_PI_2;

/// The length of the segments (time) for two bodies with these angular velocities; infinite if
/// neither turns, since the squared distance is then a parabola.
///
/// Equation 2.4 of Montanari (2017), with absolute values added in its last two terms:
///
/// `Δt = κ min(π/|ω_A + ω_B|, π/|ω_A − ω_B|, π/(2|ω_A|), π/(2|ω_B|))`, κ = 1/2.
///
/// The first two terms are never the least, because `|ω_A ± ω_B| ≤ 2 max(|ω_A|, |ω_B|)`. They are
/// not computed, and nothing is divided by zero.
pub(crate) fn segment_length(angular_velocity: [f64; 2], crop_factor: f64) -> f64 {
    let [a, b] = angular_velocity.map(f64::abs);
    let fastest = a.max(b);
    if fastest == 0.0 {
        f64::INFINITY
    } else {
        crop_factor * (FRAC_PI_2 / fastest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    proptest! {
        #[test]
        fn agrees_with_equation_2_4(a in -50.0..50.0f64, b in -50.0..50.0f64) {
            prop_assume!(a != 0.0 && b != 0.0 && a + b != 0.0 && a - b != 0.0);
            let terms = [PI / (a + b).abs(), PI / (a - b).abs(), PI / (2.0 * a.abs()), PI / (2.0 * b.abs())];
            let expected = 0.5 * terms.into_iter().fold(f64::INFINITY, f64::min);
            prop_assert!((segment_length([a, b], 0.5) - expected).abs() <= 1e-15 * expected);
        }
    }

    #[test]
    fn spins_that_are_zero_equal_or_opposite_divide_by_nothing() {
        assert_eq!(segment_length([0.0, 0.0], 0.5), f64::INFINITY);
        for spins in [[2.0, 0.0], [0.0, -2.0], [2.0, 2.0], [2.0, -2.0]] {
            assert_eq!(segment_length(spins, 0.5), PI / 8.0);
        }
    }
}
