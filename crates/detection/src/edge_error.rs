//! The rounding bounds E and E' of the gap between an atom and a straight edge.
//!
//! # Lemmas
//! To first order in u, in the notation of [`EdgeErrorBound`], with D = X + V t + r from the centre
//! of the edge's body to the centre of the atom, and m the middle of the edge:
//!
//! 1. **Position.** The error of D is at most u (2 |X| + 4 |V| t + 13 r + 4 |ω_P| r t). *Proof.* As
//!    in [`error_bound`](crate::error_bound).
//! 2. **Distance.** |D| ≤ Λ. *Proof.* The search for an edge that turns is confined to the times at
//!    which |X + V t| ≤ q + s + r, with q the largest distance of a point of the edge from the
//!    centre of its body; so Λ = q + s + 2 r, or q + s for an atom whose body does not turn
//!    ([`edge_pair`](crate::edge_pair), Lemma 4). An edge that does not turn may be a wall of any
//!    length; for it Λ = |X| + |V| t + r.
//! 3. **Normal.** The error of the normal n is at most u (12 + 4 |ω_Q| t). *Proof.* Its length
//!    takes 3 u, the orientation of the body 4 u |ω_Q| t and, with cosine and sine, 4 u (see
//!    `error_bound`), the rotation by them 3 u: in all 10 u, rounded up to 12 u.
//! 4. **Gap.** The error of the gap is at most E. *Proof.* To Lemma 1, and the error of the normal
//!    times Λ, the product n·D adds 2 u Λ. The place of the line, c = n·m in the frame of the body,
//!    has an error of 6 u |m|, and its subtraction adds u (Λ + |m|). The difference |n·D − c| − s
//!    adds u Λ + u |m| + 2 u s. Beyond an end the gap is |e·D − e·m| less half the length of the
//!    edge. The 3 u of that length are at most 3 u (Λ + |m|) where they matter. These are 18 u Λ
//!    and 8 u |m|, since the last two cases exclude each other.
//! 5. **Rate.** The error of the rate n·(D' − ω_Q D^⊥) is at most E'. *Proof.* The error of the
//!    normal is multiplied by L. D and the rotated arm add |ω_Q| and |ω_P| times their share of E.
//!    The six operations of the velocity and the scalar product add 6 u L. No term is divided by a
//!    distance, because the normal of an edge does not depend on the position of the atom.

use carom_geometry::{Circle, Edge};
use carom_kinematics::{HALF_ULP as U, RelativeMotion};

use crate::error_bound::one_norm;

/// Bounds on the rounding of the gap between an atom of one body P and a straight edge of the other
/// body Q, and of its rate.
///
/// With u = 2⁻⁵³, |·|₁ = |x| + |y|, X and V the relative position and velocity of the centres of
/// mass, r the arm of the atom, m the middle of the edge, ω the angular velocities, s the sum of
/// the radii of atom and edge, Λ a bound on the distance of the atom from the centre of Q, and δ
/// the input errors of position, velocity and angles (α for P, β for Q):
///
/// E(t) = u (2 |X|₁ + 13 r + 18 Λ + 8 |m| + 2 s) + δX + r δα + Λ δβ
///      + 4 u (|V|₁ + |ω_P| r + |ω_Q| Λ) t
///
/// E'(t) = L ((18 + 4 |ω_Q| t) u + δβ) + (|ω_P| + |ω_Q|) E + δV,  L = |V| + |ω_P| r + |ω_Q| Λ
///
/// The source of the module proves both bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeErrorBound {
    start: f64,
    rate: f64,
    /// L
    speed: f64,
    /// |ω_P| + |ω_Q|
    spin: f64,
    /// δV, and the error of the normal at the start times L.
    velocity: f64,
    /// The rate of the error of the normal times L.
    acceleration: f64,
}

impl EdgeErrorBound {
    /// The bounds for an atom of body number `body` (0 for A, 1 for B) against an edge of the other
    /// body.
    pub fn new(motion: &RelativeMotion, body: usize, atom: &Circle, edge: &Edge) -> Self {
        let spins = motion.angular_velocity;
        let reach = reach_of_pair(spins[body], atom, edge);
        Self::within(motion, body, spins, reach, atom, edge)
    }

    /// The bounds for bodies with these angular velocities, 0 for a disc about its centre of mass,
    /// while |X + V t| ≤ `reach` (length), which counts only for an edge that turns.
    pub(crate) fn within(
        motion: &RelativeMotion,
        body: usize,
        spins: [f64; 2],
        reach: f64,
        atom: &Circle,
        edge: &Edge,
    ) -> Self {
        let [spin, spin_of_edge] = [spins[body], spins[1 - body]].map(f64::abs);
        let (rim_speed, contact_distance) = (spin * atom.arm, atom.radius + edge.radius());
        let (place, velocity) = (one_norm(motion.separation), one_norm(motion.velocity));
        let tilt = motion.orientation_error[1 - body];
        let given = motion.separation_error + atom.arm * motion.orientation_error[body];
        let of_edge = 8.0 * edge.middle().length() + 2.0 * contact_distance;
        if spin_of_edge == 0.0 {
            let speed = motion.velocity.length() + rim_speed;
            let given = given + (place + atom.arm) * tilt;
            return Self {
                start: U * (20.0 * place + 31.0 * atom.arm + of_edge) + given,
                rate: U * (22.0 * velocity + 4.0 * rim_speed) + velocity * tilt,
                speed,
                spin,
                velocity: motion.velocity_error + speed * (18.0 * U + tilt),
                acceleration: 0.0,
            };
        }
        let orbit = if spin == 0.0 { 0.0 } else { atom.arm };
        let distance = reach + orbit;
        let speed = motion.velocity.length() + rim_speed + spin_of_edge * distance;
        let given = given + distance * tilt;
        Self {
            start: U * (2.0 * place + 13.0 * atom.arm + 18.0 * distance + of_edge) + given,
            rate: 4.0 * U * (velocity + rim_speed + spin_of_edge * distance),
            speed,
            spin: spin + spin_of_edge,
            velocity: motion.velocity_error + speed * (18.0 * U + tilt),
            acceleration: 4.0 * U * spin_of_edge * speed,
        }
    }

    /// The bounds for all atoms of body number `body` against all lines that are fixed in the other
    /// body and pass its centre at most at its bounding radius, while the bounding circles overlap.
    pub(crate) fn of_bodies(
        motion: &RelativeMotion,
        body: usize,
        spins: [f64; 2],
        radii: [f64; 2],
    ) -> Self {
        let [spin, spin_of_line] = [spins[body], spins[1 - body]].map(f64::abs);
        let (arm, reach) = (radii[body], radii[1 - body]);
        let distance = reach + 2.0 * arm;
        let (place, velocity) = (one_norm(motion.separation), one_norm(motion.velocity));
        let tilt = motion.orientation_error[1 - body];
        let given =
            motion.separation_error + arm * motion.orientation_error[body] + distance * tilt;
        let speed = motion.velocity.length() + spin * arm + spin_of_line * distance;
        Self {
            start: U * (2.0 * place + 15.0 * arm + 18.0 * distance + 10.0 * reach) + given,
            rate: 4.0 * U * (velocity + spin * arm + spin_of_line * distance),
            speed,
            spin: spin + spin_of_line,
            velocity: motion.velocity_error + speed * (18.0 * U + tilt),
            acceleration: 4.0 * U * spin_of_line * speed,
        }
    }

    /// E, the bound on the gap at `time` (length).
    pub fn at(&self, time: f64) -> f64 {
        self.start + self.rate * time
    }

    /// E', the bound on the rate of the gap at `time` (length per time).
    pub fn of_rate(&self, time: f64) -> f64 {
        (self.velocity + self.acceleration * time) + self.spin * self.at(time)
    }

    /// L, a bound on the speed of the atom relative to the turning edge at any time within reach
    /// (length per time).
    pub(crate) fn speed(&self) -> f64 {
        self.speed
    }
}

/// ϱ: the largest distance of the centres of mass at which an atom of a body with this angular
/// velocity can touch an edge of the other; of the atom, if its body does not turn (length).
pub(crate) fn reach_of_pair(spin: f64, atom: &Circle, edge: &Edge) -> f64 {
    let orbit = if spin == 0.0 { 0.0 } else { atom.arm };
    edge.reach() + (atom.radius + edge.radius()) + orbit
}

#[cfg(test)]
pub(crate) mod tests;
