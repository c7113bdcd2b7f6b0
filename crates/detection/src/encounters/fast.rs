//! Encounters of fast rotors, and of pairs that turn alike and stay close.

use std::f64::consts::TAU;

use carom_geometry::{Atom, Molecule, Shape};
use carom_kinematics::{Orientation, RelativeMotion};
use glam::DVec2;

use super::{
    Encounter,
    flights::{Speeds, fly_by, thermal},
    random::Draw,
    shapes::{VALID, extended, named, ordinary, scaled},
    size,
};

/// One or both bodies turn 10⁴ to 10⁸ times while their bounding circles overlap.
pub(super) fn fast(draw: &mut Draw) -> Encounter {
    let molecules = [extended(draw), ordinary(draw)];
    let speeds = thermal(draw, &molecules, 1.0);
    let (distance, across) = (draw.between(1.05, 3.0), draw.between(-1.0, 1.0));
    let mut encounter = fly_by(draw, molecules, speeds, distance, across);
    let chord = (1.0 - across * across).sqrt().max(0.1);
    let duration = 2.0 * chord * encounter.size() / speeds.velocity.length();
    let mut spin = || draw.sign() * TAU * draw.scale(1e4, 1e8) / duration;
    let spins = [spin(), spin()];
    let both = draw.happens(0.3);
    encounter.motion.angular_velocity = [spins[0], if both { spins[1] } else { speeds.spins[1] }];
    if draw.happens(0.5) {
        encounter.exchanged()
    } else {
        encounter
    }
}

/// B is up to 10⁶ times smaller than A; up to 10⁶ turns while they move by the size of the pair.
pub(super) fn extreme_ratio(draw: &mut Draw) -> Encounter {
    let factor = draw.scale(1e-6, 1.0);
    let (a, b) = (ordinary(draw), ordinary(draw));
    let molecules = [a, scaled(&b, factor)];
    let velocity = DVec2::new(draw.normal(), draw.normal());
    let passing = size(&molecules) / velocity.length();
    let mut spin = || draw.sign() * TAU * draw.scale(1e-2, 1e6) / passing;
    let mut spins = [spin(), spin()];
    if draw.happens(0.6) {
        spins[usize::from(draw.happens(0.5))] *= 1e-3;
    }
    let (distance, across) = (draw.between(1.05, 3.0), draw.between(-1.0, 1.0));
    let encounter = fly_by(
        draw,
        molecules,
        Speeds { velocity, spins },
        distance,
        across,
    );
    if draw.happens(0.5) {
        encounter.exchanged()
    } else {
        encounter
    }
}

/// A light atom off the centre of a small heavy one, which lies inside it.
fn cam() -> Molecule {
    let heavy = Atom::new(DVec2::ZERO, 0.1, 1e3).expect(VALID);
    let light = Atom::new(DVec2::new(0.5, 0.0), 1.0, 1.0).expect(VALID);
    Molecule::new([heavy, light]).expect(VALID)
}

/// Two equal bodies side by side with equal orientations and angular velocities: the gap between
/// corresponding atoms is constant, although each atom accelerates. Half of the pairs close very
/// slowly.
pub(super) fn matched_spins(draw: &mut Draw) -> Encounter {
    let gap = draw.scale(1e-9, 1e-2);
    let molecules = [cam(), cam()];
    let direction = draw.direction();
    let orientation = draw.orientation();
    let spin = draw.sign() * TAU * draw.scale(0.1, 3.0);
    let closing = if draw.happens(0.5) {
        gap * draw.scale(0.5, 1e3)
    } else {
        0.0
    };
    let motion = RelativeMotion {
        orientation: [orientation; 2],
        angular_velocity: [spin; 2],
        ..RelativeMotion::exactly((2.0 + gap) * direction, -closing * direction)
    };
    Encounter {
        molecules,
        motion,
        horizon: 1.0,
    }
}

/// A dumbbell in a ring of twelve atoms that turns with it, both ends near the ring. Half of the
/// pairs drift very slowly.
pub(super) fn concentric(draw: &mut Draw) -> Encounter {
    let gap = draw.scale(1e-9, 1e-2);
    let ring = named(draw, Shape::Ring(12));
    let (circle, radius) = (ring.atoms()[0].arm(), ring.atoms()[0].radius());
    let arm = circle - (2.0 + gap) * radius;
    let atom = |x: f64| Atom::new(DVec2::new(x, 0.0), radius, 1.0).expect(VALID);
    let dumbbell = Molecule::new([atom(arm), atom(-arm)]).expect(VALID);
    let orientation = draw.orientation();
    // Towards a ring atom, or towards a point between two ring atoms.
    let aside = draw.between(0.0, 1.0 / 24.0) * if draw.happens(0.5) { 1.0 } else { 0.0 };
    let spin = draw.sign() * TAU * draw.scale(0.1, 3.0);
    let drift = if draw.happens(0.5) {
        gap * radius * draw.scale(0.5, 1e3)
    } else {
        0.0
    };
    let motion = RelativeMotion {
        orientation: [
            orientation,
            Orientation::from_turns(orientation.turns() + aside),
        ],
        angular_velocity: [spin; 2],
        ..RelativeMotion::exactly(DVec2::ZERO, drift * draw.direction())
    };
    Encounter {
        molecules: [dumbbell, ring],
        motion,
        horizon: 1.0,
    }
}
