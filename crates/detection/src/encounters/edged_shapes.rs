//! The bodies with straight edges of the encounters.

use std::f64::consts::TAU;

use carom_geometry::{Atom, Interior, Molecule};
use glam::DVec2;

use super::{random::Draw, shapes::VALID};

/// A polygon with corners of `radius` (length) and a mass of 0.5 to 2.
fn polygon(draw: &mut Draw, corners: &[DVec2], radius: f64) -> Molecule {
    Molecule::polygon(corners, radius, draw.between(0.5, 2.0)).expect(VALID)
}

fn scaled(corners: &[[f64; 2]], factor: f64) -> Vec<DVec2> {
    corners
        .iter()
        .map(|&corner| factor * DVec2::from(corner))
        .collect()
}

/// A square of side 0.5 to 2 with corners of 1e-9 to 0.1 sides.
pub(super) fn square(draw: &mut Draw) -> Molecule {
    let side = draw.scale(0.5, 2.0);
    let radius = draw.scale(1e-9, 0.1) * side;
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    polygon(draw, &scaled(&corners, side), radius)
}

/// A rectangle of the given width (length) that is 0.2 to 1 widths high, with corners of 1e-9 to
/// 0.05 heights.
pub(super) fn rectangle(draw: &mut Draw, width: f64) -> Molecule {
    let height = draw.scale(0.2, 1.0) * width;
    let radius = draw.scale(1e-9, 0.05) * height;
    let (x, y) = (0.5 * width, 0.5 * height);
    polygon(
        draw,
        &scaled(&[[-x, -y], [x, -y], [x, y], [-x, y]], 1.0),
        radius,
    )
}

/// A capsule with a straight part of 0.2 to 2, and a radius of 1e-3 to 5 times as much.
pub(super) fn capsule(draw: &mut Draw) -> Molecule {
    let length = draw.scale(0.2, 2.0);
    let radius = draw.scale(1e-3, 5.0) * length;
    Molecule::capsule(length, radius, draw.between(0.5, 2.0)).expect(VALID)
}

/// A capsule of length 0.3 to 2 and a radius of 1e-6 lengths.
pub(super) fn needle(draw: &mut Draw) -> Molecule {
    let length = draw.scale(0.3, 2.0);
    Molecule::capsule(length, 1e-6 * length, draw.between(0.5, 2.0)).expect(VALID)
}

/// A triangle of width 1 and height 1e-4 to 0.1.
pub(super) fn sharp_triangle(draw: &mut Draw) -> Molecule {
    let height = draw.scale(1e-4, 0.1);
    let apex = DVec2::new(draw.between(0.0, 1.2), height);
    let radius = draw.scale(1e-4, 0.1) * height;
    polygon(draw, &[DVec2::ZERO, DVec2::X, apex], radius)
}

/// A polygon of 3 to 9 corners about a point that sees all of them; most are concave.
pub(super) fn star(draw: &mut Draw) -> Molecule {
    let count = draw.one_of(&[3u8, 4, 5, 6, 7, 8, 9]);
    let radius = draw.scale(1e-9, 1e-2);
    let corners: Vec<DVec2> = (0..count)
        .map(|index| {
            let angle = TAU * (f64::from(index) + draw.between(0.0, 0.6)) / f64::from(count);
            let (sin, cos) = libm::sincos(angle);
            draw.between(0.3, 1.0) * DVec2::new(cos, sin)
        })
        .collect();
    polygon(draw, &corners, radius)
}

/// An L with arms of length 1 and 0.4 to 1, and of thickness 0.1 to 0.3.
pub(super) fn ell(draw: &mut Draw) -> Molecule {
    let (second, thickness) = (draw.between(0.4, 1.0), draw.between(0.1, 0.3));
    let radius = draw.scale(1e-9, 0.02);
    let outline = [
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, thickness],
        [thickness, thickness],
        [thickness, second],
        [0.0, second],
    ];
    polygon(draw, &scaled(&outline, 1.0), radius)
}

/// A fork with two prongs of length 1 along y and a slot of width 0.2 between them.
pub(super) fn fork(draw: &mut Draw) -> Molecule {
    let radius = draw.scale(1e-9, 0.02);
    let outline = [
        [0.0, 0.0],
        [0.6, 0.0],
        [0.6, 1.2],
        [0.4, 1.2],
        [0.4, 0.2],
        [0.2, 0.2],
        [0.2, 1.2],
        [0.0, 1.2],
    ];
    polygon(draw, &scaled(&outline, 1.0), radius)
}

/// The width of the slot of [`fork`] between its rounded sides (length), and the middle of the slot
/// in the frame of the fork.
pub(super) fn slot(fork: &Molecule) -> (f64, DVec2) {
    let corner = |index: usize| fork.atoms()[index].offset();
    let width = corner(4).x - corner(5).x - 2.0 * fork.atoms()[4].radius();
    (
        width,
        0.25 * (corner(3) + corner(4) + corner(5) + corner(6)),
    )
}

/// The corners of a regular polygon of circumradius `size` (length).
fn regular(count: u8, size: f64) -> Vec<DVec2> {
    (0..count)
        .map(|index| {
            let (sin, cos) = libm::sincos(TAU * f64::from(index) / f64::from(count));
            size * DVec2::new(cos, sin)
        })
        .collect()
}

/// A regular polygon of sixteen sides of the given circumradius (length).
pub(super) fn sixteen_sides(draw: &mut Draw, size: f64) -> Molecule {
    let radius = draw.scale(1e-9, 0.05) * size;
    polygon(draw, &regular(16, size), radius)
}

/// A hollow regular polygon of 6 to 24 sides and circumradius 1.
pub(super) fn hollow_ring(draw: &mut Draw) -> Molecule {
    let count = draw.one_of(&[6u8, 7, 8, 12, 17, 24]);
    let radius = draw.scale(1e-9, 0.02);
    let mass = draw.between(0.5, 2.0) / f64::from(count);
    let atoms = regular(count, 1.0)
        .into_iter()
        .map(|corner| Atom::new(corner, radius, mass).expect(VALID));
    let count = u32::from(count);
    let edges: Vec<([u32; 2], f64)> = (0..count)
        .map(|index| ([index, (index + 1) % count], radius))
        .collect();
    Molecule::with_edges(atoms, &edges, Interior::Hollow).expect(VALID)
}

/// Three to five discs of different radii in a chain, each connected with the next by a thinner
/// edge or not.
pub(super) fn bonded_discs(draw: &mut Draw) -> Molecule {
    let count = draw.one_of(&[3u8, 4, 5]);
    let atoms: Vec<Atom> = (0..count)
        .map(|index| {
            let place = DVec2::new(0.5 * f64::from(index), draw.between(-0.4, 0.4));
            Atom::new(place, draw.scale(0.01, 0.3), draw.between(0.5, 2.0)).expect(VALID)
        })
        .collect();
    let mut edges = Vec::new();
    for index in 1..atoms.len() {
        let thickest = atoms[index - 1].radius().min(atoms[index].radius());
        let radius = draw.scale(1e-6, 1.0) * thickest;
        if draw.happens(0.7) || index == 1 {
            edges.push(([index as u32 - 1, index as u32], radius));
        }
    }
    Molecule::with_edges(atoms, &edges, Interior::Solid).expect(VALID)
}

/// A disc of radius 0.01 to 1.
pub(super) fn disc(draw: &mut Draw) -> Molecule {
    Molecule::disc(draw.scale(0.01, 1.0), draw.between(0.5, 2.0)).expect(VALID)
}

/// A body with edges of any family.
pub(super) fn any(draw: &mut Draw) -> Molecule {
    let family = draw.one_of(&[
        square,
        capsule,
        needle,
        sharp_triangle,
        star,
        ell,
        bonded_discs,
    ]);
    family(draw)
}

/// A body with edges whose smallest radius is at least 1e-3.
pub(super) fn rounded(draw: &mut Draw) -> Molecule {
    let radius = draw.scale(1e-3, 0.05);
    let corners = regular(draw.one_of(&[3, 4, 5]), 1.0);
    if draw.happens(0.3) {
        Molecule::capsule(1.0, radius, draw.between(0.5, 2.0)).expect(VALID)
    } else {
        polygon(draw, &corners, radius)
    }
}
