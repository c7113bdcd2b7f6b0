//! What has happened so far: counts of events, and the books of energy.

use std::ops::Add;

use serde::{Deserialize, Serialize};

/// Counts of events since the system was built.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counters {
    /// Contacts between two bodies, fixed ones included.
    pub collisions: u64,
    /// Of these, contacts with a fixed body.
    pub fixed_collisions: u64,
    /// Epochs begun.
    pub epochs: u64,
    /// Work of the scheduler.
    pub scheduler: SchedulerCounters,
}

/// What a scheduler did to find the contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct SchedulerCounters {
    /// Bodies that entered another cell.
    pub crossings: u64,
    /// Predictions that came up after a partner had changed.
    pub stale: u64,
    /// Searches that ended "certified free until" or without certainty, and were asked again.
    pub rechecks: u64,
    /// Of these, searches that ended without certainty; always 0 with the exact detector.
    pub unresolved: u64,
    /// Pairs asked for their first contact.
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
    /// Lost in contacts of elasticity below 1, less what superelastic ones gave.
    pub lost: f64,
    /// Put in by energy resets and by adding, removing or locking bodies.
    pub put_in: f64,
}

impl Ledger {
    /// The energy that there should be.
    pub fn booked(&self) -> f64 {
        self.initial - self.lost + self.put_in
    }
}
