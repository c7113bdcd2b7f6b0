//! What the extreme scenes, limits, reversals and drifts have shown.

use carom_testkit::extremes::ExtremeCase;

use super::{
    drift::EnergyDrift,
    limits::{FoundLimit, LimitSearch},
    reversal::Reversal,
    trial::Ending,
};

/// All results.
pub struct ExtremesResults {
    /// Each scene with its results for the exact engine and for that of the thesis.
    pub scenes: Vec<(ExtremeCase, [Ending; 2])>,
    /// Each limit for both engines.
    pub limits: Vec<(LimitSearch, [FoundLimit; 2])>,
    /// Reversal at each density for both engines.
    pub reversals: [Vec<Reversal>; 2],
    /// Drift of the exact engine.
    pub drifts: Vec<EnergyDrift>,
}
