//! Resumable runs: checkpoints from which an interrupted run continues to the same result, bit for
//! bit.
//!
//! Guarantees:
//! - A run that is interrupted and resumed gives the same files, to the bit, as one run throughout.
//! - A resumed run uses the same scene: a checkpoint of any other run is refused, with the first
//!   line that differs. Only the end of the run may change, and only to a later time; and
//!   `run.units`, in which the page and the terminal show the results.
//! - Checkpoints are written where an epoch ends, between two samples or after an edit: at a fixed
//!   interval of wall time, on SIGINT or SIGTERM, and once shortly before the end.
//! - No checkpoint is taken at the end itself: the last sample lies at `until`, where a longer run
//!   may have none, so a run is extended from the checkpoint before it.
//!
//! A checkpoint consists of:
//! 1. the head: the run as text, its end, whether it has ended, the numbers of steps done, and the
//!    state at its end, from which another run can start;
//! 2. the state: simulation, observers, number of samples, lengths of the files appended to, and
//!    processor time;
//! 3. the result, once the run has ended.

use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use anyhow::{Context, Result, ensure};
use carom::{Checkpoint, EpochTime, Observer, Scene};
use carom_methods::{AnySimulation, Method};
use clap::Args;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::{
    append_file::{AppendFiles, CheckpointLengths, Length},
    checkpoint_file::{self, CheckpointBody, FileError},
    clock::{Instant as WallTime, ProcessTime, ThreadTime},
    interruption::{SharedLengths, Signals},
    other_run::refuse_other_run,
    output::{Folder, Resumption},
};

pub use crate::file_names::CHECKPOINT;

/// One checkpoint is taken when this share of the run is done; an extended run starts from it.
/// Smaller: an extension repeats more of the run. Larger: fewer runs have an epoch that ends so
/// late.
const NEARLY_DONE: f64 = 0.99;

/// Options for folders and checkpoints, shared by all commands that run scenes to their end.
#[derive(Debug, Clone, Args)]
pub struct Choices {
    /// Output folder, and whether to resume there.
    #[command(flatten)]
    pub resumption: Resumption,
    /// Seconds between two checkpoints: the most that is lost if the program is killed
    #[arg(long, value_name = "SECONDS", default_value = "30", value_parser = seconds)]
    pub checkpoint_every: Duration,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())
}

/// The run that the user requests.
#[derive(Debug)]
pub struct Task<'a> {
    /// Folder of this run alone.
    pub folder: &'a Folder,
    /// The full description of the run without its end. A checkpoint with another description is
    /// refused.
    pub what: String,
    /// End of the run (time).
    pub until: f64,
    /// Number of samples of the whole run.
    pub samples: usize,
    /// How the run is computed; a checkpoint is resumed with the same method.
    pub method: Method,
    /// Threads of this run alone. They change no bit.
    pub threads: usize,
    /// Checkpoint options, and whether to resume.
    pub choices: &'a Choices,
    /// Signals that end the program.
    pub signals: &'a Signals,
}

/// Starting point of a run.
#[derive(Debug)]
pub enum Start<O, F> {
    /// From the beginning: there is no checkpoint, or `--resume` is not given.
    Anew,
    /// From a checkpoint.
    From(Box<Resumable<O>>),
    /// The run has already ended with this result.
    Ended(F),
}

/// Measures the processor time of a run.
#[derive(Debug)]
enum Clock {
    /// Of its thread: other runs may share the process.
    Thread(ThreadTime),
    /// Of all threads: the run has the process to itself.
    Process(ProcessTime),
}

impl Clock {
    fn start(threads: usize) -> Self {
        if threads > 1 {
            Self::Process(ProcessTime::now())
        } else {
            Self::Thread(ThreadTime::now())
        }
    }

    fn seconds(&self) -> f64 {
        match self {
            Self::Thread(clock) => clock.elapsed().as_secs_f64(),
            Self::Process(clock) => clock.elapsed().as_secs_f64(),
        }
    }
}

/// A run in progress.
#[derive(Debug)]
pub struct Resumable<O> {
    /// The simulation.
    pub simulation: AnySimulation,
    /// The observers of the run.
    pub observers: O,
    /// The files that the run appends to.
    pub files: AppendFiles,
    /// Number of draws of random numbers by thermostats so far.
    pub actions: u64,
    samples: usize,
    /// Number of steps besides samples.
    steps: u64,
    clock: Clock,
    /// Processor time of earlier processes (seconds).
    seconds_before: f64,
    /// Wall time of the last checkpoint.
    saved: Option<WallTime>,
    saved_near_end: bool,
    /// Lengths of the files at the last checkpoint.
    lengths: SharedLengths,
}

/// A checkpoint that the run can be resumed from.
#[derive(Debug)]
pub struct FoundCheckpoint {
    head: Head,
    body: CheckpointBody,
}

impl FoundCheckpoint {
    /// Returns true if the run has ended at `until`.
    pub fn has_ended(&self, until: f64) -> bool {
        self.head.ended && self.head.until == until
    }
}

#[derive(Debug, Serialize, Deserialize)]
struct Head {
    what: String,
    until: f64,
    ended: bool,
    time: EpochTime,
    progress: Done,
    end: Option<End>,
}

/// The end of a run.
#[derive(Debug, Serialize, Deserialize)]
struct End {
    state: Checkpoint,
    actions: u64,
}

/// The steps of a run that have been done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub(crate) struct Done {
    /// Samples.
    pub samples: usize,
    /// Other steps of the schedule.
    pub steps: u64,
    /// Draws of random numbers by thermostats.
    pub actions: u64,
}

#[derive(Debug, Serialize, Deserialize)]
struct State<O> {
    simulation: Checkpoint,
    observers: O,
    seconds: f64,
    files: Vec<Length>,
}

/// The last state of a run.
#[derive(Debug)]
pub struct LastState {
    /// The description of the run, see [`Task::what`].
    pub what: String,
    /// The state: at the end of the run, or of its last checkpoint.
    pub state: Checkpoint,
    /// Whether the run has ended.
    pub is_end: bool,
    /// Number of draws of random numbers by thermostats.
    pub actions: u64,
}

/// Reads the last state of a run from its checkpoint.
///
/// # Errors
/// The file cannot be read or is no checkpoint of a run in time.
pub fn last_state(path: &Path) -> Result<LastState> {
    let mut body = CheckpointBody::read(path)?;
    let Head {
        what,
        progress,
        end,
        ..
    } = body.take()?;
    Ok(match end {
        Some(End { state, actions }) => LastState {
            what,
            state,
            is_end: true,
            actions,
        },
        // The first value of the state is that of the simulation.
        None => LastState {
            what,
            state: body.take()?,
            is_end: false,
            actions: progress.actions,
        },
    })
}

/// Second line of the description of a state that [`write_state`] has written: a comment of the
/// scene.
const SAVED: &str = "# saved by a program\n";

/// Writes the state of a simulation that a program runs itself, with data of that program.
/// [`last_state`] reads it, and `carom run SCENE --from` starts from it.
///
/// # Errors
/// The data cannot be encoded, or the file cannot be written.
pub fn write_state<T: Serialize>(
    path: &Path,
    scene: &Scene,
    state: Checkpoint,
    data: &T,
) -> Result<()> {
    let (time, progress) = (state.time(), Done::default());
    let mut what = without_end("run", scene);
    what.insert_str("run\n".len(), SAVED);
    let until = time.to_f64();
    let end = Some(End { state, actions: 0 });
    let head = Head {
        what,
        until,
        ended: true,
        time,
        progress,
        end,
    };
    checkpoint_file::write(
        path,
        &[
            &checkpoint_file::encode(&head)?,
            &checkpoint_file::encode(data)?,
        ],
    )
}

/// The bytes of the checkpoint of a run that goes on, at a state of its simulation, which took this
/// processor time (seconds). It appends to `files`.
///
/// # Errors
/// It cannot be encoded.
pub(crate) fn encode_going<O: Serialize>(
    what: &str,
    until: f64,
    progress: Done,
    simulation: &Checkpoint,
    seconds: f64,
    observers: &O,
    files: Vec<Length>,
) -> Result<Vec<u8>> {
    let (what, time) = (what.to_owned(), simulation.time());
    let head = Head {
        what,
        until,
        ended: false,
        time,
        progress,
        end: None,
    };
    let state = State {
        simulation: simulation.clone(),
        observers,
        seconds,
        files,
    };
    Ok(checkpoint_file::bytes_of(&[
        &checkpoint_file::encode(&head)?,
        &checkpoint_file::encode(&state)?,
    ]))
}

/// Reads a state like [`last_state`], with the data of the program if [`write_state`] has written
/// it.
///
/// # Errors
/// Those of [`last_state`]; the data have another type.
pub fn read_state<T: DeserializeOwned>(path: &Path) -> Result<(LastState, Option<T>)> {
    let last = last_state(path)?;
    if !last.what.starts_with(&format!("run\n{SAVED}")) {
        return Ok((last, None));
    }
    let mut body = CheckpointBody::read(path)?;
    body.take::<Head>()?;
    Ok((last, Some(body.take()?)))
}

/// Returns the description that identifies a run in its checkpoint: the command and the scene
/// without its end.
pub fn without_end(command: &str, scene: &Scene) -> String {
    let mut endless = scene.clone();
    endless.run.until = 0.0;
    if let Some(last) = endless.stage.last_mut() {
        last.until = 0.0;
    }
    format!("{command}\n{}", endless.to_toml())
}

impl Task<'_> {
    /// Looks for a checkpoint if the run is to be resumed. Writes nothing. Returns `None` if there
    /// is none, as after a kill before the first checkpoint.
    ///
    /// # Errors
    /// The checkpoint cannot be read, belongs to another run, or lies beyond the end.
    pub fn find(&self) -> Result<Option<FoundCheckpoint>> {
        if !self.choices.resumption.resume {
            return Ok(None);
        }
        let path = self.path();
        match CheckpointBody::read(&path) {
            Err(FileError::Unreadable(error)) if error.kind() == io::ErrorKind::NotFound => {
                Ok(None)
            }
            Err(error) => Err(error.into()),
            Ok(body) => self.accept(body).map(Some),
        }
        .with_context(|| format!("cannot resume from {}", path.display()))
    }

    fn accept(&self, mut body: CheckpointBody) -> Result<FoundCheckpoint> {
        let head: Head = body.take()?;
        refuse_other_run(&head.what, &self.what)?;
        ensure!(
            !head.ended || self.until >= head.until,
            "the run has already ended at {}; it can be extended but not shortened: use --until {0} or later",
            head.until
        );
        ensure!(
            head.progress.samples < self.samples && head.time <= EpochTime::from(self.until),
            "the checkpoint is at time {}, so the run cannot end at {}",
            head.time,
            self.until
        );
        Ok(FoundCheckpoint { head, body })
    }

    /// Starts the run from the checkpoint `found`, or from the beginning without one.
    ///
    /// # Errors
    /// A signal has been received; the checkpoint does not fit this program or the files in the
    /// folder.
    pub fn start<O: Serialize + DeserializeOwned, F: DeserializeOwned>(
        &self,
        found: Option<FoundCheckpoint>,
    ) -> Result<Start<O, F>> {
        self.signals.check()?;
        let path = self.path();
        let Some(found) = found else {
            return match fs::remove_file(&path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    Err(error).with_context(|| format!("cannot replace {}", path.display()))
                }
                _ => Ok(Start::Anew),
            };
        };
        self.resume(found)
            .with_context(|| format!("cannot resume from {}", path.display()))
    }

    fn resume<O: Serialize + DeserializeOwned, F: DeserializeOwned>(
        &self,
        found: FoundCheckpoint,
    ) -> Result<Start<O, F>> {
        let ended = found.has_ended(self.until);
        let FoundCheckpoint { head, mut body } = found;
        let state: State<O> = body.take()?;
        if ended {
            return Ok(Start::Ended(body.take()?));
        }
        let mut simulation = AnySimulation::resume(&state.simulation, &self.method)?;
        simulation.set_tiling(&self.method.tiling(self.threads));
        if head.ended {
            // The run is extended: its old result no longer describes the files, so the head is
            // reset.
            self.write(head.progress, &state)?;
        }
        let files = AppendFiles::resume(self.folder, &state.files)?;
        let lengths = self.share(&files, Some(state.files));
        Ok(Start::From(Box::new(Resumable {
            simulation,
            observers: state.observers,
            files,
            actions: head.progress.actions,
            samples: head.progress.samples,
            steps: head.progress.steps,
            clock: Clock::start(self.threads),
            seconds_before: state.seconds,
            saved: Some(WallTime::now()),
            saved_near_end: self.is_nearly_done(head.time),
            lengths,
        })))
    }

    /// Shares the file lengths of the last checkpoint with the signal handler, which truncates the
    /// files to them if the program must end between two checkpoints.
    fn share(&self, files: &AppendFiles, lengths: Option<Vec<Length>>) -> SharedLengths {
        let mut shared = CheckpointLengths::new(files);
        shared.set(lengths);
        let shared = Arc::new(Mutex::new(shared));
        self.signals.register(Arc::clone(&shared));
        shared
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join(CHECKPOINT)
    }

    /// Writes the checkpoint of a run that has not ended.
    fn write<O: Serialize>(&self, progress: Done, state: &State<O>) -> Result<()> {
        let time = state.simulation.time();
        let head = Head {
            what: self.what.clone(),
            until: self.until,
            ended: false,
            time,
            progress,
            end: None,
        };
        checkpoint_file::write(
            &self.path(),
            &[
                &checkpoint_file::encode(&head)?,
                &checkpoint_file::encode(state)?,
            ],
        )
    }

    fn is_nearly_done(&self, time: EpochTime) -> bool {
        time.to_f64() >= NEARLY_DONE * self.until
    }
}

impl<O: Observer + Serialize> Resumable<O> {
    /// A run at its beginning.
    pub fn new(task: &Task<'_>, mut simulation: AnySimulation, observers: O) -> Self {
        simulation.set_tiling(&task.method.tiling(task.threads));
        let files = AppendFiles::new(task.folder);
        let lengths = task.share(&files, None);
        Self {
            simulation,
            observers,
            files,
            actions: 0,
            samples: 0,
            steps: 0,
            clock: Clock::start(task.threads),
            seconds_before: 0.0,
            saved: None,
            saved_near_end: false,
            lengths,
        }
    }

    /// Counts the present as a checkpoint, so that a run shorter than the interval between two of
    /// them, or killed before that, leaves none.
    pub fn postpone_checkpoint(&mut self) {
        self.saved = Some(WallTime::now());
        self.saved_near_end = true;
    }

    /// Runs to the next sample at `time` and writes checkpoints on the way.
    ///
    /// # Errors
    /// The run fails, a checkpoint cannot be written, or a signal has been received and a
    /// checkpoint exists.
    pub fn run_to(&mut self, time: f64, task: &Task<'_>) -> Result<()> {
        self.run_to_and(time, task, |_, _| Ok(()))
    }

    /// Runs to the next sample at `time`, writes checkpoints on the way, and calls `at_end` after
    /// each epoch: an observer of every contact can then empty its memory into a file.
    ///
    /// # Errors
    /// The run fails, `at_end` fails, a checkpoint cannot be written, or a signal has been received
    /// and a checkpoint exists.
    pub fn run_to_and(
        &mut self,
        time: f64,
        task: &Task<'_>,
        at_end: impl Fn(&mut O, &mut AppendFiles) -> Result<()>,
    ) -> Result<()> {
        let until = EpochTime::from(time);
        if self.saved.is_none() {
            self.save(task)?;
        }
        while !self.simulation.observe_epoch(until, &mut self.observers)? {
            at_end(&mut self.observers, &mut self.files)?;
            self.save_if_due(task)?;
        }
        Ok(())
    }

    /// Changes the simulation between two samples. `edits` receives the number of draws of random
    /// numbers so far, and returns how many it has made.
    ///
    /// # Errors
    /// An edit is refused, a checkpoint cannot be written, or a signal has been received.
    pub fn edit(
        &mut self,
        task: &Task<'_>,
        edits: impl FnOnce(&mut AnySimulation, u64) -> Result<u64>,
    ) -> Result<()> {
        self.observers.pause(&self.simulation.view());
        self.actions += edits(&mut self.simulation, self.actions)?;
        self.observers.start(&self.simulation.view());
        self.pass();
        // Edits may follow so closely on one another that no epoch ends by itself.
        self.save_if_due(task)
    }

    /// Writes a checkpoint if it is time for one and the simulation is at the end of an epoch.
    fn save_if_due(&mut self, task: &Task<'_>) -> Result<()> {
        let interrupted = task.signals.check();
        let near_end = task.is_nearly_done(self.simulation.time());
        let timely = self
            .saved
            .is_none_or(|saved| saved.elapsed() >= task.choices.checkpoint_every);
        if (timely || interrupted.is_err() || (near_end && !self.saved_near_end))
            && self.save(task)?
        {
            self.saved_near_end |= near_end;
        }
        Ok(interrupted?)
    }

    fn done(&self) -> Done {
        Done {
            samples: self.samples,
            steps: self.steps,
            actions: self.actions,
        }
    }

    /// Counts a step that is not a sample.
    pub fn pass(&mut self) {
        self.steps += 1;
    }

    /// Records a sample: calls [`Observer::sample`] with the current state.
    pub fn sample(&mut self) {
        self.observers.sample(&self.simulation.view());
        self.samples += 1;
    }

    /// Number of samples so far.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Number of steps so far: samples and others.
    pub fn steps(&self) -> usize {
        self.samples + self.steps as usize
    }

    /// Processor time so far, including earlier processes up to their last checkpoint (seconds).
    pub fn seconds(&self) -> f64 {
        self.seconds_before + self.clock.seconds()
    }

    /// Stores the result of a run that has ended.
    ///
    /// # Errors
    /// The checkpoint cannot be written.
    pub fn end<F: Serialize>(mut self, task: &Task<'_>, result: &F) -> Result<()> {
        self.files.lengths()?;
        let mut lengths = self.lengths.lock().unwrap_or_else(PoisonError::into_inner);
        // The files are now longer than at the checkpoint and must not be truncated.
        lengths.set(None);
        let mut body = CheckpointBody::read(&task.path())?;
        let end = End {
            state: self.simulation.end_epoch_here(),
            actions: self.actions,
        };
        let head = Head {
            ended: true,
            until: task.until,
            end: Some(end),
            ..body.take()?
        };
        checkpoint_file::write(
            &task.path(),
            &[
                &checkpoint_file::encode(&head)?,
                body.rest(),
                &checkpoint_file::encode(result)?,
            ],
        )
    }

    /// Writes a checkpoint if the simulation is at the end of an epoch; returns whether it is.
    fn save(&mut self, task: &Task<'_>) -> Result<bool> {
        let Some(simulation) = self.simulation.checkpoint() else {
            return Ok(false);
        };
        let files = self.files.lengths()?;
        let state = State {
            simulation,
            observers: &self.observers,
            seconds: self.seconds(),
            files,
        };
        // The lock keeps the signal handler from truncating files to an older checkpoint than the
        // one on disk.
        let mut lengths = self.lengths.lock().unwrap_or_else(PoisonError::into_inner);
        task.write(self.done(), &state)?;
        // One that has come meanwhile has resumed from the checkpoint before.
        task.folder.check_holder()?;
        lengths.set(Some(state.files));
        drop(lengths);
        self.saved = Some(WallTime::now());
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checkpoint_file::{FORMAT, decode, encode};
    use carom::{
        CollisionRate, DirectionHistogram, EnergyLedger, OverlapCheck, Pressure, RunningAverage,
        observers::ImpulseLog,
    };

    /// Checkpoint of a tee before its first step. A failure means that the content of checkpoints
    /// has changed and that older ones would be misread: increment FORMAT and put the new numbers
    /// here.
    #[test]
    fn the_content_of_a_checkpoint_changes_with_the_format_only() {
        let scene = Scene::from_toml(
            "[[molecule]]\ntags = [\"tee\"]\nshape = \"tee\"\natom_radius = 0.0625\natom_mass = 1.0\nat = [0.5, 0.5]\n\
             velocity = [1.0, 0.0]\n[[bumper]]\nradius = 0.0625\nat = [0.125, 0.125]\n\
             [[elasticity.pair]]\nbetween = [\"tee\"]\ncoefficient = 0.5\n",
        )
        .unwrap();
        let simulation = AnySimulation::new(&scene).unwrap();
        let view = simulation.view();
        let tee = view.bodies().next().unwrap().body.key();
        let mut observers = (
            (
                EnergyLedger::default(),
                OverlapCheck::default(),
                CollisionRate::default(),
                Pressure::default(),
            ),
            (
                DirectionHistogram::new(tee, 4),
                RunningAverage::new(tee),
                ImpulseLog::new(tee, 100),
            ),
        );
        observers.start(&view);
        observers.sample(&view);
        let head = Head {
            what: "run".to_owned(),
            until: 1.0,
            ended: false,
            time: EpochTime::ZERO,
            progress: Done::default(),
            end: None,
        };
        let simulation = simulation.checkpoint().unwrap();
        let kept = encode(&(
            head,
            State {
                simulation,
                observers,
                seconds: 0.5,
                files: Vec::new(),
            },
        ))
        .unwrap();
        assert_eq!(
            (FORMAT, kept.len(), crc32fast::hash(&kept)),
            (30, 1071, 1_327_252_991)
        );
    }
    /// Rules that scenes read from lists of another form.
    #[test]
    fn rules_for_pairs_are_read_back() {
        let text = "[[transparent]]\nbetween = [\"b\"]\n[[diameter]]\nbetween = [\"a\", \"b\"]\nfactor = 0.8\n\
                    [[well]]\nbetween = [\"a\"]\nsteps = [[1.5, -1.0], [2.0, 0.5]]\n\
                    [[gas]]\ntags = [\"a\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 40\n\
                    chain = { members = 2, tether = { max = 0.07 } }\n\
                    [[gas]]\ntags = [\"b\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 10\n";
        let scene = Scene::from_toml(text).unwrap();
        let mut simulation = carom::Simulation::new(&scene).unwrap();
        simulation.run_until(0.3).unwrap();
        let state = simulation.end_epoch_here();
        let read: Checkpoint = decode(&encode(&state).unwrap()).unwrap();
        let mut resumed = carom::Simulation::resume(&read).unwrap();
        for run in [&mut simulation, &mut resumed] {
            run.run_until(0.6).unwrap();
        }
        let [one, other] = [&simulation, &resumed].map(|run| run.view());
        assert_eq!(one.counters(), other.counters());
        assert!(one.counters().step_collisions > 50);
        assert_eq!(
            one.energy_of_wells().to_bits(),
            other.energy_of_wells().to_bits()
        );
    }
}
