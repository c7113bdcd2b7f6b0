//! A simulation whose detector and scheduler are chosen at run time.

use std::{fmt, ops::ControlFlow};

use carom_detection::Detection;
use carom_engine::{
    Batch, BodyKey, CellScheduler, Checkpoint, CheckpointError, EditError, ElasticitySpec, Growth,
    HeapScheduler, MoleculeSpec, Observer, Rotation, RunError, Scene, SceneError, Scheduler,
    Simulation, Tag, TileCounters, TileUse, TileWork, Tiling, View, Violation, WallSpec,
};
use carom_kinematics::EpochTime;
use carom_response::{Impact, Response};

use crate::{AnyDetector, Method, Order};

type Cells = Simulation<AnyDetector, Impact, CellScheduler>;
type Heap = Simulation<AnyDetector, Impact, HeapScheduler>;

/// A [`Simulation`] with any detector, response and scheduler.
///
/// Each method does what that of the same name of [`Simulation`] does, to the bit.
pub struct AnySimulation(Box<dyn Dynamic>);

impl fmt::Debug for AnySimulation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AnySimulation")
            .field("time", &self.time())
            .finish_non_exhaustive()
    }
}

impl<D, R, S> From<Simulation<D, R, S>> for AnySimulation
where
    D: Detection + Clone + Send + 'static,
    R: Response + Clone + Send + 'static,
    S: Scheduler<Options: Send + 'static> + Clone + Send + 'static,
{
    fn from(simulation: Simulation<D, R, S>) -> Self {
        Self(Box::new(simulation))
    }
}

impl AnySimulation {
    /// Creates a simulation of a scene with the method that it names; the default is exact.
    ///
    /// # Errors
    /// [`SceneError`], with the name of the entry, if the scene cannot be built or its method is
    /// invalid.
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        Self::with(scene, &Method::try_from(&scene.method)?)
    }

    /// Creates a simulation of a scene with a method instead of the scene's own.
    ///
    /// # Errors
    /// [`SceneError`], with the name of the entry, if the scene cannot be built or the grid of the
    /// method does not suit it.
    pub fn with(scene: &Scene, method: &Method) -> Result<Self, SceneError> {
        Self::with_progress(scene, method, &mut |_| ControlFlow::Continue(()))
    }

    /// Creates a simulation like [`Self::with`], and calls `progress` after each step of growth and
    /// relaxation of the gases, if the scene needs them.
    ///
    /// # Errors
    /// Those of [`Self::with`], and [`SceneError::Interrupted`] if `progress` breaks.
    pub fn with_progress(
        scene: &Scene,
        method: &Method,
        progress: &mut dyn FnMut(&Growth) -> ControlFlow<()>,
    ) -> Result<Self, SceneError> {
        let detector = method.detector;
        let simulation: Self = match method.order {
            Order::Cells(options) => {
                Cells::with_progress(scene, detector, Impact, options, progress)?.into()
            }
            Order::Heap(options) => {
                Heap::with_progress(scene, detector, Impact, options, progress)?.into()
            }
        };
        Ok(simulation.in_tiles(method))
    }

    /// Takes all steps of a growth that are left, and returns the simulation of its scene at time
    /// 0.
    ///
    /// # Errors
    /// Those of [`Growth::step`] and of [`Self::with`].
    pub fn grown(growth: Growth, method: &Method) -> Result<Self, SceneError> {
        let detector = method.detector;
        let simulation: Self = match method.order {
            Order::Cells(options) => growth
                .finish_with::<_, _, CellScheduler>(detector, Impact, options)?
                .into(),
            Order::Heap(options) => growth
                .finish_with::<_, _, HeapScheduler>(detector, Impact, options)?
                .into(),
        };
        Ok(simulation.in_tiles(method))
    }

    /// Resumes from a checkpoint. Only the method of the run that wrote it gives the bits of an
    /// uninterrupted run.
    ///
    /// # Errors
    /// [`CheckpointError`] if no simulation can have written it, or if the grid of the method does
    /// not suit its bodies.
    pub fn resume(checkpoint: &Checkpoint, method: &Method) -> Result<Self, CheckpointError> {
        let detector = method.detector;
        let simulation: Self = match method.order {
            Order::Cells(options) => {
                Cells::resume_with(checkpoint, detector, Impact, options)?.into()
            }
            Order::Heap(options) => {
                Heap::resume_with(checkpoint, detector, Impact, options)?.into()
            }
        };
        Ok(simulation.in_tiles(method))
    }

    /// The simulation with the tiles of a method, on one thread.
    fn in_tiles(mut self, method: &Method) -> Self {
        self.set_tiling(&method.tiling(1));
        self
    }

    /// Makes several changes at one time, or none. See [`Simulation::edit`].
    ///
    /// # Errors
    /// The error of the closure, and those of [`Simulation::edit`].
    ///
    /// # Panics
    /// Never: an accepted batch has called its closure.
    pub fn edit<T>(
        &mut self,
        edits: impl FnOnce(&mut Batch) -> Result<T, EditError>,
    ) -> Result<T, EditError> {
        let (mut edits, mut result) = (Some(edits), None);
        self.0.edit_by(&mut |batch| {
            if let Some(edits) = edits.take() {
                result = Some(edits(batch)?);
            }
            Ok(())
        })?;
        Ok(result.expect("a batch that is accepted has called its closure"))
    }
}

/// Defines the methods of [`AnySimulation`] that call those of the same name of [`Simulation`], and
/// the trait behind them.
macro_rules! dynamic {
    ($(
        $(#[$attribute:meta])*
        fn $name:ident([$($borrow:tt)+] $this:ident $(, $argument:ident: $type:ty)*) $(-> $result:ty)?;
    )*) => {
        /// The methods of a simulation that do not depend on its detector, response and scheduler.
        trait Dynamic: Send {
            fn boxed(&self) -> Box<dyn Dynamic>;
            fn edit_by(
                &mut self,
                edits: &mut dyn FnMut(&mut Batch) -> Result<(), EditError>,
            ) -> Result<(), EditError>;
            $(fn $name($($borrow)+ $this $(, $argument: $type)*) $(-> $result)?;)*
        }

        impl<D, R, S> Dynamic for Simulation<D, R, S>
        where
            D: Detection + Clone + Send + 'static,
            R: Response + Clone + Send + 'static,
            S: Scheduler<Options: Send + 'static> + Clone + Send + 'static,
        {
            fn boxed(&self) -> Box<dyn Dynamic> {
                Box::new(self.clone())
            }

            fn edit_by(
                &mut self,
                edits: &mut dyn FnMut(&mut Batch) -> Result<(), EditError>,
            ) -> Result<(), EditError> {
                self.edit(edits)
            }

            $(fn $name($($borrow)+ $this $(, $argument: $type)*) $(-> $result)? {
                Self::$name($this $(, $argument)*)
            })*
        }

        impl AnySimulation {
            $($(#[$attribute])* pub fn $name($($borrow)+ $this $(, $argument: $type)*) $(-> $result)? {
                $this.0.$name($($argument),*)
            })*
        }
    };
}

dynamic! {
    /// The present time.
    fn time([&] self) -> EpochTime;
    /// Memory used by the bodies and their events (bytes). See [`Simulation::heap_bytes`].
    fn heap_bytes([&] self) -> usize;
    /// A view of all bodies at the present time.
    fn view([&] self) -> View<'_>;
    /// The state, if an epoch has ended and the next has not begun. See [`Simulation::checkpoint`].
    fn checkpoint([&] self) -> Option<Checkpoint>;
    /// Ends the epoch at the present time and returns the state. See
    /// [`Simulation::end_epoch_here`].
    fn end_epoch_here([&mut] self) -> Checkpoint;
    /// The tag of this name, if a body or rule has ever carried it.
    fn find_tag([&] self, name: &str) -> Option<Tag>;
    /// Checks all invariants by brute force. See [`Simulation::check_invariants`].
    ///
    /// # Errors
    /// The first [`Violation`] found.
    fn check_invariants([&] self, horizon: f64) -> Result<(), Violation>;
    /// Runs to `time`. See [`Simulation::run_until`].
    ///
    /// # Errors
    /// Those of [`Simulation::run_until`].
    fn run_until([&mut] self, time: f64) -> Result<(), RunError>;
    /// Runs to `time` and reports each collision. See [`Simulation::observe_until`].
    ///
    /// # Errors
    /// Those of [`Simulation::run_until`].
    fn observe_until([&mut] self, time: f64, observer: &mut dyn Observer) -> Result<(), RunError>;
    /// Runs to `until`, without the rounding of a single `f64`. See
    /// [`Simulation::observe_until_epoch_time`].
    ///
    /// # Errors
    /// Those of [`Simulation::run_until`].
    fn observe_until_epoch_time(
        [&mut] self,
        until: EpochTime,
        observer: &mut dyn Observer
    ) -> Result<(), RunError>;
    /// Returns the end of a run at `time`. See [`Simulation::end_of_run`].
    ///
    /// # Errors
    /// Those of [`Simulation::end_of_run`].
    fn end_of_run([&] self, time: f64) -> Result<EpochTime, RunError>;
    /// Runs to `until`, but not past the end of the present epoch; returns whether `until` has been
    /// reached. See [`Simulation::observe_epoch`].
    ///
    /// # Errors
    /// Those of [`Simulation::run_until`].
    fn observe_epoch([&mut] self, until: EpochTime, observer: &mut dyn Observer) -> Result<bool, RunError>;
    /// Runs through at most `most` contacts, but not past `until` or the end of the present epoch;
    /// returns the number of contacts. See [`Simulation::observe_contacts`].
    ///
    /// # Errors
    /// Those of [`Simulation::run_until`].
    fn observe_contacts(
        [&mut] self,
        until: EpochTime,
        most: u64,
        observer: &mut dyn Observer
    ) -> Result<u64, RunError>;
    /// Runs through the next contact, if it happens no later than `time`, else to `time`; returns
    /// whether there was a contact. See [`Simulation::step`].
    ///
    /// # Errors
    /// Those of [`Simulation::run_until`].
    fn step([&mut] self, time: f64, observer: &mut dyn Observer) -> Result<bool, RunError>;
    /// Runs to `until` with a sample every `interval`. See [`Simulation::sample_every`].
    ///
    /// # Errors
    /// Those of [`Simulation::sample_every`].
    fn sample_every([&mut] self, interval: f64, until: f64, observer: &mut dyn Observer) -> Result<(), RunError>;
    /// Scales the kinetic energy of a body. See [`Simulation::reset_energy`].
    ///
    /// # Errors
    /// Those of [`Simulation::reset_energy`].
    fn reset_energy([&mut] self, key: BodyKey, energy: f64) -> Result<(), EditError>;
    /// Scales the kinetic energy of each body with this tag. See
    /// [`Simulation::reset_energy_of_tag`].
    ///
    /// # Errors
    /// Those of [`Simulation::reset_energy_of_tag`].
    fn reset_energy_of_tag([&mut] self, tag: Tag, energy: f64) -> Result<(), EditError>;
    /// Scales the kinetic energy of each moving body. See [`Simulation::reset_energy_of_all`].
    ///
    /// # Errors
    /// Those of [`Simulation::reset_energy_of_all`].
    fn reset_energy_of_all([&mut] self, energy: f64) -> Result<(), EditError>;
    /// Reverses all velocities and angular velocities.
    fn reverse([&mut] self);
    /// Locks the present orientation of a body, or frees it. See [`Simulation::set_rotation`].
    ///
    /// # Errors
    /// Those of [`Simulation::set_rotation`].
    fn set_rotation([&mut] self, key: BodyKey, rotation: Rotation) -> Result<(), EditError>;
    /// Changes the length of epochs. See [`Simulation::set_contacts_per_epoch`].
    fn set_contacts_per_epoch([&mut] self, contacts: u64);
    /// Changes how the box is divided into tiles and threads. See [`Simulation::set_tiling`].
    fn set_tiling([&mut] self, tiling: &Tiling);
    /// Whether the system is divided into tiles. See [`Simulation::tile_use`].
    fn tile_use([&] self) -> TileUse;
    /// The length of a window (time); 0 without tiles. See [`Simulation::window_length`].
    fn window_length([&] self) -> f64;
    /// The work of each tile in the last window. See [`Simulation::tile_work`].
    fn tile_work([&] self) -> Vec<TileWork>;
    /// Counts of the work in tiles. See [`Simulation::tile_counters`].
    fn tile_counters([&] self) -> TileCounters;
    /// Adds a molecule. See [`Simulation::add`].
    ///
    /// # Errors
    /// Those of [`Simulation::add`].
    fn add([&mut] self, spec: &MoleculeSpec) -> Result<BodyKey, EditError>;
    /// Adds a wall. See [`Simulation::add_wall`].
    ///
    /// # Errors
    /// Those of [`Simulation::add_wall`].
    fn add_wall([&mut] self, spec: &WallSpec) -> Result<BodyKey, EditError>;
    /// Removes a body. See [`Simulation::remove`].
    ///
    /// # Errors
    /// Those of [`Simulation::remove`].
    fn remove([&mut] self, key: BodyKey) -> Result<(), EditError>;
    /// Adds a tag to a body. See [`Simulation::tag`].
    ///
    /// # Errors
    /// Those of [`Simulation::tag`].
    fn tag([&mut] self, key: BodyKey, name: &str) -> Result<Tag, EditError>;
    /// Removes a tag from a body. See [`Simulation::untag`].
    ///
    /// # Errors
    /// Those of [`Simulation::untag`].
    fn untag([&mut] self, key: BodyKey, name: &str) -> Result<(), EditError>;
    /// Changes the elasticity of all later contacts. See [`Simulation::set_elasticity`].
    ///
    /// # Errors
    /// Those of [`Simulation::set_elasticity`].
    fn set_elasticity([&mut] self, spec: &ElasticitySpec) -> Result<(), EditError>;
    /// Changes the drag of all bodies from now on (1/time). See [`Simulation::set_drag`].
    ///
    /// # Errors
    /// Those of [`Simulation::set_drag`].
    fn set_drag([&mut] self, drag: f64) -> Result<(), EditError>;
    /// Changes the gravity from now on (length per time squared). See [`Simulation::set_gravity`].
    ///
    /// # Errors
    /// Those of [`Simulation::set_gravity`].
    fn set_gravity([&mut] self, gravity: [f64; 2]) -> Result<(), EditError>;
    /// Changes the shear rate from now on (1/time). See [`Simulation::set_shear_rate`].
    ///
    /// # Errors
    /// Those of [`Simulation::set_shear_rate`].
    fn set_shear_rate([&mut] self, rate: f64) -> Result<(), EditError>;
}

impl Clone for AnySimulation {
    fn clone(&self) -> Self {
        Self(self.0.boxed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAS: &str = "[[molecule]]\ntags = [\"tee\"]\nshape = \"tee\"\natom_radius = 0.02\natom_mass = 1.0\n\
                       at = [0.5, 0.5]\n[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 60";

    fn methods() -> Vec<Method> {
        [
            "",
            "instructions = \"portable\"",
            "scheduler = \"heap\"",
            "detector = \"golden-secant\"",
            "detector = \"golden-secant\"\nscheduler = \"heap\"",
            "detector = \"bounding-circles\"",
            "detector = \"fixed-step\"\nstep = 0.1",
        ]
        .map(|text| {
            Method::try_from(&toml::from_str::<carom_engine::MethodSpec>(text).unwrap()).unwrap()
        })
        .to_vec()
    }

    fn bits(simulation: &AnySimulation) -> Vec<u64> {
        let view = simulation.view();
        let motions = view.bodies().flat_map(|body| {
            let motion = body.motion;
            [
                motion.position.x,
                motion.position.y,
                motion.velocity.x,
                motion.orientation.turns(),
            ]
        });
        motions.map(f64::to_bits).collect()
    }

    #[test]
    fn the_default_method_gives_the_bits_of_the_static_simulation() {
        let scene = Scene::from_toml(GAS).unwrap();
        let mut any = AnySimulation::new(&scene).unwrap();
        let mut fixed = Simulation::new(&scene).unwrap();
        any.run_until(2.0).unwrap();
        fixed.run_until(2.0).unwrap();
        assert!(any.view().counters().collisions > 100);
        assert_eq!(any.view().counters(), fixed.view().counters());
        assert_eq!(bits(&any), bits(&AnySimulation::from(fixed)));
    }

    #[test]
    fn each_method_resumes_to_the_bit() {
        let scene = Scene::from_toml(GAS).unwrap();
        for method in methods() {
            let mut through = AnySimulation::with(&scene, &method).unwrap();
            while through.checkpoint().is_none() || through.time().to_f64() == 0.0 {
                assert!(
                    !through
                        .observe_epoch(EpochTime::from(1e3), &mut ())
                        .unwrap()
                );
            }
            let mut resumed =
                AnySimulation::resume(&through.checkpoint().unwrap(), &method).unwrap();
            let mut copy = through.clone();
            let until = through.time().to_f64() + 0.5;
            for simulation in [&mut through, &mut resumed, &mut copy] {
                simulation.run_until(until).unwrap();
            }
            assert_eq!(bits(&through), bits(&resumed), "{method}");
            assert_eq!(bits(&through), bits(&copy), "{method}");
        }
    }

    #[test]
    fn edits_reach_the_simulation_and_refused_ones_change_nothing() {
        let scene = Scene::from_toml(GAS).unwrap();
        for method in methods() {
            let mut simulation = AnySimulation::with(&scene, &method).unwrap();
            let tee = simulation
                .view()
                .tagged(simulation.find_tag("tee").unwrap())
                .next()
                .unwrap()
                .body
                .key();
            simulation.set_rotation(tee, Rotation::Locked).unwrap();
            simulation.reset_energy_of_all(2.0).unwrap_err();
            let before = bits(&simulation);
            simulation
                .edit(|batch| {
                    batch.remove(tee)?;
                    batch.remove(tee)
                })
                .unwrap_err();
            assert_eq!(bits(&simulation), before);
            assert_eq!(
                simulation.edit(|batch| {
                    batch.remove(tee)?;
                    Ok(7)
                }),
                Ok(7)
            );
            assert_eq!(simulation.view().len(), 60);
            simulation.reset_energy_of_all(2.0).unwrap();
            assert!((simulation.view().energy() - 120.0).abs() < 1e-10);
        }
    }
}
