//! `carom run`: runs any scene and writes what its `[run]` requests.

mod impulses;
pub(crate) mod outcome;
mod placement;
mod scene_file;

use std::{fs::File, path::PathBuf};

use anyhow::{Context, Result};
use carom::{Scene, engine::Growth};
use carom_methods::Method;
use carom_tables::{Summary, Verdict};
use clap::Args;
use outcome::simulate;
use placement::Placement;
#[cfg(test)]
pub(crate) use scene_file::check;
pub use scene_file::{EXTENDED_XYZ, START, SceneFile};

use crate::{
    interruption::Signals,
    manifest::{Manifest, program},
    output::{Existing, Folder},
    resumable::{Choices, Task, without_end},
    sampling_times::sampling_times,
};

/// Options of `carom run`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// The scene file and changes to it
    #[command(flatten)]
    pub file: SceneFile,
    /// Output folder and checkpoints
    #[command(flatten)]
    pub choices: Choices,
}

/// Runs a scene and writes its folder.
///
/// # Errors
/// The scene is invalid, the folder is not empty, or the run fails.
pub fn run(options: &Options) -> Result<Verdict> {
    let scene = options.file.read()?;
    let method = Method::try_from(&scene.method).context("[method]")?;
    let what = without_end("run", &scene);
    let signals = Signals::watch()?;
    let mut place = Place::new(options, &scene);
    let start = |place: &mut Place| -> Result<_> {
        let growth = match &place.opened {
            Some((folder, _)) => placement::stored(&what, folder.path())?,
            None => None,
        };
        let mut store = |growth: &Growth| placement::store(growth, &what, place.describe()?.path());
        let placement = Placement::new(&method, &signals, options.choices.checkpoint_every, &mut store);
        let simulation = match growth {
            Some(growth) => placement.resume(growth),
            None => placement.begin(&scene),
        };
        let simulation = simulation.with_context(|| format!("scene {}", options.file.path.display()))?;
        let observers = outcome::observers(&scene.run, &simulation.view())?;
        Ok((simulation, observers))
    };
    // Built before anything is written, so that an invalid scene leaves no folder, except for a
    // growth that takes long. A run that is resumed need not place its bodies again.
    let resumes = options.choices.resumption.resume;
    let started = if resumes { None } else { Some(start(&mut place)?) };
    let folder = place.open()?;
    let task = Task {
        folder: &folder,
        what: what.clone(),
        until: scene.run.until,
        samples: sampling_times(0.0, scene.run.until, scene.run.sample_interval).count(),
        method,
        choices: &options.choices,
        signals: &signals,
    };
    let found = task.find()?;
    place.describe()?;
    let outcome = simulate(&task, found, &scene, || started.map_or_else(|| start(&mut place), Ok))?;
    let summary = outcome.summary(format!("Scene {}", options.file.path.display()), &task.method);
    folder.write("report.html", outcome.page(&folder, &summary, &scene, &place.command)?)?;
    outcome.describe_tables(&folder)?;
    folder.write_json("summary.json", &summary)?;
    placement::remove(folder.path())?;
    place.complete(summary.totals.cpu_seconds())?;
    crate::conclude(&folder, &summary);
    Ok(summary.verdict())
}

/// The folder of a run, which is created when it is first needed.
struct Place<'a> {
    scene: &'a Scene,
    path: PathBuf,
    existing: Existing,
    /// The command that repeats the run.
    command: String,
    /// The folder and its lock.
    opened: Option<(Folder, Option<File>)>,
    manifest: Option<Manifest>,
}

impl<'a> Place<'a> {
    fn new(options: &Options, scene: &'a Scene) -> Self {
        let path = folder_path(options);
        let command = format!("{} run {}", program(), path.join("config.toml").display());
        let existing = options.choices.resumption.existing();
        Self { scene, path, existing, command, opened: None, manifest: None }
    }

    /// Creates and locks the folder.
    fn open(&mut self) -> Result<Folder> {
        if let Some((folder, _)) = &self.opened {
            return Ok(folder.clone());
        }
        let folder = Folder::create(&self.path, self.existing)?;
        let lock = folder.lock()?;
        self.opened = Some((folder.clone(), lock));
        Ok(folder)
    }

    /// Creates the folder, with the manifest and the scene.
    fn describe(&mut self) -> Result<Folder> {
        let folder = self.open()?;
        if self.manifest.is_none() {
            self.manifest = Some(Manifest::begin(&folder, &self.command, &[self.scene])?);
            if let Some(frame) = &self.scene.start.snapshot {
                folder.write_lasting(START, frame.as_bytes())?;
            }
            folder.write("config.toml", self.scene.to_toml())?;
        }
        Ok(folder)
    }

    /// Records that the run has ended.
    fn complete(mut self, cpu_seconds: f64) -> Result<()> {
        let folder = self.describe()?;
        self.manifest.take().map_or(Ok(()), |manifest| manifest.complete(&folder, cpu_seconds))
    }
}

/// Runs a scene in memory, without a folder, and returns its figures and checks.
///
/// # Errors
/// The scene is invalid, the run fails, or a signal has been received.
pub fn measure(title: &str, scene: &Scene, signals: &Signals) -> Result<Summary> {
    let method = Method::try_from(&scene.method).context("[method]")?;
    Ok(outcome::in_memory(scene, signals)?.summary(title.to_owned(), &method))
}

fn folder_path(options: &Options) -> PathBuf {
    let name = options.file.path.file_stem().unwrap_or_else(|| "scene".as_ref()).to_string_lossy();
    options.choices.resumption.folder(&format!("out/run-{name}"))
}
