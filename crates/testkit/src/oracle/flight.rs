//! The relative motion of two atoms, coordinate by coordinate.

use carom_detection::{ErrorBound, encounters::Encounter};
use carom_geometry::Edge;

use super::Number;

/// An atom of A and an atom of B.
#[derive(Debug, Clone, Copy)]
pub struct FlyingPair {
    /// From the centre of A to that of B (length).
    pub separation: [f64; 2],
    /// Velocity of B minus that of A.
    pub velocity: [f64; 2],
    /// Positions of the two atoms in their molecules (length).
    pub offsets: [[f64; 2]; 2],
    /// Their magnitudes, rounded up.
    pub arms: [f64; 2],
    /// Orientations at time 0, in turns.
    pub turns: [f64; 2],
    /// Angular velocities (radians per time).
    pub spins: [f64; 2],
    /// Radii of the two atoms (length).
    pub radii: [f64; 2],
    /// E at time 0, and its rate of growth.
    pub error: [f64; 2],
    /// Allowed overlap at time 0, and its rate of growth.
    pub allowed: [f64; 2],
    /// |V|, rounded up.
    pub speed: f64,
    /// L ≥ |d'|.
    pub lipschitz: f64,
    /// K ≥ |d''|.
    pub curvature: f64,
}

/// d and d' at one time.
pub struct Moment<N> {
    /// d
    pub d: [N; 2],
    /// d'
    pub rate: [N; 2],
}

/// F = |d|² − S² and F', with |d|².
pub struct Squared<N> {
    /// |d|²
    pub distance: N,
    /// F
    pub value: N,
    /// F'
    pub rate: N,
}

/// Relative rounding error of lengths in double precision; bounds are rounded up by it.
const ROUND_UP: f64 = 1.0 + 8.0 * f64::EPSILON;

fn length([x, y]: [f64; 2]) -> f64 {
    x.hypot(y) * ROUND_UP
}

impl FlyingPair {
    /// Atom `i` of A and atom `j` of B, without an allowance for overlap.
    pub fn new(encounter: &Encounter, (i, j): (usize, usize)) -> Self {
        let motion = &encounter.motion;
        let atoms = [
            &encounter.molecules[0].atoms()[i],
            &encounter.molecules[1].atoms()[j],
        ];
        let offsets = atoms.map(|atom| atom.offset().to_array());
        let arms = offsets.map(length);
        let spins = motion.angular_velocity;
        let velocity = motion.velocity.to_array();
        let rim = [0, 1].map(|body| spins[body].abs() * arms[body]);
        let bound = ErrorBound::new(motion, atoms[0], atoms[1]);
        let growth = if encounter.horizon > 0.0 {
            (bound.at(encounter.horizon) - bound.at(0.0)).max(0.0) / encounter.horizon
        } else {
            0.0
        };
        Self {
            separation: motion.separation.to_array(),
            velocity,
            offsets,
            arms,
            turns: motion.orientation.map(carom_kinematics::Orientation::turns),
            spins,
            radii: atoms.map(carom_geometry::Atom::radius),
            error: [bound.at(0.0), growth],
            allowed: [0.0; 2],
            speed: length(velocity),
            lipschitz: (length(velocity) + (rim[0] + rim[1])) * ROUND_UP,
            curvature: (spins[0].abs() * rim[0] + spins[1].abs() * rim[1]) * ROUND_UP,
        }
    }

    /// An atom of body number `body`, and the middle of an edge of the other as an atom with half
    /// the thickness of the edge as radius. `error` is E at time 0 and at the horizon.
    pub fn to_middle(
        encounter: &Encounter,
        body: usize,
        index: usize,
        edge: &Edge,
        error: [f64; 2],
    ) -> Self {
        let (atom, motion) = (&encounter.molecules[body].atoms()[index], &encounter.motion);
        let of_atom = |values: [f64; 2]| {
            if body == 0 {
                values
            } else {
                [values[1], values[0]]
            }
        };
        let (offset, arm) = (atom.offset().to_array(), length(atom.offset().to_array()));
        let velocity = motion.velocity.to_array();
        let thickness = edge.radius();
        let (middle, middle_arm) = (edge.middle().to_array(), length(edge.middle().to_array()));
        let rim = motion.angular_velocity[body].abs() * arm
            + motion.angular_velocity[1 - body].abs() * (middle_arm + edge.half_length());
        let bend = motion.angular_velocity[body].powi(2) * arm
            + motion.angular_velocity[1 - body].powi(2) * middle_arm;
        let [start, end] = error;
        let growth = if encounter.horizon > 0.0 {
            (end - start).max(0.0) / encounter.horizon
        } else {
            0.0
        };
        Self {
            separation: motion.separation.to_array(),
            velocity,
            offsets: if body == 0 {
                [offset, middle]
            } else {
                [middle, offset]
            },
            arms: of_atom([arm, middle_arm]),
            turns: motion.orientation.map(carom_kinematics::Orientation::turns),
            spins: motion.angular_velocity,
            radii: of_atom([atom.radius(), thickness]),
            error: [start, growth],
            allowed: [0.0; 2],
            speed: length(velocity),
            lipschitz: (length(velocity) + rim) * ROUND_UP,
            curvature: bend * ROUND_UP,
        }
    }

    /// Allows an overlap of 2 E in addition to the overlap at the start.
    pub fn allowing_for_rounding<N: Number>(mut self) -> Self {
        let overlap = (-self.gap::<N>(&N::new(0.0)).value()).max(0.0) * ROUND_UP;
        self.allowed = [
            2.0 * self.error[0] * ROUND_UP + overlap,
            2.0 * self.error[1] * ROUND_UP,
        ];
        self
    }

    /// E at a time.
    pub fn error_at(&self, time: f64) -> f64 {
        self.error[0] + self.error[1] * time
    }

    /// Returns d and d'.
    pub fn moment<N: Number>(&self, time: &N) -> Moment<N> {
        let arm = |body: usize| -> [N; 2] {
            let [x, y] = self.offsets[body].map(N::new);
            if self.spins[body] == 0.0 && self.turns[body] == 0.0 {
                return [x, y];
            }
            let [cos, sin] = N::cos_sin(self.turns[body], self.spins[body], time);
            [
                x.times(&cos).minus(&y.times(&sin)),
                x.times(&sin).plus(&y.times(&cos)),
            ]
        };
        let [a, b] = [arm(0), arm(1)];
        let [spin_a, spin_b] = self.spins.map(N::new);
        let place = |k: usize| {
            let path = N::new(self.velocity[k]).times(time);
            N::new(self.separation[k])
                .plus(&path)
                .plus(&b[k].minus(&a[k]))
        };
        // ω × r = ω (−y, x)
        let turning = [
            spin_a.times(&a[1]).minus(&spin_b.times(&b[1])),
            spin_b.times(&b[0]).minus(&spin_a.times(&a[0])),
        ];
        let rate = |k: usize| N::new(self.velocity[k]).plus(&turning[k]);
        Moment {
            d: [place(0), place(1)],
            rate: [rate(0), rate(1)],
        }
    }

    /// Returns F and F'.
    pub fn squared<N: Number>(&self, time: &N) -> Squared<N> {
        let Moment {
            d: [x, y],
            rate: [u, v],
        } = self.moment(time);
        let distance = x.times(&x).plus(&y.times(&y));
        let growth = N::new(self.allowed[1]);
        let allowed = N::new(self.allowed[0]).plus(&growth.times(time));
        let reach = N::new(self.radii[0])
            .plus(&N::new(self.radii[1]))
            .minus(&allowed);
        let half_rate = x.times(&u).plus(&y.times(&v)).plus(&reach.times(&growth));
        let value = distance.minus(&reach.times(&reach));
        Squared {
            distance,
            value,
            rate: half_rate.plus(&half_rate),
        }
    }

    /// g = |d| − s, without the allowance.
    pub fn gap<N: Number>(&self, time: &N) -> N {
        let Moment { d: [x, y], .. } = self.moment(time);
        let distance = x.times(&x).plus(&y.times(&y)).root();
        distance.minus(&N::new(self.radii[0]).plus(&N::new(self.radii[1])))
    }
}
