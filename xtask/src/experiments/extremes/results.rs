//! What the extreme scenes, edges, reversals and drifts have shown.

use carom_testkit::extremes::Case;

use super::{
    drift::Drift,
    edges::{Edge, Found},
    reversal::Reversal,
    trial::Ending,
};

/// All there is to report.
pub struct Results {
    /// Each scene with how it ended with the exact engine and with the thesis's.
    pub scenes: Vec<(Case, [Ending; 2])>,
    /// Each edge, likewise.
    pub edges: Vec<(Edge, [Found; 2])>,
    /// Reversal at each density, of both engines.
    pub reversals: [Vec<Reversal>; 2],
    /// Drift of the exact engine.
    pub drifts: Vec<Drift>,
}
