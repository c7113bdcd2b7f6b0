//! Thermostats: edits that set the energies of all bodies of a tag, or draw their velocities from
//! Maxwell's distribution.
//!
//! Maxwell's distribution at kT: each component of the velocity is normal with variance kT/m, and
//! the angular velocity of a body that contacts turn with variance kT/I. A body does not turn if it
//! is locked; the spin of a round molecule is no degree of freedom and remains.

use carom_geometry::MAX_MAGNITUDE;
use carom_kinematics::kinetic_energy;
use glam::DVec2;

use crate::{
    contact::philox::{open_unit, philox},
    edit::batch::{Batch, energy_factor},
    scene::{
        error::EditError, least_speed::MIN_SPEED, random::normal_pair_of,
        thermostat_target::ThermostatTarget,
    },
    world::{
        body::Body,
        heat::{ThermostatCounts, exact_sum},
        tags::Tag,
    },
};

/// Selects the random numbers of one draw. Two draws of a run that differ in `action` are
/// independent; equal keys give each body the same numbers again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrawKey {
    /// Seed of the scene.
    pub seed: u64,
    /// Replica of the scene.
    pub replica: u64,
    /// Number of the action in the run.
    pub action: u64,
}

impl Batch {
    /// Scales the kinetic energy of each body with this tag, like [`Self::reset_energy_of_tag`],
    /// but leaves out bodies at rest and counts them. The change is booked as heat of the tag
    /// ([`View::heat`](crate::View::heat)).
    ///
    /// # Errors
    /// [`EditError::Energy`] if an energy is not positive and finite, or gives a speed out of
    /// range; then nothing changes.
    #[doc(alias = "energy reset")]
    pub fn thermostat_energy(
        &mut self,
        tag: Tag,
        target: ThermostatTarget,
    ) -> Result<ThermostatCounts, EditError> {
        let (mut counts, mut factors) = (ThermostatCounts::default(), Vec::new());
        for index in self.members(tag) {
            let body = &self.world.bodies[index];
            if body.is_fixed() {
                counts.fixed += 1;
                continue;
            }
            match energy_factor(&self.world, &self.names, index, target.energy_of(body)) {
                Ok(factor) => factors.push((index, factor)),
                Err(EditError::NoEnergy(_)) => counts.at_rest += 1,
                Err(error) => return Err(error),
            }
        }
        counts.changed = factors.len() as u64;
        let before = self.energies_of(tag);
        self.scale(&factors);
        self.book(tag, &before, counts);
        Ok(counts)
    }

    /// Draws velocity and angular velocity of each moving body with this tag from Maxwell's
    /// distribution at rest. Bodies that are locked get no angular velocity. The change of energy
    /// is booked as heat of the tag ([`View::heat`](crate::View::heat)).
    ///
    /// The numbers of a body depend on `key` and on its handle alone.
    ///
    /// ```
    /// use carom_engine::{DrawKey, Scene, Simulation, ThermostatTarget};
    ///
    /// let scene = Scene::from_toml(
    ///     "[[gas]]\ntags = [\"gas\"]\nradius = 1e-3\nmass = 2.0\nenergy = 1.0\ncount = 2000",
    /// )?;
    /// let mut simulation = Simulation::new(&scene)?;
    /// let gas = simulation.find_tag("gas").expect("the scene names it");
    /// let key = DrawKey { seed: 1, replica: 0, action: 0 };
    /// simulation.edit(|batch| batch.thermostat_maxwell(gas, ThermostatTarget::Temperature(3.0), key))?;
    /// let temperature = simulation.view().temperature().expect("the discs move");
    /// // The relative standard error is 1/√2000 = 2.2 %.
    /// assert!((temperature / 3.0 - 1.0).abs() < 0.07);
    /// assert_eq!(simulation.view().heat().heat(gas), simulation.view().ledger().put_in);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`EditError::Energy`] if an energy or temperature is not positive and finite, or gives a
    /// speed out of range; then nothing changes.
    #[doc(alias = "Andersen")]
    pub fn thermostat_maxwell(
        &mut self,
        tag: Tag,
        target: ThermostatTarget,
        key: DrawKey,
    ) -> Result<ThermostatCounts, EditError> {
        let (mut counts, mut motions) = (ThermostatCounts::default(), Vec::new());
        for index in self.members(tag) {
            let body = &self.world.bodies[index];
            if body.is_fixed() {
                counts.fixed += 1;
                continue;
            }
            motions.push((index, maxwell(body, target.temperature_of(body), key)?));
        }
        counts.changed = motions.len() as u64;
        if motions.is_empty() {
            self.heat.give(tag, 0.0, counts);
            return Ok(counts);
        }
        let before = self.energies_of(tag);
        self.start_to_move();
        for (index, (velocity, angular_velocity)) in motions {
            let motion = &mut self.world.motions[index];
            motion.velocity = velocity;
            motion.angular_velocity = angular_velocity.unwrap_or(motion.angular_velocity);
        }
        self.moves = true;
        self.book(tag, &before, counts);
        Ok(counts)
    }

    /// Kinetic energy of each body with a tag (mass × length² / time²).
    fn energies_of(&self, tag: Tag) -> Vec<f64> {
        let world = &self.world;
        let energies = self
            .members(tag)
            .map(|index| kinetic_energy(&world.motions[index], world.bodies[index].inertia()));
        energies.collect()
    }

    /// Books the change of the energies of the bodies with a tag as heat.
    fn book(&mut self, tag: Tag, before: &[f64], counts: ThermostatCounts) {
        let change = self
            .energies_of(tag)
            .into_iter()
            .chain(before.iter().map(|energy| -energy));
        self.heat.give(tag, exact_sum(change), counts);
    }
}

/// Largest number of thermal speeds that a drawn component can have: √(2 · 53 ln 2) = 8.6.
const MAX_THERMAL_SPEEDS: f64 = 8.6;

/// Velocity of a body from Maxwell's distribution, and its angular velocity if contacts turn it.
fn maxwell(body: &Body, temperature: f64, key: DrawKey) -> Result<(DVec2, Option<f64>), EditError> {
    let inertia = body.inertia();
    let [speed, spin] = [inertia.inverse_mass, inertia.inverse_moment]
        .map(|inverse| (temperature * inverse).sqrt());
    let most = MAX_THERMAL_SPEEDS
        * if body.can_turn() {
            speed.max(spin)
        } else {
            speed
        };
    // NaN and negative temperatures are out of range as well.
    if !(temperature > 0.0
        && temperature <= MAX_MAGNITUDE
        && speed >= MIN_SPEED
        && most <= MAX_MAGNITUDE)
    {
        return Err(EditError::Energy(temperature));
    }
    let bits = philox([key.seed, key.replica], [body.key().0, key.action, 0, 0]);
    let [one, two, three, four] = bits.map(open_unit);
    let velocity = speed * normal_pair_of([one, two]);
    let angular_velocity = body
        .can_turn()
        .then(|| spin * normal_pair_of([three, four]).x);
    Ok((velocity, angular_velocity))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{run::simulation::Simulation, scene::Scene};

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
            .edit(|batch| batch.thermostat_energy(a, target))
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
            .edit(|batch| batch.thermostat_maxwell(a, target, KEY))
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
                .edit(|batch| batch.thermostat_maxwell(a, target, key))
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
                let refused = simulation.edit(|batch| batch.thermostat_energy(a, target));
                assert!(matches!(refused, Err(EditError::Energy(_))), "{target:?}");
                let refused = simulation.edit(|batch| batch.thermostat_maxwell(a, target, KEY));
                assert!(matches!(refused, Err(EditError::Energy(_))), "{target:?}");
                assert_eq!(simulation.view().energy(), before);
                assert!(simulation.view().heat().all().is_empty());
            }
        }
    }
}
