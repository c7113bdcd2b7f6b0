//! Predictions for a gas of equal, elastic hard discs at equilibrium.
//!
//! The contact value of the pair distribution is χ = (1 − 7η/16)/(1 − η)² (Henderson, Mol. Phys. 30
//! (1975) 971), with the area fraction η. It gives the pressure βp/n = 1 + 2ηχ, and with Enskog's
//! theory the collision rate of a disc Γ = 2 n σ χ √(π kT/m) and the diffusion coefficient kT/(m Γ)
//! (first Sonine approximation; Gass, J. Chem. Phys. 54 (1971) 1898).

use std::f64::consts::PI;

use carom::{View, engine::ElasticitySpec};
use serde::{Deserialize, Serialize};

/// Above this area fraction the formulas are off by more than a per cent, and discs freeze soon
/// after.
const DENSEST: f64 = 0.65;

/// Source of the contact value in tables.
pub const HENDERSON: &str = "Henderson (1975)";

/// Source of rates in tables.
pub const ENSKOG: &str = "Enskog's theory, contact value of Henderson (1975)";

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
    pub fn of(view: &View<'_>, elasticity: &ElasticitySpec) -> Result<Self, String> {
        let no = |reason: &str| Err(reason.to_owned());
        let mut bodies = view.bodies();
        let Some(first) = bodies.next() else { return no("the box is empty") };
        let is_same = |body: carom::engine::BodyView<'_>| {
            let (one, other) = (first.body.molecule(), body.body.molecule());
            other.is_disc() && other.bounding_radius() == one.bounding_radius() && other.mass() == one.mass()
        };
        if view.bodies().any(|body| body.body.is_fixed()) {
            return no("some bodies are fixed");
        }
        if !view.bodies().all(is_same) {
            return no("the bodies are not equal discs");
        }
        if elasticity.default != 1.0 || elasticity.pair.iter().any(|rule| rule.coefficient != 1.0) {
            return no("contacts are not elastic");
        }
        let Some(temperature) = view.temperature().filter(|kt| *kt > 0.0) else {
            return no("nothing moves");
        };
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

    /// Discs per area (1 / length²).
    pub fn density(&self) -> f64 {
        self.count as f64 / self.area
    }

    /// The share of the box that the discs cover.
    pub fn area_fraction(&self) -> f64 {
        0.25 * PI * self.diameter * self.diameter * self.density()
    }

    /// The pair distribution at contact.
    pub fn contact_value(&self) -> f64 {
        let fraction = self.area_fraction();
        (1.0 - 7.0 * fraction / 16.0) / (1.0 - fraction).powi(2)
    }

    /// Pressure of the infinite system (mass / time²).
    pub fn pressure(&self) -> f64 {
        self.density() * self.temperature * (1.0 + 2.0 * self.area_fraction() * self.contact_value())
    }

    /// Collisions of a disc per time (1 / time).
    pub fn collision_rate(&self) -> f64 {
        let speed = (PI * self.temperature / self.mass).sqrt();
        2.0 * self.density() * self.diameter * self.contact_value() * speed
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
        let (chi, covered) = (self.contact_value(), 2.0 * self.area_fraction());
        let dilute = 1.022 * (self.mass * self.temperature / PI).sqrt() / (2.0 * self.diameter);
        dilute * (1.0 / chi + covered + 0.8729 * covered * covered * chi)
    }

    /// Diffusion coefficient (length² / time).
    pub fn diffusion(&self) -> f64 {
        self.temperature / (self.mass * self.collision_rate())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::Scene;
    use carom_methods::AnySimulation;

    fn gas(text: &str) -> Result<HardDiscs, String> {
        let scene = Scene::from_toml(text).unwrap();
        HardDiscs::of(&AnySimulation::new(&scene).unwrap().view(), &scene.elasticity)
    }

    /// At η = 0.5, 1 + 2ηχ = (1 + η²/8)/(1 − η)² = 4.125.
    #[test]
    fn the_pressure_is_that_of_henderson() {
        let gas = gas("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\narea_fraction = 0.5").unwrap();
        let ideal = gas.density() * gas.temperature;
        let fraction = gas.area_fraction();
        let expected = (1.0 + fraction * fraction / 8.0) / (1.0 - fraction).powi(2);
        assert!((gas.pressure() / ideal - expected).abs() < 1e-12);
        assert!((expected - 4.125).abs() < 0.01);
    }

    #[test]
    fn other_systems_have_a_reason() {
        let disc = "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 20\n";
        for (text, reason) in [
            (format!("{disc}[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]"), "fixed"),
            (format!("{disc}[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 20"), "equal"),
            (format!("{disc}[elasticity]\ndefault = 0.9"), "elastic"),
            ("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\narea_fraction = 0.7".to_owned(), "0.65"),
            (String::new(), "empty"),
        ] {
            let found = gas(&text).unwrap_err();
            assert!(found.contains(reason), "{found}");
        }
    }
}
