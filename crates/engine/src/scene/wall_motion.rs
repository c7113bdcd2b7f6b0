//! The motions that walls are given.

#[cfg(feature = "schema")]
use carom_geometry::MAX_MAGNITUDE;
use serde::{Deserialize, Serialize};

use crate::scene::{
    is_false, is_zero,
    two_numbers::{optional_vector, vector, vectors},
};

/// The motion of a wall, which contacts do not change: its mass is infinite.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // A piston at speed 1 meets a ball at rest, which leaves with twice its speed.
/// let mut simulation = Simulation::new(&Scene::from_toml(r#"
///     [[wall]]
///     x = 0.1
///     motion = { velocity = [1.0, 0.0] }
///     [[molecule]]
///     shape = "disc"
///     atom_radius = 0.1
///     atom_mass = 1.0
///     at = [0.4, 0.5]
/// "#)?)?;
/// simulation.run_until(0.25)?;
/// let view = simulation.view();
/// assert!((view.energy() - 2.0).abs() < 1e-15);
/// assert!((view.ledger().work - 2.0).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[doc(alias = "piston")]
pub struct WallMotionSpec {
    /// Velocity (length per time); of a wall that turns that of its pivot. Default: 0. Of a wall
    /// across the box only the component across it has an effect, unless contacts are rough.
    #[serde(deserialize_with = "vector", skip_serializing_if = "is_zero_vector")]
    #[cfg_attr(feature = "schema", schemars(inner(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE))))]
    pub velocity: [f64; 2],
    /// Angular velocity (radians per time, counter-clockwise) of a wall with end points. Default:
    /// 0.
    #[serde(skip_serializing_if = "is_zero")]
    #[cfg_attr(feature = "schema", schemars(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE)))]
    #[doc(alias = "paddle")]
    pub turn: f64,
    /// The pivot about which the wall turns (length): a place in the box, of which the image
    /// nearest to the middle of the wall counts. It moves with `velocity`. Default: the middle of
    /// the wall.
    #[serde(
        deserialize_with = "optional_vector",
        skip_serializing_if = "Option::is_none"
    )]
    #[doc(alias = "hinge")]
    pub about: Option<[f64; 2]>,
    /// Amplitude of an oscillation (length), shorter than the shorter side of the box: the wall is
    /// at A sin(Ω t + φ) from the middle of its oscillation, with the time t since the motion was
    /// given to it. It begins where it is. Excludes `velocity`, `turn`, `about` and `times`.
    #[serde(deserialize_with = "vector", skip_serializing_if = "is_zero_vector")]
    #[cfg_attr(feature = "schema", schemars(inner(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE))))]
    #[doc(alias = "shaker")]
    pub amplitude: [f64; 2],
    /// Angular frequency Ω of the oscillation (radians per time), positive.
    #[serde(skip_serializing_if = "is_zero")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    pub frequency: f64,
    /// Phase φ of the oscillation (radians). Default: 0, the middle.
    #[serde(skip_serializing_if = "is_zero")]
    #[cfg_attr(feature = "schema", schemars(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub phase: f64,
    /// Times of a table, from 0 on in ascending order, at least two: the time since the motion was
    /// given to the wall. With `places`; excludes `velocity`, `turn`, `about` and
    /// `amplitude`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(inner(range(min = 0.0, max = MAX_MAGNITUDE))))]
    pub times: Vec<f64>,
    /// Places of the wall at these times (length), between which it moves at constant velocity.
    /// Only their differences count: the wall begins where it is.
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "vectors")]
    pub places: Vec<[f64; 2]>,
    /// Whether the table begins anew after its last time. Default: the wall is then at rest.
    #[serde(skip_serializing_if = "is_false")]
    pub repeat: bool,
}

/// The motion of one or more walls from the start of a stage on.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MoveWallSpec {
    /// The tag of the walls.
    pub tag: String,
    /// Their motion, which replaces the one before. Default: at rest.
    pub motion: WallMotionSpec,
}

fn is_zero_vector(vector: &[f64; 2]) -> bool {
    *vector == [0.0; 2]
}
