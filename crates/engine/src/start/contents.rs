//! The contents of a scene before its gases are placed: the single bodies at their places, and the
//! kinds of molecules of the gases.

use carom_geometry::PeriodicBox;
use glam::DVec2;

use crate::{
    grid::Grid,
    scene::{Placement, Scene, StageSpec, drag::drag_clock, error::SceneError},
    start::{
        body_builder::geometry,
        fixed_gas,
        single_bodies::Singles,
        species::{Species, sample, species},
    },
    world::pair_table::PairTable,
};

/// Largest number of collisions a molecule in a relaxation: more are most likely an error.
const MAX_RELAXATION: f64 = 1e9;

/// Reads the rules for pairs of tags of a scene, and gives the gases the tags that they need.
fn set_pairs(
    scene: &Scene,
    singles: &mut Singles,
    species: &mut [Species],
) -> Result<(), SceneError> {
    let reacts = |stage: &StageSpec| stage.reaction.is_some();
    if !scene.reaction.is_empty() || scene.stage.iter().any(reacts) {
        scene.refuse_unknown_pairs()?;
    }
    let changes = |stage: &StageSpec| stage.transparent.is_some() || stage.well.is_some();
    let has_rules =
        !(scene.transparent.is_empty() && scene.diameter.is_empty() && scene.well.is_empty());
    if !has_rules && !scene.stage.iter().any(changes) {
        return Ok(());
    }
    scene.refuse_unknown_pairs()?;
    for gas in species {
        gas.pair_tags = singles.names.intern_all(&gas.spec.tags);
    }
    singles.world.pairs = PairTable::new(
        &scene.transparent,
        &scene.diameter,
        &scene.well,
        &mut singles.names,
    )?;
    Ok(())
}

/// Single bodies and kinds of molecules, each checked.
#[derive(Debug, Clone)]
pub(crate) struct SceneContents {
    pub singles: Singles,
    pub species: Vec<Species>,
}

impl SceneContents {
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        let bounds = PeriodicBox::new(DVec2::from(scene.bounds.sides)).map_err(geometry("box"))?;
        drag_clock("box.drag", scene.bounds.drag)?;
        let mut singles = Singles::new(scene, bounds)?;
        let mut species = species(scene, &bounds)?;
        set_pairs(scene, &mut singles, &mut species)?;
        for (index, gas) in species.iter_mut().enumerate() {
            if gas.spec.fixed {
                fixed_gas::place(&mut singles, gas, &scene.bounds, index)?;
                *gas = gas.clone().emptied();
            }
        }
        // Refused before placement: in such a box the number of lattice sites may be unbounded.
        let (sample, counts) = sample(&singles.world, &species);
        Grid::refuse_large_box(&sample)
            .map_err(|reason| reason.named(|body| singles.entry_of(body, &counts)))?;
        singles.refuse_overlaps()?;
        if let Some(relax) = scene.start.relax
            && !(0.0..=MAX_RELAXATION).contains(&relax)
        {
            let problem = format!(
                "`relax` must be from 0 to {MAX_RELAXATION:e} collisions a molecule, but is {relax:?}"
            );
            return Err(SceneError::Entry {
                entry: "start".to_owned(),
                problem,
            });
        }
        if scene.start.empty_pockets && scene.start.placement == Some(Placement::Grown) {
            let problem =
                "`empty_pockets` excludes `placement` grown: small molecules enter any pocket"
                    .to_owned();
            return Err(SceneError::Entry {
                entry: "start".to_owned(),
                problem,
            });
        }
        Ok(Self { singles, species })
    }

    /// The number of molecules of each gas.
    pub fn counts(&self) -> Vec<usize> {
        self.species.iter().map(|kind| kind.count).collect()
    }
}
