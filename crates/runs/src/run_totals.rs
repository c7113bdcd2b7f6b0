//! Totals of a run in memory: its contacts, the drift of its energy, and its overlaps.

use carom::{EnergyLedger, Observer as _, OverlapCheck, View};
use carom_tables::Totals;

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
            overlapping_pairs: self.overlaps.worst_pairs(),
            max_overlap: self.overlaps.deepest(),
        }
    }
}
