//! Builds a simulation from the description of a scene, and places its gases.

use std::ops::ControlFlow;

use carom_detection::{Detection, Exact};
use carom_response::{Impact, Response};

use crate::{
    cells::CellScheduler,
    contact::{
        elasticity_table::ElasticityTable,
        reaction_table::ReactionTable,
        separation::{refuse_unresolved, refuse_unsearched},
    },
    run::{growth::Growth, simulation::Simulation},
    scene::{
        Placement, Scene,
        drag::drag_clock,
        error::SceneError,
        gravity::{gravity_of, refuse_gravity},
        shear::{refuse_shear, shear_rate_of},
    },
    scheduler::Scheduler,
    start::{
        bonds::{refuse_bonds, refuse_stretched, tie},
        contents::SceneContents,
        pistons::{free_pistons, refuse_pistons},
        placement, start_from,
        wall_motions::{move_walls, refuse_drag},
        wells::refuse_wells,
    },
    world::World,
};

impl Simulation {
    /// Creates a simulation of the scene with the exact detector and the default scheduler.
    ///
    /// # Errors
    /// [`SceneError`], with the name of the entry, if the scene cannot be built.
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        Self::with(
            scene,
            Exact::default(),
            Impact,
            <CellScheduler as Scheduler>::Options::default(),
        )
    }
}

impl<D: Detection, R: Response, S: Scheduler> Simulation<D, R, S> {
    /// Creates a simulation of the scene with the given detector, response and options of the
    /// scheduler.
    ///
    /// Gases are placed, grown and relaxed ([`StartSpec`](crate::StartSpec)) with the exact
    /// detector, elastic impacts and the default scheduler, so that all simulations of a scene
    /// start from the same state.
    ///
    /// ```
    /// use carom_detection::Exact;
    /// use carom_engine::{CellsPerSide, Scene, Simulation, HeapScheduler};
    /// use carom_response::Impact;
    ///
    /// let mut scene = Scene::default();
    /// // No grid: all pairs are compared.
    /// let simulation: Simulation<Exact, Impact, HeapScheduler> =
    ///     Simulation::with(&scene, Exact::default(), Impact, CellsPerSide::Given(1))?;
    /// # Ok::<(), carom_engine::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// [`SceneError`], with the name of the entry, if the scene cannot be built.
    pub fn with(
        scene: &Scene,
        detection: D,
        response: R,
        options: S::Options,
    ) -> Result<Self, SceneError> {
        Self::with_progress(scene, detection, response, options, &mut |_| {
            ControlFlow::Continue(())
        })
    }

    /// Creates a simulation like [`Self::with`], and calls `progress` after each step of growth and
    /// relaxation ([`Growth::step`]), if the scene needs them. A growth that `progress` stores can
    /// be continued later, to the same result to the bit ([`Growth::finish_with`]).
    ///
    /// # Errors
    /// Those of [`Self::with`], and [`SceneError::Interrupted`] if `progress` breaks.
    pub fn with_progress(
        scene: &Scene,
        detection: D,
        response: R,
        options: S::Options,
        progress: &mut dyn FnMut(&Growth) -> ControlFlow<()>,
    ) -> Result<Self, SceneError> {
        Self::from_world(scene, fill(scene, progress)?, detection, response, options)
    }

    /// Creates a simulation of a world that holds all bodies of the scene.
    fn from_world(
        scene: &Scene,
        (mut world, contents): (World, SceneContents),
        detection: D,
        response: R,
        options: S::Options,
    ) -> Result<Self, SceneError> {
        let counts = contents.counts();
        let mut singles = contents.singles;
        let of_gases = counts.iter().sum::<usize>();
        let first = world.bodies.len() - of_gases;
        tie(&mut world, scene, &contents.species, first)?;
        move_walls(&mut world, scene)?;
        free_pistons(&mut world, scene, &singles.entries)?;
        world.gravity = gravity_of("gravity.acceleration", scene.gravity.acceleration)?;
        let mut elasticity = ElasticityTable::new(&scene.elasticity, &mut singles.names)?;
        let mut reactions = ReactionTable::default();
        reactions.set("reaction", &scene.reaction, &mut singles.names)?;
        elasticity.classify(&mut world, &response, &mut reactions)?;
        refuse_unresolved(&world, &elasticity)
            .and_then(|()| refuse_unsearched(&world, &detection))
            .map_err(|reason| reason.named(|body| singles.entry_of(body, &counts)))?;
        world.clock = drag_clock("box.drag", scene.bounds.drag)?;
        refuse_drag(&world, |body| singles.entry_of(body, &counts))?;
        refuse_gravity(&world)?;
        world.shear_rate = shear_rate_of("box.shear_rate", scene.bounds.shear_rate)?;
        refuse_shear(&world, |body| singles.entry_of(body, &counts))?;
        if world.is_sheared() {
            world.add_flow();
        }
        refuse_pistons(&world, |body| singles.entry_of(body, &counts))?;
        refuse_bonds(&world, &elasticity, |body| singles.entry_of(body, &counts))?;
        refuse_stretched(&world, |body| singles.entry_of(body, &counts))?;
        refuse_wells(&world, |body| singles.entry_of(body, &counts))?;
        world.sort_into_shells();
        world.random_key = [scene.bounds.seed, scene.bounds.replica];
        world.shrink();
        let scheduler = S::checked(&options, &world)
            .map_err(|reason| reason.named(|body| singles.entry_of(body, &counts)))?;
        Ok(Self {
            reactions,
            ..Self::assemble(
                world,
                (detection, response),
                (scheduler, options),
                elasticity,
                singles.names,
            )
        })
    }
}

impl Growth {
    /// Takes all steps that are left, and returns the simulation of the scene at time 0.
    ///
    /// # Errors
    /// Those of [`Self::step`], and of [`Simulation::new`].
    pub fn finish(self) -> Result<Simulation, SceneError> {
        let options = <CellScheduler as Scheduler>::Options::default();
        self.finish_with(Exact::default(), Impact, options)
    }

    /// Takes all steps that are left, and returns the simulation of the scene at time 0 with the
    /// given detector, response and options of the scheduler.
    ///
    /// # Errors
    /// Those of [`Self::step`], and of [`Simulation::with`].
    pub fn finish_with<D: Detection, R: Response, S: Scheduler>(
        self,
        detection: D,
        response: R,
        options: S::Options,
    ) -> Result<Simulation<D, R, S>, SceneError> {
        let scene = self.scene().clone();
        Simulation::from_world(&scene, self.into_world()?, detection, response, options)
    }
}

/// Places all bodies of a scene; returns the world and what it has been built from.
fn fill(
    scene: &Scene,
    progress: &mut dyn FnMut(&Growth) -> ControlFlow<()>,
) -> Result<(World, SceneContents), SceneError> {
    if scene.start.from.is_some() || scene.start.snapshot.is_some() {
        return start_from::fill(scene);
    }
    let mut contents = SceneContents::new(scene)?;
    let mut growth = if scene.start.placement == Some(Placement::Grown) {
        Growth::from_contents(scene, contents)?
    } else {
        let relaxes = scene.start.relax.is_some_and(|collisions| collisions > 0.0);
        let mut singles = contents.singles.clone();
        match placement::fill(
            &mut singles.world,
            &mut singles.names,
            scene,
            &contents.species,
        ) {
            Ok(()) if relaxes => {
                let first = contents.singles.world.bodies.len();
                Growth::relaxation(scene, contents, &singles.world.motions[first..])?
            }
            Ok(()) => {
                let world = std::mem::replace(
                    &mut singles.world,
                    World::new(*contents.singles.world.bounds()),
                );
                contents.singles = singles;
                return Ok((world, contents));
            }
            Err(full @ SceneError::Full { .. })
                if scene.start.placement.is_none() && !scene.start.empty_pockets =>
            {
                Growth::after_lattice(scene, contents, full)?
            }
            Err(error) => return Err(error),
        }
    };
    while !growth.is_done() {
        growth.step()?;
        if progress(&growth).is_break() {
            return Err(SceneError::Interrupted);
        }
    }
    growth.into_world()
}
