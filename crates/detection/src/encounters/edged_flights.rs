//! Encounters of bodies with straight edges that fly at each other.

use carom_geometry::{Molecule, gap_between};
use carom_kinematics::{Orientation, RelativeMotion};
use glam::DVec2;

use super::{
    Encounter,
    edged_shapes::{any, disc, rectangle, rounded, sixteen_sides},
    flights::{fly_by, fly_by_from_near, thermal},
    random::Draw,
    shapes::{VALID, ordinary},
    size,
};

/// Limit of random states until a body starts apart from a wall; half of them do.
const MAX_TRIES: u32 = 1000;

/// Two bodies of one family with thermal velocities and spins.
pub(super) fn of_family(draw: &mut Draw, family: fn(&mut Draw) -> Molecule) -> Encounter {
    let molecules = [family(draw), family(draw)];
    let speeds = thermal(draw, &molecules, 1.0);
    fly_by_from_near(draw, molecules, speeds)
}

/// A disc and a body with edges of any family.
pub(super) fn disc_and_edges(draw: &mut Draw) -> Encounter {
    let molecules = [disc(draw), any(draw)];
    let speeds = thermal(draw, &molecules, 1.0);
    let encounter = fly_by_from_near(draw, molecules, speeds);
    either_order(draw, encounter)
}

/// Two regular polygons of sixteen sides, of which one is up to 3.5 times as large as the other.
pub(super) fn sixteen_gons(draw: &mut Draw) -> Encounter {
    let factor = draw.between(1.0, 3.5);
    let molecules = [sixteen_sides(draw, 1.0), sixteen_sides(draw, factor)];
    let speeds = thermal(draw, &molecules, 1.0);
    let encounter = fly_by_from_near(draw, molecules, speeds);
    either_order(draw, encounter)
}

/// One body or both turn by an angle from `least` to `most` (radians) while they move by the size
/// of the pair.
pub(super) fn spinning(draw: &mut Draw, [least, most]: [f64; 2]) -> Encounter {
    let molecules = [any(draw), any(draw)];
    let mut speeds = thermal(draw, &molecules, 1.0);
    let passage = size(&molecules) / speeds.velocity.length();
    let fast = draw.sign() * draw.scale(least, most) / passage;
    let second = draw.sign() * draw.scale(least, most) / passage;
    let slow = speeds.spins[1];
    speeds.spins = [fast, if draw.happens(0.5) { second } else { slow }];
    let (distance, across) = (draw.between(1.05, 2.0), draw.between(-1.0, 1.0));
    let encounter = fly_by(draw, molecules, speeds, distance, across);
    either_order(draw, encounter)
}

/// From 10² to 10⁶ sizes away.
pub(super) fn far(draw: &mut Draw) -> Encounter {
    let molecules = [rounded(draw), rounded(draw)];
    let speeds = thermal(draw, &molecules, 1.0);
    let (distance, across) = (draw.scale(1e2, 1e6), draw.between(-1.0, 1.0));
    fly_by(draw, molecules, speeds, distance, across)
}

/// Two rectangles with equal spins, or none, and faces that are parallel to within 1e-12 to 1e-3;
/// they are 1e-9 to 1e-2 apart and close slowly.
pub(super) fn parallel_faces(draw: &mut Draw) -> Encounter {
    let molecules = [rectangle(draw, 1.0), rectangle(draw, 1.0)];
    let half_height = |molecule: &Molecule| {
        let corner = &molecule.atoms()[2];
        corner.offset().y + corner.radius()
    };
    let gap = draw.scale(1e-9, 1e-2);
    let tilt = draw.sign() * draw.scale(1e-12, 1e-3);
    // The corner of the tilted face that is nearest must still be apart.
    let height = half_height(&molecules[0]) + half_height(&molecules[1]) + gap + tilt.abs();
    let orientation = draw.orientation();
    let [along, normal] = {
        let along = orientation.cos_sin();
        [along, along.perp()]
    };
    let slide = draw.between(-0.9, 0.9) * along;
    let spin = if draw.happens(0.3) {
        0.0
    } else {
        draw.sign() * draw.scale(1e-3, 3.0)
    };
    let closing = (gap + tilt.abs()) * draw.scale(0.5, 1e3);
    let separation = slide + height * normal;
    // At equal spins all of the body B moves as B's centre relative to A, seen from A.
    let velocity = spin * separation.perp() - closing * normal
        + draw.between(-1.0, 1.0) * draw.scale(1e-6, 1.0) * along;
    let tilted = Orientation::from_radians(orientation.radians() + tilt);
    let motion = RelativeMotion {
        orientation: [orientation, tilted],
        angular_velocity: [spin; 2],
        ..RelativeMotion::exactly(separation, velocity)
    };
    let encounter = Encounter {
        molecules,
        motion,
        horizon: 1.0,
    };
    either_order(draw, encounter)
}

/// A wall that turns, and a molecule of discs or a body with edges.
pub(super) fn turning_wall(draw: &mut Draw) -> Encounter {
    for _ in 0..MAX_TRIES {
        let body = if draw.happens(0.5) {
            ordinary(draw)
        } else {
            any(draw)
        };
        let length = draw.scale(0.3, 10.0) * body.bounding_radius();
        let radius = if draw.happens(0.5) {
            0.0
        } else {
            draw.scale(1e-3, 0.1) * length
        };
        let wall = Molecule::wall(length * draw.direction(), radius).expect(VALID);
        let molecules = [wall, body];
        let mut speeds = thermal(draw, &molecules, 1.0);
        speeds.spins[0] = draw.normal() * speeds.velocity.length() / length;
        let (distance, across) = (draw.between(0.3, 2.0), draw.between(-1.0, 1.0));
        let encounter = fly_by(draw, molecules, speeds, distance, across);
        if is_apart(&encounter, 1e-6) {
            return either_order(draw, encounter);
        }
    }
    unreachable!("half of all bodies start apart from the wall")
}

/// Whether the bodies start at least `share` sizes apart.
pub(super) fn is_apart(encounter: &Encounter, share: f64) -> bool {
    let [a, b] = &encounter.molecules;
    let [turn_a, turn_b] = encounter.motion.orientation.map(Orientation::cos_sin);
    gap_between(a, turn_a, b, turn_b, encounter.motion.separation) > share * encounter.size()
}

/// The encounter, or that with the bodies exchanged.
pub(super) fn either_order(draw: &mut Draw, encounter: Encounter) -> Encounter {
    if draw.happens(0.5) {
        encounter.exchanged()
    } else {
        encounter
    }
}

/// A unit vector along a body's axis and one normal to it.
pub(super) fn axes(along: DVec2, orientation: Orientation) -> [DVec2; 2] {
    let along = orientation.cos_sin().rotate(along);
    [along, along.perp()]
}
