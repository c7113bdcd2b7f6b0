//! Area, perimeter, centroid and second moment of a plane body of uniform density.
//!
//! Green's theorem turns each integral over the body into one along its boundary, of the triangles
//! between the origin and the pieces dr: A = ½ ∮ r × dr, ∫ r dA = ⅓ ∮ r (r × dr) and
//! ∫ r² dA = ¼ ∮ r² (r × dr). On an arc r = c + ρ n(φ), with the centre c and the radius ρ of its
//! circle, so r × dr = ρ (ρ + c·n) dφ. Over an angle Δ about the direction m,
//! ∫ n dφ = 2 sin(Δ/2) n(m) and ∫ (c·n) n dφ = ½ Δ c + ½ sin Δ c*, with c* the mirror image of c in
//! the line along n(m).

use glam::DVec2;

use crate::{
    boundary::{Curve, boundary},
    exposed_arc::ExposedArc,
    exposed_side::ExposedSide,
    union::Union,
};

/// Integrals over a body and along its boundary.
///
/// Rounding errors are a few 10⁻¹⁶ of the integral of the absolute values along the boundary, so
/// the origin should be near the body.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Properties {
    /// Area (length²); holes do not count.
    pub area: f64,
    /// Length of the whole boundary, that of holes included.
    pub perimeter: f64,
    /// ∫ r dA about the origin (length³).
    pub first_moment: DVec2,
    /// ∫ r² dA about the origin (length⁴): the moment of inertia at density 1.
    pub second_moment: f64,
}

impl Properties {
    /// The properties of a union.
    pub fn new(union: &Union) -> Self {
        let mut sum = Self::default();
        for piece in boundary(union) {
            let curve = piece.curve;
            sum.area += curve.swept_area();
            sum.perimeter += curve.length();
            let (first, second) = match curve {
                Curve::Arc(arc) => moments_of_arc(&arc),
                Curve::Side(side) => moments_of_side(&side),
            };
            sum.first_moment += first;
            sum.second_moment += second;
        }
        sum
    }

    /// The centroid (length).
    pub fn centroid(&self) -> DVec2 {
        self.first_moment / self.area
    }
}

/// ⅓ ∫ r (r × dr) and ¼ ∫ r² (r × dr) along an arc.
fn moments_of_arc(arc: &ExposedArc) -> (DVec2, f64) {
    let (centre, radius, angle) = (arc.centre, arc.radius, arc.angle());
    let (sin_half, sin) = if arc.is_whole() {
        (0.0, 0.0)
    } else {
        (libm::sin(0.5 * angle), libm::sin(angle))
    };
    let middle = DVec2::from_angle(arc.start + 0.5 * angle);
    let normals = 2.0 * sin_half * middle;
    let mirrored = 2.0 * middle.dot(centre) * middle - centre;
    let squares = 0.5 * angle * centre + 0.5 * sin * mirrored;
    let along = centre.dot(normals);
    let first = centre * (radius * angle + along) + radius * (radius * normals + squares);
    let (c2, r2) = (centre.length_squared(), radius * radius);
    let second =
        radius * angle * (c2 + r2) + (c2 + 3.0 * r2) * along + 2.0 * radius * centre.dot(squares);
    (radius / 3.0 * first, radius / 4.0 * second)
}

/// ⅓ ∫ r (r × dr) and ¼ ∫ r² (r × dr) along a side.
fn moments_of_side(side: &ExposedSide) -> (DVec2, f64) {
    let (p, q) = (side.start, side.end);
    let twice_area = p.perp_dot(q);
    let squares = p.length_squared() + p.dot(q) + q.length_squared();
    (twice_area / 6.0 * (p + q), twice_area / 12.0 * squares)
}

#[cfg(test)]
mod tests;
