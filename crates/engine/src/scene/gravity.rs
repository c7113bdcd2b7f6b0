//! The acceleration of all free bodies by gravity.

use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    scene::{StageSpec, error::SceneError, two_numbers::vector},
    world::{World, body::Body},
};

/// A uniform gravity. Free bodies fall on parabolas; a wall across the box must stop them.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // A ball that is let fall from 1/2 above the floor returns there.
/// let mut simulation = Simulation::new(&Scene::from_toml(r#"
///     [gravity]
///     acceleration = [0.0, -1.0]
///     [[wall]]
///     y = 0.125
///     [[molecule]]
///     shape = "disc"
///     atom_radius = 0.125
///     atom_mass = 1.0
///     at = [0.5, 0.75]
/// "#)?)?;
/// simulation.run_until(0.5)?;
/// let ball = simulation.view().bodies().next().unwrap().motion;
/// assert!((ball.position.y - 0.625).abs() < 1e-15 && (ball.velocity.y + 0.5).abs() < 1e-15);
/// simulation.run_until(2.0)?;
/// let ball = simulation.view().bodies().next().unwrap().motion;
/// assert!((ball.position.y - 0.75).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[doc(alias = "field")]
pub struct GravitySpec {
    /// Acceleration of all free bodies (length per time squared): each component is 0, or from
    /// 10⁻⁶⁰ to 10⁶⁰ in magnitude. Default: 0.
    #[cfg_attr(feature = "schema", schemars(inner(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE))))]
    #[serde(deserialize_with = "vector")]
    pub acceleration: [f64; 2],
}

impl GravitySpec {
    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.acceleration == [0.0; 2]
    }
}

impl StageSpec {
    /// The gravity from this stage on (length per time squared); `None` if the stage does not
    /// change it. `entry` names the stage in errors.
    ///
    /// # Errors
    /// [`SceneError::Entry`] if a number is not finite, or neither 0 nor from 10⁻⁶⁰ to 10⁶⁰ in
    /// magnitude.
    pub fn gravity(&self, entry: &str) -> Result<Option<DVec2>, SceneError> {
        self.gravity
            .map(|gravity| gravity_of(&format!("{entry}.gravity"), gravity))
            .transpose()
    }
}

/// A gravity whose components are 0, or from 10⁻⁶⁰ to 10⁶⁰ in magnitude.
pub(crate) fn gravity_of(entry: &str, gravity: [f64; 2]) -> Result<DVec2, SceneError> {
    let is_allowed = |number: &f64| {
        number.abs() <= MAX_MAGNITUDE && (*number == 0.0 || number.abs() >= MIN_MAGNITUDE)
    };
    if gravity.iter().all(is_allowed) {
        return Ok(DVec2::from(gravity) + 0.0);
    }
    Err(SceneError::Entry {
        entry: entry.to_owned(),
        problem: format!(
            "the components of gravity must be 0 or from {MIN_MAGNITUDE:e} to {MAX_MAGNITUDE:e} in magnitude (length/time²), but are \
             {gravity:?}"
        ),
    })
}

/// Refuses a gravity that cannot be computed: with drag, with curved walls, or without a wall
/// across the box in its way.
pub(crate) fn refuse_gravity(world: &World) -> Result<(), SceneError> {
    let problem = |problem: String| Err(SceneError::of_entry("gravity", problem));
    if !world.has_gravity() {
        return Ok(());
    }
    if !world.clock.is_free() {
        return problem(format!(
            "bodies cannot have both a gravity and a drag, which is {} (1/time): set one of them to 0",
            world.clock.drag()
        ));
    }
    let bends = |body: &Body| {
        let edge = body.molecule().wall_edge();
        edge.is_some_and(|edge| edge.bend().is_some())
    };
    if world.bodies.iter().any(bends) {
        return problem(
            "curved walls are not searched for bodies that fall yet: use straight walls".to_owned(),
        );
    }
    let is_fixed_disc = |body: &Body| body.is_fixed() && body.molecule().is_disc();
    if world.pairs.changes_distances() && world.bodies.iter().any(is_fixed_disc) {
        return problem(
            "rules of diameters and wells do not apply to fixed discs where bodies fall yet: leave out the discs or the rules"
                .to_owned(),
        );
    }
    refuse_endless_fall(world)
}

/// Refuses bodies that would fall for ever through the periodic box.
fn refuse_endless_fall(world: &World) -> Result<(), SceneError> {
    let stops = |wall: &Body, axis: usize| wall.axis_across() == Some(axis);
    for (axis, name) in ["x", "y"].into_iter().enumerate() {
        if world.gravity[axis] == 0.0 {
            continue;
        }
        if !world.bodies.iter().any(|wall| stops(wall, axis)) {
            return Err(SceneError::of_entry(
                "gravity",
                format!(
                    "bodies would fall for ever through the periodic box along {name}: add a wall across the box \
                     (`[[wall]]` with `{name}`)"
                ),
            ));
        }
        let is_stopped = |body: usize| {
            let mut walls = world.bodies.iter().enumerate();
            walls.any(|(wall, of_wall)| {
                stops(of_wall, axis) && world.pair_factor([body as u32, wall as u32]) > 0.0
            })
        };
        let falls_for_ever = |&body: &usize| world.bodies[body].is_free() && !is_stopped(body);
        if world.pairs.is_active()
            && let Some(body) = (0..world.bodies.len()).find(falls_for_ever)
        {
            return Err(SceneError::of_entry(
                "gravity",
                format!(
                    "body {body} would fall for ever, because it does not see the walls across the box in its way: change \
                     `transparent`"
                ),
            ));
        }
    }
    Ok(())
}
