//! Random bodies with straight sides: capsules and polygons by name, own corners, atoms that edges
//! join, and rings that other bodies may be inside.

use std::f64::consts::{PI, TAU};

use carom::engine::{AtomSpec, Distribution, EllipseSpec, GasSpec, MoleculeSpec};
use carom_geometry::{MAX_ASPECT, MIN_ROUNDING};
use libm::{cos, sin};

use super::kinematics::BodyPair;
use crate::fuzz::random::FuzzDraw;

/// A random body with sides of about this radius (length), and of this mass.
pub fn sided_body(draw: &mut FuzzDraw, radius: f64, mass: f64) -> MoleculeSpec {
    match draw.index(10) {
        0..=5 => {
            let (shape, size) = named(draw, radius);
            let has_corners = !shape.starts_with("capsule");
            MoleculeSpec {
                shape: Some(shape),
                size: Some(size),
                rounding: if has_corners { rounding(draw) } else { None },
                ..of_mass(draw, radius, mass)
            }
        }
        6 | 7 => MoleculeSpec {
            polygon: corners(draw, radius),
            rounding: rounding(draw),
            ..of_mass(draw, radius, mass)
        },
        8 => joined(draw, radius, mass),
        _ => ring(draw, radius, mass),
    }
}

/// The keys of a gas of bodies with sides of about this radius (length); every second one is of
/// drawn sizes.
pub fn sided_gas(draw: &mut FuzzDraw, radius: f64) -> GasSpec {
    let (shape, size) = named(draw, radius);
    let has_corners = !shape.starts_with("capsule");
    GasSpec {
        shape: Some(shape),
        size: Some(size.into()),
        rounding: if has_corners { rounding(draw) } else { None },
        scale: draw
            .happens(0.5)
            .then(|| Distribution::Uniform([draw.between(0.3, 1.0), 1.0]).into()),
        mass: Some(draw.scale(0.1, 10.0).into()),
        ..GasSpec::default()
    }
}

/// The ratio of the axes of a random ellipse: small, or rarely up to the largest.
fn aspect(draw: &mut FuzzDraw) -> f64 {
    let most = if draw.happens(0.1) { MAX_ASPECT } else { 20.0 };
    if draw.happens(0.05) {
        1.0 + draw.scale(1e-15, 1e-3)
    } else {
        draw.scale(1.0, most)
    }
}

/// One random ellipse of a list, between two circles about the origin.
fn listed_ellipse(draw: &mut FuzzDraw, [inner, outer]: [f64; 2], mass: f64) -> EllipseSpec {
    let (room, ratio) = (0.5 * (outer - inner), aspect(draw));
    let longer = draw.scale(0.3, 1.0) * room;
    let axes = [longer, longer / ratio];
    EllipseSpec {
        at: point(inner + room, draw.between(0.0, TAU)),
        axes: if draw.happens(0.5) {
            axes
        } else {
            [axes[1], axes[0]]
        },
        turn: draw.between(-4.0, 4.0),
        mass: draw.scale(0.1, 1.0) * mass,
    }
}

/// Several ellipses, and perhaps discs, in rings about each other.
fn ellipses(draw: &mut FuzzDraw, radius: f64, mass: f64) -> MoleculeSpec {
    let count = draw.integer(1, 5);
    let circle = |ring: i64| radius * ring as f64 / count as f64;
    let (mut atoms, mut ellipses) = (Vec::new(), Vec::new());
    for ring in 0..count {
        let [inner, outer] = [circle(ring), circle(ring + 1)];
        if draw.happens(0.25) {
            let room = 0.5 * (outer - inner);
            atoms.push(AtomSpec {
                at: point(inner + room, draw.between(0.0, TAU)),
                radius: draw.scale(0.1, 1.0) * room,
                mass,
            });
        } else {
            ellipses.push(listed_ellipse(draw, [inner, outer], mass));
        }
    }
    MoleculeSpec {
        atoms,
        ellipses,
        ..MoleculeSpec::default()
    }
}

/// A random ellipse of about this radius (length), and of this mass; some bodies have several.
pub fn ellipse_body(draw: &mut FuzzDraw, radius: f64, mass: f64) -> MoleculeSpec {
    if draw.happens(0.3) {
        return ellipses(draw, radius, mass);
    }
    MoleculeSpec {
        shape: Some(format!("ellipse:{}", aspect(draw))),
        size: Some(2.0 * radius),
        ..of_mass(draw, radius, mass)
    }
}

/// The keys of a gas of ellipses of about this radius (length); every second one is of drawn sizes.
pub fn ellipse_gas(draw: &mut FuzzDraw, radius: f64) -> GasSpec {
    GasSpec {
        shape: Some(format!("ellipse:{}", aspect(draw))),
        size: Some((2.0 * radius).into()),
        scale: draw
            .happens(0.5)
            .then(|| Distribution::Uniform([draw.between(0.3, 1.0), 1.0]).into()),
        mass: Some(draw.scale(0.1, 10.0).into()),
        ..GasSpec::default()
    }
}

/// The mass of a body, as such or by its density.
fn of_mass(draw: &mut FuzzDraw, radius: f64, mass: f64) -> MoleculeSpec {
    let by_density = draw.happens(0.2);
    MoleculeSpec {
        mass: (!by_density).then_some(mass),
        density: by_density.then_some(mass / (radius * radius)),
        ..MoleculeSpec::default()
    }
}

/// The radius of the corners over the size: the default, or any from the least on, and rarely one
/// that is refused.
fn rounding(draw: &mut FuzzDraw) -> Option<f64> {
    if draw.happens(0.5) {
        None
    } else if draw.happens(0.02) {
        Some(draw.one_of(&[0.0, 0.1 * MIN_ROUNDING]))
    } else {
        Some(draw.scale(MIN_ROUNDING, 1.0))
    }
}

/// A named shape of about this radius, and its size (length).
fn named(draw: &mut FuzzDraw, radius: f64) -> (String, f64) {
    match draw.index(6) {
        0 => {
            let length = draw.scale(1e-3, 100.0);
            (format!("capsule:{length}"), 2.0 * radius / (1.0 + length))
        }
        1 => ("square".to_owned(), 1.4 * radius),
        2 => {
            let aspect = draw.scale(0.01, 100.0);
            (
                format!("rectangle:{aspect}"),
                2.0 * radius / 1f64.hypot(aspect),
            )
        }
        3 => ("triangle".to_owned(), 1.7 * radius),
        4 => {
            let count = if draw.happens(0.1) {
                draw.integer(17, 100)
            } else {
                draw.integer(3, 16)
            };
            let size = 2.0 * radius * sin(PI / count as f64);
            (format!("polygon:{count}"), size)
        }
        _ => {
            let [ahead, behind] = [(); 2].map(|()| draw.scale(0.05, 5.0));
            let size = 2.0 * radius / (1.0 + ahead + behind);
            (format!("kite:{ahead},{behind}"), size)
        }
    }
}

/// A point at this distance and angle from the origin.
fn point(distance: f64, angle: f64) -> BodyPair {
    [distance * cos(angle), distance * sin(angle)]
}

/// The corners of a star, an L or a comb, of about this radius.
fn corners(draw: &mut FuzzDraw, radius: f64) -> Vec<BodyPair> {
    if draw.happens(0.3) {
        return comb(draw, radius);
    }
    // Seen from the origin the corners follow on each other: the sides do not cross.
    let count = draw.integer(3, 12);
    let start = draw.between(0.0, TAU);
    let angle = |index: i64, shift: f64| start + TAU / count as f64 * (index as f64 + shift);
    (0..count)
        .map(|index| {
            point(
                radius * draw.scale(0.2, 1.0),
                angle(index, draw.between(-0.4, 0.4)),
            )
        })
        .collect()
}

/// The corners of a bar with one to four teeth: with one, an L.
fn comb(draw: &mut FuzzDraw, radius: f64) -> Vec<BodyPair> {
    let teeth = draw.integer(1, 4);
    let width = 2.0 * radius / (2 * teeth) as f64;
    let (bar, tip) = (
        draw.scale(0.05, 0.5) * radius,
        draw.between(0.6, 1.0) * radius,
    );
    let mut corners = vec![[0.0, 0.0], [2.0 * radius, 0.0], [2.0 * radius, bar]];
    for tooth in (0..teeth).rev() {
        let left = 2.0 * tooth as f64 * width;
        corners.extend([[left + width, bar], [left + width, tip], [left, tip]]);
        if tooth > 0 {
            corners.push([left, bar]);
        }
    }
    corners
}

/// Atoms of random radii, each joined to the next, and perhaps some others, by edges.
fn joined(draw: &mut FuzzDraw, radius: f64, mass: f64) -> MoleculeSpec {
    let count = draw.integer(2, 7) as u32;
    let atoms: Vec<AtomSpec> = (0..count)
        .map(|_| AtomSpec {
            at: point(radius * draw.between(0.0, 1.0), draw.between(0.0, TAU)),
            radius: draw.scale(1e-6, 0.3) * radius,
            mass: draw.scale(0.1, 1.0) * mass,
        })
        .collect();
    let mut edges: Vec<[u32; 2]> = (1..count).map(|index| [index - 1, index]).collect();
    let has_branches = count > 3 && draw.happens(0.3);
    if has_branches {
        edges.push([0, 2]);
    }
    MoleculeSpec {
        edge_radius: thinner_than(draw, &atoms),
        // What lines with branches enclose is not clear.
        hollow: has_branches,
        atoms,
        edges,
        ..MoleculeSpec::default()
    }
}

/// A ring of edges, hollow or not, in which other bodies may have room.
fn ring(draw: &mut FuzzDraw, radius: f64, mass: f64) -> MoleculeSpec {
    let count = draw.integer(3, 10) as u32;
    let (circle, thickness) = (
        draw.scale(1.0, 4.0) * radius,
        draw.scale(1e-4, 0.2) * radius,
    );
    let atom = |index: u32| AtomSpec {
        at: point(circle, TAU * f64::from(index) / f64::from(count)),
        radius: thickness,
        mass,
    };
    let atoms: Vec<AtomSpec> = (0..count).map(atom).collect();
    MoleculeSpec {
        edge_radius: thinner_than(draw, &atoms),
        hollow: draw.happens(0.8),
        edges: (0..count)
            .map(|index| [index, (index + 1) % count])
            .collect(),
        atoms,
        ..MoleculeSpec::default()
    }
}

/// A radius of edges that no atom is thinner than, or none.
fn thinner_than(draw: &mut FuzzDraw, atoms: &[AtomSpec]) -> Option<f64> {
    let thinnest = atoms
        .iter()
        .map(|atom| atom.radius)
        .fold(f64::INFINITY, f64::min);
    draw.happens(0.5).then(|| draw.scale(0.01, 1.0) * thinnest)
}
