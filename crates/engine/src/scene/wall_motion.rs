//! The motions that walls are given.

#[cfg(feature = "schema")]
use carom_geometry::MAX_MAGNITUDE;
use carom_geometry::{Molecule, check_length};
use carom_kinematics::Motion;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    contact::limits::refuse_slow,
    scene::{error::SceneError, two_numbers::vector},
    world::World,
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
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[doc(alias = "piston")]
pub struct WallMotionSpec {
    /// Velocity (length per time). Default: 0. Of a wall across the box only the component across
    /// it has an effect.
    #[serde(deserialize_with = "vector")]
    #[cfg_attr(feature = "schema", schemars(inner(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE))))]
    pub velocity: [f64; 2],
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

impl WallMotionSpec {
    /// The motion of a wall that is at `place` now. `entry` names the wall in errors.
    ///
    /// # Errors
    /// [`SceneError`] if a number is out of range.
    pub(crate) fn of_wall(
        &self,
        entry: &str,
        wall: &Molecule,
        place: &Motion,
    ) -> Result<Motion, SceneError> {
        for number in self.velocity {
            check_length("a component of the velocity of a wall", number).map_err(|reason| {
                SceneError::Geometry {
                    entry: entry.to_owned(),
                    reason,
                }
            })?;
        }
        let motion = Motion {
            velocity: DVec2::from(self.velocity),
            angular_velocity: 0.0,
            ..*place
        };
        refuse_slow(entry, &motion, wall.bounding_radius())?;
        Ok(motion)
    }
}

/// Refuses walls that move in a system with a drag.
///
/// In the clock of the drag all free bodies move uniformly ([`DragClock`]), but a wall of constant
/// velocity does not.
///
/// [`DragClock`]: carom_kinematics::DragClock
pub(crate) fn refuse_drag(world: &World, name: impl Fn(usize) -> String) -> Result<(), SceneError> {
    match world.moving_walls().next() {
        Some(wall) if !world.clock.is_free() => Err(SceneError::Entry {
            entry: name(wall),
            problem: format!(
                "a wall cannot move where bodies have a drag, which is {} (1/time): set the drag to 0, or leave out \
                 the motion of the wall",
                world.clock.drag()
            ),
        }),
        _ => Ok(()),
    }
}
