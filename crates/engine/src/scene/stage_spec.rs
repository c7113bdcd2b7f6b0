//! The descriptions of thermostats and of changes of tags in the stages of a scene.

#[cfg(feature = "schema")]
use carom_geometry::MAX_MAGNITUDE;
use serde::{Deserialize, Serialize};

use crate::scene::{kick_momentum::KickMomentum, two_numbers::optional_vector};

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
    /// Self-propulsion: the velocity is set to `speed` along an axis of the body that diffuses with
    /// `rotational_diffusion`, plus a random velocity of `translational_diffusion`. A disc has an
    /// axis of its own, at first in a random direction. The axis of a molecule is its orientation:
    /// it gets an angular velocity that turns it by the drawn angle until the next action. A locked
    /// molecule keeps its axis, and `rotational_diffusion` must then be 0.
    #[doc(alias = "active Brownian particle")]
    Active,
    /// A bath of `temperature` and `friction`: an exact step of the Ornstein–Uhlenbeck process over
    /// `every`, for the velocity and for the angular velocity of molecules that contacts turn.
    #[doc(alias = "Ornstein-Uhlenbeck")]
    Langevin,
    /// The direction of the velocity is drawn anew; speed and angular velocity remain. Bodies at
    /// rest remain at rest.
    Rotate,
    /// `momentum` is added to each body.
    Kick,
    /// All velocities relative to the centre of mass, and to the flow under shear, and the angular
    /// velocities are scaled by one factor, so that the bodies of the tag have `temperature`.
    #[doc(alias = "isokinetic")]
    Rescale,
}

/// A thermostat that acts at regular times on the bodies of a tag.
///
/// It acts at the times start + k · `every` of its stage, with k = 0, 1, 2, …, as long as they lie
/// before the end of the stage. `energy-reset` and `maxwell` leave out fixed bodies; the other
/// kinds refuse a tag that a fixed body carries.
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
    /// For `energy-reset`: kinetic energy of each body; for `maxwell`: mean energy of a body
    /// (mass × length² / time²), above 0 and at most 1e60. Either this or `temperature`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = MAX_MAGNITUDE), extend("exclusiveMinimum" = 0.0)))]
    pub energy: Option<f64>,
    /// For `energy-reset`, `maxwell`, `langevin` and `rescale`: temperature kT (mass × length² /
    /// time²), above 0 and at most 1e60: energy ½ f kT for a body of f = 2 degrees of freedom, or 3
    /// if contacts turn it. `langevin` needs it; else either this or `energy`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = MAX_MAGNITUDE), extend("exclusiveMinimum" = 0.0)))]
    pub temperature: Option<f64>,
    /// For `active`, required: speed along the axis (length per time), from 0 to 1e60; above 0
    /// without `translational_diffusion`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    pub speed: Option<f64>,
    /// For `active`, required: diffusion coefficient of the axis (radians² per time), from 0 to
    /// 1e60: the mean square of the angle grows as 2 D_r t.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    pub rotational_diffusion: Option<f64>,
    /// For `active`: diffusion coefficient of the centre of mass (length² per time), from 0 to
    /// 1e60, as a random velocity of variance 2 D/`every` per component. Default: 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    pub translational_diffusion: Option<f64>,
    /// For `langevin`, required: friction coefficient γ of v' = −γ v (1 / time), above 0 and at
    /// most 1e60. A single body of mass m diffuses with D = kT/(m γ).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = MAX_MAGNITUDE), extend("exclusiveMinimum" = 0.0)))]
    pub friction: Option<f64>,
    /// For `kick`, required: the momentum added to each body (mass × length / time). A number above
    /// 0: its magnitude, in a direction drawn for each body. A vector `[x, y]`: this momentum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub momentum: Option<KickMomentum>,
}

/// A single change of the energies of the bodies of a tag, at the start of a stage.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct HeatSpec {
    /// The tag of the bodies.
    pub tag: String,
    /// What is done: `energy-reset` or `maxwell`; the other kinds act at regular times only.
    /// Default: an energy reset.
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

/// Velocities that bodies get once, at the start of a stage.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct VelocitySpec {
    /// The tag of the bodies; excludes `body`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub tag: String,
    /// The number of the only body concerned, as messages name it; excludes `tag`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<u64>,
    /// Velocity of the centre of mass (length per time); without it the velocity remains.
    #[serde(
        skip_serializing_if = "Option::is_none",
        deserialize_with = "optional_vector"
    )]
    pub velocity: Option<[f64; 2]>,
    /// Angular velocity (radians per time, counter-clockwise); without it the angular velocity
    /// remains. Discs and locked molecules have none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angular_velocity: Option<f64>,
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
    /// One action as a change of energy at the start of a stage; `None` for kinds that act at
    /// regular times only.
    pub fn action(&self) -> Option<HeatSpec> {
        let is_single = matches!(
            self.kind,
            ThermostatKind::EnergyReset | ThermostatKind::Maxwell
        );
        is_single.then(|| HeatSpec {
            tag: self.tag.clone(),
            kind: self.kind,
            energy: self.energy,
            temperature: self.temperature,
        })
    }
}
