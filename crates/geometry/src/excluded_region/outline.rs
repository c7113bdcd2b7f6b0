//! Separates the boundary of a union that can be reached from outside from that around its pockets.
//!
//! All pieces run with the union on their left. Linked end to start they form closed lines:
//! counter-clockwise around the outside of each connected part, clockwise around its pockets. A
//! part may itself lie in a pocket of another part.

use std::f64::consts::PI;

use glam::DVec2;

use crate::{
    boundary::{Curve, Piece, boundary},
    union::Union,
};

/// Exposed arcs shorter than this (radians), and sides shorter than this part of their edge, are
/// roundings of lines that meet in one point. Smaller: atoms that only touch a corner of the
/// boundary would count as reachable. Larger: pieces that a gas can hit are lost.
const MIN_PIECE: f64 = 1e-12;

/// The pieces that can be reached from outside, and the others; both in the order of
/// [`boundary`].
pub(super) fn outline(union: &Union) -> (Vec<Curve>, Vec<Curve>) {
    let pieces = exposed_pieces(union);
    let lines = closed_lines(&pieces);
    let curves =
        |line: &[usize]| -> Vec<Curve> { line.iter().map(|&index| pieces[index].curve).collect() };
    let outsides: Vec<(&[usize], Vec<Curve>)> = lines
        .iter()
        .map(|line| (line.as_slice(), curves(line)))
        .filter(|(_, curves)| curves.iter().map(Curve::swept_area).sum::<f64>() > 0.0)
        .collect();
    let mut reached = vec![false; pieces.len()];
    for (line, curves) in &outsides {
        if !outsides
            .iter()
            .any(|(other, around)| other != line && lies_in(curves, around))
        {
            for &index in *line {
                reached[index] = true;
            }
        }
    }
    let (mut outer, mut hidden) = (Vec::new(), Vec::new());
    for (piece, reached) in pieces.iter().zip(reached) {
        if reached {
            outer.push(piece.curve);
        } else {
            hidden.push(piece.curve);
        }
    }
    (outer, hidden)
}

/// The closed lines of the boundary of a union, each from end to start.
pub(crate) fn closed_curves(union: &Union) -> Vec<Vec<Curve>> {
    let pieces = exposed_pieces(union);
    closed_lines(&pieces)
        .iter()
        .map(|line| line.iter().map(|&index| pieces[index].curve).collect())
        .collect()
}

/// The pieces of the boundary that are longer than rounding.
fn exposed_pieces(union: &Union) -> Vec<Piece> {
    let mut pieces = boundary(union);
    pieces.retain(|piece| !is_rounding(union, &piece.curve));
    pieces
}

/// Whether a closed line lies inside another one. The outer lines of two parts do not cross, but
/// they may touch; there rounding decides, so most of the line counts.
fn lies_in(line: &[Curve], other: &[Curve]) -> bool {
    let points = line.iter().flat_map(|curve| {
        let weight = curve.length();
        [0.2, 0.45, 0.8].map(|share| (curve.point(share), weight))
    });
    let signed = |(point, weight): (DVec2, f64)| {
        if encircle(other.iter().copied(), point) {
            weight
        } else {
            -weight
        }
    };
    points.map(signed).sum::<f64>() > 0.0
}

fn is_rounding(union: &Union, curve: &Curve) -> bool {
    match curve {
        Curve::Arc(arc) => arc.angle() <= MIN_PIECE,
        Curve::Side(side) => {
            let [start, end] = union.bars[side.edge]
                .ends
                .map(|end| union.circles[end as usize].0);
            side.length() <= MIN_PIECE * start.distance(end)
        }
    }
}

/// Whether closed lines enclose a point that lies in none of the discs of their arcs.
pub(super) fn encircle(lines: impl IntoIterator<Item = Curve>, point: DVec2) -> bool {
    lines
        .into_iter()
        .map(|curve| curve.turn_about(point))
        .sum::<f64>()
        .abs()
        > PI
}

/// Indices of the pieces along each closed line.
fn closed_lines(pieces: &[Piece]) -> Vec<Vec<usize>> {
    let next = followers(pieces);
    let mut seen = vec![false; pieces.len()];
    let mut lines = Vec::new();
    for first in 0..pieces.len() {
        let mut line = Vec::new();
        let mut index = first;
        while !seen[index] {
            seen[index] = true;
            line.push(index);
            index = next[index];
        }
        if !line.is_empty() {
            lines.push(line);
        }
    }
    lines
}

/// The piece that follows at the end of each piece: a permutation.
fn followers(pieces: &[Piece]) -> Vec<usize> {
    let mut next: Vec<Option<usize>> = vec![None; pieces.len()];
    let mut taken = vec![false; pieces.len()];
    // Of the two crossings of two circles, or of a circle and a line, only one is an entry.
    for (index, piece) in pieces.iter().enumerate() {
        let from = piece.curve.feature();
        let follows = |other: &Piece| match piece.after {
            None => other.curve.feature() == from,
            Some(after) => other.curve.feature() == after && other.before == Some(from),
        };
        if let Some(found) = pieces
            .iter()
            .position(follows)
            .filter(|&found| !taken[found])
        {
            next[index] = Some(found);
            taken[found] = true;
        }
    }
    // Where three lines meet in one point, rounding may give different ones on both sides.
    for (piece, next) in pieces
        .iter()
        .zip(&mut next)
        .filter(|(_, next)| next.is_none())
    {
        let [_, end] = piece.curve.ends();
        let away = |index: &usize| pieces[*index].curve.ends()[0].distance_squared(end);
        let free = (0..pieces.len()).filter(|&index| !taken[index]);
        if let Some(found) = free.min_by(|a, b| away(a).total_cmp(&away(b))) {
            *next = Some(found);
            taken[found] = true;
        }
    }
    next.into_iter()
        .enumerate()
        .map(|(index, next)| next.unwrap_or(index))
        .collect()
}
