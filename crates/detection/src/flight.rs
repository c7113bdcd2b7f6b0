//! The positions and orientations of two bodies in flight at a given time.

use carom_geometry::{Circle, Outline};
use carom_kinematics::{RelativeMotion, Turning};
use glam::DVec2;

/// The relative motion of two bodies, with quantities common to all searches.
pub(crate) struct Flight<'a> {
    pub(crate) motion: &'a RelativeMotion,
    /// Angular velocities; 0 for a disc centred on its centre of mass.
    pub(crate) spin: [f64; 2],
    turning: [Turning; 2],
    /// |V|
    pub(crate) speed: f64,
    rotation_at_start: [DVec2; 2],
}

/// The positions and orientations of the bodies of a flight at one time.
#[derive(Clone, Copy)]
pub(crate) struct Pose {
    pub(crate) time: f64,
    /// X + V t
    pub(crate) separation: DVec2,
    rotation: [DVec2; 2],
}

impl<'a> Flight<'a> {
    pub(crate) fn new(a: Outline<'_>, b: Outline<'_>, motion: &'a RelativeMotion) -> Self {
        Self::of_bodies([is_centred_disc(a), is_centred_disc(b)], motion)
    }

    /// The flight of two bodies, of which some are discs about their centres of mass.
    pub(crate) fn of_bodies(are_centred_discs: [bool; 2], motion: &'a RelativeMotion) -> Self {
        let mut flight = Self {
            motion,
            spin: motion.angular_velocity,
            // Written out, because `map` would copy the values through memory more than once.
            turning: [
                Turning::new(motion.orientation[0], motion.angular_velocity[0]),
                Turning::new(motion.orientation[1], motion.angular_velocity[1]),
            ],
            speed: motion.velocity.length(),
            rotation_at_start: [DVec2::X; 2],
        };
        for (body, is_centred_disc) in are_centred_discs.into_iter().enumerate() {
            if is_centred_disc {
                flight.spin[body] = 0.0;
            } else if flight.spin[body] == 0.0 {
                flight.rotation_at_start[body] = motion.orientation[body].cos_sin();
            }
        }
        flight
    }

    /// Whether some atom moves on a curved path.
    pub(crate) fn turns(&self) -> bool {
        self.spin != [0.0; 2]
    }

    /// X + V t
    #[inline]
    pub(crate) fn separation(&self, time: f64) -> DVec2 {
        self.motion.separation + self.motion.velocity * time
    }

    #[inline(always)]
    pub(crate) fn at(&self, time: f64) -> Pose {
        let rotation = |body: usize| {
            if self.spin[body] == 0.0 {
                self.rotation_at_start[body]
            } else {
                self.turning[body].cos_sin_at(time)
            }
        };
        Pose {
            time,
            separation: self.separation(time),
            rotation: [rotation(0), rotation(1)],
        }
    }
}

impl Pose {
    /// This placement with another time, for quantities that depend on the time alone.
    pub(crate) fn with_time(self, time: f64) -> Self {
        Self { time, ..self }
    }

    /// A vector in the frame of a body.
    #[inline]
    pub(crate) fn in_frame_of(&self, body: usize, vector: DVec2) -> DVec2 {
        // The inverse of a rotation is its conjugate.
        let rotation = self.rotation[body];
        DVec2::new(rotation.x, -rotation.y).rotate(vector)
    }

    /// The vector from the centre of mass of a body to a point of its frame, in the present
    /// orientation.
    #[inline]
    pub(crate) fn arm(&self, body: usize, offset: DVec2) -> DVec2 {
        self.rotation[body].rotate(offset)
    }
}

fn is_centred_disc(body: Outline<'_>) -> bool {
    body.ellipses().is_empty() && matches!(body.atoms, [only] if only.arm() == 0.0)
}

/// The circle about the centre of mass that holds the body.
pub(crate) fn bounding_circle(body: Outline<'_>) -> Circle {
    Circle {
        offset: DVec2::ZERO,
        arm: 0.0,
        radius: body.bounding_radius,
    }
}
