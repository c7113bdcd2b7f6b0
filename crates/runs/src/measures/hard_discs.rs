//! Predictions for a gas of equal, elastic hard discs at equilibrium.
//!
//! Z = βp/n = (1 + η²/8 + η³/18 − 4η⁴/21)/(1 − η)² with the area fraction η (Liu, Mol. Phys. 119
//! (2021) e1886364). Of N discs in a periodic box it is lower by (S₀/2N) η d²[η(Z − 1)]/dη², S₀ =
//! 1/(d(ηZ)/dη) (Lebowitz and Percus, Phys. Rev. 124 (1961) 1673). χ = (Z − 1)/2η gives, with
//! Enskog's theory, the collision rate of a disc Γ = 2 n σ χ √(π kT/m) and the diffusion
//! coefficient kT/(m Γ) (first Sonine approximation; Gass, J. Chem. Phys. 54 (1971) 1898).

use std::f64::consts::PI;

use carom::{View, engine::ElasticitySpec};
use serde::{Deserialize, Serialize};

/// Above this area fraction Z is uncertain by more than a third of a per cent, and discs freeze
/// soon after.
const DENSEST: f64 = 0.65;

/// Below this area fraction Z − 1 = 2η (1 − 1/N) to a part in 10⁵, and its difference from 1 loses
/// digits.
const DILUTE: f64 = 1e-5;

/// Source of the pressure in tables.
pub const LIU: &str = "Liu (2021), with the finite-size shift of Lebowitz and Percus (1961)";

/// Source of the pressure of the gas far from walls.
pub(super) const LIU_BULK: &str = "Liu (2021) at the density far from the walls";

/// Source of contact values of mixtures in tables.
pub(super) const SANTOS: &str =
    "Santos, Yuste and López de Haro (1999), with the pressure of Liu (2021)";

/// Source of rates in tables.
pub const ENSKOG: &str = "Enskog's theory, pressure of Liu (2021)";

/// Source of transport coefficients, which differ from those of hard discs by a few per cent.
pub const SONINE: &str = "approximation, first Sonine: Enskog's theory, pressure of Liu (2021)";

/// A gas of equal hard discs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HardDiscs {
    /// Number of discs.
    pub count: usize,
    /// Diameter (length).
    pub diameter: f64,
    /// Mass of a disc.
    pub mass: f64,
    /// kT (mass × length² / time²).
    pub temperature: f64,
    /// Area of the box (length²).
    pub area: f64,
}

impl HardDiscs {
    /// The gas of a view.
    ///
    /// # Errors
    /// The reason why the system is no such gas.
    pub fn new(view: &View<'_>, elasticity: &ElasticitySpec) -> Result<Self, String> {
        let no = |reason: &str| Err(reason.to_owned());
        let mut bodies = view.bodies();
        let Some(first) = bodies.next() else {
            return no("the box is empty");
        };
        let is_same = |body: carom::engine::BodyView<'_>| {
            let (one, other) = (first.body.molecule(), body.body.molecule());
            other.is_disc()
                && other.bounding_radius() == one.bounding_radius()
                && other.mass() == one.mass()
        };
        if view.bodies().any(|body| !body.body.is_free()) {
            return no("some bodies are fixed");
        }
        if !view.bodies().all(is_same) {
            return no("the bodies are not equal discs");
        }
        if elasticity.is_rough() {
            return no("contacts are rough");
        }
        if !elasticity.is_elastic() {
            return no("contacts are not elastic");
        }
        if view.has_pair_rules() {
            return no("rules for pairs of tags apply");
        }
        if view.bonds().len() > 0 {
            return no("bodies are tied to each other");
        }
        let Some(temperature) = view.temperature().filter(|kt| *kt > 0.0) else {
            return no("there is no thermal motion");
        };
        if view.len() < 2 {
            return no("there is a single disc");
        }
        let gas = Self {
            count: view.len(),
            diameter: 2.0 * first.body.molecule().bounding_radius(),
            mass: first.body.molecule().mass(),
            temperature,
            area: view.bounds().area(),
        };
        if gas.area_fraction() > DENSEST {
            return Err(format!("the area fraction exceeds {DENSEST}"));
        }
        Ok(gas)
    }

    /// Whether theory is known at this density and temperature.
    pub(super) fn is_known(&self) -> bool {
        self.temperature > 0.0 && (0.0..=DENSEST).contains(&self.area_fraction())
    }

    /// Discs per area (1 / length²).
    pub fn density(&self) -> f64 {
        self.count as f64 / self.area
    }

    /// The share of the box that the discs cover.
    pub fn area_fraction(&self) -> f64 {
        0.25 * PI * self.diameter * self.diameter * self.density()
    }

    /// βpA/N of these discs.
    pub fn compressibility_factor(&self) -> f64 {
        let eta = self.area_fraction();
        // Central differences; their error is about 1e-7 relative.
        let step = 1e-3 * eta.min(1.0 - eta);
        let excess = |eta: f64| eta * (infinite(eta) - 1.0);
        let pressure = |eta: f64| eta * infinite(eta);
        let curvature =
            (excess(eta + step) - 2.0 * excess(eta) + excess(eta - step)) / (step * step);
        let slope = (pressure(eta + step) - pressure(eta - step)) / (2.0 * step);
        infinite(eta) - eta * curvature / (2.0 * self.count as f64 * slope)
    }

    /// χ, by which contacts are more frequent than in a dilute gas of the same density.
    pub fn contact_factor(&self) -> f64 {
        let eta = self.area_fraction();
        if eta < DILUTE {
            return 1.0 - 1.0 / self.count as f64;
        }
        (self.compressibility_factor() - 1.0) / (2.0 * eta)
    }

    /// The pair distribution at contact, per pair of different discs.
    pub fn contact_value(&self) -> f64 {
        let count = self.count as f64;
        self.contact_factor() * count / (count - 1.0)
    }

    /// Pressure (mass / time²).
    pub fn pressure(&self) -> f64 {
        self.density() * self.temperature * self.compressibility_factor()
    }

    /// Pressure of infinitely many discs of this density (1 / length²) and diameter (length) at kT
    /// (mass / time²); `None` where Z is uncertain.
    pub(super) fn bulk_pressure(density: f64, diameter: f64, temperature: f64) -> Option<f64> {
        let eta = 0.25 * PI * diameter * diameter * density;
        (eta <= DENSEST).then(|| density * temperature * infinite(eta))
    }

    /// Collisions of a disc per time (1 / time).
    pub fn collision_rate(&self) -> f64 {
        let speed = (PI * self.temperature / self.mass).sqrt();
        2.0 * self.density() * self.diameter * self.contact_factor() * speed
    }

    /// Mean free path in the frame of the centre of mass (length), the mean speed over the rate.
    pub fn mean_free_path(&self) -> f64 {
        // Of N discs at fixed energy and momentum the speeds are smaller by √(1 − 1/N).
        let few = (1.0 - 1.0 / self.count as f64).sqrt();
        few * (0.5 * PI * self.temperature / self.mass).sqrt() / self.collision_rate()
    }

    /// Shear viscosity (mass / time): η₀ (1/χ + 2φ + 0.8729 (2φ)² χ) with the area fraction φ and
    /// η₀ = 1.022 √(m kT/π) / 2σ (Gass 1971).
    pub fn viscosity(&self) -> f64 {
        let (chi, covered) = (self.contact_factor(), 2.0 * self.area_fraction());
        let dilute = 1.022 * (self.mass * self.temperature / PI).sqrt() / (2.0 * self.diameter);
        dilute * (1.0 / chi + covered + 0.8729 * covered * covered * chi)
    }

    /// Heat conductivity by k (1 / time): λ₀ (1/χ + 3φ + 0.8718 (2φ)² χ) with the area fraction φ
    /// and λ₀ = 1.029 · 2 √(kT/π m) / σ (Gass 1971).
    pub fn heat_conductivity(&self) -> f64 {
        let (chi, covered) = (self.contact_factor(), 2.0 * self.area_fraction());
        let dilute = 1.029 * 2.0 * (self.temperature / (PI * self.mass)).sqrt() / self.diameter;
        dilute * (1.0 / chi + 1.5 * covered + 0.8718 * covered * covered * chi)
    }

    /// Diffusion coefficient (length² / time).
    pub fn diffusion(&self) -> f64 {
        self.temperature / (self.mass * self.collision_rate())
    }
}

/// Discs of several sizes in a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiscMixture {
    /// The share of the box that they cover.
    covered: f64,
    /// g at contact of as many equal discs that cover the same share.
    of_equal: f64,
    /// ⟨d⟩/⟨d²⟩ of the diameters d (1 / length).
    shape: f64,
}

impl DiscMixture {
    /// Densest mixture: denser ones are taken for it, since the formula diverges at 1.
    const MAX_COVERED: f64 = 0.9;

    /// So many discs of mean diameter `mean` (length), which cover this area (length²) of a box
    /// (length²).
    pub fn new(count: f64, mean: f64, covered: f64, area: f64) -> Self {
        let covered = (covered / area).min(Self::MAX_COVERED);
        let diameter = (4.0 * covered * area / (PI * count)).sqrt();
        let equal = HardDiscs {
            count: (count as usize).max(2),
            diameter,
            mass: 1.0,
            temperature: 1.0,
            area,
        };
        Self {
            covered,
            of_equal: equal.contact_value(),
            shape: mean / (diameter * diameter),
        }
    }

    /// Whether the fluid is not so dense that Z of equal discs is uncertain.
    pub(super) fn is_known(&self) -> bool {
        self.covered <= DENSEST
    }

    /// g at contact of two discs of these diameters (length):
    ///
    /// g_ij = 1/(1 − η) + (g(η) − 1/(1 − η)) z_ij, z_ij = 2 d_i d_j/(d_i + d_j) ⟨d⟩/⟨d²⟩,
    ///
    /// with that of equal discs at the same area fraction, g(η) (Santos, Yuste and López de Haro,
    /// Mol. Phys. 96 (1999) 1, after Jenkins and Mancini, J. Appl. Mech. 54 (1987) 27).
    pub fn contact_value(&self, [a, b]: [f64; 2]) -> f64 {
        let dilute = 1.0 / (1.0 - self.covered);
        let z = 2.0 * a * b / (a + b) * self.shape;
        dilute + (self.of_equal - dilute) * z
    }
}

/// βpA/N of infinitely many discs at this area fraction.
fn infinite(eta: f64) -> f64 {
    (1.0 + eta * eta * (1.0 / 8.0 + eta * (1.0 / 18.0 - 4.0 / 21.0 * eta))) / (1.0 - eta).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::Scene;
    use carom_methods::AnySimulation;

    fn gas(text: &str) -> Result<HardDiscs, String> {
        let scene = Scene::from_toml(text).unwrap();
        HardDiscs::new(
            &AnySimulation::new(&scene).unwrap().view(),
            &scene.elasticity,
        )
    }

    /// Sums of the virial series, and simulations of 256 discs at 0.2 and 0.5.
    #[test]
    fn the_pressure_is_that_of_the_virial_series() {
        for (eta, expected, tolerance) in [
            (0.1, 1.23614, 1e-4),
            (0.2, 1.57036, 2e-4),
            (0.3, 2.0633, 5e-4),
            (0.4, 2.8293, 6e-4),
            (0.5, 4.106, 2e-3),
            (0.6, 6.457, 1e-2),
        ] {
            assert!(
                (infinite(eta) - expected).abs() < tolerance,
                "{eta}: {}",
                infinite(eta)
            );
        }
        for (eta, shift) in [(0.1, -0.215), (0.3, -0.774), (0.5, -1.676)] {
            let gas = HardDiscs {
                count: 256,
                diameter: (eta / (64.0 * PI)).sqrt(),
                mass: 1.0,
                temperature: 1.0,
                area: 1.0,
            };
            assert!((gas.area_fraction() - eta).abs() < 1e-12);
            let found = (gas.compressibility_factor() - infinite(eta)) * 256.0;
            assert!((found / shift - 1.0).abs() < 0.01, "{eta}: {found}");
        }
    }

    /// Enskog's theory in d dimensions with y = (2φ)χ, in the first Sonine approximation: η = η₀/χ
    /// (1 + y/2)² + ζ/2 and λ = λ₀/χ (1 + 3y/4)² + kζ/m, with one bulk viscosity ζ. Both of Gass's
    /// coefficients of (2φ)²χ give it.
    #[test]
    fn viscosity_and_heat_conductivity_have_one_bulk_viscosity() {
        let gas = HardDiscs {
            count: 1000,
            diameter: 0.02,
            mass: 3.0,
            temperature: 2.0,
            area: 1.0,
        };
        let (chi, covered) = (gas.contact_factor(), 2.0 * gas.area_fraction());
        let y = covered * chi;
        let viscosity = 1.022 * (gas.mass * gas.temperature / PI).sqrt() / (2.0 * gas.diameter);
        let conductivity = 1.029 * 2.0 * (gas.temperature / (PI * gas.mass)).sqrt() / gas.diameter;
        let from_viscosity = 2.0 * (gas.viscosity() - viscosity / chi * (1.0 + 0.5 * y).powi(2));
        let rest = gas.heat_conductivity() - conductivity / chi * (1.0 + 0.75 * y).powi(2);
        assert!(
            (gas.mass * rest / from_viscosity - 1.0).abs() < 1e-3,
            "{rest} {from_viscosity}"
        );
    }

    #[test]
    fn other_systems_have_a_reason() {
        let disc = "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 20\n";
        for (text, reason) in [
            (
                format!("{disc}[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]"),
                "fixed",
            ),
            (
                format!("{disc}[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 20"),
                "equal",
            ),
            (format!("{disc}[elasticity]\ndefault = 0.9"), "elastic"),
            (
                "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\narea_fraction = 0.7".to_owned(),
                "0.65",
            ),
            (String::new(), "empty"),
        ] {
            let found = gas(&text).unwrap_err();
            assert!(found.contains(reason), "{found}");
        }
    }
}
