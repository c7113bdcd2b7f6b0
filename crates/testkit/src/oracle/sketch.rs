//! Examination of an interval in double precision, with a generous allowance for rounding.

use super::flight::FlyingPair;

/// Result in double precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sketch {
    /// The interval has no zero.
    Free,
    /// It must be bisected in any arithmetic.
    Halve,
    /// Higher precision is needed.
    Unclear,
}

/// Relative allowance for rounding: ten times the actual number of roundings.
const ROUNDINGS: f64 = 400.0 * f64::EPSILON;

/// Least turn of a body in half an interval for which the whole orbit of its atom is a useful bound
/// (radians).
const WIDE: f64 = 0.3;

/// State of the atoms at one time, in double precision.
struct Rough {
    centres: [f64; 2],
    arms: [[f64; 2]; 2],
    /// Bound on the error of each coordinate of d.
    error: f64,
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

impl FlyingPair {
    fn rough(&self, time: f64) -> Rough {
        let arms = [0, 1].map(|body| {
            let turned = self.spins[body] * time / std::f64::consts::TAU;
            let turns = (turned - turned.round()) + self.turns[body];
            let (sin, cos) = (std::f64::consts::TAU * turns).sin_cos();
            let [x, y] = self.offsets[body];
            [x * cos - y * sin, x * sin + y * cos]
        });
        let centres = [0, 1].map(|k| self.separation[k] + self.velocity[k] * time);
        let places =
            self.separation[0].abs() + self.separation[1].abs() + self.arms[0] + self.arms[1];
        Rough {
            centres,
            arms,
            error: ROUNDINGS * (places + self.lipschitz * time),
        }
    }

    /// Examines F from `middle` − `half` to `middle` + `half`.
    pub fn sketch_around(&self, middle: f64, half: f64) -> Sketch {
        let rough = self.rough(middle);
        let growth = self.allowed[1];
        let reach = self.radii[0] + self.radii[1] - self.allowed[0] - growth * middle;
        if self.out_of_orbit(&rough, half, reach + growth * half + rough.error) {
            return Sketch::Free;
        }
        let d = [0, 1].map(|k| rough.centres[k] + (rough.arms[1][k] - rough.arms[0][k]));
        let [spin_a, spin_b] = self.spins;
        let rate = [
            self.velocity[0] + (spin_a * rough.arms[0][1] - spin_b * rough.arms[1][1]),
            self.velocity[1] + (spin_b * rough.arms[1][0] - spin_a * rough.arms[0][0]),
        ];
        let distance = dot(d, d).sqrt();
        let value = dot(d, d) - reach * reach;
        let slope = 2.0 * (dot(d, rate) + reach * growth);
        let error = 4.0 * rough.error * (distance + reach.abs() + rough.error);
        let spin = spin_a.abs().max(spin_b.abs());
        let slope_error = 8.0 * rough.error * (self.lipschitz + spin * (distance + rough.error))
            + 2.0 * ROUNDINGS * (distance * self.lipschitz + reach.abs() * growth);
        let (sag, bend) = self.curvatures(distance + rough.error, half);
        let drop = (slope.abs() + slope_error) * half + 0.5 * sag * half * half;
        if value - error > drop * (1.0 + ROUNDINGS)
            || slope - slope_error > bend * half * (1.0 + ROUNDINGS)
        {
            Sketch::Free
        } else if error < 0.01 * drop && slope.abs() < bend * half {
            Sketch::Halve
        } else {
            Sketch::Unclear
        }
    }

    /// Bounds on −F'' and on |F''| over an interval in whose middle |d| is at most `distance`: F''
    /// = 2 |d'|² + 2 d·d'' − 2 S'².
    pub fn curvatures(&self, distance: f64, half: f64) -> (f64, f64) {
        let growth = self.allowed[1];
        let most = distance + self.lipschitz * half;
        let sag = 2.0 * (most * self.curvature + growth * growth);
        (
            sag * (1.0 + ROUNDINGS),
            (sag + 2.0 * self.lipschitz * self.lipschitz) * (1.0 + ROUNDINGS),
        )
    }

    /// Returns true if the atoms stay apart even with the atoms of fast rotors anywhere on their
    /// orbits.
    fn out_of_orbit(&self, rough: &Rough, half: f64, reach: f64) -> bool {
        let wide = [0, 1].map(|body| self.spins[body].abs() * half > WIDE);
        let choices = [[false, true], [true, false], [true, true]];
        choices.into_iter().any(|smeared| {
            let useful = (0..2).all(|body| wide[body] || !smeared[body]);
            useful && self.apart_when_smeared(rough, half, reach, smeared)
        })
    }

    /// Returns true if the atoms stay apart with the atoms of the bodies in `smeared` anywhere on
    /// their orbits.
    fn apart_when_smeared(&self, rough: &Rough, half: f64, reach: f64, smeared: [bool; 2]) -> bool {
        let sign = [-1.0, 1.0];
        let (mut point, mut rate) = (rough.centres, self.velocity);
        let (mut speed, mut curvature) = (self.speed, 0.0);
        for body in (0..2).filter(|&body| !smeared[body]) {
            let [x, y] = rough.arms[body];
            let turning = sign[body] * self.spins[body];
            point = [point[0] + sign[body] * x, point[1] + sign[body] * y];
            rate = [rate[0] - turning * y, rate[1] + turning * x];
            let rim = self.spins[body].abs() * self.arms[body];
            speed += rim;
            curvature += self.spins[body].abs() * rim;
        }
        let distance = point[0].hypot(point[1]);
        if distance == 0.0 {
            return false;
        }
        let along = dot(point, rate).abs() / distance + ROUNDINGS * speed;
        let nearest = distance
            - rough.error
            - along * half
            - 0.5 * curvature * half * half * (1.0 + ROUNDINGS);
        let farthest = distance + rough.error + speed * half * (1.0 + ROUNDINGS);
        // The set reached by the smeared atoms is an annulus about the point.
        let circles = [0, 1].map(|body| if smeared[body] { self.arms[body] } else { 0.0 });
        let (outer, inner) = (circles[0] + circles[1], (circles[0] - circles[1]).abs());
        let room = 1.0 + ROUNDINGS;
        nearest > (outer + reach) * room || farthest < inner * (1.0 - ROUNDINGS) - reach * room
    }
}
