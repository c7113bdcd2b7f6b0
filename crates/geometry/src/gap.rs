//! The gap between two placed shapes: the distance of their nearest surfaces.

use glam::DVec2;

use crate::{Face, Molecule};

/// Returns the smallest distance between the surfaces of two molecules (length); negative where
/// they overlap.
///
/// `separation` is the vector from the centre of `a` to the centre of the image of `b`; each
/// rotation is (cos θ, sin θ) of the molecule's orientation. For two walls that cross, only the end
/// points are taken into account.
///
/// ```
/// use carom_geometry::{Molecule, gap_between};
/// use glam::DVec2;
///
/// let disc = Molecule::disc(0.5, 1.0)?;
/// let gap = gap_between(&disc, DVec2::X, &disc, DVec2::X, DVec2::new(3.0, 4.0));
/// assert_eq!(gap, 4.0);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
pub fn gap_between(
    a: &Molecule,
    rotation_a: DVec2,
    b: &Molecule,
    rotation_b: DVec2,
    separation: DVec2,
) -> f64 {
    let mut least = f64::INFINITY;
    for atom_a in a.atoms() {
        let place_a = rotation_a.rotate(atom_a.offset());
        for atom_b in b.atoms() {
            let d = separation + (rotation_b.rotate(atom_b.offset()) - place_a);
            least = least.min(d.length() - (atom_a.radius() + atom_b.radius()));
        }
    }
    if let Some(face) = b.face() {
        least = least.min(gap_to_face(a, rotation_a, face, rotation_b, -separation));
    }
    if let Some(face) = a.face() {
        least = least.min(gap_to_face(b, rotation_b, face, rotation_a, separation));
    }
    least
}

/// The gap between the atoms of a molecule and a face; `place` is the vector from the centre of the
/// face to that of the molecule.
fn gap_to_face(
    molecule: &Molecule,
    rotation: DVec2,
    face: &Face,
    rotation_of_face: DVec2,
    place: DVec2,
) -> f64 {
    // The inverse of a rotation is its conjugate.
    let back = DVec2::new(rotation_of_face.x, -rotation_of_face.y);
    let gap = |atom: &crate::Atom| {
        let place = back.rotate(place + rotation.rotate(atom.offset()));
        face.nearest(place).distance - (face.radius() + atom.radius())
    };
    molecule
        .atoms()
        .iter()
        .map(gap)
        .fold(f64::INFINITY, f64::min)
}
