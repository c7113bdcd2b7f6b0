//! The gap between two placed shapes: the distance of their nearest surfaces.

use glam::DVec2;
use smallvec::SmallVec;

use crate::{
    Edge, EdgeTangents, Ellipse, FacingEdge, FacingParts, FacingTangents, Molecule, Support,
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
    if !(a.ellipses().is_empty() && b.ellipses().is_empty()) {
        return gap_of_ellipses([a, b], [rotation_a, rotation_b], separation);
    }
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
    for (body, rotation, other, rotation_of_other, to_other) in [
        (a, rotation_a, b, rotation_b, separation),
        (b, rotation_b, a, rotation_a, -separation),
    ] {
        for atom in other.atoms().iter().filter(|_| !body.edges().is_empty()) {
            let place = in_frame(rotation, to_other + rotation_of_other.rotate(atom.offset()));
            for edge in body.edges() {
                least = least.min(edge.nearest(place).distance - (edge.radius() + atom.radius()));
            }
        }
    }
    let may_cross = !a.edges().is_empty() && !b.edges().is_empty();
    let is_solid = !(a.solid_rings().is_empty() && b.solid_rings().is_empty());
    if (a.is_wall() && b.is_wall()) || !(may_cross || is_solid) {
        return least;
    }
    let views = [
        RelativeParts::new(a, rotation_a, b, rotation_b, separation),
        RelativeParts::new(b, rotation_b, a, rotation_a, -separation),
    ];
    let depths = views.iter().map(RelativeParts::depth_inside);
    match depths.fold(views[0].depth_of_crossings(), f64::max) {
        0.0 => least,
        depth => least.min(-depth),
    }
}

/// The gap of two bodies of which one has ellipses.
fn gap_of_ellipses(bodies: [&Molecule; 2], rotations: [DVec2; 2], separation: DVec2) -> f64 {
    let mut least = f64::INFINITY;
    let [a, b] = bodies;
    for i in 0..a.atoms().len() {
        for j in 0..b.atoms().len() {
            least = least.min(atom_tangents(bodies, [i, j], rotations, separation).gap);
        }
    }
    let exchanged = [rotations[1], rotations[0]];
    for (body, other, rotations, d) in [
        (a, b, exchanged, separation),
        (b, a, rotations, -separation),
    ] {
        for edge in body.edges() {
            for atom in 0..other.atoms().len() {
                least = least.min(edge_tangents(edge, other, atom, rotations, d).gap);
            }
        }
    }
    least
}

/// The tangents of atoms i and j of two bodies, of which any may be an ellipse, where they are
/// nearest. `separation` (length) leads from the centre of the first body to that of the second.
pub fn atom_tangents(
    [a, b]: [&Molecule; 2],
    [i, j]: [usize; 2],
    rotations: [DVec2; 2],
    separation: DVec2,
) -> FacingTangents {
    let arms = [
        rotations[0].rotate(a.atoms()[i].offset()),
        rotations[1].rotate(b.atoms()[j].offset()),
    ];
    let d = separation + (arms[1] - arms[0]);
    let (one, other) = (a.shape_of(i), b.shape_of(j));
    let parts = FacingParts {
        a: &one,
        b: &other,
        rotations,
        d,
    };
    parts.farthest(rounding(d, &one, &other))
}

/// The tangents of an edge and an atom of another body, which may be an ellipse, where they are
/// nearest. `d` (length) leads from the centre of the edge's body to that of the other;
/// `rotations` are those of the atom's body and of the edge's.
pub fn edge_tangents(
    edge: &Edge,
    body: &Molecule,
    atom: usize,
    rotations: [DVec2; 2],
    d: DVec2,
) -> EdgeTangents {
    let part = body.shape_of(atom);
    let d = d + rotations[0].rotate(body.atoms()[atom].offset());
    let facing = FacingEdge {
        part: &part,
        edge,
        rotations,
        d,
    };
    facing.farthest(rounding(d, &part, &part))
}

/// The rounding of a gap at this distance (length).
fn rounding(d: DVec2, a: &Ellipse, b: &Ellipse) -> f64 {
    4.0 * f64::EPSILON * (d.length() + (a.reach() + b.reach()))
}

/// A vector in the frame of a body with this rotation, the inverse of which is its conjugate.
fn in_frame(rotation: DVec2, vector: DVec2) -> DVec2 {
    DVec2::new(rotation.x, -rotation.y).rotate(vector)
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
        let place = |offset: DVec2| in_frame(rotation, to_other + rotation_of_other.rotate(offset));
        let atoms = other
            .atoms()
            .iter()
            .map(|atom| (place(atom.offset()), atom.radius()));
        let edges = other
            .edges()
            .iter()
            .filter(|edge| edge.bend().is_none())
            .map(|edge| (edge.segment().map(place), edge.radius()));
        Self {
            body,
            atoms: atoms.collect(),
            edges: edges.collect(),
        }
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
        // Of a body that crosses the border of a cavity, a corner is outside.
        for edge in self
            .body
            .edges()
            .iter()
            .filter(|edge| edge.bend().is_none())
        {
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
