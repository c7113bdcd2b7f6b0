//! The gap between two placed shapes: the distance of their nearest surfaces.

use glam::DVec2;
use smallvec::SmallVec;

use crate::{
    Edge, Molecule,
    interior::{encloses, segments_meet},
};

/// Returns the smallest distance between the surfaces of two molecules (length); negative where
/// they overlap.
///
/// `separation` is the vector from the centre of `a` to the centre of the image of `b`; each
/// rotation is (cos θ, sin θ) of the molecule's orientation. Two edges that cross, and an atom
/// within a solid interior, overlap by the distance of the nearest atom from the edge. For two
/// walls that cross, only the end points are taken into account.
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
    if a.edges().is_empty() && b.edges().is_empty() {
        return least;
    }
    let views = [
        RelativeParts::new(a, rotation_a, b, rotation_b, separation),
        RelativeParts::new(b, rotation_b, a, rotation_a, -separation),
    ];
    for view in &views {
        for edge in view.body.edges() {
            least = least.min(view.gap_to(edge));
        }
    }
    if a.is_wall() && b.is_wall() {
        return least;
    }
    let depths = views.iter().map(RelativeParts::depth_inside);
    match depths.fold(views[0].depth_of_crossings(), f64::max) {
        0.0 => least,
        depth => least.min(-depth),
    }
}

/// A body, and the atoms and edges of another in its frame: centre or ends, and radius.
struct RelativeParts<'a> {
    body: &'a Molecule,
    atoms: SmallVec<[(DVec2, f64); 8]>,
    edges: SmallVec<[([DVec2; 2], f64); 8]>,
}

impl<'a> RelativeParts<'a> {
    fn new(
        body: &'a Molecule,
        rotation: DVec2,
        other: &'a Molecule,
        rotation_of_other: DVec2,
        to_other: DVec2,
    ) -> Self {
        // The inverse of a rotation is its conjugate.
        let back = DVec2::new(rotation.x, -rotation.y);
        let place = |offset: DVec2| back.rotate(to_other + rotation_of_other.rotate(offset));
        let atoms = other
            .atoms()
            .iter()
            .map(|atom| (place(atom.offset()), atom.radius()));
        let edges = other
            .edges()
            .iter()
            .map(|edge| (edge.segment().map(place), edge.radius()));
        Self {
            body,
            atoms: atoms.collect(),
            edges: edges.collect(),
        }
    }

    /// The gap between the atoms and an edge of the body.
    fn gap_to(&self, edge: &Edge) -> f64 {
        self.atoms
            .iter()
            .map(|&(place, radius)| edge.nearest(place).distance - (edge.radius() + radius))
            .fold(f64::INFINITY, f64::min)
    }

    /// The largest depth of an atom in a solid interior of the body (length); 0 if none is inside.
    fn depth_inside(&self) -> f64 {
        let mut deepest: f64 = 0.0;
        for ring in self.body.solid_rings() {
            let corner =
                |index: usize| self.body.atoms()[ring[index % ring.len()] as usize].offset();
            let sides = || (0..ring.len()).map(|index| [corner(index), corner(index + 1)]);
            for &(place, radius) in &self.atoms {
                if encloses(sides(), place) {
                    let edges = self.body.edges().iter();
                    let depth = edges.map(|edge| edge.nearest(place).distance + edge.radius());
                    deepest = deepest.max(depth.fold(f64::INFINITY, f64::min) + radius);
                }
            }
        }
        deepest
    }

    /// The largest depth of two edges that cross (length): the way after which they cross no more.
    fn depth_of_crossings(&self) -> f64 {
        let mut deepest: f64 = 0.0;
        for edge in self.body.edges() {
            for &(ends, radius) in &self.edges {
                if segments_meet(edge.segment(), ends) {
                    let way = ends.map(|end| edge.nearest(end).distance);
                    deepest = deepest.max(way[0].min(way[1]) + edge.radius() + radius);
                }
            }
        }
        deepest
    }
}
