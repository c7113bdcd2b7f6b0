//! The entry `[run.stop]` of a scene file: when a run ends before its time.

use serde::{Deserialize, Serialize};

/// Conditions that end a run at a sample before `run.until`; the first that holds ends it.
/// [`Simulation::run_until`](crate::Simulation::run_until) ignores it.
///
/// ```
/// use carom_engine::Scene;
///
/// let scene = Scene::from_toml(r#"
///     [run]
///     until = 100.0
///     observe = ["pressure"]
///     [run.stop]
///     figure = "pressure"
///     relative_error = 0.01
/// "#)?;
/// let stop = scene.run.stop.as_ref().expect("it is given");
/// assert_eq!(stop.relative_error, Some(0.01));
/// assert_eq!(Scene::from_toml(&scene.to_toml())?, scene);
/// # Ok::<(), carom_engine::SceneError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct StopSpec {
    /// The run ends at the first sample with at least this number of collisions since time 0; from
    /// 1 to 1e15.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1.0, max = 1e15)))]
    pub collisions: Option<f64>,
    /// Name of a figure of the run, as in its report, whose standard error ends the run. With
    /// `standard_error` or `relative_error`. The error is judged at the end of whole blocks of
    /// time, as soon as there are 32 of them; it is the largest of those from the blocks, and from
    /// neighbours joined by two and by four, so that correlated blocks do not end a run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub figure: Option<String>,
    /// The run ends when the standard error of `figure` is at most this (unit of the figure).
    /// Excludes `relative_error`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0.0)))]
    pub standard_error: Option<f64>,
    /// The run ends when the standard error of `figure` is at most this share of its value.
    /// Excludes `standard_error`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0.0)))]
    pub relative_error: Option<f64>,
}
