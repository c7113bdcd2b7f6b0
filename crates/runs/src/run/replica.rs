//! One replica of a scene in a campaign: a run of which only the sums are kept.
//!
//! It makes the contacts of `carom run` with the same seed and replica, to the bit, and writes
//! neither series nor pictures. A checkpoint is written only if it takes longer than the interval
//! between two of them, or at a signal.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use carom::{Scene, engine::Growth};
use carom_methods::Method;

use super::{
    outcome::outcome_of,
    placement::{self, BodyPlacement},
    scene_file, start,
    steps::{self, Output},
};
use crate::{
    console::note,
    interruption::Signals,
    measures::{self, IMPULSES, Measures, Span},
    output::{Folder, Resumption},
    progress::Progress,
    record::Record,
    resumable::{Choices, Resumable, Start, Task, without_end},
    sampling_times::sampling_times,
};

/// A replica to run.
#[derive(Debug)]
pub struct ReplicaRun<'a> {
    /// The scene with seed and number of the replica.
    pub scene: &'a Scene,
    /// Folder of its checkpoint alone; a checkpoint in it is continued.
    pub folder: &'a Folder,
    /// Time between two checkpoints.
    pub checkpoint_every: Duration,
    /// Signals that end the program.
    pub signals: &'a Signals,
    /// Progress in simulated time, which several replicas may share.
    pub progress: &'a Progress,
}

/// What is kept of a replica that has ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Finished {
    /// Its sums, tables and figures; they do not depend on interruptions.
    pub record: Record,
    /// Processor time of its run phase (seconds).
    pub seconds: f64,
}

/// Validates a scene of which only sums are kept.
///
/// # Errors
/// An entry of the scene is invalid, or a measure writes every contact to a file.
pub fn check(scene: &Scene) -> Result<()> {
    scene_file::validate(scene)?;
    Method::try_from(&scene.method).context("[method]")?;
    for request in measures::requests(scene)? {
        let is_log = request.kind.span == Span::EveryContact || request.kind.name == IMPULSES;
        ensure!(
            !is_log,
            "{}: it writes contacts to a file, but only sums are kept of a replica; use `carom run` for it",
            request.entry
        );
    }
    Ok(())
}

impl ReplicaRun<'_> {
    /// Runs the replica to its end, from its checkpoint if there is one.
    ///
    /// # Errors
    /// The scene is invalid, the run fails, a checkpoint cannot be written, or a signal has been
    /// received.
    pub fn run(&self) -> Result<Finished> {
        let Self {
            scene,
            folder,
            checkpoint_every,
            signals,
            progress,
        } = *self;
        let method = Method::try_from(&scene.method).context("[method]")?;
        let resumption = Resumption {
            resume: true,
            ..Resumption::default()
        };
        let choices = Choices {
            resumption,
            checkpoint_every,
        };
        let task = Task {
            folder,
            what: without_end("sweep", scene),
            until: scene.run.until,
            samples: sampling_times(0.0, scene.run.until, scene.run.sample_interval).count(),
            method,
            threads: 1,
            choices: &choices,
            signals,
        };
        let started = task
            .find()
            .and_then(|found| task.start::<Measures, ()>(found));
        let mut going = match started {
            Ok(Start::From(going)) => *going,
            Ok(Start::Anew | Start::Ended(())) => self.start(&task)?,
            Err(error) => {
                signals.check()?;
                note(&format!("{error:#}; this replica starts anew"));
                self.start(&task)?
            }
        };
        let begun = going.simulation.time().to_f64();
        progress.skip(begun);
        steps::proceed(&mut going, &task, scene, Output::Nothing, progress)?;
        going.observers.finish(&going.simulation.view());
        let (view, seconds) = (going.simulation.view(), going.seconds());
        progress.skip(scene.run.until - view.time().to_f64());
        let outcome = outcome_of(&view, &going.observers, seconds, scene);
        Ok(Finished {
            record: outcome.record(scene, &task.method),
            seconds,
        })
    }

    /// Places the bodies and takes the first sample.
    fn start(&self, task: &Task<'_>) -> Result<Resumable<Measures>> {
        let Self { scene, folder, .. } = *self;
        let mut store = |growth: &Growth| placement::store(growth, &task.what, folder.path());
        let placement = BodyPlacement::new(
            &task.method,
            self.signals,
            self.checkpoint_every,
            &mut store,
        );
        let simulation = match placement::stored(&task.what, folder.path()) {
            Ok(Some(growth)) => placement.resume(growth)?,
            // A damaged growth starts anew.
            Ok(None) | Err(_) => placement.place(scene)?,
        };
        let (simulation, measures, actions) = start(simulation, scene, 0)?;
        let mut going = Resumable::new(task, simulation, measures);
        going.actions = actions;
        steps::take_first(&mut going, &scene.run, Output::Nothing)?;
        going.postpone_checkpoint();
        Ok(going)
    }
}
