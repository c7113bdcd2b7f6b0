//! Encounters that begin near a contact, at a contact, or with an overlap of rounding size.

use carom_geometry::{Molecule, Shape, gap_between};
use carom_kinematics::{Orientation, RelativeMotion};
use glam::DVec2;

use super::{
    Encounter,
    flights::thermal,
    random::Draw,
    shapes::{VALID, extended, named, ordinary},
    size,
};

/// Limit of random states until one meets the condition; at least one in twenty does.
const MAX_TRIES: u32 = 10_000;

/// The bounding circles overlap, the atoms do not.
pub(super) fn annulus(draw: &mut Draw) -> Encounter {
    for _ in 0..MAX_TRIES {
        let molecules = [extended(draw), extended(draw)];
        let speeds = thermal(draw, &molecules, 1.0);
        let separation = draw.between(0.3, 1.0) * size(&molecules) * draw.direction();
        let motion = RelativeMotion {
            orientation: [draw.orientation(), draw.orientation()],
            angular_velocity: speeds.spins,
            ..RelativeMotion::exactly(separation, speeds.velocity)
        };
        let encounter = Encounter::until_parted(molecules, motion, 1.0);
        if smallest_gap(&encounter) > 0.0 {
            return encounter;
        }
    }
    unreachable!("a tenth of all such pairs are apart")
}

fn smallest_gap(encounter: &Encounter) -> f64 {
    let [a, b] = &encounter.molecules;
    let [turn_a, turn_b] = encounter.motion.orientation.map(Orientation::cos_sin);
    gap_between(a, turn_a, b, turn_b, encounter.motion.separation)
}

/// A pair that touches and closes.
struct Touching {
    molecules: [Molecule; 2],
    motion: RelativeMotion,
    /// From the centres of mass to the centres of the touching atoms.
    arms: [DVec2; 2],
    /// Sum of the radii of the touching atoms.
    contact_distance: f64,
    normal: DVec2,
}

/// Two molecules in random orientations, moved together along a random direction u until they
/// touch.
///
/// Atoms with arms r_i, r_j and sum of radii σ touch where |s u + Δ| = σ, Δ = r_j − r_i; the larger
/// solution is s = −Δ·u + √(σ² − (Δ × u)²). The largest s of all pairs is the distance at which one
/// pair touches and all others are apart.
fn touching(draw: &mut Draw) -> Touching {
    for _ in 0..MAX_TRIES {
        if let Some(touching) = brought_together(draw) {
            return touching;
        }
    }
    unreachable!("most pairs cannot pass each other centre to centre")
}

fn brought_together(draw: &mut Draw) -> Option<Touching> {
    let molecules = [ordinary(draw), ordinary(draw)];
    let orientation = [draw.orientation(), draw.orientation()];
    let along = draw.direction();
    let [of_a, of_b] = [0, 1].map(|body: usize| {
        let turn = orientation[body].cos_sin();
        molecules[body]
            .atoms()
            .iter()
            .map(move |atom| (turn.rotate(atom.offset()), atom.radius()))
    });
    let (mut farthest, mut pair) = (f64::NEG_INFINITY, None);
    for (arm_a, radius_a) in of_a {
        for (arm_b, radius_b) in of_b.clone() {
            let (delta, sum) = (arm_b - arm_a, radius_a + radius_b);
            let across = delta.perp_dot(along);
            let distance = ((sum - across) * (sum + across)).sqrt() - delta.dot(along);
            // Pairs that pass each other give NaN.
            if distance > farthest {
                (farthest, pair) = (distance, Some(([arm_a, arm_b], sum)));
            }
        }
    }
    let (arms, contact_distance) = pair?;
    let separation = farthest * along;
    let normal = (separation + (arms[1] - arms[0])).normalize();
    let speeds = thermal(draw, &molecules, 1.0);
    let rate =
        speeds.velocity + (speeds.spins[1] * arms[1].perp() - speeds.spins[0] * arms[0].perp());
    // A pair that separates closes with reversed velocities.
    let direction = if rate.dot(normal) > 0.0 { -1.0 } else { 1.0 };
    let motion = RelativeMotion {
        orientation,
        angular_velocity: speeds.spins.map(|spin| direction * spin),
        ..RelativeMotion::exactly(separation, direction * speeds.velocity)
    };
    Some(Touching {
        molecules,
        motion,
        arms,
        contact_distance,
        normal,
    })
}

impl Touching {
    /// This state with other velocities.
    fn encounter(self, velocity: DVec2, angular_velocity: [f64; 2]) -> Encounter {
        let motion = RelativeMotion {
            velocity,
            angular_velocity,
            ..self.motion
        };
        Encounter::until_parted(self.molecules, motion, 1.0)
    }
}

pub(super) fn after_collision(draw: &mut Draw) -> Encounter {
    let touching = touching(draw);
    let speeds = thermal(draw, &touching.molecules, 1.0);
    touching.encounter(speeds.velocity, speeds.spins)
}

/// An elastic, smooth impulse: J = 2 μ u with 1/μ = Σ 1/m + (r × n)²/I and u = −n·d'.
pub(super) fn rebound(draw: &mut Draw) -> Encounter {
    let touching = touching(draw);
    let Touching {
        motion,
        arms,
        normal,
        ..
    } = touching;
    let [spin_a, spin_b] = motion.angular_velocity;
    let levers = arms.map(|arm| arm.perp_dot(normal));
    let [a, b] = &touching.molecules;
    let inverse_mass = 1.0 / a.mass() + 1.0 / b.mass();
    let inverse_moments = [1.0 / a.moment_of_inertia(), 1.0 / b.moment_of_inertia()];
    let reduced = 1.0
        / (inverse_mass
            + levers[0] * levers[0] * inverse_moments[0]
            + levers[1] * levers[1] * inverse_moments[1]);
    let rate = motion.velocity + (spin_b * arms[1].perp() - spin_a * arms[0].perp());
    let impulse = -2.0 * reduced * rate.dot(normal);
    let spins = [
        spin_a - impulse * levers[0] * inverse_moments[0],
        spin_b + impulse * levers[1] * inverse_moments[1],
    ];
    touching.encounter(motion.velocity + impulse * inverse_mass * normal, spins)
}

pub(super) fn overlap(draw: &mut Draw) -> Encounter {
    let mut touching = touching(draw);
    touching.motion.separation -=
        draw.between(0.0, 27e-16) * touching.contact_distance * touching.normal;
    let speeds = thermal(draw, &touching.molecules, 1.0);
    touching.encounter(speeds.velocity, speeds.spins)
}

/// A small disc in an inner corner of a turning molecule, at an arm that moves away and returns:
/// g'' = slip²/s − ω² n·r < 0, and 2 g'/|g''| is the time to the next contact.
pub(super) fn recontact(draw: &mut Draw, exponent: u8) -> Encounter {
    for _ in 0..MAX_TRIES {
        let shape = draw.one_of(&[Shape::Cross, Shape::Tee]);
        let rotor = named(draw, shape);
        let disc_radius = draw.between(0.05, 0.4) * rotor.atoms()[0].radius();
        let disc = Molecule::disc(disc_radius, 1.0).expect(VALID);
        let atom = draw.one_of(rotor.atoms());
        let orientation = draw.orientation();
        let arm = orientation.cos_sin().rotate(atom.offset());
        let normal = draw.direction();
        let inward = arm.dot(normal);
        if inward < 0.2 * arm.length() || arm.length() < 0.5 * atom.radius() {
            continue;
        }
        let contact_distance = disc_radius + atom.radius();
        let spin = draw.sign() * draw.between(0.5, 2.0);
        let slip =
            draw.sign() * draw.between(0.0, 0.7) * (contact_distance * spin * spin * inward).sqrt();
        let curvature = spin * spin * inward - slip * slip / contact_distance;
        let interval = 10f64.powi(-i32::from(exponent)) / spin.abs();
        let rate = 0.5 * curvature * interval * normal + slip * normal.perp();
        let motion = RelativeMotion {
            orientation: [Orientation::default(), orientation],
            angular_velocity: [0.0, spin],
            ..RelativeMotion::exactly(contact_distance * normal - arm, rate - spin * arm.perp())
        };
        let encounter = Encounter::until_parted([disc, rotor], motion, 1.0);
        // No other atom may touch already.
        if smallest_gap(&encounter) > -1e-15 * encounter.size()
            && others_apart(&encounter, contact_distance)
        {
            return if draw.happens(0.5) {
                encounter.exchanged()
            } else {
                encounter
            };
        }
    }
    unreachable!("one such pair in twenty is free")
}

/// Whether only one atom of B is within 10⁻³ of the contact distance of A, a disc.
fn others_apart(encounter: &Encounter, contact_distance: f64) -> bool {
    let [disc, rotor] = &encounter.molecules;
    let turn = encounter.motion.orientation[1].cos_sin();
    let near = rotor.atoms().iter().filter(|atom| {
        let d = encounter.motion.separation + turn.rotate(atom.offset());
        d.length() - (atom.radius() + disc.atoms()[0].radius()) < 1e-3 * contact_distance
    });
    near.count() == 1
}
