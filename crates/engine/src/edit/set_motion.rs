//! Velocities and angular velocities that a caller sets.

use carom_geometry::check_length;
use carom_kinematics::Motion;
use glam::DVec2;

use crate::{
    contact::limits::refuse_slow,
    edit::batch::Batch,
    scene::error::{EditError, SceneError},
    world::body::{Body, BodyKey, BodyName},
};

impl Batch {
    /// Sets the velocity of the centre of mass of a body (length per time). The change of energy is
    /// recorded in [`Ledger::put_in`](crate::Ledger::put_in).
    ///
    /// ```
    /// use carom_engine::{Scene, Simulation};
    ///
    /// let scene = Scene::from_toml("[[gas]]\nradius = 0.01\nmass = 2.0\nenergy = 1.0\ncount = 100")?;
    /// let mut simulation = Simulation::new(&scene)?;
    /// simulation.run_until(0.5)?;
    /// // All bodies move along x with speed 3.
    /// simulation.edit(|batch| {
    ///     let keys: Vec<_> = batch.moving().collect();
    ///     keys.into_iter().try_for_each(|key| batch.set_velocity(key, [3.0, 0.0]))
    /// })?;
    /// assert!((simulation.view().energy() - 100.0 * 9.0).abs() < 1e-9);
    /// let ledger = simulation.view().ledger();
    /// assert!((ledger.booked() - simulation.view().energy()).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`EditError::Fixed`], [`EditError::NoSuchBody`], or [`EditError::Scene`] if a component is
    /// not finite or above 10⁶⁰, or the speed is below [`MIN_SPEED`](crate::MIN_SPEED) and not 0.
    pub fn set_velocity(&mut self, key: BodyKey, velocity: [f64; 2]) -> Result<(), EditError> {
        let index = self.index(key)?;
        self.refuse_fixed(index)?;
        let body = &self.world.bodies[index];
        if let Some(axis) = body.axis_of_piston()
            && velocity[1 - axis] != 0.0
        {
            return Err(EditError::Scene(SceneError::of_entry(
                &self.name(index).to_string(),
                format!("a piston moves along its normal only, but the velocity is {velocity:?}"),
            )));
        }
        let motion = Motion {
            velocity: DVec2::from(velocity),
            ..self.world.motions[index]
        };
        self.set_motion(index, &motion)
    }

    /// Sets the angular velocity of a body (radians per time, counter-clockwise). The change of
    /// energy is recorded in [`Ledger::put_in`](crate::Ledger::put_in).
    ///
    /// # Errors
    /// [`EditError::CannotTurn`] for a single disc and for a body whose orientation is locked,
    /// [`EditError::Fixed`], [`EditError::NoSuchBody`], or [`EditError::Scene`] if the angular
    /// velocity is not finite or above 10⁶⁰, or the speed of the rim is below
    /// [`MIN_SPEED`](crate::MIN_SPEED) and not 0.
    pub fn set_angular_velocity(
        &mut self,
        key: BodyKey,
        angular_velocity: f64,
    ) -> Result<(), EditError> {
        let index = self.index(key)?;
        self.refuse_fixed(index)?;
        let body = &self.world.bodies[index];
        let is_idle = body.molecule().is_disc() && !self.world.has_rough_contacts;
        if body.is_locked() || is_idle {
            return Err(EditError::CannotTurn(self.name(index)));
        }
        let motion = Motion {
            angular_velocity,
            ..self.world.motions[index]
        };
        self.set_motion(index, &motion)
    }

    /// Sets velocity and angular velocity of a body to those of a motion.
    fn set_motion(&mut self, index: usize, motion: &Motion) -> Result<(), EditError> {
        refuse_motion(&self.world.bodies[index], motion, || {
            self.name(index).to_string()
        })?;
        self.start_to_move();
        let present = &mut self.world.motions[index];
        present.velocity = motion.velocity;
        present.angular_velocity = motion.angular_velocity;
        self.moves = true;
        Ok(())
    }

    pub(super) fn refuse_fixed(&self, index: usize) -> Result<(), EditError> {
        if self.world.bodies[index].is_fixed() {
            return Err(EditError::Fixed(self.name(index)));
        }
        Ok(())
    }

    pub(super) fn name(&self, index: usize) -> BodyName {
        BodyName::new(&self.world.bodies[index], &self.names)
    }
}

/// Refuses a motion that is too fast, or too slow and not at rest, for a body of this name.
pub(super) fn refuse_motion(
    body: &Body,
    motion: &Motion,
    name: impl Fn() -> String,
) -> Result<(), EditError> {
    let radius = body.molecule().bounding_radius();
    let in_range = [
        ("a component of the velocity", motion.velocity.x),
        ("a component of the velocity", motion.velocity.y),
        ("the angular velocity", motion.angular_velocity),
        ("the rim speed", motion.angular_velocity * radius),
    ];
    for (quantity, value) in in_range {
        check_length(quantity, value).map_err(|reason| SceneError::Geometry {
            entry: name(),
            reason,
        })?;
    }
    // The name is needed for the error alone.
    refuse_slow("", motion, radius)
        .or_else(|_| refuse_slow(&name(), motion, radius))
        .map_err(EditError::from)
}

#[cfg(test)]
mod tests {
    use crate::{EditError, Scene, Simulation};

    const BODIES: &str = r#"
        [[molecule]]
        shape = "tee"
        atom_radius = 0.01
        atom_mass = 1.0
        at = [0.2, 0.1]
        [[molecule]]
        shape = "tee"
        atom_radius = 0.01
        atom_mass = 1.0
        at = [0.4, 0.1]
        rotation = "locked"
        [[molecule]]
        shape = "disc"
        atom_radius = 0.01
        atom_mass = 1.0
        at = [0.6, 0.1]
        [[bumper]]
        tags = ["post"]
        radius = 0.01
        at = [0.8, 0.1]
    "#;

    #[test]
    fn velocities_are_set_and_booked() {
        let mut simulation = Simulation::new(&Scene::from_toml(BODIES).unwrap()).unwrap();
        let keys: Vec<_> = simulation.view().bodies().map(|b| b.body.key()).collect();
        simulation.set_velocity(keys[0], [1.0, -2.0]).unwrap();
        simulation.set_velocity(keys[1], [0.5, 0.0]).unwrap();
        simulation.set_angular_velocity(keys[0], 3.0).unwrap();
        simulation.run_until(0.02).unwrap();
        simulation.set_velocity(keys[1], [0.0, 0.0]).unwrap();
        let view = simulation.view();
        let motion = view.body(keys[0]).unwrap().motion;
        assert_eq!(motion.velocity.to_array(), [1.0, -2.0]);
        assert_eq!(motion.angular_velocity, 3.0);
        let energy = view.energy();
        assert!(energy > 12.5 && (view.ledger().put_in - energy).abs() < 1e-14);
    }

    #[test]
    fn bodies_that_cannot_move_or_turn_and_speeds_out_of_range_are_refused_by_name() {
        let mut simulation = Simulation::new(&Scene::from_toml(BODIES).unwrap()).unwrap();
        let keys: Vec<_> = simulation.view().bodies().map(|b| b.body.key()).collect();
        let words = |refused: Result<(), EditError>| refused.unwrap_err().to_string();
        assert!(words(simulation.set_velocity(keys[3], [0.0; 2])).contains("body 3 (tag post)"));
        assert!(words(simulation.set_angular_velocity(keys[3], 0.0)).contains("is fixed"));
        for key in [keys[1], keys[2]] {
            let refused = simulation.set_angular_velocity(key, 1.0);
            assert!(matches!(refused, Err(EditError::CannotTurn(name)) if name.key == key));
        }
        for value in [f64::NAN, f64::INFINITY, 1e61, 1e-80] {
            let refused = words(simulation.set_velocity(keys[2], [value, 0.0]));
            assert!(refused.starts_with("body 2"), "{value}: {refused}");
            let refused = words(simulation.set_angular_velocity(keys[0], value));
            assert!(refused.starts_with("body 0"), "{value}: {refused}");
        }
        assert_eq!(simulation.view().energy(), 0.0);
    }
}
