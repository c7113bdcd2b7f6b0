//! What the extreme scenes, edges, reversals and drifts have shown.

use carom_testkit::extremes::Case;

use super::{
    drift::Drift,
    edges::{Edge, Found},
    reversal::Reversal,
    trial::Ending,
};

/// All results.
pub struct Results {
    /// Each scene with its results for the exact engine and for that of the thesis.
    pub scenes: Vec<(Case, [Ending; 2])>,
    /// Each limit for both engines.
    pub edges: Vec<(Edge, [Found; 2])>,
    /// Reversal at each density for both engines.
    pub reversals: [Vec<Reversal>; 2],
    /// Drift of the exact engine.
    pub drifts: Vec<Drift>,
}
