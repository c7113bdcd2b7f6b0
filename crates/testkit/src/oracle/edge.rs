//! First contact of an atom with a straight edge, from the atom's distance across the line of the
//! edge and its distance beyond the ends.
//!
//! In the frame that turns with the edge each distance is a coordinate of the atom, whose second
//! derivative is at most K in magnitude. An interval on which either distance stays positive is
//! excluded; all others are bisected, the earlier half first, down to the shortest interval.

use carom_detection::{EdgeErrorBound, encounters::Encounter};
use carom_geometry::{Circle, Edge};

use super::{
    Number,
    flight::FlyingPair,
    interval_search::{IntervalVerdict, SearchEnd, SearchedGap, TimeInterval, first_zero},
    sketch::Sketch,
};

/// An atom of one body and an edge of the other.
#[derive(Debug, Clone, Copy)]
pub struct OracleEdgePair<'a> {
    /// The atom, and the middle of the edge as a second atom.
    pub(super) pair: FlyingPair,
    /// Half of the vector from end to end, in the frame of its body (length).
    pub(super) half: [f64; 2],
    pub(super) edge: &'a Edge,
    /// The number of the body with the edge.
    pub(super) edged: usize,
    bound: EdgeErrorBound,
}

/// Distances and their rates at one time.
pub struct Sight<N> {
    /// Distance across the line of the edge, minus the radii, plus the allowance.
    pub across: [N; 2],
    /// Distance along the edge beyond the nearer end.
    pub beyond: [N; 2],
}

/// Factor by which bounds on rates and curvatures are rounded up.
const ROUND_UP: f64 = 1.0 + 8.0 * f64::EPSILON;

/// Shorter intervals, as a share of the horizon, count as one time.
const MIN_INTERVAL: f64 = 1e-26;

impl<'a> OracleEdgePair<'a> {
    /// The atom `index` of body `body` (0 for A, 1 for B) and the edge `number` of the other,
    /// without an allowance for overlap; `None` if there is no such edge with atoms at its ends.
    pub fn new(encounter: &'a Encounter, body: usize, index: usize, number: usize) -> Option<Self> {
        let other = &encounter.molecules[1 - body];
        let edge = other.edges().get(number)?;
        let [from, to] = edge.ends()?.map(|end| other.atoms()[end as usize].offset());
        let atom = &encounter.molecules[body].atoms()[index];
        let bound = EdgeErrorBound::new(&encounter.motion, body, &Circle::from(atom), edge);
        Some(Self {
            pair: FlyingPair::to_middle(
                encounter,
                body,
                index,
                edge,
                [bound.at(0.0), bound.at(encounter.horizon)],
            ),
            half: (0.5 * (to - from)).to_array(),
            edge,
            edged: 1 - body,
            bound,
        })
    }

    /// Allows an overlap of 2 E in addition to the overlap at the start.
    pub fn allowing_for_rounding<N: Number>(mut self) -> Self {
        let now = self.sight(&N::new(0.0));
        let beside = now.beyond[0].value() <= 0.0;
        let overlap = if beside {
            (-now.across[0].value()).max(0.0) * ROUND_UP
        } else {
            0.0
        };
        let [error, growth] = self.pair.error;
        self.pair.allowed = [2.0 * error * ROUND_UP + overlap, 2.0 * growth * ROUND_UP];
        self
    }

    /// E at a time.
    pub fn error_at(&self, time: f64) -> f64 {
        self.bound.at(time)
    }

    /// E' at a time.
    pub fn rate_error_at(&self, time: f64) -> f64 {
        self.bound.of_rate(time)
    }

    /// K near a contact.
    pub fn curvature(&self) -> f64 {
        let way = self.pair.radii[0] + self.pair.radii[1] + self.edge.reach();
        self.curvature_within(way + self.pair.arms[1 - self.edged])
    }

    /// K while the centres of the bodies are within `distance` (length).
    fn curvature_within(&self, distance: f64) -> f64 {
        let (fast, spin) = (self.pair.spins[self.edged], self.pair.spins[1 - self.edged]);
        let arm = self.pair.arms[1 - self.edged];
        let of_edge = fast * fast * distance + 2.0 * fast.abs() * self.pair.speed;
        (of_edge + (spin - fast) * (spin - fast) * arm) * ROUND_UP
    }

    /// The two distances.
    pub fn sight<N: Number>(&self, time: &N) -> Sight<N> {
        let moment = self.pair.moment(time);
        let [x, y] = self.half.map(N::new);
        let spin = self.pair.spins[self.edged];
        let [cos, sin] = N::cos_sin(self.pair.turns[self.edged], spin, time);
        let half = [
            x.times(&cos).minus(&y.times(&sin)),
            x.times(&sin).plus(&y.times(&cos)),
        ];
        let length = x.times(&x).plus(&y.times(&y)).root();
        let along = |v: &[N; 2]| {
            v[0].times(&half[0])
                .plus(&v[1].times(&half[1]))
                .over(&length)
        };
        let across = |v: &[N; 2]| {
            v[1].times(&half[0])
                .minus(&v[0].times(&half[1]))
                .over(&length)
        };
        // The edge turns: n·d has the rate n·(d' − ω d^⊥).
        let spin = N::new(spin);
        let rate = [
            moment.rate[0].plus(&spin.times(&moment.d[1])),
            moment.rate[1].minus(&spin.times(&moment.d[0])),
        ];
        // The sign of the separation is irrelevant: the edge is symmetric.
        let upright = |value: N, rate: N| {
            let zero = N::new(0.0);
            if value.value() < 0.0 {
                [zero.minus(&value), zero.minus(&rate)]
            } else {
                [value, rate]
            }
        };
        let [distance, closing] = upright(across(&moment.d), across(&rate));
        let [way, leaving] = upright(along(&moment.d), along(&rate));
        let [radius, thickness] = self.pair.radii.map(N::new);
        let growth = N::new(self.pair.allowed[1]);
        let allowed = N::new(self.pair.allowed[0]).plus(&growth.times(time));
        let gap = distance.minus(&radius.plus(&thickness)).plus(&allowed);
        Sight {
            across: [gap, closing.plus(&growth)],
            beyond: [way.minus(&length), leaving],
        }
    }

    /// The first time up to `end` at which the atom is near the line and between the ends.
    pub fn first_contact<N: Number>(&self, end: f64, budget: &mut u64) -> SearchEnd<N> {
        debug_assert!(!self.edge.is_solid_behind());
        first_zero(self, [0.0, end], MIN_INTERVAL * end, budget)
    }

    /// Whether the atom stays away from the line or beyond the ends for `half` (time) to either
    /// side of a time.
    ///
    /// Lemma 3 of the detector's search of edges: in the frame of the edge the atom is at
    /// R_Q⁻¹ (X + V t) + R r, so that both second derivatives are at most
    /// ω_Q² |X + V t| + 2 |ω_Q||V| + (ω_P − ω_Q)² r, here with the largest |X + V t| in the
    /// interval. The allowance is linear in time.
    fn stays_out<N: Number>(&self, middle: &N, half: f64) -> bool {
        let now = self.sight(middle);
        let component = |k: usize| {
            let way = self.pair.velocity[k] * middle.value();
            let rounding = 4.0 * f64::EPSILON * (self.pair.separation[k].abs() + way.abs());
            (self.pair.separation[k] + way).abs() + rounding
        };
        let centre = component(0).hypot(component(1));
        let distance = (centre + self.pair.speed * half) * ROUND_UP;
        let bend = 0.5 * self.curvature_within(distance) * half * half;
        let stays_positive =
            |[value, rate]: &[N; 2]| value.value() > (rate.value().abs() * half + bend) * ROUND_UP;
        stays_positive(&now.across) || stays_positive(&now.beyond)
    }

    /// Last time before `time` at which an atom in deep contact began to touch; 0 if it did from
    /// the start.
    pub fn touch_before<N: Number>(&self, time: &N) -> N {
        let mut back = 2.0 * self.error_at(time.value()) / self.pair.lipschitz;
        let (mut above, mut below) = (N::new(0.0), time.clone());
        for _ in 0..200 {
            let before = time.minus(&N::new(back));
            if before.value() <= 0.0 {
                break;
            }
            if self.sight(&before).across[0].value() > 0.0 {
                above = before;
                break;
            }
            below = before;
            back *= 2.0;
        }
        if above.value() == 0.0 && self.sight(&above).across[0].value() <= 0.0 {
            return above;
        }
        for _ in 0..110 {
            let middle = above.plus(&below).times(&N::new(0.5));
            if self.sight(&middle).across[0].value() > 0.0 {
                above = middle;
            } else {
                below = middle;
            }
        }
        below
    }
}

impl<N: Number> SearchedGap<N> for OracleEdgePair<'_> {
    fn sketch(&self, middle: f64, half: f64) -> Sketch {
        self.sketch_around(middle, half)
    }

    fn look(&self, interval: &TimeInterval<N>) -> IntervalVerdict<N> {
        if self.stays_out(&interval.middle, interval.half) {
            IntervalVerdict::Free
        } else {
            IntervalVerdict::Halve
        }
    }

    /// Nothing else tells a zero from a time at which both distances are small.
    fn at_shortest(&self, begin: N) -> SearchEnd<N> {
        SearchEnd::Zero(begin)
    }
}
