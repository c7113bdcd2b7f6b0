//! Random motions of walls, and gravity, of a size that suits the duration of a case.

use carom::engine::{Scene, WallMotionSpec, WallSpec};

use super::{
    table_path::MAX_PLACES,
    vectors::{BodyPair, along, length},
};
use crate::fuzz::random::FuzzDraw;

/// Largest phase that an oscillation passes in a case (radians): each epoch passes a few.
const MAX_PHASE: f64 = 4000.0;

/// A kind of motion of walls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionKind {
    /// At constant velocity.
    Uniform,
    /// Uniform rotation about a pivot, of a wall with end points; of other walls uniform motion.
    Turning,
    /// An oscillation.
    Oscillating,
    /// Through the places of a table.
    Table,
}

/// Gives walls of a scene motions of these kinds during a case of this duration (time).
///
/// The walls of some scenes have one motion, with which they never meet; those of others travel a
/// small part of the box, so that most do not meet.
pub fn move_walls(draw: &mut FuzzDraw, scene: &mut Scene, kinds: &[MotionKind], duration: f64) {
    let sides = scene.bounds.sides;
    if kinds.is_empty() {
        return;
    }
    let stands = scene.bumper.is_empty() && !scene.molecule.iter().any(|spec| spec.fixed);
    let is_alone = stands && scene.wall.len() == 1;
    let kind = draw.one_of(kinds);
    let turns = kinds.contains(&MotionKind::Turning);
    let has_common = !turns && draw.happens(0.3);
    let common = has_common.then(|| motion(draw, kind, sides, duration, !stands));
    for index in 0..scene.wall.len() {
        // A piston excludes walls that move along its axis, or that have end points.
        if !is_beside_pistons(scene, &scene.wall[index]) {
            continue;
        }
        // The last wall moves in any case; if some walls turn, it has end points and turns.
        let is_last = index + 1 == scene.wall.len();
        if !is_last && common.is_none() && draw.happens(0.4) {
            continue;
        }
        let motion = common.clone().unwrap_or_else(|| {
            let kind = if is_last && turns {
                MotionKind::Turning
            } else {
                draw.one_of(kinds)
            };
            let mut given = motion(draw, kind, sides, duration, !is_alone);
            if kind == MotionKind::Turning {
                turn(draw, &scene.wall[index], sides, duration, &mut given);
            }
            given
        });
        scene.wall[index].motion = Some(motion);
    }
}

/// Returns true if a wall may move beside the pistons of a scene: if there are none, or if it
/// lies across the box along their axis.
fn is_beside_pistons(scene: &Scene, wall: &WallSpec) -> bool {
    scene.piston.iter().all(|piston| match piston.x {
        Some(_) => wall.y.is_some(),
        None => wall.x.is_some(),
    })
}

/// A motion of a kind; in a box with other fixed bodies, `crowded`, one of a short way.
pub fn motion(
    draw: &mut FuzzDraw,
    kind: MotionKind,
    sides: BodyPair,
    duration: f64,
    crowded: bool,
) -> WallMotionSpec {
    let shorter = sides[0].min(sides[1]);
    let direction = match draw.index(4) {
        0 => [draw.sign(), 0.0],
        1 => [0.0, draw.sign()],
        _ => draw.direction().to_array(),
    };
    let speed = draw.scale(0.01, 3.0);
    let of_size = |size: f64| direction.map(|x| size * x);
    match kind {
        MotionKind::Uniform | MotionKind::Turning => {
            let way = draw.scale(0.01, 0.3) * shorter;
            let most = if crowded { way / duration } else { speed };
            WallMotionSpec {
                velocity: of_size(speed.min(most)),
                ..WallMotionSpec::default()
            }
        }
        MotionKind::Oscillating => {
            let most = if crowded { 0.1 } else { 0.9 };
            let amplitude = draw.scale(1e-4, most) * shorter;
            WallMotionSpec {
                amplitude: of_size(amplitude),
                frequency: (speed / amplitude).min(MAX_PHASE / duration),
                phase: draw.one_of(&[0.0, 1.0, 3.0, 8.0]) * draw.between(-1.0, 1.0),
                ..WallMotionSpec::default()
            }
        }
        MotionKind::Table => {
            let most = if crowded { 0.1 } else { 0.5 };
            let way = draw.scale(1e-3, most) * shorter;
            table(draw, of_size(way), speed.min(way / (0.01 * duration)))
        }
    }
}

/// A table of places along a way (length), which the wall passes at up to this speed; in some
/// pieces it is at rest.
fn table(draw: &mut FuzzDraw, way: BodyPair, speed: f64) -> WallMotionSpec {
    let count = draw.integer(2, MAX_PLACES as i64) as usize;
    let (mut times, mut places) = (vec![0.0], vec![[0.0; 2]]);
    for index in 1..count {
        let (time, place) = (times[index - 1], places[index - 1]);
        let returns = index + 1 == count && draw.happens(0.6);
        let next = match draw.index(5) {
            _ if returns => [0.0; 2],
            0 => place,
            _ => {
                let share = draw.between(-1.0, 1.0);
                way.map(|way| share * way)
            }
        };
        let lasts = length(along(next, -1.0, place)).max(0.1 * length(way)) / speed;
        times.push(time + draw.between(1.0, 3.0) * lasts);
        places.push(next);
    }
    WallMotionSpec {
        times,
        places,
        repeat: draw.happens(0.5),
        ..WallMotionSpec::default()
    }
}

/// Lets a wall with end points that is short enough turn, about its middle, an end or another point
/// nearby.
fn turn(
    draw: &mut FuzzDraw,
    wall: &WallSpec,
    sides: BodyPair,
    duration: f64,
    motion: &mut WallMotionSpec,
) {
    let (Some(from), Some(to)) = (wall.from, wall.to) else {
        return;
    };
    let span = along(to, -1.0, from);
    if length(span) >= sides[0].min(sides[1]) {
        return;
    }
    let turns = draw.scale(0.01, 3.0) / duration.min(1.0);
    motion.turn = draw.sign() * turns;
    motion.about = match draw.index(4) {
        0 | 1 => None,
        2 => Some(from),
        _ => Some([0, 1].map(|axis| from[axis] + draw.between(-0.2, 0.2) * sides[axis])),
    };
    if draw.happens(0.6) {
        motion.velocity = [0.0; 2];
    }
}

/// The acceleration by a gravity along one side of the box, or along none; rarely one that hardly
/// acts (length per time²).
pub fn gravity(draw: &mut FuzzDraw) -> BodyPair {
    let size = if draw.happens(0.1) {
        draw.scale(1e-9, 1e-2)
    } else {
        draw.scale(0.05, 20.0)
    };
    match draw.index(4) {
        0 => draw.direction().to_array().map(|x| size * x),
        1 => [draw.sign() * size, 0.0],
        _ => [0.0, -size],
    }
}

/// Multiplies lengths and speeds in a motion by powers of two.
pub fn scale_motion(motion: &mut WallMotionSpec, length: f64, speed: f64) {
    motion.velocity = motion.velocity.map(|v| v * speed);
    motion.turn *= speed / length;
    motion.about = motion.about.map(|at| at.map(|x| x * length));
    motion.amplitude = motion.amplitude.map(|a| a * length);
    motion.frequency *= speed / length;
    for time in &mut motion.times {
        *time *= length / speed;
    }
    for place in &mut motion.places {
        *place = place.map(|x| x * length);
    }
}
