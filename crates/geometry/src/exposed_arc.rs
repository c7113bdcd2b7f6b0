//! The arcs on which a round probe can touch one atom of a molecule.
//!
//! A probe of radius r touches an atom of radius ρ with its centre on the circle of radius ρ + r
//! about the atom.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use crate::{
    boundary_point::{BoundaryPart, BoundaryPoint},
    quadrature::sum_of_means,
};

/// An arc of directions of the contact normal in which a probe can touch one atom.
///
/// It is a piece of the circle on which the probe's centre lies at contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExposedArc {
    /// Index of the atom.
    pub atom: usize,
    /// Start angle (radians, from 0 to 2π, counter-clockwise from +x of the molecule's frame).
    pub start: f64,
    /// End angle, counter-clockwise from the start (radians, up to 4π).
    pub end: f64,
    /// Radius of the circle: radius of the atom plus that of the probe (length).
    pub radius: f64,
    /// Centre of the atom from the centre of mass (length).
    pub centre: DVec2,
}

impl ExposedArc {
    /// The angle of the arc (radians).
    pub fn angle(&self) -> f64 {
        self.end - self.start
    }

    /// The length of the arc.
    pub fn length(&self) -> f64 {
        self.radius * self.angle()
    }

    /// The position of the probe's centre at a contact with the normal in direction `normal`
    /// (radians).
    pub fn point(&self, normal: f64) -> DVec2 {
        self.centre + self.radius * direction(normal)
    }

    /// The contact with the normal in direction `normal` (radians).
    pub fn contact(&self, normal: f64) -> BoundaryPoint {
        BoundaryPoint {
            part: BoundaryPart::Atom(self.atom),
            foot: self.centre,
            radius: self.radius,
            normal,
        }
    }

    /// ∫ weight ds from one direction of the normal to another (radians), within the arc.
    ///
    /// Three-point Gauss rule on pieces of at most one degree, which is exact to rounding for
    /// weights that vary on the scale of a molecule's shape.
    pub fn integral(&self, from: f64, to: f64, weight: &impl Fn(&BoundaryPoint) -> f64) -> f64 {
        let pieces = ((to - from) / (PI / 180.0)).ceil().max(1.0) as usize;
        let step = (to - from) / pieces as f64;
        let sum = sum_of_means(from, step, pieces, |normal| weight(&self.contact(normal)));
        self.radius * step * sum
    }

    /// The pieces of the arc in each of `count` equal sectors of the whole turn, beginning at
    /// `origin` (radians): the index of the sector, and the first and last direction of the normal
    /// in it.
    pub fn sectors(&self, count: usize, origin: f64) -> Vec<(usize, f64, f64)> {
        let width = TAU / count.max(1) as f64;
        let first = ((self.start - origin) / width).floor();
        let most = (self.angle() / width).ceil() as usize + 2;
        let mut from = self.start;
        let mut pieces = Vec::new();
        for sector in (0..most).map(|index| first + index as f64) {
            let to = (origin + (sector + 1.0) * width).min(self.end);
            if to > from {
                pieces.push((
                    (sector as i64).rem_euclid(count.max(1) as i64) as usize,
                    from,
                    to,
                ));
                from = to;
            }
        }
        pieces
    }

    /// ½ ∮ (x dy − y dx) along the arc: its contribution to the area inside a closed line of arcs
    /// (Green).
    pub(crate) fn swept_area(&self) -> f64 {
        // A whole circle ends where it starts; rounding must not leave a chord.
        let chord = if self.is_whole() {
            DVec2::ZERO
        } else {
            direction(self.end) - direction(self.start)
        };
        0.5 * self.radius
            * (self.radius * self.angle() + self.centre.x * chord.y - self.centre.y * chord.x)
    }

    /// Whether this is a whole circle.
    pub(crate) fn is_whole(&self) -> bool {
        self.angle() >= TAU
    }
}

/// The unit vector at an angle (radians).
fn direction(angle: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(angle);
    DVec2::new(cos, sin)
}
