//! A run that can be interrupted at any moment and gone on with, to the bit.
//!
//! A checkpoint holds: what is run, as text, and until when (the head); the simulation, its observers, how many samples
//! there were, how long the files were that grow, and the processor time spent (the state); and, once the run has ended,
//! its result. It is taken where an epoch ends, between two samples: when it is time, when the program is asked to end, and
//! once shortly before the end. Never at the end itself: the last sample stands where the run was to end, which a longer
//! run knows nothing of, so a run is extended from before it.

use std::{
    fs, io,
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant as WallTime},
};

use anyhow::{Context, Result, bail, ensure};
use carom::{Checkpoint, EpochTime, Observer, Scene, Simulation};
use clap::Args;
use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::{
    append_file::{Growing, Kept, Length},
    checkpoint_file::{self, Body, FileError},
    interruption::{SharedKept, Signals},
    output::{Folder, Resumption},
};

/// Name of the file in the folder of a run.
pub const CHECKPOINT: &str = "checkpoint";

/// A checkpoint is taken once when this part of the run is done, to extend it from. Smaller: more is run twice then. Larger:
/// fewer runs have an epoch's end so late.
const NEARLY_DONE: f64 = 0.99;

/// Choices about folders and checkpoints, the same for every command that runs one scene or several to their end.
#[derive(Debug, Clone, Args)]
pub struct Choices {
    /// Where to write, and whether to go on there.
    #[command(flatten)]
    pub resumption: Resumption,
    /// Seconds between two checkpoints: what is lost at most if the program is killed
    #[arg(long, value_name = "SECONDS", default_value = "30", value_parser = seconds)]
    pub checkpoint_every: Duration,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())
}

/// One run as it was asked for.
#[derive(Debug)]
pub struct Task<'a> {
    /// Folder of this run alone.
    pub folder: &'a Folder,
    /// What is run, in full, but for its end. A checkpoint of anything else is refused.
    pub what: String,
    /// When it ends (time).
    pub until: f64,
    /// How many samples there will be.
    pub samples: usize,
    /// Checkpoints, and whether to go on from one.
    pub choices: &'a Choices,
    /// Who may ask the program to end.
    pub signals: &'a Signals,
}

/// Where a run begins.
#[derive(Debug)]
pub enum Start<O, F> {
    /// At its beginning: there is no checkpoint, or none is asked for.
    Anew,
    /// At a checkpoint.
    From(Box<Resumable<O>>),
    /// It has ended already; this was the result.
    Ended(F),
}

/// A run between its beginning and its end.
#[derive(Debug)]
pub struct Resumable<O> {
    /// The simulation.
    pub simulation: Simulation,
    /// What watches it.
    pub observers: O,
    /// The files that grow with it.
    pub files: Growing,
    samples: usize,
    clock: ThreadTime,
    /// Processor time before the present process (seconds).
    seconds_before: f64,
    /// When the last checkpoint was written.
    saved: Option<WallTime>,
    saved_near_end: bool,
    /// How long the files are at the last checkpoint.
    kept: SharedKept,
}

/// A checkpoint that the run can go on from.
#[derive(Debug)]
pub struct Found {
    head: Head,
    body: Body,
}

impl Found {
    /// Whether the run has ended, and at this time.
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
    samples: usize,
}

#[derive(Debug, Serialize, Deserialize)]
struct State<O> {
    simulation: Checkpoint,
    observers: O,
    seconds: f64,
    files: Vec<Length>,
}

/// What is run, in words that a checkpoint can be recognised by: a scene without its end.
pub fn without_end(command: &str, scene: &Scene) -> String {
    let mut endless = scene.clone();
    endless.run.until = 0.0;
    format!("{command}\n{}", endless.to_toml())
}

impl Task<'_> {
    /// Looks for a checkpoint, if one is to be gone on with; nothing is written. `None` if there is none, as in a run that
    /// was killed before its first.
    ///
    /// # Errors
    /// It cannot be read, is of another run, or lies beyond the end.
    pub fn find(&self) -> Result<Option<Found>> {
        if !self.choices.resumption.resume {
            return Ok(None);
        }
        let path = self.path();
        match Body::read(&path) {
            Err(FileError::Unreadable(error)) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error.into()),
            Ok(body) => self.accept(body).map(Some),
        }
        .with_context(|| format!("cannot resume from {}", path.display()))
    }

    fn accept(&self, mut body: Body) -> Result<Found> {
        let head: Head = body.take()?;
        refuse_other(&head.what, &self.what)?;
        ensure!(
            !head.ended || self.until >= head.until,
            "the run has been run until {}; it can be extended, but not made shorter: --until {0}",
            head.until
        );
        ensure!(
            head.samples < self.samples && head.time <= EpochTime::from(self.until),
            "the run has come to {}, so that it cannot end at {}",
            head.time,
            self.until
        );
        Ok(Found { head, body })
    }

    /// Begins where the checkpoint tells.
    ///
    /// # Errors
    /// The program has been asked to end; what is found does not fit this program, or the files beside it.
    pub fn start<O: Serialize + DeserializeOwned, F: DeserializeOwned>(
        &self,
        found: Option<Found>,
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
        self.go_on(found).with_context(|| format!("cannot resume from {}", path.display()))
    }

    fn go_on<O: Serialize + DeserializeOwned, F: DeserializeOwned>(
        &self,
        found: Found,
    ) -> Result<Start<O, F>> {
        let ended = found.has_ended(self.until);
        let Found { head, mut body } = found;
        let state: State<O> = body.take()?;
        if ended {
            return Ok(Start::Ended(body.take()?));
        }
        let simulation = Simulation::resume(&state.simulation)?;
        if head.ended {
            // From here on it has not: its result is no longer what the files will say.
            self.write(head.samples, &state)?;
        }
        let kept = self.share(Some(state.files.clone()));
        Ok(Start::From(Box::new(Resumable {
            simulation,
            observers: state.observers,
            files: Growing::resume(self.folder, &state.files)?,
            samples: head.samples,
            clock: ThreadTime::now(),
            seconds_before: state.seconds,
            saved: Some(WallTime::now()),
            saved_near_end: self.is_nearly_done(head.time),
            kept,
        })))
    }

    /// Lets the files be cut back to the last checkpoint, at which they are so long, where the
    /// program must end between two.
    fn share(&self, lengths: Option<Vec<Length>>) -> SharedKept {
        let mut kept = Kept::nothing(self.folder);
        kept.set(lengths);
        let kept = Arc::new(Mutex::new(kept));
        self.signals.register(Arc::clone(&kept));
        kept
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join(CHECKPOINT)
    }

    /// Writes the checkpoint of a run that has not ended.
    fn write<O: Serialize>(&self, samples: usize, state: &State<O>) -> Result<()> {
        let time = state.simulation.time();
        let head = Head { what: self.what.clone(), until: self.until, ended: false, time, samples };
        checkpoint_file::write(
            &self.path(),
            &[&checkpoint_file::encode(&head)?, &checkpoint_file::encode(state)?],
        )
    }

    fn is_nearly_done(&self, time: EpochTime) -> bool {
        time.to_f64() >= NEARLY_DONE * self.until
    }
}

/// Refuses a checkpoint of another run, and names the first thing in which they differ.
///
/// # Errors
/// They differ.
pub fn refuse_other(there: &str, here: &str) -> Result<()> {
    if there == here {
        return Ok(());
    }
    let mut pairs = there.lines().zip(here.lines());
    match pairs.find(|(there, here)| there != here) {
        Some((there, here)) => bail!("it is of another run: there it says `{there}`, here `{here}`"),
        None => bail!("it is of another run: one of the two has more in it than the other"),
    }
}

impl<O: Observer + Serialize> Resumable<O> {
    /// A run that has not begun yet.
    pub fn begin(task: &Task<'_>, simulation: Simulation, observers: O) -> Self {
        Self {
            simulation,
            observers,
            files: Growing::begin(task.folder),
            samples: 0,
            clock: ThreadTime::now(),
            seconds_before: 0.0,
            saved: None,
            saved_near_end: false,
            kept: task.share(None),
        }
    }

    /// Runs to the next sample, and leaves checkpoints on the way.
    ///
    /// # Errors
    /// The run cannot go on, a checkpoint cannot be written, or the program has been asked to end and there is one.
    pub fn run_to(&mut self, time: f64, task: &Task<'_>) -> Result<()> {
        let until = EpochTime::from(time);
        if self.saved.is_none() {
            self.save(task)?;
        }
        while !self.simulation.observe_epoch(until, &mut self.observers)? {
            let asked_to_end = task.signals.check();
            let near_end = task.is_nearly_done(self.simulation.time());
            let timely = self.saved.is_none_or(|saved| saved.elapsed() >= task.choices.checkpoint_every);
            if timely || asked_to_end.is_err() || (near_end && !self.saved_near_end) {
                self.save(task)?;
                self.saved_near_end |= near_end;
            }
            asked_to_end?;
        }
        Ok(())
    }

    /// The simulation has come to a sample_interval: the observers are told.
    pub fn stand_by(&mut self) {
        self.observers.sample(&self.simulation.view());
        self.samples += 1;
    }

    /// How many samples there were.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Processor time spent so far, by earlier processes too, as far as their checkpoints know (seconds).
    pub fn seconds(&self) -> f64 {
        self.seconds_before + self.clock.elapsed().as_secs_f64()
    }

    /// Keeps the result of a run that has ended.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn end<F: Serialize>(mut self, task: &Task<'_>, result: &F) -> Result<()> {
        self.files.lengths()?;
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        // From here on the files are longer than at the checkpoint, and stay so.
        kept.set(None);
        let mut body = Body::read(&task.path())?;
        let head = Head { ended: true, until: task.until, ..body.take()? };
        checkpoint_file::write(
            &task.path(),
            &[&checkpoint_file::encode(&head)?, body.rest(), &checkpoint_file::encode(result)?],
        )
    }

    /// Writes a checkpoint, if an epoch has ended.
    fn save(&mut self, task: &Task<'_>) -> Result<()> {
        let Some(simulation) = self.simulation.checkpoint() else { return Ok(()) };
        let files = self.files.lengths()?;
        let state = State { simulation, observers: &self.observers, seconds: self.seconds(), files };
        // Locked, so that files are not cut back to an older checkpoint than the one on the disk.
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        task.write(self.samples, &state)?;
        kept.set(Some(state.files));
        drop(kept);
        self.saved = Some(WallTime::now());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checkpoint_file::{FORMAT, encode};
    use carom::{
        CollisionRate, DirectionHistogram, EnergyLedger, OverlapCheck, Pressure, RunningAverage,
        observers::ImpulseLog,
    };

    /// What is kept of a tee that has not moved yet. If this fails, what is in a checkpoint has changed, and older ones would
    /// be misread: FORMAT must go up, and the numbers found be put here.
    #[test]
    fn what_is_kept_changes_with_the_format_only() {
        let scene = Scene::from_toml(
            "[[molecule]]\ntags = [\"tee\"]\nshape = \"tee\"\natom_radius = 0.0625\natom_mass = 1.0\nat = [0.5, 0.5]\n\
             velocity = [1.0, 0.0]\n[[bumper]]\nradius = 0.0625\nat = [0.125, 0.125]\n\
             [[elasticity.pair]]\nbetween = [\"tee\"]\ncoefficient = 0.5\n",
        )
        .unwrap();
        let simulation = Simulation::new(&scene).unwrap();
        let view = simulation.view();
        let tee = view.bodies().next().unwrap().body.key();
        let mut observers = (
            (EnergyLedger::default(), OverlapCheck::default(), CollisionRate::default(), Pressure::default()),
            (DirectionHistogram::new(tee, 4), RunningAverage::new(tee), ImpulseLog::new(tee, 100)),
        );
        observers.start(&view);
        observers.sample(&view);
        let head =
            Head { what: "run".to_owned(), until: 1.0, ended: false, time: EpochTime::ZERO, samples: 0 };
        let simulation = simulation.checkpoint().unwrap();
        let kept = encode(&(head, State { simulation, observers, seconds: 0.5, files: Vec::new() })).unwrap();
        assert_eq!((FORMAT, kept.len(), crc32fast::hash(&kept)), (4, 831, 2_239_407_009));
    }
}
