//! The search: intervals of time are excluded or bisected, the earlier half first.

use carom_detection::{Part, Touch, encounters::Encounter};

use super::{
    Number,
    edge::OracleEdgePair,
    flight::FlyingPair,
    interval_search::{self, IntervalVerdict, SearchEnd, SearchedGap, TimeInterval},
    sketch::Sketch,
};

/// Effort limit of the oracle.
#[derive(Debug, Clone, Copy)]
pub struct Oracle {
    /// Largest number of intervals examined in one encounter.
    pub most_intervals: u64,
}

impl Default for Oracle {
    fn default() -> Self {
        Self {
            most_intervals: 1_000_000,
        }
    }
}

/// Result of the oracle for an encounter.
#[derive(Debug, Clone)]
pub enum ExclusionReference<N> {
    /// No overlap exceeds the rounding allowance up to the horizon.
    Free,
    /// An overlap exceeds the rounding allowance.
    Deep(Deep<N>),
    /// The limit on intervals was reached.
    Unresolved,
}

/// The first overlap that exceeds the rounding allowance.
#[derive(Debug, Clone)]
pub struct Deep<N> {
    /// Time at which the overlap reaches the allowance: the latest correct time for a report
    /// (time).
    pub time: N,
    /// Time at which these parts touched before (time).
    pub touch: N,
    /// The parts: an atom of A and one of B, or an atom and an edge.
    pub parts: Touch,
}

/// Shortest interval; further bisection is below rounding.
const MIN_INTERVAL: f64 = 1e-31;

/// Largest number of steps of the final root search; Newton's method takes six.
const MAX_STEPS: u32 = 200;

impl Oracle {
    /// Searches the first deep contact of all pairs of atoms.
    pub fn first_contact<N: Number>(self, encounter: &Encounter) -> ExclusionReference<N> {
        let mut budget = self.most_intervals;
        let mut best: Option<Deep<N>> = None;
        let is_resolved = search_atoms(encounter, &mut best, &mut budget)
            && search_edges(encounter, &mut best, &mut budget);
        if !is_resolved {
            return ExclusionReference::Unresolved;
        }
        best.map_or(ExclusionReference::Free, ExclusionReference::Deep)
    }
}

/// Searches all pairs of atoms for a contact earlier than the best one so far. Returns false if the
/// budget is spent.
fn search_atoms<N: Number>(
    encounter: &Encounter,
    best: &mut Option<Deep<N>>,
    budget: &mut u64,
) -> bool {
    let counts = [0, 1].map(|body| encounter.molecules[body].atoms().len());
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            let pair = FlyingPair::new(encounter, (i, j)).allowing_for_rounding::<N>();
            match first_zero::<N>(&pair, horizon(encounter, best.as_ref()), budget) {
                SearchEnd::Nothing => {}
                SearchEnd::OutOfBudget => return false,
                SearchEnd::Zero(time) => {
                    if is_earlier(&time, best.as_ref()) {
                        let plain = FlyingPair::new(encounter, (i, j));
                        let touch = touch_before(&plain, &time);
                        *best = Some(Deep {
                            time,
                            touch,
                            parts: Touch::Atoms(i as u32, j as u32),
                        });
                    }
                }
            }
        }
    }
    true
}

/// Searches all atoms of one body and all edges of the other for a contact earlier than the best
/// one so far. Returns false if the budget is spent.
fn search_edges<N: Number>(
    encounter: &Encounter,
    best: &mut Option<Deep<N>>,
    budget: &mut u64,
) -> bool {
    for (body, molecule) in encounter.molecules.iter().enumerate() {
        let edges = encounter.molecules[1 - body].edges().len();
        let pairs =
            (0..molecule.atoms().len()).flat_map(|index| (0..edges).map(move |edge| (index, edge)));
        for (index, number) in pairs {
            let Some(plain) = OracleEdgePair::new(encounter, body, index, number) else {
                continue;
            };
            let pair = plain.allowing_for_rounding::<N>();
            match pair.first_contact::<N>(horizon(encounter, best.as_ref()), budget) {
                SearchEnd::Nothing => {}
                SearchEnd::OutOfBudget => return false,
                SearchEnd::Zero(time) => {
                    if is_earlier(&time, best.as_ref()) {
                        let part = Part::Atom(index as u32);
                        let edge = number as u32;
                        let parts = if body == 0 {
                            Touch::EdgeOfB { edge, part }
                        } else {
                            Touch::EdgeOfA { edge, part }
                        };
                        *best = Some(Deep {
                            touch: plain.touch_before(&time),
                            time,
                            parts,
                        });
                    }
                }
            }
        }
    }
    true
}

/// The end of a search: contacts after the best one so far are of no interest.
fn horizon<N: Number>(encounter: &Encounter, best: Option<&Deep<N>>) -> f64 {
    best.map_or(encounter.horizon, |deep| deep.time.value().next_up())
        .min(encounter.horizon)
}

/// Whether a contact at this time is earlier than the best one so far.
fn is_earlier<N: Number>(time: &N, best: Option<&Deep<N>>) -> bool {
    best.is_none_or(|deep| time.minus(&deep.time).value() < 0.0)
}

/// The time window in which the atoms' orbit circles are within reach, rounded outwards; `None` if
/// they never are.
fn window(pair: &FlyingPair, end: f64) -> Option<(f64, f64)> {
    let reach = (pair.arms[0] + pair.arms[1] + pair.radii[0] + pair.radii[1]) * (1.0 + 1e-9);
    let [x, y] = pair.separation;
    let [u, v] = pair.velocity;
    let (b, speed_squared) = (x * u + y * v, u * u + v * v);
    if speed_squared == 0.0 {
        return (x.hypot(y) <= reach).then_some((0.0, end));
    }
    let nearest = (x * v - y * u).abs() / speed_squared.sqrt();
    let room = 1e-9 * (x.hypot(y) + reach);
    if nearest > reach + room {
        return None;
    }
    let middle = -b / speed_squared;
    let half = ((reach + room).powi(2) - nearest * nearest).max(0.0).sqrt() / speed_squared.sqrt();
    let (begin, end) = (
        (middle - half) * (1.0 - 1e-9) - 1e-9 * half,
        ((middle + half) + 1e-9 * half).min(end),
    );
    let begin = begin.max(0.0);
    (begin <= end).then_some((begin, end))
}

/// The first zero of F up to `end`; F is positive at time 0.
fn first_zero<N: Number>(pair: &FlyingPair, end: f64, budget: &mut u64) -> SearchEnd<N> {
    let Some((begin, end)) = window(pair, end) else {
        return SearchEnd::Nothing;
    };
    interval_search::first_zero(pair, [begin, end], MIN_INTERVAL * end, budget)
}

impl<N: Number> SearchedGap<N> for FlyingPair {
    fn sketch(&self, middle: f64, half: f64) -> Sketch {
        self.sketch_around(middle, half)
    }

    fn look(&self, interval: &TimeInterval<N>) -> IntervalVerdict<N> {
        let half = interval.half;
        let now = self.squared(&interval.middle);
        let (value, slope) = (now.value.value(), now.rate.value());
        let distance = now.distance.value().max(0.0).sqrt() * (1.0 + 4.0 * f64::EPSILON);
        let (sag, bend) = self.curvatures(distance, half);
        let drop = (slope.abs() * half + 0.5 * sag * half * half) * (1.0 + 8.0 * f64::EPSILON);
        if value > drop || slope > bend * half {
            return IntervalVerdict::Free;
        }
        if -slope <= bend * half {
            return IntervalVerdict::Halve;
        }
        // F decreases throughout.
        let end = interval.begin.plus(&N::new(2.0 * half));
        if self.squared(&end).value.value() > 0.0 {
            IntervalVerdict::Free
        } else {
            IntervalVerdict::Zero(zero_between(self, interval.begin.clone(), end))
        }
    }

    /// F touches 0, to rounding: whether there is a contact is not decided.
    fn at_shortest(&self, _begin: N) -> SearchEnd<N> {
        SearchEnd::OutOfBudget
    }
}

/// The zero of F between two times, before which it is positive: Newton's method, with bisection
/// where a step leaves the bracket.
fn zero_between<N: Number>(pair: &FlyingPair, mut above: N, mut below: N) -> N {
    let half = N::new(0.5);
    let mut time = above.plus(&below).times(&half);
    for _ in 0..MAX_STEPS {
        let now = pair.squared(&time);
        if now.value.value() > 0.0 {
            above = time.clone();
        } else {
            below = time.clone();
        }
        let slope = now.rate.value();
        let step = if slope < 0.0 {
            now.value.over(&now.rate)
        } else {
            N::new(0.0)
        };
        let next = time.minus(&step);
        let inside =
            slope < 0.0 && next.minus(&above).value() > 0.0 && below.minus(&next).value() > 0.0;
        let next = if inside {
            next
        } else {
            above.plus(&below).times(&half)
        };
        let moved = next.minus(&time).value().abs();
        time = next;
        if moved <= 1e-30 * time.value().abs()
            || below.minus(&above).value() <= 1e-30 * time.value().abs()
        {
            break;
        }
    }
    time
}

/// Last time before `time` at which the atoms of a pair in deep contact began to touch; 0 if they
/// did from the start.
fn touch_before<N: Number>(plain: &FlyingPair, time: &N) -> N {
    let speed = plain.lipschitz;
    let mut back = 2.0 * plain.error_at(time.value()) / speed;
    for _ in 0..MAX_STEPS {
        let before = time.minus(&N::new(back));
        if before.value() <= 0.0 {
            let start = N::new(0.0);
            let apart = plain.squared(&start).value.value() > 0.0;
            return if apart {
                zero_between(plain, start, time.clone())
            } else {
                start
            };
        }
        if plain.squared(&before).value.value() > 0.0 {
            return zero_between(plain, before, time.clone());
        }
        back *= 2.0;
    }
    N::new(0.0)
}
