//! Which normals an atom of a molecule exposes to discs of a given radius, and which its fellow atoms cover.
//!
//! Discs of radius r touch atom i with their centres on a circle of radius s_i = ρ_i + r around it. Atom j, at distance d
//! in direction φ, covers the normals within acos((s_i² + d² − s_j²) / (2 s_i d)) of φ: there a disc would overlap it.

use std::f64::consts::{PI, TAU};

use carom_geometry::Molecule;

/// Exposed angle of one atom in each of `bins` equal bins of [0, 2π) (radians).
pub(crate) fn exposed_angles(molecule: &Molecule, atom: usize, radius: f64, bins: usize) -> Vec<f64> {
    let exposed = exposed_arcs(molecule, atom, radius);
    let edge = |bin: usize| TAU * bin as f64 / bins as f64;
    let inside = |bin: usize| {
        let (from, to) = (edge(bin), edge(bin + 1));
        exposed.iter().map(|&(low, high)| (high.min(to) - low.max(from)).max(0.0)).sum()
    };
    (0..bins).map(inside).collect()
}

/// The exposed arcs in [0, 2π], in ascending order (radians).
fn exposed_arcs(molecule: &Molecule, atom: usize, radius: f64) -> Vec<(f64, f64)> {
    let mut covered = covered_arcs(molecule, atom, radius);
    covered.sort_by(|a, b| a.0.total_cmp(&b.0));
    covered.push((TAU, TAU));
    let mut exposed = Vec::new();
    let mut reached = 0.0;
    for (from, to) in covered {
        if from > reached {
            exposed.push((reached, from));
        }
        reached = to.max(reached);
    }
    exposed
}

fn covered_arcs(molecule: &Molecule, atom: usize, radius: f64) -> Vec<(f64, f64)> {
    let atoms = molecule.atoms();
    let centre = atoms[atom].offset();
    let own = atoms[atom].radius() + radius;
    let mut covered = Vec::new();
    for (_, other) in atoms.iter().enumerate().filter(|&(index, _)| index != atom) {
        let (arm, reach) = (other.offset() - centre, other.radius() + radius);
        let distance = arm.length();
        // s_i² − s_j² as a product, which does not cancel.
        let cosine = (distance * distance + (own - reach) * (own + reach)) / (2.0 * own * distance);
        if cosine >= 1.0 {
            continue;
        }
        let half = if cosine <= -1.0 { PI } else { libm::acos(cosine) };
        let from = (libm::atan2(arm.y, arm.x) - half).rem_euclid(TAU);
        let to = from + 2.0 * half;
        covered.push((from, to.min(TAU)));
        if to > TAU {
            covered.push((0.0, to - TAU));
        }
    }
    covered
}

#[cfg(test)]
mod tests {
    use carom_geometry::Shape;

    use super::*;

    /// Exposed degrees of each atom.
    fn degrees(shape: Shape, atom_radius: f64, radius: f64) -> Vec<f64> {
        let molecule = Molecule::named(shape, atom_radius, 1.0).unwrap();
        let total = |atom| exposed_angles(&molecule, atom, radius, 7).iter().sum::<f64>().to_degrees();
        (0..molecule.atoms().len()).map(total).collect()
    }

    fn assert_near(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
        }
    }

    #[test]
    fn arcs_of_the_tee_are_those_of_plane_geometry() {
        // For atoms of radius a and discs of radius r, s = a + r, an atom covers acos(a/s) to either side of a neighbour
        // at 2a, and acos(√2 a/s) of one at √8 a (wing A and stem D). At s = 5a wing and foot (√20 a) meet before the
        // latter, and D is hidden between A, C and E.
        let degrees_of = |cosine: f64| cosine.acos().to_degrees();
        let (near, diagonal) = (degrees_of(1.0 / 3.0), degrees_of(2f64.sqrt() / 3.0));
        let (wing, bar, stem) =
            (315.0 - diagonal - near, 180.0 - 2.0 * near, 2.0 * (135.0 - near - diagonal));
        assert_near(&degrees(Shape::Tee, 0.005, 0.01), &[wing, bar, wing, stem, 360.0 - 2.0 * near]);
        let near = degrees_of(0.2);
        let wing = 180.0 + degrees_of(0.6) - near;
        assert_near(&degrees(Shape::Tee, 0.0025, 0.01), &[wing, 180.0 - 2.0 * near, wing, 0.0, 180.0]);
    }

    #[test]
    fn a_lone_disc_is_exposed_all_round_and_a_hidden_one_nowhere() {
        let disc = Molecule::disc(0.3, 1.0).unwrap();
        assert_near(&exposed_angles(&disc, 0, 0.1, 4), &[PI / 2.0; 4]);
        assert_near(&degrees(Shape::Cross, 1.0, 1e9)[..1], &[0.0]);
        assert_near(&degrees(Shape::Dumbbell, 1.0, 1.0), &[240.0, 240.0]);
    }
}
