//! Verdicts on the answers of detectors.

use carom_detection::{Answer, Contact, ErrorBound, Outcome, Part, Touch, encounters::Encounter};
use serde::{Deserialize, Serialize};

use super::{
    ExclusionReference, Number, edge::OracleEdgePair, exclusion::Deep, flight::FlyingPair,
};

/// Comparison of an answer with the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum OracleVerdict {
    /// The first contact, or correctly none.
    Right,
    /// A contact no deeper than 2 E was reported; both reporting and omitting it are correct.
    Graze,
    /// A contact deeper than 2 E was not reported.
    Missed,
    /// It was reported after the overlap exceeded 2 E.
    Late,
    /// A contact was reported while the atoms were more than 2 E apart or separating; one follows
    /// later.
    Early,
    /// A contact was reported, but there is none up to the horizon.
    False,
    /// "Certified free until" a time, correctly.
    FreeUntil,
    /// The detector returned "unresolved".
    GaveUp,
}

/// A verdict and the error of the time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// The verdict.
    pub verdict: OracleVerdict,
    /// |t − t*| in natural times, if a contact exists and was reported.
    pub deviation: Option<f64>,
}

impl<N: Number> ExclusionReference<N> {
    /// Judges an answer; `None` if the oracle found no result.
    pub fn judge(&self, encounter: &Encounter, answer: &Answer) -> Option<Judgement> {
        let deep = match self {
            Self::Unresolved => return None,
            Self::Free => None,
            Self::Deep(deep) => Some(deep),
        };
        let passed =
            |time: f64| deep.is_some_and(|deep| N::new(time).minus(&deep.time).value() > 0.0);
        let plain = |verdict| Judgement {
            verdict,
            deviation: None,
        };
        Some(match answer.outcome {
            Outcome::Unresolved(_) | Outcome::OutOfRange => plain(OracleVerdict::GaveUp),
            Outcome::FreeUntil(time) if passed(time) => plain(OracleVerdict::Missed),
            Outcome::FreeUntil(_) => plain(OracleVerdict::FreeUntil),
            Outcome::Free if deep.is_some() => plain(OracleVerdict::Missed),
            Outcome::Free => plain(OracleVerdict::Right),
            Outcome::Contact(contact) => {
                let time = N::new(contact.time);
                let off = deep.map(|deep| time.minus(&deep.touch).value());
                let verdict = if passed(contact.time) {
                    OracleVerdict::Late
                } else if !touches(encounter, &time, contact.touch) {
                    if deep.is_some() {
                        OracleVerdict::Early
                    } else {
                        OracleVerdict::False
                    }
                } else if deep.is_some_and(|deep| is_of(encounter, deep, &time)) {
                    OracleVerdict::Right
                } else {
                    OracleVerdict::Graze
                };
                let counts = matches!(
                    verdict,
                    OracleVerdict::Right | OracleVerdict::Late | OracleVerdict::Early
                );
                let deviation = off
                    .filter(|_| counts)
                    .map(|off| off.abs() / encounter.natural_time());
                Judgement { verdict, deviation }
            }
        })
    }
}

/// First derivative and curvature bound of the gap in double precision, which suffices here.
struct Approach {
    rate: f64,
    curvature: f64,
}

fn approach<N: Number>(pair: &FlyingPair, time: &N) -> Approach {
    let moment = pair.moment(time);
    let [x, y] = moment.d.map(|component| component.value());
    let [u, v] = moment.rate.map(|component| component.value());
    let distance = x.hypot(y);
    let rate = (x * u + y * v) / distance;
    let turning = (u * u + v * v - rate * rate).max(0.0) / distance;
    Approach {
        rate,
        curvature: pair.curvature + turning,
    }
}

/// Returns true if the reported parts touch to within 2 E and do not separate faster than they
/// would leave an overlap of that depth.
fn touches<N: Number>(encounter: &Encounter, time: &N, touch: Touch) -> bool {
    let [a, b] = &encounter.molecules;
    let within = |i: usize, j: usize| {
        let pair = FlyingPair::new(encounter, (i, j));
        let error = 2.0 * pair.error_at(time.value());
        if pair.gap(time).value() > error {
            return false;
        }
        let approach = approach(&pair, time);
        let distance = pair.radii[0] + pair.radii[1];
        let bound = ErrorBound::new(&encounter.motion, &a.atoms()[i], &b.atoms()[j]);
        approach.rate
            <= bound.of_rate(time.value(), distance) + (2.0 * approach.curvature * error).sqrt()
    };
    match touch {
        Touch::Atoms(i, j) => within(i as usize, j as usize),
        Touch::BoundingCircles => {
            (0..a.atoms().len()).any(|i| (0..b.atoms().len()).any(|j| within(i, j)))
        }
        Touch::EdgeOfA { edge, part } => touches_edge(encounter, time, 1, part, edge),
        Touch::EdgeOfB { edge, part } => touches_edge(encounter, time, 0, part, edge),
    }
}

/// Returns true if a part of body number `body` touches an edge of the other body to within 2 E and
/// does not separate faster than it would leave an overlap of that depth.
fn touches_edge<N: Number>(
    encounter: &Encounter,
    time: &N,
    body: usize,
    part: Part,
    edge: u32,
) -> bool {
    let within = |index: usize| {
        OracleEdgePair::new(encounter, body, index, edge as usize).is_some_and(|pair| {
            let error = 2.0 * pair.error_at(time.value());
            let sight = pair.sight(time);
            let [gap, rate] = sight.across.map(|number| number.value());
            let parting =
                pair.rate_error_at(time.value()) + (2.0 * pair.curvature() * error).sqrt();
            gap <= error && sight.beyond[0].value() <= error && rate <= parting
        })
    };
    match part {
        Part::Atom(index) => within(index as usize),
        Part::BoundingCircle => (0..encounter.molecules[body].atoms().len()).any(within),
    }
}

/// Returns true if a time not later than the deep contact belongs to it or to a preceding graze:
/// the zeros of g' h + g'' h²/2 = ±2 E lie within 4 E/max(|g'|, √(4 |g''| E)) of 0.
fn is_of<N: Number>(encounter: &Encounter, deep: &Deep<N>, time: &N) -> bool {
    let of_edge = match deep.parts {
        Touch::EdgeOfA { edge, part } => edge_pair(encounter, 1, part, edge),
        Touch::EdgeOfB { edge, part } => edge_pair(encounter, 0, part, edge),
        Touch::Atoms(..) | Touch::BoundingCircles => None,
    };
    let (error, approach) = match (deep.parts, of_edge) {
        (_, Some(pair)) => {
            let rate = pair.sight(&deep.touch).across[1].value();
            (
                2.0 * pair.error_at(deep.touch.value()),
                Approach {
                    rate,
                    curvature: pair.curvature(),
                },
            )
        }
        (Touch::Atoms(i, j), None) => {
            let pair = FlyingPair::new(encounter, (i as usize, j as usize));
            (
                2.0 * pair.error_at(deep.touch.value()),
                approach(&pair, &deep.touch),
            )
        }
        _ => return false,
    };
    let tolerance = 2.0 * error
        / approach
            .rate
            .abs()
            .max((2.0 * approach.curvature * error).sqrt());
    deep.touch.minus(time).value() <= 2.0 * tolerance
}

/// An atom of body number `body` and an edge of the other body.
fn edge_pair(
    encounter: &Encounter,
    body: usize,
    part: Part,
    edge: u32,
) -> Option<OracleEdgePair<'_>> {
    match part {
        Part::Atom(index) => OracleEdgePair::new(encounter, body, index as usize, edge as usize),
        Part::BoundingCircle => None,
    }
}

/// The gap of the reported parts at the reported time, in units of E; `None` for bounding circles.
pub fn gap_over_bound<N: Number>(encounter: &Encounter, contact: &Contact) -> Option<f64> {
    let time = N::new(contact.time);
    let of_pair = |pair: OracleEdgePair<'_>| {
        pair.sight(&time).across[0].value() / pair.error_at(contact.time)
    };
    match contact.touch {
        Touch::Atoms(i, j) => {
            let pair = FlyingPair::new(encounter, (i as usize, j as usize));
            Some(pair.gap(&time).value() / pair.error_at(contact.time))
        }
        Touch::EdgeOfA { edge, part } => edge_pair(encounter, 1, part, edge).map(of_pair),
        Touch::EdgeOfB { edge, part } => edge_pair(encounter, 0, part, edge).map(of_pair),
        Touch::BoundingCircles => None,
    }
}
