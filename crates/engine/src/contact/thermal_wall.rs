//! Contacts with walls that have a temperature: bodies leave them with random velocities.
//!
//! The random numbers of a contact depend on the seed, the replica, and the number of such contacts
//! before it in the whole run
//! ([`Counters::thermal_collisions`](crate::Counters::thermal_collisions)). Contacts are resolved
//! in order of time, so that these numbers are the same for all schedulers and after a resume.

use carom_kinematics::kinetic_energy;
use carom_response::{Elasticity, ThermalDraw, thermal_motion};
use glam::DVec2;

use crate::{
    contact::{
        contact_geometry::contact_geometry,
        resolution::{ContactPair, Resolved, Rules},
        separation::{missing_impulse, round_outwards},
    },
    scene::random::{RandomStream, normal_pair, rayleigh},
};

/// Random numbers reserved for each contact; it needs five.
const NUMBERS_PER_CONTACT: u128 = 8;

/// The outcome of a contact with a thermal wall, and the heat that the body has received (mass ×
/// length² / time²): the change of its energy less the work of a wall that moves. `None` if no body
/// of the contact is such a wall.
#[cold]
#[inline(never)]
pub(crate) fn resolve<R>(
    rules: &Rules<'_, R>,
    encounter: &ContactPair,
    number: u64,
) -> Option<(Resolved, f64)> {
    let (world, contact, before) = (rules.world, &encounter.contact, &encounter.before);
    let pair = contact.bodies.map(|body| &world.bodies[body as usize]);
    let wall = (0..2).find(|&body| pair[body].kind.temperature.is_some())?;
    let moving = 1 - wall;
    let (frame, depth) = contact_geometry(world, contact, before);
    let normal = frame.normal();
    let away = if wall == 0 { normal } else { -normal };
    let inertias = pair.map(|body| &body.kind.inertia);
    let draw = draw(world.random_key, number);
    let (old, inertia, arm) = (&before[moving], inertias[moving], frame.arms[moving]);
    let mut after = *before;
    // In the clock of a drag all velocities are larger by the same factor.
    let slowing = world.clock.slowing(contact.time);
    let temperature = pair[wall].kind.temperature? / (slowing * slowing);
    // The draw is in the frame of the surface.
    let surface = (!before[wall].is_at_rest())
        .then(|| before[wall].velocity_of(frame.arms[wall] + pair[wall].reach() * away));
    let can_turn = pair[moving].can_turn();
    after[moving] = thermal_motion(old, inertia, arm, away, temperature, &draw, can_turn);
    if let Some(surface) = surface {
        after[moving].velocity += surface;
    }
    // So slow a body, one among 10²⁰, gets the least speed of separation, like any other.
    if let Some(missing) = missing_impulse(
        world,
        rules.separation_error,
        &frame,
        (contact.parts, pair),
        before.each_ref(),
        after.each_ref(),
    ) {
        let on_body = if moving == 1 { missing } else { -missing };
        after[moving] = carom_response::apply_impulse(&after[moving], inertia, arm, on_body);
    }
    let change: DVec2 = (after[moving].velocity - old.velocity) / inertia.inverse_mass;
    let work = surface.map_or(0.0, |surface| change.dot(surface));
    let heat = kinetic_energy(&after[moving], inertia) - kinetic_energy(old, inertia) - work;
    let mut onwards = after;
    round_outwards(world, contact, depth, &frame, inertias, &mut onwards);
    let resolved = Resolved {
        frame,
        elasticity: Elasticity::ELASTIC,
        impulse: if moving == 1 { change } else { -change },
        after,
        onwards,
        spared: None,
        lost: None,
        work,
        met_fixed: true,
        is_unresolved: false,
        points: 1,
        is_rough: false,
    };
    Some((resolved, heat))
}

/// The random numbers of a contact.
fn draw([seed, replica]: [u64; 2], number: u64) -> ThermalDraw {
    let mut random = RandomStream::Walls.generator(seed, replica);
    random.advance(u128::from(number) * NUMBERS_PER_CONTACT);
    let (one, other) = (normal_pair(&mut random), normal_pair(&mut random));
    ThermalDraw {
        normal: [one.x, one.y, other.x],
        rayleigh: rayleigh(&mut random),
    }
}
