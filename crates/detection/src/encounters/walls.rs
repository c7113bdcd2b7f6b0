//! Encounters of a molecule with a wall, which has two end points and does not turn.

use std::f64::consts::TAU;

use carom_geometry::{Atom, Molecule, Shape, gap_between};
use carom_kinematics::{Orientation, RelativeMotion};
use glam::DVec2;

use super::{
    Encounter,
    random::Draw,
    shapes::{VALID, extended, named, ordinary},
};

/// Limit of random states until a molecule starts apart from the wall; half of them do.
const MAX_TRIES: u32 = 1000;

/// A wall of `length` in a random direction; half of the walls have a thickness.
fn wall(draw: &mut Draw, length: f64, thickest: f64) -> Molecule {
    let radius = if draw.happens(0.5) {
        0.0
    } else {
        draw.scale(1e-3, 1.0) * thickest
    };
    Molecule::wall(length * draw.direction(), radius).expect(VALID)
}

/// Unit vectors along the wall in its orientation, and normal to it towards the molecule.
fn axes(draw: &mut Draw, wall: &Molecule, orientation: Orientation) -> [DVec2; 2] {
    let along = orientation
        .cos_sin()
        .rotate(wall.atoms()[1].offset().normalize());
    [along, draw.sign() * along.perp()]
}

/// A molecule (one in ten is a rod of nine atoms) flies at a wall shorter or longer than itself: at
/// its face, at an end, or past it. Velocities are thermal, angular velocities thermal times a
/// factor.
pub(super) fn fly_at(draw: &mut Draw, spins: [f64; 2]) -> Encounter {
    for _ in 0..MAX_TRIES {
        let molecule = if draw.happens(0.1) {
            named(draw, Shape::Rod(9))
        } else {
            ordinary(draw)
        };
        let size = molecule.bounding_radius();
        let length = draw.scale(0.3, 30.0) * size;
        let wall = wall(draw, length, 0.5 * size);
        let orientation = [draw.orientation(), draw.orientation()];
        let [along, _] = axes(draw, &wall, orientation[0]);
        let velocity = DVec2::new(draw.normal(), draw.normal()) / molecule.mass().sqrt();
        let factor = draw.scale(spins[0], spins[1]);
        let spin = factor * draw.normal() / molecule.moment_of_inertia().sqrt();
        let spin = if molecule.is_disc() { 0.0 } else { spin };
        let target = draw.between(-0.7, 0.7) * (length + size) * along;
        let flight = draw.between(1.05, 6.0) * size / velocity.length();
        let motion = RelativeMotion {
            orientation,
            angular_velocity: [0.0, spin],
            ..RelativeMotion::exactly(target - velocity * flight, velocity)
        };
        if let Some(encounter) = apart(draw, [wall, molecule], motion, 2.0 * flight) {
            return encounter;
        }
    }
    unreachable!("half of all molecules start apart from the wall")
}

/// The lowest atom of a turning molecule overlaps the face by 10^−`exponent` sizes in seven of ten
/// cases, misses it by as much in the others, and moves along it.
pub(super) fn graze(draw: &mut Draw, exponent: u8) -> Encounter {
    let depth = 10f64.powi(-i32::from(exponent));
    let depth = if draw.happens(0.7) { depth } else { -depth };
    for _ in 0..MAX_TRIES {
        let molecule = extended(draw);
        let size = molecule.bounding_radius();
        let wall = wall(draw, 40.0 * size, 0.5 * size);
        let (at_rest, then) = (draw.orientation(), draw.orientation());
        let [along, normal] = axes(draw, &wall, at_rest);
        let turned = |atom: &Atom| then.cos_sin().rotate(atom.offset());
        let height = |atom: &&Atom| turned(atom).dot(normal) - atom.radius();
        let lowest = molecule
            .atoms()
            .iter()
            .min_by(|a, b| height(a).total_cmp(&height(b)))
            .expect(VALID);
        let arm = turned(lowest);
        let spin = draw.sign() * draw.between(0.5, 2.0);
        // g' = 0 at the graze.
        let velocity =
            draw.between(-2.0, 2.0) * size * along - spin * arm.perp().dot(normal) * normal;
        let time = draw.between(0.2, 2.0) / spin.abs();
        let reach = lowest.radius() + wall.atoms()[0].radius() - depth * size;
        let centre = draw.between(-5.0, 5.0) * size * along + reach * normal - arm;
        let before = Orientation::from_turns(then.turns() - spin * time / TAU);
        let motion = RelativeMotion {
            orientation: [at_rest, before],
            angular_velocity: [0.0, spin],
            ..RelativeMotion::exactly(centre - velocity * time, velocity)
        };
        if let Some(encounter) = apart(draw, [wall, molecule], motion, 2.0 * time) {
            return encounter;
        }
    }
    unreachable!("a third of all constructed molecules start apart")
}

/// A disc with a heavy spot off its centre, whose centre of mass is nearer to the wall than its
/// centre. It leaves a contact, turns, and returns after 10^−`exponent`/|ω|: g'' = −ω² n·r.
pub(super) fn recontact(draw: &mut Draw, exponent: u8) -> Encounter {
    let radius = draw.scale(0.2, 1.0);
    let disc = Atom::new(DVec2::ZERO, radius, 1.0).expect(VALID);
    let spot = Atom::new(
        draw.between(0.2, 0.8) * radius * DVec2::X,
        0.05 * radius,
        100.0,
    )
    .expect(VALID);
    let molecule = Molecule::new([disc, spot]).expect(VALID);
    let wall = wall(draw, 40.0 * radius, radius);
    let (at_rest, orientation) = (draw.orientation(), draw.orientation());
    let [along, normal] = axes(draw, &wall, at_rest);
    // Turned so that the centre of the disc is above the centre of mass.
    let upright =
        Orientation::from_turns(normal.to_angle() / TAU + 0.5 + 0.6 * (orientation.turns() / 2.0));
    let arm = upright.cos_sin().rotate(molecule.atoms()[0].offset());
    let spin = draw.sign() * draw.between(0.5, 2.0);
    let interval = 10f64.powi(-i32::from(exponent)) / spin.abs();
    let rate = 0.5 * spin * spin * arm.dot(normal) * interval;
    let slip = draw.between(-1.0, 1.0) * radius * along;
    let velocity = slip + (rate - spin * arm.perp().dot(normal)) * normal;
    let centre = draw.between(-5.0, 5.0) * radius * along
        + (radius + wall.atoms()[0].radius()) * normal
        - arm;
    let motion = RelativeMotion {
        orientation: [at_rest, upright],
        angular_velocity: [0.0, spin],
        ..RelativeMotion::exactly(centre, velocity)
    };
    let encounter = Encounter::until_parted([wall, molecule], motion, TAU / spin.abs());
    if draw.happens(0.5) {
        encounter.exchanged()
    } else {
        encounter
    }
}

/// The encounter, with the wall as B in half of the cases; `None` if the bodies do not start apart.
fn apart(
    draw: &mut Draw,
    molecules: [Molecule; 2],
    motion: RelativeMotion,
    otherwise: f64,
) -> Option<Encounter> {
    let [turn_a, turn_b] = motion.orientation.map(Orientation::cos_sin);
    let [wall, molecule] = &molecules;
    if gap_between(wall, turn_a, molecule, turn_b, motion.separation)
        <= 1e-3 * molecule.bounding_radius()
    {
        return None;
    }
    let encounter = Encounter::until_parted(molecules, motion, otherwise);
    Some(if draw.happens(0.5) {
        encounter.exchanged()
    } else {
        encounter
    })
}
