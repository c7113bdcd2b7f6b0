//! Counts of missed, late, early and invented contacts: an interval is run twice from one state and
//! compared contact by contact.
//!
//! Trajectories separate soon after a single error, and the consequences of an error are not
//! errors. A body with a wrong contact is therefore excluded afterwards, with every body that it
//! meets; only contacts between unaffected bodies count.

use anyhow::Result;
use carom::Checkpoint;

use super::{
    knobs::Setting,
    observers::{Contact, Log},
};

/// Counts over all intervals.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    /// Contacts judged.
    pub judged: u64,
    /// Contacts of the exact run that are absent.
    pub missed: u64,
    /// Contacts with a time error above the tolerance.
    pub off: u64,
    /// Contacts that the exact run does not have.
    pub invented: u64,
    /// Largest |Δt| of the correct contacts (time).
    pub largest: f64,
}

impl Tally {
    /// Wrong contacts in a million.
    pub fn wrong(&self) -> f64 {
        self.million(self.missed + self.off + self.invented)
    }

    /// A count relative to the judged contacts, in a million.
    pub fn million(&self, count: u64) -> f64 {
        1e6 * count as f64 / self.judged.max(1) as f64
    }

    /// Upper end of the 95 % confidence interval if none is wrong: 3/n (Hanley and Lippman-Hand
    /// 1983), in a million.
    pub fn upper_bound_of_none(&self) -> f64 {
        3e6 / self.judged.max(1) as f64
    }
}

/// Records the contacts of a setting from a state for `duration`.
///
/// # Errors
/// The run fails.
pub fn stretch(setting: &Setting, state: &Checkpoint, duration: f64) -> Result<Log> {
    let mut simulation = setting.resume(state)?;
    let mut log = Log { begin: state.time(), contacts: Vec::new() };
    simulation.observe_until(state.time().to_f64() + duration, &mut log)?;
    Ok(log)
}

/// Compares two intervals of equal duration; times may differ by `tolerance` (time).
pub fn compare(exact: &Log, other: &Log, duration: f64, tolerance: f64, tally: &mut Tally) {
    let all = exact.contacts.iter().chain(&other.contacts);
    let bodies = all.map(|contact| contact.bodies[1] as usize + 1).max().unwrap_or(0);
    let mut queues = vec![std::collections::VecDeque::new(); bodies];
    for (index, contact) in other.contacts.iter().enumerate() {
        contact.bodies.iter().for_each(|&body| queues[body as usize].push_back(index));
    }
    let mut spoilt = vec![false; bodies];
    // The contact that is next for both of its bodies, if there is one.
    let next = |queues: &[std::collections::VecDeque<usize>], body: u64| {
        let index = *queues[body as usize].front()?;
        let contact = other.contacts[index];
        let mutual = contact.bodies.iter().all(|&body| queues[body as usize].front() == Some(&index));
        Some((contact, mutual))
    };
    for contact in &exact.contacts {
        let [a, b] = contact.bodies;
        if !spoilt[a as usize] && !spoilt[b as usize] {
            match next(&queues, a) {
                Some((found, true)) if found.bodies == contact.bodies => {
                    tally.judged += 1;
                    let off = (found.time - contact.time).abs();
                    if off <= tolerance {
                        tally.largest = tally.largest.max(off);
                        for body in [a, b] {
                            queues[body as usize].pop_front();
                        }
                        continue;
                    }
                    tally.off += 1;
                }
                _ => {
                    let before = [a, b].into_iter().filter_map(|body| next(&queues, body));
                    let earlier: Vec<(Contact, bool)> =
                        before.filter(|(found, _)| found.time < contact.time).collect();
                    if earlier.is_empty() {
                        tally.judged += 1;
                        tally.missed += 1;
                    }
                    for (found, mutual) in earlier {
                        let clean = found.bodies.iter().all(|&body| !spoilt[body as usize]);
                        tally.judged += u64::from(mutual && clean);
                        tally.invented += u64::from(mutual && clean);
                        found.bodies.iter().for_each(|&body| spoilt[body as usize] = true);
                    }
                }
            }
        }
        (spoilt[a as usize], spoilt[b as usize]) = (true, true);
    }
    for body in 0..bodies as u64 {
        if let Some((found, true)) = next(&queues, body)
            && found.time < duration - tolerance
            && found.bodies.iter().all(|&body| !spoilt[body as usize])
        {
            tally.judged += 1;
            tally.invented += 1;
            found.bodies.iter().for_each(|&body| spoilt[body as usize] = true);
        }
    }
}

#[cfg(test)]
mod tests {
    use carom::kinematics::EpochTime;

    use super::*;

    fn tally(exact: &[(f64, u64, u64)], other: &[(f64, u64, u64)]) -> Tally {
        let log = |list: &[(f64, u64, u64)]| Log {
            begin: EpochTime::ZERO,
            contacts: list.iter().map(|&(time, a, b)| Contact { time, bodies: [a, b] }).collect(),
        };
        let mut tally = Tally::default();
        compare(&log(exact), &log(other), 10.0, 1e-6, &mut tally);
        tally
    }

    #[test]
    fn consequences_of_an_error_are_not_counted() {
        let exact = [(1.0, 0, 1), (2.0, 2, 3), (3.0, 1, 2), (4.0, 4, 5)];
        let right = tally(&exact, &exact);
        assert_eq!((right.judged, right.missed, right.off, right.invented), (4, 0, 0, 0));
        // Without the first contact, body 1 continues and meets 4; body 2 is not met.
        let missed = tally(&exact, &[(2.0, 2, 3), (3.5, 1, 4)]);
        assert_eq!((missed.judged, missed.missed, missed.off, missed.invented), (2, 1, 0, 0));
        let late = tally(&exact, &[(1.5, 0, 1), (2.0, 2, 3), (3.1, 1, 2), (4.0, 4, 5)]);
        assert_eq!((late.judged, late.missed, late.off, late.invented), (3, 0, 1, 0));
        let invented = tally(&exact, &[(0.5, 6, 7), (1.0, 0, 1), (2.0, 2, 3), (3.0, 1, 2), (4.0, 4, 5)]);
        assert_eq!((invented.judged, invented.missed, invented.off, invented.invented), (5, 0, 0, 1));
        let before = tally(&exact, &[(0.5, 0, 6), (2.0, 2, 3), (4.0, 4, 5)]);
        assert_eq!((before.missed, before.off, before.invented), (0, 0, 1));
    }
}
