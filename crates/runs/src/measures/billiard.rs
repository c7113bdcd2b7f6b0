//! One disc among the images of one fixed molecule, for which integral geometry is exact.
//!
//! All states of the disc of one energy are equally probable, so that every piece of the boundary
//! that its centre cannot cross is hit with equal probability, and the mean free path is π (A −
//! A_excluded) / P (Santaló 1976).

use carom::{Molecule, View, engine::Body, geometry::ExcludedRegion};
use serde::{Deserialize, Serialize};

/// Source of the predictions.
pub(super) const SANTALO: &str = "integral geometry: π (A − A_excluded) / P (Santaló 1976)";

/// Source of the shares of directions.
pub(super) const ARCS: &str = "integral geometry: exposed arcs";

/// The molecule and the disc.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Billiard {
    molecule: Molecule,
    /// Radius of the disc (length).
    radius: f64,
    /// Area of the box (length²).
    area: f64,
}

impl Billiard {
    /// `None` unless the box has one disc that moves and one fixed molecule, which the disc can go
    /// around.
    pub(super) fn of(view: &View<'_>) -> Option<Self> {
        let bodies: Vec<&Body> = view.bodies().take(3).map(|body| body.body).collect();
        let (disc, fixed) = match bodies.as_slice() {
            [one, other] if one.is_fixed() => (other, one),
            [one, other] => (one, other),
            _ => return None,
        };
        let is_one_disc = !disc.is_fixed() && disc.molecule().is_disc();
        let is_molecule = fixed.is_fixed() && !fixed.is_wall();
        let radius = disc.molecule().bounding_radius();
        // The region does not overlap its own images.
        let is_apart = is_molecule
            && 2.0 * (fixed.molecule().bounding_radius() + radius) < view.bounds().sides().min_element();
        (is_one_disc && is_apart).then(|| Self {
            molecule: fixed.molecule().clone(),
            radius,
            area: view.bounds().area(),
        })
    }

    fn region(&self) -> Option<ExcludedRegion> {
        ExcludedRegion::of(&self.molecule, self.radius).ok()
    }

    /// Mean path of the disc between two contacts (length).
    pub(super) fn mean_free_path(&self) -> Option<f64> {
        Some(self.region()?.mean_free_path(self.area))
    }

    /// Share of each sector of the directions of the impulses on the molecule, in the contacts and
    /// in the impulse.
    pub(super) fn direction_shares(&self, sectors: usize) -> Option<Vec<f64>> {
        Some(self.region()?.direction_shares(sectors))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::Scene;
    use carom_methods::AnySimulation;

    fn of(text: &str) -> Option<Billiard> {
        Billiard::of(&AnySimulation::new(&Scene::from_toml(text).unwrap()).unwrap().view())
    }

    #[test]
    fn only_one_disc_around_one_fixed_molecule_has_exact_predictions() {
        let tee = "[[molecule]]\nshape = \"tee\"\natom_radius = 0.05\natom_mass = 1.0\nat = [0.5, 0.5]\n";
        let fixed = format!("{tee}fixed = true\n");
        let gas = |count| format!("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = {count}\n");
        let found = of(&format!("{fixed}{}", gas(1))).unwrap();
        let region = ExcludedRegion::of(&found.molecule, 0.02).unwrap();
        assert_eq!(found.mean_free_path(), Some(region.mean_free_path(1.0)));
        assert!((found.direction_shares(36).unwrap().iter().sum::<f64>() - 1.0).abs() < 1e-12);
        for text in [
            format!("{fixed}{}", gas(2)),
            format!("{tee}{}", gas(1)),
            format!("[box]\nsides = [0.3, 1.0]\n{}{}", fixed.replace("0.5, 0.5", "0.15, 0.5"), gas(1)),
            format!("[[wall]]\nx = 0.0\n{}", gas(1)),
            gas(1),
        ] {
            assert_eq!(of(&text), None, "{text}");
        }
    }
}
