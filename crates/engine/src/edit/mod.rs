//! Edits between events: add and remove bodies, and change tags, velocities, energy, rotation or
//! elasticity, with effect from that time.

pub(crate) mod batch;
pub(crate) mod draw_key;
mod motion_rule;
pub(crate) mod react;
mod set_motion;
pub(crate) mod thermostat;

use std::sync::Arc;

use carom_detection::Detection;
use carom_kinematics::{EpochTime, Motion, kinetic_energy};
use carom_response::Response;

use crate::{
    contact::unresolved::Unresolved,
    edit::batch::{energy_factor, energy_factors},
    run::simulation::{Epoch, Simulation},
    scene::{
        MoleculeSpec, WallSpec, bond_spec::BondSpec, elasticity_spec::ElasticitySpec,
        error::EditError, reaction_spec::ReactionSpec, wall_motion::WallMotionSpec,
    },
    scheduler::Scheduler,
    start::body_builder::inertia,
    world::{
        body::{Body, BodyKey, BodyName, Rotation},
        tags::Tag,
    },
};

impl<D: Detection, R: Response, S: Scheduler> Simulation<D, R, S> {
    /// Adds a molecule, described as in a scene file; a batch of one, see [`Self::edit`].
    ///
    /// # Errors
    /// [`EditError::Scene`] if the description is invalid, or the molecule overlaps a body or is
    /// too large for the grid or the box; then nothing changes.
    pub fn add(&mut self, spec: &MoleculeSpec) -> Result<BodyKey, EditError> {
        self.edit(|batch| batch.add(spec))
    }

    /// Adds a wall, described as in a scene file; a batch of one, see [`Self::edit`].
    ///
    /// # Errors
    /// [`EditError::Scene`] if the description is invalid or the wall overlaps a moving body; then
    /// nothing changes.
    pub fn add_wall(&mut self, spec: &WallSpec) -> Result<BodyKey, EditError> {
        self.edit(|batch| batch.add_wall(spec))
    }

    /// Replaces the motion of a wall from now on; a batch of one, see [`Self::edit`].
    ///
    /// # Errors
    /// Those of [`Batch::move_wall`](crate::Batch::move_wall).
    pub fn move_wall(&mut self, key: BodyKey, motion: &WallMotionSpec) -> Result<(), EditError> {
        self.edit(|batch| batch.move_wall(key, motion))
    }

    /// Replaces the force on a piston from now on; a batch of one, see [`Self::edit`].
    ///
    /// # Errors
    /// Those of [`Batch::push_piston`](crate::Batch::push_piston).
    pub fn push_piston(&mut self, key: BodyKey, force: f64) -> Result<(), EditError> {
        self.edit(|batch| batch.push_piston(key, force))
    }

    /// Removes a body; a batch of one, see [`Self::edit`].
    ///
    /// # Errors
    /// [`EditError::NoSuchBody`].
    pub fn remove(&mut self, key: BodyKey) -> Result<(), EditError> {
        self.edit(|batch| batch.remove(key))
    }

    /// Adds a tag to a body; a batch of one, see [`Self::edit`].
    ///
    /// # Errors
    /// [`EditError::NoSuchBody`], or [`EditError::Scene`] if rules of elasticity would then
    /// disagree.
    pub fn tag(&mut self, key: BodyKey, name: &str) -> Result<Tag, EditError> {
        self.edit(|batch| batch.tag(key, name))
    }

    /// Removes a tag from a body; a tag that it does not carry changes nothing. A batch of one, see
    /// [`Self::edit`].
    ///
    /// # Errors
    /// [`EditError::NoSuchBody`], or [`EditError::Scene`] if rules of elasticity would then
    /// disagree.
    pub fn untag(&mut self, key: BodyKey, name: &str) -> Result<(), EditError> {
        self.edit(|batch| batch.untag(key, name))
    }

    /// Changes the elasticity of all later contacts; a batch of one, see [`Self::edit`].
    ///
    /// # Errors
    /// [`EditError::Scene`] if a coefficient is out of range or rules disagree; then the old rules
    /// remain.
    pub fn set_elasticity(&mut self, spec: &ElasticitySpec) -> Result<(), EditError> {
        self.edit(|batch| batch.set_elasticity(spec))
    }

    /// Replaces the reactions of bodies that collide; a batch of one, see [`Self::edit`].
    ///
    /// ```
    /// use carom_engine::{ReactionSpec, Scene, Simulation};
    ///
    /// // An infection that passes at each contact.
    /// let mut scene = Scene::from_toml(
    ///     "[[gas]]\ntags = [\"S\"]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 100",
    /// )?;
    /// let mut simulation = Simulation::new(&scene)?;
    /// let first = simulation.view().bodies().next().unwrap().body.key();
    /// simulation.untag(first, "S")?;
    /// simulation.tag(first, "I")?;
    /// simulation.set_reactions(&[ReactionSpec {
    ///     between: vec!["I".to_owned(), "S".to_owned()],
    ///     becomes: vec!["I".to_owned(), "I".to_owned()],
    ///     ..ReactionSpec::default()
    /// }])?;
    /// simulation.run_until(2.0)?;
    /// let infected = simulation.find_tag("I").expect("the reaction names it");
    /// let infections = simulation.view().counters().reactions;
    /// assert!(infections > 10);
    /// assert_eq!(simulation.view().tagged(infected).count() as u64, 1 + infections);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`EditError::Scene`] if a rule is invalid, or cannot act on the bodies that it names.
    pub fn set_reactions(&mut self, rules: &[ReactionSpec]) -> Result<(), EditError> {
        self.edit(|batch| batch.set_reactions(rules))
    }

    /// Ties bodies by bonds; a batch of one, see [`Self::edit`].
    ///
    /// ```
    /// use carom_engine::{BondSpec, Scene, Simulation, TetherSpec};
    ///
    /// let gas = "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 20";
    /// let mut simulation = Simulation::new(&Scene::from_toml(gas)?)?;
    /// let keys: Vec<_> = simulation.view().bodies().map(|body| body.body.key()).collect();
    /// let spec = BondSpec {
    ///     pairs: vec![[keys[0].id(), keys[1].id()]],
    ///     tether: TetherSpec { max: 0.45, ..TetherSpec::default() },
    /// };
    /// // Two bodies farther apart than that cannot be tied.
    /// let tied = simulation.bond(&spec).is_ok();
    /// assert_eq!(simulation.view().bonds().count(), usize::from(tied));
    /// simulation.edit(|batch| batch.unbond(&keys[..1]))?;
    /// assert_eq!(simulation.view().bonds().count(), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Batch::bond`](crate::Batch::bond), and [`EditError::Scene`] if a bond is beyond
    /// its bounds or ties bodies that cannot be tied.
    pub fn bond(&mut self, spec: &BondSpec) -> Result<(), EditError> {
        self.edit(|batch| batch.bond(spec))
    }

    /// Changes the drag γ of all bodies (1/time): from now on v' = −γ v and ω' = −γ ω between
    /// contacts. All paths and the order of contacts are those without drag, only later
    /// ([`DragClock`](carom_kinematics::DragClock)); walls that have a temperature keep it. The
    /// energy that the drag takes is [`Ledger::dragged`](crate::Ledger::dragged). A batch of one,
    /// see [`Self::edit`].
    ///
    /// ```
    /// # use carom_engine::{Scene, Simulation};
    /// let gas = "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100";
    /// let mut simulation = Simulation::new(&Scene::from_toml(gas)?)?;
    /// simulation.set_drag(0.5)?;
    /// simulation.run_until(2.0)?;
    /// let energy = simulation.view().energy();
    /// assert!((energy - 100.0 * (-2.0_f64 * 0.5 * 2.0).exp()).abs() < 1e-11);
    /// let ledger = simulation.view().ledger();
    /// assert!((ledger.booked() - energy).abs() < 1e-11);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`EditError::Scene`] if the drag is negative, not finite, or above 10⁶⁰.
    #[doc(alias = "damping")]
    #[doc(alias = "viscous friction")]
    pub fn set_drag(&mut self, drag: f64) -> Result<(), EditError> {
        self.edit(|batch| batch.set_drag(drag))
    }

    /// Changes the gravity from now on: an acceleration of all free bodies (length per time
    /// squared); a batch of one, see [`Self::edit`].
    ///
    /// The ledger books its work ([`Ledger::fallen`](crate::Ledger::fallen)).
    ///
    /// # Errors
    /// [`EditError::Scene`] if a component is neither 0 nor from 10⁻⁶⁰ to 10⁶⁰ in magnitude, with
    /// drag, with curved walls, or if no wall across the box stops bodies that fall.
    #[doc(alias = "field")]
    pub fn set_gravity(&mut self, gravity: [f64; 2]) -> Result<(), EditError> {
        self.edit(|batch| batch.set_gravity(gravity))
    }

    /// Changes the shear rate from now on (1/time); a batch of one, see [`Self::edit`].
    ///
    /// Velocities do not change: a flow forms from the seam on. With a rate of 0 the box above
    /// stays where it is.
    ///
    /// ```
    /// use carom_engine::{Scene, Simulation};
    ///
    /// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
    /// let mut simulation = Simulation::new(&scene)?;
    /// simulation.set_shear_rate(0.25)?;
    /// simulation.run_until(1.0)?;
    /// let view = simulation.view();
    /// assert_eq!((view.shear_rate(), view.bounds().tilt()), (0.25, 0.25));
    /// assert!((view.ledger().booked() / view.energy() - 1.0).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`EditError::Scene`] if the rate is neither 0 nor from 10⁻⁶⁰ to 10⁶⁰ in magnitude, with
    /// fixed bodies, walls or pistons, with a drag or with a gravity.
    #[doc(alias = "Lees-Edwards")]
    pub fn set_shear_rate(&mut self, rate: f64) -> Result<(), EditError> {
        self.edit(|batch| batch.set_shear_rate(rate))
    }

    /// Sets the velocity of a body (length per time); a batch of one, see [`Self::edit`].
    ///
    /// # Errors
    /// Those of [`Batch::set_velocity`](crate::Batch::set_velocity).
    pub fn set_velocity(&mut self, key: BodyKey, velocity: [f64; 2]) -> Result<(), EditError> {
        self.edit(|batch| batch.set_velocity(key, velocity))
    }

    /// Sets the angular velocity of a body (radians per time, counter-clockwise); a batch of one,
    /// see [`Self::edit`].
    ///
    /// # Errors
    /// Those of [`Batch::set_angular_velocity`](crate::Batch::set_angular_velocity).
    pub fn set_angular_velocity(
        &mut self,
        key: BodyKey,
        angular_velocity: f64,
    ) -> Result<(), EditError> {
        self.edit(|batch| batch.set_angular_velocity(key, angular_velocity))
    }

    /// Scales velocity and angular velocity of a body so that its kinetic energy is `energy`
    /// (mass × length² / time²). Directions and the shares of translation and rotation remain
    /// (Montanari 2017, section 2.1.1).
    ///
    /// # Errors
    /// [`EditError::NoEnergy`] if the body is at rest and has no direction, [`EditError::Energy`]
    /// if `energy` is not positive and finite or gives a speed above 10⁶⁰ or below
    /// [`MIN_SPEED`](crate::MIN_SPEED), [`EditError::Fixed`], [`EditError::NoSuchBody`].
    #[doc(alias = "thermostat")]
    pub fn reset_energy(&mut self, key: BodyKey, energy: f64) -> Result<(), EditError> {
        let index = self.index(key)?;
        self.settle();
        let factor = energy_factor(
            &self.world,
            &self.names,
            (index, &self.world.motions[index]),
            energy,
        )?;
        self.scale(index, factor);
        Ok(())
    }

    /// Scales the kinetic energy of each body with this tag to `energy`. Fixed bodies, which have
    /// no energy, are skipped. If one body is refused, none is changed.
    ///
    /// # Errors
    /// Those of [`Self::reset_energy`], except for fixed bodies.
    pub fn reset_energy_of_tag(&mut self, tag: Tag, energy: f64) -> Result<(), EditError> {
        self.reset_energies(energy, |body| body.has_tag(tag))
    }

    /// Scales the kinetic energy of each moving body to `energy`. If one body is refused, none is
    /// changed.
    ///
    /// # Errors
    /// Those of [`Self::reset_energy`], except for fixed bodies.
    pub fn reset_energy_of_all(&mut self, energy: f64) -> Result<(), EditError> {
        self.reset_energies(energy, |_| true)
    }

    fn reset_energies(
        &mut self,
        energy: f64,
        which: impl Fn(&Body) -> bool,
    ) -> Result<(), EditError> {
        self.settle();
        let chosen = |index: usize| which(&self.world.bodies[index]);
        let factors = energy_factors(&self.world, &self.names, energy, chosen)?;
        for (index, factor) in factors {
            self.scale(index, factor);
        }
        Ok(())
    }

    fn scale(&mut self, index: usize, factor: f64) {
        self.change(index, |motion| {
            motion.velocity *= factor;
            motion.angular_velocity *= factor;
        });
    }

    /// Reverses all velocities and angular velocities (Loschmidt's reversal). An elastic run then
    /// returns to its start, apart from rounding errors, which chaos amplifies. The distance from
    /// the start measures the accuracy of the run. A wall with a table of places turns back, but
    /// follows its table onwards from the next time in it.
    ///
    /// ```
    /// # use carom_engine::{Scene, Simulation};
    /// let scene = Scene::from_toml(
    ///     "[box]\nseed = 1\n[[gas]]\nradius = 0.05\nmass = 1.0\nenergy = 1.0\ncount = 20",
    /// )?;
    /// let mut simulation = Simulation::new(&scene)?;
    /// let start = simulation.view().bodies().next().unwrap().motion.position;
    /// simulation.run_until(0.1)?;
    /// simulation.reverse();
    /// simulation.run_until(0.2)?;
    /// let end = simulation.view().bodies().next().unwrap().motion.position;
    /// assert!((end - start).length() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[doc(alias = "time reversal")]
    pub fn reverse(&mut self) {
        self.walls_meet_after = EpochTime::ZERO;
        for index in 0..self.world.bodies.len() {
            self.change(index, |motion| {
                motion.velocity = -motion.velocity;
                motion.angular_velocity = -motion.angular_velocity;
            });
        }
        self.world.reverse_oscillations();
        self.world.shear_rate = -self.world.shear_rate;
    }

    /// Locks the present orientation of a body, or frees it. Locking removes its angular velocity.
    ///
    /// # Errors
    /// [`EditError::Fixed`] or [`EditError::NoSuchBody`].
    pub fn set_rotation(&mut self, key: BodyKey, rotation: Rotation) -> Result<(), EditError> {
        let index = self.index(key)?;
        if !self.world.bodies[index].is_free() {
            return Err(EditError::Fixed(self.name(index)));
        }
        self.change(index, |motion| {
            if rotation == Rotation::Locked {
                motion.angular_velocity = 0.0;
            }
        });
        // `change` has recorded the energy with the old inertia: an angular velocity of 0 has the
        // same energy with the new one.
        let kind = Arc::make_mut(&mut self.world.bodies[index].kind);
        kind.inertia = inertia(&kind.molecule, rotation);
        Ok(())
    }

    /// Changes the options of the scheduler (for [`HeapScheduler`](crate::HeapScheduler): the cells
    /// per side of its grid).
    ///
    /// # Errors
    /// [`EditError::Scene`] if the options do not fit the bodies; then the old options remain.
    #[doc(alias = "fineness")]
    pub fn set_scheduler_options(&mut self, options: &S::Options) -> Result<(), EditError> {
        let scheduler = S::checked(options, &self.world)
            .map_err(|reason| reason.named(|body| self.name(body).to_string()))?;
        self.end_epoch(self.offset);
        self.work_before = self.counters.scheduler;
        self.scheduler = scheduler;
        self.scheduler_options = options.clone();
        Ok(())
    }

    /// The tag of this name, if a body or rule has ever carried it.
    pub fn find_tag(&self, name: &str) -> Option<Tag> {
        self.names.find(name)
    }

    fn name(&self, index: usize) -> BodyName {
        BodyName::new(&self.world.bodies[index], &self.names)
    }

    fn index(&self, key: BodyKey) -> Result<usize, EditError> {
        self.world.index(key).ok_or(EditError::NoSuchBody(key))
    }

    /// With drag, gravity or shear, begins an epoch at the present: its velocities are the true
    /// ones.
    fn settle(&mut self) {
        if self.world.has_own_frame() {
            self.end_epoch(self.offset);
        }
    }

    /// Changes the motion of one body at the present time, and records the energy in the ledger.
    fn change(&mut self, index: usize, change: impl FnOnce(&mut Motion)) {
        // Only the first of many changes moves all bodies to the present: otherwise each of N
        // changes would cost O(N).
        if self.offset != 0.0 || !matches!(self.epoch, Epoch::ToBegin) {
            self.end_epoch(self.offset);
        }
        self.simultaneous.start();
        self.unresolved = Unresolved::default();
        let inertia = self.world.bodies[index].kind.inertia;
        let before = kinetic_energy(&self.world.motions[index], &inertia);
        change(&mut self.world.motions[index]);
        self.ledger.put_in += kinetic_energy(&self.world.motions[index], &inertia) - before;
    }
}
