//! The motion of a driven body: how it deviates from uniform motion.

use std::ops::Neg;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{HALF_ULP, Motion, Orientation, RelativeMotion, relative_motion::one_norm};

/// Up to this angle (radians) sin θ − θ is taken from six terms of its series. Larger: its rest
/// shows. Smaller: the difference loses digits.
const SMALL_ANGLE: f64 = 0.5;

/// Acceleration and oscillation of a body, added to its uniform motion: a constant acceleration g,
/// an oscillation A sin(Ω t + φ), or both.
///
/// The motion of the body holds its position and velocity at time 0, with those of the oscillation;
/// the drive adds the deviation from uniform motion since then.
///
/// ```
/// use carom_kinematics::{Drive, Motion, Orientation};
/// use glam::DVec2;
///
/// // A wall that oscillates by 0.1 about y = 0.5, and passes it upwards at time 0.
/// let drive = Drive::oscillation(0.1 * DVec2::Y, 2.0, Orientation::default());
/// let [place, velocity] = drive.oscillation_now();
/// let wall = Motion { velocity, ..Motion::at_rest(DVec2::new(0.0, 0.5) + place) };
/// let quarter = drive.applied(&wall, std::f64::consts::FRAC_PI_4);
/// assert!((quarter.position.y - 0.6).abs() < 1e-15 && quarter.velocity.y.abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[doc(alias = "oscillating wall")]
#[doc(alias = "shaker")]
pub struct Drive {
    /// g (length per time squared)
    acceleration: DVec2,
    /// A (length)
    amplitude: DVec2,
    /// Ω (radians per time)
    frequency: f64,
    /// φ at time 0.
    phase: Orientation,
}

/// How a motion deviates from uniform motion after some time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveDeviation {
    /// Of the position (length).
    pub position: DVec2,
    /// Of the velocity (length per time).
    pub velocity: DVec2,
    /// The acceleration (length per time squared).
    pub acceleration: DVec2,
    /// Bound on the rounding of the position (length).
    pub position_error: f64,
    /// Bound on the rounding of the velocity (length per time).
    pub velocity_error: f64,
    /// Bound on the rounding of the acceleration (length per time squared).
    pub acceleration_error: f64,
}

/// Bounds on a drive from some time on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveBounds {
    /// On the change of the velocity (length per time).
    pub velocity: f64,
    /// On the acceleration (length per time squared).
    pub acceleration: f64,
    /// On the rate of the acceleration (length per time cubed).
    pub jerk: f64,
}

impl Drive {
    /// A constant acceleration g (length per time squared).
    pub fn acceleration(acceleration: DVec2) -> Self {
        Self {
            acceleration,
            ..Self::default()
        }
    }

    /// An oscillation A sin(Ω t + φ) with the amplitude A (length), the angular frequency Ω
    /// (radians per time) and the phase φ.
    pub fn oscillation(amplitude: DVec2, frequency: f64, phase: Orientation) -> Self {
        Self {
            amplitude,
            frequency,
            phase,
            ..Self::default()
        }
    }

    /// This drive less another one, of which at most one oscillates.
    #[must_use]
    pub fn less(&self, other: &Self) -> Self {
        debug_assert!(self.frequency == 0.0 || other.frequency == 0.0);
        if other.frequency == 0.0 {
            self.accelerated(-other.acceleration)
        } else {
            (-*other).accelerated(self.acceleration)
        }
    }

    /// This drive with a further constant acceleration (length per time squared).
    #[must_use]
    pub fn accelerated(&self, acceleration: DVec2) -> Self {
        Self {
            acceleration: self.acceleration + acceleration,
            ..*self
        }
    }

    /// Whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.acceleration.is_finite()
            && self.amplitude.is_finite()
            && self.frequency.is_finite()
            && self.phase.turns().is_finite()
    }

    /// The drive whose time 0 is `time` of this one.
    #[must_use]
    pub fn restarted(&self, time: f64) -> Self {
        Self {
            phase: self.phase.turned(self.frequency, time),
            ..*self
        }
    }

    /// The drive that runs through the places of this one in the opposite order.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self {
            phase: Orientation::from_turns(0.5 - self.phase.turns()),
            ..*self
        }
    }

    /// Displacement (length) and velocity (length per time) of the oscillation at time 0.
    pub fn oscillation_now(&self) -> [DVec2; 2] {
        let now = self.cos_sin(0.0);
        [now.y, self.frequency * now.x].map(|factor| factor * self.amplitude)
    }

    /// The motion at `time` of a body with this drive and this motion at time 0.
    pub fn applied(&self, motion: &Motion, time: f64) -> Motion {
        let (there, deviation) = (motion.at(time), self.deviation(0.0, time));
        Motion {
            position: there.position + deviation.position,
            velocity: there.velocity + deviation.velocity,
            ..there
        }
    }

    /// The position and velocity that a body has beyond uniform motion `elapsed` (time) after
    /// `from`, and its acceleration then.
    pub fn deviation(&self, from: f64, elapsed: f64) -> DriveDeviation {
        let mut deviation = DriveDeviation {
            position: (0.5 * elapsed * elapsed) * self.acceleration,
            velocity: elapsed * self.acceleration,
            acceleration: self.acceleration,
            position_error: 0.0,
            velocity_error: 0.0,
            acceleration_error: 0.0,
        };
        if self.frequency != 0.0 {
            let [before, now] = [from, from + elapsed].map(|time| self.cos_sin(time));
            let turned = self.frequency * elapsed;
            let half = Orientation::default()
                .turned(self.frequency, 0.5 * elapsed)
                .cos_sin();
            // cos θ − 1, sin θ and sin θ − θ. As differences of places in the swing they would have
            // its rounding, also where the way is far shorter than the amplitude.
            let (versine, sine) = (-2.0 * half.y * half.y, 2.0 * half.y * half.x);
            let lag = sine_less_angle(turned, sine);
            let [size, speed] = [1.0, self.frequency].map(|power| power * self.amplitude);
            deviation.position += (versine * before.y + lag * before.x) * size;
            deviation.velocity += (versine * before.x - sine * before.y) * speed;
            deviation.acceleration -= (self.frequency * now.y) * speed;
            // Each angle has a few roundings of itself and of a turn, cosine and sine one more.
            let angle = self.frequency.abs() * (from.abs() + elapsed);
            let rounding = HALF_ULP * (8.0 * angle + 32.0);
            // A way far shorter than the amplitude has a small share of its rounding.
            let share = (1.0 + turned.abs()).min(2.0 * (versine.abs() + lag.abs()));
            deviation.position_error = rounding * size.length() * share;
            deviation.velocity_error = rounding * speed.length();
            deviation.acceleration_error = rounding * (self.frequency.abs() * speed.length());
        }
        deviation.position_error += 4.0 * HALF_ULP * deviation.position.length();
        deviation.velocity_error += 4.0 * HALF_ULP * deviation.velocity.length();
        deviation.acceleration_error += 4.0 * HALF_ULP * deviation.acceleration.length();
        deviation
    }

    /// The part of this drive along a direction, a unit vector.
    #[must_use]
    pub fn along(&self, direction: DVec2) -> Self {
        let part = |vector: DVec2| vector.dot(direction) * direction;
        Self {
            acceleration: part(self.acceleration),
            amplitude: part(self.amplitude),
            ..*self
        }
    }

    /// Bounds for a duration (time).
    pub fn bounds(&self, duration: f64) -> DriveBounds {
        let size = self.amplitude.length();
        let speed = size * self.frequency.abs();
        let acceleration = speed * self.frequency.abs();
        let constant = self.acceleration.length();
        DriveBounds {
            velocity: (2.0 * speed).min(acceleration * duration) + constant * duration,
            acceleration: acceleration + constant,
            jerk: acceleration * self.frequency.abs(),
        }
    }

    /// A bound on the speed until `time` of a body that is at rest but for its drive (length per
    /// time).
    pub fn max_speed(&self, time: f64) -> f64 {
        self.amplitude.length() * self.frequency.abs() + self.acceleration.length() * time
    }

    /// A bound on the way of such a body in a duration that ends at `time` (length).
    pub fn max_displacement(&self, duration: f64, time: f64) -> f64 {
        let amplitude = self.amplitude.length();
        let speed = amplitude * self.frequency.abs();
        (speed * duration).min(2.0 * amplitude) + self.acceleration.length() * time * duration
    }

    /// A (length).
    pub fn amplitude(&self) -> DVec2 {
        self.amplitude
    }

    /// φ at time 0.
    pub fn phase(&self) -> Orientation {
        self.phase
    }

    /// Ω (radians per time).
    pub fn frequency(&self) -> f64 {
        self.frequency
    }

    /// (cos, sin) of Ω t + φ
    fn cos_sin(&self, time: f64) -> DVec2 {
        self.phase.turned(self.frequency, time).cos_sin()
    }
}

/// sin θ − θ, where sin θ is known: by its series for small angles, of which the next term is below
/// 10⁻¹⁷ of the whole.
fn sine_less_angle(angle: f64, sine: f64) -> f64 {
    if angle.abs() > SMALL_ANGLE {
        return sine - angle;
    }
    let square = angle * angle;
    // (2n) (2n + 1), from the last term on.
    let terms = [210.0, 156.0, 110.0, 72.0, 42.0, 20.0];
    let series = terms
        .iter()
        .fold(1.0, |sum, term| 1.0 - square / term * sum);
    -angle * square / 6.0 * series
}

impl Neg for Drive {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            acceleration: -self.acceleration,
            amplitude: -self.amplitude,
            ..self
        }
    }
}

impl RelativeMotion {
    /// The relative motion `elapsed` (time) after this one, which starts at `from`, of a body B
    /// with a drive relative to A; and the deviation of B.
    pub fn driven(&self, drive: &Drive, from: f64, elapsed: f64) -> (Self, DriveDeviation) {
        let way = self.velocity * elapsed;
        let turns = [0, 1].map(|body| self.angular_velocity[body] * elapsed);
        let uniform = Self {
            separation: self.separation + way,
            orientation: [0, 1]
                .map(|body| self.orientation[body].turned(self.angular_velocity[body], elapsed)),
            separation_error: self.separation_error
                + HALF_ULP * (one_norm(self.separation) + 5.0 * one_norm(way)),
            velocity_error: self.velocity_error,
            orientation_error: [0, 1].map(|body| {
                let rounding = if turns[body] == 0.0 {
                    0.0
                } else {
                    HALF_ULP * (5.0 * turns[body].abs() + 4.0)
                };
                self.orientation_error[body] + rounding
            }),
            ..*self
        };
        let deviation = drive.deviation(from, elapsed);
        (uniform.deviated(&deviation), deviation)
    }

    /// The relative motion with what a drive of B adds.
    #[must_use]
    pub fn deviated(&self, deviation: &DriveDeviation) -> Self {
        let separation = self.separation + deviation.position;
        let velocity = self.velocity + deviation.velocity;
        Self {
            separation,
            velocity,
            separation_error: self.separation_error
                + (deviation.position_error + HALF_ULP * one_norm(separation)),
            velocity_error: self.velocity_error
                + (deviation.velocity_error + HALF_ULP * one_norm(velocity)),
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// By sin ½ and sin ¼ to 32 digits.
    #[test]
    fn the_series_of_the_sine_less_its_angle_is_exact_to_rounding() {
        for (angle, exact) in [
            (0.5, -0.020_574_461_395_797_f64),
            (0.25, -0.002_596_040_745_477_070_4),
        ] {
            for sign in [1.0, -1.0] {
                let found = sine_less_angle(sign * angle, f64::NAN);
                let off = (found / (sign * exact) - 1.0).abs();
                assert!(off < 4.0 * HALF_ULP, "{angle}: {off:e}");
            }
        }
    }

    proptest! {
        #[test]
        fn the_deviation_is_what_uniform_motion_lacks(
            a in -2.0..2.0f64, g in -2.0..2.0f64, frequency in 0.1..9.0f64, turns in -0.5..0.5f64,
            from in 0.0..3.0f64, elapsed in 0.0..3.0f64,
        ) {
            let drive = Drive {
                acceleration: DVec2::new(0.0, g),
                ..Drive::oscillation(DVec2::new(a, -0.5 * a), frequency, Orientation::from_turns(turns))
            };
            let velocity = DVec2::new(0.3, 0.1) + drive.oscillation_now()[1];
            let body = Motion { velocity, ..Motion::at_rest(DVec2::ONE) };
            let [start, end] = [from, from + elapsed].map(|time| drive.applied(&body, time));
            let deviation = drive.deviation(from, elapsed);
            let straight = start.at(from + elapsed);
            let allowed = 1e-15 + 2.0 * deviation.position_error;
            prop_assert!((end.position - straight.position - deviation.position).abs().max_element() < allowed * 20.0);
            let allowed = 1e-15 + 2.0 * deviation.velocity_error;
            prop_assert!((end.velocity - straight.velocity - deviation.velocity).abs().max_element() < allowed * 20.0);
            let bounds = drive.bounds(elapsed);
            prop_assert!(deviation.velocity.length() <= bounds.velocity * (1.0 + 1e-12) + 1e-14);
            prop_assert!(deviation.acceleration.length() <= bounds.acceleration * (1.0 + 1e-12));
            prop_assert!((end.velocity - DVec2::new(0.3, 0.1)).length() <= drive.max_speed(from + elapsed) * (1.0 + 1e-12) + 1e-14);
            let way = (end.position - start.position - elapsed * DVec2::new(0.3, 0.1)).length();
            prop_assert!(way <= drive.max_displacement(elapsed, from + elapsed) * (1.0 + 1e-12) + 1e-14);
        }

        /// The deviation in a small part of a very large swing is that of the constant acceleration
        /// there, to its own error and to the term that follows, θ/3 of it.
        #[test]
        fn a_small_part_of_a_large_swing_has_no_rounding_of_its_amplitude(
            turns in -0.5..0.5f64, from in 0.0..1e-3f64, elapsed in 1e-9..1e-6f64,
        ) {
            let drive = Drive::oscillation(DVec2::new(1e12, 0.0), 1.5, Orientation::from_turns(turns));
            let deviation = drive.deviation(from, elapsed);
            prop_assert!(deviation.position_error < 1e-13 * 1e12 * elapsed * elapsed, "{deviation:?}");
            let acceleration = -1e12 * 2.25 * (std::f64::consts::TAU * turns + 1.5 * from).sin();
            let expected = 0.5 * acceleration * elapsed * elapsed;
            let next = 1e12 * (1.5 * elapsed).powi(3) / 6.0;
            prop_assert!((deviation.position.x - expected).abs() < next + 20.0 * deviation.position_error, "{deviation:?}");
        }

        #[test]
        fn velocity_and_acceleration_are_difference_quotients(
            a in -2.0..2.0f64, g in -2.0..2.0f64, frequency in 0.1..9.0f64, time in 0.1..3.0f64,
        ) {
            let drive = Drive {
                acceleration: DVec2::new(g, 0.0),
                ..Drive::oscillation(DVec2::new(a, a), frequency, Orientation::from_turns(0.1))
            };
            let at = |time: f64| drive.applied(&Motion::at_rest(DVec2::ZERO), time);
            let h = 1e-5;
            let rate = (at(time + h).position - at(time - h).position) / (2.0 * h);
            prop_assert!((rate - at(time).velocity).length() < 1e-6);
            let bend = (at(time + h).velocity - at(time - h).velocity) / (2.0 * h);
            prop_assert!((bend - drive.deviation(0.0, time).acceleration).length() < 1e-5);
        }
    }
}
