//! Encounters of bodies with straight edges that begin inside each other's bounding circles.

use carom_geometry::Molecule;
use carom_kinematics::{Orientation, RelativeMotion};
use glam::DVec2;

use super::{
    Encounter,
    edged_flights::{either_order, is_apart},
    edged_shapes::{capsule, disc, ell, fork, hollow_ring, sharp_triangle, slot, square},
    flights::thermal,
    random::Draw,
    shapes::VALID,
};

/// Limit of random states until the bodies start apart; at least one in ten does.
const MAX_TRIES: u32 = 10_000;

/// An L that begins in the notch of another.
pub(super) fn ell_in_notch(draw: &mut Draw) -> Encounter {
    for _ in 0..MAX_TRIES {
        let factor = draw.between(0.2, 0.8);
        let (a, b) = (ell(draw), ell(draw));
        let b = b.scaled(factor).expect(VALID);
        let place = DVec2::new(draw.between(0.0, 1.0), draw.between(0.0, 1.0));
        // The inner corner of the L, atom 3.
        let corner = a.atoms()[3].offset();
        if let Some(encounter) = begun(draw, [a, b], corner + 0.7 * place, draw_free_turn) {
            return either_order(draw, encounter);
        }
    }
    unreachable!("one in ten such pairs starts apart")
}

/// A rod that begins in the slot of a fork.
pub(super) fn rod_in_slot(draw: &mut Draw) -> Encounter {
    for _ in 0..MAX_TRIES {
        let fork = fork(draw);
        let (width, middle) = slot(&fork);
        let radius = draw.between(0.05, 0.48) * width;
        let length = draw.between(0.2, 1.0);
        let rod = Molecule::capsule(length, radius, draw.between(0.5, 2.0)).expect(VALID);
        let place = middle + DVec2::new(draw.between(-0.3, 0.3) * width, draw.between(-0.3, 0.6));
        if let Some(encounter) = begun(draw, [fork, rod], place, draw_upright_turn) {
            return either_order(draw, encounter);
        }
    }
    unreachable!("one in ten such pairs starts apart")
}

/// A body in a hollow ring. A third of the horizons may end before the contact.
pub(super) fn inside_ring(draw: &mut Draw) -> Encounter {
    for _ in 0..MAX_TRIES {
        let ring = hollow_ring(draw);
        let family = draw.one_of(&[square, capsule, disc, sharp_triangle]);
        let body = family(draw);
        let factor = draw.between(0.05, 0.7) / body.bounding_radius();
        let body = body.scaled(factor).expect(VALID);
        let place = draw.between(0.0, 0.7) * draw.direction();
        if let Some(mut encounter) = begun(draw, [ring, body], place, draw_free_turn) {
            if draw.happens(0.33) {
                encounter.horizon *= draw.between(0.0, 0.3);
            }
            return either_order(draw, encounter);
        }
    }
    unreachable!("most such pairs start apart")
}

fn draw_free_turn(draw: &mut Draw) -> f64 {
    draw.between(-0.5, 0.5)
}

/// The orientation of a rod along y, to within a tenth of a turn.
fn draw_upright_turn(draw: &mut Draw) -> f64 {
    0.25 + draw.between(-0.1, 0.1) * draw.scale(1e-3, 1.0)
}

/// Thermal motion of two bodies, with B's centre at `place` in the frame of A and B turned against
/// A by a random angle (turns); `None` if they do not start apart.
fn begun(
    draw: &mut Draw,
    molecules: [Molecule; 2],
    place: DVec2,
    turn_of_b: fn(&mut Draw) -> f64,
) -> Option<Encounter> {
    let speeds = thermal(draw, &molecules, 1.0);
    let orientation = draw.orientation();
    let turned = Orientation::from_turns(orientation.turns() + turn_of_b(draw));
    let motion = RelativeMotion {
        orientation: [orientation, turned],
        angular_velocity: speeds.spins,
        ..RelativeMotion::exactly(orientation.cos_sin().rotate(place), speeds.velocity)
    };
    let encounter = Encounter::until_parted(molecules, motion, 1.0);
    is_apart(&encounter, 1e-9).then_some(encounter)
}
