//! A batch of edits: adds and removes bodies, and changes tags, energy or rotation, in one
//! transaction.

use std::{collections::HashMap, sync::Arc};

use carom_detection::Detection;
use carom_geometry::MAX_MAGNITUDE;
use carom_kinematics::{EpochTime, Motion, kinetic_energy};
use carom_response::Response;

use crate::{
    contact::{
        elasticity_table::ElasticityTable,
        reaction_table::ReactionTable,
        separation::{refuse_unresolved, refuse_unsearched},
        simultaneous_contacts::SimultaneousContacts,
        unresolved::Unresolved,
    },
    run::simulation::{Epoch, Simulation},
    scene::{
        MoleculeSpec, WallSpec,
        bond_spec::BondSpec,
        drag::drag_clock,
        elasticity_spec::ElasticitySpec,
        error::{EditError, SceneError},
        gravity::{gravity_of, refuse_gravity},
        least_speed::MIN_SPEED,
        pair_spec::TransparentSpec,
        reaction_spec::ReactionSpec,
        shear::{refuse_shear, shear_rate_of},
        wall_motion::WallMotionSpec,
        well_spec::WellSpec,
    },
    scheduler::Scheduler,
    start::{
        body_builder::inertia,
        bonds::{bonds_between, refuse_bonds, refuse_stretched},
        pistons::{check_force, refuse_pistons},
        single_bodies::{add_molecule, add_wall, deepest_overlap, first_overlap},
        sites::Sites,
        wall_motions::refuse_drag,
        wells::refuse_wells,
    },
    world::{
        World,
        body::{Body, BodyKey, BodyKind, BodyName, Rotation},
        heat::{HeatByTag, exact_sum},
        pair_table::PairTable,
        pistons::Piston,
        tags::{Tag, TagNames},
        tethers::{Bond, Tethers},
    },
};

/// Edits that are made together or not at all; see [`Simulation::edit`].
///
/// The batch works on a copy of the bodies. Each method checks its own edit: an error belongs to
/// one edit, and leaves the batch unchanged. A closure may handle such an error and continue, for
/// example with another position for a molecule.
#[derive(Debug)]
pub struct Batch {
    pub(crate) world: World,
    pub(crate) names: TagNames,
    elasticity: ElasticityTable,
    reactions: ReactionTable,
    /// The time of the edit, as an offset in the epoch of the world; `None` once the bodies have
    /// been moved to that time.
    offset: Option<f64>,
    /// Grid of the bodies in the box, built for the first added body.
    sites: Option<Sites>,
    /// Whether each body of the world has been removed; removed bodies leave the lists at the end
    /// of the batch.
    removed: Vec<bool>,
    /// Whether bodies have been added or removed or have changed their motion: then the epoch ends.
    pub(crate) moves: bool,
    /// Whether tags or rules of elasticity have changed.
    relabels: bool,
    /// Heat given by thermostats so far.
    pub(crate) heat: HeatByTag,
    /// Edited descriptions, so that bodies of one kind continue to share a description.
    edited: EditedKinds,
}

/// An edit of a description that bodies of one kind share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum KindEdit {
    Tag(Tag),
    Untag(Tag),
    Rotation(Rotation),
}

/// A description before an edit and after it.
#[derive(Debug)]
struct EditedKind {
    /// Kept alive, so that no other description gets its address.
    _before: Arc<BodyKind>,
    after: Arc<BodyKind>,
}

/// The descriptions that a batch has edited, with the address of the old description and the edit
/// as key.
#[derive(Debug, Default)]
struct EditedKinds(HashMap<(usize, KindEdit), EditedKind>);

impl EditedKinds {
    /// Edits the description of one body, in O(1) time on average.
    fn edit(&mut self, kind: &mut Arc<BodyKind>, edit: KindEdit) {
        let entry = self
            .0
            .entry((Arc::as_ptr(kind).addr(), edit))
            .or_insert_with(|| {
                let mut after = BodyKind::clone(kind);
                match edit {
                    KindEdit::Tag(tag) => {
                        if let Err(place) = after.tags.binary_search(&tag) {
                            after.tags.insert(place, tag);
                        }
                    }
                    KindEdit::Untag(tag) => after.tags.retain(|carried| *carried != tag),
                    KindEdit::Rotation(rotation) => {
                        after.inertia = inertia(&after.molecule, rotation);
                    }
                }
                EditedKind {
                    _before: Arc::clone(kind),
                    after: Arc::new(after),
                }
            });
        *kind = Arc::clone(&entry.after);
    }
}

impl Batch {
    /// Adds a molecule, described as in a scene file.
    ///
    /// # Errors
    /// [`EditError::Scene`] if the description is invalid or the molecule overlaps a body.
    pub fn add(&mut self, spec: &MoleculeSpec) -> Result<BodyKey, EditError> {
        self.insert("the molecule added", |world, names, entry| {
            add_molecule(world, names, spec, entry)
        })
    }

    /// Adds a wall, described as in a scene file.
    ///
    /// # Errors
    /// [`EditError::Scene`] if the description is invalid or the wall overlaps a moving body.
    pub fn add_wall(&mut self, spec: &WallSpec) -> Result<BodyKey, EditError> {
        let key = self.insert("the wall added", |world, names, entry| {
            add_wall(world, names, spec, entry)
        })?;
        if let Some(motion) = &spec.motion {
            self.move_wall(key, motion)?;
        }
        Ok(key)
    }

    /// Replaces the motion of a wall from now on.
    ///
    /// # Errors
    /// [`EditError::NotWall`] if the body is no wall or a piston, [`EditError::NoSuchBody`], or
    /// [`EditError::Scene`] if a number is out of range.
    pub fn move_wall(&mut self, key: BodyKey, motion: &WallMotionSpec) -> Result<(), EditError> {
        let index = self.index(key)?;
        let body = &self.world.bodies[index];
        if !body.is_wall() || body.is_piston() {
            return Err(EditError::NotWall(BodyName::new(body, &self.names)));
        }
        let name = BodyName::new(body, &self.names).to_string();
        // An error leaves the batch unchanged.
        let (place, bounds) = (&self.world.motions[index], &self.world.bounds);
        motion.of_wall(&name, body.molecule(), place, bounds)?;
        self.start_to_move();
        if let Some(sites) = self.sites.as_mut().filter(|_| motion.turn != 0.0) {
            sites.remove(&self.world, index);
            motion.set(&mut self.world, index, &name)?;
            sites.add(&self.world, index);
        } else {
            motion.set(&mut self.world, index, &name)?;
        }
        self.moves = true;
        Ok(())
    }

    /// Replaces the constant force on a piston from now on (mass × length / time²), upwards if
    /// positive.
    ///
    /// # Errors
    /// [`EditError::NotPiston`], [`EditError::NoSuchBody`], or [`EditError::Scene`] if the force is
    /// out of range.
    pub fn push_piston(&mut self, key: BodyKey, force: f64) -> Result<(), EditError> {
        let index = self.index(key)?;
        let name = BodyName::new(&self.world.bodies[index], &self.names);
        let Some(&piston) = self.world.piston(index) else {
            return Err(EditError::NotPiston(name));
        };
        let pushed = Piston {
            force: check_force(&name.to_string(), force, piston.mass)?,
            ..piston
        };
        self.start_to_move();
        self.world.replace_piston(pushed);
        self.moves = true;
        Ok(())
    }

    /// Removes a body; another body of the batch may be added at its position.
    ///
    /// # Errors
    /// [`EditError::NoSuchBody`].
    pub fn remove(&mut self, key: BodyKey) -> Result<(), EditError> {
        let index = self.index(key)?;
        self.start_to_move();
        if let Some(sites) = &mut self.sites {
            sites.remove(&self.world, index);
        }
        self.removed[index] = true;
        self.moves = true;
        Ok(())
    }

    /// Adds a tag to a body.
    ///
    /// # Errors
    /// [`EditError::NoSuchBody`].
    pub fn tag(&mut self, key: BodyKey, name: &str) -> Result<Tag, EditError> {
        let index = self.index(key)?;
        let tag = self.names.intern(name);
        let body = &mut self.world.bodies[index];
        if !body.has_tag(tag) {
            self.edited.edit(&mut body.kind, KindEdit::Tag(tag));
        }
        self.relabels = true;
        Ok(tag)
    }

    /// Removes a tag from a body; a tag that it does not carry changes nothing.
    ///
    /// # Errors
    /// [`EditError::NoSuchBody`].
    pub fn untag(&mut self, key: BodyKey, name: &str) -> Result<(), EditError> {
        let index = self.index(key)?;
        if let Some(tag) = self
            .names
            .find(name)
            .filter(|&tag| self.world.bodies[index].has_tag(tag))
        {
            self.edited
                .edit(&mut self.world.bodies[index].kind, KindEdit::Untag(tag));
            self.relabels = true;
        }
        Ok(())
    }

    /// Changes the elasticity of all later contacts.
    ///
    /// # Errors
    /// [`EditError::Scene`] if a coefficient is out of range.
    pub fn set_elasticity(&mut self, spec: &ElasticitySpec) -> Result<(), EditError> {
        let known = self.names.len();
        self.elasticity = ElasticityTable::new(spec, &mut self.names)
            .inspect_err(|_| self.names.forget_after(known))?;
        // For spins that discs get in this batch; the response is not known here.
        self.world.has_rough_contacts |= spec.is_rough();
        self.relabels = true;
        Ok(())
    }

    /// Changes the drag of all bodies from now on.
    ///
    /// # Errors
    /// Those of [`Simulation::set_drag`].
    pub fn set_drag(&mut self, drag: f64) -> Result<(), EditError> {
        let clock = drag_clock("drag", drag)?;
        if clock != self.world.clock {
            self.start_to_move();
            self.world.clock = clock;
            self.moves = true;
        }
        Ok(())
    }

    /// Changes the gravity from now on (length per time squared).
    ///
    /// # Errors
    /// Those of [`Simulation::set_gravity`].
    pub fn set_gravity(&mut self, gravity: [f64; 2]) -> Result<(), EditError> {
        let gravity = gravity_of("gravity", gravity)?;
        if gravity != self.world.gravity {
            self.start_to_move();
            self.world.gravity = gravity;
            self.moves = true;
        }
        Ok(())
    }

    /// Changes the shear rate from now on (1/time).
    ///
    /// # Errors
    /// Those of [`Simulation::set_shear_rate`].
    pub fn set_shear_rate(&mut self, rate: f64) -> Result<(), EditError> {
        let rate = shear_rate_of("shear_rate", rate)?;
        if rate != self.world.shear_rate {
            self.start_to_move();
            self.world.shear_rate = rate;
            self.moves = true;
        }
        Ok(())
    }

    /// Replaces the pairs of bodies that do not see each other. The batch is refused if bodies
    /// overlap that then see each other.
    ///
    /// # Errors
    /// [`EditError::Scene`] if a rule names no tag or more than two.
    pub fn set_transparent(&mut self, rules: &[TransparentSpec]) -> Result<(), EditError> {
        self.replace_pairs(Some(rules), None)
    }

    /// Replaces the wells of discs. Velocities do not change, and the energy of the pairs becomes
    /// that of the new wells.
    ///
    /// # Errors
    /// [`EditError::Scene`] if a rule names no tag or more than two, or a step is out of range. The
    /// batch is refused if a well does not fit the bodies or the box.
    pub fn set_wells(&mut self, wells: &[WellSpec]) -> Result<(), EditError> {
        self.replace_pairs(None, Some(wells))
    }

    /// Replaces the rules for pairs of tags that are given; the others remain.
    fn replace_pairs(
        &mut self,
        transparent: Option<&[TransparentSpec]>,
        wells: Option<&[WellSpec]>,
    ) -> Result<(), EditError> {
        let known = self.names.len();
        let (present, diameter, present_wells) = self.world.pairs.specs();
        let pairs = PairTable::new(
            transparent.unwrap_or(present),
            diameter,
            wells.unwrap_or(present_wells),
            &mut self.names,
        )
        .inspect_err(|_| self.names.forget_after(known))?;
        // Earlier rules have effects until the bodies are predicted anew.
        self.start_to_move();
        self.world.pairs = pairs;
        (self.moves, self.relabels) = (true, true);
        Ok(())
    }

    /// Replaces the reactions of bodies that collide. Reactions that have been in force before
    /// continue their counts.
    ///
    /// # Errors
    /// [`EditError::Scene`] if a rule names no tag or more than two, a number is out of range, or
    /// its outcome is not clear.
    pub fn set_reactions(&mut self, rules: &[ReactionSpec]) -> Result<(), EditError> {
        let known = self.names.len();
        self.reactions
            .set("reaction", rules, &mut self.names)
            .inspect_err(|_| self.names.forget_after(known))?;
        // Tiles run no reactions.
        self.start_to_move();
        (self.moves, self.relabels) = (true, true);
        Ok(())
    }

    /// Ties bodies by bonds, beside those that there are; numbers are those of their keys.
    ///
    /// # Errors
    /// [`EditError::Scene`] if a body is not there or a number is out of range. The batch is
    /// refused if a bond is beyond its bounds at its end, or ties bodies that cannot be tied.
    pub fn bond(&mut self, spec: &BondSpec) -> Result<(), EditError> {
        let index = |number: u64| self.index(BodyKey::of_id(number)).ok();
        let added = bonds_between(index, "bond", spec)?;
        self.start_to_move();
        let bonds = [self.world.bonds(), &added].concat();
        self.world.tethers = Tethers::new(bonds);
        self.moves = true;
        Ok(())
    }

    /// Removes all bonds of bodies.
    ///
    /// # Errors
    /// [`EditError::NoSuchBody`]; then nothing changes.
    pub fn unbond(&mut self, keys: &[BodyKey]) -> Result<(), EditError> {
        let mut is_cut = vec![false; self.world.bodies.len()];
        for &key in keys {
            is_cut[self.index(key)?] = true;
        }
        self.cut_bonds(|_, body| is_cut[body as usize]);
        Ok(())
    }

    /// Removes all bonds of the bodies that carry a tag.
    pub fn unbond_tag(&mut self, tag: Tag) {
        self.cut_bonds(|world, body| world.bodies[body as usize].has_tag(tag));
    }

    /// Removes the bonds of the bodies that are cut off.
    fn cut_bonds(&mut self, is_cut: impl Fn(&World, u32) -> bool) {
        let bonds = self.world.bonds();
        let remains = |bond: &&Bond| !bond.bodies.iter().any(|&body| is_cut(&self.world, body));
        let others: Vec<Bond> = bonds.iter().filter(remains).copied().collect();
        if others.len() < bonds.len() {
            self.start_to_move();
            self.world.tethers = Tethers::new(others);
            self.moves = true;
        }
    }

    /// Replaces a tag of a body by another.
    pub(super) fn replace_tag(
        &mut self,
        key: BodyKey,
        from: Tag,
        to: Tag,
    ) -> Result<(), EditError> {
        let index = self.index(key)?;
        let kind = &mut self.world.bodies[index].kind;
        self.edited.edit(kind, KindEdit::Untag(from));
        self.edited.edit(kind, KindEdit::Tag(to));
        self.relabels = true;
        Ok(())
    }

    /// Scales velocity and angular velocity of a body so that its kinetic energy is `energy`.
    ///
    /// # Errors
    /// Those of [`Simulation::reset_energy`].
    pub fn reset_energy(&mut self, key: BodyKey, energy: f64) -> Result<(), EditError> {
        let index = self.index(key)?;
        let factor = energy_factor(
            &self.world,
            &self.names,
            (index, &self.world.motions[index]),
            energy,
        )?;
        self.scale(&[(index, factor)]);
        Ok(())
    }

    /// Scales the kinetic energy of each body with this tag to `energy`. Fixed bodies, which have
    /// no energy, are skipped. If one body is refused, none is changed.
    ///
    /// # Errors
    /// Those of [`Simulation::reset_energy_of_tag`].
    pub fn reset_energy_of_tag(&mut self, tag: Tag, energy: f64) -> Result<(), EditError> {
        self.reset_energies(energy, |body| body.has_tag(tag))
    }

    /// Scales the kinetic energy of each moving body to `energy`. If one body is refused, none is
    /// changed.
    ///
    /// # Errors
    /// Those of [`Simulation::reset_energy_of_all`].
    pub fn reset_energy_of_all(&mut self, energy: f64) -> Result<(), EditError> {
        self.reset_energies(energy, |_| true)
    }

    fn reset_energies(
        &mut self,
        energy: f64,
        which: impl Fn(&Body) -> bool,
    ) -> Result<(), EditError> {
        let chosen = |index: usize| !self.removed[index] && which(&self.world.bodies[index]);
        let factors = energy_factors(&self.world, &self.names, energy, chosen)?;
        self.scale(&factors);
        Ok(())
    }

    /// Multiplies velocities and angular velocities of bodies by factors.
    fn scale(&mut self, factors: &[(usize, f64)]) {
        if factors.is_empty() {
            return;
        }
        self.start_to_move();
        for &(index, factor) in factors {
            let motion = &mut self.world.motions[index];
            motion.velocity *= factor;
            motion.angular_velocity *= factor;
        }
        self.moves = true;
    }

    /// Locks the present orientation of a body, or frees it. Locking removes its angular velocity.
    ///
    /// # Errors
    /// [`EditError::Fixed`] or [`EditError::NoSuchBody`].
    pub fn set_rotation(&mut self, key: BodyKey, rotation: Rotation) -> Result<(), EditError> {
        let index = self.index(key)?;
        let body = &mut self.world.bodies[index];
        if !body.is_free() {
            return Err(EditError::Fixed(BodyName::new(body, &self.names)));
        }
        self.edited
            .edit(&mut body.kind, KindEdit::Rotation(rotation));
        self.start_to_move();
        if rotation == Rotation::Locked {
            self.world.motions[index].angular_velocity = 0.0;
        }
        self.moves = true;
        Ok(())
    }

    pub(super) fn index(&self, key: BodyKey) -> Result<usize, EditError> {
        let index = self.world.index(key).filter(|&index| !self.removed[index]);
        index.ok_or(EditError::NoSuchBody(key))
    }

    /// Moves all bodies to the time of the edit, at which the next epoch starts.
    pub(crate) fn start_to_move(&mut self) {
        if let Some(offset) = self.offset.take() {
            self.world.rebase(offset);
        }
    }

    /// Refuses overlaps of bodies that see each other after the batch.
    fn refuse_overlaps(&self) -> Result<(), SceneError> {
        first_overlap(&self.world).map_or(Ok(()), |(pair, depth)| {
            let [first, second] = pair.map(self.world.naming(&self.names));
            Err(SceneError::Overlap {
                first,
                second,
                depth,
            })
        })
    }

    /// The tag of this name, if a body or rule has ever carried it.
    pub fn find_tag(&self, name: &str) -> Option<Tag> {
        self.names.find(name)
    }

    /// The bodies that carry a tag after the edits so far, in the order of insertion.
    pub fn tagged(&self, tag: Tag) -> impl Iterator<Item = BodyKey> {
        self.members(tag)
            .map(|index| self.world.bodies[index].key())
    }

    /// The bodies that are neither fixed nor pistons after the edits so far, in the order of
    /// insertion.
    pub fn moving(&self) -> impl Iterator<Item = BodyKey> {
        self.indices(Body::is_free)
            .map(|index| self.world.bodies[index].key())
    }

    /// The indices of the bodies that carry a tag.
    pub(crate) fn members(&self, tag: Tag) -> impl Iterator<Item = usize> {
        self.indices(move |body| body.has_tag(tag))
    }

    /// The indices of the bodies that are not removed and of which this holds.
    fn indices(&self, which: impl Fn(&Body) -> bool) -> impl Iterator<Item = usize> {
        (0..self.world.bodies.len())
            .filter(move |&index| !self.removed[index] && which(&self.world.bodies[index]))
    }

    fn insert(
        &mut self,
        entry: &str,
        add: impl FnOnce(&mut World, &mut TagNames, &str) -> Result<BodyKey, SceneError>,
    ) -> Result<BodyKey, EditError> {
        self.start_to_move();
        let known = self.names.len();
        let added = add(&mut self.world, &mut self.names, entry).and_then(|key| {
            let refused = self.refuse_overlaps_of_last(entry);
            refused
                .map(|()| key)
                .inspect_err(|_| self.world.take_back_last())
        });
        match added {
            Ok(key) => {
                self.removed.push(false);
                self.moves = true;
                Ok(key)
            }
            Err(error) => {
                self.names.forget_after(known);
                Err(error.into())
            }
        }
    }

    /// Refuses the body added last if it overlaps another, unless both are fixed; lists it
    /// otherwise.
    fn refuse_overlaps_of_last(&mut self, entry: &str) -> Result<(), SceneError> {
        let (world, new) = (&self.world, self.world.bodies.len() - 1);
        let mut sites = self
            .sites
            .take()
            .filter(|sites| !sites.is_crowded(new))
            .unwrap_or_else(|| {
                let mut sites = Sites::new(world);
                (0..new)
                    .filter(|&index| !self.removed[index])
                    .for_each(|index| sites.add(world, index));
                sites
            });
        let overlap = deepest_overlap(world, &sites, new);
        if overlap.is_none() {
            sites.add(world, new);
        }
        self.sites = Some(sites);
        match overlap {
            None => Ok(()),
            Some((other, depth)) => {
                let other = BodyName::new(&self.world.bodies[other], &self.names);
                let (first, second) = (other.to_string(), entry.to_owned());
                Err(SceneError::Overlap {
                    first,
                    second,
                    depth,
                })
            }
        }
    }
}

impl<D: Detection, R: Response, S: Scheduler> Simulation<D, R, S> {
    /// Makes several edits at once: all of them, or none if one is refused.
    ///
    /// A batch of any number of edits costs one copy of the bodies and one start of an epoch, O(N)
    /// for N bodies; k single edits cost k times as much. If the closure returns an error, or the
    /// edited bodies do not fit the grid or the rules of elasticity, no bit of the trajectory
    /// changes. Keys of bodies that a refused batch has added are not reused.
    ///
    /// ```
    /// use carom_engine::{EditError, MoleculeSpec, Scene, Simulation};
    ///
    /// let scene = Scene::from_toml(
    ///     "[[gas]]\ntags = [\"gas\"]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 100",
    /// )?;
    /// let mut simulation = Simulation::new(&scene)?;
    /// simulation.run_until(0.1)?;
    /// // A reaction of two discs: a heavier disc replaces the first.
    /// let pair = simulation.view().bodies().take(2);
    /// let mut pair = pair.map(|body| (body.body.key(), body.motion)).collect::<Vec<_>>();
    /// let (second, first) = (pair.pop().unwrap(), pair.pop().unwrap());
    /// let product = MoleculeSpec {
    ///     shape: Some("disc".to_owned()),
    ///     atom_radius: Some(0.01),
    ///     atom_mass: Some(2.0),
    ///     at: first.1.position.to_array(),
    ///     velocity: (0.5 * (first.1.velocity + second.1.velocity)).to_array(),
    ///     ..MoleculeSpec::default()
    /// };
    /// let product = simulation.edit(|batch| {
    ///     batch.remove(first.0)?;
    ///     batch.remove(second.0)?;
    ///     let product = batch.add(&product)?;
    ///     batch.tag(product, "product")?;
    ///     Ok(product)
    /// })?;
    /// assert_eq!(simulation.view().len(), 99);
    /// // Nothing changes if one edit is refused.
    /// let third = simulation.view().bodies().next().unwrap().body.key();
    /// let refused = simulation.edit(|batch| {
    ///     batch.remove(third)?;
    ///     batch.remove(first.0)
    /// });
    /// assert_eq!(refused, Err(EditError::NoSuchBody(first.0)));
    /// assert!(simulation.view().body(third).is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The error of the closure; [`EditError::Scene`] if a body is too large for the grid or the
    /// box, or if rules of elasticity disagree.
    #[doc(alias = "transaction")]
    pub fn edit<T>(
        &mut self,
        edits: impl FnOnce(&mut Batch) -> Result<T, EditError>,
    ) -> Result<T, EditError> {
        let mut batch = Batch {
            world: self.world.clone(),
            names: self.names.clone(),
            elasticity: self.elasticity.clone(),
            reactions: self.reactions.clone(),
            offset: Some(self.offset),
            sites: None,
            removed: vec![false; self.world.bodies.len()],
            moves: false,
            relabels: false,
            heat: self.heat.clone(),
            edited: EditedKinds::default(),
        };
        if batch.world.has_own_frame() {
            // The batch sees the true velocities.
            batch.start_to_move();
        }
        let result = edits(&mut batch);
        // Also after a refused batch: the closure may have kept the keys of bodies that it added.
        self.world.next_id = batch.world.next_id;
        let result = result?;
        self.accept(batch)?;
        Ok(result)
    }

    /// Takes over an edited world if it fits the elasticity and the grid.
    fn accept(&mut self, mut batch: Batch) -> Result<(), EditError> {
        let has_pairs = batch.world.pairs.has_rules() || self.world.pairs.has_rules();
        let may_reveal = batch.relabels && has_pairs;
        if may_reveal {
            // Tags decide which bodies see each other: predictions begin anew.
            batch.start_to_move();
            batch.moves = true;
        }
        if !batch.moves && !batch.relabels {
            return Ok(());
        }
        if batch.moves {
            batch.world.keep_bodies(|index| !batch.removed[index]);
        }
        self.refuse_impossible(&mut batch)?;
        if may_reveal {
            batch.refuse_overlaps()?;
        }
        if !batch.moves && batch.world.keeps_spins == self.world.keeps_spins {
            self.take_over_rules(batch);
            return Ok(());
        }
        self.take_over_motion(batch)
    }

    /// Classifies the contacts of an edited world, and refuses what cannot be computed in it.
    fn refuse_impossible(&self, batch: &mut Batch) -> Result<(), EditError> {
        let Batch {
            world,
            names,
            elasticity,
            reactions,
            ..
        } = batch;
        refuse_drag(world, world.naming(names))?;
        elasticity.classify(world, &self.response, reactions)?;
        refuse_gravity(world)?;
        refuse_shear(world, world.naming(names))?;
        refuse_pistons(world, world.naming(names))?;
        refuse_bonds(world, elasticity, world.naming(names))?;
        refuse_wells(world, world.naming(names))?;
        refuse_unresolved(world, elasticity)
            .and_then(|()| refuse_unsearched(world, &self.detection))
            .map_err(|reason| reason.named(world.naming(names)))?;
        Ok(())
    }

    /// Takes over the tags and rules of a batch. They affect no motion and no prediction: the epoch
    /// continues.
    fn take_over_rules(&mut self, batch: Batch) {
        let Batch {
            world,
            names,
            elasticity,
            reactions,
            ..
        } = batch;
        self.come_back_to_present();
        self.world.bodies = world.bodies;
        self.world.has_rough_contacts = world.has_rough_contacts;
        self.world
            .keep_last_contacts(!world.last_contacts.is_empty());
        self.world.has_reactions = world.has_reactions;
        self.world.has_special_contacts = world.has_special_contacts;
        (self.names, self.elasticity, self.reactions) = (names, elasticity, reactions);
    }

    /// Takes over all of a batch, and books what it has put in; an epoch begins.
    ///
    /// # Errors
    /// A bond is too long or too short, or the grid does not fit the bodies: nothing is taken over.
    fn take_over_motion(&mut self, batch: Batch) -> Result<(), EditError> {
        let Batch {
            mut world,
            names,
            elasticity,
            reactions,
            offset,
            heat,
            ..
        } = batch;
        if let Some(offset) = offset {
            world.rebase(offset);
        }
        refuse_stretched(&world, world.naming(&names))?;
        world.sort_into_shells();
        let scheduler = S::checked(&self.scheduler_options, &world)
            .map_err(|reason| reason.named(world.naming(&names)))?;
        self.ledger.put_in += exact_sum(
            world
                .energies()
                .chain(self.world.energies_at(self.offset).map(|energy| -energy)),
        );
        self.book_flight();
        // What the batch has wrapped is part of what it has put in.
        world.work_of_shear = 0.0;
        self.work_before = self.counters.scheduler;
        (self.offset, self.epoch) = (0.0, Epoch::ToBegin);
        (self.simultaneous, self.unresolved) =
            (SimultaneousContacts::default(), Unresolved::default());
        (self.world, self.names, self.elasticity, self.scheduler) =
            (world, names, elasticity, scheduler);
        (self.heat, self.reactions) = (heat, reactions);
        self.walls_meet_after = EpochTime::ZERO;
        Ok(())
    }
}

/// The factors for velocities and angular velocities that give each chosen body this energy; fixed
/// bodies, which have no energy, are skipped.
pub(crate) fn energy_factors(
    world: &World,
    names: &TagNames,
    energy: f64,
    chosen: impl Fn(usize) -> bool,
) -> Result<Vec<(usize, f64)>, EditError> {
    (0..world.bodies.len())
        .filter(|&index| !world.bodies[index].is_fixed() && chosen(index))
        .map(|index| {
            let body = (index, &world.motions[index]);
            energy_factor(world, names, body, energy).map(|factor| (index, factor))
        })
        .collect()
}

/// The factor for velocity and angular velocity of a body with this motion that gives it this
/// energy.
pub(crate) fn energy_factor(
    world: &World,
    names: &TagNames,
    (index, motion): (usize, &Motion),
    energy: f64,
) -> Result<f64, EditError> {
    if !(energy.is_finite() && energy > 0.0) {
        return Err(EditError::Energy(energy));
    }
    let body = &world.bodies[index];
    if body.is_fixed() {
        return Err(EditError::Fixed(BodyName::new(body, names)));
    }
    let before = kinetic_energy(motion, &body.kind.inertia);
    if before == 0.0 {
        return Err(EditError::NoEnergy(BodyName::new(body, names)));
    }
    let factor = (energy / before).sqrt();
    let (speed, spin) = (
        factor * motion.velocity.length(),
        factor * motion.angular_velocity.abs(),
    );
    let rim = spin * body.kind.molecule.bounding_radius();
    // NaN and infinite factors are out of range as well.
    let is_in_range = speed.max(spin) <= MAX_MAGNITUDE && speed.max(rim) >= MIN_SPEED;
    if is_in_range && factor.is_finite() {
        Ok(factor)
    } else {
        Err(EditError::Energy(energy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{cells::CellScheduler, scene::Scene};
    use carom_detection::Exact;
    use carom_response::Impact;

    type Edit = fn(&mut Batch, BodyKey) -> Result<(), EditError>;

    /// A hundred molecules, alternately dumbbells and discs.
    fn mixture() -> Simulation<Exact, Impact, CellScheduler> {
        let molecule = |n: u32| MoleculeSpec {
            shape: Some(["dumbbell", "disc"][n as usize % 2].to_owned()),
            atom_radius: Some(0.01),
            atom_mass: Some(1.0),
            at: [0.1 * f64::from(n % 10), 0.1 * f64::from(n / 10)],
            velocity: [1.0, 0.5],
            ..MoleculeSpec::default()
        };
        Simulation::new(&Scene {
            molecule: (0..100).map(molecule).collect(),
            ..Scene::default()
        })
        .unwrap()
    }

    #[test]
    fn equal_bodies_share_their_description_after_each_kind_of_edit() {
        let mut simulation = mixture();
        let keys: Vec<BodyKey> = simulation
            .world
            .bodies
            .iter()
            .map(|body| body.key)
            .collect();
        let mut kinds = Vec::new();
        let edits: [Edit; 6] = [
            |batch, key| batch.tag(key, "a").map(|_| ()),
            |batch, key| batch.tag(key, "b").map(|_| ()),
            |batch, key| batch.untag(key, "a"),
            |batch, key| batch.set_rotation(key, Rotation::Locked),
            |batch, key| batch.set_rotation(key, Rotation::Free),
            |batch, key| {
                batch.tag(key, "c")?;
                batch.set_rotation(key, Rotation::Locked)?;
                batch.untag(key, "b")
            },
        ];
        for edit in edits {
            simulation
                .edit(|batch| keys.iter().try_for_each(|&key| edit(batch, key)))
                .unwrap();
            kinds.push(simulation.world.count_kinds());
        }
        assert_eq!(kinds, [2; 6]);
        let tag = simulation.names.find("c").unwrap();
        assert!(
            simulation
                .world
                .bodies
                .iter()
                .all(|body| body.tags() == [tag] && body.is_locked())
        );
    }
}
