//! Predictions of kinetic theory for the kicks: directions, rates and magnitudes.

use std::f64::consts::{PI, TAU};

use carom::{
    Molecule,
    geometry::{ExcludedRegion, ExposedArc},
};
use glam::DVec2;

use crate::experiments::thesis_scene::{AREA_FRACTION, Case, GAS_MASS, GAS_RADIUS};

/// Contact value χ = g(σ⁺) of hard discs of area fraction 0.5, from the [5/4] Padé approximant of
/// the virial series of Clisby and `McCoy`, J. Stat. Phys. 122 (2006) 15.
const CONTACT_VALUE: f64 = 3.106;

/// Contact value of hard discs: (1 − 7η/16)/(1 − η)² (Henderson 1975), with a correction
/// proportional to η⁴ that makes it exact at area fraction η = 0.5; it then agrees with the Padé
/// values at 0.4 and 0.6 within 0.1 %.
fn contact_value(fraction: f64) -> f64 {
    let henderson = |fraction: f64| (1.0 - 7.0 / 16.0 * fraction) / (1.0 - fraction).powi(2);
    let excess = CONTACT_VALUE / henderson(AREA_FRACTION) - 1.0;
    henderson(fraction) * (1.0 + excess * (fraction / AREA_FRACTION).powi(4))
}

/// Area fraction of gas discs of this number density.
fn area_fraction(density: f64) -> f64 {
    density * PI * GAS_RADIUS * GAS_RADIUS
}

/// Predictions for a molecule in the gas.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// Boundary of the region excluded to gas centres.
    pub boundary: ExcludedRegion,
    inverse_mass: f64,
    inverse_moment: f64,
}

impl Prediction {
    /// Predictions for the molecule of a case.
    ///
    /// # Panics
    /// Never: none of the cases is a wall.
    pub fn new(case: Case, molecule: &Molecule) -> Self {
        Self {
            boundary: ExcludedRegion::of(molecule, GAS_RADIUS).expect("the molecule is not a wall"),
            inverse_mass: 1.0 / molecule.mass(),
            inverse_moment: if case.turns() { 1.0 / molecule.moment_of_inertia() } else { 0.0 },
        }
    }

    /// Share of the impulse in each sector of directions, in a dilute gas: N(φ) of the opposite
    /// direction, normalised.
    pub fn impulse_shares(&self, sectors: usize) -> Vec<f64> {
        self.boundary.direction_shares(sectors)
    }

    /// Share of the contacts in each sector of directions, in a dilute gas.
    pub fn count_shares(&self, sectors: usize) -> Vec<f64> {
        let whole = self.boundary.integral(|arc, normal| self.frequency(arc, normal));
        let parts = self.boundary.by_impulse_direction(sectors, |arc, normal| self.frequency(arc, normal));
        parts.iter().map(|part| part / whole).collect()
    }

    /// Share of the contacts on each atom, in a dilute gas.
    pub fn atom_shares(&self) -> Vec<f64> {
        let parts = self.boundary.by_atom(|arc, normal| self.frequency(arc, normal));
        let whole: f64 = parts.iter().sum();
        parts.iter().map(|part| part / whole).collect()
    }

    /// Contacts per time in an ideal gas: n √(kT / 2π) ∮ μ^(−1/2) ds.
    pub fn ideal_rate(&self, density: f64, temperature: f64) -> f64 {
        let integral = self.boundary.integral(|arc, normal| self.frequency(arc, normal));
        density * (temperature / TAU).sqrt() * integral
    }

    /// Sum of impulse magnitudes per time in an ideal gas: n kT P.
    pub fn ideal_impulse(&self, density: f64, temperature: f64) -> f64 {
        density * temperature * self.boundary.perimeter()
    }

    /// μ^(−1/2); the number of contacts on a piece of the boundary is proportional to it.
    fn frequency(&self, arc: &ExposedArc, normal: f64) -> f64 {
        // The point of contact lies on the line along the normal through the atom's centre, so both
        // have the same lever arm.
        let lever = arc.centre.perp_dot(DVec2::from_angle(normal));
        (1.0 / GAS_MASS + self.inverse_mass + lever * lever * self.inverse_moment).sqrt()
    }
}

/// Collisions per disc and time in the gas: Γ = 2 n σ χ √(π kT / m) (Enskog; Chapman and Cowling
/// 1970, chapter 16, in two dimensions).
pub fn collision_rate(density: f64, temperature: f64) -> f64 {
    2.0 * density
        * (2.0 * GAS_RADIUS)
        * contact_value(area_fraction(density))
        * (PI * temperature / GAS_MASS).sqrt()
}

/// Density of gas centres at the boundary of a single disc of radius R, relative to the mean: χ =
/// 1/(1 − η) + (9/16) (2Rr/(R + r)) (η/r)/(1 − η)² (Jenkins and Mancini, J. Appl. Mech. 54 (1987)
/// 27).
pub fn contact_density_of_disc(radius: f64, density: f64) -> f64 {
    let fraction = area_fraction(density);
    let free = 1.0 - fraction;
    let harmonic = 2.0 * radius / (radius + GAS_RADIUS);
    1.0 / free + 9.0 / 16.0 * harmonic * fraction / (free * free)
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::engine::RunSpec;

    use crate::experiments::thesis_scene::{Size, scene};
    use carom_methods::AnySimulation;

    impl Prediction {
        /// Predictions for a case with atoms of half the gas radius.
        pub fn of_case(case: Case) -> Self {
            let simulation = AnySimulation::new(&scene(case, Size::Half, 1, 0, RunSpec::default())).unwrap();
            Self::new(case, simulation.view().bodies().next().unwrap().body.molecule())
        }
    }

    #[test]
    fn a_locked_molecule_is_hit_in_proportion_to_its_boundary() {
        let locked = Prediction::of_case(Case::Locked0);
        for (count, impulse) in locked.count_shares(360).iter().zip(locked.impulse_shares(360)) {
            assert!((count - impulse).abs() < 1e-15);
        }
        // √1.1 times the rate of a fixed body.
        assert!((locked.ideal_rate(1.0, 1.0) - 0.068_821_26).abs() < 1e-8);
        assert!((locked.ideal_impulse(2.0, 3.0) - 6.0 * 0.164_481_17).abs() < 1e-7);
    }

    #[test]
    fn a_free_molecule_is_hit_more_often_far_from_its_centre() {
        let (free, locked) = (Prediction::of_case(Case::Standard), Prediction::of_case(Case::Locked0));
        assert!((free.ideal_rate(1.0, 1.0) - 0.070_917_76).abs() < 1e-8);
        assert!(free.atom_shares()[4] > locked.atom_shares()[4]);
        assert!((free.count_shares(360).iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_disc_is_hit_isotropically() {
        for share in Prediction::of_case(Case::Control).count_shares(360) {
            assert!((share * 360.0 - 1.0).abs() < 1e-12);
        }
    }

    /// For equal discs the formula reduces to Henderson's χ = (1 − 7η/16)/(1 − η)², here 3.125.
    #[test]
    fn contact_density_of_a_gas_disc() {
        let half = AREA_FRACTION / (PI * GAS_RADIUS * GAS_RADIUS);
        assert!((contact_density_of_disc(GAS_RADIUS, half) - 3.125).abs() < 1e-12);
        assert!((collision_rate(1591.5, 1.0) - 350.5).abs() < 0.1);
    }
}
