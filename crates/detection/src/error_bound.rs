//! The rounding bounds E and E': how far the computed gap of two atoms and its rate can be from the exact ones.

use carom_geometry::{Atom, Circle};
use carom_kinematics::{HALF_ULP as U, RelativeMotion};
use glam::DVec2;

/// Bounds on the rounding of the gap between an atom of A and an atom of B, and of the rate of the gap.
///
/// With u = 2⁻⁵³, |·|₁ = |x| + |y|, X and V the relative place and velocity of the centres, r the arms
/// of the atoms, s the sum of their radii, ω the angular velocities, and δ the errors that place, velocity
/// and angles came with:
///
/// E(t) = u (5 |X|₁ + 17 (r_A + r_B) + 2 s) + δX + r_A δα_A + r_B δα_B
///      + u (7 |V|₁ + 4 (|ω_A| r_A + |ω_B| r_B)) t
///
/// E'(t) = L (2 E/|d| + 12 u) + max(|ω_A|, |ω_B|) E + δV,  L = |V| + |ω_A| r_A + |ω_B| r_B
///
/// **E**, rounding by rounding, to first order in u:
/// * X + V t: u |V t| for the product, u |X + V t| for the sum, and u |V| t for the rounding of V, the
///   difference of two velocities;
/// * the angle in turns: 3 u |ω t| for the product, the conversion from radians and its constant 1/2π, and
///   u (|ω t| + π) for the sum with the orientation; dropping whole turns and quarters is exact. Back to radians
///   1.6 u (product and constant, at most π/4), cosine and sine 2 u together, the rotation of r by them 3 u:
///   in all u r (4 |ω t| + 10), where 12 is taken;
/// * r_B − r_A: u (r_A + r_B); d: u |d|; its length: 2 u |d|; s: u s; the gap: u (|d| + s). As
///   |d| ≤ |X| + |V| t + r_A + r_B, that is 4 u of each of these more, and 2 u s.
///
/// So the vector d itself is off by no more than E.
///
/// **E'**: g' = n·d' with n = d/|d|. The normal is off by at most 2 E/|d|. Of d' = V + ω_B r_B^⊥ − ω_A r_A^⊥ the
/// turned arms bring |ω| times their share of E, its four operations 4 u L, the scalar product 2 u L, the length and
/// the division by it 4 u L: 10 u L, where 12 is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorBound {
    start: f64,
    rate: f64,
    /// L
    speed: f64,
    /// max(|ω_A|, |ω_B|)
    spin: f64,
    /// δV
    velocity: f64,
}

impl ErrorBound {
    /// The bounds for one pair of atoms.
    pub fn new(motion: &RelativeMotion, a: &Atom, b: &Atom) -> Self {
        let circles = [Circle::from(a), Circle::from(b)];
        Self::of_circles(motion, motion.velocity.length(), motion.angular_velocity, &circles)
    }

    /// The same for any circles, where |V| and the angular velocities that matter are at hand.
    #[inline]
    pub(crate) fn of_circles(
        motion: &RelativeMotion,
        speed: f64,
        spin: [f64; 2],
        circles: &[Circle; 2],
    ) -> Self {
        let [a, b] = circles;
        let [spin_a, spin_b] = spin.map(f64::abs);
        let rim_speed = spin_a * a.arm + spin_b * b.arm;
        let places = 5.0 * one_norm(motion.separation) + 17.0 * (a.arm + b.arm) + 2.0 * (a.radius + b.radius);
        let given = motion.separation_error
            + (a.arm * motion.orientation_error[0] + b.arm * motion.orientation_error[1]);
        Self {
            start: U * places + given,
            rate: U * (7.0 * one_norm(motion.velocity) + 4.0 * rim_speed),
            speed: speed + rim_speed,
            spin: spin_a.max(spin_b),
            velocity: motion.velocity_error,
        }
    }

    /// E, the bound on the gap at `time` (length).
    #[inline]
    pub fn at(&self, time: f64) -> f64 {
        self.start + self.rate * time
    }

    /// E', the bound on the rate of the gap where the centres are `distance` apart (length per time).
    pub fn of_rate(&self, time: f64, distance: f64) -> f64 {
        let [constant, over_distance] = self.rate_terms(self.at(time));
        constant + over_distance / distance
    }

    /// E' for a given E, as a constant and what is to be divided by the distance.
    #[inline]
    pub(crate) fn rate_terms(&self, error: f64) -> [f64; 2] {
        [12.0 * U * self.speed + self.spin * error + self.velocity, 2.0 * self.speed * error]
    }

    /// L, a bound on |d'| at any time (length per time).
    #[inline]
    pub(crate) fn speed(&self) -> f64 {
        self.speed
    }
}

pub(crate) fn one_norm(v: DVec2) -> f64 {
    v.x.abs() + v.y.abs()
}
