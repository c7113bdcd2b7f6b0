//! Checkpoints: the state on which a run depends from the end of an epoch on, as plain data.
//!
//! An epoch starts from positions and velocities alone, so at its end no prediction, list or queue
//! needs to be kept. A checkpoint contains each body with its motion, the time, the counters, the
//! ledger, and the rules. The random numbers of a scene are used only when it is built.

use std::sync::Arc;

use carom_detection::{Detection, Exact};
use carom_geometry::{MAX_MAGNITUDE, Molecule, PeriodicBox};
use carom_kinematics::{EpochTime, Inertia, Motion, Orientation};
use carom_response::{Impact, Response};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    cells::CellScheduler,
    contact::{
        elasticity_table::ElasticityTable,
        limits::too_slow,
        separation::{refuse_unresolved, refuse_unsearched},
        simultaneous_contacts::SimultaneousContacts,
        unresolved::Unresolved,
    },
    run::{
        saved_bonds::{SavedBond, tethers},
        saved_elasticity::SavedElasticity,
        saved_reactions::SavedReactions,
        saved_wells::SavedWell,
        simulation::{Epoch, Simulation},
    },
    scene::{
        drag::drag_clock,
        error::SceneError,
        gravity::{gravity_of, refuse_gravity},
        least_speed::MIN_SPEED,
        pair_spec::{DiameterSpec, TransparentSpec},
        shear::{refuse_shear, shear_rate_of},
        well_spec::WellSpec,
    },
    scheduler::Scheduler,
    start::{
        body_builder::inertia,
        bonds::{refuse_bonds, refuse_stretched},
        pistons::refuse_pistons,
        single_bodies::{is_open_wall, is_wall_temperature, refuse_large_wall},
        wells::refuse_wells,
    },
    world::{
        World,
        body::{BodyKey, BodyKind, Rotation},
        counters::{Counters, Ledger},
        drives::Oscillation,
        heat::HeatByTag,
        pair_table::PairTable,
        pistons::Piston,
        tags::{TagNames, Tags},
        wall_table::WallTable,
    },
};

/// The state of a simulation at the end of an epoch, to be stored and resumed.
///
/// All bits of its numbers survive in any format that keeps those of an `f64`. Detector, response
/// and scheduler are not part of it: the caller chooses them again on resuming, and only the same
/// choice gives the bits of an uninterrupted run.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use carom_kinematics::EpochTime;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 50")?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.observe_epoch(EpochTime::from(10.0), &mut ())?;
/// let checkpoint = simulation.checkpoint().expect("the epoch has ended before that");
/// let mut resumed = Simulation::resume(&checkpoint)?;
/// simulation.run_until(10.0)?;
/// resumed.run_until(10.0)?;
/// assert_eq!(simulation.view().counters(), resumed.view().counters());
/// assert_eq!(simulation.view().momentum(), resumed.view().momentum());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Checkpoint {
    epoch: EpochTime,
    /// Seed and replica, for walls that have a temperature.
    random_key: [u64; 2],
    bounds: PeriodicBox,
    /// Drag of all bodies (1/time).
    drag: f64,
    next_key: BodyKey,
    /// Shapes, each once for all bodies that share it.
    molecules: Vec<Molecule>,
    bodies: Vec<SavedBody>,
    /// Times of last contacts, for the guard against inelastic collapse; −∞ for a body without
    /// contacts.
    last_contacts: Vec<f64>,
    /// Axes of round bodies that self-propulsion drives, by the order of the bodies.
    axes: Vec<Option<Orientation>>,
    /// Acceleration of all free bodies (length per time squared).
    gravity: DVec2,
    /// Shear rate (1/time), and the tilt of the box (length).
    shear: [f64; 2],
    /// Walls that oscillate, by the order of the bodies.
    oscillations: Vec<Option<Oscillation>>,
    /// Walls with a mass, by the order of the bodies.
    pistons: Vec<Piston>,
    /// Walls whose velocity changes at given times.
    wall_tables: Vec<WallTable>,
    /// Bodies tied to each other, by the order of the bodies.
    bonds: Vec<SavedBond>,
    /// Discs in their wells, by the order of the bodies, and the shell of each pair.
    shells: Vec<([u32; 2], u8)>,
    names: TagNames,
    elasticity: SavedElasticity,
    transparent: Vec<TransparentSpec>,
    diameter: Vec<DiameterSpec>,
    wells: Vec<SavedWell>,
    counters: Counters,
    ledger: Ledger,
    heat: HeatByTag,
    reactions: SavedReactions,
    simultaneous: SimultaneousContacts,
    unresolved: Unresolved,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct SavedBody {
    key: BodyKey,
    molecule: u32,
    /// Whether the body turns; with its shape this gives its inertia. `None`: it is fixed.
    rotation: Option<Rotation>,
    tags: Tags,
    /// kT of a wall that has a temperature.
    temperature: Option<f64>,
    motion: Motion,
    winding: [i64; 2],
}

/// Largest value of a counter: no run takes long enough to overflow the remaining range.
const MAX_COUNTED: u64 = 1 << 62;

/// A checkpoint that no simulation can have written.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The record of a body is invalid.
    #[error("body {index} of the checkpoint {problem}")]
    Body {
        /// Index of the body in the order of insertion.
        index: usize,
        /// Description of the problem.
        problem: &'static str,
    },
    /// A speed of a body is out of range.
    #[error(
        "{quantity} of body {index} of the checkpoint must be 0 or from {MIN_SPEED:e} to {MAX_MAGNITUDE:e}, but is {value:e}"
    )]
    Speed {
        /// Index of the body in the order of insertion.
        index: usize,
        /// Name of the speed.
        quantity: &'static str,
        /// The speed (length per time), or the angular velocity (radians per time).
        value: f64,
    },
    /// A number of the run is out of range.
    #[error("the checkpoint's {what} must be {allowed}, but is {value}")]
    OutOfRange {
        /// Name of the number.
        what: &'static str,
        /// Its allowed range.
        allowed: &'static str,
        /// Its value.
        value: f64,
    },
    /// The time, a contact time or the ledger holds a number that is not finite.
    #[error("the checkpoint's {0} is not finite")]
    NotFinite(&'static str),
    /// There must be a time of last contact for each body where contacts lose energy, and none
    /// elsewhere.
    #[error(
        "the checkpoint has {0} times of last contacts; it must have one per body with a guard, else none"
    )]
    LastContacts(usize),
    /// An axis that is no orientation, or of a body that is not there.
    #[error(
        "the checkpoint has {0} axes; it must have at most one per body, from -0.5 to 0.5 turns"
    )]
    Axes(usize),
    /// An oscillation whose numbers are out of range or not those of the motion, or of a body that
    /// is no wall.
    #[error(
        "oscillation {0} of the walls in the checkpoint must be that of a wall, with finite numbers, a positive \
         frequency, and the position and velocity of the wall"
    )]
    Oscillation(usize),
    /// A tilt of more than half a box.
    #[error("the tilt of the box is {0} (length), more than half a side")]
    Tilt(f64),
    /// A table of a wall whose numbers are out of range, or of a body that is no wall.
    #[error(
        "table {0} of the walls in the checkpoint must be that of a wall, with durations above 0, finite velocities, and a \
         next piece in the future"
    )]
    WallTable(usize),
    /// A piston whose numbers are out of range, or of a body that is no wall across the box.
    #[error(
        "piston {0} of the checkpoint must be a wall across the box, between its stops, with a mass, move along its \
         normal, and have no stop in the future"
    )]
    Piston(usize),
    /// A bond whose numbers are out of range, or of a body that is not there.
    #[error(
        "bond {0} of the checkpoint must tie two bodies in their order, with lengths, points and an elasticity in range"
    )]
    Bond(usize),
    /// A pair in a well that is not there, or not at that distance.
    #[error(
        "pair {0} in a well of the checkpoint must be two discs in their order, at the distance of their shell"
    )]
    Shell(usize),
    /// A tag with heat has no name.
    #[error("the checkpoint has heat of a tag without a name")]
    UnnamedHeat,
    /// Bodies, box and rules do not fit each other.
    #[error("the checkpoint cannot be resumed: {0}")]
    Scene(#[from] SceneError),
}

impl Simulation {
    /// Resumes from a checkpoint with the exact detector and the default scheduler.
    ///
    /// # Errors
    /// [`CheckpointError`] if no simulation can have written it.
    pub fn resume(checkpoint: &Checkpoint) -> Result<Self, CheckpointError> {
        Self::resume_with(
            checkpoint,
            Exact::default(),
            Impact,
            <CellScheduler as Scheduler>::Options::default(),
        )
    }
}

impl<D: Detection, R: Response, S: Scheduler> Simulation<D, R, S> {
    /// Returns the state if an epoch has ended and the next has not begun: after
    /// [`Self::observe_epoch`] has stopped before its target time, and before the first run. `None`
    /// within an epoch.
    ///
    /// A checkpoint changes nothing in the simulation.
    pub fn checkpoint(&self) -> Option<Checkpoint> {
        // All fields are listed, so that a new field cannot be forgotten here.
        let Self {
            world,
            detection: _,
            response: _,
            scheduler: _,
            scheduler_options: _,
            contacts_per_epoch: _,
            tiling: _,
            elasticity,
            names,
            counters,
            // Already included in the counters.
            work_before: _,
            ledger,
            heat,
            reactions,
            offset,
            epoch,
            simultaneous,
            unresolved,
            walls_meet_after: _,
        } = self;
        if !matches!(epoch, Epoch::ToBegin) {
            return None;
        }
        debug_assert_eq!(*offset, 0.0, "an epoch that has not begun has not been run");
        let World {
            bounds,
            bodies: _,
            motions: _,
            windings: _,
            last_contacts,
            axes,
            oscillations,
            gravity,
            shear_rate,
            work_of_shear,
            pistons,
            wall_tables,
            tethers,
            shells,
            epoch,
            next_id,
            random_key,
            clock,
            stop: _,
            has_thermal_walls: _,
            has_reactions: _,
            has_special_contacts: _,
            pairs,
            has_rough_contacts: _,
            keeps_spins: _,
        } = world;
        let (transparent, diameter, wells) = pairs.specs();
        let (molecules, bodies) = records(world);
        Some(Checkpoint {
            epoch: *epoch,
            random_key: *random_key,
            bounds: *bounds,
            drag: clock.drag(),
            next_key: BodyKey(*next_id),
            molecules,
            bodies,
            last_contacts: last_contacts.clone(),
            axes: axes.clone(),
            oscillations: oscillations.clone(),
            gravity: *gravity,
            shear: [*shear_rate, bounds.tilt()],
            pistons: pistons.clone(),
            wall_tables: wall_tables.clone(),
            bonds: tethers.bonds().iter().map(SavedBond::from).collect(),
            shells: (shells.pairs().into_iter())
                .map(|(bodies, shell)| (bodies, shell.number))
                .collect(),
            names: names.clone(),
            elasticity: elasticity.spec().into(),
            transparent: transparent.to_vec(),
            diameter: diameter.to_vec(),
            wells: wells.iter().map(SavedWell::from).collect(),
            counters: *counters,
            ledger: Ledger {
                sheared: ledger.sheared + work_of_shear,
                ..*ledger
            },
            heat: heat.clone(),
            reactions: SavedReactions::new(reactions),
            simultaneous: simultaneous.clone(),
            unresolved: *unresolved,
        })
    }

    /// Ends the epoch at the present time and returns the state. Unlike [`Self::checkpoint`], this
    /// is possible at any time, but it changes the later trajectory by rounding.
    ///
    /// ```
    /// use carom_engine::{Scene, Simulation};
    ///
    /// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 50")?;
    /// let mut simulation = Simulation::new(&scene)?;
    /// simulation.run_until(0.3)?;
    /// let state = simulation.end_epoch_here();
    /// simulation.run_until(1.3)?;
    /// // Another run from that state, whose clock begins at 0.
    /// let mut other = Simulation::resume(&state.as_start(0, 0)?)?;
    /// assert_eq!(other.view().counters().collisions, 0);
    /// other.run_until(1.0)?;
    /// let [one, two] = [&simulation, &other].map(|run| run.view().bodies().next().unwrap().motion);
    /// assert!((one.position - two.position).length() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Never: an epoch that has ended has a state.
    pub fn end_epoch_here(&mut self) -> Checkpoint {
        self.end_epoch(self.offset);
        self.checkpoint()
            .expect("an epoch that has ended has a state")
    }

    /// Resumes from a checkpoint with the given detector, response and options of the scheduler.
    ///
    /// # Errors
    /// [`CheckpointError`] if no simulation can have written it, or if the options do not fit its
    /// bodies.
    pub fn resume_with(
        checkpoint: &Checkpoint,
        detection: D,
        response: R,
        options: S::Options,
    ) -> Result<Self, CheckpointError> {
        checkpoint.refuse_infinite()?;
        checkpoint.refuse_overflowing()?;
        let mut world = checkpoint.world()?;
        checkpoint.oscillate_walls(&mut world)?;
        world.gravity = gravity_of("gravity", checkpoint.gravity.to_array())?;
        checkpoint.shear(&mut world)?;
        checkpoint.free_pistons(&mut world)?;
        world.tethers =
            tethers(&checkpoint.bonds, world.bodies.len()).map_err(CheckpointError::Bond)?;
        let mut names = checkpoint.names.clone();
        world.pairs = checkpoint.pair_table(&mut names)?;
        let mut elasticity =
            ElasticityTable::new(&checkpoint.elasticity.clone().into(), &mut names)?;
        let mut reactions = checkpoint.reactions.table(&mut names)?;
        elasticity.classify(&mut world, &response, &mut reactions)?;
        refuse_unfit(&world, &elasticity, &names)?;
        world
            .restore_shells(&checkpoint.shells)
            .map_err(CheckpointError::Shell)?;
        refuse_unresolved(&world, &elasticity)
            .and_then(|()| refuse_unsearched(&world, &detection))
            .map_err(|reason| reason.named(world.naming(&names)))?;
        checkpoint.restore_bodies(&mut world)?;
        checkpoint.move_walls(&mut world)?;
        if let Some((index, value)) = too_slow(&world) {
            return Err(CheckpointError::Speed {
                index,
                quantity: "the speed",
                value,
            });
        }
        let scheduler =
            S::checked(&options, &world).map_err(|reason| reason.named(world.naming(&names)))?;
        Ok(Self {
            counters: checkpoint.counters,
            work_before: checkpoint.counters.scheduler,
            ledger: checkpoint.ledger,
            heat: checkpoint.heat.clone(),
            reactions,
            simultaneous: checkpoint.simultaneous.clone(),
            unresolved: checkpoint.unresolved,
            ..Self::assemble(
                world,
                (detection, response),
                (scheduler, options),
                elasticity,
                names,
            )
        })
    }
}

impl Checkpoint {
    /// The time of the checkpoint.
    pub fn time(&self) -> EpochTime {
        self.epoch
    }

    /// The names of the tags.
    pub fn tag_names(&self) -> &TagNames {
        &self.names
    }

    /// This state as the start of another run with this seed and replica: at time 0, with no heat,
    /// and a ledger that begins with the present energy. Bodies, motions, windings and rules
    /// remain. All counts are 0 except those of contacts with walls that have a temperature, and of
    /// contacts at which reactions were possible, which select their random numbers: a run with the
    /// same seed does not repeat them.
    ///
    /// # Errors
    /// [`CheckpointError`] if no simulation can have written it.
    pub fn as_start(self, seed: u64, replica: u64) -> Result<Self, CheckpointError> {
        let initial = self.world()?.energy();
        Ok(Self {
            epoch: EpochTime::ZERO,
            random_key: [seed, replica],
            counters: Counters {
                thermal_collisions: self.counters.thermal_collisions,
                reactive_collisions: self.counters.reactive_collisions,
                ..Counters::default()
            },
            ledger: Ledger {
                initial,
                ..Ledger::default()
            },
            heat: HeatByTag::default(),
            reactions: self.reactions.restarted(),
            pistons: self
                .pistons
                .iter()
                .map(|piston| piston.restarted(self.epoch))
                .collect(),
            ..self
        })
    }

    fn refuse_infinite(&self) -> Result<(), CheckpointError> {
        let finite = |what, numbers: &[f64]| {
            let all = numbers.iter().all(|number| number.is_finite());
            if all {
                Ok(())
            } else {
                Err(CheckpointError::NotFinite(what))
            }
        };
        finite(
            "time",
            &[
                self.epoch.epoch(),
                self.epoch.epoch_low(),
                self.epoch.offset(),
            ],
        )?;
        finite(
            "time of the last contact",
            &[self.simultaneous.time, self.unresolved.since],
        )?;
        finite("ledger", &self.ledger.entries())?;
        if !self.heat.is_finite() {
            return Err(CheckpointError::NotFinite("heat of a tag"));
        }
        if !self.reactions.is_finite() {
            return Err(CheckpointError::NotFinite("energy of a reaction"));
        }
        if !self.heat.is_named(&self.names) {
            return Err(CheckpointError::UnnamedHeat);
        }
        if self
            .last_contacts
            .iter()
            .any(|&time| time.is_nan() || time == f64::INFINITY)
        {
            return Err(CheckpointError::NotFinite("time of a last contact"));
        }
        Ok(())
    }

    /// Refuses counters so large that they could overflow, and times of last contacts in the
    /// future.
    fn refuse_overflowing(&self) -> Result<(), CheckpointError> {
        let out_of_range = |what, allowed, value| CheckpointError::OutOfRange {
            what,
            allowed,
            value,
        };
        let simultaneous = self.simultaneous.counts.values().copied().max();
        let counts = [
            self.counters.largest_count(),
            self.reactions.largest_count(),
            self.next_key.0,
            simultaneous.map_or(0, |count| u64::from(count) << 32),
            u64::from(self.unresolved.count) << 32,
            self.heat.largest_count(),
        ];
        let windings = self
            .bodies
            .iter()
            .flat_map(|body| body.winding)
            .map(i64::unsigned_abs);
        let largest = counts.into_iter().chain(windings).max().unwrap_or(0);
        if largest > MAX_COUNTED {
            return Err(out_of_range(
                "largest count",
                "at most 2^62",
                largest as f64,
            ));
        }
        let counted = self.simultaneous.time.max(self.unresolved.since);
        let last = self.last_contacts.iter().copied().fold(counted, f64::max);
        if last > 0.0 {
            return Err(out_of_range("time of the last contact", "at most 0", last));
        }
        Ok(())
    }

    /// The world at the time of the checkpoint.
    fn world(&self) -> Result<World, CheckpointError> {
        let bounds =
            PeriodicBox::new(self.bounds.sides()).map_err(|reason| SceneError::Geometry {
                entry: "box".to_owned(),
                reason,
            })?;
        let mut world = World {
            epoch: self.epoch,
            next_id: self.next_key.0,
            random_key: self.random_key,
            clock: drag_clock("drag", self.drag)?,
            ..World::new(bounds)
        };
        let molecules: Vec<Arc<Molecule>> = self.molecules.iter().cloned().map(Arc::new).collect();
        for (index, record) in self.bodies.iter().enumerate() {
            let wrong = |problem| CheckpointError::Body { index, problem };
            let molecule = molecules
                .get(record.molecule as usize)
                .ok_or_else(|| wrong("has a shape that is not in the list of shapes"))?;
            if world
                .bodies
                .last()
                .is_some_and(|before| before.key >= record.key)
            {
                return Err(wrong("is out of order"));
            }
            if record.key >= self.next_key {
                return Err(wrong("has a key that has not been assigned"));
            }
            if record.tags.iter().any(|&tag| !self.names.knows(tag)) {
                return Err(wrong("has a tag without a name"));
            }
            refuse_large_wall(
                &format!("body {index} of the checkpoint"),
                molecule,
                bounds.sides(),
            )?;
            record.check(molecule, &bounds).map_err(wrong)?;
            record.check_speeds(index, molecule)?;
            world.push_body(record.key, record.kind(molecule));
            world.motions.push(record.motion);
            world.windings.push(record.winding);
        }
        Ok(world)
    }
}

impl Checkpoint {
    /// Sets the shear rate and the tilt of the box.
    fn shear(&self, world: &mut World) -> Result<(), CheckpointError> {
        let [rate, tilt] = self.shear;
        world.shear_rate = shear_rate_of("shear_rate", rate)?;
        if tilt.is_nan() || tilt.abs() > 0.5 * world.bounds.sides().x {
            return Err(CheckpointError::Tilt(tilt));
        }
        world.bounds = world.bounds.tilted(tilt);
        Ok(())
    }

    /// Gives the walls that oscillate their oscillations.
    fn oscillate_walls(&self, world: &mut World) -> Result<(), CheckpointError> {
        let is_valid = |(wall, oscillation): (usize, &Option<Oscillation>)| {
            oscillation.is_none_or(|oscillation| {
                let body = world.bodies.get(wall).zip(world.motions.get(wall));
                body.is_some_and(|(body, motion)| {
                    body.is_wall()
                        && body.is_fixed()
                        && oscillation.is_of(motion, world.bounds.sides())
                })
            })
        };
        let is_canonical = self.oscillations.len() <= world.bodies.len()
            && (self.oscillations.is_empty() || self.oscillations.iter().any(Option::is_some));
        if !is_canonical {
            return Err(CheckpointError::Oscillation(self.oscillations.len()));
        }
        let mut oscillations = self.oscillations.iter().enumerate();
        if let Some(wrong) = oscillations.position(|oscillation| !is_valid(oscillation)) {
            return Err(CheckpointError::Oscillation(wrong));
        }
        world.oscillations.clone_from(&self.oscillations);
        Ok(())
    }

    /// The rules for pairs of bodies.
    fn pair_table(&self, names: &mut TagNames) -> Result<PairTable, SceneError> {
        let wells: Vec<WellSpec> = self.wells.iter().map(WellSpec::from).collect();
        PairTable::new(&self.transparent, &self.diameter, &wells, names)
    }

    /// Gives the bodies their axes and the times of their last contacts.
    fn restore_bodies(&self, world: &mut World) -> Result<(), CheckpointError> {
        let is_axis = |axis: &Orientation| axis.turns().abs() <= 0.5;
        if self.axes.len() > world.bodies.len() || !self.axes.iter().flatten().all(is_axis) {
            return Err(CheckpointError::Axes(self.axes.len()));
        }
        if self.last_contacts.len() != world.last_contacts.len() {
            return Err(CheckpointError::LastContacts(self.last_contacts.len()));
        }
        world.last_contacts.clone_from(&self.last_contacts);
        world.axes.clone_from(&self.axes);
        Ok(())
    }

    /// Gives the walls with tables their times and places.
    fn move_walls(&self, world: &mut World) -> Result<(), CheckpointError> {
        let is_of_wall = |table: &WallTable| {
            let wall = world.index(table.key);
            let is_free_wall = |wall: usize| {
                let body = &world.bodies[wall];
                body.is_wall() && body.is_fixed() && world.oscillation(wall).is_none()
            };
            table.is_valid() && wall.is_some_and(is_free_wall)
        };
        let mut tables = self.wall_tables.iter();
        if let Some(wrong) = tables.position(|table| !is_of_wall(table)) {
            return Err(CheckpointError::WallTable(wrong));
        }
        world.wall_tables.clone_from(&self.wall_tables);
        Ok(())
    }

    /// Gives the pistons of the checkpoint their masses.
    fn free_pistons(&self, world: &mut World) -> Result<(), CheckpointError> {
        for (number, piston) in self.pistons.iter().enumerate() {
            let wrong = CheckpointError::Piston(number);
            let Some(index) = world.index(piston.key) else {
                return Err(wrong);
            };
            let body = &world.bodies[index];
            let Some(axis) = body.axis_across().filter(|_| body.is_fixed()) else {
                return Err(wrong);
            };
            let is_free = world.oscillation(index).is_none() && body.wall_temperature().is_none();
            let side = world.bounds.sides()[axis];
            let since = |stop| (0.0..f64::INFINITY).contains(&self.epoch.since(stop));
            let is_past = piston.last_stop.is_none_or(since);
            if !(is_free && is_past && piston.is_of(&world.motions[index], axis, side)) {
                return Err(wrong);
            }
            world.free_piston(index, *piston);
        }
        Ok(())
    }
}

impl SavedBody {
    /// Checks that a body of this shape can have this motion.
    ///
    /// # Errors
    /// The problem, as the rest of a sentence on the body.
    fn check(&self, molecule: &Molecule, bounds: &PeriodicBox) -> Result<(), &'static str> {
        let Motion {
            position,
            velocity,
            orientation,
            angular_velocity,
            time,
        } = self.motion;
        if !(position.is_finite()
            && velocity.is_finite()
            && angular_velocity.is_finite()
            && time == 0.0)
        {
            return Err("has a motion that is not finite");
        }
        let is_turned_once = orientation.turns().abs() <= 0.5;
        if !bounds.contains(position) || !is_turned_once {
            return Err("is out of the box or turned by more than half a turn");
        }
        if molecule.is_wall() && self.rotation.is_some() {
            return Err("is a wall that can move");
        }
        if let Some(temperature) = self.temperature
            && !(molecule.is_wall() && is_wall_temperature(temperature))
        {
            return Err("has a temperature but is no wall, or one out of range");
        }
        if is_open_wall(molecule, orientation, bounds.sides()) {
            return Err("is a wall without end points that does not meet its own images");
        }
        let may_turn = molecule.is_wall() && !molecule.atoms().is_empty();
        if self.rotation.is_none()
            && (angular_velocity != 0.0 && !may_turn
                || velocity != DVec2::ZERO && !molecule.is_wall())
        {
            return Err("is fixed but moves");
        }
        if self.rotation == Some(Rotation::Locked) && angular_velocity != 0.0 {
            return Err("cannot turn but has an angular velocity");
        }
        Ok(())
    }

    /// Refuses velocities out of range of the body at this index, which has this shape.
    fn check_speeds(&self, index: usize, molecule: &Molecule) -> Result<(), CheckpointError> {
        let too_fast = |quantity, value| CheckpointError::Speed {
            index,
            quantity,
            value,
        };
        let speed = self.motion.velocity.abs().max_element();
        if speed > MAX_MAGNITUDE {
            return Err(too_fast("a component of the velocity", speed));
        }
        // A small molecule may turn faster than a scene may specify, but the speed of its rim is at
        // most 1e60.
        let spin = self.motion.angular_velocity.abs();
        if spin > MAX_MAGNITUDE && spin * molecule.bounding_radius() > MAX_MAGNITUDE {
            return Err(too_fast("the angular velocity", spin));
        }
        Ok(())
    }

    fn kind(&self, molecule: &Arc<Molecule>) -> BodyKind {
        BodyKind {
            molecule: Arc::clone(molecule),
            inertia: self
                .rotation
                .map_or(Inertia::FIXED, |rotation| inertia(molecule, rotation)),
            tags: self.tags.clone(),
            tag_class: 0,
            has_rough_contacts: false,
            temperature: self.temperature,
        }
    }
}

/// Refuses bodies and rules that do not fit each other.
fn refuse_unfit(
    world: &World,
    elasticity: &ElasticityTable,
    names: &TagNames,
) -> Result<(), SceneError> {
    refuse_gravity(world)?;
    refuse_shear(world, world.naming(names))?;
    refuse_pistons(world, world.naming(names))?;
    refuse_bonds(world, elasticity, world.naming(names))?;
    refuse_stretched(world, world.naming(names))?;
    refuse_wells(world, world.naming(names))
}

/// The shapes, and the bodies with the indices of their shapes.
fn records(world: &World) -> (Vec<Molecule>, Vec<SavedBody>) {
    let mut shapes: Vec<&Arc<Molecule>> = world
        .bodies
        .iter()
        .map(|body| &body.kind.molecule)
        .collect();
    let address = |shape: &Arc<Molecule>| Arc::as_ptr(shape);
    shapes.sort_by_key(|shape| address(shape));
    shapes.dedup_by_key(|shape| address(shape));
    // Addresses differ between runs, so shapes are listed in the order of the first bodies that
    // have them.
    let mut places = vec![None; shapes.len()];
    let mut molecules = Vec::with_capacity(shapes.len());
    let mut bodies = Vec::with_capacity(world.bodies.len());
    for ((body, &motion), &winding) in world.bodies.iter().zip(&world.motions).zip(&world.windings)
    {
        let found = shapes.partition_point(|shape| address(shape) < address(&body.kind.molecule));
        let place = *places[found].get_or_insert_with(|| {
            molecules.push(body.molecule().clone());
            molecules.len() as u32 - 1
        });
        let rotation = if body.is_locked() {
            Rotation::Locked
        } else {
            Rotation::Free
        };
        bodies.push(SavedBody {
            key: body.key,
            molecule: place,
            rotation: (!body.is_fixed() && !body.is_wall()).then_some(rotation),
            tags: body.kind.tags.clone(),
            temperature: body.kind.temperature,
            motion,
            winding,
        });
    }
    (molecules, bodies)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        scene::{Scene, gas_spec::GasSpec},
        world::{heat::ThermostatCounts, tags::Tag},
    };
    use carom_kinematics::Orientation;

    fn sound() -> Checkpoint {
        let gas = GasSpec {
            tags: vec!["gas".to_owned()],
            radius: Some(0.02.into()),
            mass: Some(1.0.into()),
            energy: 1.0,
            count: Some(3),
            ..GasSpec::default()
        };
        Simulation::new(&Scene {
            gas: vec![gas],
            ..Scene::default()
        })
        .unwrap()
        .checkpoint()
        .unwrap()
    }

    /// The error message after `spoil` has changed a valid checkpoint.
    fn refusal(spoil: impl FnOnce(&mut Checkpoint)) -> String {
        let mut checkpoint = sound();
        spoil(&mut checkpoint);
        Simulation::resume(&checkpoint).unwrap_err().to_string()
    }

    /// Replaces all bodies by walls without end points, of this span and orientation (turns).
    fn wall_bodies(checkpoint: &mut Checkpoint, span: DVec2, turns: f64) {
        checkpoint.molecules[0] = Molecule::wall_without_ends(span, 0.0).unwrap();
        for body in &mut checkpoint.bodies {
            body.rotation = None;
            body.motion.velocity = DVec2::ZERO;
            body.motion.orientation = Orientation::from_turns(turns);
        }
    }

    #[test]
    fn walls_across_the_box_are_resumed() {
        let mut checkpoint = sound();
        wall_bodies(&mut checkpoint, DVec2::Y, 0.0);
        assert!(Simulation::resume(&checkpoint).is_ok());
        // Sides that are no floats in decimal notation.
        let walls = "box.sides = [0.3, 0.7]\n[[wall]]\nx = 0.1\nradius = 1e-3\n[[wall]]\ny = 0.2";
        let scene = Scene::from_toml(walls);
        let written = Simulation::new(&scene.unwrap())
            .unwrap()
            .checkpoint()
            .unwrap();
        assert!(Simulation::resume(&written).is_ok());
    }

    #[test]
    fn the_last_stop_of_a_piston_is_saved_and_must_not_be_in_the_future() {
        let scene = Scene::from_toml(
            "[[piston]]\nx = 0.3\nmass = 2.0\nvelocity = 0.5\nstops = [0.2, 0.7]\nstop_elasticity = 0.5",
        );
        let mut simulation = Simulation::new(&scene.unwrap()).unwrap();
        simulation.run_until(1.0).unwrap();
        let saved = simulation.end_epoch_here();
        let stop_of = |checkpoint: &Checkpoint| checkpoint.pistons[0].last_stop.unwrap();
        assert!((stop_of(&saved).to_f64() - 0.8).abs() < 1e-15);
        // On a clock that begins at 0 now.
        let start = saved.clone().as_start(0, 0).unwrap();
        assert!((stop_of(&start).to_f64() + 0.2).abs() < 1e-15);
        assert!(Simulation::resume(&start).is_ok());
        for (time, is_refused) in [(0.8, false), (1.0, false), (1.1, true), (f64::NAN, true)] {
            let mut checkpoint = saved.clone();
            checkpoint.pistons[0].last_stop = Some(EpochTime::from(time));
            let resumed = Simulation::resume(&checkpoint);
            assert_eq!(resumed.is_err(), is_refused, "{time}");
        }
    }

    #[test]
    fn bodies_of_one_kind_share_their_shape() {
        let checkpoint = sound();
        assert_eq!(checkpoint.molecules.len(), 1);
        let resumed = Simulation::resume(&checkpoint).unwrap();
        let shapes: Vec<_> = resumed
            .world
            .bodies
            .iter()
            .map(|body| Arc::as_ptr(&body.kind.molecule))
            .collect();
        assert!(shapes.iter().all(|shape| *shape == shapes[0]));
    }

    #[test]
    #[expect(clippy::too_many_lines, reason = "one table of refusals")]
    fn a_checkpoint_that_no_simulation_can_have_written_is_refused() {
        for (said, refused) in [
            (
                "body 1 of the checkpoint has a shape",
                refusal(|c| c.bodies[1].molecule = 7),
            ),
            (
                "body 2 of the checkpoint is out of order",
                refusal(|c| c.bodies[2].key = c.bodies[1].key),
            ),
            ("not been assigned", refusal(|c| c.next_key = BodyKey(2))),
            (
                "tag without a name",
                refusal(|c| c.bodies[0].tags.push(Tag(9))),
            ),
            (
                "not finite",
                refusal(|c| c.bodies[0].motion.velocity.x = f64::NAN),
            ),
            (
                "out of the box",
                refusal(|c| c.bodies[0].motion.position.y = 1.5),
            ),
            (
                "time is not finite",
                refusal(|c| c.epoch = EpochTime::from(f64::INFINITY)),
            ),
            (
                "ledger is not finite",
                refusal(|c| c.ledger.lost = f64::NAN),
            ),
            (
                "heat of a tag is not finite",
                refusal(|c| c.heat.give(Tag(0), f64::NAN, ThermostatCounts::default())),
            ),
            (
                "heat of a tag without a name",
                refusal(|c| c.heat.give(Tag(9), 1.0, ThermostatCounts::default())),
            ),
            (
                "last contact is not finite",
                refusal(|c| c.simultaneous.time = f64::NAN),
            ),
            (
                "a component of the velocity of body 0 of the checkpoint must be 0 or from 1e-70 to 1e60, but is 1e61",
                refusal(|c| c.bodies[0].motion.velocity.x = 1e61),
            ),
            (
                "the speed of body",
                refusal(|c| {
                    c.bodies
                        .iter_mut()
                        .for_each(|body| body.motion.velocity = DVec2::splat(1e-71));
                }),
            ),
            (
                "cannot turn but has an angular velocity",
                refusal(|c| {
                    c.bodies[1].rotation = Some(Rotation::Locked);
                    c.bodies[1].motion.angular_velocity = 1.0;
                }),
            ),
            (
                "is fixed but moves",
                refusal(|c| c.bodies[1].rotation = None),
            ),
            (
                "turned by more",
                refusal(|c| c.bodies[1].motion.orientation = Orientation::from_turns(f64::NAN)),
            ),
            (
                "largest count must be at most 2^62",
                refusal(|c| c.bodies[1].winding[0] = i64::MAX),
            ),
            (
                "largest count",
                refusal(|c| c.counters.collisions = u64::MAX),
            ),
            (
                "largest count",
                refusal(|c| c.counters.scheduler.pairs = u64::MAX),
            ),
            (
                "largest count",
                refusal(|c| {
                    c.heat.give(
                        Tag(0),
                        1.0,
                        ThermostatCounts {
                            fixed: u64::MAX,
                            ..ThermostatCounts::default()
                        },
                    );
                }),
            ),
            (
                "largest count",
                refusal(|c| c.simultaneous.counts = [(0, u32::MAX)].into()),
            ),
            ("largest count", refusal(|c| c.unresolved.count = u32::MAX)),
            (
                "last contact is not finite",
                refusal(|c| c.unresolved.since = f64::NAN),
            ),
            (
                "last contact must be at most 0, but is 2",
                refusal(|c| c.unresolved.since = 2.0),
            ),
            (
                "last contact must be at most 0, but is 1",
                refusal(|c| c.simultaneous.time = 1.0),
            ),
            (
                "the radius of the wall must be at most",
                refusal(|c| c.molecules[0] = Molecule::wall(DVec2::X, 1e6).unwrap()),
            ),
            (
                "16 times as long",
                refusal(|c| c.molecules[0] = Molecule::wall(DVec2::splat(1e6), 0.0).unwrap()),
            ),
            (
                "a wall that can move",
                refusal(|c| c.molecules[0] = Molecule::wall(DVec2::X, 0.0).unwrap()),
            ),
            (
                "does not meet its own images",
                refusal(|c| wall_bodies(c, 0.75 * DVec2::X, 0.0)),
            ),
            (
                "does not meet its own images",
                refusal(|c| wall_bodies(c, DVec2::ONE, 0.0)),
            ),
            (
                "does not meet its own images",
                refusal(|c| wall_bodies(c, DVec2::Y, 0.125)),
            ),
            (
                "does not meet its own images",
                refusal(|c| {
                    wall_bodies(c, DVec2::X, 0.0);
                    c.bounds = PeriodicBox::new(DVec2::new(1.0 + f64::EPSILON, 1.0)).unwrap();
                }),
            ),
            (
                "box is too large",
                refusal(|c| c.bounds = PeriodicBox::new(DVec2::new(1.0, 1e20)).unwrap()),
            ),
            (
                "elasticity.default",
                refusal(|c| c.elasticity.default = -1.0),
            ),
            (
                "checkpoint has 1 axes",
                refusal(|c| c.axes = vec![Some(Orientation::from_turns(f64::NAN))]),
            ),
            (
                "last contact is not finite",
                refusal(|c| c.last_contacts.push(f64::NAN)),
            ),
            (
                "3 times of last contacts",
                refusal(|c| c.last_contacts = vec![0.0; 3]),
            ),
            (
                "box is too small",
                refusal(|c| {
                    c.bounds = PeriodicBox::new(DVec2::splat(1e-3)).unwrap();
                    c.bodies
                        .iter_mut()
                        .for_each(|body| body.motion.position = DVec2::ZERO);
                }),
            ),
        ] {
            assert!(refused.contains(said), "{said}: {refused}");
        }
    }
}
