//! The squared gap of two atoms in flight: f(t) = |d|² − s², positive while they are apart.

use carom_geometry::Atom;
use carom_kinematics::RelativeMotion;
use glam::DVec2;

use crate::ErrorBound;

/// One atom of A and one of B, whose centres are d apart and touch at the distance s.
pub(crate) struct SquaredGap<'a> {
    motion: &'a RelativeMotion,
    offsets: [DVec2; 2],
    /// Sum of the radii, s.
    contact_distance: f64,
    error: ErrorBound,
}

impl<'a> SquaredGap<'a> {
    pub(crate) fn new(motion: &'a RelativeMotion, a: &Atom, b: &Atom) -> Self {
        Self {
            motion,
            offsets: [a.offset(), b.offset()],
            contact_distance: a.radius() + b.radius(),
            error: ErrorBound::new(motion, a, b),
        }
    }

    /// f at `time` (length²).
    pub(crate) fn at(&self, time: f64) -> f64 {
        let [arm_a, arm_b] = self.arms(time);
        self.between_centres(time, arm_a, arm_b).length_squared()
            - self.contact_distance * self.contact_distance
    }

    /// The f of two atoms that are apart by the rounding bound E (length²): below it they touch.
    pub(crate) fn touching(&self, time: f64) -> f64 {
        2.0 * self.contact_distance * self.error.at(time)
    }

    /// Whether atoms that touch or overlap at `time` close, rather than part or only touch.
    ///
    /// d·d' must be below −|d| E', with the bound E' on the rounding of the closing speed that
    /// [`Exact`](crate::Exact) uses; of atoms that overlap by more than E, below what the velocities
    /// resolve.
    pub(crate) fn closes(&self, time: f64) -> bool {
        let motion = self.motion;
        let [spin_a, spin_b] = motion.angular_velocity;
        let [arm_a, arm_b] = self.arms(time);
        let d = self.between_centres(time, arm_a, arm_b);
        let velocity = motion.velocity + (spin_b * arm_b.perp() - spin_a * arm_a.perp());
        let distance = d.length();
        let overlaps = distance - self.contact_distance < -self.error.at(time);
        let threshold = if overlaps { motion.velocity_error } else { self.error.of_rate(time, distance) };
        d.dot(velocity) < -(distance * threshold)
    }

    fn arms(&self, time: f64) -> [DVec2; 2] {
        [0, 1].map(|body| {
            let offset = self.offsets[body];
            if offset == DVec2::ZERO {
                return offset;
            }
            let spin = self.motion.angular_velocity[body];
            self.motion.orientation[body].turned(spin, time).cos_sin().rotate(offset)
        })
    }

    fn between_centres(&self, time: f64, arm_a: DVec2, arm_b: DVec2) -> DVec2 {
        (self.motion.separation + self.motion.velocity * time) + (arm_b - arm_a)
    }
}
