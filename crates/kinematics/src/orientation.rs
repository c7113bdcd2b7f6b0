//! Orientations as fractions of a full turn, and their cosines and sines.

#![allow(
    clippy::inline_always,
    reason = "compiled with the instructions of the caller"
)]

use glam::DVec2;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The orientation of a body, counter-clockwise.
///
/// It is stored in turns between −1/2 and 1/2, because removing whole turns from such a number is
/// exact: the angle of a body after 10⁸ turns has an error of at most 10⁸ roundings.
///
/// ```
/// use carom_kinematics::Orientation;
///
/// let quarter = Orientation::from_turns(1.25);
/// assert_eq!(quarter.turns(), 0.25);
/// assert_eq!(quarter.cos_sin(), glam::DVec2::new(0.0, 1.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[doc(alias = "angle")]
pub struct Orientation(f64);

impl Orientation {
    /// The orientation for an angle in turns; whole turns are removed exactly.
    pub fn from_turns(turns: f64) -> Self {
        Self(turns - nearest_integer(turns))
    }

    /// The orientation for an angle in radians, rounded to the nearest float in turns.
    pub fn from_radians(radians: f64) -> Self {
        Self::from_turns(radians / TAU)
    }

    /// The angle in turns, from −1/2 to 1/2.
    pub fn turns(self) -> f64 {
        self.0
    }

    /// The angle in radians, from −π to π.
    pub fn radians(self) -> f64 {
        self.0 * TAU
    }

    /// The orientation after turning with `angular_velocity` (radians per time) for `duration`.
    ///
    /// The error of the angle is at most (4 |ω Δt| + π) roundings (3.56: two products, their sum
    /// with the orientation, and the constant 1/2π).
    #[inline]
    #[must_use]
    pub fn turned(self, angular_velocity: f64, duration: f64) -> Self {
        if angular_velocity == 0.0 {
            return self;
        }
        Self::from_turns(self.0 + angular_velocity * duration * (1.0 / TAU))
    }

    /// (cos θ, sin θ), each within 1.5e-16: `rotation.rotate(offset)` rotates an offset.
    ///
    /// Exact at multiples of a quarter turn.
    #[doc(alias = "rotation")]
    #[inline]
    pub fn cos_sin(self) -> DVec2 {
        cos_sin_of_quarters(4.0 * self.0)
    }
}

/// The orientation of a body with constant angular velocity, as a function of time.
///
/// ```
/// use carom_kinematics::{Orientation, Turning};
///
/// let body = Turning::new(Orientation::from_turns(0.125), std::f64::consts::TAU);
/// assert_eq!(body.cos_sin_at(0.125), glam::DVec2::Y);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turning {
    quarters_at_start: f64,
    quarters_per_time: f64,
}

impl Turning {
    /// The orientation at time 0 and the angular velocity (radians per time).
    #[inline]
    pub fn new(orientation: Orientation, angular_velocity: f64) -> Self {
        Self {
            quarters_at_start: 4.0 * orientation.0,
            quarters_per_time: angular_velocity * (4.0 / TAU),
        }
    }

    /// (cos θ, sin θ) at `time`. The result differs from [`Orientation::turned`] and
    /// [`Orientation::cos_sin`] only by a different rounding of the angle, within the same bound.
    #[inline(always)]
    pub fn cos_sin_at(&self, time: f64) -> DVec2 {
        let quarters = self.quarters_at_start + self.quarters_per_time * time;
        // Beyond this magnitude no fraction of a quarter turn is left.
        if quarters.abs() < 1e15 {
            cos_sin_of_quarters(quarters)
        } else {
            Orientation::from_turns(0.25 * quarters).cos_sin()
        }
    }
}

/// Cosine and sine of an angle in quarter turns. Removing whole quarter turns is exact.
#[inline(always)]
fn cos_sin_of_quarters(quarters: f64) -> DVec2 {
    let shifted = quarters + SHIFT;
    let angle = (quarters - (shifted - SHIFT)) * FRAC_PI_2;
    let (sin, cos) = (sin_kernel(angle), cos_kernel(angle));
    // (c, s), (−s, c), (−c, −s), (s, −c) in the four quadrants, without a branch that would be
    // mispredicted.
    let quadrant = shifted.to_bits();
    let odd = (quadrant & 1).wrapping_neg();
    let exchanged = (cos.to_bits() ^ sin.to_bits()) & odd;
    let negated = |bits: u64, quadrant: u64| f64::from_bits(bits ^ ((quadrant & 2) << 62));
    DVec2::new(
        negated(cos.to_bits() ^ exchanged, quadrant.wrapping_add(1)),
        negated(sin.to_bits() ^ exchanged, quadrant),
    )
}

/// Adding 1.5 × 2^52 leaves no bits for a fraction, so the default rounding gives an integer; the
/// last bits of the sum are those of the integer.
const SHIFT: f64 = 6_755_399_441_055_744.0;

/// Rounds to the nearest integer, without a library call for magnitudes that have a fraction.
#[inline]
fn nearest_integer(x: f64) -> f64 {
    if x.abs() < 1.0e15 {
        (x + SHIFT) - SHIFT
    } else {
        x.round()
    }
}

// The coefficients have the published digits; the compiler rounds them to the nearest float. The
// terms are summed in pairs for instruction-level parallelism; their rounding is far below that of
// the leading terms.
/// Minimax polynomial of sin on |x| ≤ π/4 (Sun Microsystems' fdlibm 5.3, `k_sin.c`).
#[expect(clippy::excessive_precision, reason = "published digits")]
#[inline]
fn sin_kernel(x: f64) -> f64 {
    const S1: f64 = -1.666_666_666_666_663_243_48e-1;
    const S2: f64 = 8.333_333_333_322_489_461_24e-3;
    const S3: f64 = -1.984_126_982_985_794_931_34e-4;
    const S4: f64 = 2.755_731_370_707_006_767_89e-6;
    const S5: f64 = -2.505_076_025_340_686_341_95e-8;
    const S6: f64 = 1.589_690_995_211_550_102_21e-10;
    let z = x * x;
    let zz = z * z;
    x + (z * x) * (((S1 + z * S2) + zz * (S3 + z * S4)) + (zz * zz) * (S5 + z * S6))
}

/// Minimax polynomial of cos on |x| ≤ π/4 (Sun Microsystems' fdlibm 5.3, `k_cos.c`).
#[expect(clippy::excessive_precision, reason = "published digits")]
#[inline]
fn cos_kernel(x: f64) -> f64 {
    const C1: f64 = 4.166_666_666_666_660_190_37e-2;
    const C2: f64 = -1.388_888_888_887_410_957_49e-3;
    const C3: f64 = 2.480_158_728_947_672_941_78e-5;
    const C4: f64 = -2.755_731_435_139_066_330_35e-7;
    const C5: f64 = 2.087_572_321_298_174_827_90e-9;
    const C6: f64 = -1.135_964_755_778_819_482_65e-11;
    let z = x * x;
    let zz = z * z;
    let r = z * (((C1 + z * C2) + zz * (C3 + z * C4)) + (zz * zz) * (C5 + z * C6));
    let half = 0.5 * z;
    let w = 1.0 - half;
    w + (((1.0 - w) - half) + z * r)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn cosine_and_sine_agree_with_libm(turns in -0.5..0.5f64) {
            let ours = Orientation::from_turns(turns).cos_sin();
            let (sin, cos) = libm::sincos(turns * TAU);
            // The argument of the reference is itself rounded: half an ulp of π.
            prop_assert!((ours.x - cos).abs() < 5e-16 && (ours.y - sin).abs() < 5e-16);
        }

        #[test]
        fn whole_turns_change_no_bit(numerator in -(1i64 << 30)..(1i64 << 30), whole in -1000i64..1000) {
            let fraction = numerator as f64 / (1i64 << 32) as f64;
            let turned = Orientation::from_turns(fraction + whole as f64);
            prop_assert_eq!(turned.cos_sin(), Orientation::from_turns(fraction).cos_sin());
        }

        #[test]
        fn any_bits_stay_in_range(bits in any::<u64>()) {
            let turns = f64::from_bits(bits);
            prop_assume!(turns.is_finite());
            let orientation = Orientation::from_turns(turns);
            prop_assert!(orientation.turns().abs() <= 0.5);
            prop_assert!((orientation.cos_sin().length() - 1.0).abs() < 1e-15);
        }
    }

    proptest! {
        #[test]
        fn turning_agrees_with_turned_and_cos_sin(
            turns in -0.5..0.5f64, rate in -1e3..1e3f64, exponent in -10..40i32, duration in 0.0..1.0f64,
        ) {
            let duration = duration * 2f64.powi(exponent);
            let orientation = Orientation::from_turns(turns);
            let [one, other] =
                [Turning::new(orientation, rate).cos_sin_at(duration), orientation.turned(rate, duration).cos_sin()];
            // Three roundings for each of the two angles, and those of their cosines and sines.
            let bound = 8.0 * f64::EPSILON * (1.0 + (rate * duration).abs());
            prop_assert!((one - other).length() <= bound, "{one} {other}");
        }
    }

    #[test]
    fn quarter_turns_are_exact() {
        let quarters = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
        for (i, (cos, sin)) in quarters.into_iter().enumerate() {
            let rotation = Orientation::from_turns(0.25 * i as f64).cos_sin();
            assert_eq!((rotation.x, rotation.y), (cos, sin));
        }
    }
}
