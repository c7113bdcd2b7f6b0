//! The motion of one body: constant velocity and angular velocity since its subjective time.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::Orientation;

/// Position, orientation and velocities of a body, valid from its subjective time until its next
/// contact or edit.
///
/// Times are offsets from an origin common to all bodies of a system.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[doc(alias = "roto-translation")]
pub struct Motion {
    /// Position of the centre of mass at the subjective time (length).
    pub position: DVec2,
    /// Velocity of the centre of mass (length per time).
    pub velocity: DVec2,
    /// Orientation at the subjective time.
    pub orientation: Orientation,
    /// Angular velocity (radians per time, counter-clockwise).
    #[doc(alias = "spin")]
    pub angular_velocity: f64,
    /// The subjective time: the time at which this motion began.
    #[doc(alias = "subjective time")]
    pub time: f64,
}

impl Motion {
    /// A body at rest at `position`, time 0.
    pub fn at_rest(position: DVec2) -> Self {
        Self {
            position,
            velocity: DVec2::ZERO,
            orientation: Orientation::default(),
            angular_velocity: 0.0,
            time: 0.0,
        }
    }

    /// This motion with its subjective time moved to `time`.
    #[must_use]
    pub fn at(&self, time: f64) -> Self {
        let duration = time - self.time;
        Self {
            position: self.position + self.velocity * duration,
            orientation: self.orientation.turned(self.angular_velocity, duration),
            time,
            ..*self
        }
    }

    /// This motion with velocity and angular velocity multiplied by a factor.
    #[must_use]
    #[inline]
    pub fn slowed(&self, factor: f64) -> Self {
        Self {
            velocity: self.velocity * factor,
            angular_velocity: self.angular_velocity * factor,
            ..*self
        }
    }

    /// Position of the centre of mass at `time` (length).
    pub fn position_at(&self, time: f64) -> DVec2 {
        self.position + self.velocity * (time - self.time)
    }

    /// Whether velocity and angular velocity are 0.
    pub fn is_at_rest(&self) -> bool {
        self.velocity == DVec2::ZERO && self.angular_velocity == 0.0
    }

    /// Velocity of the material point at `arm` from the centre of mass (length per time).
    pub fn velocity_of(&self, arm: DVec2) -> DVec2 {
        self.velocity + self.angular_velocity * arm.perp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn velocity_of_a_material_point_is_its_difference_quotient() {
        let motion = Motion {
            velocity: DVec2::new(0.3, -0.2),
            orientation: Orientation::from_turns(0.1),
            angular_velocity: 2.0,
            time: 5.0,
            ..Motion::at_rest(DVec2::new(1.0, 2.0))
        };
        let offset = DVec2::new(0.4, 0.7);
        let place = |t: f64| {
            let there = motion.at(t);
            there.position + there.orientation.cos_sin().rotate(offset)
        };
        let h = 1e-6;
        let measured = (place(5.0 + h) - place(5.0 - h)) / (2.0 * h);
        let arm = motion.orientation.cos_sin().rotate(offset);
        assert!((measured - motion.velocity_of(arm)).length() < 1e-9);
    }
}
