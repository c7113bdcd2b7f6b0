//! Thermostats: edits by which a rule changes the motions of all bodies of a tag.

use carom_kinematics::{Motion, Orientation, kinetic_energy};
use glam::DVec2;

use crate::{
    edit::{
        batch::{Batch, energy_factor},
        draw_key::DrawKey,
        motion_rule::{
            ActionDraw, active, first_axis, kicked, langevin, maxwell, rotated, turned_axis,
        },
        set_motion::refuse_motion,
    },
    scene::{
        error::EditError,
        thermostat_rule::{SelfPropulsion, ThermostatRule},
        thermostat_target::ThermostatTarget,
    },
    world::{
        centre_of_mass::CentreOfMassFrame,
        heat::{ThermostatCounts, exact_sum},
        tags::Tag,
        view::body_at,
    },
};

/// A change of all velocities relative to one of them, by a factor.
#[derive(Debug, Clone, Copy)]
struct Rescaling {
    factor: f64,
    /// The velocity that remains (length / time).
    about: DVec2,
}

impl Rescaling {
    fn apply(self, motion: &Motion) -> Motion {
        Motion {
            velocity: self.about + self.factor * (motion.velocity - self.about),
            angular_velocity: self.factor * motion.angular_velocity,
            ..*motion
        }
    }
}

/// The effect of a thermostat on a body.
enum Effect {
    Changed(Motion),
    /// A round body moves along an axis of its own.
    Driven(Motion, Orientation),
    AtRest,
    Fixed,
}

impl Batch {
    /// Lets a thermostat act once on each body with this tag. The change of energy is booked as
    /// heat of the tag ([`View::heat`](crate::View::heat)).
    ///
    /// The random numbers of a body depend on `key` and on its handle alone. Under shear a rule
    /// acts on velocities relative to the flow.
    ///
    /// ```
    /// use carom_engine::{DrawKey, Scene, Simulation, ThermostatRule, ThermostatTarget};
    ///
    /// let scene = Scene::from_toml(
    ///     "[[gas]]\ntags = [\"gas\"]\nradius = 1e-3\nmass = 2.0\nenergy = 1.0\ncount = 2000",
    /// )?;
    /// let mut simulation = Simulation::new(&scene)?;
    /// let gas = simulation.find_tag("gas").expect("the scene names it");
    /// let key = DrawKey { seed: 1, replica: 0, action: 0 };
    /// let rule = ThermostatRule::Maxwell(ThermostatTarget::Temperature(3.0));
    /// simulation.edit(|batch| batch.thermostat(gas, &rule, key))?;
    /// let temperature = simulation.view().temperature().expect("the discs move");
    /// // The relative standard error is 1/√2000 = 2.2 %.
    /// assert!((temperature / 3.0 - 1.0).abs() < 0.07);
    /// assert_eq!(simulation.view().heat().heat(gas), simulation.view().ledger().put_in);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`EditError::Energy`] if an energy or temperature is not positive and finite, or gives a
    /// speed out of range. [`EditError::Fixed`] if a rule that sets velocities meets a fixed body.
    /// [`EditError::CannotTurn`] if the axis of a locked body should diffuse. [`EditError::Scene`]
    /// if a velocity is out of range. In each case nothing changes.
    #[doc(alias = "energy reset")]
    #[doc(alias = "Andersen")]
    pub fn thermostat(
        &mut self,
        tag: Tag,
        rule: &ThermostatRule,
        key: DrawKey,
    ) -> Result<ThermostatCounts, EditError> {
        self.start_to_move();
        let rescaling = self.rescaling(tag, rule);
        let (mut counts, mut changes) = (ThermostatCounts::default(), Vec::new());
        for index in self.members(tag) {
            match self.effect(index, rule, rescaling, key)? {
                Effect::Changed(motion) => changes.push((index, motion, None)),
                Effect::Driven(motion, axis) => changes.push((index, motion, Some(axis))),
                Effect::AtRest => counts.at_rest += 1,
                Effect::Fixed => counts.fixed += 1,
            }
        }
        counts.changed = changes.len() as u64;
        let before = self.energies_of(tag);
        self.moves |= !changes.is_empty();
        for (index, mut motion, axis) in changes {
            if self.world.is_sheared() {
                motion.velocity += self.world.flow_at(motion.position);
            }
            self.world.motions[index] = motion;
            if let Some(axis) = axis {
                self.world.set_axis(index, axis);
            }
        }
        let change = self
            .energies_of(tag)
            .into_iter()
            .chain(before.iter().map(|energy| -energy));
        self.heat.give(tag, exact_sum(change), counts);
        Ok(counts)
    }

    /// The motion of a body relative to the flow.
    fn relative_to_flow(&self, index: usize) -> Motion {
        let mut motion = self.world.motions[index];
        if self.world.is_sheared() {
            motion.velocity -= self.world.flow_at(motion.position);
        }
        motion
    }

    /// The motion that a rule gives to a body, relative to the flow.
    fn effect(
        &self,
        index: usize,
        rule: &ThermostatRule,
        rescaling: Option<Rescaling>,
        key: DrawKey,
    ) -> Result<Effect, EditError> {
        let (body, motion) = (&self.world.bodies[index], &self.relative_to_flow(index));
        let draw = ActionDraw::new(body, key);
        let changed = match rule {
            ThermostatRule::EnergyReset(_) | ThermostatRule::Maxwell(_) if !body.is_free() => {
                return Ok(Effect::Fixed);
            }
            ThermostatRule::EnergyReset(target) => return self.reset(index, *target),
            ThermostatRule::Maxwell(target) => {
                let temperature = target.temperature_of(body);
                return maxwell(body, motion, temperature, &draw).map(Effect::Changed);
            }
            _ if !body.is_free() => return Err(EditError::Fixed(self.name(index))),
            ThermostatRule::Active(rule) => return self.drive(index, rule, key),
            ThermostatRule::Langevin(step) => langevin(body, motion, step, &draw),
            ThermostatRule::Rotate => match rotated(motion, &draw) {
                Some(motion) => motion,
                None => return Ok(Effect::AtRest),
            },
            ThermostatRule::Kick(momentum) => kicked(body, motion, *momentum, &draw),
            ThermostatRule::Rescale(_) => match rescaling {
                Some(rescaling) => rescaling.apply(motion),
                None => return Ok(Effect::AtRest),
            },
        };
        refuse_motion(body, &changed, || self.name(index).to_string())?;
        Ok(Effect::Changed(changed))
    }

    /// The change of scale by which the bodies of a tag reach the temperature of a rule; `None` for
    /// other rules, and without a thermal motion.
    fn rescaling(&self, tag: Tag, rule: &ThermostatRule) -> Option<Rescaling> {
        let ThermostatRule::Rescale(temperature) = *rule else {
            return None;
        };
        let frame = CentreOfMassFrame::new(&self.world, 0.0);
        let members = self.members(tag);
        let thermal = frame.thermal(members.map(|index| body_at(&self.world, index, 0.0)));
        let now = thermal.temperature().filter(|now| *now > 0.0)?;
        Some(Rescaling {
            factor: (temperature / now).sqrt(),
            about: frame.velocity(),
        })
    }

    /// Self-propulsion along the axis of a body.
    fn drive(
        &self,
        index: usize,
        rule: &SelfPropulsion,
        key: DrawKey,
    ) -> Result<Effect, EditError> {
        let (body, motion) = (&self.world.bodies[index], &self.relative_to_flow(index));
        let draw = ActionDraw::new(body, key);
        let has_own_axis = body.molecule().is_round() && !body.can_turn();
        let own_axis = has_own_axis.then(|| {
            let before = self.world.axis(index);
            let before = before.unwrap_or_else(|| first_axis(body, key));
            turned_axis(before, rule, &draw)
        });
        let diffuses = rule.rotational_diffusion > 0.0;
        if own_axis.is_none() && body.is_locked() && diffuses {
            return Err(EditError::CannotTurn(self.name(index)));
        }
        let axis = own_axis.unwrap_or(motion.orientation);
        let motion = active(body, motion, axis, rule, &draw);
        refuse_motion(body, &motion, || self.name(index).to_string())?;
        Ok(own_axis.map_or(Effect::Changed(motion), |axis| Effect::Driven(motion, axis)))
    }

    fn reset(&self, index: usize, target: ThermostatTarget) -> Result<Effect, EditError> {
        let energy = target.energy_of(&self.world.bodies[index]);
        let mut motion = self.relative_to_flow(index);
        match energy_factor(&self.world, &self.names, (index, &motion), energy) {
            Ok(factor) => {
                motion.velocity *= factor;
                motion.angular_velocity *= factor;
                Ok(Effect::Changed(motion))
            }
            Err(EditError::NoEnergy(_)) => Ok(Effect::AtRest),
            Err(error) => Err(error),
        }
    }

    /// Kinetic energy of each body with a tag (mass × length² / time²).
    fn energies_of(&self, tag: Tag) -> Vec<f64> {
        let world = &self.world;
        let energies = self
            .members(tag)
            .map(|index| kinetic_energy(&world.motions[index], world.bodies[index].inertia()));
        energies.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        run::simulation::Simulation,
        scene::{
            Scene,
            kick_momentum::KickMomentum,
            thermostat_rule::{LangevinStep, SelfPropulsion},
        },
    };

    const MIXTURE: &str = r#"
        [box]
        sides = [10.0, 10.0]
        [[molecule]]
        tags = ["a"]
        shape = "dumbbell"
        atom_radius = 0.01
        atom_mass = 1.0
        at = [0.1, 0.1]
        rotation = "locked"
        velocity = [1.0, 0.0]
        [[molecule]]
        tags = ["a"]
        shape = "disc"
        atom_radius = 0.01
        atom_mass = 1.0
        at = [0.3, 0.1]
        [[bumper]]
        tags = ["a"]
        radius = 0.01
        at = [0.5, 0.1]
        [[molecule]]
        tags = ["a"]
        shape = "tee"
        atom_radius = 0.01
        atom_mass = 1.0
        at = [0.7, 0.1]
        angular_velocity = 1.0
        [[molecule]]
        tags = ["b"]
        shape = "tee"
        atom_radius = 0.01
        atom_mass = 1.0
        at = [0.9, 0.1]
        velocity = [1.0, 0.0]
    "#;

    const KEY: DrawKey = DrawKey {
        seed: 3,
        replica: 1,
        action: 7,
    };

    fn mixture() -> (Simulation, Tag) {
        let simulation = Simulation::new(&Scene::from_toml(MIXTURE).unwrap()).unwrap();
        let tag = simulation.find_tag("a").unwrap();
        (simulation, tag)
    }

    #[test]
    fn fixed_bodies_and_bodies_at_rest_are_counted() {
        let (mut simulation, a) = mixture();
        let target = ThermostatTarget::Temperature(2.0);
        let counts = simulation
            .edit(|batch| batch.thermostat(a, &ThermostatRule::EnergyReset(target), KEY))
            .unwrap();
        assert_eq!(
            counts,
            ThermostatCounts {
                changed: 2,
                at_rest: 1,
                fixed: 1
            }
        );
        // ½ · 2 · kT for the locked dumbbell, ½ · 3 · kT for the tee.
        let energies: Vec<f64> = simulation
            .view()
            .bodies()
            .map(|body| body.energy())
            .collect();
        for (energy, expected) in energies.iter().zip([2.0, 0.0, 3.0]) {
            assert!((energy - expected).abs() < 1e-14, "{energies:?}");
        }
        let ledger = simulation.view().ledger();
        assert!((simulation.view().heat().heat(a) - ledger.put_in).abs() < 1e-14);
        assert!((ledger.booked() - simulation.view().energy()).abs() < 1e-14);
        let counts = simulation
            .edit(|batch| batch.thermostat(a, &ThermostatRule::Maxwell(target), KEY))
            .unwrap();
        assert_eq!(
            counts,
            ThermostatCounts {
                changed: 3,
                at_rest: 0,
                fixed: 1
            }
        );
        let all = ThermostatCounts {
            changed: 5,
            at_rest: 1,
            fixed: 2,
        };
        assert_eq!(simulation.view().heat().all()[0].counts, all);
        for (index, body) in simulation.view().bodies().enumerate() {
            // Molecules first: the dumbbell is locked, the disc is round, the last tee has tag b.
            assert_eq!(body.motion.angular_velocity != 0.0, index == 2, "{index}");
        }
    }

    /// A mixture and a flow: kT of all is that of the rule, and the momentum remains.
    #[test]
    fn one_factor_brings_all_bodies_to_a_temperature() {
        for rate in [0.0, 0.7] {
            let text = format!(
                "[box]\nsides = [2.0, 1.0]\nshear_rate = {rate:?}\n[[gas]]\ntags = [\"all\"]\nradius = 0.01\n\
                 mass = 2.0\nenergy = 1.0\ncount = 60\n[[gas]]\ntags = [\"all\"]\nshape = \"tee\"\n\
                 atom_radius = 0.01\natom_mass = 1.0\nenergy = 3.0\ncount = 40"
            );
            let mut simulation = Simulation::new(&Scene::from_toml(&text).unwrap()).unwrap();
            let all = simulation.find_tag("all").unwrap();
            simulation.run_until(0.4).unwrap();
            let frame = simulation.view().centre_of_mass_frame();
            let rule = ThermostatRule::Rescale(0.25);
            let counts = simulation
                .edit(|batch| batch.thermostat(all, &rule, KEY))
                .unwrap();
            assert_eq!(counts.changed, 100);
            let view = simulation.view();
            assert!((view.temperature().unwrap() - 0.25).abs() < 1e-14);
            let drift = view.centre_of_mass_frame().velocity() - frame.velocity();
            assert!(drift.length() < 1e-14);
            let ledger = view.ledger();
            assert!((ledger.booked() / view.energy() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn draws_depend_on_the_key_and_the_body_alone() {
        let target = ThermostatTarget::Temperature(2.0);
        let drawn = |key: DrawKey, remove: bool| {
            let (mut simulation, a) = mixture();
            if remove {
                let first = simulation.view().bodies().next().unwrap().body.key();
                simulation.remove(first).unwrap();
            }
            simulation
                .edit(|batch| batch.thermostat(a, &ThermostatRule::Maxwell(target), key))
                .unwrap();
            let disc = simulation
                .view()
                .bodies()
                .find(|body| body.body.molecule().is_disc())
                .unwrap();
            disc.motion.velocity
        };
        assert_eq!(drawn(KEY, false), drawn(KEY, true));
        for other in [
            DrawKey { seed: 4, ..KEY },
            DrawKey { replica: 2, ..KEY },
            DrawKey { action: 8, ..KEY },
        ] {
            assert_ne!(drawn(KEY, false), drawn(other, false));
        }
    }

    #[test]
    fn targets_out_of_range_change_nothing() {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e200] {
            for target in [
                ThermostatTarget::Energy(value),
                ThermostatTarget::Temperature(value),
            ] {
                let (mut simulation, a) = mixture();
                let before = simulation.view().energy();
                let refused = simulation
                    .edit(|batch| batch.thermostat(a, &ThermostatRule::EnergyReset(target), KEY));
                assert!(matches!(refused, Err(EditError::Energy(_))), "{target:?}");
                let refused = simulation
                    .edit(|batch| batch.thermostat(a, &ThermostatRule::Maxwell(target), KEY));
                assert!(matches!(refused, Err(EditError::Energy(_))), "{target:?}");
                assert_eq!(simulation.view().energy(), before);
                assert!(simulation.view().heat().all().is_empty());
            }
        }
    }

    #[test]
    fn rules_that_set_velocities_refuse_fixed_and_locked_bodies_by_name() {
        let active = |diffusion: f64| {
            ThermostatRule::Active(SelfPropulsion {
                speed: 1.0,
                rotational_diffusion: diffusion,
                translational_diffusion: 0.0,
                every: 0.1,
            })
        };
        let (mut simulation, a) = mixture();
        let before = simulation.view().energy();
        let refused = simulation.edit(|batch| batch.thermostat(a, &ThermostatRule::Rotate, KEY));
        let kick = ThermostatRule::Kick(KickMomentum::Magnitude(1e300));
        let EditError::Fixed(name) = refused.unwrap_err() else {
            panic!("another error")
        };
        simulation.remove(name.key).unwrap();
        let refused = simulation.edit(|batch| batch.thermostat(a, &active(0.5), KEY));
        assert!(matches!(refused, Err(EditError::CannotTurn(name)) if name.id == 0));
        let refused = simulation.edit(|batch| batch.thermostat(a, &kick, KEY));
        let words = refused.unwrap_err().to_string();
        assert!(words.contains("body 0 (tag a)"), "{words}");
        assert_eq!(simulation.view().energy(), before);
        simulation
            .edit(|batch| batch.thermostat(a, &active(0.0), KEY))
            .unwrap();
        let locked = simulation.view().bodies().next().unwrap().motion;
        assert_eq!(locked.velocity, locked.orientation.cos_sin());
    }

    /// Masses 2 and 5 with kT = 1.5 for a time of many relaxations.
    #[test]
    fn a_bath_without_contacts_reaches_its_temperature() {
        let gas = |tag: &str, shape: &str| {
            format!(
                "[[gas]]\ntags = [\"{tag}\"]\nshape = \"{shape}\"\natom_radius = 1e-4\natom_mass = 1.0\n\
                 energy = 9.0\ncount = 2000\n"
            )
        };
        let text = gas("bath", "disc") + &gas("bath", "tee");
        let mut simulation = Simulation::new(&Scene::from_toml(&text).unwrap()).unwrap();
        let bath = simulation.find_tag("bath").unwrap();
        let rule = ThermostatRule::Langevin(LangevinStep {
            friction: 2.0,
            temperature: 1.5,
            every: 0.25,
        });
        for action in 0..40 {
            simulation
                .edit(|batch| batch.thermostat(bath, &rule, DrawKey { action, ..KEY }))
                .unwrap();
        }
        let energy = |turns: bool| {
            let view = simulation.view();
            let bodies = view.bodies().filter(|body| body.body.can_turn() == turns);
            bodies.map(|body| body.energy()).sum::<f64>() / 2000.0
        };
        // Standard deviations of a mean energy: kT √(f/2N).
        assert!((energy(false) - 1.5).abs() < 5.0 * 1.5 / 2000f64.sqrt());
        assert!((energy(true) - 2.25).abs() < 5.0 * 1.5 * (1.5 / 2000.0f64).sqrt());
        let view = simulation.view();
        assert!((view.heat().heat(bath) - view.ledger().put_in).abs() < 1e-9);
    }
}
