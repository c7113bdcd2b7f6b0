//! One body among fixed ones, for which integral geometry is exact: a disc among equal molecules,
//! or a molecule among equal discs.
//!
//! All states of one energy are equally probable. The velocity of the point of contact along the
//! normal n is w cos α, w² = (2 E/m) (1 + m (r × n)²/I), with a random direction α in the plane of
//! the velocity, or in the space of it and √(I/m) ω for a body that turns; in both the mean speed
//! over the mean of its positive part is π/√(1 + m (r × n)²/I). So the mean free path is
//!
//! λ = π (A/N − A_excluded) / ∮ √(1 + m (r × n)²/I) ds,
//!
//! with the boundary of the region around a molecule that the centre of a disc cannot enter, for N
//! fixed bodies whose regions do not overlap. Without rotation it is π (A/N − A_excluded) / P
//! (Santaló 1976).

use std::f64::consts::PI;

use carom::{
    Molecule, View,
    engine::{Body, BodyView},
    geometry::{BoundaryPoint, ExcludedRegion},
};
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Source of the predictions.
pub(super) const SANTALO: &str =
    "integral geometry: π (A/N − A_excluded) / ∮ √(1 + m (r × n)²/I) ds (Santaló 1976)";

/// Source of the shares of directions and atoms.
pub(super) const ARCS: &str = "integral geometry: exposed boundary";

/// With more fixed bodies it takes long to verify that their regions do not overlap.
const MAX_FIXED: usize = 2000;

/// The molecule and the disc.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Billiard {
    molecule: Molecule,
    /// Whether the molecule is fixed and the disc moves.
    pub(super) molecule_is_fixed: bool,
    /// Radius of the disc (length).
    radius: f64,
    /// Area of the box by the number of fixed bodies (length²).
    area: f64,
    /// Mass over moment of inertia of a molecule that turns, else 0 (1 / length²).
    ratio: f64,
}

impl Billiard {
    /// `None` unless one body moves among fixed ones that are equal, one of the two is a disc, the
    /// disc can go around each molecule, and no rules for pairs of tags apply.
    pub(super) fn new(view: &View<'_>) -> Option<Self> {
        let fixed = || view.bodies().filter(|body| body.body.is_fixed());
        let mut moving = view.bodies().filter(|body| body.body.is_free());
        let (mover, another) = (moving.next()?.body, moving.next());
        let count = view.len() - 1;
        if another.is_some()
            || view.has_pair_rules()
            || !(1..=MAX_FIXED).contains(&count)
            || fixed().any(|body| body.body.is_wall())
        {
            return None;
        }
        let first = fixed().next()?.body.molecule();
        let is_alike = |body: &BodyView<'_>| body.body.molecule() == first;
        let (molecule, disc) = match (mover.molecule().is_disc(), first.is_disc()) {
            (true, _) => (first, mover.molecule()),
            (false, true) => (mover.molecule(), first),
            (false, false) => return None,
        };
        let (molecule_is_fixed, radius) = (mover.molecule().is_disc(), disc.bounding_radius());
        let reach = molecule.bounding_radius() + radius;
        let is_sound = fixed().all(|body| is_alike(&body)) && are_apart(view, fixed(), 2.0 * reach);
        let turning = Some(mover)
            .filter(|mover| mover.can_turn())
            .map(Body::molecule);
        let ratio = turning.map_or(0.0, |molecule| {
            molecule.mass() / molecule.moment_of_inertia()
        });
        let area = view.bounds().area() / count as f64;
        is_sound.then(|| Self {
            molecule: molecule.clone(),
            molecule_is_fixed,
            radius,
            area,
            ratio,
        })
    }

    fn region(&self) -> Option<ExcludedRegion> {
        ExcludedRegion::new(&self.molecule, self.radius).ok()
    }

    /// The number of contacts on a piece of the boundary is proportional to this.
    fn frequency(&self) -> impl Fn(&BoundaryPoint) -> f64 {
        let ratio = self.ratio;
        move |contact| {
            let lever = contact.lever();
            (1.0 + lever * lever * ratio).sqrt()
        }
    }

    /// Mean path of the body that moves between two contacts (length).
    pub(super) fn mean_free_path(&self) -> Option<f64> {
        let region = self.region()?;
        Some(PI * (self.area - region.area()) / region.integral(self.frequency()))
    }

    /// Share of each sector of the directions of the impulses on the molecule in its own frame: in
    /// the contacts, and in the impulse, which is constant along the boundary.
    pub(super) fn direction_shares(&self, sectors: usize) -> Option<[Vec<f64>; 2]> {
        let region = self.region()?;
        let by_count = region.by_impulse_direction(sectors, self.frequency());
        Some([shares(by_count), region.direction_shares(sectors)])
    }

    /// Share of each atom, and then of each straight edge, in the contacts.
    pub(super) fn part_shares(&self) -> Option<Vec<f64>> {
        let region = self.region()?;
        let mut parts = region.by_atom(self.frequency());
        parts.extend(region.by_edge(self.frequency()));
        Some(shares(parts))
    }
}

/// Whether all bodies, and their images, are farther apart than `distance` (length).
fn are_apart<'a>(
    view: &View<'_>,
    bodies: impl Iterator<Item = BodyView<'a>>,
    distance: f64,
) -> bool {
    let bounds = view.bounds();
    let places: Vec<DVec2> = bodies.map(|body| body.motion.position).collect();
    let is_free = |(index, place): (usize, &DVec2)| {
        places[..index]
            .iter()
            .all(|other| bounds.nearest_image(*place - *other).length() > distance)
    };
    distance < bounds.sides().min_element() && places.iter().enumerate().all(is_free)
}

/// Parts relative to their sum.
fn shares(parts: Vec<f64>) -> Vec<f64> {
    let whole: f64 = parts.iter().sum();
    parts.into_iter().map(|part| part / whole).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::Scene;
    use carom_methods::AnySimulation;

    fn of(text: &str) -> Option<Billiard> {
        Billiard::new(
            &AnySimulation::new(&Scene::from_toml(text).unwrap())
                .unwrap()
                .view(),
        )
    }

    const TEE: &str = "shape = \"tee\"\natom_radius = 0.05\natom_mass = 1.0\n";

    fn molecule(at: [f64; 2]) -> String {
        format!("[[molecule]]\n{TEE}at = {at:?}\nfixed = true\n")
    }

    fn gas(count: u32) -> String {
        format!("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = {count}\n")
    }

    #[test]
    fn one_disc_around_fixed_molecules_has_exact_predictions() {
        let found = of(&format!("{}{}", molecule([0.5; 2]), gas(1))).unwrap();
        let region = ExcludedRegion::new(&found.molecule, 0.02).unwrap();
        let path = found.mean_free_path().unwrap();
        assert!((path / region.mean_free_path(1.0) - 1.0).abs() < 1e-12 && found.molecule_is_fixed);
        for shares in found.direction_shares(36).unwrap() {
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
        // Half of the box for each of two.
        let large = "[box]\nsides = [2.0, 1.0]\n";
        let two = of(&format!(
            "{large}{}{}{}",
            molecule([0.5; 2]),
            molecule([1.5, 0.5]),
            gas(1)
        ))
        .unwrap();
        assert!((two.mean_free_path().unwrap() / path - 1.0).abs() < 1e-12);
    }

    /// The lever arm enters: a rod meets discs more often if it turns, and a disc does not.
    #[test]
    fn one_molecule_among_fixed_discs_has_exact_predictions() {
        let bumper = "[[bumper]]\nradius = 0.02\nat = [0.5, 0.5]\n";
        let mover = |shape: &str, keys: &str| {
            let gas = format!(
                "[[gas]]\nshape = \"{shape}\"\natom_radius = 0.02\natom_mass = 1.0\n{keys}"
            );
            of(&format!("{bumper}{gas}energy = 1.0\ncount = 1\n")).unwrap()
        };
        let [free, locked] = ["", "rotation = \"locked\"\n"].map(|keys| mover("rod:3", keys));
        assert!(!free.molecule_is_fixed && free.ratio > 0.0 && locked.ratio == 0.0);
        assert!(free.mean_free_path().unwrap() < locked.mean_free_path().unwrap());
        let [of_free, of_locked] = [free, locked].map(|billiard| billiard.part_shares().unwrap());
        assert!(of_free[0] > of_locked[0] && (of_free[0] - of_free[2]).abs() < 1e-12);
        let disc = mover("disc", "");
        assert!(
            (disc.mean_free_path().unwrap() - PI * (1.0 - PI * 0.0016) / (PI * 0.08)).abs() < 1e-12
        );
    }

    #[test]
    fn other_systems_have_none() {
        for text in [
            format!("{}{}", molecule([0.5; 2]), gas(2)),
            format!("[[molecule]]\n{TEE}at = [0.5, 0.5]\n{}", gas(1)),
            format!(
                "[box]\nsides = [0.3, 1.0]\n{}{}",
                molecule([0.15, 0.5]),
                gas(1)
            ),
            // Too near to one another, and unlike.
            format!("{}{}{}", molecule([0.3, 0.5]), molecule([0.6, 0.5]), gas(1)),
            format!(
                "{}[[bumper]]\nradius = 0.02\nat = [0.05, 0.05]\n{}",
                molecule([0.5; 2]),
                gas(1)
            ),
            format!("[[wall]]\nx = 0.0\n{}", gas(1)),
            gas(1),
        ] {
            assert_eq!(of(&text), None, "{text}");
        }
    }
}
