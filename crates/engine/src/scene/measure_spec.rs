//! An entry `[[measure]]` of a scene file: a quantity to measure, with its parameters.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// A quantity to measure, as plain data; the runner of scenes validates it.
/// [`Simulation::new`](crate::Simulation::new) ignores it.
///
/// ```
/// use carom_engine::{MeasureParameter, Scene};
///
/// let scene = Scene::from_toml(r#"
///     [[measure]]
///     kind = "pair-distribution"
///     of = "gas"
///     name = "fine"
///     bins = 500
/// "#)?;
/// assert_eq!(scene.measure[0].of.as_deref(), Some("gas"));
/// assert_eq!(scene.measure[0].parameters["bins"], MeasureParameter::Number(500.0));
/// assert_eq!(Scene::from_toml(&scene.to_toml())?, scene);
/// # Ok::<(), carom_engine::SceneError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MeasureSpec {
    /// What is measured, such as `velocities`; a name that `run.observe` accepts, without tag.
    pub kind: String,
    /// The tag of the bodies; two tags separated by a comma for a kind that measures pairs.
    /// Default: all bodies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// Name in files and figures. Default: the tag.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Further parameters by name; each kind has its own.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, MeasureParameter>,
}

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum MeasureParameter {
    /// A number; an integer of the file is read as a number.
    Number(f64),
    /// A text: one of the words of the parameter, or a tag.
    Text(String),
    /// A truth value, which no kind accepts yet.
    Flag(bool),
    /// Numbers, such as both coordinates of a point.
    Numbers(Vec<f64>),
}
