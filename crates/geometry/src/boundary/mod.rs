//! The boundary of a union of discs, bars and filled rings: arcs of its circles and straight sides
//! of its bars.
//!
//! A piece of the boundary is what no other disc, no bar and no filled ring covers. Every piece
//! runs with the union on its left, so that the pieces form closed lines, counter-clockwise around
//! each connected part and clockwise around its holes.
//!
//! 1. A bar ends at the centres of two discs of at least its radius. So its short ends are never
//!    part of the boundary.
//! 2. The bars of a filled ring lie along its polygon. So no exposed piece crosses the polygon, and
//!    its middle decides whether the ring covers all of it or nothing. The middle is at least the
//!    radius of a bar away from the polygon.
//! 3. A circle that touches the line of a side to rounding does not cross it. Whether it lies
//!    inside is then decided by its centre. Otherwise rounding would cut an arc of up to √ε there.
//! 4. Two pieces that meet take their common point from one computation (see [`frame`] and
//!    [`crossing`]), so the boundary is closed to rounding. Where three meet in one point, rounding
//!    may leave a piece of some ε of the size, which adds nothing to any integral.

mod arcs;
mod crossing;
mod frame;
mod sides;
#[cfg(test)]
mod tests;

use glam::DVec2;

use crate::{
    exposed_arc::ExposedArc,
    exposed_side::{EdgeSide, ExposedSide},
    union::Union,
};
use frame::Frame;

/// A line of the arrangement: a whole circle, or the side of a bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Feature {
    Circle(usize),
    Side(usize, EdgeSide),
}

/// A covered part of a circle (radians) or of a side (length), with the lines that begin and end
/// it.
#[derive(Debug, Clone, Copy)]
struct Covered {
    from: f64,
    to: f64,
    entry: Feature,
    exit: Feature,
}

/// The shape of a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Curve {
    Arc(ExposedArc),
    Side(ExposedSide),
}

/// A piece of the boundary and the lines that end it on both sides; `None` for a whole circle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece {
    pub curve: Curve,
    pub before: Option<Feature>,
    pub after: Option<Feature>,
}

impl Curve {
    /// The line that the piece is a part of.
    pub fn feature(&self) -> Feature {
        match self {
            Self::Arc(arc) => Feature::Circle(arc.atom),
            Self::Side(side) => Feature::Side(side.edge, side.side),
        }
    }

    /// First and last point (length).
    pub fn ends(&self) -> [DVec2; 2] {
        match self {
            Self::Arc(arc) => [arc.point(arc.start), arc.point(arc.end)],
            Self::Side(side) => [side.start, side.end],
        }
    }

    /// The point at a share of the way from the first to the last one (length).
    pub fn point(&self, share: f64) -> DVec2 {
        match self {
            Self::Arc(arc) => arc.point(arc.start + share * arc.angle()),
            Self::Side(side) => side.start.lerp(side.end, share),
        }
    }

    /// The length.
    pub fn length(&self) -> f64 {
        match self {
            Self::Arc(arc) => arc.length(),
            Self::Side(side) => side.length(),
        }
    }

    /// ½ ∫ (x dy − y dx) along the piece (length²): its contribution to the area inside a closed
    /// line (Green).
    pub fn swept_area(&self) -> f64 {
        match self {
            Self::Arc(arc) => arc.swept_area(),
            Self::Side(side) => side.swept_area(),
        }
    }

    /// The change of the direction to the piece along it, from a point inside none of the circles
    /// (radians, less than half a turn).
    pub fn turn_about(&self, point: DVec2) -> f64 {
        if matches!(self, Self::Arc(arc) if arc.is_whole()) {
            return 0.0;
        }
        let [from, to] = self.ends().map(|end| end - point);
        libm::atan2(from.perp_dot(to), from.dot(to))
    }
}

/// The pieces of the boundary of a union, however short: arcs by circle and then by angle, then
/// sides by bar.
pub(crate) fn boundary(union: &Union) -> Vec<Piece> {
    let circles = &union.circles;
    let bars = Frame::all(union);
    let arcs = (0..circles.len()).flat_map(|atom| arcs::exposed(circles, &bars, atom));
    let sides = bars.iter().flat_map(|frame| {
        [EdgeSide::Right, EdgeSide::Left]
            .into_iter()
            .flat_map(|side| sides::exposed(circles, &bars, frame, side))
    });
    arcs.chain(sides)
        .filter(|piece| union.rings.is_empty() || !union.fills(piece.curve.point(0.5)))
        .collect()
}
