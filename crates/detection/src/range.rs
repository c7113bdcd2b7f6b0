//! The allowed range of the numbers of a query, and the unit of time of its search.
//!
//! The bounds of the certified search are products of up to three velocities, which underflow for
//! slow bodies and overflow for fast ones. Multiplying a velocity by a power of two is exact. A
//! query whose velocities are far from 1 is therefore searched in another unit of time. Its contact
//! time equals that of the ordinary query times the power of two, to the last bit.

use carom_geometry::Outline;
use carom_kinematics::RelativeMotion;

use crate::{Answer, Outcome, error_bound::one_norm};

/// The largest length and speed of a query: more than
/// [`MAX_MAGNITUDE`](carom_geometry::MAX_MAGNITUDE), which limits those of a single body, and
/// small enough for the product of a squared length with a length.
const MAX_OF_QUERY: f64 = 1e70;

/// The smallest speed of a query other than 0; contact times of slower pairs would overflow.
const MIN_SPEED: f64 = 1e-150;

/// Speeds in this range need no other unit of time.
const ORDINARY: std::ops::Range<f64> = 1e-12..1e12;

/// How a query is searched.
pub(crate) enum Unit {
    /// In its own unit of time.
    Ordinary,
    /// With its velocities multiplied by this power of two.
    Scaled(f64),
    /// Not at all: a number is not finite, too large, or too small.
    OutOfRange,
}

/// The answer to a query with a number out of range.
pub(crate) const OUT_OF_RANGE: Answer = Answer {
    outcome: Outcome::OutOfRange,
    evaluations: 0,
};

/// Classifies a query up to `horizon`.
#[inline]
pub(crate) fn unit(a: Outline<'_>, b: Outline<'_>, motion: &RelativeMotion, horizon: f64) -> Unit {
    // The length of a wall that does not turn is unrelated to the motion; a half-plane has none.
    let radius = |body: Outline<'_>, spin: f64| {
        let is_unbounded = body.bounding_radius == f64::INFINITY;
        if body.is_wall() && (spin == 0.0 || is_unbounded) {
            0.0
        } else {
            body.bounding_radius
        }
    };
    let [spin_a, spin_b] = motion.angular_velocity;
    unit_of_radii([radius(a, spin_a), radius(b, spin_b)], motion, horizon)
}

/// Classifies a query of bodies with these bounding radii (length) up to `horizon`.
#[inline]
pub(crate) fn unit_of_radii(
    [radius_a, radius_b]: [f64; 2],
    motion: &RelativeMotion,
    horizon: f64,
) -> Unit {
    let [spin_a, spin_b] = motion.angular_velocity.map(f64::abs);
    let size = one_norm(motion.separation) + (radius_a + radius_b) + motion.separation_error;
    let speed = one_norm(motion.velocity) + (spin_a * radius_a + spin_b * radius_b);
    let given = speed + motion.velocity_error;
    let angles = (motion.orientation[0].turns() + motion.orientation[1].turns())
        + (motion.orientation_error[0] + motion.orientation_error[1]);
    let errors = motion.separation_error.min(motion.velocity_error);
    let angle_errors = motion.orientation_error[0].min(motion.orientation_error[1]);
    // NaN fails every comparison but is ignored by min(); the sums propagate it.
    let is_in_range = (size <= MAX_OF_QUERY)
        & (given <= MAX_OF_QUERY)
        & (angles.abs() <= MAX_OF_QUERY)
        & (errors >= 0.0)
        & (angle_errors >= 0.0)
        & !horizon.is_nan();
    if is_in_range & (ORDINARY.contains(&speed) | (given == 0.0)) {
        Unit::Ordinary
    } else {
        extraordinary(is_in_range, speed)
    }
}

#[cold]
fn extraordinary(is_in_range: bool, speed: f64) -> Unit {
    if !is_in_range {
        Unit::OutOfRange
    } else if speed == 0.0 {
        Unit::Ordinary
    } else if speed < MIN_SPEED {
        Unit::OutOfRange
    } else {
        Unit::Scaled(power_of_two_over(speed))
    }
}

/// 2^−k for a speed from 2^k to 2^(k+1).
fn power_of_two_over(speed: f64) -> f64 {
    const EXPONENT: u64 = 0x7FF << 52;
    f64::from_bits(((2 * 1023) << 52) - (speed.to_bits() & EXPONENT))
}

/// The query with its velocities multiplied by `factor`.
pub(crate) fn faster(motion: &RelativeMotion, factor: f64) -> RelativeMotion {
    RelativeMotion {
        velocity: motion.velocity * factor,
        angular_velocity: motion.angular_velocity.map(|spin| spin * factor),
        velocity_error: motion.velocity_error * factor,
        ..*motion
    }
}

/// The answer with its times multiplied by `factor`.
pub(crate) fn later(answer: Answer, factor: f64) -> Answer {
    Answer {
        outcome: answer.outcome.later(factor),
        ..answer
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_scaled_speed_is_from_one_to_two(power in -150.0..70.0f64) {
            let speed = 10f64.powf(power);
            let scaled = speed * power_of_two_over(speed);
            prop_assert!((1.0..2.0).contains(&scaled), "{scaled}");
        }
    }
}
