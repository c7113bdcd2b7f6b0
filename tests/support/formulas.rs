//! Gaps and contacts by the plain formulas, independent of any detector.

use carom_detection::{ErrorBound, natural_time};
use carom_geometry::{Molecule, gap_between};
use carom_kinematics::RelativeMotion;
use glam::DVec2;

/// The gap of one atom pair at one time, with its first two derivatives.
#[derive(Debug, Clone, Copy)]
pub struct Approach {
    /// g = |d| − s (length).
    pub gap: f64,
    /// g' = n·d' (length / time).
    pub rate: f64,
    /// g'' = n·d'' + (|d'|² − g'²)/|d| (length / time²).
    pub curvature: f64,
}

/// Two moving molecules.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    pub a: &'a Molecule,
    pub b: &'a Molecule,
    pub motion: RelativeMotion,
}

impl Pair<'_> {
    pub fn rotations(&self, time: f64) -> [DVec2; 2] {
        [0, 1].map(|body| {
            let spin = self.motion.angular_velocity[body];
            self.motion.orientation[body].turned(spin, time).cos_sin()
        })
    }

    /// The smallest gap over all atoms (length).
    pub fn smallest_gap(&self, time: f64) -> f64 {
        let [turn_a, turn_b] = self.rotations(time);
        gap_between(
            self.a,
            turn_a,
            self.b,
            turn_b,
            self.motion.separation + self.motion.velocity * time,
        )
    }

    /// The gap of atom `i` of A and atom `j` of B, and its derivatives.
    pub fn approach(&self, (i, j): (u32, u32), time: f64) -> Approach {
        let (atom_a, atom_b) = (&self.a.atoms()[i as usize], &self.b.atoms()[j as usize]);
        let [spin_a, spin_b] = self.motion.angular_velocity;
        let [turn_a, turn_b] = self.rotations(time);
        let (arm_a, arm_b) = (
            turn_a.rotate(atom_a.offset()),
            turn_b.rotate(atom_b.offset()),
        );
        let d = self.motion.separation + self.motion.velocity * time + (arm_b - arm_a);
        let rate = self.motion.velocity + (spin_b * arm_b.perp() - spin_a * arm_a.perp());
        let second = spin_a * spin_a * arm_a - spin_b * spin_b * arm_b;
        let normal = d.normalize();
        let closing = normal.dot(rate);
        Approach {
            gap: d.length() - (atom_a.radius() + atom_b.radius()),
            rate: closing,
            curvature: normal.dot(second)
                + (rate.length_squared() - closing * closing) / d.length(),
        }
    }

    /// E of one atom pair (length).
    pub fn error(&self, (i, j): (u32, u32), time: f64) -> f64 {
        ErrorBound::new(
            &self.motion,
            &self.a.atoms()[i as usize],
            &self.b.atoms()[j as usize],
        )
        .at(time)
    }

    /// The largest E over all atom pairs (length).
    pub fn largest_error(&self, time: f64) -> f64 {
        let mut largest = 0.0f64;
        for i in 0..self.a.atoms().len() as u32 {
            for j in 0..self.b.atoms().len() as u32 {
                largest = largest.max(self.error((i, j), time));
            }
        }
        largest
    }

    /// The error of a time of contact if the gap has an error of ε = 2 E, the guarantee of `Exact`.
    ///
    /// The zeros of g' h + g'' h²/2 = ±ε lie within 2ε/|g'| of 0 if g'² ≥ 2 |g''| ε. Otherwise the
    /// contact is a graze with an overlap no deeper than ε, and the error of the time is at most
    /// √(2ε/|g''|) from the minimum of the gap: 2ε/√(2 |g''| ε).
    pub fn time_tolerance(&self, atoms: (u32, u32), time: f64) -> f64 {
        let at = self.approach(atoms, time);
        let error = 2.0 * self.error(atoms, time);
        2.0 * error / at.rate.abs().max((2.0 * at.curvature.abs() * error).sqrt())
    }

    /// Panics if any two atoms overlap before `until` by more than the bound of `Exact`. It steps
    /// through time, and uses only that no gap closes faster than `L = |V| + |ω_A| R_A + |ω_B|
    /// R_B`.
    ///
    /// No atoms touch within g/L of a time with gap g. Steps below 1e-4 natural times are replaced
    /// by these, so an overlap that lasts less than 1e-4 natural times is not detected.
    pub fn assert_nothing_before(&self, until: f64) {
        let [spin_a, spin_b] = self.motion.angular_velocity.map(f64::abs);
        let (reach_a, reach_b) = (self.a.bounding_radius(), self.b.bounding_radius());
        let speed = self.motion.velocity.length() + spin_a * reach_a + spin_b * reach_b;
        let least_step = 1e-4 * self.natural_time();
        let mut time = 0.0;
        while time < until {
            let gap = self.smallest_gap(time);
            // The bound is 2 E, and this gap has an error of up to E itself.
            let allowed = 3.0 * self.largest_error(time);
            assert!(
                gap >= -allowed,
                "gap {gap:e} at {time}, before {until}; allowed {allowed:e}"
            );
            time += least_step.max(gap / speed);
        }
    }

    /// Time in which the pair moves by its own size.
    pub fn natural_time(&self) -> f64 {
        natural_time(self.a.outline(), self.b.outline(), &self.motion)
    }
}
