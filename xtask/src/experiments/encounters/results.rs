//! The answers of all detectors to all classes of encounters.

use carom_tables::Totals;
use serde::{Deserialize, Serialize};

use super::{settings::Setting, tally::Tally, timing::Timing};

/// What came out for one class.
#[derive(Debug)]
pub struct ClassResult {
    /// Its name.
    pub name: String,
    /// What is in it.
    pub about: String,
    /// Cases about which the oracle does not know.
    pub unresolved: usize,
    /// The answers at each setting.
    pub tallies: Vec<Tally>,
    /// The times at each setting.
    pub timings: Vec<Option<Timing>>,
    /// parry's answers.
    pub parry: ParryResult,
}

/// What parry answered.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct ParryResult {
    /// Its answers; a call that does not return counts as given up.
    pub tally: Tally,
    /// Its time over that of the exact detector, for each call that returned.
    pub ratios: Vec<f64>,
    /// Calls.
    pub asked: usize,
    /// Calls that did not return.
    pub hung: usize,
}

impl ParryResult {
    pub fn sum<'a>(rounds: impl Iterator<Item = &'a Self> + Clone) -> Self {
        Self {
            tally: Tally::sum(rounds.clone().map(|round| &round.tally)),
            ratios: rounds.clone().flat_map(|round| &round.ratios).copied().collect(),
            asked: rounds.clone().map(|round| round.asked).sum(),
            hung: rounds.map(|round| round.hung).sum(),
        }
    }
}

/// All there is to report.
#[derive(Debug)]
pub struct Results {
    /// The settings.
    pub settings: Vec<Setting>,
    /// The classes.
    pub classes: Vec<ClassResult>,
    /// Totals of the runs that pairs were recorded from.
    pub totals: Totals,
}
