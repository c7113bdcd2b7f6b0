//! The arcs on which a round probe can touch one atom of a molecule.
//!
//! A probe of radius r touches an atom of radius ρ with its centre on the circle of radius s = ρ +
//! r about the atom. Another atom, whose own such circle has radius s′, at distance d in direction
//! φ, covers all of it (s + d ≤ s′), nothing of it (d ≥ s + s′, or s′ + d ≤ s), or the angles
//! within α of φ, with cos α = (d² + s² − s′²) / (2 s d) and s sin α = h, half the common chord of
//! both circles: (2 d h)² = (s + s′ + d) (s + s′ − d) (d + |s − s′|) (d − |s − s′|) (Heron). Both
//! circles take h from the same product, so the arcs of both end at one point to rounding, also
//! where the circles hardly cross. An arc cosine would be off by up to the root of the rounding
//! there.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

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

    /// ∫ weight ds from one direction of the normal to another (radians), within the arc.
    ///
    /// Three-point Gauss rule on pieces of at most one degree, which is exact to rounding for
    /// weights that vary on the scale of a molecule's shape.
    pub fn integral(&self, from: f64, to: f64, weight: &impl Fn(&Self, f64) -> f64) -> f64 {
        let pieces = ((to - from) / (PI / 180.0)).ceil().max(1.0) as usize;
        let step = (to - from) / pieces as f64;
        let offset = 0.6f64.sqrt();
        let piece = |index: usize| {
            let middle = from + (index as f64 + 0.5) * step;
            let at = |node: f64| weight(self, middle + 0.5 * step * node);
            (5.0 * (at(-offset) + at(offset)) + 8.0 * at(0.0)) / 18.0
        };
        self.radius * step * (0..pieces).map(piece).sum::<f64>()
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
        let is_whole = self.angle() >= TAU;
        let chord = if is_whole {
            DVec2::ZERO
        } else {
            direction(self.end) - direction(self.start)
        };
        0.5 * self.radius
            * (self.radius * self.angle() + self.centre.x * chord.y - self.centre.y * chord.x)
    }

    /// The change of the direction to the arc along it, from a point not inside the circle
    /// (radians, less than half a turn).
    pub(crate) fn turn_about(&self, point: DVec2) -> f64 {
        if self.angle() >= TAU {
            return 0.0;
        }
        let (from, to) = (self.point(self.start) - point, self.point(self.end) - point);
        libm::atan2(from.perp_dot(to), from.dot(to))
    }
}

/// The unit vector at an angle (radians).
fn direction(angle: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(angle);
    DVec2::new(cos, sin)
}

/// An exposed arc and the atoms whose circles end it on both sides; `None` for a whole circle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece {
    pub arc: ExposedArc,
    pub before: Option<usize>,
    pub after: Option<usize>,
}

/// Exposed arcs shorter than this (radians) are roundings of circles that meet in one point.
/// Smaller: atoms that only touch a corner of the boundary would count as reachable. Larger: arcs
/// that a gas can hit are lost.
const MIN_ARC: f64 = 1e-12;

/// The exposed arcs of one circle of a union, given as centres and radii; without those that are
/// roundings of circles that meet in one point.
pub(crate) fn exposed(circles: &[(DVec2, f64)], atom: usize) -> Vec<Piece> {
    let mut pieces = boundary(circles, atom);
    pieces.retain(|piece| piece.arc.angle() > MIN_ARC);
    pieces
}

/// The part of a circle that another disc covers.
enum Cover {
    Nothing,
    /// The circles are the same.
    Identical,
    All,
    /// From a start in [0, 2π) to an end (radians).
    Arc(f64, f64),
}

/// The part of the first circle that the second disc covers.
fn cover((centre, radius): (DVec2, f64), (other_centre, other_radius): (DVec2, f64)) -> Cover {
    let to_other = other_centre - centre;
    let reach = radius + other_radius;
    // Excludes distant circles without a square root.
    if to_other.length_squared() > 2.0 * reach * reach {
        return Cover::Nothing;
    }
    let distance = to_other.length();
    if distance == 0.0 && radius == other_radius {
        return Cover::Identical;
    }
    let difference = (radius - other_radius).abs();
    if distance <= difference && radius < other_radius {
        return Cover::All;
    }
    if distance >= reach || distance <= difference {
        return Cover::Nothing;
    }
    // Of both sides of a triangle, times 2 d; s² − s′² as a product, which does not cancel.
    let along = distance * distance + (radius - other_radius) * reach;
    let chord = ((reach + distance) * (reach - distance)).sqrt()
        * ((distance + difference) * (distance - difference)).sqrt();
    let half = libm::atan2(chord, along);
    let start = (libm::atan2(to_other.y, to_other.x) - half).rem_euclid(TAU);
    Cover::Arc(start, start + 2.0 * half)
}

/// The exposed arcs of one circle of a union, however short.
pub(crate) fn boundary(circles: &[(DVec2, f64)], atom: usize) -> Vec<Piece> {
    let (centre, radius) = circles[atom];
    let arc = |start: f64, angle: f64| ExposedArc {
        atom,
        start,
        end: start + angle,
        radius,
        centre,
    };
    // Start, end, and the index of the covering circle.
    let mut covered: Vec<(f64, f64, usize)> = Vec::new();
    for (other, &circle) in circles
        .iter()
        .enumerate()
        .filter(|(other, _)| *other != atom)
    {
        match cover((centre, radius), circle) {
            Cover::Nothing => {}
            // Of identical circles only the first counts.
            Cover::Identical if other > atom => {}
            Cover::Identical | Cover::All => return Vec::new(),
            Cover::Arc(start, end) => covered.push((start, end, other)),
        }
    }
    covered.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(first, _, opener)) = covered.first() else {
        return vec![Piece {
            arc: arc(0.0, TAU),
            before: None,
            after: None,
        }];
    };
    // One turn from the start of the first covered piece; the gaps between pieces are exposed. A
    // piece that starts late may extend past the whole turn and cover more than the first piece.
    let (mut reached, mut last) = (first, opener);
    for &(_, end, other) in &covered {
        if end - TAU > reached {
            (reached, last) = (end - TAU, other);
        }
    }
    let mut pieces = Vec::new();
    for &(start, end, other) in covered.iter().chain([&(first + TAU, first + TAU, opener)]) {
        if start > reached {
            let from = reached.rem_euclid(TAU);
            pieces.push(Piece {
                arc: arc(from, start - reached),
                before: Some(last),
                after: Some(other),
            });
        }
        if end > reached {
            (reached, last) = (end, other);
        }
    }
    pieces
}
