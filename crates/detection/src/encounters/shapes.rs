//! The molecules of the encounters.

use carom_geometry::{Atom, Molecule, Shape};
use glam::DVec2;

use super::random::Draw;

/// The shapes below are within the limits of a molecule.
pub(super) const VALID: &str = "radii and masses are positive, and centres differ";

/// One to five atoms, with radius 0.2 to 1 and mass 0.5 to 2 each.
pub(super) fn ordinary(draw: &mut Draw) -> Molecule {
    let shape = draw.one_of(&[
        Shape::Disc,
        Shape::Dumbbell,
        Shape::Rod(3),
        Shape::Cross,
        Shape::Tee,
    ]);
    named(draw, shape)
}

/// At least two atoms, with radius 0.2 to 1 and mass 0.5 to 2 each.
pub(super) fn extended(draw: &mut Draw) -> Molecule {
    let shape = draw.one_of(&[Shape::Dumbbell, Shape::Rod(3), Shape::Cross, Shape::Tee]);
    named(draw, shape)
}

pub(super) fn named(draw: &mut Draw, shape: Shape) -> Molecule {
    let (radius, mass) = (draw.scale(0.2, 1.0), draw.between(0.5, 2.0));
    Molecule::named(shape, radius, mass).expect(VALID)
}

/// The molecule with all lengths times `factor`.
pub(super) fn scaled(molecule: &Molecule, factor: f64) -> Molecule {
    let atom = |atom: &Atom| {
        Atom::new(factor * atom.offset(), factor * atom.radius(), atom.mass()).expect(VALID)
    };
    Molecule::new(molecule.atoms().iter().map(atom)).expect(VALID)
}

/// The molecule with other masses, which move its centre of mass.
pub(super) fn weighed(molecule: &Molecule, mut mass: impl FnMut(usize) -> f64) -> Molecule {
    let atom =
        |(i, atom): (usize, &Atom)| Atom::new(atom.offset(), atom.radius(), mass(i)).expect(VALID);
    Molecule::new(molecule.atoms().iter().enumerate().map(atom)).expect(VALID)
}

/// A disc of `radius` with `count` discs 10³ times smaller on its rim.
pub(super) fn warty(radius: f64, count: u8) -> Molecule {
    let wart = |index: u8| {
        let angle = std::f64::consts::TAU * f64::from(index) / f64::from(count);
        let (sin, cos) = libm::sincos(angle);
        Atom::new(radius * DVec2::new(cos, sin), 1e-3 * radius, 1.0).expect(VALID)
    };
    let body = Atom::new(DVec2::ZERO, radius, 1.0).expect(VALID);
    Molecule::new((0..count).map(wart).chain([body])).expect(VALID)
}

/// The `count` sites of a triangular lattice that are nearest to a random point, as touching discs
/// of radius 1/2.
pub(super) fn blob(draw: &mut Draw, count: usize) -> Molecule {
    let middle = DVec2::new(draw.between(0.0, 1.0), draw.between(0.0, 1.0));
    let reach = 2 + libm::sqrt(count as f64) as i32;
    let mut sites: Vec<DVec2> = Vec::new();
    for row in -reach..=reach {
        for column in -2 * reach..=2 * reach {
            let x = f64::from(column) + 0.5 * f64::from(row);
            sites.push(DVec2::new(x, 0.5 * 3f64.sqrt() * f64::from(row)));
        }
    }
    sites.sort_by(|a, b| {
        a.distance_squared(middle)
            .total_cmp(&b.distance_squared(middle))
    });
    let mass = 1.0 / count as f64;
    Molecule::new(
        sites
            .into_iter()
            .take(count)
            .map(|at| Atom::new(at, 0.5, mass).expect(VALID)),
    )
    .expect(VALID)
}
