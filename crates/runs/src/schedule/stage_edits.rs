//! The edits at the starts of stages, and the actions of their thermostats.

use anyhow::{Context, Result};
use carom::{
    BodyKey, EditError, Scene, SceneError,
    engine::{Batch, DrawKey, RelabelSpec, Rotation, StageSpec, ThermostatSpec},
};
use carom_methods::AnySimulation;

use super::What;

/// Makes the edits at the start of a stage, all or none. `action` is the number of draws before;
/// returns the number of draws made.
///
/// # Errors
/// The edit that is refused, with its entry.
pub fn start(
    simulation: &mut AnySimulation,
    scene: &Scene,
    stage: usize,
    action: u64,
) -> Result<u64> {
    start_with(simulation, scene, stage, action, |result| result)
}

/// Makes the edits of all stages one after another on a copy of the system, with one action of each
/// thermostat that sets velocities, so that most of those that would be refused are refused before
/// the run. What overlaps now is left out, as are edits of single bodies that are missing for that
/// reason: there may be room when the stage starts.
///
/// # Errors
/// The edit that is refused, with its entry.
fn rehearse(simulation: &AnySimulation, scene: &Scene) -> Result<()> {
    let mut copy = simulation.clone();
    for (stage, spec) in scene.stage.iter().enumerate() {
        if stage > 0 {
            let edited = start_with(&mut copy, scene, stage, 0, |result| match result {
                Err(EditError::Scene(SceneError::Overlap { .. }) | EditError::NoSuchBody(_)) => {
                    Ok(())
                }
                other => other,
            });
            // Bodies that see each other again, and overlap now.
            if let Err(error) = edited
                && !matches!(
                    error.downcast_ref(),
                    Some(EditError::Scene(SceneError::Overlap { .. }))
                )
            {
                return Err(error);
            }
        }
        // An energy may be out of range for the present speeds and not for later ones.
        let sets_velocities = |spec: &ThermostatSpec| spec.action().is_none();
        for (index, _) in
            (spec.thermostat.iter().enumerate()).filter(|(_, one)| sets_velocities(one))
        {
            act(&mut copy, scene, (stage, index), 0)?;
        }
    }
    Ok(())
}

fn start_with(
    simulation: &mut AnySimulation,
    scene: &Scene,
    stage: usize,
    action: u64,
    forgive: impl Fn(Result<(), EditError>) -> Result<(), EditError>,
) -> Result<u64> {
    let spec = &scene.stage[stage];
    let mut entry = String::new();
    let edited = simulation.edit(|batch| {
        let mut edits = Edits {
            batch,
            scene,
            entry: &mut entry,
        };
        edits.contents(spec, &forgive)?;
        edits.rules(spec)?;
        edits.energies(spec, action)?;
        edits.velocities(spec)
    });
    edited.with_context(|| match entry.as_str() {
        "" => format!("stage[{stage}]"),
        entry => format!("stage[{stage}].{entry}"),
    })?;
    Ok(spec.set_energy.len() as u64)
}

/// Puts the rules of a scene in the place of those of a state, all or none.
///
/// # Errors
/// The rule that is refused, with its entry.
pub fn replace_rules(simulation: &mut AnySimulation, scene: &Scene) -> Result<()> {
    let spec = StageSpec {
        elasticity: Some(scene.elasticity.clone()),
        drag: Some(scene.bounds.drag),
        gravity: Some(scene.gravity.acceleration),
        shear_rate: Some(scene.bounds.shear_rate),
        transparent: Some(scene.transparent.clone()),
        well: Some(scene.well.clone()),
        reaction: Some(scene.reaction.clone()),
        ..StageSpec::default()
    };
    let mut entry = String::new();
    let replaced = simulation.edit(|batch| {
        let mut edits = Edits {
            batch,
            scene,
            entry: &mut entry,
        };
        edits.rules(&spec)?;
        // What is refused at the end concerns all rules.
        edits.entry.clear();
        Ok(())
    });
    replaced.with_context(|| match entry.as_str() {
        "" => "the rules of the scene".to_owned(),
        entry => entry.to_owned(),
    })
}

/// Makes the edits of the first stage, before the run, and rehearses those of the others. `action`
/// is the number of draws before; returns the number of draws made.
///
/// # Errors
/// The edit that is refused, with its entry.
pub fn prepare(simulation: &mut AnySimulation, scene: &Scene, action: u64) -> Result<u64> {
    if scene.stage.is_empty() {
        return Ok(0);
    }
    let draws = start(simulation, scene, 0, action)?;
    rehearse(simulation, scene)?;
    Ok(draws)
}

/// Makes the change of a step: the start of a stage or the action of a thermostat. `action` is the
/// number of draws before; returns the number of draws made.
///
/// # Errors
/// The edit that is refused, with its entry.
pub fn change(
    simulation: &mut AnySimulation,
    scene: &Scene,
    what: What,
    action: u64,
) -> Result<u64> {
    match what {
        What::Stage(stage) => start(simulation, scene, stage, action),
        What::Thermostat { stage, index } => {
            act(simulation, scene, (stage, index), action).map(|()| 1)
        }
        What::Sample | What::Snapshot | What::Check => Ok(0),
    }
}

/// One action of a thermostat. `action` is the number of draws before.
///
/// # Errors
/// The rule is refused for a body, with the entry.
fn act(
    simulation: &mut AnySimulation,
    scene: &Scene,
    (stage, index): (usize, usize),
    action: u64,
) -> Result<()> {
    let (entry, thermostat) = (
        format!("stage[{stage}].thermostat[{index}]"),
        &scene.stage[stage].thermostat[index],
    );
    let rule = thermostat.rule(&entry)?;
    simulation
        .edit(|batch| match batch.find_tag(&thermostat.tag) {
            Some(tag) => batch
                .thermostat(tag, &rule, draw_key(scene, action))
                .map(|_| ()),
            None => Ok(()),
        })
        .with_context(|| entry.clone())
}

fn draw_key(scene: &Scene, action: u64) -> DrawKey {
    DrawKey {
        seed: scene.bounds.seed,
        replica: scene.bounds.replica,
        action,
    }
}

/// The edits of a stage in progress.
struct Edits<'a> {
    batch: &'a mut Batch,
    scene: &'a Scene,
    /// The entry of the present edit, for errors.
    entry: &'a mut String,
}

impl Edits<'_> {
    /// The bodies with a tag.
    fn tagged(&self, name: &str) -> Vec<BodyKey> {
        let tag = self.batch.find_tag(name);
        tag.into_iter()
            .flat_map(|tag| self.batch.tagged(tag))
            .collect()
    }

    /// The bodies whose tags change.
    fn concerned(&self, relabel: &RelabelSpec) -> Vec<BodyKey> {
        if let Some(id) = relabel.body {
            return vec![BodyKey::of_id(id)];
        }
        let mut keys = if relabel.of.is_empty() {
            self.batch.moving().collect()
        } else {
            self.tagged(&relabel.of)
        };
        keys.truncate(relabel.count.unwrap_or(usize::MAX));
        keys
    }

    /// Bodies and their tags. `forgive` receives the result of each edit that depends on where
    /// bodies are.
    fn contents(
        &mut self,
        spec: &StageSpec,
        forgive: &impl Fn(Result<(), EditError>) -> Result<(), EditError>,
    ) -> Result<(), EditError> {
        for (index, name) in spec.remove.iter().enumerate() {
            *self.entry = format!("remove[{index}]");
            self.tagged(name)
                .into_iter()
                .try_for_each(|key| self.batch.remove(key))?;
        }
        for (index, molecule) in spec.add.iter().enumerate() {
            *self.entry = format!("add[{index}]");
            forgive(self.batch.add(molecule).map(|_| ()))?;
        }
        for (index, wall) in spec.add_wall.iter().enumerate() {
            *self.entry = format!("add_wall[{index}]");
            forgive(self.batch.add_wall(wall).map(|_| ()))?;
        }
        for (index, set) in spec.move_wall.iter().enumerate() {
            *self.entry = format!("move_wall[{index}]");
            for key in self.tagged(&set.tag) {
                forgive(self.batch.move_wall(key, &set.motion))?;
            }
        }
        for (index, set) in spec.push_piston.iter().enumerate() {
            *self.entry = format!("push_piston[{index}]");
            for key in self.tagged(&set.tag) {
                forgive(self.batch.push_piston(key, set.force))?;
            }
        }
        for (index, relabel) in spec.tag.iter().enumerate() {
            *self.entry = format!("tag[{index}]");
            for key in self.concerned(relabel) {
                forgive(self.batch.tag(key, &relabel.name).map(|_| ()))?;
            }
        }
        for (index, relabel) in spec.untag.iter().enumerate() {
            *self.entry = format!("untag[{index}]");
            for key in self.concerned(relabel) {
                forgive(self.batch.untag(key, &relabel.name))?;
            }
        }
        Ok(())
    }

    /// Elasticity, pairs that do not see each other, bonds, and rotation.
    fn rules(&mut self, spec: &StageSpec) -> Result<(), EditError> {
        if let Some(elasticity) = &spec.elasticity {
            "elasticity".clone_into(self.entry);
            self.batch.set_elasticity(elasticity)?;
        }
        if let Some(drag) = spec.drag {
            "drag".clone_into(self.entry);
            self.batch.set_drag(drag)?;
        }
        if let Some(gravity) = spec.gravity {
            "gravity".clone_into(self.entry);
            self.batch.set_gravity(gravity)?;
        }
        if let Some(rate) = spec.shear_rate {
            "shear_rate".clone_into(self.entry);
            self.batch.set_shear_rate(rate)?;
        }
        if let Some(transparent) = &spec.transparent {
            "transparent".clone_into(self.entry);
            self.batch.set_transparent(transparent)?;
        }
        if let Some(wells) = &spec.well {
            "well".clone_into(self.entry);
            self.batch.set_wells(wells)?;
        }
        if let Some(reactions) = &spec.reaction {
            "reaction".clone_into(self.entry);
            self.batch.set_reactions(reactions)?;
        }
        for (index, name) in spec.unbond.iter().enumerate() {
            *self.entry = format!("unbond[{index}]");
            if let Some(tag) = self.batch.find_tag(name) {
                self.batch.unbond_tag(tag);
            }
        }
        for (index, bond) in spec.bond.iter().enumerate() {
            *self.entry = format!("bond[{index}]");
            self.batch.bond(bond)?;
        }
        let locks = [
            (Rotation::Locked, "lock", &spec.lock),
            (Rotation::Free, "unlock", &spec.unlock),
        ];
        for (rotation, key_name, tags) in locks {
            for (index, name) in tags.iter().enumerate() {
                *self.entry = format!("{key_name}[{index}]");
                for key in self.tagged(name) {
                    self.batch.set_rotation(key, rotation)?;
                }
            }
        }
        Ok(())
    }

    fn energies(&mut self, spec: &StageSpec, action: u64) -> Result<(), EditError> {
        for (index, heat) in spec.set_energy.iter().enumerate() {
            *self.entry = format!("set_energy[{index}]");
            if let Some(tag) = self.batch.find_tag(&heat.tag) {
                let key = draw_key(self.scene, action + index as u64);
                let rule = heat.rule(self.entry)?;
                self.batch.thermostat(tag, &rule, key)?;
            }
        }
        Ok(())
    }

    fn velocities(&mut self, spec: &StageSpec) -> Result<(), EditError> {
        for (index, set) in spec.set_velocity.iter().enumerate() {
            *self.entry = format!("set_velocity[{index}]");
            let keys = set
                .body
                .map_or_else(|| self.tagged(&set.tag), |id| vec![BodyKey::of_id(id)]);
            for key in keys {
                if let Some(velocity) = set.velocity {
                    self.batch.set_velocity(key, velocity)?;
                }
                if let Some(angular_velocity) = set.angular_velocity {
                    self.batch.set_angular_velocity(key, angular_velocity)?;
                }
            }
        }
        // Errors of the batch as a whole belong to no single edit.
        self.entry.clear();
        Ok(())
    }
}
