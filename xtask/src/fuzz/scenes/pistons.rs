//! Random pistons, with room between their stops, forces that suit bodies of about unit mass, and
//! springs that suit the duration of a case.

use carom::engine::{PistonSpec, Scene};

use super::vectors::BodyPair;
use crate::fuzz::random::FuzzDraw;

/// Least distance of a stop from walls, other pistons and the border, in sides of the box.
const ROOM: f64 = 1e-3;

/// Least distance of two stops, in sides of the box.
const MIN_WAY: f64 = 0.02;

/// Share of the pistons that are on springs.
const SHARE_ON_SPRINGS: f64 = 0.35;

/// Largest distance of a piston from where its spring is relaxed, and of that place from the
/// balance, in sides of the box. The engine refuses balances at a hundred sides from a stop.
const MAX_AWAY: f64 = 30.0;

/// The place for a piston in a scene.
#[derive(Debug)]
pub struct PistonRoom<'a> {
    /// The axis along which it moves: 0 for x, 1 for y.
    pub axis: usize,
    /// Sides of the box (length).
    pub sides: BodyPair,
    /// The scene, with its walls and other pistons.
    pub scene: &'a Scene,
    /// The tags of the piston.
    pub tags: Vec<String>,
}

impl PistonRoom<'_> {
    /// A random piston; `None` if its place is taken.
    pub fn piston(&self, draw: &mut FuzzDraw) -> Option<PistonSpec> {
        let side = self.sides[self.axis];
        let radius = if draw.happens(0.5) {
            0.0
        } else {
            draw.scale(1e-4, 0.02)
        };
        let place = draw.between(0.0, side);
        if self.scene.piston.iter().any(|other| other.stops.is_none()) {
            return None;
        }
        let [low, high] = self.gap_about(place)?;
        let has_walls = low > 0.0 && high < side;
        let room = ROOM * side + radius;
        let [low, high] = [low + room, high - room];
        if !(low < place && place < high && high - low > MIN_WAY * side) {
            return None;
        }
        let is_given = !(has_walls && self.may_have_default_stops()) || draw.happens(0.5);
        let stops = is_given.then(|| {
            let share = draw.one_of(&[0.0, 1.0]) * draw.between(0.0, 1.0);
            [low + share * (place - low), high - share * (high - place)]
        });
        let mass = draw.scale(0.1, 100.0);
        let [x, y] = [0, 1].map(|axis| (axis == self.axis).then_some(place));
        Some(PistonSpec {
            tags: self.tags.clone(),
            x,
            y,
            radius,
            mass,
            velocity: if draw.happens(0.3) {
                0.0
            } else {
                draw.normal() / mass.sqrt()
            },
            force: if draw.happens(0.5) {
                0.0
            } else {
                force(draw, side)
            },
            stops,
            // Springs are added when the duration of the case is drawn.
            spring: 0.0,
            relaxed_at: None,
            stop_elasticity: if draw.happens(0.5) {
                1.0
            } else {
                draw.between(0.05, 1.0)
            },
        })
    }

    /// The gap between the walls and the ranges of the other pistons about a place, within the box
    /// (length); `None` if the place is taken.
    fn gap_about(&self, place: f64) -> Option<BodyPair> {
        let side = self.sides[self.axis];
        let mut gap = [0.0, side];
        for [low, high] in self.taken() {
            for image in -2..=2 {
                let shift = f64::from(image) * side;
                let [low, high] = [low + shift, high + shift];
                if high < place {
                    gap[0] = gap[0].max(high);
                } else if low > place {
                    gap[1] = gap[1].min(low);
                } else {
                    return None;
                }
            }
        }
        Some(gap)
    }

    /// The ranges along the axis of all walls but those across the box along it, and of pistons.
    fn taken(&self) -> Vec<BodyPair> {
        let axis = self.axis;
        let across = |x: Option<f64>, y: Option<f64>| [x, y][axis];
        let mut taken = Vec::new();
        for wall in &self.scene.wall {
            let radius = wall.radius;
            if let Some(place) = across(wall.x, wall.y) {
                taken.push([place - radius, place + radius]);
            } else if let (Some(from), Some(to)) = (wall.from, wall.to) {
                let [a, b] = [from[axis], to[axis]];
                taken.push([a.min(b) - radius, a.max(b) + radius]);
            }
        }
        for piston in &self.scene.piston {
            let place = across(piston.x, piston.y).unwrap_or_default();
            let [low, high] = piston.stops.unwrap_or([place; 2]);
            taken.push([low - piston.radius, high + piston.radius]);
        }
        taken
    }

    /// Returns true if a piston between two walls needs no stops: the walls are parallel, and
    /// there is no other piston that it may meet.
    fn may_have_default_stops(&self) -> bool {
        let are_across = self.scene.wall.iter().all(|wall| wall.from.is_none());
        are_across && self.scene.piston.is_empty()
    }
}

/// A force on a piston in a box of this side (length), which changes its energy by about that of a
/// body or by little (mass × length / time²).
pub fn force(draw: &mut FuzzDraw, side: f64) -> f64 {
    draw.sign() * draw.scale(0.01, 30.0) / side
}

/// Lets springs pull a share of the pistons of a scene, in a case of this duration (time).
///
/// Most pistons make from a small part of a swing to some tens of swings; a few springs are much
/// stiffer or softer. They change the energy of a piston by about that of a body.
pub fn add_springs(draw: &mut FuzzDraw, scene: &mut Scene, duration: f64) {
    let (sides, gravity) = (scene.bounds.sides, scene.gravity.acceleration);
    for piston in &mut scene.piston {
        if !draw.happens(SHARE_ON_SPRINGS) {
            continue;
        }
        let axis = usize::from(piston.x.is_none());
        let most = MAX_AWAY * sides[axis];
        let phase = match draw.index(10) {
            0 => draw.scale(1e-3, 0.3),
            1 => draw.scale(200.0, 1000.0),
            _ => draw.scale(0.3, 200.0),
        };
        // Springs whose balance is far away are refused.
        let constant = gravity[axis] + piston.force / piston.mass;
        let frequency = (phase / duration).max((constant.abs() / most).sqrt());
        piston.spring = piston.mass * frequency * frequency;
        let speed = draw.scale(0.05, 5.0) / piston.mass.sqrt();
        let away = draw.sign() * (speed / frequency).min(most);
        let place = piston.x.or(piston.y).unwrap_or_default();
        piston.relaxed_at = (!draw.happens(0.25)).then_some(place + away);
    }
}

/// Multiplies lengths, speeds and masses of a piston by powers of two.
pub fn scale_piston(spec: &mut PistonSpec, length: f64, speed: f64, mass: f64) {
    (spec.x, spec.y) = (spec.x.map(|x| x * length), spec.y.map(|y| y * length));
    spec.radius *= length;
    spec.mass *= mass;
    spec.velocity *= speed;
    spec.force *= mass * (speed * speed / length);
    spec.stops = spec.stops.map(|stops| stops.map(|stop| stop * length));
    let rate = speed / length;
    spec.spring *= mass * (rate * rate);
    spec.relaxed_at = spec.relaxed_at.map(|place| place * length);
}
