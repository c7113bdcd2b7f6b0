//! Comparison of two schedulers: they find the same contacts until chaos separates their
//! trajectories.

use std::slice;

use super::{
    kinematics::{BodyPair, distance_in_box, length},
    watcher::Logged,
};
use crate::fuzz::subject::{Report, exceeds};

/// Relative deviation at which two trajectories count as different.
const SEPARATED: f64 = 1e-8;

/// Largest shift of a contact in the other list, for contacts whose times are equal up to rounding.
const AHEAD: usize = 8;

/// The scales of a scene.
#[derive(Debug, Clone, Copy)]
pub struct Scales {
    /// Sides of the box (length).
    pub sides: BodyPair,
    /// A typical speed (length per time).
    pub speed: f64,
    /// Time up to which both have run (time).
    pub end: f64,
}

/// Compares two lists of contacts.
pub fn compare(one: &[Logged], other: &[Logged], scales: &Scales, report: &mut Report) {
    let side = scales.sides[0].max(scales.sides[1]);
    let mut judge = Judge {
        deviation: 1e-15,
        side,
        unit: side / scales.speed,
        end: scales.end,
    };
    // In the order of comparison; equal times may change it.
    let mut list = other.to_vec();
    let mut compared = 0;
    for (index, a) in one.iter().enumerate() {
        let Some(b) = list.get(index) else {
            judge.unmatched(a, &list, index, report);
            break;
        };
        if !is_same(a, b) {
            let at = list[index..]
                .iter()
                .take(AHEAD)
                .position(|later| is_same(a, later));
            let Some(at) = at.filter(|&at| judge.is_tie([a, b, &list[index + at]])) else {
                if a.time <= b.time {
                    judge.unmatched(a, &list, index, report);
                } else {
                    judge.unmatched(b, one, index, report);
                }
                break;
            };
            if shares(a, &list[index..index + at]) {
                // A different order of contacts of one body changes its trajectory.
                break;
            }
            let found = list.remove(index + at);
            list.insert(index, found);
        }
        judge.raise_deviation(a, &list[index], scales);
        if exceeds(judge.deviation, SEPARATED) {
            break;
        }
        compared += 1;
    }
    if compared == one.len()
        && let Some(extra) = list.get(compared)
    {
        judge.unmatched(extra, one, compared, report);
    }
    report.count("contacts in both", compared as u64);
}

fn is_same(a: &Logged, b: &Logged) -> bool {
    a.bodies == b.bodies && a.atoms == b.atoms
}

/// Returns true if a body of this contact takes part in one of the list.
fn shares(a: &Logged, list: &[Logged]) -> bool {
    list.iter()
        .any(|b| a.bodies.iter().any(|body| b.bodies.contains(body)))
}

/// Returns true if a contact is so grazing that the deviation of the trajectories decides whether
/// it occurs.
fn is_graze(contact: &Logged, deviation: f64, side: f64) -> bool {
    // An overlap of this depth: u² / (2 g'') with g'' ≤ w²/s + a.
    let depth = 100.0 * deviation * side;
    let of_speed = contact.speed * (2.0 * depth / contact.distance).sqrt();
    contact.approach <= of_speed.hypot((2.0 * depth * contact.acceleration).sqrt())
}

/// Deviation of two trajectories, and the scales of the scene.
struct Judge {
    deviation: f64,
    side: f64,
    unit: f64,
    end: f64,
}

impl Judge {
    /// Raises the deviation to that of two reports of one contact, if this is larger.
    fn raise_deviation(&mut self, a: &Logged, b: &Logged, scales: &Scales) {
        let mut deviation = self.deviation.max((a.time - b.time).abs() / self.unit);
        for body in 0..2 {
            let off = distance_in_box(a.places[body], b.places[body], scales.sides);
            deviation = deviation.max(off / self.side);
            let [u, v] = [a.velocities[body], b.velocities[body]];
            deviation =
                deviation.max(length([u[0] - v[0], u[1] - v[1]]) / scales.speed.max(length(u)));
        }
        self.deviation = deviation;
    }

    /// Contacts closer in time than this may change their order (time).
    fn resolution(&self) -> f64 {
        1e3 * self.deviation * self.unit
    }

    fn is_tie(&self, [a, b, found]: [&Logged; 3]) -> bool {
        (found.time - a.time).abs() + (found.time - b.time).abs() <= self.resolution()
    }

    /// Reports a contact that is missing in the other list, whose first `matched` contacts are in
    /// both, unless it is a graze or after the end of the other run. Chattering bodies may have
    /// more or fewer contacts before it. Where a body touches two others at one instant, rounding
    /// decides the order, and the first contact may prevent the second.
    fn unmatched(&self, contact: &Logged, other: &[Logged], matched: usize, report: &mut Report) {
        let at_the_end = contact.time >= self.end - self.resolution();
        let nearby = |found: &&Logged| (found.time - contact.time).abs() <= self.resolution();
        let there = other
            .iter()
            .filter(nearby)
            .any(|found| found.bodies == contact.bodies);
        let mut rivals = other[matched..].iter().filter(nearby);
        let is_tied = rivals.any(|rival| shares(contact, slice::from_ref(rival)));
        if !at_the_end && !there && !is_tied && !is_graze(contact, self.deviation, self.side) {
            let next = other
                .iter()
                .find(|found| found.time >= contact.time - self.resolution());
            report.fail(
                "schedulers differ",
                format!(
                    "only one of them has {contact:?}, where trajectories differ by {:e}; the next \
                     contact of the other is {next:?}",
                    self.deviation
                ),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list() -> Vec<Logged> {
        (1..=6)
            .map(|index| Logged {
                time: 0.1 * f64::from(index),
                bodies: [u64::from(index as u32 % 3), 3],
                atoms: [Some(0), Some(0)],
                places: [[0.5, 0.5], [0.6, 0.5]],
                velocities: [[1.0, 0.0], [0.0, 1.0]],
                approach: 0.5,
                speed: 1.0,
                distance: 0.1,
                acceleration: 0.0,
            })
            .collect()
    }

    fn failure(one: &[Logged], other: &[Logged]) -> Option<String> {
        let mut report = Report::default();
        let scales = Scales {
            sides: [1.0, 1.0],
            speed: 1.0,
            end: 1.0,
        };
        compare(one, other, &scales, &mut report);
        report.failure.map(|failure| failure.kind)
    }

    #[test]
    fn a_contact_missing_in_one_scheduler_is_found_anywhere() {
        assert_eq!(failure(&list(), &list()), None);
        for index in 0..6 {
            let mut less = list();
            less.remove(index);
            assert!(failure(&list(), &less).is_some(), "{index}");
            assert!(failure(&less, &list()).is_some(), "{index}");
        }
    }

    /// Body 3 touches body 1 and body 2 at one instant. One scheduler resolves the contact with
    /// body 1 first, after which body 2 still approaches; the other resolves that with body 2
    /// first, which separates body 3 from body 1.
    #[test]
    fn a_contact_prevented_by_a_simultaneous_one_is_no_failure() {
        let contact = |time, first| Logged {
            time,
            bodies: [first, 3],
            ..list()[0].clone()
        };
        let longer = [contact(0.1, 1), contact(0.2, 1), contact(0.2 + 1e-15, 2)];
        let shorter = [contact(0.1, 1), contact(0.2 + 1e-15, 2)];
        assert_eq!(failure(&longer, &shorter), None);
        assert_eq!(failure(&shorter, &longer), None);
        // Bodies of no common contact, or contacts farther apart than the resolution, are no tie.
        let apart = |bodies, time| {
            [
                contact(0.1, 1),
                Logged {
                    time,
                    bodies,
                    ..contact(time, 2)
                },
            ]
        };
        let lost = |shorter: &[Logged]| failure(&longer[..2], shorter).is_some();
        assert!(lost(&apart([4, 5], 0.2)) && lost(&apart([2, 3], 0.2 + 1e-9)));
        assert!(!lost(&apart([2, 3], 0.2)));
    }

    #[test]
    fn grazes_and_separated_trajectories_are_no_failures() {
        let mut graze = list();
        graze[3].approach = 1e-9;
        let mut less = list();
        less.remove(3);
        assert_eq!(failure(&graze, &less), None);
        let mut apart = list();
        apart[1].velocities[0][0] += 1e-6;
        apart.truncate(3);
        assert_eq!(failure(&list(), &apart), None);
    }
}
