//! Counts of missed, late, early and invented contacts: an interval is run twice from one state and
//! compared contact by contact.
//!
//! Trajectories separate soon after a single error, and the consequences of an error are not
//! errors. A body with a wrong contact is therefore excluded afterwards, with every body that it
//! meets; only contacts between unaffected bodies count.

use std::collections::VecDeque;

use anyhow::Result;
use carom::{CollisionReport, Observer, Scene, kinematics::EpochTime};
use serde::{Deserialize, Serialize};

use super::{Course, CourseState, Reached, Setting};
use crate::clock::Instant;

/// A contact with a larger time error is wrong (mean times between two collisions of a body).
/// Rounding errors grow by some orders of magnitude within a replay and stay below it.
pub const TOLERANCE: f64 = 1e-7;

/// A contact: its time and its bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayedContact {
    /// Time since the start of the interval.
    pub time: f64,
    /// Numbers of the two bodies.
    pub bodies: [u64; 2],
}

/// All contacts of an interval.
#[derive(Debug, Clone)]
pub struct ReplayLog {
    /// Start of the interval.
    pub begin: EpochTime,
    /// In order of time.
    pub contacts: Vec<ReplayedContact>,
    /// The deepest overlap at its end, in units of the smaller diameter, and the number of pairs
    /// that overlap by more than rounding.
    pub deepest: f64,
    /// See `deepest`.
    pub overlapping: usize,
}

impl Observer for ReplayLog {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let [a, b] = report.sides.each_ref().map(|side| side.body.id());
        let bodies = [a.min(b), a.max(b)];
        self.contacts.push(ReplayedContact {
            time: report.time.since(self.begin),
            bodies,
        });
    }
}

/// Counts over all intervals.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ReplayTally {
    /// Contacts judged.
    pub judged: u64,
    /// Contacts of the exact run that are absent.
    pub missed: u64,
    /// Contacts with a time error above the tolerance.
    pub off: u64,
    /// Contacts that the exact run does not have.
    pub invented: u64,
    /// Largest |Δt| of the correct contacts (mean times between two collisions of a body).
    pub largest: f64,
    /// Deepest overlap at the end of an interval, in units of the smaller diameter; may be due to
    /// rounding.
    pub deepest: f64,
    /// Largest number of pairs that overlap by more than rounding at the end of an interval.
    pub overlapping: usize,
    /// Number of intervals.
    pub intervals: u64,
}

impl ReplayTally {
    /// Wrong contacts in a million.
    pub fn wrong(&self) -> f64 {
        self.million(self.missed + self.off + self.invented)
    }

    /// A count relative to the judged contacts, in a million.
    pub fn million(&self, count: u64) -> f64 {
        1e6 * count as f64 / self.judged.max(1) as f64
    }

    /// The counts in words.
    pub fn words(&self) -> String {
        let judged = self.judged;
        if judged == 0 {
            return "no contact was judged".to_owned();
        }
        if self.wrong() == 0.0 {
            return format!(
                "none of {judged} contacts is wrong, so fewer than {:.1e} are (95 %)",
                1e-6 * self.upper_bound_of_none()
            );
        }
        format!(
            "of {judged} contacts {} are missed, {} late or early, and {} invented",
            self.missed, self.off, self.invented
        )
    }

    /// Upper end of the 95 % confidence interval if none is wrong: 3/n (Hanley and Lippman-Hand
    /// 1983), in a million.
    pub fn upper_bound_of_none(&self) -> f64 {
        3e6 / self.judged.max(1) as f64
    }
}

/// Records the contacts of a setting from a state for `duration` (time); `None` if the time allowed
/// passes before.
///
/// # Errors
/// The run fails.
pub fn interval(
    scene: &Scene,
    setting: &Setting,
    state: &CourseState,
    duration: f64,
    deadline: Instant,
) -> Result<Option<ReplayLog>> {
    let mut course = Course::resume(scene, setting, state)?;
    let begin = state.checkpoint().time();
    let mut log = ReplayLog {
        begin,
        contacts: Vec::new(),
        deepest: 0.0,
        overlapping: 0,
    };
    if course.run_to(state.time() + duration, &mut log, deadline)? == Reached::Deadline {
        return Ok(None);
    }
    let census = course.simulation().view().overlaps();
    (log.deepest, log.overlapping) = (census.deepest, census.pairs);
    Ok(Some(log))
}

/// Compares an interval with that of the exact run, and adds the result to the counts; `tau` is the
/// mean time between two collisions of a body (time).
pub fn add(exact: &ReplayLog, other: &ReplayLog, duration: f64, tau: f64, tally: &mut ReplayTally) {
    let mut own = ReplayTally::default();
    compare(exact, other, duration, TOLERANCE * tau, &mut own);
    tally.judged += own.judged;
    tally.missed += own.missed;
    tally.off += own.off;
    tally.invented += own.invented;
    tally.largest = tally.largest.max(own.largest / tau);
    tally.deepest = tally.deepest.max(other.deepest);
    tally.overlapping = tally.overlapping.max(other.overlapping);
    tally.intervals += 1;
}

/// Compares two intervals of equal duration; times may differ by `tolerance` (time).
fn compare(
    exact: &ReplayLog,
    other: &ReplayLog,
    duration: f64,
    tolerance: f64,
    tally: &mut ReplayTally,
) {
    let mut pending = PendingContacts::new(exact, other);
    for contact in &exact.contacts {
        if pending.are_unaffected(contact.bodies) {
            match pending.next_of(contact.bodies[0]) {
                Some((found, true)) if found.bodies == contact.bodies => {
                    tally.judged += 1;
                    let off = (found.time - contact.time).abs();
                    if off <= tolerance {
                        tally.largest = tally.largest.max(off);
                        pending.pass(contact.bodies);
                        continue;
                    }
                    tally.off += 1;
                }
                _ => pending.judge_absent(contact, tally),
            }
        }
        pending.spoil(contact.bodies);
    }
    for body in 0..pending.queues.len() as u64 {
        if let Some((found, true)) = pending.next_of(body)
            && found.time < duration - tolerance
            && pending.are_unaffected(found.bodies)
        {
            tally.judged += 1;
            tally.invented += 1;
            pending.spoil(found.bodies);
        }
    }
}

/// The contacts of a compared interval that are still to come, and the bodies that an error has
/// affected.
struct PendingContacts<'a> {
    contacts: &'a [ReplayedContact],
    /// Indices of the contacts of each body, in order of time.
    queues: Vec<VecDeque<usize>>,
    /// Whether each body is affected.
    spoilt: Vec<bool>,
}

impl<'a> PendingContacts<'a> {
    /// All contacts of the compared interval, before any error.
    fn new(exact: &ReplayLog, other: &'a ReplayLog) -> Self {
        let all = exact.contacts.iter().chain(&other.contacts);
        let bodies = all
            .map(|contact| contact.bodies[1] as usize + 1)
            .max()
            .unwrap_or(0);
        let mut queues = vec![VecDeque::new(); bodies];
        for (index, contact) in other.contacts.iter().enumerate() {
            for body in contact.bodies {
                queues[body as usize].push_back(index);
            }
        }
        Self {
            contacts: &other.contacts,
            queues,
            spoilt: vec![false; bodies],
        }
    }

    /// The next contact of a body, and whether it is the next of its partner as well.
    fn next_of(&self, body: u64) -> Option<(ReplayedContact, bool)> {
        let index = *self.queues[body as usize].front()?;
        let contact = self.contacts[index];
        let mutual = contact
            .bodies
            .iter()
            .all(|&body| self.queues[body as usize].front() == Some(&index));
        Some((contact, mutual))
    }

    /// Whether no error has affected any of these bodies.
    fn are_unaffected(&self, bodies: [u64; 2]) -> bool {
        bodies.iter().all(|&body| !self.spoilt[body as usize])
    }

    /// Excludes bodies that an error has affected.
    fn spoil(&mut self, bodies: [u64; 2]) {
        for body in bodies {
            self.spoilt[body as usize] = true;
        }
    }

    /// Passes the next contact of these bodies.
    fn pass(&mut self, bodies: [u64; 2]) {
        for body in bodies {
            self.queues[body as usize].pop_front();
        }
    }

    /// Judges a contact of the exact run that is not the next one here: it is missed, unless one of
    /// its bodies meets another before, which is then invented.
    fn judge_absent(&mut self, contact: &ReplayedContact, tally: &mut ReplayTally) {
        let before = contact
            .bodies
            .into_iter()
            .filter_map(|body| self.next_of(body));
        let earlier: Vec<(ReplayedContact, bool)> = before
            .filter(|(found, _)| found.time < contact.time)
            .collect();
        if earlier.is_empty() {
            tally.judged += 1;
            tally.missed += 1;
        }
        for (found, mutual) in earlier {
            let clean = self.are_unaffected(found.bodies);
            tally.judged += u64::from(mutual && clean);
            tally.invented += u64::from(mutual && clean);
            self.spoil(found.bodies);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tally(exact: &[(f64, u64, u64)], other: &[(f64, u64, u64)]) -> ReplayTally {
        let log = |list: &[(f64, u64, u64)]| ReplayLog {
            begin: EpochTime::ZERO,
            contacts: list
                .iter()
                .map(|&(time, a, b)| ReplayedContact {
                    time,
                    bodies: [a, b],
                })
                .collect(),
            deepest: 0.0,
            overlapping: 0,
        };
        let mut tally = ReplayTally::default();
        compare(&log(exact), &log(other), 10.0, 1e-6, &mut tally);
        tally
    }

    #[test]
    fn consequences_of_an_error_are_not_counted() {
        let exact = [(1.0, 0, 1), (2.0, 2, 3), (3.0, 1, 2), (4.0, 4, 5)];
        let right = tally(&exact, &exact);
        assert_eq!(
            (right.judged, right.missed, right.off, right.invented),
            (4, 0, 0, 0)
        );
        // Without the first contact, body 1 continues and meets 4; body 2 is not met.
        let missed = tally(&exact, &[(2.0, 2, 3), (3.5, 1, 4)]);
        assert_eq!(
            (missed.judged, missed.missed, missed.off, missed.invented),
            (2, 1, 0, 0)
        );
        let late = tally(
            &exact,
            &[(1.5, 0, 1), (2.0, 2, 3), (3.1, 1, 2), (4.0, 4, 5)],
        );
        assert_eq!(
            (late.judged, late.missed, late.off, late.invented),
            (3, 0, 1, 0)
        );
        let invented = tally(
            &exact,
            &[
                (0.5, 6, 7),
                (1.0, 0, 1),
                (2.0, 2, 3),
                (3.0, 1, 2),
                (4.0, 4, 5),
            ],
        );
        assert_eq!(
            (
                invented.judged,
                invented.missed,
                invented.off,
                invented.invented
            ),
            (5, 0, 0, 1)
        );
        let before = tally(&exact, &[(0.5, 0, 6), (2.0, 2, 3), (4.0, 4, 5)]);
        assert_eq!((before.missed, before.off, before.invented), (0, 0, 1));
    }
}
