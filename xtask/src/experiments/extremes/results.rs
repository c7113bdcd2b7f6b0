//! What the extreme scenes, limits, reversals and drifts have shown.

use carom_testkit::extremes::Case;

use super::{
    drift::Drift,
    limits::{Limit, LimitSearch},
    reversal::Reversal,
    trial::Ending,
};

/// All results.
pub struct Results {
    /// Each scene with its results for the exact engine and for that of the thesis.
    pub scenes: Vec<(Case, [Ending; 2])>,
    /// Each limit for both engines.
    pub limits: Vec<(LimitSearch, [Limit; 2])>,
    /// Reversal at each density for both engines.
    pub reversals: [Vec<Reversal>; 2],
    /// Drift of the exact engine.
    pub drifts: Vec<Drift>,
}
