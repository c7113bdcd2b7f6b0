//! The parts of the two sides of a bar that no disc and no other bar covers.

use std::f64::consts::TAU;

use glam::DVec2;

use super::{
    Covered, Curve, Feature, Piece,
    crossing::{Crossing, Relation, crossing},
    frame::{Frame, sign},
};
use crate::exposed_side::{EdgeSide, ExposedSide};

/// The exposed lines of one side of a bar, however short.
///
/// A side of a bar as wide as its end disc begins at its tangent point: there it is the bar that
/// ends, and no root is taken.
pub(super) fn exposed(
    circles: &[(DVec2, f64)],
    bars: &[Frame],
    frame: &Frame,
    side: EdgeSide,
) -> Vec<Piece> {
    let by_circles = (0..circles.len()).filter_map(|circle| {
        let placed = frame.place(circle, circles[circle]);
        let half = placed.half_chord(frame.radius - sign(side) * placed.centre.y)?;
        let feature = Feature::Circle(circle);
        Some(Covered {
            from: placed.centre.x - half,
            to: placed.centre.x + half,
            entry: feature,
            exit: feature,
        })
    });
    let by_bars = bars
        .iter()
        .filter(|other| other.index != frame.index)
        .filter_map(|other| covered_by_bar([frame, other], side));
    let ends = frame.ends.map(Feature::Circle);
    let after_end = Covered {
        from: frame.length,
        to: f64::INFINITY,
        entry: ends[1],
        exit: ends[1],
    };
    let mut covered: Vec<Covered> = by_circles.chain(by_bars).chain([after_end]).collect();
    covered.sort_by(|a, b| a.from.total_cmp(&b.from));
    let (mut reached, mut last) = (0.0, ends[0]);
    let mut pieces = Vec::new();
    for next in covered {
        if next.from > reached {
            pieces.push(piece(
                frame,
                side,
                [(reached, last), (next.from, next.entry)],
            ));
        }
        if next.to > reached {
            (reached, last) = (next.to, next.exit);
        }
    }
    pieces
}

/// A piece of a side between two places along the bar, each with what ends it there.
fn piece(frame: &Frame, side: EdgeSide, low_and_high: [(f64, Feature); 2]) -> Piece {
    let [first, last] = match side {
        EdgeSide::Right => low_and_high,
        EdgeSide::Left => [low_and_high[1], low_and_high[0]],
    };
    let outward = frame.outward(side);
    // Adding 0 makes −0 a positive zero.
    let normal = libm::atan2(outward.y, outward.x).rem_euclid(TAU) + 0.0;
    let line = ExposedSide {
        edge: frame.index,
        side,
        start: frame.point(side, first.0),
        end: frame.point(side, last.0),
        normal,
        radius: frame.radius,
    };
    Piece {
        curve: Curve::Side(line),
        before: Some(first.1),
        after: Some(last.1),
    }
}

/// The part of a line that lies in a half-plane.
enum Portion {
    All,
    Nothing,
    Below(f64),
    Above(f64),
}

/// The part of the first bar's side that the rectangle of the second bar covers.
fn covered_by_bar(bars: [&Frame; 2], side: EdgeSide) -> Option<Covered> {
    let [frame, other] = bars;
    if are_far_apart(frame, other) {
        return None;
    }
    let relation = Relation::between(frame, other);
    let ends = frame.ends.map(Feature::Circle);
    let mut covered = Covered {
        from: f64::NEG_INFINITY,
        to: f64::INFINITY,
        entry: ends[0],
        exit: ends[1],
    };
    let [before, behind] = between_ends(bars, side, &relation);
    let half_planes = [
        (before, Feature::Circle(other.ends[0])),
        (behind, Feature::Circle(other.ends[1])),
        (
            under_side(bars, [side, EdgeSide::Left], &relation),
            Feature::Side(other.index, EdgeSide::Left),
        ),
        (
            under_side(bars, [side, EdgeSide::Right], &relation),
            Feature::Side(other.index, EdgeSide::Right),
        ),
    ];
    for (part, feature) in half_planes {
        match part {
            Portion::Nothing => return None,
            Portion::Below(x) if x < covered.to => (covered.to, covered.exit) = (x, feature),
            Portion::Above(x) if x > covered.from => (covered.from, covered.entry) = (x, feature),
            Portion::All | Portion::Below(_) | Portion::Above(_) => {}
        }
    }
    (covered.from < covered.to).then_some(covered)
}

/// Whether the circles around two bars are apart.
fn are_far_apart(a: &Frame, b: &Frame) -> bool {
    let twice_apart = (a.centres[0] + a.centres[1]) - (b.centres[0] + b.centres[1]);
    let reach = |frame: &Frame| frame.length + 2.0 * frame.radius;
    twice_apart.length() > 1.01 * (reach(a) + reach(b))
}

/// The parts of a bar's side that lie after the first end of another bar, and before its second
/// end.
fn between_ends(bars: [&Frame; 2], side: EdgeSide, relation: &Relation) -> [Portion; 2] {
    let [frame, other] = bars;
    // Along the other bar: `along` at the reference point, and `cos` for each length from there.
    let along = relation.references[1] + sign(side) * frame.radius * relation.sin
        - relation.apart.dot(other.along);
    let (cos, reference) = (relation.cos, relation.references[0]);
    let at = |end: f64| reference + (end - along) / cos;
    if cos > 0.0 {
        [Portion::Above(at(0.0)), Portion::Below(at(other.length))]
    } else if cos < 0.0 {
        [Portion::Below(at(0.0)), Portion::Above(at(other.length))]
    } else if (0.0..=other.length).contains(&along) {
        [Portion::All, Portion::All]
    } else {
        [Portion::Nothing, Portion::Nothing]
    }
}

/// The part of one bar's side that lies under the side of another bar.
fn under_side(bars: [&Frame; 2], sides: [EdgeSide; 2], relation: &Relation) -> Portion {
    let [frame, other] = bars;
    let [side, other_side] = sides.map(sign);
    match crossing(bars, sides) {
        // With increasing x the height above the other side decreases by this.
        Crossing::At([x, _]) if other_side * relation.sin > 0.0 => Portion::Above(x),
        Crossing::At([x, _]) => Portion::Below(x),
        Crossing::Parallel if relation.height(bars, sides, 0.0) < 0.0 => Portion::All,
        // Of sides in one place only the first counts; two bodies that touch along a line cover
        // neither side.
        Crossing::Coincident
            if side * other_side * relation.cos > 0.0 && other.index < frame.index =>
        {
            Portion::All
        }
        Crossing::Parallel | Crossing::Coincident => Portion::Nothing,
    }
}
