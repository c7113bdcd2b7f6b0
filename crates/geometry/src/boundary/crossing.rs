//! Where the side of one bar crosses the side of another bar.
//!
//! Two lines at a small angle δ cross at a place that is uncertain by ε/δ, with the rounding ε. If
//! each bar computed its own place, the boundary would be open there by as much. So the place on
//! the bar of lower index is computed, and projected onto the other line: both points are then the
//! same to rounding. At a common end, distances count from its centre, and equal radii cancel
//! exactly.

use glam::DVec2;

use super::frame::{Frame, sign};
use crate::exposed_side::EdgeSide;

/// The position of one bar relative to another one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Relation {
    /// Sine and cosine of the angle from the first bar to the second.
    pub sin: f64,
    pub cos: f64,
    /// A reference point on each axis (length from its first end): the common end, if there is one.
    pub references: [f64; 2],
    /// From the first reference point to the second (length).
    pub apart: DVec2,
}

impl Relation {
    pub fn between(first: &Frame, second: &Frame) -> Self {
        let lengths = first.length * second.length;
        let common = [(0, 0), (0, 1), (1, 0), (1, 1)]
            .into_iter()
            .find(|&(of_first, of_second)| first.ends[of_first] == second.ends[of_second]);
        let at = |frame: &Frame, end: usize| if end == 0 { 0.0 } else { frame.length };
        let (references, apart) = match common {
            Some((a, b)) => ([at(first, a), at(second, b)], DVec2::ZERO),
            None => ([0.0, 0.0], second.centres[0] - first.centres[0]),
        };
        Self {
            sin: first.span.perp_dot(second.span) / lengths,
            cos: first.span.dot(second.span) / lengths,
            references,
            apart,
        }
    }

    /// The height of a point of the first bar's side above the second bar's side (length): positive
    /// outside. The point is at `x` along the first bar.
    pub fn height(&self, bars: [&Frame; 2], sides: [EdgeSide; 2], x: f64) -> f64 {
        let [first, second] = sides.map(sign);
        let across = first * bars[0].radius * self.cos
            - (x - self.references[0]) * self.sin
            - bars[1].along.perp_dot(self.apart);
        second * across - bars[1].radius
    }
}

/// How the lines of two sides lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Crossing {
    /// They cross at these distances along the first and the second bar (length).
    At([f64; 2]),
    Parallel,
    /// They are one line, to rounding.
    Coincident,
}

/// How the side of one bar lies to the side of another one; the same place in either order.
pub(super) fn crossing(bars: [&Frame; 2], sides: [EdgeSide; 2]) -> Crossing {
    let [first, second] = bars;
    if first.index > second.index {
        return match in_order([second, first], [sides[1], sides[0]]) {
            Crossing::At([of_second, of_first]) => Crossing::At([of_first, of_second]),
            other => other,
        };
    }
    in_order(bars, sides)
}

fn in_order(bars: [&Frame; 2], sides: [EdgeSide; 2]) -> Crossing {
    let [first, second] = bars;
    let relation = Relation::between(first, second);
    if are_coincident(bars, sides, &relation) {
        return Crossing::Coincident;
    }
    let Relation {
        sin,
        cos,
        references,
        apart,
    } = relation;
    if sin == 0.0 {
        return Crossing::Parallel;
    }
    let [side, other] = sides.map(sign);
    let inward = side * other * cos;
    // r_A cos − r_B up to signs; where it cancels, 1 − |cos| = sin² / (1 + |cos|).
    let shift = if inward > 0.0 {
        other * ((first.radius - second.radius) / sin - first.radius * sin / (1.0 + inward))
    } else {
        (side * first.radius * cos - other * second.radius) / sin
    };
    let of_first = apart.perp_dot(second.along) / sin + shift;
    let of_second = of_first * cos + side * first.radius * sin - apart.dot(second.along);
    Crossing::At([references[0] + of_first, references[1] + of_second])
}

/// Whether the ends of each side lie on the line of the other one, to rounding.
fn are_coincident(bars: [&Frame; 2], sides: [EdgeSide; 2], relation: &Relation) -> bool {
    let [first, second] = bars;
    let size = |frame: &Frame| frame.centres[0].length() + frame.length + frame.radius;
    let slack = 8.0 * f64::EPSILON * (size(first) + size(second));
    let back = Relation::between(second, first);
    let lies_on = |relation: &Relation, bars: [&Frame; 2], sides: [EdgeSide; 2]| {
        [0.0, bars[0].length]
            .into_iter()
            .all(|x| relation.height(bars, sides, x).abs() <= slack)
    };
    // Sides with the same outward normal, or opposite ones.
    lies_on(relation, bars, sides) && lies_on(&back, [second, first], [sides[1], sides[0]])
}
