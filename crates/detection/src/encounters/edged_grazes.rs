//! Encounters of bodies with straight edges, constructed backwards in time from a graze of known
//! depth, or from a contact at a known distance from the end of an edge.

use std::f64::consts::TAU;

use carom_geometry::{Edge, Molecule};
use carom_kinematics::{Orientation, RelativeMotion};
use glam::DVec2;

use super::{
    Encounter,
    edged_flights::{axes, either_order, is_apart},
    edged_shapes::{rectangle, sharp_triangle, sixteen_sides, square},
    grazes::{outermost, planted},
    random::Draw,
    size,
};

/// Limit of constructed pairs until one starts apart; one in ten does.
const MAX_TRIES: u32 = 1000;

/// A corner that grazes a corner or an edge: seven in ten overlap by 10^−`exponent` sizes, the
/// others miss by as much.
pub(super) fn corner_graze(draw: &mut Draw, exponent: u8) -> Encounter {
    let depth = 10f64.powi(-i32::from(exponent));
    let depth = if draw.happens(0.7) { depth } else { -depth };
    let on_corner = draw.happens(0.4);
    for _ in 0..MAX_TRIES {
        let molecules = [convex(draw), convex(draw)];
        let encounter = if on_corner {
            planted(draw, molecules, depth)
        } else {
            let [a, b] = &molecules;
            let pose = CornerOnEdge::new(draw, a, b);
            let place = draw.between(-0.8, 0.8);
            let graze = pose.grazing(draw, place, depth * size(&molecules));
            pose.encounter(draw, molecules, graze)
        };
        if is_apart(&encounter, 1e-3) {
            return either_order(draw, encounter);
        }
    }
    unreachable!("one constructed pair in ten starts apart")
}

/// A corner that comes to a moving edge within 1e-12 to 1e-2 of its end, on it or beyond.
pub(super) fn edge_end(draw: &mut Draw) -> Encounter {
    let distance = draw.sign() * draw.scale(1e-12, 1e-2);
    for _ in 0..MAX_TRIES {
        let molecules = [convex(draw), convex(draw)];
        let [a, b] = &molecules;
        let pose = CornerOnEdge::new(draw, a, b);
        let end = draw.sign() * (1.0 + distance);
        let hit = pose.hitting(draw, end);
        let encounter = pose.encounter(draw, molecules, hit);
        if is_apart(&encounter, 1e-6) {
            return either_order(draw, encounter);
        }
    }
    unreachable!("one constructed pair in ten starts apart")
}

fn convex(draw: &mut Draw) -> Molecule {
    match draw.one_of(&[0, 1, 2, 3]) {
        0 => square(draw),
        1 => rectangle(draw, 1.0),
        2 => sharp_triangle(draw),
        _ => sixteen_sides(draw, 1.0),
    }
}

/// An edge of A, which is convex, and the corner of B that is nearest to its line, at the time of
/// the contact.
struct CornerOnEdge {
    orientation: [Orientation; 2],
    spins: [f64; 2],
    /// Unit vectors along the edge and out of A.
    along: DVec2,
    normal: DVec2,
    /// From the centre of A to the middle of the edge (length).
    middle: DVec2,
    half_length: f64,
    /// From the centre of B to the corner (length).
    arm: DVec2,
    contact_distance: f64,
}

/// Position and velocity of B relative to A, and how long before the encounter begins.
#[derive(Clone, Copy)]
struct Meeting {
    separation: DVec2,
    velocity: DVec2,
    time: f64,
}

impl CornerOnEdge {
    fn new(draw: &mut Draw, a: &Molecule, b: &Molecule) -> Self {
        let orientation = [draw.orientation(), draw.orientation()];
        let edges: Vec<&Edge> = a.edges().iter().collect();
        let edge = draw.one_of(&edges);
        let [along, normal] = axes(edge.along(), orientation[0]);
        let middle = orientation[0].cos_sin().rotate(edge.middle());
        // The centre of mass of a convex body is behind all its edges.
        let normal = normal * middle.dot(normal).signum();
        let (arm, radius) = outermost(b, orientation[1].cos_sin(), -normal);
        let spin = |draw: &mut Draw| draw.sign() * draw.between(0.1, 1.0);
        Self {
            orientation,
            spins: [spin(draw), spin(draw)],
            along,
            normal,
            middle,
            half_length: edge.half_length(),
            arm,
            contact_distance: radius + edge.radius(),
        }
    }

    /// From the centre of A to the corner, at `place` half lengths from the middle of the edge and
    /// `gap` (length) apart from it.
    fn corner(&self, place: f64, gap: f64) -> DVec2 {
        self.middle
            + place * self.half_length * self.along
            + (self.contact_distance + gap) * self.normal
    }

    /// The meeting at which the corner D has this velocity relative to the edge.
    fn meeting(&self, corner: DVec2, slip: f64, rate: f64, time: f64) -> Meeting {
        let turning = self.spins[1] * self.arm.perp() - self.spins[0] * corner.perp();
        Meeting {
            separation: corner - self.arm,
            velocity: slip * self.along + (rate - turning.dot(self.normal)) * self.normal,
            time,
        }
    }

    /// y = s − `depth` and y' = 0 < y'': −2 ω_A n·V^⊥ exceeds the other terms of y''.
    fn grazing(&self, draw: &mut Draw, place: f64, depth: f64) -> Meeting {
        let corner = self.corner(place, -depth);
        let [fast, spin] = self.spins.map(f64::abs);
        let others =
            (spin * spin + 2.0 * fast * spin) * self.arm.length() + fast * fast * corner.length();
        let speed = others / (2.0 * fast) + draw.between(0.5, 2.0);
        // n·V^⊥ is the velocity along −n^⊥.
        let towards = -self.normal.perp().dot(self.along).signum();
        let slip = -self.spins[0].signum() * towards * speed;
        let time = draw.between(0.2, 2.0) * self.arm.length() / speed;
        self.meeting(corner, slip, 0.0, time)
    }

    /// y = s and y' < 0.
    fn hitting(&self, draw: &mut Draw, place: f64) -> Meeting {
        let rate = -draw.between(0.2, 2.0);
        let slip = draw.between(-1.0, 1.0);
        let time = draw.between(0.1, 1.0) * self.arm.length() / -rate;
        self.meeting(self.corner(place, 0.0), slip, rate, time)
    }

    fn encounter(&self, draw: &mut Draw, molecules: [Molecule; 2], meeting: Meeting) -> Encounter {
        let Meeting {
            separation,
            velocity,
            time,
        } = meeting;
        let before = |body: usize| {
            Orientation::from_turns(self.orientation[body].turns() - self.spins[body] * time / TAU)
        };
        let motion = RelativeMotion {
            orientation: [before(0), before(1)],
            angular_velocity: self.spins,
            ..RelativeMotion::exactly(separation - velocity * time, velocity)
        };
        Encounter::until_parted(molecules, motion, draw.between(1.5, 3.0) * time)
    }
}
