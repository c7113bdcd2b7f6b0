//! A least speed of separation and outward rounding of positions: they keep touching bodies from
//! sinking into each other.
//!
//! A contact and its outcome are computed to rounding. Three causes could let a pair sink, contact
//! after contact:
//!
//! 1. *Closing speeds of rounding size.* At elasticity 0, and where two bodies approach as slowly
//!    as velocities are rounded, the surfaces may still close after the contact by a rounding,
//!    which no detector can distinguish from rest. So a contact that loses energy, or that follows
//!    another at the same instant, ends with the surfaces separating at [`MIN_SEPARATION`] times
//!    the speed that detection resolves, E'. Elastic contacts separate as fast as they approach,
//!    which is already faster than E'. Two discs need only separate by more than the rounding of
//!    velocities, since separating straight flights do not meet again.
//! 2. *Steps of a search that fall by E.* Excluded by Lemma 9 of `carom_detection`
//!    (`gap_search.rs`), given 1.
//! 3. *Rounding of positions.* Each contact rounds two positions to the nearest float, inwards or
//!    outwards. A pair with 10⁵ contacts within a short time would do a random walk of 300
//!    roundings. So the positions of bodies that overlap by more than two roundings of the side at
//!    a contact are rounded away from each other, by at most the overlap and at most four
//!    roundings.
//!
//! A body that overlaps an arc is moved along its path instead of along the normal. Every move
//! along the normal would bring a disc in a circle nearer to the centre, and so lower its angular
//! momentum L about the centre: relative to L by 10⁻¹⁷ to 10⁻¹⁶ a contact, of one sign, where the
//! epoch is as long as that of a single moving body. A move along the path leaves L as it is, and
//! corrects the rounding of the time of the contact, from which these overlaps come. The normal
//! remains for paths nearly along the arc ([`MIN_PARTING`]): there the rounding of the time gives
//! no such overlap.
//!
//! With these measures, the depth of a pair is at most 5/4 E plus the roundings of one contact, at
//! any elasticity and for any number of contacts. Positions change by rounding only, after the
//! observers have received the contact.
//!
//! **Energy of measure 1.** Between atoms whose radii add up to s, E' is about 2 L E/s, with the
//! speed L = |V| + |ω_A| R_A + |ω_B| R_B of the surfaces. The least speed of separation is
//! therefore
//! a share 8 E/s of L, and the kinetic energy that it adds at most the square of that share, which
//! the ledger counts: 10⁻²¹ for atoms of 0.002 of the side, 10⁻¹³ for 10⁻⁷ of the side.
//! [`MAX_SEPARATION`] bounds the share. Where 8 E/s is larger, a scene whose contacts change
//! energy
//! is refused ([`refuse_unresolved`]), and other contacts separate at `MAX_SEPARATION` times L.

use std::collections::BTreeMap;

use carom_detection::{Detection, TetherBound, resolved_speed};
use carom_kinematics::{Inertia, Motion, RelativeMotion};
use carom_response::{ContactFrame, approach_speed, reduced_mass};
use glam::DVec2;

use crate::{
    contact::{elasticity_table::ElasticityTable, separation_error::separation_error},
    scene::error::GridError,
    world::{
        World,
        body::Body,
        contact_event::{ContactEvent, TouchingParts},
    },
};

/// Least speed of separation of surfaces, in units of the speed that detection resolves. Smaller
/// than 2: detection may not see that a pair separates. Larger: energy is put into contacts at
/// elasticity 0.
const MIN_SEPARATION: f64 = 4.0;

/// Largest least speed of separation, as a share of the speed L of the surfaces, apart from the
/// rounding of velocities. Smaller: more scenes with small atoms are refused. Larger: at elasticity
/// 0 the surfaces separate visibly.
const MAX_SEPARATION: f64 = 1e-3;

/// E of a contact in units of the rounding of separations: that itself, and 5/16 of it for the
/// distance of the centres, since both are proportional to the sides; rounded up for arms and
/// orientations.
const ERROR_OF_GAP: f64 = 2.0;

/// Overlaps at a contact up to this many roundings of the side are not corrected; most are not
/// deeper.
const TOLERATED: f64 = 2.0;

/// Largest correction of the positions of two bodies, in roundings of the side.
const MAX_OUTWARDS: f64 = 4.0;

/// Least speed at which a body parts from an arc, as a share of its whole speed, for a correction
/// along its path. Larger: overlaps by the rounding of the time, at most 4 roundings of the side
/// along a path of eight sides, are corrected along the normal. Smaller: bodies move farther by a
/// correction, which is up to `MAX_OUTWARDS / MIN_PARTING` roundings of the side.
const MIN_PARTING: f64 = 0.25;

/// The additional impulse on B (mass × length / time) with which the surfaces separate fast enough
/// to be resolved. `None` if they already do, or if the response leaves them closing at a resolved
/// speed. `separation_error` is that of the epoch (length).
#[inline(never)]
pub(crate) fn missing_impulse(
    world: &World,
    separation_error: f64,
    frame: &ContactFrame,
    (parts, bodies): (TouchingParts, [&Body; 2]),
    before: [&Motion; 2],
    after: [&Motion; 2],
) -> Option<DVec2> {
    let time = before[0].time;
    let mut relative = RelativeMotion::between(before[0], before[1], DVec2::ZERO, time);
    let least = if parts == TouchingParts::Discs {
        // Discs fly straight: once separating they do not meet again, for any rounding of their
        // positions.
        least_speed_of_discs(relative.velocity_error)
    } else {
        // The scheduler may use another image or store positions with a larger error; this bounds
        // all cases.
        relative.separation_error = relative.separation_error.max(separation_error);
        let resolved = match (parts, parts.touch()) {
            (TouchingParts::Bond(bond, bound), _) => {
                let tether = &world.bonds()[bond as usize].tether;
                relative.separation += world.nearest_shift(before);
                tether.resolved_speed(bound, &relative)
            }
            (_, Some(touch)) => {
                let [a, b] = bodies.map(|body| body.kind.molecule.outline());
                resolved_speed(a, b, &relative, touch, frame.normal())
            }
            (_, None) => 0.0,
        };
        let arm = |n: usize| match parts {
            TouchingParts::Bond(bond, _) => {
                world.bonds()[bond as usize].tether.points()[n].length()
            }
            _ => bodies[n].kind.molecule.bounding_radius(),
        };
        let rim = |n: usize| before[n].angular_velocity.abs() * arm(n);
        let speed = relative.velocity.length() + (rim(0) + rim(1));
        let most = MAX_SEPARATION * speed + MIN_SEPARATION * relative.velocity_error;
        (MIN_SEPARATION * resolved).min(most)
    };
    let approach = approach_speed(frame, after);
    let mass = reduced_mass(frame, bodies.map(|body| &body.kind.inertia));
    // Surfaces that still close faster do so because of the response, which is not overridden.
    (approach.abs() < least).then(|| (least + approach) * mass * frame.normal())
}

/// The least speed with which two discs separate, for this bound on the rounding of their relative
/// velocity (both length per time): once separating they do not meet again.
#[inline]
pub(crate) fn least_speed_of_discs(velocity_error: f64) -> f64 {
    2.0 * velocity_error
}

/// The least speed with which two discs bounce back from a step of their well (length per time):
/// above the speed that the search resolves.
pub(crate) fn least_speed_at_step(
    world: &World,
    contact: &ContactEvent,
    bound: TetherBound,
    before: &[Motion; 2],
) -> f64 {
    let shift = world.shift_of(contact);
    let relative = RelativeMotion::between(&before[0], &before[1], shift, contact.time);
    match world.shell_as_tether(contact.bodies) {
        Some(tether) => MIN_SEPARATION * tether.resolved_speed(bound, &relative),
        // Separating straight flights do not meet again.
        None => 2.0 * relative.velocity_error,
    }
}

/// Refuses bodies whose contacts change energy and whose atoms are so small that the speed which
/// detection resolves exceeds [`MAX_SEPARATION`] of that of the surfaces. Pairs of discs separate
/// in straight lines and need no least speed; neither do faces of walls, whose normal is known.
///
/// # Errors
/// [`GridError::UnresolvedElasticity`].
pub(crate) fn refuse_unresolved(world: &World, table: &ElasticityTable) -> Result<(), GridError> {
    if table.is_elastic() {
        return Ok(());
    }
    let is_arc = |body: &Body| body.is_wall() && body.molecule().outline().has_curves();
    let arc = world.bodies.iter().position(is_arc);
    if let Some(arc) = arc.filter(|_| table.loses_energy() && table.guard.contact_time == 0.0) {
        return Err(GridError::UnguardedArc(arc));
    }
    let least = 2.0 * MIN_SEPARATION * ERROR_OF_GAP * separation_error(world) / MAX_SEPARATION;
    let groups = smallest_of_groups(world, table);
    for (n, (kind, smallest)) in groups.iter().enumerate() {
        for (other_kind, other_smallest) in &groups[n..] {
            let may_touch = kind.moves || other_kind.moves;
            if !may_touch || (kind.is_disc && other_kind.is_disc) {
                continue;
            }
            // Within one group the second smallest is another body.
            let second = if kind == other_kind {
                other_smallest.get(1)
            } else {
                other_smallest.first()
            };
            let (Some(&(radius, one)), Some(&(other_radius, other))) = (smallest.first(), second)
            else {
                continue;
            };
            let coefficient = table.least_coefficient(&world.bodies[one], &world.bodies[other]);
            let reach = radius + other_radius;
            if coefficient != 1.0 && reach < least {
                let bodies = [one, other];
                return Err(GridError::UnresolvedElasticity {
                    reach,
                    least,
                    coefficient,
                    bodies,
                });
            }
        }
    }
    Ok(())
}

/// Refuses ellipses, arcs and walls that turn where the detector does not search them, and bodies
/// that no detector searches against the arcs and the turning walls of the world.
///
/// # Errors
/// [`GridError::Curve`], [`GridError::BesideArc`], [`GridError::MovingWallAndArc`],
/// [`GridError::OscillatingWall`], [`GridError::Falling`], [`GridError::TurningWall`] or
/// [`GridError::TurningWallAndEllipse`].
pub(crate) fn refuse_unsearched<D: Detection>(
    world: &World,
    detection: &D,
) -> Result<(), GridError> {
    let position = |is_such: &dyn Fn(&Body) -> bool| world.bodies.iter().position(is_such);
    let curved = position(&|body| body.molecule().outline().has_curves());
    if let Some(body) = curved.filter(|_| !detection.searches_curves()) {
        return Err(GridError::Curve(body));
    }
    let bend = |body: &Body| {
        body.molecule()
            .wall_edge()
            .and_then(|edge| edge.bend().copied())
    };
    let has_open_arcs = world
        .bodies
        .iter()
        .any(|body| bend(body).is_some_and(|bend| !bend.is_one_sided()));
    let has_arcs = position(&|body| bend(body).is_some()).is_some();
    let has_sides = |body: &Body| !body.is_wall() && !body.molecule().edges().is_empty();
    let unsearched =
        position(&|body| has_arcs && body.has_ellipses() || has_open_arcs && has_sides(body));
    if let Some(body) = unsearched {
        return Err(GridError::BesideArc(body));
    }
    let moving = world.moving_walls().next();
    if let Some(wall) = moving.filter(|_| has_arcs) {
        return Err(GridError::MovingWallAndArc(wall));
    }
    if world.is_driven() && !detection.searches_driven_bodies() {
        let oscillates = |&wall: &usize| world.oscillation(wall).is_some();
        let wall = world.moving_walls().find(oscillates);
        return Err(wall.map_or(GridError::Falling, GridError::OscillatingWall));
    }
    let turns = |&wall: &usize| world.motions[wall].angular_velocity != 0.0;
    let Some(wall) = world.moving_walls().find(turns) else {
        return Ok(());
    };
    match position(&Body::has_ellipses) {
        _ if !detection.searches_turning_walls() => Err(GridError::TurningWall(wall)),
        Some(ellipse) => Err(GridError::TurningWallAndEllipse([wall, ellipse])),
        None => Ok(()),
    }
}

/// Properties that bodies of one group share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Group {
    class: u32,
    moves: bool,
    is_disc: bool,
}

/// The two bodies with the smallest radii of curvature of each group (length), and their indices.
fn smallest_of_groups(world: &World, table: &ElasticityTable) -> Vec<(Group, Vec<(f64, usize)>)> {
    let mut groups: BTreeMap<Group, Vec<(f64, usize)>> = BTreeMap::new();
    for (index, body) in world.bodies.iter().enumerate() {
        let is_disc = !body.is_wall() && body.kind.molecule.is_disc();
        let group = Group {
            class: table.class_of(body),
            moves: !body.is_fixed(),
            is_disc,
        };
        let smallest = groups.entry(group).or_default();
        let radius = body.sharpest_curvature();
        let place = smallest.partition_point(|&(other, _)| other <= radius);
        if place < 2 {
            smallest.insert(place, (radius, index));
            smallest.truncate(2);
        }
    }
    groups.into_iter().collect()
}

/// Whether an overlap at a contact is so deep (length) that positions are rounded outwards.
#[inline]
pub(crate) fn is_deep(world: &World, depth: f64) -> bool {
    depth > TOLERATED * position_rounding(world)
}

/// The rounding of a position at the far side of the box (length).
#[inline]
fn position_rounding(world: &World) -> f64 {
    f64::EPSILON * world.bounds.sides().max_element()
}

/// Rounds the positions of two bodies that overlap by `depth` (length) away from each other, if
/// their surfaces separate. Pairs that still close after their contact reach the limit on contacts
/// at one instant instead.
pub(crate) fn round_outwards(
    world: &World,
    contact: &ContactEvent,
    depth: f64,
    frame: &ContactFrame,
    inertias: [&Inertia; 2],
    motions: &mut [Motion; 2],
) {
    if is_deep(world, depth) && approach_speed(frame, [&motions[0], &motions[1]]) < 0.0 {
        let [a, b] = inertias.map(|inertia| inertia.inverse_mass);
        let outwards = depth.min(MAX_OUTWARDS * position_rounding(world));
        let normal = frame.normal();
        if let Some(arc) = touched_arc(world, contact) {
            let away = if arc == 0 { normal } else { -normal };
            let moving = &mut motions[1 - arc];
            moving.position += shift_from_arc(moving.velocity, away, outwards);
            return;
        }
        let apart = outwards * normal;
        motions[0].position -= a / (a + b) * apart;
        motions[1].position += b / (a + b) * apart;
    }
}

/// Which of the two bodies of a contact is an arc, touched between its ends; `None` if neither is.
/// Arcs are fixed.
fn touched_arc(world: &World, contact: &ContactEvent) -> Option<usize> {
    let edges = contact.parts.edges();
    (0..2).find(|&side| {
        let molecule = world.bodies[contact.bodies[side] as usize].molecule();
        edges[side].is_some()
            && molecule
                .wall_edge()
                .is_some_and(|edge| edge.bend().is_some())
    })
}

/// The displacement of a body by which its distance from an arc grows by `outwards` (length), to
/// first order: along its path, or along the normal if the path is nearly along the arc. `away` is
/// the unit normal from the arc to the body.
fn shift_from_arc(velocity: DVec2, away: DVec2, outwards: f64) -> DVec2 {
    let parting = velocity.dot(away);
    if parting >= MIN_PARTING * velocity.length() && parting > 0.0 {
        (outwards / parting) * velocity
    } else {
        outwards * away
    }
}
