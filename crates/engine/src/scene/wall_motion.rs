//! The motions that walls are given.

use std::sync::Arc;

#[cfg(feature = "schema")]
use carom_geometry::MAX_MAGNITUDE;
use carom_geometry::{Molecule, PeriodicBox, check_length};
use carom_kinematics::Motion;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    contact::limits::refuse_slow,
    scene::{
        error::SceneError,
        is_zero,
        two_numbers::{optional_vector, vector},
    },
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
    /// Velocity (length per time); of a wall that turns that of its pivot. Default: 0. Of a wall
    /// across the box only the component across it has an effect.
    #[serde(deserialize_with = "vector", skip_serializing_if = "is_zero_vector")]
    #[cfg_attr(feature = "schema", schemars(inner(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE))))]
    pub velocity: [f64; 2],
    /// Angular velocity (radians per time, counter-clockwise) of a wall with end points. Default: 0.
    #[serde(skip_serializing_if = "is_zero")]
    #[cfg_attr(feature = "schema", schemars(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE)))]
    #[doc(alias = "paddle")]
    pub turn: f64,
    /// The pivot about which the wall turns (length): a place in the box, of which the image nearest
    /// to the middle of the wall counts. It moves with `velocity`. Default: the middle of the wall.
    #[serde(
        deserialize_with = "optional_vector",
        skip_serializing_if = "Option::is_none"
    )]
    #[doc(alias = "hinge")]
    pub about: Option<[f64; 2]>,
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
    /// The motion of a wall that is at `place` now, and the wall with its pivot at the origin; `None`
    /// if its shape remains. `entry` names the wall in errors.
    ///
    /// # Errors
    /// [`SceneError`] if a number is out of range, or if the wall cannot turn.
    pub(crate) fn of_wall(
        &self,
        entry: &str,
        wall: &Molecule,
        place: &Motion,
        bounds: &PeriodicBox,
    ) -> Result<(Motion, Option<Molecule>), SceneError> {
        let geometry = |reason| SceneError::Geometry {
            entry: entry.to_owned(),
            reason,
        };
        let numbers = self
            .velocity
            .iter()
            .chain([&self.turn])
            .chain(self.about.iter().flatten());
        for &number in numbers {
            check_length("a number of the motion of a wall", number).map_err(geometry)?;
        }
        let mut motion = Motion {
            velocity: DVec2::from(self.velocity),
            angular_velocity: self.turn,
            ..*place
        };
        let Some(edge) = wall.wall_edge().filter(|_| self.turn != 0.0) else {
            refuse_slow(entry, &motion, wall.bounding_radius())?;
            return Ok((motion, None));
        };
        let problem = |problem: String| SceneError::Entry {
            entry: entry.to_owned(),
            problem,
        };
        if wall.atoms().is_empty() {
            return Err(problem(
                "a wall across the box cannot turn: give it end points (`from` and `to`)".to_owned(),
            ));
        }
        let (length, side) = (2.0 * edge.half_length(), bounds.sides().min_element());
        if length >= side {
            return Err(problem(format!(
                "a wall that turns must be shorter than the shorter side of the box, {side:e}, but its length is \
                 {length:e}: it would pass through its own image"
            )));
        }
        let rotation = place.orientation.cos_sin();
        let middle = place.position + rotation.rotate(edge.middle());
        let to_pivot = self.about.map_or(DVec2::ZERO, |about| {
            bounds.nearest_image(DVec2::from(about) - middle)
        });
        let back = DVec2::new(rotation.x, -rotation.y);
        let span = wall.atoms()[1].offset() - wall.atoms()[0].offset();
        let turned = Molecule::wall_about(span, back.rotate(-to_pivot), edge.radius());
        let turned = turned.map_err(geometry)?;
        motion.position = middle + to_pivot;
        refuse_slow(entry, &motion, turned.bounding_radius())?;
        Ok((motion, Some(turned)))
    }

    /// Gives this motion to a wall of a world. `entry` names the wall in errors.
    ///
    /// # Errors
    /// Those of [`Self::of_wall`]; the wall is then unchanged.
    pub(crate) fn set(&self, world: &mut World, wall: usize, entry: &str) -> Result<(), SceneError> {
        let (kind, place) = (&mut world.bodies[wall].kind, &mut world.motions[wall]);
        let (motion, molecule) = self.of_wall(entry, &kind.molecule, place, &world.bounds)?;
        if let Some(molecule) = molecule {
            Arc::make_mut(kind).molecule = Arc::new(molecule);
        }
        let (position, image) = world.bounds.wrap(motion.position);
        *place = Motion { position, ..motion };
        let winding = &mut world.windings[wall];
        *winding = [winding[0] + image[0], winding[1] + image[1]];
        Ok(())
    }
}

fn is_zero_vector(vector: &[f64; 2]) -> bool {
    *vector == [0.0; 2]
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
