//! Edits at rest: in bulk, all or none.

use carom::{
    BodyKey, EditError, Scene, SceneError,
    engine::{
        BondSpec, DrawKey, ElasticitySpec, MoleculeSpec, ReactionSpec, Rotation, StageSpec,
        ThermostatSpec, TransparentSpec, WallSpec, WellSpec,
    },
};
use carom_methods::AnySimulation;
use pyo3::prelude::*;

use crate::errors;

/// One kind of change of existing bodies.
#[derive(Debug, Clone, Copy)]
pub enum Change<'a> {
    /// Removes the body.
    Remove,
    /// Locks its orientation.
    Lock,
    /// Frees its orientation.
    Unlock,
    /// Adds this tag.
    Tag(&'a str),
    /// Removes this tag.
    Untag(&'a str),
}

/// Changes bodies by their numbers.
///
/// # Errors
/// The first body that is refused.
pub fn change(
    simulation: &mut AnySimulation,
    ids: &[u64],
    change: Change<'_>,
) -> Result<(), EditError> {
    simulation.edit(|batch| {
        for key in ids.iter().map(|&id| BodyKey::of_id(id)) {
            match change {
                Change::Remove => batch.remove(key)?,
                Change::Lock => batch.set_rotation(key, Rotation::Locked)?,
                Change::Unlock => batch.set_rotation(key, Rotation::Free)?,
                Change::Tag(name) => batch.tag(key, name).map(|_| ())?,
                Change::Untag(name) => batch.untag(key, name)?,
            }
        }
        Ok(())
    })
}

/// Sets the energies of bodies by their numbers.
///
/// # Errors
/// The first body that is refused.
pub fn set_energies(
    simulation: &mut AnySimulation,
    ids: &[u64],
    energies: &[f64],
) -> Result<(), EditError> {
    simulation.edit(|batch| {
        let mut pairs = ids.iter().zip(energies);
        pairs.try_for_each(|(&id, &energy)| batch.reset_energy(BodyKey::of_id(id), energy))
    })
}

/// Sets the velocities of bodies by their numbers; `velocities` holds x and y of each.
///
/// # Errors
/// The first body that is refused.
pub fn set_velocities(
    simulation: &mut AnySimulation,
    ids: &[u64],
    velocities: &[f64],
) -> Result<(), EditError> {
    simulation.edit(|batch| {
        let mut pairs = ids.iter().zip(velocities.chunks_exact(2));
        pairs.try_for_each(|(&id, row)| batch.set_velocity(BodyKey::of_id(id), [row[0], row[1]]))
    })
}

/// Sets the angular velocities of bodies by their numbers.
///
/// # Errors
/// The first body that is refused.
pub fn set_angular_velocities(
    simulation: &mut AnySimulation,
    ids: &[u64],
    angular_velocities: &[f64],
) -> Result<(), EditError> {
    simulation.edit(|batch| {
        let mut pairs = ids.iter().zip(angular_velocities);
        pairs.try_for_each(|(&id, &spin)| batch.set_angular_velocity(BodyKey::of_id(id), spin))
    })
}

/// The molecule that the text of a scene describes.
fn template(text: &str) -> Result<MoleculeSpec, SceneError> {
    Ok(Scene::from_toml(text)?.molecule.pop().unwrap_or_default())
}

/// The wall that the text of a scene describes.
fn wall(text: &str) -> Result<WallSpec, SceneError> {
    Ok(Scene::from_toml(text)?.wall.pop().unwrap_or_default())
}

/// Adds copies of a molecule. A row of `motions` has place, angle, velocity and angular velocity.
///
/// # Errors
/// The first copy that is refused.
pub fn add(
    simulation: &mut AnySimulation,
    text: &str,
    motions: &[f64],
) -> Result<Vec<u64>, EditError> {
    let template = template(text)?;
    simulation.edit(|batch| {
        let rows = motions.chunks_exact(6);
        let spec = |row: &[f64]| MoleculeSpec {
            at: [row[0], row[1]],
            orientation: Some(row[2]),
            velocity: [row[3], row[4]],
            angular_velocity: row[5],
            ..template.clone()
        };
        rows.map(|row| batch.add(&spec(row)).and_then(id_of))
            .collect()
    })
}

/// Adds a wall.
///
/// # Errors
/// It is refused.
pub fn add_wall(simulation: &mut AnySimulation, text: &str) -> Result<u64, EditError> {
    let wall = wall(text)?;
    simulation
        .edit(|batch| batch.add_wall(&wall))
        .and_then(id_of)
}

/// Gives walls the motion of the wall that the text of a scene describes.
///
/// # Errors
/// It is refused.
pub fn move_walls(
    simulation: &mut AnySimulation,
    ids: &[u64],
    text: &str,
) -> Result<(), EditError> {
    let motion = wall(text)?.motion.unwrap_or_default();
    simulation.edit(|batch| {
        let mut keys = ids.iter().map(|&id| BodyKey::of_id(id));
        keys.try_for_each(|key| batch.move_wall(key, &motion))
    })
}

/// Gives pistons a force.
///
/// # Errors
/// It is refused.
pub fn push_pistons(
    simulation: &mut AnySimulation,
    ids: &[u64],
    force: f64,
) -> Result<(), EditError> {
    simulation.edit(|batch| {
        let mut keys = ids.iter().map(|&id| BodyKey::of_id(id));
        keys.try_for_each(|key| batch.push_piston(key, force))
    })
}

fn id_of(key: BodyKey) -> Result<u64, EditError> {
    Ok(key.id())
}

/// The elasticity that the text of a scene describes.
///
/// # Errors
/// It is refused.
pub fn elasticity(text: &str) -> Result<ElasticitySpec, EditError> {
    Ok(Scene::from_toml(text)?.elasticity)
}

/// The reactions that the text of a scene describes.
///
/// # Errors
/// The text is not that of a scene.
pub fn reactions(text: &str) -> Result<Vec<ReactionSpec>, EditError> {
    Ok(Scene::from_toml(text)?.reaction)
}

/// The bonds that the text of a scene describes.
///
/// # Errors
/// The text is not that of a scene.
pub fn bonds(text: &str) -> Result<Vec<BondSpec>, EditError> {
    Ok(Scene::from_toml(text)?.bond)
}

/// The wells that the text of a scene describes.
///
/// # Errors
/// The text is not that of a scene.
pub fn wells(text: &str) -> Result<Vec<WellSpec>, EditError> {
    Ok(Scene::from_toml(text)?.well)
}

/// The pairs of bodies that do not see each other, which the text of a scene describes.
///
/// # Errors
/// The text is not that of a scene.
pub fn transparent(text: &str) -> Result<Vec<TransparentSpec>, EditError> {
    Ok(Scene::from_toml(text)?.transparent)
}

/// The first thermostat of the text of a scene.
///
/// # Errors
/// The text is not that of a scene, or has no thermostat.
fn thermostat(text: &str) -> Result<ThermostatSpec, SceneError> {
    let stages: Vec<StageSpec> = Scene::from_toml(text)?.stage;
    let mut specs = stages.into_iter().flat_map(|stage| stage.thermostat);
    specs.next().ok_or_else(|| SceneError::Entry {
        entry: "thermostat".to_owned(),
        problem: "a thermostat is missing".to_owned(),
    })
}

/// Lets the thermostat that the text of a scene describes act once.
///
/// The key of its random numbers is the number of bodies on which thermostats have acted before.
/// Checkpoints hold it, so that a loaded simulation draws as that which was saved.
///
/// # Errors
/// The rule is refused, or a body of the tag.
pub fn act(simulation: &mut AnySimulation, scene: &Scene, text: &str) -> Result<(), EditError> {
    let spec = thermostat(text)?;
    let rule = spec.rule("thermostat")?;
    let heats = simulation.view().heat().all();
    let acted = heats.iter().map(|heat| {
        let counts = heat.counts;
        counts.changed + counts.at_rest + counts.fixed
    });
    let key = DrawKey {
        seed: scene.bounds.seed,
        replica: scene.bounds.replica,
        action: acted.sum(),
    };
    simulation.edit(|batch| match batch.find_tag(&spec.tag) {
        Some(tag) => batch.thermostat(tag, &rule, key).map(|_| ()),
        None => Ok(()),
    })
}

/// The numbers of the bodies with a tag.
///
/// # Errors
/// No body carries the tag.
pub fn ids_of(simulation: &AnySimulation, name: &str) -> PyResult<Vec<u64>> {
    let view = simulation.view();
    let tag = view.tag_names().find(name);
    let ids: Vec<u64> = tag
        .into_iter()
        .flat_map(|tag| view.tagged(tag))
        .map(|body| body.body.id())
        .collect();
    if ids.is_empty() {
        return Err(errors::EditError::new_err(format!(
            "no body carries the tag {name:?}"
        )));
    }
    Ok(ids)
}
