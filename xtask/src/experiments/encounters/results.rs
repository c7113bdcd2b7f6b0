//! The answers of all detectors to all classes of encounters.

use serde::{Deserialize, Serialize};

use super::{settings::DetectorSetting, tally::EncounterTally, timing::Timing};

/// Results for one class.
#[derive(Debug)]
pub struct ClassResult {
    /// Its name.
    pub name: String,
    /// Description.
    pub about: String,
    /// Cases without a reference from the oracle.
    pub unresolved: usize,
    /// The answers at each setting.
    pub tallies: Vec<EncounterTally>,
    /// The times at each setting.
    pub timings: Vec<Option<Timing>>,
    /// parry's answers.
    pub parry: ParryResult,
}

/// Results of parry.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct ParryResult {
    /// Its answers; a call that does not return counts as unresolved.
    pub tally: EncounterTally,
    /// Time relative to the exact detector for each call that returned.
    pub ratios: Vec<f64>,
    /// Number of calls.
    pub calls: usize,
    /// Number of calls that did not return.
    pub hung: usize,
}

impl ParryResult {
    pub fn sum<'a>(rounds: impl Iterator<Item = &'a Self> + Clone) -> Self {
        Self {
            tally: EncounterTally::sum(rounds.clone().map(|round| &round.tally)),
            ratios: rounds
                .clone()
                .flat_map(|round| &round.ratios)
                .copied()
                .collect(),
            calls: rounds.clone().map(|round| round.calls).sum(),
            hung: rounds.map(|round| round.hung).sum(),
        }
    }
}

/// All results.
#[derive(Debug)]
pub struct EncounterResults {
    /// The settings.
    pub settings: Vec<DetectorSetting>,
    /// The classes.
    pub classes: Vec<ClassResult>,
}
