//! `carom run`: runs any scene and writes what its `[run]` requests.

mod impulses;
pub(crate) mod outcome;
mod scene_file;

use std::path::PathBuf;

use anyhow::{Context, Result};
use carom_methods::{AnySimulation, Method};
use carom_tables::Verdict;
use clap::Args;
use outcome::simulate;
pub use scene_file::SceneFile;

use crate::{
    interruption::Signals,
    manifest::{Manifest, program},
    output::Folder,
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
    // Built before anything is written: an invalid scene leaves no folder.
    let method = Method::try_from(&scene.method).context("[method]")?;
    let simulation =
        AnySimulation::new(&scene).with_context(|| format!("scene {}", options.file.path.display()))?;
    let observers = outcome::observers(&scene.run, &simulation.view())?;
    let signals = Signals::watch()?;
    let folder = Folder::create(&folder_path(options), options.choices.resumption.existing())?;
    let _alone = folder.lock()?;
    let command = format!("{} run {}", program(), folder.path().join("config.toml").display());
    let task = Task {
        folder: &folder,
        what: without_end("run", &scene),
        until: scene.run.until,
        samples: sampling_times(0.0, scene.run.until, scene.run.sample_interval).count(),
        method,
        choices: &options.choices,
        signals: &signals,
    };
    let found = task.find()?;
    let manifest = Manifest::begin(&folder, &command, &[&scene])?;
    folder.write("config.toml", scene.to_toml())?;
    let outcome = simulate(&task, found, simulation, &scene, observers)?;
    let summary = outcome.summary(options, &task.method);
    folder.write("report.html", outcome.page(&folder, &summary, &scene, &command)?)?;
    outcome.describe_tables(&folder, &scene.run)?;
    folder.write_json("summary.json", &summary)?;
    manifest.complete(&folder, summary.totals.cpu_seconds())?;
    crate::conclude(&folder, &summary);
    Ok(summary.verdict())
}

fn folder_path(options: &Options) -> PathBuf {
    let name = options.file.path.file_stem().unwrap_or_else(|| "scene".as_ref()).to_string_lossy();
    options.choices.resumption.folder(&format!("out/run-{name}"))
}
