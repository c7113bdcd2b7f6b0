//! The straight lines on which a round probe can touch one edge of a molecule.
//!
//! A probe of radius r touches an edge of radius ρ with its centre at the distance ρ + r from the
//! line between the centres of the edge's atoms, on either side of it.

use glam::DVec2;

use crate::{
    boundary_point::{BoundaryPart, BoundaryPoint},
    quadrature::sum_of_means,
};

/// A side of an edge, seen along the edge from its first atom to its second.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeSide {
    /// On the left.
    Left,
    /// On the right.
    Right,
}

/// A straight line of places of a probe's centre at which it touches one side of an edge.
///
/// It runs with the body on its left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExposedSide {
    /// Index of the edge.
    pub edge: usize,
    /// The side of the edge.
    pub side: EdgeSide,
    /// First place of the probe's centre, from the centre of mass (length).
    pub start: DVec2,
    /// Last place of the probe's centre (length).
    pub end: DVec2,
    /// Direction of the outward normal (radians, from 0 to 2π, counter-clockwise from +x of the
    /// molecule's frame).
    pub normal: f64,
    /// Distance from the line between the centres of the edge's atoms: radius of the edge plus that
    /// of the probe (length).
    pub radius: f64,
}

/// Intervals of the Gauss rule on a side. Fewer: the integral of √(1 + m l²/I) over a thin rod,
/// with the lever arm l, is off by more than 10⁻¹² of it. More: only slower.
const PIECES: usize = 128;

impl ExposedSide {
    /// The length of the side.
    pub fn length(&self) -> f64 {
        self.start.distance(self.end)
    }

    /// The contact at a share of the way from the start to the end, from 0 to 1.
    pub fn contact(&self, share: f64) -> BoundaryPoint {
        let place = self.start.lerp(self.end, share);
        BoundaryPoint {
            part: BoundaryPart::Edge(self.edge),
            foot: place - self.radius * DVec2::from_angle(self.normal),
            radius: self.radius,
            normal: self.normal,
        }
    }

    /// ∫ weight ds along the side.
    ///
    /// Three-point Gauss rule on equal pieces, which is exact to rounding for weights that vary on
    /// the scale of the side.
    pub fn integral(&self, weight: &impl Fn(&BoundaryPoint) -> f64) -> f64 {
        let step = 1.0 / PIECES as f64;
        let sum = sum_of_means(0.0, step, PIECES, |share| weight(&self.contact(share)));
        self.length() * step * sum
    }

    /// ½ ∫ (x dy − y dx) along the side (length²): the area of its triangle with the origin.
    pub(crate) fn swept_area(&self) -> f64 {
        0.5 * self.start.perp_dot(self.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ √(1 + 12 x²/L²) dx over a thin rod of length L: (L/√12) (a √(1 + a²) + asinh a), a = √3.
    #[test]
    fn the_frequency_of_contacts_of_a_thin_rod_is_exact_to_rounding() {
        let rod = ExposedSide {
            edge: 0,
            side: EdgeSide::Right,
            start: DVec2::new(-1.0, -0.5),
            end: DVec2::new(1.0, -0.5),
            normal: 1.5 * std::f64::consts::PI,
            radius: 0.5,
        };
        let found = rod.integral(&|contact| (1.0 + 3.0 * contact.lever().powi(2)).sqrt());
        let a = 3f64.sqrt();
        let expected = (a * 2.0 + a.asinh()) / a;
        assert!((found / expected - 1.0).abs() < 1e-13, "{found} {expected}");
        assert!((rod.contact(0.75).foot - DVec2::new(0.5, 0.0)).length() < 1e-15);
        assert!((rod.contact(0.75).position() - DVec2::new(0.5, -0.5)).length() < 1e-15);
    }
}
