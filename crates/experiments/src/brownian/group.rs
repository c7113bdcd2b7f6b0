//! Runs of one molecule taken together, and what theory predicts for them.

use anyhow::{Context, Result};
use carom::Molecule;
use carom_runs::measures::kicks::{Mirror, Prediction};
use glam::DVec2;

use super::{
    momentum::thermal_shares,
    results::{Kicks, Measurement},
    setting::Setting,
    surroundings::Surroundings,
};

/// Runs of one molecule, with their predictions.
#[derive(Debug)]
pub struct Group<'a> {
    /// The molecule in its gas.
    pub setting: &'a Setting,
    /// The runs, at least one; they differ in their random numbers only.
    pub runs: &'a [Measurement],
    /// Start of the measurement (time).
    pub from: f64,
    /// What moves around the molecule.
    pub surroundings: Surroundings,
    /// Predictions of kinetic theory for one gas of equal discs. In a mixture, the boundary is that
    /// for its smallest disc, and no other prediction holds.
    pub prediction: Prediction,
    /// Shares of velocity and rotation that the molecule loses at a contact on average.
    forgotten: [f64; 2],
    /// Mirror symmetry of the molecule.
    pub mirror: Option<Mirror>,
    /// Sum of the kicks of all runs.
    pub kicks: Kicks,
}

pub use carom_runs::measures::kicks::MIN_BLOCK;

/// Standard error of a sum of `count` Rayleigh-distributed impulse magnitudes, as ⟨J²⟩/⟨J⟩² = 4/π.
pub fn impulse_error(sum: f64, count: u64) -> f64 {
    if count == 0 { 0.0 } else { sum * (4.0 / (std::f64::consts::PI * count as f64)).sqrt() }
}

/// Shares of velocity and rotation that a molecule loses at a contact in a mixture, on average: the
/// friction by all kinds over their contacts, each kind as discs of its mean area and mass. An
/// estimate, for the length of blocks.
fn forgotten_in_a_mixture(surroundings: &Surroundings, molecule: &Molecule, turns: bool) -> Result<[f64; 2]> {
    let (mut forgotten, mut contacts) = ([0.0; 2], 0.0);
    for kind in &surroundings.kinds {
        let alone = Prediction::new(molecule, turns, [kind.radius, kind.mass])?;
        let sums = alone.forgotten();
        forgotten = [0, 1].map(|index| forgotten[index] + kind.number * sums[index]);
        contacts += kind.number * alone.contacts();
    }
    Ok(forgotten.map(|sum| sum / contacts))
}

impl<'a> Group<'a> {
    /// Groups runs of one molecule.
    ///
    /// # Errors
    /// There are no runs, or the radius of the gas discs is out of range.
    pub fn new(setting: &'a Setting, runs: &'a [Measurement], from: f64) -> Result<Self> {
        let kicks = Kicks::sum(runs.iter().map(|run| &run.kicks)).context("there are no runs")?;
        let molecule = &runs[0].molecule;
        let (surroundings, turns) = (setting.surroundings()?, setting.turns(molecule));
        let smallest = [surroundings.probe(), surroundings.largest_mass()];
        let prediction = Prediction::new(molecule, turns, smallest)?;
        let forgotten = if surroundings.is_one_gas {
            prediction.forgotten_at_a_contact()
        } else {
            forgotten_in_a_mixture(&surroundings, molecule, turns)?
        };
        let mirror = Mirror::of(molecule);
        Ok(Self { setting, runs, from, surroundings, prediction, forgotten, mirror, kicks })
    }

    /// The share of kT that the molecule has along x′ and along y′.
    pub fn thermal_shares(&self) -> DVec2 {
        let mass = self.molecule().mass();
        let kinds = &self.surroundings.kinds;
        let number: f64 = kinds.iter().map(|kind| kind.number).sum();
        let all: f64 = kinds.iter().map(|kind| kind.number * kind.mass).sum();
        let gas = self.density() * self.setting.area() * all / number;
        thermal_shares(&self.setting.scene, self.setting.body, self.turns(), mass / (mass + gas))
    }

    /// Whether the surroundings are other than one gas of equal discs.
    pub fn is_mixed(&self) -> bool {
        !self.surroundings.is_one_gas
    }

    /// Whether the distribution of the kicks in a dilute gas is known: that of the exposed arcs, or
    /// the isotropic one on a disc.
    pub fn has_arcs(&self) -> bool {
        !self.is_mixed() || self.is_round()
    }

    /// The molecule.
    pub fn molecule(&self) -> &'a Molecule {
        &self.runs[0].molecule
    }

    /// Whether the molecule is round: the control, whose kicks are isotropic.
    pub fn is_round(&self) -> bool {
        self.molecule().is_round()
    }

    /// Whether contacts turn the molecule.
    pub fn turns(&self) -> bool {
        self.setting.turns(self.molecule())
    }

    /// Duration of the measurement, summed over all runs (time).
    pub fn duration(&self) -> f64 {
        self.runs.iter().map(|run| run.duration).sum()
    }

    /// Temperature, equal in all runs up to rounding (mass × length² / time²).
    pub fn temperature(&self) -> f64 {
        self.runs.iter().map(|run| run.temperature).sum::<f64>() / self.runs.len() as f64
    }

    /// Gas discs per area of the box (1 / length²).
    pub fn density(&self) -> f64 {
        self.runs.iter().map(|run| run.density).sum::<f64>() / self.runs.len() as f64
    }

    /// Impulse per time and length of the boundary in an ideal gas of this density, nkT (mass /
    /// time²).
    pub fn ideal_pressure(&self) -> f64 {
        self.density() * self.temperature()
    }

    /// Relaxation times of the velocity and of the rotation (time), from the measured rate of kicks
    /// and kinetic theory with uncorrelated contacts; 0 for a rotation that contacts do not change.
    /// Infinite without kicks.
    pub fn relaxation_times(&self) -> [f64; 2] {
        let rate = self.hit_rate();
        self.forgotten.map(|share| {
            // Locked, or round.
            if share == 0.0 { 0.0 } else { 1.0 / (share * rate) }
        })
    }

    /// Whether blocks of time are long enough that their scatter gives errors of the motion of the
    /// molecule.
    pub fn has_long_blocks(&self) -> bool {
        let [velocity, rotation] = self.relaxation_times();
        let blocks = || self.runs.iter().flat_map(|run| run.drift.complete());
        let mean = blocks().map(|block| block.duration).sum::<f64>() / blocks().count().max(1) as f64;
        mean >= MIN_BLOCK * velocity.max(rotation)
    }

    /// Kicks by the gas per time (1 / time).
    pub fn hit_rate(&self) -> f64 {
        self.kicks.hits() as f64 / self.duration()
    }
}
