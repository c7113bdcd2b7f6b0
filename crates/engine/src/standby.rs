//! Edits at a standby: bodies come, go, change tags, energy or rotation, and elasticity changes; each from
//! that instant on.

use std::sync::Arc;

use carom_detection::Detection;
use carom_geometry::LARGEST;
use carom_kinematics::{Motion, kinetic_energy};
use carom_response::Response;

use crate::{
    BodyKey, BodyName, EditError, ElasticitySpec, ElasticityTable, LEAST_SPEED, MoleculeSpec, Rotation,
    SceneError, Scheduler, Simulation, Tag, TagNames, WallSpec, World,
    build::{add_molecule, add_wall, deepest_overlap, inertia},
    pass::AtOnce,
    simulation::Epoch,
    sites::Sites,
};

impl<D: Detection, R: Response, S: Scheduler> Simulation<D, R, S> {
    /// Adds a molecule as a scene file would.
    ///
    /// # Errors
    /// [`EditError::Scene`] if it is impossible, overlaps something, or is too large for the grid or the box;
    /// nothing has been changed then.
    pub fn add(&mut self, spec: &MoleculeSpec) -> Result<BodyKey, EditError> {
        let entry = "the molecule added";
        let mut world = self.world_from_now();
        let mut names = self.names.clone();
        let key = add_molecule(&mut world, &mut names, spec, entry)?;
        refuse_overlaps_of_last(&world, &names, entry)?;
        self.accept(world, names)?;
        Ok(key)
    }

    /// Adds a wall as a scene file would.
    ///
    /// # Errors
    /// [`EditError::Scene`] if it is impossible or overlaps something that moves; nothing has been changed then.
    pub fn add_wall(&mut self, spec: &WallSpec) -> Result<BodyKey, EditError> {
        let entry = "the wall added";
        let mut world = self.world_from_now();
        let mut names = self.names.clone();
        let key = add_wall(&mut world, &mut names, spec, entry)?;
        refuse_overlaps_of_last(&world, &names, entry)?;
        self.accept(world, names)?;
        Ok(key)
    }

    /// Takes a body out of the system.
    ///
    /// # Errors
    /// [`EditError::NoSuchBody`].
    pub fn remove(&mut self, key: BodyKey) -> Result<(), EditError> {
        self.index(key)?;
        let mut world = self.world_from_now();
        world.remove(key);
        self.accept(world, self.names.clone())
    }

    /// Gives a body a tag.
    ///
    /// # Errors
    /// [`EditError::NoSuchBody`], or [`EditError::Scene`] if rules of elasticity would then disagree.
    pub fn tag(&mut self, key: BodyKey, name: &str) -> Result<Tag, EditError> {
        let index = self.index(key)?;
        let (mut world, mut names) = (self.world.clone(), self.names.clone());
        let tag = names.intern(name);
        if let Err(place) = world.bodies[index].kind.tags.binary_search(&tag) {
            Arc::make_mut(&mut world.bodies[index].kind).tags.insert(place, tag);
        }
        self.accept_tags(world, names)?;
        Ok(tag)
    }

    /// Takes a tag from a body; one that it does not carry changes nothing.
    ///
    /// # Errors
    /// As [`Self::tag`].
    pub fn untag(&mut self, key: BodyKey, name: &str) -> Result<(), EditError> {
        let index = self.index(key)?;
        let mut world = self.world.clone();
        if let Some(tag) = self.names.find(name) {
            Arc::make_mut(&mut world.bodies[index].kind).tags.retain(|carried| *carried != tag);
        }
        self.accept_tags(world, self.names.clone())
    }

    /// Changes the elasticity of all contacts from now on.
    ///
    /// # Errors
    /// [`EditError::Scene`] if a coefficient is out of range or rules disagree; the old rules then stay.
    pub fn set_elasticity(&mut self, spec: &ElasticitySpec) -> Result<(), EditError> {
        let mut names = self.names.clone();
        let mut table = ElasticityTable::new(spec, &mut names)?;
        table.classify(&mut self.world, &self.response)?;
        (self.elasticity, self.names) = (table, names);
        Ok(())
    }

    /// Scales velocity and spin of a body so that its kinetic energy is `energy`; directions, and the shares of
    /// translation and rotation, stay (Montanari 2017, section 2.1.1).
    ///
    /// # Errors
    /// [`EditError::NoEnergy`] if the body is at rest and has no direction, [`EditError::Energy`] if
    /// `energy` is not positive and finite or gives it a speed beyond 10⁶⁰ or below
    /// [`LEAST_SPEED`], [`EditError::Fixed`], [`EditError::NoSuchBody`].
    #[doc(alias = "thermostat")]
    pub fn reset_energy(&mut self, key: BodyKey, energy: f64) -> Result<(), EditError> {
        let (index, factor) = self.energy_factor(key, energy)?;
        self.change(index, |motion| {
            motion.velocity *= factor;
            motion.angular_velocity *= factor;
        });
        Ok(())
    }

    /// Scales the energy of each body that carries the tag to `energy`; all are checked before any is changed.
    ///
    /// # Errors
    /// As [`Self::reset_energy`].
    pub fn reset_energy_of_all(&mut self, tag: Tag, energy: f64) -> Result<(), EditError> {
        let keys: Vec<BodyKey> = self.view().tagged(tag).map(|view| view.body.key()).collect();
        for &key in &keys {
            self.energy_factor(key, energy)?;
        }
        keys.into_iter().try_for_each(|key| self.reset_energy(key, energy))
    }

    /// Reverses all velocities and spins: an elastic run then goes back the way that it came, as far as roundings, which
    /// chaos multiplies, let it (Loschmidt's reversal). How far from its start it ends tells how exact it is.
    ///
    /// ```
    /// # use carom_engine::{Scene, Simulation};
    /// let scene = Scene::from_toml("[box]\nseed = 1\n[[gas]]\nradius = 0.05\nmass = 1.0\nenergy = 1.0\ncount = 20")?;
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
        for index in 0..self.world.bodies.len() {
            self.change(index, |motion| {
                motion.velocity = -motion.velocity;
                motion.angular_velocity = -motion.angular_velocity;
            });
        }
    }

    /// Locks the orientation of a body where it is now, or frees it. Its spin is taken away when it is locked.
    ///
    /// # Errors
    /// [`EditError::Fixed`] or [`EditError::NoSuchBody`].
    pub fn set_rotation(&mut self, key: BodyKey, rotation: Rotation) -> Result<(), EditError> {
        let index = self.index(key)?;
        if self.world.bodies[index].is_fixed() {
            return Err(EditError::Fixed(self.name(index)));
        }
        let before = self.world.energy();
        self.change(index, |motion| {
            if rotation == Rotation::Locked {
                motion.angular_velocity = 0.0;
            }
        });
        let kind = Arc::make_mut(&mut self.world.bodies[index].kind);
        kind.inertia = inertia(&kind.molecule, rotation);
        // `change` has booked with the old inertia, under which a spin of 0 has the same energy.
        debug_assert!(self.world.energy() <= before);
        Ok(())
    }

    /// Changes how the scheduler works (for the thesis's: the fineness of its grid).
    ///
    /// # Errors
    /// [`EditError::Scene`] if the options do not suit the bodies; the old ones then stay.
    #[doc(alias = "fineness")]
    pub fn set_scheduler_options(&mut self, options: &S::Options) -> Result<(), EditError> {
        let scheduler = S::new(options, &self.world)
            .map_err(|reason| reason.named(|body| self.name(body).to_string()))?;
        self.end_epoch(self.offset);
        self.work_before = self.counters.scheduler;
        self.scheduler = scheduler;
        self.scheduler_options = options.clone();
        Ok(())
    }

    /// The tag of this name, if any body or rule has ever carried it.
    pub fn find_tag(&self, name: &str) -> Option<Tag> {
        self.names.find(name)
    }

    fn name(&self, index: usize) -> BodyName {
        BodyName::new(&self.world.bodies[index], &self.names)
    }

    fn index(&self, key: BodyKey) -> Result<usize, EditError> {
        self.world.index(key).ok_or(EditError::NoSuchBody(key))
    }

    /// By what to multiply a body's velocity and spin to give it this energy, and its index.
    fn energy_factor(&self, key: BodyKey, energy: f64) -> Result<(usize, f64), EditError> {
        let index = self.index(key)?;
        if !(energy.is_finite() && energy > 0.0) {
            return Err(EditError::Energy(energy));
        }
        let (body, motion) = (&self.world.bodies[index], &self.world.motions[index]);
        if body.is_fixed() {
            return Err(EditError::Fixed(self.name(index)));
        }
        let before = kinetic_energy(motion, &body.kind.inertia);
        if before == 0.0 {
            return Err(EditError::NoEnergy(self.name(index)));
        }
        let factor = (energy / before).sqrt();
        let (speed, spin) = (factor * motion.velocity.length(), factor * motion.angular_velocity.abs());
        let rim = spin * body.kind.molecule.bounding_radius();
        // NaN and an infinite factor are out of range as well.
        let is_in_range = speed.max(spin) <= LARGEST && speed.max(rim) >= LEAST_SPEED;
        if is_in_range && factor.is_finite() { Ok((index, factor)) } else { Err(EditError::Energy(energy)) }
    }

    /// Changes the motion of one body now, and books the energy.
    fn change(&mut self, index: usize, change: impl FnOnce(&mut Motion)) {
        // Only the first of many changes brings all bodies to now: each of N would otherwise cost N.
        if self.offset != 0.0 || !matches!(self.epoch, Epoch::ToBegin) {
            self.end_epoch(self.offset);
        }
        self.at_once.begin();
        let inertia = self.world.bodies[index].kind.inertia;
        let before = kinetic_energy(&self.world.motions[index], &inertia);
        change(&mut self.world.motions[index]);
        self.ledger.put_in += kinetic_energy(&self.world.motions[index], &inertia) - before;
    }

    /// The world with an epoch that starts now, to be edited: a refused edit leaves every bit of the true one alone.
    fn world_from_now(&self) -> World {
        let mut world = self.world.clone();
        world.rebase(self.offset);
        world
    }

    /// Takes over an edited world whose epoch starts now, if elasticity and grid suit it.
    fn accept(&mut self, mut world: World, names: TagNames) -> Result<(), EditError> {
        let mut elasticity = self.elasticity.clone();
        elasticity.classify(&mut world, &self.response)?;
        let scheduler = S::new(&self.scheduler_options, &world)
            .map_err(|reason| reason.named(|body| BodyName::new(&world.bodies[body], &names).to_string()))?;
        self.ledger.put_in += world.energy() - self.world.energy();
        self.work_before = self.counters.scheduler;
        (self.offset, self.epoch, self.at_once) = (0.0, Epoch::ToBegin, AtOnce::default());
        (self.world, self.names, self.elasticity, self.scheduler) = (world, names, elasticity, scheduler);
        Ok(())
    }

    /// Takes over new tags; they touch no motion and no prediction.
    fn accept_tags(&mut self, mut world: World, names: TagNames) -> Result<(), EditError> {
        let mut elasticity = self.elasticity.clone();
        elasticity.classify(&mut world, &self.response)?;
        (self.world, self.names, self.elasticity) = (world, names, elasticity);
        Ok(())
    }
}

/// Refuses overlaps of the body added last with any other, unless both are fixed.
fn refuse_overlaps_of_last(world: &World, names: &TagNames, entry: &str) -> Result<(), SceneError> {
    let new = world.bodies.len() - 1;
    let mut sites = Sites::new(world);
    let overlap = if world.bodies[new].is_fixed() {
        // Those that move ask for it.
        sites.add(world, new);
        let moving = (0..new).filter(|&index| !world.bodies[index].is_fixed());
        let mut overlaps =
            moving.filter_map(|index| deepest_overlap(world, &sites, index).map(|(_, depth)| (index, depth)));
        overlaps.next()
    } else {
        (0..new).for_each(|index| sites.add(world, index));
        deepest_overlap(world, &sites, new)
    };
    match overlap {
        None => Ok(()),
        Some((other, depth)) => {
            let other = BodyName::new(&world.bodies[other], names);
            let (first, second) = (other.to_string(), entry.to_owned());
            Err(SceneError::Overlap { first, second, depth })
        }
    }
}
