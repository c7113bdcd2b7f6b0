//! Pistons of a scene: walls at rest while the gases are placed, which get their masses afterwards.

use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE, check_length, gap_between};
use carom_kinematics::{Drive, Motion};
use glam::DVec2;

use crate::{
    contact::limits::refuse_slow,
    scene::{Scene, error::SceneError, piston_spec::PistonSpec},
    world::{
        World,
        body::Body,
        pistons::{Piston, is_force},
        rounding_bound::rounding_bound,
        wall::StandingWall,
        wall_table::WallTable,
    },
};

/// Room left between a piston at its stop and the wall that is its default, in sides of the box:
/// more than all rounding.
const ROOM: f64 = 1e-9;

/// The farthest place at which a spring may balance, in sides of the box. Larger: it acts as a
/// constant force, but searches are bounded by the speed of its whole swing.
const MAX_STRETCH: f64 = 100.0;

/// Gives the pistons of a scene their masses, velocities and stops. `entries` are the entries of
/// the first bodies of the world.
pub(crate) fn free_pistons(
    world: &mut World,
    scene: &Scene,
    entries: &[String],
) -> Result<(), SceneError> {
    let is_piston = |entry: &String| entry.starts_with("piston[");
    let Some(first) = entries.iter().position(is_piston) else {
        return Ok(());
    };
    for (spec, index) in scene.piston.iter().zip(first..) {
        free_piston(world, spec, index, &entries[index])?;
    }
    Ok(())
}

/// Gives a wall at rest across the box (index in the order of the bodies) the mass, velocity and
/// stops of a piston.
fn free_piston(
    world: &mut World,
    spec: &PistonSpec,
    index: usize,
    entry: &str,
) -> Result<(), SceneError> {
    check_numbers(entry, spec)?;
    let Some(axis) = world.bodies[index].axis_across() else {
        let problem = "a piston must be a wall across the box";
        return Err(SceneError::of_entry(entry, problem));
    };
    check_mass(entry, spec.mass)?;
    let place = world.motions[index].position[axis];
    let stops = spec.stops.or_else(|| default_stops(world, index, axis));
    let stops = stops.ok_or_else(|| {
        SceneError::of_entry(
            entry,
            "a piston needs `stops` where no other wall across the box is parallel to it",
        )
    })?;
    let piston = Piston {
        key: world.bodies[index].key(),
        mass: spec.mass,
        force: spec.force,
        stops,
        stiffness: spec.spring,
        relaxed_at: spec.relaxed_at.unwrap_or(place),
        stop_elasticity: spec.stop_elasticity,
        last_stop: None,
        swing: Drive::default(),
    };
    check_stop_elasticity(entry, spec.stop_elasticity)?;
    check_spring(entry, spec)?;
    check_force(entry, spec.force, spec.mass)?;
    check_stops(entry, &piston, place, world.bounds.sides()[axis])?;
    let motion = Motion {
        velocity: DVec2::AXES[axis] * spec.velocity,
        ..world.motions[index]
    };
    refuse_slow(entry, &motion, 0.0)?;
    world.motions[index] = motion;
    world.free_piston(index, piston);
    Ok(())
}

/// Refuses lengths and speeds that are out of range.
fn check_numbers(entry: &str, spec: &PistonSpec) -> Result<(), SceneError> {
    let numbers = spec.stops.into_iter().flatten();
    for number in numbers
        .chain([spec.velocity, spec.force])
        .chain(spec.relaxed_at)
    {
        check_length("a number of a piston", number).map_err(|reason| SceneError::Geometry {
            entry: entry.to_owned(),
            reason,
        })?;
    }
    Ok(())
}

fn check_mass(entry: &str, mass: f64) -> Result<(), SceneError> {
    if (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(&mass) {
        return Ok(());
    }
    let problem =
        format!("`mass` must be from {MIN_MAGNITUDE:e} to {MAX_MAGNITUDE:e}, but is {mass:e}");
    Err(SceneError::of_entry(entry, problem))
}

/// Refuses stops out of a box of this side, or that do not enclose the place of the piston
/// (length).
fn check_stops(entry: &str, piston: &Piston, place: f64, side: f64) -> Result<(), SceneError> {
    let [low, high] = piston.stops;
    let problem = if !piston.is_valid(side) {
        format!(
            "`stops` must ascend between 0 and the side of the box, {side:e}, but are {low:e} and {high:e}"
        )
    } else if (low..=high).contains(&place) {
        return Ok(());
    } else {
        format!("a piston must begin between its stops, {low:e} and {high:e}, but is at {place:e}")
    };
    Err(SceneError::of_entry(entry, problem))
}

/// A force on a piston of this mass that is in its range. `entry` names the piston in errors.
///
/// # Errors
/// [`SceneError::Entry`] if it is not.
pub(crate) fn check_force(entry: &str, force: f64, mass: f64) -> Result<f64, SceneError> {
    if is_force(force, mass) {
        return Ok(force + 0.0);
    }
    Err(SceneError::of_entry(
        entry,
        format!(
            "the acceleration of a piston by its `force` must be 0 or from {MIN_MAGNITUDE:e} to {MAX_MAGNITUDE:e}, but \
             the force is {force:e}, and the mass {mass:e}"
        ),
    ))
}

/// Refuses an elasticity of the stops that is out of range.
fn check_stop_elasticity(entry: &str, elasticity: f64) -> Result<(), SceneError> {
    if (0.0..=1.0).contains(&elasticity) {
        return Ok(());
    }
    let problem = format!("`stop_elasticity` must be from 0 to 1, but is {elasticity}");
    Err(SceneError::of_entry(entry, problem))
}

/// Refuses a spring that pushes, or whose square of the angular frequency is out of range.
fn check_spring(entry: &str, spec: &PistonSpec) -> Result<(), SceneError> {
    if spec.spring == 0.0 && spec.relaxed_at.is_some() {
        let problem = "`relaxed_at` is the place of a spring: give `spring`, too";
        return Err(SceneError::of_entry(entry, problem));
    }
    if spec.spring >= 0.0 && is_force(spec.spring, spec.mass) {
        return Ok(());
    }
    Err(SceneError::of_entry(
        entry,
        format!(
            "`spring` over `mass` must be 0 or from {MIN_MAGNITUDE:e} to {MAX_MAGNITUDE:e}, but the spring is {:e}, and \
             the mass {:e}",
            spec.spring, spec.mass
        ),
    ))
}

/// The places at which a piston would touch the nearest parallel walls on its two sides, less some
/// room; `None` without any.
fn default_stops(world: &World, index: usize, axis: usize) -> Option<[f64; 2]> {
    let (body, place) = (&world.bodies[index], world.motions[index].position[axis]);
    let side = world.bounds.sides()[axis];
    let walls = world.bodies.iter().zip(&world.motions).enumerate();
    let parallel = walls.filter(|&(other, (wall, _))| {
        other != index && wall.is_fixed() && wall.axis_across() == Some(axis)
    });
    let mut stops = [f64::NEG_INFINITY, f64::INFINITY];
    for (_, (wall, motion)) in parallel {
        let reach = body.reach() + wall.reach() + ROOM * side;
        for image in -1..=1 {
            let face = motion.position[axis] + f64::from(image) * side;
            if face <= place {
                stops[0] = stops[0].max(face + reach);
            } else {
                stops[1] = stops[1].min(face - reach);
            }
        }
    }
    stops.iter().all(|stop| stop.is_finite()).then_some(stops)
}

/// Refuses pistons that may meet another piston or a wall, that are rough, or that have a drag.
/// `name` is the name of a body in errors.
pub(crate) fn refuse_pistons(
    world: &World,
    name: impl Fn(usize) -> String,
) -> Result<(), SceneError> {
    for piston in world.pistons() {
        refuse_piston(world, piston).map_err(|text| SceneError::of_entry(&name(piston), text))?;
    }
    Ok(())
}

/// The reason why a piston cannot be run.
fn refuse_piston(world: &World, index: usize) -> Result<(), String> {
    let body = &world.bodies[index];
    let (Some(piston), Some(axis)) = (world.piston(index), body.axis_across()) else {
        return Err("a piston must be a wall across the box".to_owned());
    };
    if !world.clock.is_free() {
        return Err(
            "a piston and a drag cannot be in one system yet: set the drag to 0".to_owned(),
        );
    }
    if body.kind.has_rough_contacts {
        return Err(
            "a piston must be smooth: give its contacts `tangential` -1, or leave `tangential` out"
                .to_owned(),
        );
    }
    refuse_forces(world, index, piston, axis)?;
    (0..world.bodies.len()).try_for_each(|other| refuse_obstacle(world, index, piston, axis, other))
}

/// Refuses a piston that its forces press against a stop, or whose spring balances them far away.
fn refuse_forces(world: &World, index: usize, piston: &Piston, axis: usize) -> Result<(), String> {
    let motion = &world.motions[index];
    let (place, constant) = (motion.position[axis], world.acceleration(index)[axis]);
    let acceleration = piston.acceleration_at(place, constant);
    // The guard of stops that lose energy lets the piston leave.
    let is_elastic = piston.stop_elasticity == 1.0;
    if is_elastic && piston.rests_on_stop(place, motion.velocity[axis], acceleration) {
        return Err(
            "the piston is at rest on one of its stops and pressed against it: let it begin beside the stop, or with \
             a velocity"
                .to_owned(),
        );
    }
    if piston.stiffness > 0.0 {
        let balance = piston.balance(constant);
        let away = piston.stops.map(|stop| (balance - stop).abs());
        let most = MAX_STRETCH * world.bounds.sides()[axis];
        if away[0].max(away[1]) > most {
            return Err(format!(
                "its spring balances force and gravity at {balance:e}, farther than {most:e} from a stop (length): give \
                 a stiffer spring, or a `force` in its place"
            ));
        }
    }
    Ok(())
}

/// Refuses a body that a piston overlaps or may meet: a fixed body, a wall or another piston.
fn refuse_obstacle(
    world: &World,
    index: usize,
    piston: &Piston,
    axis: usize,
    other: usize,
) -> Result<(), String> {
    let (body, wall) = (&world.bodies[index], &world.bodies[other]);
    let is_seen = || world.pairs.sees(&body.kind.tags, &wall.kind.tags);
    if wall.is_fixed() && !wall.is_wall() && is_seen() && overlaps(world, index, other, axis) {
        return Err(format!("the piston overlaps fixed body {}", wall.id()));
    }
    if other == index || !wall.is_wall() {
        return Ok(());
    }
    let motion = &world.motions[other];
    let Some([from, to]) = range_of(world, other, wall, motion, axis) else {
        // A wall across the box along the axis of the piston: both cross everywhere.
        if world.piston(other).is_some() {
            return Err("all pistons of a system must move along the same axis".to_owned());
        }
        return Ok(());
    };
    let is_of_wall = |table: &WallTable| table.key == wall.key();
    let moves = wall.is_fixed()
        && (!motion.is_at_rest()
            || world.oscillation(other).is_some()
            || world.wall_tables.iter().any(is_of_wall));
    if moves {
        return Err(
            "a piston cannot be in one system with a wall that moves along its axis or has end points yet"
                .to_owned(),
        );
    }
    let [low, high] = [
        piston.stops[0] - body.reach(),
        piston.stops[1] + body.reach(),
    ];
    let side = world.bounds.sides()[axis];
    let is_entered = [-1.0, 0.0, 1.0]
        .map(|image| image * side)
        .iter()
        .any(|shift| from + shift < high && to + shift > low);
    if is_entered {
        return Err(format!(
            "the piston may meet a wall or another piston that lies from {from:e} to {to:e}, between its stops {:e} \
             and {:e}: choose other `stops`",
            piston.stops[0], piston.stops[1]
        ));
    }
    Ok(())
}

/// Whether a piston overlaps a fixed body that is no wall. Places along the piston do not count.
fn overlaps(world: &World, piston: usize, fixed: usize, axis: usize) -> bool {
    let [of_piston, of_body] = [piston, fixed].map(|body| &world.motions[body]);
    let side = world.bounds.sides()[axis];
    let between = of_body.position[axis] - of_piston.position[axis];
    let separation = DVec2::AXES[axis] * (between - side * (between / side).round());
    let [a, b] = [piston, fixed].map(|body| world.bodies[body].molecule());
    let rotations = [of_piston, of_body].map(|motion| motion.orientation.cos_sin());
    let reach = world.bodies[piston].reach() + world.bodies[fixed].reach();
    gap_between(a, rotations[0], b, rotations[1], separation)
        < -rounding_bound(world.bounds.sides(), reach)
}

/// The places of a wall along an axis (length), of another piston all that it can reach; `None` for
/// a wall across the box along this axis.
fn range_of(
    world: &World,
    index: usize,
    wall: &Body,
    motion: &Motion,
    axis: usize,
) -> Option<[f64; 2]> {
    let [low, high] = match (wall.axis_across(), world.piston(index)) {
        (Some(own), _) if own != axis => return None,
        (Some(_), Some(piston)) => piston.stops,
        (Some(_), None) => [motion.position[axis]; 2],
        (None, _) => StandingWall::new(wall, motion)?
            .extent()
            .map(|corner| corner[axis]),
    };
    let side = world.bounds.sides()[axis];
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low) + wall.reach());
    let middle = middle - side * (middle / side).floor();
    Some([middle - half, middle + half])
}
