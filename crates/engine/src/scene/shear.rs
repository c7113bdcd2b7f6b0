//! The range of a shear rate, and what cannot be sheared.

use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE};

use crate::{
    scene::{StageSpec, error::SceneError},
    world::World,
};

impl StageSpec {
    /// Checks the shear rate of this stage, if there is one. `entry` names the stage in errors.
    ///
    /// # Errors
    /// [`SceneError::Entry`] if it is neither 0 nor from 10⁻⁶⁰ to 10⁶⁰ in magnitude.
    pub fn check_shear_rate(&self, entry: &str) -> Result<(), SceneError> {
        let rate = self.shear_rate.unwrap_or(0.0);
        shear_rate_of(&format!("{entry}.shear_rate"), rate).map(|_| ())
    }
}

/// A shear rate that is 0, or from 10⁻⁶⁰ to 10⁶⁰ in magnitude (1/time).
pub(crate) fn shear_rate_of(entry: &str, rate: f64) -> Result<f64, SceneError> {
    let is_allowed = rate == 0.0 || (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(&rate.abs());
    if is_allowed {
        return Ok(rate + 0.0);
    }
    Err(SceneError::Entry {
        entry: entry.to_owned(),
        problem: format!(
            "a shear rate must be 0 or from {MIN_MAGNITUDE:e} to {MAX_MAGNITUDE:e} in magnitude \
             (1/time), but is {rate}"
        ),
    })
}

/// Refuses a shear with what is not at rest relative to its images, with a drag, a gravity and
/// reactions.
pub(crate) fn refuse_shear(
    world: &World,
    name: impl Fn(usize) -> String,
) -> Result<(), SceneError> {
    let problem = |problem: String| {
        Err(SceneError::Entry {
            entry: "shear_rate".to_owned(),
            problem,
        })
    };
    if !world.is_sheared() {
        return Ok(());
    }
    if let Some(body) = world.bodies.iter().position(|body| !body.is_free()) {
        return problem(format!(
            "{} stays where it is, but its images above and below would move: remove all walls, \
             pistons and fixed bodies, or the shear",
            name(body)
        ));
    }
    if !world.clock.is_free() {
        return problem(format!(
            "bodies cannot have both a shear and a drag, which is {} (1/time): set one of them to 0",
            world.clock.drag()
        ));
    }
    if world.has_reactions {
        return problem("bodies cannot react under a shear yet: leave out one of them".to_owned());
    }
    if world.has_gravity() {
        return problem("bodies cannot have both a shear and a gravity: leave out one".to_owned());
    }
    Ok(())
}
