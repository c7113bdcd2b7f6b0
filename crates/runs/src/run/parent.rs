//! `carom run SCENE --from DIR`: the state of another run as the start of a run under new rules.
//!
//! The start state is copied into the folder of the new run, so that it can be resumed without the
//! folder of the other one. The contents of the box are those of the other run; its clock, counts
//! and ledger begin anew.

use std::{fs, io, path::Path};

use anyhow::{Context, Result, bail, ensure};
use carom::{Checkpoint, Scene};
use carom_methods::{AnySimulation, Method};
use serde::{Deserialize, Serialize};

use crate::{
    checkpoint_file::{self, CheckpointBody, FileError},
    output::Folder,
    resumable,
    schedule::stage_edits,
};

/// File of the start state in the folder of the new run.
const START_STATE: &str = "start-state";

/// The tables of a scene that describe the contents of the box, beside its sides, and whether two
/// scenes have the same.
const CONTENTS: [(&str, IsSame); 9] = [
    ("molecule", |a, b| a.molecule == b.molecule),
    ("bumper", |a, b| a.bumper == b.bumper),
    ("wall", |a, b| a.wall == b.wall),
    ("piston", |a, b| a.piston == b.piston),
    ("container", |a, b| a.container == b.container),
    ("gas", |a, b| a.gas == b.gas),
    ("bond", |a, b| a.bond == b.bond),
    ("diameter", |a, b| a.diameter == b.diameter),
    ("start", |a, b| a.start == b.start),
];

type IsSame = fn(&Scene, &Scene) -> bool;

/// A state of another run, with what identifies it.
#[derive(Debug, Serialize, Deserialize)]
pub struct Parent {
    /// What is written to the manifest.
    pub origin: Origin,
    /// The scene of the other run, as text.
    scene: String,
    /// Number of draws of random numbers by its thermostats: those of the new run continue after
    /// them.
    pub actions: u64,
    state: Checkpoint,
}

/// The origin of the start state of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Folder of the other run.
    pub folder: String,
    /// CRC-32 of its scene, as text with all options and without the end of the run.
    pub scene_crc32: String,
    /// CRC-32 of the state.
    pub state_crc32: String,
    /// Time of the state in the other run.
    pub time: f64,
    /// Whether this is the end of the other run, or the last checkpoint of one that has not ended.
    pub is_end: bool,
}

impl Origin {
    /// A sentence for the report.
    pub fn sentence(&self) -> String {
        let Self {
            folder,
            time,
            is_end,
            ..
        } = self;
        let what = if *is_end {
            "the end"
        } else {
            "the last checkpoint"
        };
        format!("Starts from {what} of the run in {folder}, at its time {time}.")
    }
}

impl Parent {
    /// The state from which a run in `folder` starts, if it starts from another run: that stored in
    /// the folder if the run is resumed, or else that in `from`.
    ///
    /// # Errors
    /// A file cannot be read, holds no run of a scene, or names another run than `from`.
    pub fn find(from: Option<&Path>, folder: &Path, resume: bool) -> Result<Option<Self>> {
        let stored = if resume { Self::stored(folder)? } else { None };
        match (stored, from) {
            (Some(stored), Some(from)) if stored.origin.folder != from.display().to_string() => {
                bail!(
                    "the run in {} starts from {}, not from {}",
                    folder.display(),
                    stored.origin.folder,
                    from.display()
                )
            }
            (Some(stored), _) => Ok(Some(stored)),
            (None, Some(from)) => {
                ensure!(
                    from != folder,
                    "a run cannot start from its own folder {}",
                    from.display()
                );
                let read = Self::read(from);
                read.with_context(|| format!("cannot start from the run in {}", from.display()))
                    .map(Some)
            }
            (None, None) => Ok(None),
        }
    }

    fn stored(folder: &Path) -> Result<Option<Self>> {
        let path = folder.join(START_STATE);
        match CheckpointBody::read(&path).and_then(|mut body| body.take()) {
            Ok(stored) => Ok(Some(stored)),
            Err(FileError::Unreadable(error)) if error.kind() == io::ErrorKind::NotFound => {
                Ok(None)
            }
            Err(error) => Err(error).with_context(|| format!("cannot read {}", path.display())),
        }
    }

    /// The last state of the run in a folder.
    fn read(folder: &Path) -> Result<Self> {
        let last = resumable::last_state(&folder.join(resumable::CHECKPOINT))?;
        let Some(scene) = last.what.strip_prefix("run\n") else {
            bail!("it is a run of an experiment, not of a scene");
        };
        let crc32 = |bytes: &[u8]| format!("{:08x}", crc32fast::hash(bytes));
        let origin = Origin {
            folder: folder.display().to_string(),
            scene_crc32: crc32(scene.as_bytes()),
            state_crc32: crc32(&checkpoint_file::encode(&last.state)?),
            time: last.state.time().to_f64(),
            is_end: last.is_end,
        };
        Ok(Self {
            origin,
            scene: scene.to_owned(),
            actions: last.actions,
            state: last.state,
        })
    }

    /// Stores the start state of a run in its folder, or removes that of an earlier run.
    ///
    /// # Errors
    /// The file cannot be written or removed.
    pub fn store(parent: Option<&Self>, folder: &Folder) -> Result<()> {
        if let Some(parent) = parent {
            return checkpoint_file::write(
                &folder.file(START_STATE)?,
                &[&checkpoint_file::encode(parent)?],
            );
        }
        let path = folder.path().join(START_STATE);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(error).with_context(|| format!("cannot remove {}", path.display()))
            }
            _ => Ok(()),
        }
    }

    /// Gives a scene the contents of the box that it leaves out. An empty list counts as left out:
    /// the text of a scene has one where there are no entries.
    ///
    /// # Errors
    /// The stored scene cannot be read.
    pub fn complete(&self, scene: &mut toml::Table) -> Result<()> {
        let own: toml::Table = self.scene.parse().context("the scene of the other run")?;
        let is_empty = |value: &toml::Value| value.as_array().is_some_and(Vec::is_empty);
        for (key, _) in CONTENTS {
            if let Some(value) = own.get(key).filter(|_| scene.get(key).is_none_or(is_empty)) {
                scene.insert(key.to_owned(), value.clone());
            }
        }
        let bounds = scene
            .entry("box")
            .or_insert_with(|| toml::Value::Table(toml::Table::new()));
        if let (toml::Value::Table(bounds), Some(toml::Value::Table(own))) =
            (bounds, own.get("box"))
        {
            for (key, value) in own {
                bounds.entry(key).or_insert_with(|| value.clone());
            }
        }
        Ok(())
    }

    /// Refuses a scene with other contents of the box.
    ///
    /// # Errors
    /// The first entry that differs.
    pub fn refuse_other_contents(&self, scene: &Scene) -> Result<()> {
        let own = Scene::from_toml(&self.scene).context("the scene of the other run")?;
        let sides: (&str, IsSame) = ("box.sides", |a, b| a.bounds.sides == b.bounds.sides);
        let differs = |(_, is_same): &(&str, IsSame)| !is_same(&own, scene);
        match std::iter::once(sides).chain(CONTENTS).find(differs) {
            None => Ok(()),
            Some((entry, _)) => bail!(
                "`{entry}` differs from that of the run in {}, from which the contents of the box come: leave it out",
                self.origin.folder
            ),
        }
    }

    /// The simulation at the start, with the rules of the new scene.
    ///
    /// # Errors
    /// The state does not fit the method, or the rule that it refuses.
    pub fn start(&self, scene: &Scene, method: &Method) -> Result<AnySimulation> {
        let mut simulation = AnySimulation::resume(
            &self
                .state
                .clone()
                .as_start(scene.bounds.seed, scene.bounds.replica)?,
            method,
        )?;
        stage_edits::replace_rules(&mut simulation, scene)?;
        Ok(simulation)
    }

    /// The line that identifies the start state in the description of a run.
    pub fn line(&self) -> String {
        let Origin {
            scene_crc32,
            state_crc32,
            ..
        } = &self.origin;
        format!("# starts from scene {scene_crc32}, state {state_crc32}\n")
    }
}
