//! Independent gaps of ellipses, discs and edges: the greatest distance of two parallel tangents,
//! by bisection.
//!
//! The tangents across a direction n touch part A at p and part B at q. Their distance is
//! n·(q − p), and it grows with the angle of n by n^⊥·(q − p). Its maximum is the gap.

use super::vectors::{BodyPair, along, dot, length, rotated};

/// A convex part at rest: an ellipse, a disc or an edge with round ends.
#[derive(Debug, Clone, Copy)]
pub struct ConvexPart {
    /// The centre (length).
    pub centre: BodyPair,
    /// Unit vector along the longer axis or along the edge.
    pub axis: BodyPair,
    /// The semi-axes of an ellipse, or 0 (length).
    pub axes: [f64; 2],
    /// Half the length of an edge, or 0 (length).
    pub half: f64,
    /// The radius of a disc, or half the thickness of an edge (length).
    pub radius: f64,
}

/// Two tangents across one direction.
#[derive(Debug, Clone, Copy)]
pub struct Tangents {
    /// Unit vector from the first part to the second.
    pub normal: BodyPair,
    /// Their distance (length).
    pub gap: f64,
    /// The growth of the distance with the angle of the normal (length per radian).
    pub slope: f64,
    /// The points of the parts on them (length).
    pub points: [BodyPair; 2],
    /// The radii of curvature of the parts there (length).
    pub curvature_radii: [f64; 2],
}

/// Directions that are tried where the first one shows no gap: equal angles, as many normals at
/// equal eccentric angles of each ellipse, and the normals of edges.
const TRIED: u32 = 32;

/// Doublings of the first turn, and halvings of the bracket.
const MAX_TURNS: u32 = 120;

/// The first turn in the search for a bracket (radians).
const FIRST_TURN: f64 = 1e-9;

/// The rounding of a distance, as a share of the lengths in it.
const ROUNDING: f64 = 1e-14;

fn perp([x, y]: BodyPair) -> BodyPair {
    [-y, x]
}

fn unit(a: BodyPair) -> BodyPair {
    let size = length(a);
    if size > 0.0 {
        [a[0] / size, a[1] / size]
    } else {
        [1.0, 0.0]
    }
}

fn direction(angle: f64) -> BodyPair {
    let (sin, cos) = libm::sincos(angle);
    [cos, sin]
}

impl ConvexPart {
    /// The point with this outward normal, and the radius of curvature there.
    fn point(&self, normal: BodyPair) -> (BodyPair, f64) {
        let [a, b] = self.axes;
        let across = perp(self.axis);
        let (c, s) = (dot(self.axis, normal), dot(across, normal));
        let mut point = along(self.centre, self.radius, normal);
        point = along(point, self.half * c.signum(), self.axis);
        let h = length([a * c, b * s]);
        if h == 0.0 {
            return (point, self.radius);
        }
        point = along(point, a * (a * c / h), self.axis);
        point = along(point, b * (b * s / h), across);
        let tip = a * b / h;
        (point, self.radius + tip * tip / h)
    }

    /// The largest distance of a point from the centre, at least (length).
    fn size(&self) -> f64 {
        self.axes[0] + self.half + self.radius
    }

    /// A normal of the ellipse at an eccentric angle (radians).
    fn normal_at(&self, eccentric: f64) -> BodyPair {
        let [a, b] = self.axes;
        let [c, s] = direction(eccentric);
        let across = perp(self.axis);
        unit([
            b * c * self.axis[0] + a * s * across[0],
            b * c * self.axis[1] + a * s * across[1],
        ])
    }
}

fn across(a: &ConvexPart, b: &ConvexPart, normal: BodyPair) -> Tangents {
    let (p, curvature_a) = a.point(normal);
    let (q, curvature_b) = b.point([-normal[0], -normal[1]]);
    let between = along(q, -1.0, p);
    Tangents {
        normal,
        gap: dot(normal, between),
        slope: dot(perp(normal), between),
        points: [p, q],
        curvature_radii: [curvature_a, curvature_b],
    }
}

/// The tangents of two parts whose distance is the gap between them; of parts that overlap, the
/// least deep ones.
pub fn farthest_tangents(a: &ConvexPart, b: &ConvexPart) -> Tangents {
    let towards = unit(along(b.centre, -1.0, a.centre));
    let mut best = across(a, b, towards);
    if best.gap <= 0.0 {
        for index in 0..TRIED {
            let angle = std::f64::consts::TAU * f64::from(index) / f64::from(TRIED);
            let of_b = b.normal_at(angle);
            let sides = [perp(a.axis), perp(b.axis)];
            let sign = if index == 0 { 1.0 } else { -1.0 };
            let flat = sides.map(|side| [sign * side[0], sign * side[1]]);
            let flat = flat.into_iter().filter(|_| index < 2);
            let tried = [direction(angle), a.normal_at(angle), [-of_b[0], -of_b[1]]];
            for normal in tried.into_iter().chain(flat) {
                let here = across(a, b, normal);
                if here.gap > best.gap {
                    best = here;
                }
            }
        }
    }
    climb(a, b, best)
}

/// The local maximum next to a direction.
fn climb(a: &ConvexPart, b: &ConvexPart, start: Tangents) -> Tangents {
    let side = start.slope.signum();
    let between = along(start.points[1], -1.0, start.points[0]);
    let least = start.gap - ROUNDING * (length(between) + a.size() + b.size());
    let rises = |here: &Tangents| here.slope * side > 0.0 && here.gap >= least;
    let turned = |normal: BodyPair, turn: f64| unit(along(normal, side * turn, perp(normal)));
    let (mut low, mut high) = (start, None);
    let mut turn = FIRST_TURN;
    for _ in 0..MAX_TURNS {
        let next = across(a, b, turned(low.normal, turn));
        if !rises(&next) {
            high = Some(next);
            break;
        }
        (low, turn) = (next, (2.0 * turn).min(0.25));
    }
    let Some(mut high) = high else { return low };
    for _ in 0..MAX_TURNS {
        let middle = unit(along(low.normal, 1.0, high.normal));
        if middle == low.normal || middle == high.normal {
            break;
        }
        let here = across(a, b, middle);
        if rises(&here) {
            low = here;
        } else {
            high = here;
        }
    }
    // Where both are the maximum to rounding, the flatter one has the better normal.
    let is_flatter = high.slope.abs() < low.slope.abs() && high.gap >= least;
    if is_flatter { high } else { low }
}

/// An ellipse of a body, in the frame of its centre of mass.
#[derive(Debug, Clone, Copy)]
pub struct OutlineEllipse {
    /// The semi-axes, the longer one first (length).
    pub axes: [f64; 2],
    /// Unit vector along the longer one.
    pub along: BodyPair,
}

impl OutlineEllipse {
    /// This ellipse at a place, turned by the rotation with this cosine and sine.
    pub fn placed(&self, centre: BodyPair, rotation: BodyPair) -> ConvexPart {
        ConvexPart {
            centre,
            axis: rotated(self.along, rotation),
            axes: self.axes,
            half: 0.0,
            radius: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ellipse(centre: BodyPair, axes: [f64; 2], angle: f64) -> ConvexPart {
        let along = direction(angle);
        OutlineEllipse { axes, along }.placed(centre, [1.0, 0.0])
    }

    #[test]
    fn the_gap_of_ellipses_on_a_line_is_known() {
        let a = ellipse([0.0, 0.0], [2.0, 0.5], 0.0);
        let b = ellipse([4.0, 0.0], [1.0, 0.25], std::f64::consts::FRAC_PI_2);
        let found = farthest_tangents(&a, &b);
        assert!((found.gap - 1.75).abs() < 1e-15, "{found:?}");
        assert!((found.curvature_radii[0] - 0.125).abs() < 1e-15);
        let inside = ellipse([0.1, 0.0], [0.2, 0.2], 0.0);
        let found = farthest_tangents(&a, &inside);
        assert!((found.gap + 0.7).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn the_gap_is_that_of_the_nearest_points() {
        for index in 0..200 {
            let t = f64::from(index);
            let a = ellipse([0.0, 0.0], [1.0, 1.0 / (1.0 + t)], t);
            let b = ellipse([2.1 * t.cos(), 2.1 * t.sin()], [0.9, 0.1], 2.0 * t);
            let found = farthest_tangents(&a, &b);
            let mut least = f64::INFINITY;
            for i in 0..600 {
                let p = a.point(a.normal_at(f64::from(i) * 0.01048)).0;
                for j in 0..600 {
                    let q = b.point(b.normal_at(f64::from(j) * 0.01048)).0;
                    least = least.min(length(along(q, -1.0, p)));
                }
            }
            assert!(
                found.gap <= least + 1e-12 && found.gap > least - 1e-3,
                "{found:?} {least}"
            );
        }
    }
}
