//! The cooling of equal inelastic discs in a homogeneous state.
//!
//! Each contact takes (1 − e²) kT from a pair in the mean, and a disc has Γ ∝ √T contacts a time,
//! so that kT(t) = kT₀ (1 + (t − t₀)/τ)⁻² with τ = 4/(Γ₀ (1 − e²)) (P. K. Haff, J. Fluid Mech. 134
//! (1983) 401), and Γ₀ by Enskog's theory. It ends where clusters grow.

use carom::{Scene, engine::Quantity};

use super::HardDiscs;
use crate::schedule::stages;

/// Source of the curve.
pub(super) const SOURCE: &str = "approximation, homogeneous: Haff (1983), rate by Enskog's theory";

/// A gas of equal discs that cools by contacts of one elasticity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CoolingDiscs {
    /// The discs, at kT = 1.
    discs: HardDiscs,
    /// Their elasticity.
    elasticity: f64,
}

impl CoolingDiscs {
    /// The gas of a scene that has nothing else.
    pub fn new(scene: &Scene) -> Option<Self> {
        let [gas] = &scene.gas[..] else { return None };
        let elasticity = &scene.elasticity;
        let is_alone = scene.molecule.is_empty()
            && scene.bumper.is_empty()
            && scene.wall.is_empty()
            && scene.container.is_empty()
            && scene.piston.is_empty()
            && scene.well.is_empty()
            && scene.bond.is_empty()
            && scene.reaction.is_empty()
            && scene.transparent.is_empty()
            && scene.diameter.is_empty()
            && scene.gravity.is_none()
            && scene.start.from.is_none()
            && !gas.fixed
            && gas.chain.is_none()
            && stages::is_disturbed(scene).is_none();
        let (Some(Quantity::Number(radius)), Some(Quantity::Number(mass))) =
            (&gas.radius, &gas.mass)
        else {
            return None;
        };
        if !is_alone || elasticity.is_rough() || !elasticity.pair.is_empty() {
            return None;
        }
        let discs = HardDiscs {
            count: scene.expected_bodies().ok()?,
            diameter: 2.0 * radius,
            mass: *mass,
            temperature: 1.0,
            area: scene.bounds.sides[0] * scene.bounds.sides[1],
        };
        (discs.count >= 2 && discs.is_known()).then_some(Self {
            discs,
            elasticity: elasticity.default,
        })
    }

    /// kT at these times (time) after one with this kT (mass × length² / time²).
    pub fn temperatures(&self, [time, kt]: [f64; 2], times: &[f64]) -> Vec<Option<f64>> {
        let at_start = HardDiscs {
            temperature: kt,
            ..self.discs
        };
        let lost = 1.0 - self.elasticity * self.elasticity;
        let rate = 0.25 * lost * at_start.collision_rate();
        let law = |&now: &f64| {
            let grown = 1.0 + rate * (now - time);
            (now >= time).then(|| kt / (grown * grown))
        };
        times.iter().map(law).collect()
    }
}
