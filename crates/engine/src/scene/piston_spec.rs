//! The description of a piston: a wall across the box that contacts move.

#[cfg(feature = "schema")]
use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE};
use serde::{Deserialize, Serialize};

use crate::scene::{is_one, is_zero, two_numbers::optional_vector};

/// A piston: a smooth wall across the box with a mass, which moves along its normal only. Contacts
/// change its velocity, a constant force or a spring may act on it, and it is reflected by two
/// stops.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // A piston of mass 3 that meets a ball of mass 1 at rest gives it 3/2 of its own velocity.
/// let mut simulation = Simulation::new(&Scene::from_toml(r#"
///     [[piston]]
///     x = 0.25
///     mass = 3.0
///     velocity = 1.0
///     stops = [0.1, 0.9]
///     [[molecule]]
///     shape = "disc"
///     atom_radius = 0.0625
///     atom_mass = 1.0
///     at = [0.5, 0.5]
/// "#)?)?;
/// simulation.run_until(0.25)?;
/// let view = simulation.view();
/// let velocities: Vec<f64> = view.bodies().map(|body| body.motion.velocity.x).collect();
/// assert_eq!(velocities, [1.5, 0.5]);
/// assert_eq!(view.energy(), view.ledger().booked());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[doc(alias = "movable wall")]
#[doc(alias = "barostat")]
pub struct PistonSpec {
    /// Tags of the piston.
    pub tags: Vec<String>,
    /// The piston is the line of all points with this x at the start (length), and moves along x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<f64>,
    /// The piston is the line of all points with this y at the start (length), and moves along y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<f64>,
    /// Half the thickness (length); 0 for a piston without thickness.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    pub radius: f64,
    /// Mass, from 10⁻⁶⁰ to 10⁶⁰.
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub mass: f64,
    /// Velocity at the start, upwards if positive (length per time). Default: 0.
    #[serde(skip_serializing_if = "is_zero")]
    #[cfg_attr(feature = "schema", schemars(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub velocity: f64,
    /// Constant force, upwards if positive (mass × length / time²): a pressure of |force| over the
    /// length of the piston. [`Ledger::fallen`](crate::Ledger::fallen) is its work. Default: 0.
    #[serde(skip_serializing_if = "is_zero")]
    #[cfg_attr(feature = "schema", schemars(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE)))]
    #[doc(alias = "load")]
    pub force: f64,
    /// Stiffness k of a spring that pulls the piston to `relaxed_at` (mass / time²), from 0,
    /// without one. Its energy is in [`Ledger::fallen`](crate::Ledger::fallen), too. Default: 0.
    #[serde(skip_serializing_if = "is_zero")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    pub spring: f64,
    /// Where the spring is relaxed (length), along the axis of the piston; it may be beyond the
    /// stops. Default: the place of the piston at the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE)))]
    #[doc(alias = "rest length")]
    pub relaxed_at: Option<f64>,
    /// The least and the largest place of the piston (length), between 0 and the side of the box.
    /// It is reflected there, without loss unless `stop_elasticity` is below 1. Default: where it
    /// would touch the nearest parallel walls across the box.
    #[serde(
        deserialize_with = "optional_vector",
        skip_serializing_if = "Option::is_none"
    )]
    pub stops: Option<[f64; 2]>,
    /// Share of its speed that the piston keeps at a stop, from 0 to 1; the energy lost is in
    /// [`Ledger::lost`](crate::Ledger::lost). At 0 it rests at the stop until a body pushes it
    /// away. Below 1 a guard prevents stops without end, with `elasticity.contact_time` for c, or
    /// its default if that is 0: a stop loses nothing if the piston moves by less than c of the way
    /// between its stops in the time since the last one, and a piston that is pressed against a
    /// stop keeps bouncing by c/4 of that way. Default: 1.
    #[serde(skip_serializing_if = "is_one")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1.0)))]
    #[doc(alias = "coefficient of restitution")]
    pub stop_elasticity: f64,
}

impl Default for PistonSpec {
    fn default() -> Self {
        Self {
            tags: Vec::new(),
            x: None,
            y: None,
            radius: 0.0,
            mass: 0.0,
            velocity: 0.0,
            force: 0.0,
            spring: 0.0,
            relaxed_at: None,
            stops: None,
            stop_elasticity: 1.0,
        }
    }
}

/// The force on one or more pistons from the start of a stage on.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct PushPistonSpec {
    /// The tag of the pistons.
    pub tag: String,
    /// Their constant force, upwards if positive (mass × length / time²). Default: 0.
    #[cfg_attr(feature = "schema", schemars(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub force: f64,
}
