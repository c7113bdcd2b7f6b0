//! Random bodies with straight edges.

use std::f64::consts::TAU;

use carom_geometry::{Atom, Interior, Molecule};
use glam::DVec2;

use crate::fuzz::random::FuzzDraw;

/// Generated numbers are inside the accepted range.
pub(super) const VALID: &str = "radii and masses are positive, and centres differ";

/// A capsule, a convex or concave polygon, a hollow ring, or discs some of which are connected.
pub(super) fn edged(draw: &mut FuzzDraw) -> Molecule {
    match draw.index(5) {
        0 => Molecule::capsule(draw.scale(0.1, 3.0), draw.scale(1e-6, 1.0), 1.0).expect(VALID),
        1 => regular(draw),
        2 => star(draw),
        3 => ring(draw),
        _ => network(draw),
    }
}

fn corner(index: usize, count: usize, distance: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(TAU * index as f64 / count as f64);
    distance * DVec2::new(cos, sin)
}

fn regular(draw: &mut FuzzDraw) -> Molecule {
    let count = draw.integer(3, 16) as usize;
    let corners: Vec<DVec2> = (0..count).map(|index| corner(index, count, 1.0)).collect();
    Molecule::polygon(&corners, draw.scale(1e-9, 0.3), 1.0).expect(VALID)
}

/// A polygon whose corners are at random distances from a point that sees all of them.
fn star(draw: &mut FuzzDraw) -> Molecule {
    let count = draw.integer(4, 10) as usize;
    let corners: Vec<DVec2> = (0..count)
        .map(|index| corner(index, count, draw.between(0.2, 1.0)))
        .collect();
    Molecule::polygon(&corners, draw.scale(1e-9, 0.05), 1.0).expect(VALID)
}

fn ring(draw: &mut FuzzDraw) -> Molecule {
    let (count, radius) = (draw.integer(3, 24) as usize, draw.scale(1e-9, 0.1));
    let atoms: Vec<Atom> = (0..count)
        .map(|index| Atom::new(corner(index, count, 1.0), radius, 1.0).expect(VALID))
        .collect();
    let next = |index: usize| ((index + 1) % count) as u32;
    let edges: Vec<_> = (0..count)
        .map(|index| ([index as u32, next(index)], radius))
        .collect();
    Molecule::with_edges(atoms, &edges, Interior::Hollow).expect(VALID)
}

/// Discs in a row, with edges that are as thick or thinner, and may cross each other.
fn network(draw: &mut FuzzDraw) -> Molecule {
    let count = draw.integer(2, 6) as usize;
    let atoms: Vec<Atom> = (0..count)
        .map(|index| {
            let place = DVec2::new(0.5 * index as f64, draw.between(-1.0, 1.0));
            Atom::new(place, draw.scale(1e-6, 0.3), draw.scale(0.1, 10.0)).expect(VALID)
        })
        .collect();
    let mut edges = Vec::new();
    for second in 1..count {
        for first in 0..second {
            if second == 1 || draw.happens(0.4) {
                let thickest = atoms[first].radius().min(atoms[second].radius());
                let radius = thickest * draw.one_of(&[1.0, 0.5, 1e-3]);
                edges.push(([first as u32, second as u32], radius));
            }
        }
    }
    Molecule::with_edges(atoms, &edges, Interior::Hollow).expect(VALID)
}
