//! Separates the arcs of a union of discs that can be reached from outside from those around its
//! pockets.
//!
//! Arcs run counter-clockwise about their own centres. Linked end to start they form closed lines:
//! counter-clockwise around the outside of each connected part, clockwise around its pockets. A
//! part may itself lie in a pocket of another part.

use std::f64::consts::PI;

use glam::DVec2;

use crate::exposed_arc::{ExposedArc, Piece, exposed};

/// The arcs that can be reached from outside, and the others; both by atom and then by angle.
pub(super) fn outline(circles: &[(DVec2, f64)]) -> (Vec<ExposedArc>, Vec<ExposedArc>) {
    let pieces: Vec<Piece> = (0..circles.len())
        .flat_map(|atom| exposed(circles, atom))
        .collect();
    let arcs = |line: &Vec<usize>| {
        line.iter()
            .map(|&index| pieces[index].arc)
            .collect::<Vec<_>>()
    };
    let is_outside =
        |line: &Vec<usize>| arcs(line).iter().map(ExposedArc::swept_area).sum::<f64>() > 0.0;
    let outsides: Vec<Vec<usize>> = closed_lines(&pieces)
        .into_iter()
        .filter(is_outside)
        .collect();
    let mut reached = vec![false; pieces.len()];
    for line in &outsides {
        let first = pieces[line[0]].arc;
        let start = first.point(first.start);
        // The outer lines of two parts do not cross.
        if !outsides
            .iter()
            .any(|other| other != line && encircle(&arcs(other), start))
        {
            for &index in line {
                reached[index] = true;
            }
        }
    }
    let (mut outer, mut hidden) = (Vec::new(), Vec::new());
    for (piece, reached) in pieces.iter().zip(reached) {
        if reached {
            outer.push(piece.arc);
        } else {
            hidden.push(piece.arc);
        }
    }
    (outer, hidden)
}

/// Whether closed lines enclose a point that lies in none of the discs of their arcs.
pub(super) fn encircle(lines: &[ExposedArc], point: DVec2) -> bool {
    lines
        .iter()
        .map(|arc| arc.turn_about(point))
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
    // Of the two crossings of two circles only one is an entry.
    for (index, piece) in pieces.iter().enumerate() {
        let follows = |other: &Piece| match piece.after {
            None => other.arc.atom == piece.arc.atom,
            Some(after) => other.arc.atom == after && other.before == Some(piece.arc.atom),
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
    // Where three circles meet in one point, rounding may give different atoms on both sides.
    for (piece, next) in pieces
        .iter()
        .zip(&mut next)
        .filter(|(_, next)| next.is_none())
    {
        let end = piece.arc.point(piece.arc.end);
        let away = |index: &usize| {
            let arc = &pieces[*index].arc;
            arc.point(arc.start).distance_squared(end)
        };
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
