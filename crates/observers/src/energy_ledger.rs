//! Kinetic energy, its expected value, and momentum, at each sample.
//!
//! E = Σ ½ m v² + ½ I ω² (mass × length² / time²). Its expected ("booked") value is the energy at
//! the start, less the loss in inelastic contacts, plus the energy put in by edits and by walls.
//! The difference of the two is due to rounding alone.

use carom_engine::{Ledger, Observer, View};
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Energy, expected energy and momentum over the samples.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::EnergyLedger;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut ledger = EnergyLedger::default();
/// ledger.sample(&simulation.view());
/// simulation.observe_until(1.0, &mut ledger)?;
/// ledger.sample(&simulation.view());
/// assert_eq!(ledger.series()[0].booked, ledger.series()[1].booked);
/// assert!(ledger.drift() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[doc(alias = "energy drift")]
pub struct EnergyLedger {
    series: Vec<LedgerPoint>,
}

/// Energy and momentum at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LedgerPoint {
    /// Time of the sample.
    pub time: f64,
    /// Kinetic energy of all bodies (mass × length² / time²).
    pub energy: f64,
    /// The expected kinetic energy (mass × length² / time²).
    pub booked: f64,
    /// The largest of the energies lost in contacts, put in by edits, given by thermal walls, given
    /// by the work of walls and taken by drag so far, and of those exchanged at one step of a well,
    /// by magnitude (mass × length² / time²).
    pub exchanged: f64,
    /// Total momentum (mass × length / time).
    pub momentum: DVec2,
}

impl EnergyLedger {
    /// Energy and momentum at each sample so far.
    pub fn series(&self) -> &[LedgerPoint] {
        &self.series
    }

    /// (E − booked)/S at each sample, with the larger S of E(first sample) and of the largest
    /// energy exchanged up to the sample, whose rounding remains; 0 if both are 0.
    pub fn drifts(&self) -> impl Iterator<Item = f64> {
        let mut scale = self.series.first().map_or(0.0, |first| first.energy);
        self.series.iter().map(move |point| {
            scale = scale.max(point.exchanged);
            if scale > 0.0 {
                (point.energy - point.booked) / scale
            } else {
                0.0
            }
        })
    }

    /// The largest magnitude of [`Self::drifts`].
    pub fn drift(&self) -> f64 {
        self.drifts().map(f64::abs).fold(0.0, f64::max)
    }
}

/// The largest of the energies lost in contacts, put in by edits, given by walls, taken by drag,
/// and gained by falling and in wells.
fn largest_exchange(ledger: &Ledger) -> f64 {
    ledger
        .lost
        .abs()
        .max(ledger.put_in.abs())
        .max(ledger.heat.abs())
        .max(ledger.work.abs())
        .max(ledger.dragged)
        .max(ledger.fallen.abs())
        .max(ledger.sheared.abs())
        .max(ledger.wells.abs())
}

impl Observer for EnergyLedger {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let ledger = view.ledger();
        self.series.push(LedgerPoint {
            time: view.time().to_f64(),
            energy: view.energy(),
            booked: ledger.booked(),
            exchanged: largest_exchange(&ledger).max(view.largest_step()),
            momentum: view.momentum(),
        });
    }
}
