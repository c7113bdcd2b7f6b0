//! The circles that a molecule is drawn by: its atoms, or a coarser shape if they are very many.

use std::collections::BTreeMap;

use carom_geometry::Molecule;
use glam::DVec2;

/// Cells across the bounding circle of a molecule that is drawn coarsely. More: larger pictures.
/// Fewer: a shape that can be seen to be coarse.
const CELLS: usize = 128;

/// The most circles that any molecule is drawn by.
pub const MAX_CIRCLES: usize = CELLS * CELLS;

/// Centre and radius of each circle that a molecule is drawn by (length, in the molecule's frame),
/// at most [`MAX_CIRCLES`] of them.
///
/// They are its atoms, in their order. Of more than [`MAX_CIRCLES`] atoms only the largest one
/// with its centre in each cell of a square grid is drawn, and at least as large as the circle
/// around a cell. So each cell that an atom stands in is covered, and nothing farther from an atom
/// than the diagonal of a cell: 1.1 % of the diameter of the bounding circle.
///
/// ```
/// use carom_geometry::{Atom, Molecule};
/// use carom_observers::{MAX_CIRCLES, drawn_circles};
/// use glam::DVec2;
///
/// let row = |atoms: usize| {
///     let atom = |k| Atom::new(DVec2::new(k as f64, 0.0), 0.5, 1.0).unwrap();
///     Molecule::new((0..atoms).map(atom)).unwrap()
/// };
/// assert_eq!(drawn_circles(&row(5)).len(), 5);
/// assert_eq!(drawn_circles(&row(MAX_CIRCLES + 1)).len(), 128);
/// ```
pub fn drawn_circles(molecule: &Molecule) -> Vec<(DVec2, f64)> {
    if !molecule.ellipses().is_empty() {
        return discs_in_ellipses(molecule);
    }
    let circles = molecule
        .atoms()
        .iter()
        .map(|atom| (atom.offset(), atom.radius()));
    if molecule.atoms().len() <= MAX_CIRCLES {
        return circles.collect();
    }
    let reach = molecule.bounding_radius();
    let side = 2.0 * reach / CELLS as f64;
    let index = |x: f64| (((x + reach) / side) as usize).min(CELLS - 1);
    let mut largest: BTreeMap<[usize; 2], (DVec2, f64)> = BTreeMap::new();
    for (centre, radius) in circles {
        let kept = largest
            .entry([index(centre.y), index(centre.x)])
            .or_insert((centre, radius));
        if radius > kept.1 {
            *kept = (centre, radius);
        }
    }
    let around_cell = std::f64::consts::FRAC_1_SQRT_2 * side;
    let covering = |(&[row, column], (centre, radius)): (&[usize; 2], (DVec2, f64))| {
        if radius > 2.0 * around_cell {
            return (centre, radius);
        }
        let middle = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) * side - reach;
        (middle, around_cell.max(radius))
    };
    largest
        .iter()
        .map(|(cell, &circle)| covering((cell, circle)))
        .collect()
}

/// Discs in each ellipse of a molecule, as many as there is room for.
fn discs_in_ellipses(molecule: &Molecule) -> Vec<(DVec2, f64)> {
    let count = (MAX_CIRCLES / molecule.atoms().len()).clamp(1, DISCS_OF_ELLIPSE) as u32;
    let parts = molecule.atoms().iter().zip(molecule.ellipses());
    parts
        .flat_map(|(atom, ellipse)| {
            ellipse
                .inscribed_discs(count)
                .map(|(x, radius)| (atom.offset() + x * ellipse.along(), radius))
        })
        .collect()
}

/// Most discs that are drawn for an ellipse.
const DISCS_OF_ELLIPSE: usize = 15;

#[cfg(test)]
mod tests {
    use super::*;
    use carom_geometry::Atom;

    #[test]
    fn what_is_drawn_of_many_atoms_covers_their_centres_and_little_else() {
        // A spiral of 50 000 small atoms, and a large one at its end.
        let small = (0..50_000).map(|k| {
            let angle = 0.002 * f64::from(k);
            (0.01 * angle * DVec2::from_angle(angle), 0.003)
        });
        let atoms: Vec<(DVec2, f64)> = small.chain([(DVec2::new(1.5, 0.0), 0.25)]).collect();
        let molecule = Molecule::new(
            atoms
                .iter()
                .map(|&(at, radius)| Atom::new(at, radius, 1.0).unwrap()),
        )
        .unwrap();
        let drawn = drawn_circles(&molecule);
        assert!(
            (500..=MAX_CIRCLES).contains(&drawn.len()),
            "{}",
            drawn.len()
        );
        let cell = 2.0 * molecule.bounding_radius() / CELLS as f64;
        for atom in molecule.atoms() {
            let is_covered =
                |&(centre, radius): &(DVec2, f64)| (atom.offset() - centre).length() <= radius;
            assert!(drawn.iter().any(is_covered), "{atom:?}");
        }
        let large = molecule.atoms().last().unwrap();
        assert!(drawn.contains(&(large.offset(), large.radius())));
        for (centre, radius) in drawn {
            let is_near = |atom: &Atom| (atom.offset() - centre).length() <= cell;
            assert!(molecule.atoms().iter().any(is_near) && (radius == 0.25 || radius <= cell));
        }
    }
}
