//! `carom run`: runs any scene and writes what its `[run]` requests.

mod before_placement;
pub mod interactive;
mod measured_before;
pub(crate) mod outcome;
pub(crate) mod parent;
pub(crate) mod placement;
pub mod replica;
mod scene_file;
mod state_table;
mod steps;
pub(crate) mod stop;

use std::{
    collections::BTreeSet,
    ffi::OsString,
    path::{Path, PathBuf},
};

use anyhow::{Context, Error, Result};
use carom::{Scene, engine::Growth};
use carom_methods::{AnySimulation, Method};
use carom_tables::{Summary, SummaryFile, Verdict};
use clap::Args;
use outcome::{Begun, Pricing, RunEnd, RunOutcome, simulate};
use parent::Parent;
use placement::BodyPlacement;
pub use scene_file::{EXTENDED_XYZ, START, SceneFile};

use crate::{
    command_line::command,
    exit::Followed,
    folder_lock::{FolderLock, Ousted},
    interruption::{Interrupted, Signals},
    manifest::{Manifest, TileSummary},
    measures::{self, Measures},
    memory::{self, Demand},
    output::{Existing, Folder},
    price::PRICE,
    record::Record,
    remarks::remarks,
    report::{self, FolderState},
    resumable::{Choices, Task, without_end},
    sampling_times::sampling_times,
    schedule::{stage_edits, stages},
    terminal::note,
    units::units,
};

/// Options of `carom run`.
#[derive(Debug, Clone, Args)]
pub struct RunOptions {
    /// The scene file and changes to it
    #[command(flatten)]
    pub file: SceneFile,
    /// Output folder and checkpoints
    #[command(flatten)]
    pub choices: Choices,
    /// Number of threads; default: one for each processor. Used where the box is divided into
    /// tiles, as large gases are; results do not depend on it
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Do not measure at the end what a `[method]` other than the default saves and gets wrong
    #[arg(long)]
    pub no_price: bool,
}

/// Runs a scene and writes its folder.
///
/// # Errors
/// The scene is invalid, the folder is not empty, or the run fails.
pub fn run(options: &RunOptions) -> Result<Verdict> {
    let from = options.file.from.as_deref();
    let parent = Parent::find(
        from,
        &folder_path(options),
        options.choices.resumption.resume,
    )?;
    let scene = options.file.read(parent.as_ref())?;
    let method = Method::try_from(&scene.method).context("[method]")?;
    let remarks = note_remarks(&scene, parent.as_ref());
    let what = describe(&scene, parent.as_ref());
    let signals = Signals::watch()?;
    let mut place = Place::new(options, &scene, parent.as_ref());
    let start = |place: &mut Place| start_in(place, options, &method, &what, &signals);
    // Built before anything is written, so that an invalid scene leaves no folder, except for a
    // growth that takes long. A run that is resumed need not place its bodies again.
    let resumes = options.choices.resumption.resume;
    if !resumes {
        options
            .choices
            .resumption
            .destination
            .check(&place.path.display().to_string())?;
    }
    let started = if resumes {
        None
    } else {
        Some(start(&mut place).map_err(|error| place.give_up(error))?)
    };
    let folder = place.open()?;
    let task = Task {
        folder: &folder,
        what: what.clone(),
        until: scene.run.until,
        samples: sampling_times(0.0, scene.run.until, scene.run.sample_interval).count(),
        method,
        threads: options.threads.map_or_else(all_processors, usize::from),
        choices: &options.choices,
        signals: &signals,
    };
    let found = task.find()?;
    place.describe()?;
    let pricing = if options.no_price {
        Pricing::LeftOut
    } else {
        Pricing::Measured
    };
    let ended = simulate(&task, found, &scene, pricing, || {
        started.map_or_else(|| start(&mut place), Ok)
    });
    let ended = ended.map_err(|error| place.record(error))?;
    let title = format!("Scene {}", options.file.path.display());
    finish(place, &task, ended, title, &remarks)
}

/// Shows the remarks on a scene, and returns them. There are none on a run that starts from another
/// one.
fn note_remarks(scene: &Scene, parent: Option<&Parent>) -> Vec<String> {
    // The contents of the box come from the parent.
    let remarks = if parent.is_none() {
        remarks(scene)
    } else {
        Vec::new()
    };
    for remark in &remarks {
        note(remark);
    }
    remarks
}

/// The start of a run: from another run, from a growth that was interrupted, or from its scene.
fn start_in(
    place: &mut Place<'_>,
    options: &RunOptions,
    method: &Method,
    what: &str,
    signals: &Signals,
) -> Result<Begun> {
    let scene = place.scene;
    if let Some(parent) = place.parent {
        return start(continued(parent, scene, method)?, scene, parent.actions);
    }
    let of_scene = || format!("scene {}", options.file.path.display());
    let demand = Demand::new(scene).with_context(of_scene)?;
    demand
        .refuse_unless_fits(memory::available())
        .with_context(of_scene)?;
    let growth = match &place.opened {
        Some((folder, _)) => placement::stored(what, folder.path())?,
        None => None,
    };
    let mut store = |growth: &Growth| placement::store(growth, what, place.describe()?.path());
    let every = options.choices.checkpoint_every;
    let placement = BodyPlacement::new(method, signals, every, &mut store);
    let simulation = match growth {
        Some(growth) => placement.resume(growth),
        None => placement.place(scene),
    };
    start(simulation.with_context(of_scene)?, scene, 0)
}

fn all_processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Writes what was measured to the end of a run, or to the error that ended it, and returns the
/// verdict.
fn finish(
    mut place: Place<'_>,
    task: &Task<'_>,
    ended: RunEnd,
    title: String,
    remarks: &[String],
) -> Result<Verdict> {
    let (folder, scene, parent) = (task.folder, place.scene, place.parent);
    place.tiles = Some(TileSummary::new(task.threads, &ended.tiles));
    let units = units(scene)?;
    if let Some(error) = ended.error {
        let until = scene.run.until;
        let mut summary = ended.outcome.summary_of_failed(title, &task.method, until);
        put_first(&mut summary, parent, remarks);
        // The cause comes first: on a full disk none of this can be written.
        let recorded = place.fail(summary.totals.cpu_seconds(), &error);
        let written = write_failed(folder, &ended.outcome, &summary, &error);
        let later = [recorded.err(), written.err()].into_iter().flatten();
        crate::conclude(folder, &summary, units.as_ref());
        return Err(Followed::by(error, ended.later.into_iter().chain(later)));
    }
    let mut summary = ended.outcome.summary(title, &task.method);
    put_first(&mut summary, parent, remarks);
    let written = write_ended(folder, &ended.outcome, &summary, scene, &task.method);
    written.map_err(|error| place.record(error))?;
    place.complete(summary.totals.cpu_seconds())?;
    crate::conclude(folder, &summary, units.as_ref());
    Ok(summary.verdict())
}

/// Writes the results of a run that has reached its end, the page last.
fn write_ended(
    folder: &Folder,
    outcome: &RunOutcome,
    summary: &Summary,
    scene: &Scene,
    method: &Method,
) -> Result<()> {
    report::write_tables(&outcome.results, folder)?;
    outcome.record(scene, method).write(folder)?;
    folder.write_json("summary.json", &SummaryFile::new(summary))?;
    if let Some(price) = outcome.price() {
        folder.write_json(PRICE, price)?;
    }
    placement::remove(folder.path())?;
    report::write(folder, FolderState::Ended)
}

/// Writes the results of a run up to an error, the page last.
fn write_failed(
    folder: &Folder,
    outcome: &RunOutcome,
    summary: &Summary,
    error: &Error,
) -> Result<()> {
    folder.write_json("summary.json", &SummaryFile::new(summary))?;
    report::write_tables(&outcome.results, folder)?;
    report::write(folder, FolderState::Failed(format!("{error:#}")))
}

/// Puts the run from which this one starts, and remarks on the scene, before the note.
fn put_first(summary: &mut Summary, parent: Option<&Parent>, remarks: &[String]) {
    let mut note: Vec<String> = parent
        .map(|parent| parent.origin.sentence())
        .into_iter()
        .collect();
    note.extend_from_slice(remarks);
    note.push(std::mem::take(&mut summary.note));
    summary.note = note.join(" ").trim_end().into();
}

/// Validates `[run]` and the times of the stages.
#[cfg(test)]
pub(crate) fn check(scene: &Scene) -> Result<()> {
    scene_file::check(&scene.run)?;
    stages::check(scene)
}

/// The time from which on a scene is measured; 0 if none of its stages is.
pub fn measured_from(scene: &Scene) -> f64 {
    let (from, _) = stages::window(scene);
    if from.is_finite() { from } else { 0.0 }
}

/// The description that identifies a run in its checkpoint.
fn describe(scene: &Scene, parent: Option<&Parent>) -> String {
    let mut what = without_end("run", scene);
    if let Some(parent) = parent {
        what.insert_str("run\n".len(), &parent.line());
    }
    what
}

/// The start of a run, after the edits of the first stage. `before` is the number of draws of
/// random numbers by thermostats before.
pub(crate) fn start(mut simulation: AnySimulation, scene: &Scene, before: u64) -> Result<Begun> {
    let actions = before + stage_edits::prepare(&mut simulation, scene, before)?;
    let measures = Measures::new(scene, &simulation.view())?;
    memory::refuse_long_series(measures.bytes_at_end(&scene.run), memory::available())?;
    Ok((simulation, measures, actions))
}

/// The simulation of a run that starts from another run, with the rules of its scene.
///
/// # Errors
/// The state does not fit the scene.
pub(crate) fn continued(parent: &Parent, scene: &Scene, method: &Method) -> Result<AnySimulation> {
    let simulation = parent.start(scene, method)?;
    let view = simulation.view();
    if view.is_sheared() {
        measures::refuse_displaced(scene)?;
    }
    let tags = view
        .bodies()
        .flat_map(|body| body.body.tags().iter().copied());
    let names: BTreeSet<String> = tags
        .map(|tag| view.tag_names().name(tag).to_owned())
        .collect();
    stages::refuse_unknown_tags(scene, names)?;
    Ok(simulation)
}

/// The folder of a run, which is created when it is first needed.
struct Place<'a> {
    scene: &'a Scene,
    /// The run from which it starts.
    parent: Option<&'a Parent>,
    path: PathBuf,
    existing: Existing,
    /// The command that repeats the run.
    command: String,
    /// The folder and its lock.
    opened: Option<(Folder, FolderLock)>,
    manifest: Option<Manifest>,
    /// Work in tiles, once the run has ended.
    tiles: Option<TileSummary>,
}

impl<'a> Place<'a> {
    fn new(options: &RunOptions, scene: &'a Scene, parent: Option<&'a Parent>) -> Self {
        let path = folder_path(options);
        let command = again(&path, parent);
        let existing = options.choices.resumption.existing();
        Self {
            scene,
            parent,
            path,
            existing,
            command,
            opened: None,
            manifest: None,
            tiles: None,
        }
    }

    /// Creates and locks the folder.
    fn open(&mut self) -> Result<Folder> {
        if let Some((folder, _)) = &self.opened {
            return Ok(folder.clone());
        }
        let (folder, lock) = Folder::claim(&self.path, self.existing)?;
        self.opened = Some((folder.clone(), lock));
        Ok(folder)
    }

    /// Creates the folder, with the manifest and the scene.
    fn describe(&mut self) -> Result<Folder> {
        let folder = self.open()?;
        if self.manifest.is_none() {
            let note = self
                .parent
                .map(|parent| serde_json::to_value(&parent.origin))
                .transpose()?;
            self.manifest = Some(Manifest::write_from(
                &folder,
                &self.command,
                &[self.scene],
                note,
            )?);
            Parent::store(self.parent, &folder)?;
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
        self.ended()
            .map_or(Ok(()), |manifest| manifest.complete(&folder, cpu_seconds))
    }

    /// Records that the run has ended with an error.
    fn fail(&mut self, cpu_seconds: f64, error: &Error) -> Result<()> {
        let folder = self.describe()?;
        self.ended().map_or(Ok(()), |manifest| {
            manifest.fail(&folder, cpu_seconds, error)
        })
    }

    /// Removes what a run has written that did not start, unless it was interrupted, or has stored
    /// a growth, which continues from there.
    fn give_up(&mut self, error: Error) -> Error {
        if error
            .chain()
            .any(|cause| cause.is::<Interrupted>() || cause.is::<Ousted>())
        {
            return error;
        }
        let Some((folder, lock)) = self.opened.take() else {
            return error;
        };
        if folder.path().join(placement::GROWTH).exists() {
            return error;
        }
        self.manifest = None;
        let removed = folder.remove_own();
        drop(lock);
        Followed::by(error, removed.err())
    }

    /// Puts an error that is not an interruption into the manifest, and returns it.
    fn record(&mut self, error: Error) -> Error {
        if error
            .chain()
            .any(|cause| cause.is::<Interrupted>() || cause.is::<Ousted>())
        {
            return error;
        }
        let recorded = self.fail(0.0, &error);
        Followed::by(error, recorded.err())
    }

    /// The manifest of a run that has ended.
    fn ended(&mut self) -> Option<Manifest> {
        let mut manifest = self.manifest.take()?;
        if let Some(tiles) = self.tiles.take() {
            manifest.set_tiles(tiles);
        }
        Some(manifest)
    }
}

/// The command that repeats the run in a folder.
fn again(folder: &Path, parent: Option<&Parent>) -> String {
    let mut words: Vec<OsString> = vec!["run".into(), folder.join("config.toml").into()];
    if let Some(parent) = parent {
        words.extend(["--from".into(), OsString::from(&parent.origin.folder)]);
    }
    command(words)
}

/// Validates a scene and runs it in memory, without a folder; returns what the runs of other
/// replicas are merged with.
///
/// # Errors
/// The scene is invalid, the run fails, or a signal has been received.
pub fn record(scene: &Scene, signals: &Signals) -> Result<Record> {
    let method = Method::try_from(&scene.method).context("[method]")?;
    scene_file::validate(scene)?;
    Ok(outcome::in_memory(scene, signals)?.record(scene, &method))
}

fn folder_path(options: &RunOptions) -> PathBuf {
    let name = options
        .file
        .path
        .file_stem()
        .unwrap_or_else(|| "scene".as_ref())
        .to_string_lossy();
    options
        .choices
        .resumption
        .folder(&format!("out/run-{name}"))
}
