//! The sides of the convex hull of a body with edges: lines that can separate it from another.

use glam::DVec2;

use crate::{Atom, Edge};

/// A line behind which a whole body lies, in the frame of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HullSide {
    /// Unit normal of the line, away from the body.
    pub normal: DVec2,
    /// Distance of the line from the centre of mass (length), to rounding.
    pub distance: f64,
    /// The edge whose surface lies on the line, if all parts of the body are equally thick.
    pub edge: Option<u32>,
}

/// Whether all atoms and edges have one radius.
pub(crate) fn are_of_one_radius(atoms: &[Atom], edges: &[Edge]) -> bool {
    let mut radii = atoms
        .iter()
        .map(Atom::radius)
        .chain(edges.iter().map(Edge::radius));
    radii
        .next()
        .is_none_or(|first| radii.all(|radius| radius == first))
}

/// The sides of the convex hull of the centres, moved outwards to the farthest atom; for centres on
/// one line, the four sides of the rectangle about them.
pub(crate) fn hull_sides(atoms: &[Atom], edges: &[Edge]) -> Vec<HullSide> {
    let hull = convex_hull(atoms);
    let at = |index: usize| atoms[hull[index % hull.len()] as usize].offset();
    let side = |normal: DVec2, edge: Option<u32>| HullSide {
        normal,
        distance: atoms
            .iter()
            .map(|atom| normal.dot(atom.offset()) + atom.radius())
            .fold(f64::NEG_INFINITY, f64::max),
        edge,
    };
    let is_even = are_of_one_radius(atoms, edges);
    let edge_between = |first: u32, second: u32| {
        let joins = |edge: &Edge| {
            edge.ends()
                .is_some_and(|ends| ends == [first, second] || ends == [second, first])
        };
        edges.iter().position(joins).map(|index| index as u32)
    };
    match hull.len() {
        0 | 1 => Vec::new(),
        2 => {
            let along = (at(1) - at(0)).normalize();
            let edge = edge_between(hull[0], hull[1]).filter(|_| is_even);
            [
                (along.perp(), edge),
                (-along.perp(), edge),
                (along, None),
                (-along, None),
            ]
            .map(|(normal, edge)| side(normal, edge))
            .to_vec()
        }
        count => (0..count)
            .map(|index| {
                // Counter-clockwise, so that the body is on the left.
                let outwards = -(at(index + 1) - at(index)).normalize().perp();
                let edge = edge_between(hull[index], hull[(index + 1) % count]);
                side(outwards, edge.filter(|_| is_even))
            })
            .collect(),
    }
}

/// Indices of the corners of the convex hull of the centres, counter-clockwise (Andrew, Inf.
/// Process. Lett. 9 (1979) 216).
fn convex_hull(atoms: &[Atom]) -> Vec<u32> {
    let place = |index: u32| atoms[index as usize].offset();
    let mut order: Vec<u32> = (0..atoms.len() as u32).collect();
    order.sort_by(|&i, &j| {
        let (one, other) = (place(i), place(j));
        one.x.total_cmp(&other.x).then(one.y.total_cmp(&other.y))
    });
    let chain = |indices: &mut dyn Iterator<Item = u32>| {
        let mut chain: Vec<u32> = Vec::new();
        for next in indices {
            while let [.., before, last] = chain[..]
                && (place(last) - place(before)).perp_dot(place(next) - place(last)) <= 0.0
            {
                chain.pop();
            }
            chain.push(next);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut order.iter().copied());
    hull.extend(chain(&mut order.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EdgedShape, Molecule};

    #[test]
    fn a_body_lies_behind_all_sides_and_touches_each() {
        let corners = [
            (0.0, 0.0),
            (3.0, 0.0),
            (3.0, 1.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ];
        let ell = Molecule::polygon(&corners.map(DVec2::from), 0.01, 1.0).unwrap();
        let of = |shape: EdgedShape| shape.molecule(1.0, 1e-3, 1.0).unwrap();
        let capsule = of(EdgedShape::Capsule(2.0));
        for (body, sides, edges) in [
            (&ell, 5, 4),
            (&capsule, 4, 2),
            (&of(EdgedShape::Square), 4, 4),
            (&of(EdgedShape::Polygon(16)), 16, 16),
        ] {
            let hull = body.outline().sides();
            assert_eq!(hull.len(), sides);
            assert_eq!(
                hull.iter().filter(|side| side.edge.is_some()).count(),
                edges
            );
            for side in hull {
                let beyond =
                    |atom: &Atom| side.normal.dot(atom.offset()) + atom.radius() - side.distance;
                let farthest = body.atoms().iter().map(beyond).fold(f64::MIN, f64::max);
                assert!(farthest.abs() < 1e-14, "{side:?}: {farthest}");
                if let Some(edge) = side.edge {
                    let edge = &body.edges()[edge as usize];
                    let reach = side.normal.dot(edge.middle()) + edge.radius();
                    assert!((reach - side.distance).abs() < 1e-14);
                }
            }
        }
        assert!(
            Molecule::disc(1.0, 1.0)
                .unwrap()
                .outline()
                .sides()
                .is_empty()
        );
    }
}
