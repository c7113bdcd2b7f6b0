//! Totals of a run in memory: its contacts, the drift of its energy, and its overlaps.

use carom::{EnergyLedger, Observer as _, OverlapCheck, View};
use carom_tables::{Totals, allowed_drift};

/// Energy and overlaps at the samples of one run.
#[derive(Debug, Clone, Default)]
pub struct RunTotals {
    energy: EnergyLedger,
    overlaps: OverlapCheck,
}

impl RunTotals {
    /// Starts from the present energy.
    pub fn new(view: &View<'_>) -> Self {
        let mut totals = Self::default();
        totals.energy.sample(view);
        totals
    }

    /// Samples energy and overlaps.
    pub fn sample(&mut self, view: &View<'_>) {
        self.energy.sample(view);
        self.overlaps.sample(view);
    }

    /// Totals up to the present time; the run phase took `seconds` of processor time.
    pub fn totals(&self, view: &View<'_>, seconds: f64) -> Totals {
        let collisions = view.counters().collisions;
        Totals {
            collisions,
            simulated_time: view.time().to_f64(),
            collisions_per_second: collisions as f64 / seconds.max(1e-9),
            energy_drift: self.energy.drift(),
            allowed_drift: allowed_drift_now(view),
            overlapping_pairs: self.overlaps.worst_pairs(),
            max_overlap: self.overlaps.deepest(),
        }
    }
}

/// Largest relative drift of the energy that rounding explains up to the present time, by the
/// contacts so far and the bodies that move now ([`allowed_drift`]).
pub fn allowed_drift_now(view: &View<'_>) -> f64 {
    let moving = view.bodies().filter(|body| !body.body.is_fixed()).count();
    allowed_drift(view.counters().collisions, Some(moving as u64))
}
