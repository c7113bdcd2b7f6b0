//! The price of each setting in a scene.

use carom_runs::price::{ReplayTally, TimeRatio};
use serde::Serialize;

use super::{
    curves::Deviation,
    difference::Difference,
    effective_error::EffectiveError,
    knobs::{FAMILIES, Knob, LeftOutKnob},
    physics::Physics,
};

/// Results for one setting.
#[derive(Debug, Clone)]
pub struct KnobResult {
    /// Which.
    pub knob: Knob,
    /// Processor time of a collision over that of the exact run; `None` if it was not measured.
    pub time: Option<TimeRatio>,
    /// Counts of wrong contacts.
    pub tally: ReplayTally,
    /// Effective error by reversal; `None` for another model, for a scene that cannot be reversed,
    /// or if the run fails.
    pub effective: Option<EffectiveError>,
    /// The scene's own measures.
    pub physics: Physics,
    /// Whether it was left out because it would take too long.
    pub is_skipped: bool,
    /// What could not be measured, and why.
    pub notes: Vec<String>,
}

/// Results in one scene.
#[derive(Debug, Clone)]
pub struct SceneResult {
    /// Name of the scene.
    pub name: String,
    /// Number of bodies that move.
    pub moving: usize,
    /// Processor time for each collision of the exact run (nanoseconds).
    pub nanoseconds: f64,
    /// E-foldings of rounding errors for each collision of a body.
    pub rate: f64,
    /// Length of a replay, in mean times between two collisions of a body.
    pub stretch: f64,
    /// Mean time between two collisions of a body at the first state (time).
    pub tau: f64,
    /// Times of the first and of the last state.
    pub span: [f64; 2],
    /// Number of states.
    pub states: usize,
    /// Why no run can be reversed, if that is so.
    pub irreversible: Option<String>,
    /// Knobs that do not apply, with the reason.
    pub left_out: Vec<LeftOutKnob>,
    /// What could not be measured in the time allowed.
    pub notes: Vec<String>,
    /// The settings; the exact run is the first.
    pub found: Vec<KnobResult>,
}

impl SceneResult {
    /// The exact run.
    pub fn exact(&self) -> &KnobResult {
        &self.found[0]
    }
}

impl KnobResult {
    /// Results without a measurement yet.
    pub fn new(knob: Knob) -> Self {
        Self {
            knob,
            time: None,
            tally: ReplayTally::default(),
            effective: None,
            physics: Physics::default(),
            is_skipped: false,
            notes: Vec::new(),
        }
    }

    /// Wrong contacts in a million, or the largest number that is compatible with none (95 %).
    /// `None` if no contact was judged.
    pub fn wrong(&self) -> Option<Bound> {
        let wrong = self.tally.wrong();
        (self.tally.judged > 0).then(|| Bound {
            value: if wrong > 0.0 {
                wrong
            } else {
                self.tally.upper_bound_of_none()
            },
            is_upper: wrong == 0.0,
        })
    }
}

/// A number, or an upper bound of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// The number.
    pub value: f64,
    /// True for an upper bound.
    pub is_upper: bool,
}

/// A setting in `summary.json`.
#[derive(Debug, Clone, Serialize)]
pub struct TradeRow {
    scene: String,
    family: &'static str,
    setting: String,
    how: String,
    is_exact: bool,
    time_over_exact: Option<TimeRatio>,
    contacts: ReplayTally,
    effective_error_sides: Option<f64>,
    effective_error_is_lower_bound: bool,
    measured_from: f64,
    measured_until: f64,
    measures: Vec<Difference>,
    curves: Vec<Deviation>,
    notes: Vec<String>,
}

/// The rows of all settings of a scene.
pub fn rows(result: &SceneResult) -> Vec<TradeRow> {
    let row = |found: &KnobResult| TradeRow {
        scene: result.name.clone(),
        family: FAMILIES[found.knob.family],
        setting: found.knob.name.clone(),
        how: found.knob.how(),
        is_exact: found.knob.setting.is_exact(),
        time_over_exact: found.time,
        contacts: found.tally,
        effective_error_sides: found.effective.map(|effective| effective.value),
        effective_error_is_lower_bound: found.effective.is_some_and(|effective| effective.at_least),
        measured_from: found.physics.span[0],
        measured_until: found.physics.span[1],
        measures: found.physics.differences(&result.exact().physics),
        curves: found.physics.deviations(&result.exact().physics),
        notes: found.notes.clone(),
    };
    result.found.iter().map(row).collect()
}
