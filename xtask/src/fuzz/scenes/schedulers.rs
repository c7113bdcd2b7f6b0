//! Two schedulers find the same contacts, until chaos has made their trajectories different.

use super::{
    kinematics::{Pair, distance_in_box, length},
    watcher::Logged,
};
use crate::fuzz::subject::{Report, exceeds};

/// Relative deviation at which two trajectories count as different.
const SEPARATED: f64 = 1e-8;

/// How far ahead a contact may stand in the other list, where the times of two are the same to
/// rounding.
const AHEAD: usize = 8;

/// The scales of a scene.
#[derive(Debug, Clone, Copy)]
pub struct Scales {
    /// Sides of the box (length).
    pub sides: Pair,
    /// A typical speed (length per time).
    pub speed: f64,
    /// Up to when both have run (time).
    pub end: f64,
}

/// Compares two lists of contacts.
pub fn compare(one: &[Logged], other: &[Logged], scales: &Scales, report: &mut Report) {
    let side = scales.sides[0].max(scales.sides[1]);
    let unit = side / scales.speed;
    let mut other = other.to_vec();
    let mut deviation = 1e-15f64;
    let mut compared = 0;
    for (index, a) in one.iter().enumerate() {
        let Some(b) = other.get(index) else {
            unmatched(a, deviation, side, unit, scales, report);
            break;
        };
        if !is_same(a, b) {
            let Some(at) = find(a, &other[index..]) else {
                unmatched(if a.time <= b.time { a } else { b }, deviation, side, unit, scales, report);
                break;
            };
            let found = other[index + at].clone();
            let tie = (found.time - a.time).abs() + (found.time - b.time).abs();
            if tie > 1e3 * deviation * unit || shares(a, &other[index..index + at]) {
                // Contacts of one body that change places change the trajectory; others do so only
                // at one instant.
                if tie > 1e3 * deviation * unit && !is_graze(b, deviation, side) {
                    unmatched(b, deviation, side, unit, scales, report);
                }
                break;
            }
            other.remove(index + at);
            other.insert(index, found);
        }
        let b = &other[index];
        deviation = deviation.max((a.time - b.time).abs() / unit);
        for body in 0..2 {
            let off = distance_in_box(a.places[body], b.places[body], scales.sides);
            deviation = deviation.max(off / side);
            let [u, v] = [a.velocities[body], b.velocities[body]];
            deviation = deviation.max(length([u[0] - v[0], u[1] - v[1]]) / scales.speed.max(length(u)));
        }
        if exceeds(deviation, SEPARATED) {
            break;
        }
        compared += 1;
    }
    if compared == one.len()
        && let Some(extra) = other.get(compared)
    {
        unmatched(extra, deviation, side, unit, scales, report);
    }
    report.count("contacts in both", compared as u64);
}

fn is_same(a: &Logged, b: &Logged) -> bool {
    a.bodies == b.bodies && a.atoms == b.atoms
}

fn find(a: &Logged, list: &[Logged]) -> Option<usize> {
    list.iter().take(AHEAD).position(|b| is_same(a, b))
}

/// Whether a body of this contact takes part in one of those.
fn shares(a: &Logged, list: &[Logged]) -> bool {
    list.iter().any(|b| a.bodies.iter().any(|body| b.bodies.contains(body)))
}

/// Whether a contact is so flat that the deviation of the trajectories decides whether it takes
/// place.
fn is_graze(contact: &Logged, deviation: f64, side: f64) -> bool {
    // A dip of this depth: u² / (2 g'') with g'' ≤ w²/s.
    let depth = 100.0 * deviation * side;
    contact.approach <= contact.speed * (2.0 * depth / contact.distance).sqrt()
}

/// A contact that only one of the two has found.
fn unmatched(contact: &Logged, deviation: f64, side: f64, unit: f64, scales: &Scales, report: &mut Report) {
    let at_the_end = contact.time >= scales.end - 1e3 * deviation * unit;
    if !at_the_end && !is_graze(contact, deviation, side) {
        report.fail(
            "schedulers differ",
            format!("one of them alone has {contact:?}, where trajectories differ by {deviation:e}"),
        );
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
            })
            .collect()
    }

    fn failure(one: &[Logged], other: &[Logged]) -> Option<String> {
        let mut report = Report::default();
        let scales = Scales { sides: [1.0, 1.0], speed: 1.0, end: 1.0 };
        compare(one, other, &scales, &mut report);
        report.failure.map(|failure| failure.kind)
    }

    #[test]
    fn a_contact_that_one_scheduler_lacks_is_found_wherever_it_is() {
        assert_eq!(failure(&list(), &list()), None);
        for index in 0..6 {
            let mut less = list();
            less.remove(index);
            assert!(failure(&list(), &less).is_some(), "{index}");
            assert!(failure(&less, &list()).is_some(), "{index}");
        }
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
