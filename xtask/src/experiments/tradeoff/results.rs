//! The price of each setting in each scene.

use super::{knobs::Setting, measures::Physics, replay::Tally, reversal::EffectiveError, scenes::Named};

/// A contact that is off by more than this is wrong (mean times between two collisions of a body). Rounding grows by some
/// orders of magnitude within a replay, and stays below.
pub const TOLERANCE: f64 = 1e-7;

/// What was found about one setting.
#[derive(Debug)]
pub struct Found {
    /// Which.
    pub setting: Setting,
    /// Processor time of a collision over that of the exact run in the same round, median; `None` if it breaks off.
    pub time: Option<f64>,
    /// Wrong contacts.
    pub tally: Tally,
    /// Effective error by reversal; `None` where the model is another, or the run breaks off.
    pub effective: Option<EffectiveError>,
    /// What the physicist came for.
    pub physics: Physics,
}

/// What was found in one scene.
#[derive(Debug)]
pub struct SceneResult {
    /// The scene.
    pub named: Named,
    /// Nanoseconds of a collision of the exact run.
    pub nanoseconds: f64,
    /// By how many e-foldings roundings grow in one collision of each body.
    pub rate: f64,
    /// Length of a replay, in mean times between two collisions of a body.
    pub stretch: f64,
    /// The settings, the exact run first.
    pub found: Vec<Found>,
    /// Its charts, as file name and SVG.
    pub charts: Vec<(String, String)>,
}
