//! Two bodies at a common time and in one periodic image: the relative motion, the input of
//! detection.

use glam::DVec2;

use crate::{Motion, Orientation};

/// Half the distance from 1 to the next float: the largest relative error of one rounding.
pub const HALF_ULP: f64 = 0.5 * f64::EPSILON;

/// The motion of body B relative to body A, from a common time 0 on.
///
/// The errors bound the rounding of these numbers relative to the motions from which they were
/// computed; they are 0 for exact numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeMotion {
    /// From the centre of A to the centre of the image of B (length).
    pub separation: DVec2,
    /// Velocity of B less that of A (length per time).
    pub velocity: DVec2,
    /// Orientations of A and B.
    pub orientation: [Orientation; 2],
    /// Angular velocities of A and B (radians per time).
    pub angular_velocity: [f64; 2],
    /// Bound on the rounding of the separation (length).
    pub separation_error: f64,
    /// Bound on the rounding of the relative velocity, including the part of it that a response
    /// cannot resolve (length per time).
    pub velocity_error: f64,
    /// Bounds on the rounding of the two orientations (radians).
    pub orientation_error: [f64; 2],
}

impl RelativeMotion {
    /// The relative motion at `time` of A and the image of B shifted by `shift` (length).
    ///
    /// Exchanging A and B, with the opposite shift, only exchanges signs, to the bit.
    ///
    /// ```
    /// use carom_kinematics::{Motion, RelativeMotion};
    /// use glam::DVec2;
    ///
    /// let a = Motion { velocity: DVec2::X, ..Motion::at_rest(DVec2::new(0.75, 0.5)) };
    /// let b = Motion::at_rest(DVec2::new(0.25, 0.5));
    /// // The image of B one box to the right.
    /// let pair = RelativeMotion::between(&a, &b, DVec2::X, 0.25);
    /// assert_eq!(pair.separation, DVec2::new(0.25, 0.0));
    /// ```
    #[doc(alias = "equalise")]
    #[inline]
    pub fn between(a: &Motion, b: &Motion, shift: DVec2, time: f64) -> Self {
        let (duration_a, duration_b) = (time - a.time, time - b.time);
        let (path_a, path_b) = (a.velocity * duration_a, b.velocity * duration_b);
        let (place_a, place_b) = (a.position + path_a, b.position + path_b);
        let separation = (place_b - place_a) + shift;
        // Each path has three roundings (duration, product, and its share of the sum), each sum
        // one.
        let paths = one_norm(path_a) + one_norm(path_b);
        let places = one_norm(place_a) + one_norm(place_b) + one_norm(place_b - place_a);
        // Of the angle: the duration, two products and the sum have one rounding each, the constant
        // 1/2π has 0.56; for the turns at the start, the sum has one rounding of up to π radians.
        let turn_error = |spin: f64, duration: f64| {
            if spin == 0.0 {
                0.0
            } else {
                HALF_ULP * (5.0 * (spin * duration).abs() + 4.0)
            }
        };
        Self {
            separation,
            velocity: b.velocity - a.velocity,
            orientation: [
                a.orientation.turned(a.angular_velocity, duration_a),
                b.orientation.turned(b.angular_velocity, duration_b),
            ],
            angular_velocity: [a.angular_velocity, b.angular_velocity],
            separation_error: HALF_ULP * (2.0 * places + 4.0 * paths + one_norm(separation)),
            velocity_error: Self::velocity_error_of([a.velocity, b.velocity]),
            orientation_error: [
                turn_error(a.angular_velocity, duration_a),
                turn_error(b.angular_velocity, duration_b),
            ],
        }
    }

    /// Bound on the rounding of the relative velocity of two bodies with these velocities, with the
    /// part of it that a response cannot resolve (length per time).
    #[inline]
    pub fn velocity_error_of([a, b]: [DVec2; 2]) -> f64 {
        2.0 * HALF_ULP * (one_norm(a) + one_norm(b))
    }

    /// The relative motion of two discs, or of two bodies that do not turn, without rounding
    /// errors.
    pub fn exactly(separation: DVec2, velocity: DVec2) -> Self {
        Self {
            separation,
            velocity,
            orientation: [Orientation::default(); 2],
            angular_velocity: [0.0; 2],
            separation_error: 0.0,
            velocity_error: 0.0,
            orientation_error: [0.0; 2],
        }
    }

    /// The motion of A relative to B.
    #[must_use]
    pub fn exchanged(&self) -> Self {
        let swap = |pair: [f64; 2]| [pair[1], pair[0]];
        Self {
            separation: -self.separation,
            velocity: -self.velocity,
            orientation: [self.orientation[1], self.orientation[0]],
            angular_velocity: swap(self.angular_velocity),
            orientation_error: swap(self.orientation_error),
            ..*self
        }
    }
}

/// |x| + |y|, an upper bound of the length without a square root.
pub(crate) fn one_norm(v: DVec2) -> f64 {
    v.x.abs() + v.y.abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn motions() -> impl Strategy<Value = Motion> {
        (
            -1.0..1.0,
            -1.0..1.0,
            -2.0..2.0,
            -2.0..2.0,
            -0.5..0.5,
            -9.0..9.0,
            -3.0..3.0,
        )
            .prop_map(
                |(x, y, vx, vy, turns, angular_velocity, time): (
                    f64,
                    f64,
                    f64,
                    f64,
                    f64,
                    f64,
                    f64,
                )| Motion {
                    position: DVec2::new(x, y),
                    velocity: DVec2::new(vx, vy),
                    orientation: Orientation::from_turns(turns),
                    angular_velocity,
                    time,
                },
            )
    }

    proptest! {
        #[test]
        fn exchanging_the_bodies_only_exchanges_signs(a in motions(), b in motions(), t in 3.0..9.0f64) {
            let shift = DVec2::new(1.0, -1.0);
            let one = RelativeMotion::between(&a, &b, shift, t);
            let other = RelativeMotion::between(&b, &a, -shift, t);
            prop_assert_eq!(one, other.exchanged());
        }

        #[test]
        fn velocities_times_a_power_of_two_give_the_same_bits(a in motions(), b in motions(), k in -30i32..30) {
            let factor = 2f64.powi(k);
            let faster = |m: &Motion| Motion {
                velocity: m.velocity * factor,
                angular_velocity: m.angular_velocity * factor,
                time: m.time / factor,
                ..*m
            };
            let one = RelativeMotion::between(&a, &b, DVec2::ZERO, 4.0);
            let two = RelativeMotion::between(&faster(&a), &faster(&b), DVec2::ZERO, 4.0 / factor);
            prop_assert_eq!(one.separation, two.separation);
            prop_assert_eq!(one.separation_error, two.separation_error);
            prop_assert_eq!(one.velocity * factor, two.velocity);
            prop_assert_eq!(one.orientation, two.orientation);
        }
    }
}
