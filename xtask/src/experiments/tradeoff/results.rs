//! The price of each setting in each scene.

use super::{knobs::Setting, measures::Physics, replay::Tally, reversal::EffectiveError, scenes::Named};

/// A contact with a larger time error is wrong (mean times between two collisions of a body).
/// Rounding errors grow by some orders of magnitude within a replay and stay below it.
pub const TOLERANCE: f64 = 1e-7;

/// Results for one setting.
#[derive(Debug)]
pub struct SettingResult {
    /// Which.
    pub setting: Setting,
    /// Processor time of a collision over that of the exact run in the same round, median; `None`
    /// if it breaks off.
    pub time: Option<f64>,
    /// Counts of wrong contacts.
    pub tally: Tally,
    /// Effective error by reversal; `None` for another model or if the run fails.
    pub effective: Option<EffectiveError>,
    /// Physical results.
    pub physics: Physics,
}

/// Results in one scene.
#[derive(Debug)]
pub struct SceneResult {
    /// The scene.
    pub named: Named,
    /// Time for each collision of the exact run (nanoseconds).
    pub nanoseconds: f64,
    /// E-foldings of rounding errors for each collision of a body.
    pub rate: f64,
    /// Length of a replay, in mean times between two collisions of a body.
    pub stretch: f64,
    /// The settings; the exact run is the first.
    pub found: Vec<SettingResult>,
    /// Charts of the scene: file name and SVG.
    pub charts: Vec<(String, String)>,
}
