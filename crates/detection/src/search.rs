//! The intermediate result of a search over many atom pairs.

use crate::{Answer, Contact, Outcome, Touch, trace::Recorder};

/// The result of the search for one pair of parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PairOutcome {
    /// The parts touch at this time.
    Contact(f64),
    /// The parts do not touch before the limit.
    Free,
    /// The step limit is reached; the parts do not touch before this time.
    OutOfBudget(f64),
    /// The search is interrupted; the parts do not touch before this time, which is later than the
    /// bound of another pair.
    Paused(f64),
}

/// The earliest contact and the earliest certified time so far, and the limits of the search.
pub(crate) struct Search<R, T = Touch> {
    end: f64,
    best: Option<Contact<T>>,
    out_of_budget: f64,
    pub(crate) most_steps: u32,
    pub(crate) evaluations: u32,
    pub(crate) recorder: R,
}

impl<R: Recorder> Search<R> {
    /// Records the result of the search for one pair of atoms.
    pub(crate) fn record(&mut self, outcome: PairOutcome, atoms: [u32; 2]) {
        self.record_touch(outcome, Touch::Atoms(atoms[0], atoms[1]));
    }
}

impl<R: Recorder, T: Copy + PartialOrd> Search<R, T> {
    pub(crate) fn new(end: f64, most_steps: u32, recorder: R) -> Self {
        Self {
            end,
            best: None,
            out_of_budget: f64::INFINITY,
            most_steps,
            evaluations: 0,
            recorder,
        }
    }

    /// Nothing after this time can change the answer.
    #[inline]
    pub(crate) fn limit(&self) -> f64 {
        let found = self.best.map_or(self.end, |best| best.time);
        found.min(self.out_of_budget)
    }

    /// Records the result of the search for one pair of parts.
    pub(crate) fn record_touch(&mut self, outcome: PairOutcome, touch: T) {
        match outcome {
            PairOutcome::Contact(time) => {
                let earlier = |best: Contact<T>| {
                    time < best.time || (time == best.time && touch < best.touch)
                };
                if self.best.is_none_or(earlier) {
                    self.best = Some(Contact { time, touch });
                }
            }
            PairOutcome::Free | PairOutcome::Paused(_) => {}
            PairOutcome::OutOfBudget(time) => self.out_of_budget = self.out_of_budget.min(time),
        }
    }

    /// The answer. A pair that is only certified up to a time takes precedence over a later
    /// contact.
    pub(crate) fn answer(&self) -> Answer<T> {
        let outcome = match self.best {
            Some(contact) if contact.time <= self.out_of_budget => Outcome::Contact(contact),
            _ if self.out_of_budget <= self.end => Outcome::FreeUntil(self.out_of_budget),
            _ => Outcome::Free,
        };
        Answer {
            outcome,
            evaluations: self.evaluations,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_earlier_of_certified_time_and_contact_is_the_answer() {
        for (contact, expected) in [(2.0, Outcome::FreeUntil(1.0)), (0.5, contact_at(0.5))] {
            for contact_first in [true, false] {
                let mut search = Search::new(10.0, 1, ());
                let mut findings = [PairOutcome::Contact(contact), PairOutcome::OutOfBudget(1.0)];
                if !contact_first {
                    findings.reverse();
                }
                for finding in findings {
                    search.record(finding, [0, 0]);
                }
                assert_eq!(search.limit(), contact.min(1.0));
                assert_eq!(search.answer().outcome, expected);
            }
        }
    }

    fn contact_at(time: f64) -> Outcome {
        Outcome::Contact(Contact {
            time,
            touch: Touch::Atoms(0, 0),
        })
    }
}
