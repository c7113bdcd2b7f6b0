//! The gap between a convex part and a straight edge.
//!
//! The edge, with its round ends, is convex too: with its middle m, its direction e, its half
//! length ℓ and its radius ρ, h(n) = n·m + ℓ |n·e| + ρ. Its kinks at the normals of the edge keep
//! the best direction there while the nearest point of the part lies beside the edge.

use glam::DVec2;

use crate::{Edge, Ellipse, FacingParts, Support, SupportPoint};

/// A convex part of one body beside an edge of another, at rest.
#[derive(Debug, Clone, Copy)]
pub struct FacingEdge<'a, A> {
    /// The part.
    pub part: &'a A,
    /// The edge, in the frame of its body.
    pub edge: &'a Edge,
    /// (cos θ, sin θ) of the body of the part and of that of the edge.
    pub rotations: [DVec2; 2],
    /// From the centre of the body of the edge to the centre of the part (length).
    pub d: DVec2,
}

/// Two tangents across one direction, of an edge and of a convex part that faces it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeTangents {
    /// n, from the edge to the part.
    pub normal: DVec2,
    /// Their distance (length).
    pub gap: f64,
    /// The point of the part on its tangent, for its outward normal −n.
    pub point: SupportPoint,
    /// Whether the edge is touched between its ends, or as a line.
    pub is_beside: bool,
    /// How far the nearest point of the part is beyond the end of the edge (length); negative
    /// beside it, infinite for tangents that do not lie along the edge.
    pub beyond: f64,
}

impl<A: Support> FacingEdge<'_, A> {
    /// The tangents across a direction.
    pub fn across(&self, normal: DVec2) -> EdgeTangents {
        let [to_part, to_edge] = self.rotations.map(|r| DVec2::new(r.x, -r.y));
        let point = self.part.at(to_part.rotate(-normal));
        let turned = to_edge.rotate(normal);
        let of_edge = turned.dot(self.edge.middle()) + self.reach_along(turned);
        EdgeTangents {
            normal,
            gap: normal.dot(self.d) - of_edge - (point.distance + self.edge.radius()),
            point,
            is_beside: false,
            beyond: f64::INFINITY,
        }
    }

    /// ℓ |n·e|; 0 for a line.
    fn reach_along(&self, turned: DVec2) -> f64 {
        if self.edge.is_line() {
            0.0
        } else {
            self.edge.half_length() * turned.dot(self.edge.along()).abs()
        }
    }

    /// The tangents whose distance is the gap, less a small share of `error` (length); of parts
    /// that overlap, some tangents that overlap.
    pub fn farthest(&self, error: f64) -> EdgeTangents {
        let beside = self.beside();
        if beside.is_beside && beside.gap > error {
            return beside;
        }
        if self.edge.is_line() {
            return beside;
        }
        let ends = [-1.0, 1.0].map(|side| self.beyond(side, error));
        let mut best = beside;
        for end in ends {
            if end.gap > best.gap || !best.is_beside && end.gap == best.gap {
                best = end;
            }
        }
        best
    }

    /// The tangents along the edge on the side of the part.
    fn beside(&self) -> EdgeTangents {
        let rotation = self.rotations[1];
        let [normal, along] =
            [self.edge.normal(), self.edge.along()].map(|axis| rotation.rotate(axis));
        let middle = rotation.rotate(self.edge.middle());
        let height = normal.dot(self.d - middle);
        let side = if height < 0.0 && !self.edge.is_solid_behind() {
            -normal
        } else {
            normal
        };
        let to_part = DVec2::new(self.rotations[0].x, -self.rotations[0].y);
        let point = self.part.at(to_part.rotate(-side));
        let foot = along.dot(self.d - middle + point.place(-side));
        EdgeTangents {
            normal: side,
            gap: side.dot(self.d) - side.dot(middle) - (point.distance + self.edge.radius()),
            point,
            is_beside: self.edge.is_line() || foot.abs() <= self.edge.half_length(),
            beyond: foot.abs() - self.edge.half_length(),
        }
    }

    /// The tangents of the part and of the round end on one side.
    fn beyond(&self, side: f64, error: f64) -> EdgeTangents {
        let end = self.edge.middle() + side * self.edge.half_length() * self.edge.along();
        let disc = Ellipse::round(self.edge.radius());
        let parts = FacingParts {
            a: &disc,
            b: self.part,
            rotations: [DVec2::X, self.rotations[0]],
            d: self.d - self.rotations[1].rotate(end),
        };
        let found = parts.farthest(error);
        self.across(found.normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Molecule;
    use proptest::prelude::*;

    /// An ellipse beyond the border touches the image of a wall across the box on its line: the
    /// next image of the wall begins there.
    #[test]
    fn a_wall_across_the_box_has_no_ends() {
        let wall = Molecule::wall_without_ends(DVec2::new(2.0, 0.0), 0.0).unwrap();
        let part = Ellipse::new([0.2, 0.1], DVec2::X).unwrap();
        for beyond in [-1e-9, 1e-12, 1e-9, 1e-3, 0.1] {
            let d = DVec2::new(1.0 + beyond, 0.1);
            let edge = &wall.edges()[0];
            let facing = FacingEdge {
                part: &part,
                edge,
                rotations: [DVec2::X; 2],
                d,
            };
            let found = facing.farthest(1e-15);
            assert_eq!(
                (found.normal, found.is_beside),
                (DVec2::Y, true),
                "{beyond}"
            );
            assert!(found.gap.abs() < 1e-16, "{beyond}: {}", found.gap);
        }
    }

    proptest! {
        /// The gap of an ellipse and a wall is the least distance of its points from the wall.
        #[test]
        fn the_gap_is_the_distance_of_the_nearest_point(
            x in -3.0..3.0f64, y in -3.0..3.0f64, turns in prop::array::uniform2(-3.2..3.2f64),
            length in 0.1..4.0f64, radius in 0.0..0.3f64, stretch in 0.0..1.5f64, b in 0.05..0.5f64,
        ) {
            let wall = Molecule::wall(DVec2::new(length, 0.0), radius).unwrap();
            let edge = &wall.edges()[0];
            let part = Ellipse::new([b * 10f64.powf(stretch), b], DVec2::X).unwrap();
            let (d, rotations) = (DVec2::new(x, y), turns.map(DVec2::from_angle));
            let facing = FacingEdge { part: &part, edge, rotations, d };
            let found = facing.farthest(1e-14);
            let to_wall = DVec2::new(rotations[1].x, -rotations[1].y);
            let distance = |point: DVec2| {
                edge.nearest(to_wall.rotate(d + rotations[0].rotate(point))).distance - radius
            };
            let least = part.points(20_000).map(distance).fold(f64::INFINITY, f64::min);
            if found.gap > 1e-3 {
                prop_assert!((found.gap - least).abs() < 1e-6 * (1.0 + least), "{} {least}", found.gap);
            } else {
                prop_assert!(least < 2e-3, "{} {least}", found.gap);
            }
        }
    }
}
