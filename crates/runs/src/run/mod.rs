//! `carom run`: runs any scene and writes what its `[run]` requests.

pub(crate) mod outcome;
mod scene_file;

use std::{ops::ControlFlow, path::PathBuf};

use anyhow::{Context, Result};
use carom::{Scene, engine::SceneError};
use carom_methods::{AnySimulation, Method};
use carom_tables::{Summary, Totals, Verdict};
use clap::Args;
use outcome::simulate;
pub use scene_file::SceneFile;

use crate::{
    interruption::Signals,
    manifest::{Manifest, program},
    measures::{Measures, Results},
    output::Folder,
    progress::{Lines, Progress},
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
    let start = || -> Result<_> {
        let simulation =
            placed(&scene, &method).with_context(|| format!("scene {}", options.file.path.display()))?;
        let observers = Measures::begin(&scene, &simulation.view())?;
        Ok((simulation, observers))
    };
    // Built before anything is written, so that an invalid scene leaves no folder. A run that is
    // resumed need not place its bodies again.
    let started = if options.choices.resumption.resume { None } else { Some(start()?) };
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
    let outcome = simulate(&task, found, &scene, || started.map_or_else(start, Ok))?;
    let summary = outcome.summary(format!("Scene {}", options.file.path.display()), &task.method);
    folder.write("report.html", outcome.page(&folder, &summary, &scene, &command)?)?;
    outcome::describe_tables(&outcome.results, &folder)?;
    outcome.record(&scene, &task.method).write(&folder)?;
    folder.write_json("summary.json", &summary)?;
    manifest.complete(&folder, summary.totals.cpu_seconds())?;
    crate::conclude(&folder, &summary);
    Ok(summary.verdict())
}

/// Runs a scene in memory, without a folder, and returns its figures and checks.
///
/// # Errors
/// The scene is invalid, the run fails, or a signal has been received.
pub fn measure(title: &str, scene: &Scene, signals: &Signals) -> Result<Summary> {
    let method = Method::try_from(&scene.method).context("[method]")?;
    Ok(outcome::in_memory(scene, signals)?.summary(title.to_owned(), &method))
}

/// Runs a scene in memory, without a folder, and returns the tables and figures of its measures.
///
/// # Errors
/// The scene is invalid, the run fails, or a signal has been received.
pub fn tables(scene: &Scene, signals: &Signals) -> Result<(Results, Totals)> {
    let outcome = outcome::in_memory(scene, signals)?;
    let totals = outcome.totals();
    Ok((outcome.results, totals))
}

/// The simulation of a scene, with the progress of the placement if that takes steps of growth.
fn placed(scene: &Scene, method: &Method) -> Result<AnySimulation, SceneError> {
    let mut shown: Option<Progress> = None;
    let (mut share, mut collisions) = (0.0, 0);
    AnySimulation::with_progress(scene, method, &mut |now| {
        // Growth and relaxation take about the same time.
        let reached = 0.5 * (now.smallest_scale + now.relaxed);
        let progress = shown.get_or_insert_with(|| Lines::default().add("placement", 1.0));
        progress.advance(reached - share, now.collisions - collisions);
        (share, collisions) = (reached, now.collisions);
        ControlFlow::Continue(())
    })
}

fn folder_path(options: &Options) -> PathBuf {
    let name = options.file.path.file_stem().unwrap_or_else(|| "scene".as_ref()).to_string_lossy();
    options.choices.resumption.folder(&format!("out/run-{name}"))
}
