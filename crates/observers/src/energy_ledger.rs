//! Kinetic energy, its expected value, and momentum, at each sample.
//!
//! E = Σ ½ m v² + ½ I ω² (mass × length² / time²). Its expected ("booked") value is the energy at
//! the start, less the loss in inelastic contacts, plus the energy put in by edits. The difference
//! of the two is due to rounding alone.

use carom_engine::{Observer, View};
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
    /// Total momentum (mass × length / time).
    pub momentum: DVec2,
}

impl EnergyLedger {
    /// Energy and momentum at each sample so far.
    pub fn series(&self) -> &[LedgerPoint] {
        &self.series
    }

    /// Largest |E − booked| / E(first sample); 0 if that energy is 0.
    pub fn drift(&self) -> f64 {
        match self.series.first() {
            Some(first) if first.energy > 0.0 => {
                let largest = self.series.iter().map(|point| (point.energy - point.booked).abs());
                largest.fold(0.0, f64::max) / first.energy
            }
            _ => 0.0,
        }
    }
}

impl Observer for EnergyLedger {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        self.series.push(LedgerPoint {
            time: view.time().to_f64(),
            energy: view.energy(),
            booked: view.ledger().booked(),
            momentum: view.momentum(),
        });
    }
}
