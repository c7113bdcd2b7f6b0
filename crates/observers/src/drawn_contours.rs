//! The closed lines that a molecule with straight edges is drawn by.

use carom_geometry::{Contour, ContourPiece, Molecule};

use crate::coarse_atoms::MAX_CIRCLES;

/// Points of a coarse contour in its bounding radius. More: larger pictures. Fewer: a shape that
/// can be seen to be coarse.
const COARSE: f64 = 128.0;

/// The contours that a molecule with edges is drawn by, as one filled path in the molecule's frame;
/// none for a union of discs, which is [drawn by circles](crate::drawn_circles()), and for a wall.
///
/// A solid interior is filled, a hollow one is not. Corners of a tiny radius are sharp. Contours of
/// more than [`MAX_CIRCLES`] pieces are drawn coarsely, to 0.4 % of the bounding circle's diameter.
///
/// ```
/// use carom_geometry::{EdgedShape, Molecule};
/// use carom_observers::drawn_contours;
///
/// let square = EdgedShape::Square.molecule(1.0, 1e-6, 1.0)?;
/// let [contour] = &drawn_contours(&square)[..] else { panic!("it has no holes") };
/// assert_eq!(contour.pieces().len(), 4);
/// assert!(drawn_contours(&Molecule::disc(1.0, 1.0)?).is_empty());
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
pub fn drawn_contours(molecule: &Molecule) -> Vec<Contour> {
    if molecule.is_of_discs() {
        return Vec::new();
    }
    let contours = molecule.visible_contours();
    let pieces: usize = contours.iter().map(|contour| contour.pieces().len()).sum();
    if pieces <= MAX_CIRCLES {
        return contours;
    }
    let apart = molecule.bounding_radius() / COARSE;
    contours
        .iter()
        .map(|contour| contour.coarse(apart))
        .collect()
}

/// The [contours](drawn_contours) as numbers for a page, with lengths divided by `unit` (length):
/// of each contour a list of pieces. A piece is the first point of a straight line, [x, y], or an
/// arc: x and y of its centre, its radius, and the angles of both ends (radians,
/// counter-clockwise).
pub fn packed_contours(molecule: &Molecule, unit: f64) -> Vec<Vec<Vec<f64>>> {
    let packed = |piece: &ContourPiece| match *piece {
        ContourPiece::Line { from, .. } => vec![from.x / unit, from.y / unit],
        ContourPiece::Arc {
            centre,
            radius,
            start,
            end,
        } => vec![centre.x / unit, centre.y / unit, radius / unit, start, end],
    };
    drawn_contours(molecule)
        .iter()
        .map(|contour| contour.pieces().iter().map(packed).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_geometry::{Atom, Interior};
    use glam::DVec2;

    #[test]
    fn a_rectangle_is_packed_as_its_corners() {
        let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (0.0, 2.0)].map(DVec2::from);
        let rectangle = Molecule::polygon(&corners, 1e-6, 1.0).unwrap();
        let [packed] = &packed_contours(&rectangle, 2.0)[..] else {
            panic!("it has one contour")
        };
        for (found, [x, y]) in
            packed
                .iter()
                .zip([[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]])
        {
            assert!((found[0] - x).abs() < 1e-6 && (found[1] - y).abs() < 1e-6);
        }
    }

    #[test]
    fn a_bar_between_discs_is_packed_as_lines_and_arcs() {
        let atom = |x| Atom::new(DVec2::new(x, 0.0), 0.5, 1.0).unwrap();
        let edges = [([0, 1], 0.3)];
        let dumbbell =
            Molecule::with_edges([atom(-1.0), atom(1.0)], &edges, Interior::Solid).unwrap();
        let [packed] = &packed_contours(&dumbbell, 1.0)[..] else {
            panic!("it has one contour")
        };
        let lengths: Vec<usize> = packed.iter().map(Vec::len).collect();
        assert_eq!(lengths.iter().filter(|&&length| length == 2).count(), 2);
        assert_eq!(lengths.iter().filter(|&&length| length == 5).count(), 2);
        assert!((packed[0][4] - packed[0][3]) > 4.0, "{packed:?}");
    }
}
