//! What has happened so far: counts of events, and the books of energy.

/// Counts of events since the system was built.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Contacts between two bodies, fixed ones included.
    pub collisions: u64,
    /// Of these, contacts with a fixed body.
    pub fixed_collisions: u64,
    /// Contacts whose elasticity the guard against inelastic collapse has raised, if by ever so little
    /// ([`ElasticitySpec::contact_time`](crate::ElasticitySpec::contact_time)): what that means for the energy is in
    /// [`Ledger::spared`].
    pub guarded_collisions: u64,
    /// Epochs begun.
    pub epochs: u64,
    /// Work of the scheduler.
    pub scheduler: SchedulerCounters,
}

/// What a scheduler did to find the contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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

/// Energy taken out and put in since the system was built (mass × length² / time²).
///
/// At any time the kinetic energy is `initial − lost + put_in`, to rounding.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ledger {
    /// Energy at the start.
    pub initial: f64,
    /// Lost in contacts of elasticity below 1, less what superelastic ones gave.
    pub lost: f64,
    /// What contacts of elasticity below 1 would have lost as well without the guard against inelastic collapse; it is still
    /// there, and in none of the other three.
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
