//! Encounters constructed backwards in time from a tangential pass of known depth.

use std::f64::consts::TAU;

use carom_geometry::{Atom, Molecule, gap_between};
use carom_kinematics::{Orientation, RelativeMotion};
use glam::DVec2;

use super::{Encounter, random::Draw, shapes::ordinary, size};

/// Limit of constructed pairs until one does not overlap at the start; one in three succeeds.
const MAX_TRIES: u32 = 1000;

/// A graze with a depth of 1e-9 to 1e-3 sizes.
pub(super) fn grazing(draw: &mut Draw) -> Encounter {
    let depth = draw.scale(1e-9, 1e-3);
    graze_of(draw, depth)
}

/// A graze with a depth of 10^−`exponent` sizes.
pub(super) fn graze(draw: &mut Draw, exponent: u8) -> Encounter {
    graze_of(draw, 10f64.powi(-i32::from(exponent)))
}

/// Seven in ten overlap by `depth` sizes, the others miss by it.
fn graze_of(draw: &mut Draw, depth: f64) -> Encounter {
    let depth = if draw.happens(0.7) { depth } else { -depth };
    for _ in 0..MAX_TRIES {
        let molecules = [ordinary(draw), ordinary(draw)];
        let encounter = planted(draw, molecules, depth);
        if starts_apart(&encounter) {
            return encounter;
        }
    }
    unreachable!("a third of all constructed pairs start apart")
}

fn starts_apart(encounter: &Encounter) -> bool {
    let [a, b] = &encounter.molecules;
    let [turn_a, turn_b] = encounter.motion.orientation.map(Orientation::cos_sin);
    gap_between(a, turn_a, b, turn_b, encounter.motion.separation) > 1e-3 * encounter.size()
}

/// The arm (in the present orientation) and the radius of the atom that reaches farthest in a
/// direction.
pub(super) fn outermost(molecule: &Molecule, turn: DVec2, direction: DVec2) -> (DVec2, f64) {
    let reach = |atom: &&Atom| turn.rotate(atom.offset()).dot(direction) + atom.radius();
    let atom = molecule
        .atoms()
        .iter()
        .max_by(|a, b| reach(a).total_cmp(&reach(b)));
    let atom = atom.expect("a molecule has an atom");
    (turn.rotate(atom.offset()), atom.radius())
}

/// A pair whose two outermost atoms along a line have, at some time, the gap −`depth` sizes with g'
/// = 0 < g''.
pub(super) fn planted(draw: &mut Draw, molecules: [Molecule; 2], depth: f64) -> Encounter {
    let [a, b] = &molecules;
    let normal = draw.direction();
    let then = [draw.orientation(), draw.orientation()];
    let spins = [draw.between(-1.0, 1.0), draw.between(-1.0, 1.0)];
    let (arm_a, radius_a) = outermost(a, then[0].cos_sin(), normal);
    let (arm_b, radius_b) = outermost(b, then[1].cos_sin(), -normal);
    let contact_distance = radius_a + radius_b;
    // g'' = n·d'' + slip²/s; K bounds the first term.
    let curvature = spins[0] * spins[0] * arm_a.length() + spins[1] * spins[1] * arm_b.length();
    let slip = draw.sign() * ((2.0 * contact_distance * curvature).sqrt() + draw.between(0.5, 2.0));
    let turning = spins[1] * arm_b.perp() - spins[0] * arm_a.perp();
    let velocity = slip * normal.perp() - turning;
    let time = draw.between(0.2, 2.0) * size(&molecules) / velocity.length();
    let d = (contact_distance - depth * size(&molecules)) * normal;
    let before =
        |body: usize| Orientation::from_turns(then[body].turns() - spins[body] * time / TAU);
    let motion = RelativeMotion {
        orientation: [before(0), before(1)],
        angular_velocity: spins,
        ..RelativeMotion::exactly(d - (arm_b - arm_a) - velocity * time, velocity)
    };
    Encounter::until_parted(molecules, motion, 2.0 * time)
}
