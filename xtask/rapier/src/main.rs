//! Runs a gas in a closed box with rapier: the scene is read from standard input, the results are
//! written to standard output.
//!
//! Restitution 1, no friction, no damping, no gravity, no sleep, continuous collision detection:
//! the settings for elastic molecules. All other parameters are rapier's defaults, except the unit
//! of length, which is the size of a molecule.

use std::{
    io::{stdin, stdout},
    sync::mpsc::channel,
};

use anyhow::Result;
use cpu_time::ThreadTime;
use rapier2d_f64::prelude::*;
use serde::{Deserialize, Serialize};

/// The requested runs.
#[derive(Deserialize)]
struct Scene {
    /// Sides of the box (length); walls are at 0 and at the sides.
    sides: [f64; 2],
    bodies: Vec<Body>,
    /// Duration (time).
    duration: f64,
    /// Time steps, one run for each.
    steps: Vec<f64>,
    /// Processor time after which a run ends early (seconds).
    most_seconds: f64,
}

/// A molecule in its initial state.
#[derive(Deserialize)]
struct Body {
    atoms: Vec<Atom>,
    at: [f64; 2],
    turns: f64,
    velocity: [f64; 2],
    angular_velocity: f64,
    fixed: bool,
}

/// A disc of a molecule, with its position relative to the centre of mass.
#[derive(Deserialize)]
struct Atom {
    at: [f64; 2],
    radius: f64,
    mass: f64,
}

/// Results of one run.
#[derive(Serialize)]
struct Seen {
    step: f64,
    /// Actual duration (time).
    duration: f64,
    /// Processor time (seconds), without the overlap checks.
    seconds: f64,
    /// Contacts that began between two molecules, or a molecule and a wall.
    collisions: u64,
    /// Relative change of the kinetic energy.
    energy_change: f64,
    /// Largest number of overlapping pairs of molecules in any check, and the deepest overlap
    /// (smaller diameters).
    overlapping: usize,
    deepest: f64,
    /// Number of molecules that ended outside the box.
    escaped: usize,
}

/// Number of overlap checks in a run.
const LOOKS: u32 = 10;

/// Shallower overlaps are rounding errors (smaller diameters).
const SHALLOWEST: f64 = 1e-12;

fn main() -> Result<()> {
    let scene: Scene = serde_json::from_reader(stdin())?;
    let seen: Vec<Seen> = scene.steps.iter().map(|&step| run(&scene, step)).collect();
    serde_json::to_writer(stdout(), &seen)?;
    Ok(())
}

fn run(scene: &Scene, step: f64) -> Seen {
    let (mut world, bodies) = build(scene, step);
    let start = energy(&world, &bodies);
    let (sender, contacts) = channel();
    let events = ChannelEventCollector::new(sender, channel().0, channel().0);
    let steps = (scene.duration / step).round().max(f64::from(LOOKS)) as u64;
    let (mut seconds, mut done, mut collisions) = (0.0, 0, 0);
    let (mut overlapping, mut deepest) = (0, 0.0f64);
    for look in 1..=u64::from(LOOKS) {
        let clock = ThreadTime::now();
        while done < steps * look / u64::from(LOOKS) {
            world.step_with_events(&(), &events);
            done += 1;
            if seconds + clock.elapsed().as_secs_f64() > scene.most_seconds {
                break;
            }
        }
        seconds += clock.elapsed().as_secs_f64();
        collisions += contacts.try_iter().filter(|event| event.started()).count() as u64;
        let (pairs, depth) = overlaps(scene, &world, &bodies);
        (overlapping, deepest) = (overlapping.max(pairs), deepest.max(depth));
        if seconds > scene.most_seconds {
            break;
        }
    }
    let outside = |place: f64, side: f64| !(0.0..=side).contains(&place);
    let escaped = bodies.iter().filter(|&&body| {
        let at = world.bodies[body].translation();
        outside(at.x, scene.sides[0]) || outside(at.y, scene.sides[1])
    });
    Seen {
        step,
        duration: step * done as f64,
        seconds,
        collisions,
        energy_change: energy(&world, &bodies) / start - 1.0,
        overlapping,
        deepest,
        escaped: escaped.count(),
    }
}

/// The molecules, and four walls as thick as the width of the box.
fn build(scene: &Scene, step: f64) -> (PhysicsWorld, Vec<RigidBodyHandle>) {
    let mut world = PhysicsWorld::default();
    world.gravity = Vector::ZERO;
    world.integration_parameters.dt = step;
    let radius = |body: &Body| body.atoms.iter().map(|atom| atom.radius).fold(0.0, f64::max);
    let largest = scene.bodies.iter().filter(|body| !body.fixed).map(radius).fold(0.0, f64::max);
    world.integration_parameters.length_unit = 2.0 * largest;
    let elastic = |collider: ColliderBuilder| {
        collider.restitution(1.0).friction(0.0).active_events(ActiveEvents::COLLISION_EVENTS)
    };
    let insert = |world: &mut PhysicsWorld, body: &Body| {
        let builder = if body.fixed { RigidBodyBuilder::fixed() } else { RigidBodyBuilder::dynamic() };
        let builder = builder
            .translation(Vector::new(body.at[0], body.at[1]))
            .rotation(body.turns * std::f64::consts::TAU)
            .linvel(Vector::new(body.velocity[0], body.velocity[1]))
            .angvel(body.angular_velocity)
            .can_sleep(false)
            .ccd_enabled(true);
        let handle = world.insert_body(builder);
        for atom in &body.atoms {
            let ball = ColliderBuilder::ball(atom.radius).translation(Vector::new(atom.at[0], atom.at[1]));
            world.insert_collider(elastic(ball).mass(atom.mass), Some(handle));
        }
        handle
    };
    let bodies: Vec<RigidBodyHandle> = scene.bodies.iter().map(|body| insert(&mut world, body)).collect();
    let [width, height] = scene.sides;
    let walls = [
        [-0.5 * width, 0.5 * height],
        [1.5 * width, 0.5 * height],
        [0.5 * width, -0.5 * height],
        [0.5 * width, 1.5 * height],
    ];
    for (index, at) in walls.into_iter().enumerate() {
        let half = if index < 2 { [0.5 * width, 1.5 * height] } else { [1.5 * width, 0.5 * height] };
        let wall = ColliderBuilder::cuboid(half[0], half[1]).translation(Vector::new(at[0], at[1]));
        world.insert_collider(elastic(wall), None);
    }
    // Masses of colliders reach their bodies in a step, but energies are needed before the first.
    for &body in &bodies {
        let PhysicsWorld { bodies, colliders, .. } = &mut world;
        bodies[body].recompute_mass_properties_from_colliders(colliders);
    }
    (world, bodies)
}

fn energy(world: &PhysicsWorld, bodies: &[RigidBodyHandle]) -> f64 {
    bodies
        .iter()
        .map(|&body| &world.bodies[body])
        .filter(|body| body.is_dynamic())
        .map(RigidBody::kinetic_energy)
        .sum()
}

/// Overlapping pairs of molecules, and the deepest overlap of two atoms (smaller diameters).
fn overlaps(scene: &Scene, world: &PhysicsWorld, bodies: &[RigidBodyHandle]) -> (usize, f64) {
    let atoms: Vec<Vec<(Vector, f64)>> = bodies
        .iter()
        .zip(&scene.bodies)
        .map(|(&handle, body)| {
            let pose = *world.bodies[handle].position();
            let place =
                |atom: &Atom| (pose.transform_point(Vector::new(atom.at[0], atom.at[1])), atom.radius);
            body.atoms.iter().map(place).collect()
        })
        .collect();
    let (mut pairs, mut deepest) = (0, 0.0f64);
    for (index, one) in atoms.iter().enumerate() {
        for other in &atoms[..index] {
            let depths = one.iter().flat_map(|(a, r)| {
                other.iter().map(move |(b, s)| (r + s - (*a - *b).length()) / (2.0 * r.min(*s)))
            });
            let depth = depths.fold(0.0, f64::max);
            pairs += usize::from(depth > SHALLOWEST);
            deepest = deepest.max(depth);
        }
    }
    (pairs, deepest)
}
