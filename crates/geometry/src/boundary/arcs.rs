//! The arcs of a circle that no other disc and no bar covers.
//!
//! A probe of radius r touches an atom of radius ρ with its centre on the circle of radius s = ρ +
//! r about the atom. Another atom, whose own such circle has radius s′, at distance d in direction
//! φ, covers all of it (s + d ≤ s′), nothing of it (d ≥ s + s′, or s′ + d ≤ s), or the angles
//! within α of φ, with cos α = (d² + s² − s′²) / (2 s d) and s sin α = h, half the common chord of
//! both circles: (2 d h)² = (s + s′ + d) (s + s′ − d) (d + |s − s′|) (d − |s − s′|) (Heron). Both
//! circles take h from the same product, so the arcs of both end at one point to rounding, also
//! where the circles hardly cross. An arc cosine would be off by up to the root of the rounding
//! there.
//!
//! The rectangle of a bar is the common part of four half-planes. A line at distance a from the
//! centre ends the arcs at atan2(±h, a) from its normal, with h² = (s + a) (s − a).

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec2;

use super::{
    Covered, Curve, Feature, Piece,
    frame::{Frame, PlacedCircle},
};
use crate::{
    exposed_arc::ExposedArc,
    exposed_side::EdgeSide::{self, Left, Right},
};

/// The part of a circle that another disc covers.
enum ByDisc {
    Nothing,
    /// The circles are the same.
    Identical,
    All,
    /// From a start in [0, 2π) to an end (radians).
    Arc(f64, f64),
}

/// The part of the first circle that the second disc covers. Circles that cross by at most `slack`
/// (length) touch.
fn covered_by_disc(
    (centre, radius): (DVec2, f64),
    (other_centre, other_radius): (DVec2, f64),
    slack: f64,
) -> ByDisc {
    let to_other = other_centre - centre;
    let reach = radius + other_radius;
    // Excludes distant circles without a square root.
    if to_other.length_squared() > 2.0 * reach * reach {
        return ByDisc::Nothing;
    }
    let distance = to_other.length();
    let difference = (radius - other_radius).abs();
    if distance <= slack && difference <= slack {
        return ByDisc::Identical;
    }
    if distance <= difference + slack && radius < other_radius {
        return ByDisc::All;
    }
    if distance >= reach - slack || distance <= difference + slack {
        return ByDisc::Nothing;
    }
    // Of both sides of a triangle, times 2 d; s² − s′² as a product, which does not cancel.
    let along = distance * distance + (radius - other_radius) * reach;
    let chord = ((reach + distance) * (reach - distance)).sqrt()
        * ((distance + difference) * (distance - difference)).sqrt();
    let half = libm::atan2(chord, along);
    let start = (libm::atan2(to_other.y, to_other.x) - half).rem_euclid(TAU);
    ByDisc::Arc(start, start + 2.0 * half)
}

/// A side of the rectangle of a bar, seen from the centre of a circle.
struct RectangleSide {
    /// Direction of the outward normal from the bar's (radians).
    normal: f64,
    /// Distance of the centre from the line (length), positive inside.
    depth: f64,
    /// Half the angle of the circle that lies beyond the line; `None` if they do not cross.
    half_angle: Option<f64>,
}

impl RectangleSide {
    /// Whether the whole circle lies outside.
    fn excludes(&self) -> bool {
        self.half_angle.is_none() && self.depth <= 0.0
    }

    /// Whether a point of the circle, not on the line, lies inside.
    fn contains(&self, radius: f64, angle: f64) -> bool {
        match self.half_angle {
            Some(_) => radius * libm::cos(angle - self.normal) < self.depth,
            None => self.depth > 0.0,
        }
    }
}

/// The sides of a bar's rectangle: at its second end, on its left, at its first end, on its right.
fn rectangle(frame: &Frame, circle: &PlacedCircle) -> [RectangleSide; 4] {
    let DVec2 { x, y } = circle.centre;
    let side = |quarter: f64, depth: f64| RectangleSide {
        normal: quarter * FRAC_PI_2,
        depth,
        half_angle: circle
            .half_chord(depth)
            .map(|half| libm::atan2(half, depth)),
    };
    [
        side(0.0, frame.length - x),
        side(1.0, frame.radius - y),
        side(2.0, x),
        side(3.0, frame.radius + y),
    ]
}

/// The angles at which a circle crosses the sides of a bar's rectangle, in increasing order from 0
/// to 2π, with the long side that is crossed, or that begins there.
fn crossings(frame: &Frame, sides: &[RectangleSide; 4]) -> Vec<(f64, Feature)> {
    let long_sides = [[Right, Left], [Left, Left], [Left, Right], [Right, Right]];
    let of_side = |(side, [before, after]): (&RectangleSide, [EdgeSide; 2])| {
        let normal = side.normal;
        side.half_angle
            .map(|half| [(normal - half, before), (normal + half, after)])
    };
    let mut crossings: Vec<(f64, Feature)> = sides
        .iter()
        .zip(long_sides)
        .filter_map(of_side)
        .flatten()
        .map(|(angle, side)| (angle.rem_euclid(TAU), Feature::Side(frame.index, side)))
        .collect();
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    crossings
}

/// The arcs of a circle that the rectangle of a bar covers; `None` if it covers all of it.
fn covered_by_bar(frame: &Frame, index: usize, circle: (DVec2, f64)) -> Option<Vec<Covered>> {
    let placed = frame.place(index, circle);
    let sides = rectangle(frame, &placed);
    if sides.iter().any(RectangleSide::excludes) {
        return Some(Vec::new());
    }
    let crossings = crossings(frame, &sides);
    let &(first, opener) = crossings.first()?;
    let turn = libm::atan2(frame.along.y, frame.along.x);
    let nexts = crossings.iter().copied().skip(1);
    let arcs = crossings
        .iter()
        .zip(nexts.chain([(first + TAU, opener)]))
        .filter(|&(&(from, _), (to, _))| {
            let middle = 0.5 * (from + to);
            sides
                .iter()
                .all(|side| side.contains(placed.radius, middle))
        })
        .map(|(&(from, entry), (to, exit))| {
            let start = (turn + from).rem_euclid(TAU);
            Covered {
                from: start,
                to: start + (to - from),
                entry,
                exit,
            }
        });
    Some(arcs.collect())
}

/// The overlap of two discs that counts as a touch (length), so that the side of a bar through the
/// point where they touch ends there. Discs alone need none: any two arcs that meet are closed.
fn slack(bars: &[Frame], circles: [(DVec2, f64); 2]) -> f64 {
    if bars.is_empty() {
        return 0.0;
    }
    let size = circles.map(|(centre, radius)| centre.length() + radius);
    8.0 * f64::EPSILON * (size[0] + size[1])
}

/// What other discs and bars cover of a circle; `None` if they cover all of it.
fn covered(circles: &[(DVec2, f64)], bars: &[Frame], atom: usize) -> Option<Vec<Covered>> {
    let circle = circles[atom];
    let mut covered = Vec::new();
    for (other, &disc) in circles.iter().enumerate() {
        if other == atom {
            continue;
        }
        match covered_by_disc(circle, disc, slack(bars, [circle, disc])) {
            ByDisc::Nothing => {}
            // Of identical circles only the first counts.
            ByDisc::Identical if other > atom => {}
            ByDisc::Identical | ByDisc::All => return None,
            ByDisc::Arc(from, to) => covered.push(Covered {
                from,
                to,
                entry: Feature::Circle(other),
                exit: Feature::Circle(other),
            }),
        }
    }
    for bar in bars {
        covered.extend(covered_by_bar(bar, atom, circle)?);
    }
    covered.sort_by(|a, b| a.from.total_cmp(&b.from));
    Some(covered)
}

/// The exposed arcs of one circle of a union, however short.
pub(super) fn exposed(circles: &[(DVec2, f64)], bars: &[Frame], atom: usize) -> Vec<Piece> {
    let (centre, radius) = circles[atom];
    let arc = |start: f64, angle: f64| {
        Curve::Arc(ExposedArc {
            atom,
            start,
            end: start + angle,
            radius,
            centre,
        })
    };
    let Some(covered) = covered(circles, bars, atom) else {
        return Vec::new();
    };
    let Some(opener) = covered.first() else {
        return vec![Piece {
            curve: arc(0.0, TAU),
            before: None,
            after: None,
        }];
    };
    // One turn from the start of the first covered piece; the gaps between pieces are exposed. A
    // piece that starts late may extend past the whole turn and cover more than the first piece.
    let (mut reached, mut last) = (opener.from, opener.exit);
    for next in &covered {
        if next.to - TAU > reached {
            (reached, last) = (next.to - TAU, next.exit);
        }
    }
    let whole_turn = Covered {
        from: opener.from + TAU,
        to: opener.from + TAU,
        ..*opener
    };
    let mut pieces = Vec::new();
    for next in covered.iter().chain([&whole_turn]) {
        if next.from > reached {
            pieces.push(Piece {
                curve: arc(reached.rem_euclid(TAU), next.from - reached),
                before: Some(last),
                after: Some(next.entry),
            });
        }
        if next.to > reached {
            (reached, last) = (next.to, next.exit);
        }
    }
    pieces
}
