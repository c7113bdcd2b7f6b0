//! What has happened so far: counts of events, and the books of energy.

use std::ops::Add;

use serde::{Deserialize, Serialize};

/// Counts of events since the system was built; an edit at a sample resets none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counters {
    /// Contacts between two bodies, fixed ones included.
    pub collisions: u64,
    /// Of these, contacts with a fixed body.
    pub fixed_collisions: u64,
    /// Contacts whose impulse the guard against inelastic collapse has changed
    /// ([`ElasticitySpec::contact_time`](crate::ElasticitySpec::contact_time)), by however little.
    /// Their energy is in [`Ledger::spared`]. Contacts of a response that ignores the raised
    /// elasticity are not counted.
    pub guarded_collisions: u64,
    /// Epochs begun: stretches of time at the start of which everything is predicted anew.
    pub epochs: u64,
    /// Work of the scheduler.
    pub scheduler: SchedulerCounters,
}

/// What a scheduler did to find the contacts.
///
/// These are counts of work: they depend on the scheduler, not on the trajectory alone. How it is told apart what costs
/// time: many crossings, and the cells are too small; many stale predictions, and the gas is dense; many re-checks, and
/// molecules fly long at a small gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct SchedulerCounters {
    /// Bodies that entered another cell. Those that cover several cells of [`CellScheduler`](crate::CellScheduler) are not among them.
    pub crossings: u64,
    /// Predictions that came up after a partner had changed its motion. [`HeapScheduler`](crate::HeapScheduler) drops them, and has one for
    /// each pair; [`CellScheduler`](crate::CellScheduler) predicts the body anew, and has one for each body.
    pub stale: u64,
    /// Times at which a search was taken up again that had ended "certified free until" or without certainty. Fewer than
    /// there were such searches: a body that meets another before is predicted anew in any case.
    pub rechecks: u64,
    /// Searches that ended without certainty; always 0 with the exact detector.
    pub unresolved: u64,
    /// Pairs asked for their first contact. Those in the loop over small discs of [`CellScheduler`](crate::CellScheduler) are not counted:
    /// counting would take a share of the time that asking takes.
    pub pairs: u64,
}

impl Add for SchedulerCounters {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            crossings: self.crossings + other.crossings,
            stale: self.stale + other.stale,
            rechecks: self.rechecks + other.rechecks,
            unresolved: self.unresolved + other.unresolved,
            pairs: self.pairs + other.pairs,
        }
    }
}

/// Energy taken out and put in since the system was built (mass × length² / time²).
///
/// At any time the kinetic energy is `initial − lost + put_in`, to rounding.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Ledger {
    /// Energy at the start.
    pub initial: f64,
    /// Lost in contacts, less what contacts have added: of all contacts that do not conserve the
    /// energy by the word of the response (`Response::conserves_energy`), at any elasticity.
    pub lost: f64,
    /// What guarded contacts would have lost in addition without the guard against inelastic
    /// collapse: the energy after each, less the energy that the response leaves at the elasticity
    /// of the table. For information; not a term of [`Self::booked`].
    pub spared: f64,
    /// Put in by energy resets and by adding, removing or locking bodies.
    pub put_in: f64,
}

impl Ledger {
    /// The energy that there should be.
    pub fn booked(&self) -> f64 {
        self.initial - self.lost + self.put_in
    }
}
