//! The rounding bound E: how far the computed gap of two atoms can be from the exact one.

use carom_geometry::Atom;
use carom_kinematics::{HALF_ULP as U, RelativeMotion};
use glam::DVec2;

/// Bound on the rounding of the gap between an atom of A and an atom of B, as a line in time.
///
/// With u = 2⁻⁵³, |·|₁ = |x| + |y|, X and V the relative place and velocity of the centres, r the arms
/// of the atoms, s the sum of their radii, and α the errors that place and angles came with:
///
/// E(t) = u (5 |X|₁ + 17 (r_A + r_B) + 2 s) + δX + r_A δα_A + r_B δα_B
///      + u (7 |V|₁ + 4 (|ω_A| r_A + |ω_B| r_B)) t
///
/// Derivation, rounding by rounding, to first order in u:
/// * X + V t: u |V t| for the product, u |X + V t| for the sum, and 2 u |V| t for V itself;
/// * the angle in turns: u (3 |ω t| + π) (product, conversion, sum), the reduction exact, back to
///   radians and the polynomials 4 u, the rotation of r by it 3 u: u r (4 |ω t| + 12) covers them;
/// * r_B − r_A: u (r_A + r_B); d: u |d|; its length: 2 u |d|; s: u s; the gap: u |d − s|. As
///   |d| ≤ |X| + |V| t + r_A + r_B this is at most 4 u of each of those, and u s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorBound {
    start: f64,
    rate: f64,
}

impl ErrorBound {
    /// The bound for one pair of atoms.
    pub fn new(motion: &RelativeMotion, a: &Atom, b: &Atom) -> Self {
        let (arm_a, arm_b) = (a.arm(), b.arm());
        let [spin_a, spin_b] = motion.angular_velocity;
        let rim_speed = spin_a.abs() * arm_a + spin_b.abs() * arm_b;
        let places =
            5.0 * one_norm(motion.separation) + 17.0 * (arm_a + arm_b) + 2.0 * (a.radius() + b.radius());
        let given = motion.separation_error
            + (arm_a * motion.orientation_error[0] + arm_b * motion.orientation_error[1]);
        Self { start: U * places + given, rate: U * (7.0 * one_norm(motion.velocity) + 4.0 * rim_speed) }
    }

    /// The bound at `time` (length).
    pub fn at(&self, time: f64) -> f64 {
        self.start + self.rate * time
    }
}

pub(crate) fn one_norm(v: DVec2) -> f64 {
    v.x.abs() + v.y.abs()
}
