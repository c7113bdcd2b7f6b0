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
/// rotation is (cos θ, sin θ) of the molecule's orientation. Two edges that cross overlap by the
/// distance of the nearest atom from the edge. An atom or an ellipse in a solid interior overlaps
/// by the shortest way out of it, across an edge. For two walls that cross, only the end points are
/// taken into account.
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
    with_depth(least, views[0].depth_of_crossings(), &views)
}

/// The gap of two bodies whose surfaces are `least` apart (length), if their edges cross by
/// `crossing` (length), or if a part of one is in a solid interior of the other.
fn with_depth(least: f64, crossing: f64, views: &[RelativeParts<'_>; 2]) -> f64 {
    let depths = views.iter().map(RelativeParts::depth_inside);
    match depths.fold(crossing, f64::max) {
        0.0 => least,
        depth => least.min(-depth),
    }
}

/// The gap of two bodies of which one has ellipses, and hence no edges.
///
/// All parts but solid interiors are convex: one inside another overlaps it in every direction.
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
    if a.solid_rings().is_empty() && b.solid_rings().is_empty() {
        return least;
    }
    let [rotation_a, rotation_b] = rotations;
    let views = [
        RelativeParts::new(a, rotation_a, b, rotation_b, separation),
        RelativeParts::new(b, rotation_b, a, rotation_a, -separation),
    ];
    with_depth(least, 0.0, &views)
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
    other: &'a Molecule,
    /// The rotation of the other body in the frame of the first.
    turn: DVec2,
    places: SmallVec<[DVec2; 8]>,
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
        let edges = other
            .edges()
            .iter()
            .filter(|edge| edge.bend().is_none())
            .map(|edge| (edge.segment().map(place), edge.radius()));
        Self {
            body,
            other,
            turn: in_frame(rotation, rotation_of_other),
            places: (other.atoms().iter())
                .map(|atom| place(atom.offset()))
                .collect(),
            edges: edges.collect(),
        }
    }

    /// The largest depth of an atom or ellipse in a solid interior of the body (length): its
    /// shortest way out across an edge; 0 if no centre is inside.
    ///
    /// A part that reaches inside without its centre overlaps an edge.
    fn depth_inside(&self) -> f64 {
        let mut deepest: f64 = 0.0;
        for ring in self.body.solid_rings() {
            let corner =
                |index: usize| self.body.atoms()[ring[index % ring.len()] as usize].offset();
            let sides = || (0..ring.len()).map(|index| [corner(index), corner(index + 1)]);
            for (atom, &place) in self.places.iter().enumerate() {
                if encloses(sides(), place) {
                    let shape = self.other.shape_of(atom);
                    let depth = self.body.edges().iter().map(|edge| {
                        let nearest = edge.nearest(place);
                        let half_width = shape.at(in_frame(self.turn, nearest.direction)).distance;
                        nearest.distance + edge.radius() + half_width
                    });
                    deepest = deepest.max(depth.fold(f64::INFINITY, f64::min));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Atom, Interior};
    use proptest::prelude::*;

    /// The gap in both orders of the pair, which must agree.
    fn gap_in_both_orders(
        [a, b]: [&Molecule; 2],
        [turn_a, turn_b]: [DVec2; 2],
        separation: DVec2,
    ) -> f64 {
        let gap = gap_between(a, turn_a, b, turn_b, separation);
        let exchanged = gap_between(b, turn_b, a, turn_a, -separation);
        assert!((gap - exchanged).abs() < 1e-12, "{gap} and {exchanged}");
        gap
    }

    fn polygon(corners: &[(f64, f64)]) -> Molecule {
        let corners: Vec<DVec2> = corners.iter().copied().map(DVec2::from).collect();
        Molecule::polygon(&corners, 0.01, 1.0).unwrap()
    }

    const SQUARE: [(f64, f64); 4] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];

    #[test]
    fn an_ellipse_in_a_solid_square_overlaps_by_its_way_out() {
        let square = polygon(&SQUARE);
        let ellipse = Molecule::ellipse([0.3, 0.1], 1.0).unwrap();
        // To the right side it is 0.5, to the others 1 or more; the sides have a radius of 0.01.
        for (turn, depth) in [(DVec2::X, 0.81), (DVec2::Y, 0.61)] {
            for frame in [0.0, 0.7, -2.0].map(DVec2::from_angle) {
                let place = frame.rotate(DVec2::new(0.5, 0.0));
                let rotations = [frame, frame.rotate(turn)];
                let gap = gap_in_both_orders([&square, &ellipse], rotations, place);
                assert!((gap + depth).abs() < 1e-12, "{gap} for {depth}");
            }
        }
        let outside = gap_in_both_orders([&square, &ellipse], [DVec2::X; 2], DVec2::new(2.0, 0.0));
        assert!((outside - 0.69).abs() < 1e-12, "{outside}");
    }

    #[test]
    fn discs_beside_an_ellipse_are_found_in_a_solid_square_too() {
        let square = polygon(&SQUARE);
        let disc = Ellipse::new([0.05, 0.05], DVec2::X).unwrap();
        let ellipse = Ellipse::new([0.2, 0.1], DVec2::X).unwrap();
        // The ellipse is outside, and one disc of the body inside.
        let parts = [
            (DVec2::ZERO, disc, 1.0),
            (DVec2::new(3.0, 0.0), ellipse, 1.0),
        ];
        let body = Molecule::of_ellipses(parts).unwrap();
        let place = -body.atoms()[0].offset();
        let gap = gap_in_both_orders([&square, &body], [DVec2::X; 2], place);
        assert!((gap + 1.06).abs() < 1e-12, "{gap}");
    }

    #[test]
    fn an_ellipse_in_a_notch_or_in_a_hollow_ring_does_not_overlap() {
        let ell = polygon(&[
            (0.0, 0.0),
            (3.0, 0.0),
            (3.0, 1.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ]);
        let ellipse = Molecule::ellipse([0.3, 0.1], 1.0).unwrap();
        let gap_at = |x, y| {
            let place = DVec2::new(x, y) + ell.atoms()[0].offset();
            gap_in_both_orders([&ell, &ellipse], [DVec2::X; 2], place)
        };
        assert!((gap_at(2.0, 2.0) - 0.69).abs() < 1e-12);
        assert!(gap_at(0.5, 2.0) < 0.0 && gap_at(2.0, 0.5) < 0.0);
        let corner = |(x, y)| Atom::new(DVec2::new(x, y), 0.01, 1.0).unwrap();
        let sides = [[0, 1], [1, 2], [2, 3], [3, 0]].map(|ends| (ends, 0.01));
        let ring = Molecule::with_edges(SQUARE.map(corner), &sides, Interior::Hollow).unwrap();
        let gap = gap_in_both_orders([&ring, &ellipse], [DVec2::X; 2], DVec2::ZERO);
        assert!((gap - 0.69).abs() < 1e-12, "{gap}");
    }

    #[test]
    fn bodies_in_an_ellipse_overlap_it() {
        let large = Molecule::ellipse([2.0, 1.5], 1.0).unwrap();
        for small in [
            Molecule::disc(0.1, 1.0).unwrap(),
            Molecule::ellipse([0.1, 0.05], 1.0).unwrap(),
            Molecule::capsule(0.2, 0.05, 1.0).unwrap(),
            polygon(&SQUARE.map(|(x, y)| (0.1 * x, 0.1 * y))),
        ] {
            for place in [DVec2::ZERO, DVec2::new(0.7, -0.2)] {
                let rotations = [DVec2::X, DVec2::from_angle(0.3)];
                let gap = gap_in_both_orders([&large, &small], rotations, place);
                assert!(gap < -1.0, "{gap} at {place}");
            }
        }
    }

    proptest! {
        /// A star and an ellipse overlap where a point of the ellipse is in the star, or a corner
        /// of the star in the ellipse, and nowhere else.
        #[test]
        fn a_star_and_an_ellipse_overlap_where_they_have_points_in_common(
            count in 2..6u32, notch in 0.3..1.0f64, half in 0.02..0.5f64, ratio in 1.0..8.0f64,
            turns in prop::array::uniform2(-3.2..3.2f64), x in -1.5..1.5f64, y in -1.5..1.5f64,
        ) {
            let corner = |index: u32| {
                let size = if index.is_multiple_of(2) { 1.0 } else { notch };
                let angle = std::f64::consts::PI * f64::from(index) / f64::from(count);
                size * DVec2::from_angle(angle)
            };
            let corners: Vec<DVec2> = (0..2 * count).map(corner).collect();
            let star = Molecule::polygon(&corners, 1e-6, 1.0).unwrap();
            let ellipse = Molecule::ellipse([half * ratio, half], 1.0).unwrap();
            let (place, rotations) = (DVec2::new(x, y), turns.map(DVec2::from_angle));
            let gap = gap_between(&star, rotations[0], &ellipse, rotations[1], place);
            let corners: Vec<DVec2> = star.atoms().iter().map(Atom::offset).collect();
            let corner = |index: usize| corners[index % corners.len()];
            let sides = || (0..corners.len()).map(|index| [corner(index), corner(index + 1)]);
            let is_in_star = |point: DVec2| {
                encloses(sides(), in_frame(rotations[0], place + rotations[1].rotate(point)))
            };
            let is_in_ellipse = |corner: DVec2| {
                let point = in_frame(rotations[1], rotations[0].rotate(corner) - place);
                (point / DVec2::new(half * ratio, half)).length() < 1.0
            };
            let shape = ellipse.shape_of(0);
            let has_common_point = is_in_star(DVec2::ZERO)
                || shape.points(2000).any(is_in_star)
                || corners.iter().any(|&corner| is_in_ellipse(corner));
            if gap.abs() > 1e-4 {
                prop_assert_eq!(gap < 0.0, has_common_point, "gap {}", gap);
            }
        }
    }
}
