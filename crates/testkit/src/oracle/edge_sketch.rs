//! Examination of an interval for an atom and an edge in double precision, with a generous
//! allowance for rounding.
//!
//! Besides the bounds of the full arithmetic it uses the orbits of fast rotors: an atom stays
//! within its arm of the centre of its body, and an edge stays between its least and its largest
//! distance from the centre of its own.

use std::f64::consts::TAU;

use super::{edge::OracleEdgePair, sketch::Sketch};

/// Relative allowance for rounding: ten times the actual number of roundings.
const ROUNDINGS: f64 = 400.0 * f64::EPSILON;

/// Least turn of a body in half an interval for which the whole orbit of its part is a useful bound
/// (radians).
const WIDE: f64 = 0.3;

type Vector = [f64; 2];

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn sum(a: Vector, factor: f64, b: Vector) -> Vector {
    [a[0] + factor * b[0], a[1] + factor * b[1]]
}

fn perp([x, y]: Vector) -> Vector {
    [-y, x]
}

fn rotated([x, y]: Vector, turns: f64) -> Vector {
    let (sin, cos) = (TAU * turns).sin_cos();
    [x * cos - y * sin, x * sin + y * cos]
}

/// A distance and its rate at one time, and what bounds them over an interval around it.
struct Bounded {
    value: f64,
    rate: f64,
    curvature: f64,
    error: f64,
    rate_error: f64,
}

impl Bounded {
    /// How far the distance can fall in `half` (time) to either side.
    fn drop(&self, half: f64) -> f64 {
        let fall = (self.rate.abs() + self.rate_error) * half + 0.5 * self.curvature * half * half;
        fall * (1.0 + ROUNDINGS)
    }

    /// Whether the distance stays above `limit`.
    fn stays_above(&self, limit: f64, half: f64) -> bool {
        self.value - self.error > limit * (1.0 + ROUNDINGS) + self.drop(half)
    }
}

/// Places in double precision at one time, from the body with the edge.
struct Rough {
    /// The centre of the body with the atom.
    centre: Vector,
    velocity: Vector,
    arm: Vector,
    along: Vector,
    /// Coordinates of the middle of the edge, along and across it.
    middle: Vector,
    error: f64,
    rate_error: f64,
}

impl OracleEdgePair<'_> {
    /// The spin of the atom's body, and that of the edge's.
    fn spins(&self) -> [f64; 2] {
        [self.pair.spins[1 - self.edged], self.pair.spins[self.edged]]
    }

    fn rough(&self, time: f64) -> Rough {
        let (pair, edged) = (&self.pair, self.edged);
        let turns = |body: usize| {
            let turned = pair.spins[body] * time / TAU;
            (turned - turned.round()) + pair.turns[body]
        };
        let sign = if edged == 0 { 1.0 } else { -1.0 };
        let place = sum(pair.separation, time, pair.velocity);
        let length = self.half[0].hypot(self.half[1]);
        let unit = self.half.map(|component| component / length);
        let offset = pair.offsets[edged];
        let [spin, fast] = self.spins();
        let arm = pair.arms[1 - edged];
        let reach = pair.arms[edged] + length;
        let far = place[0].hypot(place[1]) + arm + reach;
        let lengths = pair.separation[0].abs()
            + pair.separation[1].abs()
            + pair.speed * time
            + arm * (1.0 + spin.abs() * time)
            + far * (1.0 + fast.abs() * time);
        let error = ROUNDINGS * lengths;
        let speeds = pair.speed + spin.abs() * arm + fast.abs() * far;
        Rough {
            centre: place.map(|component| sign * component),
            velocity: pair.velocity.map(|component| sign * component),
            arm: rotated(pair.offsets[1 - edged], turns(1 - edged)),
            along: rotated(unit, turns(edged)),
            middle: [dot(unit, offset), dot(perp(unit), offset)],
            error,
            rate_error: error * (spin.abs() + fast.abs())
                + ROUNDINGS * speeds * (1.0 + fast.abs() * time),
        }
    }

    /// Examines an interval from `middle` − `half` to `middle` + `half`.
    pub fn sketch_around(&self, middle: f64, half: f64) -> Sketch {
        let rough = self.rough(middle);
        let [spin, fast] = self.spins();
        let (arm, radii) = (self.pair.arms[1 - self.edged], self.radii());
        let centre = rough.centre[0].hypot(rough.centre[1]);
        let farthest = centre + self.pair.speed * half + rough.error;
        let nearest = centre - self.pair.speed * half - rough.error;
        let reach = self.edge.reach();
        if nearest > (reach + arm + radii) * (1.0 + ROUNDINGS) {
            return Sketch::Free;
        }
        let of_edge = fast * fast * farthest + 2.0 * fast.abs() * self.pair.speed;
        let wide = [spin, fast].map(|spin| spin.abs() * half > WIDE);
        let of_arm = (spin - fast) * (spin - fast) * arm;
        if wide[0] && self.is_apart_from_orbit_of_atom(&rough, of_edge, half)
            || wide[1] && self.is_apart_from_orbit_of_edge(&rough, half)
            || wide[0] && wide[1] && farthest < (self.least_distance() - arm - radii)
            || wide[0] && wide[1] && farthest < arm * (1.0 - ROUNDINGS) - (reach + radii)
        {
            return Sketch::Free;
        }
        let place = sum(rough.centre, 1.0, rough.arm);
        let velocity = sum(rough.velocity, spin, perp(rough.arm));
        let [mut across, mut beyond] = self.coordinates(&rough, place, velocity, of_edge + of_arm);
        // The allowance: 2 E that grow linearly.
        let [allowed, growth] = self.pair.allowed;
        across.value += (allowed + growth * middle) - radii;
        across.rate_error += growth;
        beyond.value -= self.edge.half_length();
        if across.stays_above(0.0, half) || beyond.stays_above(0.0, half) {
            return Sketch::Free;
        }
        let is_clear = |bounded: &Bounded| {
            bounded.value + bounded.error < bounded.drop(half)
                && bounded.error < 0.01 * bounded.drop(half)
        };
        if is_clear(&across) && is_clear(&beyond) {
            Sketch::Halve
        } else {
            Sketch::Unclear
        }
    }

    /// The distances of a point from the middle of the edge across it and along it.
    fn coordinates(
        &self,
        rough: &Rough,
        place: Vector,
        velocity: Vector,
        curvature: f64,
    ) -> [Bounded; 2] {
        let [_, fast] = self.spins();
        // n·D has the rate n·(D' − ω D^⊥).
        let rate = sum(velocity, -fast, perp(place));
        let [along, across] = [rough.along, perp(rough.along)];
        let bounded = |direction: Vector, middle: f64| Bounded {
            value: (dot(direction, place) - middle).abs(),
            rate: dot(direction, rate),
            curvature,
            error: rough.error,
            rate_error: rough.rate_error,
        };
        [
            bounded(across, rough.middle[1]),
            bounded(along, rough.middle[0]),
        ]
    }

    /// Whether the whole orbit of the atom stays apart from the edge.
    fn is_apart_from_orbit_of_atom(&self, rough: &Rough, of_edge: f64, half: f64) -> bool {
        let arm = self.pair.arms[1 - self.edged];
        let [across, beyond] = self.coordinates(rough, rough.centre, rough.velocity, of_edge);
        across.stays_above(arm + self.radii(), half)
            || beyond.stays_above(arm + self.edge.half_length(), half)
    }

    /// Whether the atom stays apart from the annulus in which the edge turns.
    fn is_apart_from_orbit_of_edge(&self, rough: &Rough, half: f64) -> bool {
        let [spin, _] = self.spins();
        let place = sum(rough.centre, 1.0, rough.arm);
        let velocity = sum(rough.velocity, spin, perp(rough.arm));
        let distance = place[0].hypot(place[1]);
        if distance == 0.0 {
            return false;
        }
        let speed = velocity[0].hypot(velocity[1]) + rough.rate_error;
        let outwards = Bounded {
            value: distance,
            rate: dot(place, velocity) / distance,
            curvature: spin * spin * self.pair.arms[1 - self.edged],
            error: rough.error,
            // The direction has an error of 2 error/|D|.
            rate_error: rough.rate_error + 2.0 * speed * rough.error / distance,
        };
        let farthest = distance + rough.error + self.pair.lipschitz * half * (1.0 + ROUNDINGS);
        outwards.stays_above(self.edge.reach() + self.radii(), half)
            || farthest < self.least_distance() - self.radii()
    }

    /// A lower bound on the distance of the edge from the centre of its body (length).
    fn least_distance(&self) -> f64 {
        let middle = self.edge.middle();
        let (along, across) = (
            middle.dot(self.edge.along()).abs(),
            middle.dot(self.edge.normal()).abs(),
        );
        let past = (along - self.edge.half_length()).max(0.0);
        past.hypot(across) * (1.0 - ROUNDINGS) - ROUNDINGS * self.edge.reach()
    }

    /// The sum of the radii of atom and edge (length).
    fn radii(&self) -> f64 {
        self.pair.radii[0] + self.pair.radii[1]
    }
}
