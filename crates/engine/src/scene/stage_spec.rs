//! The descriptions of thermostats and of changes of tags in the stages of a scene.

use carom_geometry::MAX_MAGNITUDE;
use serde::{Deserialize, Serialize};

use crate::scene::{error::SceneError, thermostat_target::ThermostatTarget};

/// How a thermostat changes the motions of bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ThermostatKind {
    /// Velocity and angular velocity of each body are scaled to a given kinetic energy; directions
    /// remain (Montanari 2017, section 2.1.1). Bodies at rest remain at rest.
    #[default]
    EnergyReset,
    /// Velocity and angular velocity are drawn anew from Maxwell's distribution.
    #[doc(alias = "Andersen")]
    Maxwell,
}

/// A thermostat that acts at regular times on the bodies of a tag.
///
/// It acts at the times start + k · `every` of its stage, with k = 0, 1, 2, …, as long as they lie
/// before the end of the stage. Fixed bodies are left out.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ThermostatSpec {
    /// The tag of the bodies.
    pub tag: String,
    /// Interval between two actions (time), above 0.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0.0)))]
    pub every: f64,
    /// What the thermostat does. Default: energy resets.
    pub kind: ThermostatKind,
    /// Kinetic energy of each body, or the mean energy of a body for `maxwell`
    /// (mass × length² / time²), above 0 and at most 1e60. Either this or `temperature`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = MAX_MAGNITUDE), extend("exclusiveMinimum" = 0.0)))]
    pub energy: Option<f64>,
    /// Temperature kT (mass × length² / time²), above 0 and at most 1e60: energy ½ f kT for a body
    /// of f = 2 degrees of freedom, or 3 if contacts turn it. Either this or `energy`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = MAX_MAGNITUDE), extend("exclusiveMinimum" = 0.0)))]
    pub temperature: Option<f64>,
}

/// A single change of the energies of the bodies of a tag, at the start of a stage.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct HeatSpec {
    /// The tag of the bodies.
    pub tag: String,
    /// What is done. Default: an energy reset.
    pub kind: ThermostatKind,
    /// Kinetic energy of each body, or the mean energy of a body for `maxwell`
    /// (mass × length² / time²), above 0 and at most 1e60. Either this or `temperature`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = MAX_MAGNITUDE), extend("exclusiveMinimum" = 0.0)))]
    pub energy: Option<f64>,
    /// Temperature kT (mass × length² / time²), above 0 and at most 1e60: energy ½ f kT for a body
    /// of f = 2 degrees of freedom, or 3 if contacts turn it. Either this or `energy`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = MAX_MAGNITUDE), extend("exclusiveMinimum" = 0.0)))]
    pub temperature: Option<f64>,
}

/// A tag that bodies get or lose at the start of a stage.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RelabelSpec {
    /// The tag of the bodies concerned. Without this and `body`: all bodies that move.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub of: String,
    /// The number of the only body concerned (instead of `of` and `count`), as messages name it;
    /// bodies are numbered from 0 in the order of insertion, and keep their numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<u64>,
    /// The tag that they get or lose.
    pub name: String,
    /// The first so many of them, in the order of insertion; all if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
}

impl ThermostatSpec {
    /// One action of the thermostat.
    pub fn action(&self) -> HeatSpec {
        let Self {
            tag,
            every: _,
            kind,
            energy,
            temperature,
        } = self;
        HeatSpec {
            tag: tag.clone(),
            kind: *kind,
            energy: *energy,
            temperature: *temperature,
        }
    }
}

impl HeatSpec {
    /// The energy or temperature to which it brings the bodies.
    ///
    /// # Errors
    /// [`SceneError::Entry`] with the name `entry` if there is not exactly one of both, or if it is
    /// not above 0 and at most 1e60.
    pub fn target(&self, entry: &str) -> Result<ThermostatTarget, SceneError> {
        let problem = |problem: String| SceneError::Entry {
            entry: entry.to_owned(),
            problem,
        };
        let (key, value, target) = match (self.energy, self.temperature) {
            (Some(energy), None) => ("energy", energy, ThermostatTarget::Energy(energy)),
            (None, Some(kt)) => ("temperature", kt, ThermostatTarget::Temperature(kt)),
            _ => return Err(problem("give either `energy` or `temperature`".to_owned())),
        };
        if value > 0.0 && value <= MAX_MAGNITUDE {
            Ok(target)
        } else {
            Err(problem(format!(
                "`{key}` must be above 0 and at most {MAX_MAGNITUDE:e}, but is {value:?}"
            )))
        }
    }
}
