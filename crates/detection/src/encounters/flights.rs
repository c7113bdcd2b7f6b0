//! Encounters in which two molecules approach from a distance and pass each other, or collide.

use carom_geometry::{Molecule, Shape};
use carom_kinematics::{Motion, RelativeMotion};
use glam::DVec2;

use super::{
    Encounter,
    random::Draw,
    shapes::{VALID, blob, ordinary, scaled, warty, weighed},
    size,
};

/// The relative motion of two molecules: velocity of B less that of A, and both angular velocities.
#[derive(Debug, Clone, Copy)]
pub(super) struct Speeds {
    pub(super) velocity: DVec2,
    pub(super) spins: [f64; 2],
}

/// Draws from Maxwell's distribution at the temperature `kt` (energy).
pub(super) fn thermal(draw: &mut Draw, molecules: &[Molecule; 2], kt: f64) -> Speeds {
    let mut velocity = || {
        let [a, b] = molecules.each_ref().map(|molecule| {
            (kt / molecule.mass()).sqrt() * DVec2::new(draw.normal(), draw.normal())
        });
        b - a
    };
    let velocity = velocity();
    let spins = molecules.each_ref().map(|molecule| {
        if molecule.is_disc() {
            0.0
        } else {
            (kt / molecule.moment_of_inertia()).sqrt() * draw.normal()
        }
    });
    Speeds { velocity, spins }
}

/// B starts `distance` sizes before the point of closest approach; the centres would pass at
/// `across` sizes.
pub(super) fn fly_by(
    draw: &mut Draw,
    molecules: [Molecule; 2],
    speeds: Speeds,
    distance: f64,
    across: f64,
) -> Encounter {
    let along = speeds.velocity.normalize();
    let motion = RelativeMotion {
        orientation: [draw.orientation(), draw.orientation()],
        angular_velocity: speeds.spins,
        ..RelativeMotion::exactly(
            size(&molecules) * (across * along.perp() - distance * along),
            speeds.velocity,
        )
    };
    // Without a window the circles never meet; the horizon is then well after they have passed.
    let passed = 2.0 * distance * size(&molecules) / speeds.velocity.length();
    Encounter::until_parted(molecules, motion, passed)
}

pub(super) fn fly_by_from_near(
    draw: &mut Draw,
    molecules: [Molecule; 2],
    speeds: Speeds,
) -> Encounter {
    let (distance, across) = (draw.between(1.05, 6.0), draw.between(-1.0, 1.0));
    fly_by(draw, molecules, speeds, distance, across)
}

pub(super) fn small_discs(draw: &mut Draw) -> Encounter {
    let radius = 1e-3;
    let molecules = [(); 2].map(|()| Molecule::disc(radius, 1.0).expect(VALID));
    let velocity = 2f64.sqrt() * (draw.direction() - draw.direction());
    let (distance, across) = (
        draw.scale(0.01, 1.0) / (2.0 * radius),
        draw.between(-1.5, 1.5),
    );
    fly_by(
        draw,
        molecules,
        Speeds {
            velocity,
            spins: [0.0; 2],
        },
        distance,
        across,
    )
}

pub(super) fn generic(draw: &mut Draw, kt: f64) -> Encounter {
    let molecules = [ordinary(draw), ordinary(draw)];
    let speeds = thermal(draw, &molecules, kt);
    fly_by_from_near(draw, molecules, speeds)
}

/// Thermal angular velocities times a factor for each body.
pub(super) fn spinning(draw: &mut Draw, factors: [f64; 2]) -> Encounter {
    let mut encounter = generic(draw, 1.0);
    for (spin, factor) in encounter.motion.angular_velocity.iter_mut().zip(factors) {
        *spin *= factor;
    }
    encounter
}

pub(super) fn large_omega(draw: &mut Draw) -> Encounter {
    let factors = [draw.scale(1e2, 1e4), draw.scale(1e2, 1e4)];
    spinning(draw, factors)
}

/// From 10² to 10⁶ sizes away; if `offset`, also both up to 10⁹ sizes away from the origin.
pub(super) fn far(draw: &mut Draw, offset: bool) -> Encounter {
    let molecules = [ordinary(draw), ordinary(draw)];
    let speeds = thermal(draw, &molecules, 1.0);
    let (distance, across) = (draw.scale(1e2, 1e6), draw.between(-1.0, 1.0));
    let mut encounter = fly_by(draw, molecules, speeds, distance, across);
    if offset {
        let origin = encounter.size() * draw.scale(1e3, 1e9) * draw.direction();
        let motion = encounter.motion;
        let at = |position: DVec2, velocity: DVec2, body: usize| Motion {
            velocity,
            orientation: motion.orientation[body],
            angular_velocity: motion.angular_velocity[body],
            ..Motion::at_rest(position)
        };
        let a = at(origin, DVec2::ZERO, 0);
        let b = at(origin + motion.separation, motion.velocity, 1);
        encounter.motion = RelativeMotion::between(&a, &b, DVec2::ZERO, 0.0);
    }
    encounter
}

/// If `between_molecules`, all atoms of A are 10⁶ times as heavy as those of B. Otherwise one atom
/// of each molecule is 10⁶ times as heavy as its others.
pub(super) fn mass_ratio(draw: &mut Draw, between_molecules: bool) -> Encounter {
    let (a, b) = (super::shapes::extended(draw), super::shapes::extended(draw));
    let molecules = if between_molecules {
        [weighed(&a, |_| 1e6), weighed(&b, |_| 1.0)]
    } else {
        let (heavy_a, heavy_b) = (draw.one_of(&[0, 1]), draw.one_of(&[0, 1]));
        let mass = |heavy: usize| move |index: usize| if index == heavy { 1.0 } else { 1e-6 };
        [weighed(&a, mass(heavy_a)), weighed(&b, mass(heavy_b))]
    };
    let speeds = thermal(draw, &molecules, 1.0);
    fly_by_from_near(draw, molecules, speeds)
}

/// If `between_molecules`, B is 10³ times smaller than A. Otherwise each molecule is a disc with a
/// few discs 10³ times smaller on its rim.
pub(super) fn size_ratio(draw: &mut Draw, between_molecules: bool) -> Encounter {
    let molecules = if between_molecules {
        let (a, b) = (ordinary(draw), ordinary(draw));
        [a, scaled(&b, 1e-3)]
    } else {
        [
            warty(draw.between(0.5, 1.0), 3),
            warty(draw.between(0.5, 1.0), 3),
        ]
    };
    let speeds = Speeds {
        velocity: DVec2::new(draw.normal(), draw.normal()),
        spins: [draw.between(-5.0, 5.0), draw.between(-5.0, 5.0)],
    };
    fly_by_from_near(draw, molecules, speeds)
}

pub(super) fn rods(draw: &mut Draw, atoms: usize) -> Encounter {
    let rod = || Molecule::named(Shape::Rod(atoms), 0.5, 1.0 / atoms as f64).expect(VALID);
    let molecules = [rod(), rod()];
    let speeds = thermal(draw, &molecules, 1.0);
    fly_by_from_near(draw, molecules, speeds)
}

pub(super) fn blobs(draw: &mut Draw, atoms: usize) -> Encounter {
    let molecules = [blob(draw, atoms), blob(draw, atoms)];
    let speeds = thermal(draw, &molecules, 1.0);
    fly_by_from_near(draw, molecules, speeds)
}
