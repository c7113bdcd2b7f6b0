//! Runs of one case and size taken together, and what theory predicts for them.

use crate::experiments::thesis_scene::Case;

use super::{
    prediction::Prediction,
    results::{Kicks, Measurement},
};

/// Runs of one case and size, with their predictions.
#[derive(Debug)]
pub struct Group<'a> {
    /// The case.
    pub case: Case,
    /// The runs, at least one; they differ in their random numbers only.
    pub runs: &'a [Measurement],
    /// Start of the measurement (time).
    pub from: f64,
    /// Predictions of kinetic theory.
    pub prediction: Prediction,
    /// Sum of the kicks of all runs.
    pub kicks: Kicks,
}

/// Standard error of a sum of `count` Rayleigh-distributed impulse magnitudes, as ⟨J²⟩/⟨J⟩² = 4/π.
pub fn impulse_error(sum: f64, count: u64) -> f64 {
    if count == 0 { 0.0 } else { sum * (4.0 / (std::f64::consts::PI * count as f64)).sqrt() }
}

impl<'a> Group<'a> {
    /// Groups runs of one case and size; `None` if there are none.
    pub fn new(case: Case, runs: &'a [Measurement], from: f64) -> Option<Self> {
        let kicks = Kicks::sum(runs.iter().map(|run| &run.kicks))?;
        let prediction = Prediction::new(case, &runs.first()?.molecule);
        Some(Self { case, runs, from, prediction, kicks })
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

    /// Kicks by the gas per time (1 / time).
    pub fn hit_rate(&self) -> f64 {
        self.kicks.hits() as f64 / self.duration()
    }
}
