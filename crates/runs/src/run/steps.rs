//! The steps of a run in the order of its schedule: samples, snapshots, checks, stages, and actions
//! of thermostats.

use std::time::Duration;

use anyhow::Result;
use carom::{EpochTime, Observer as _, Scene, engine::RunSpec, observers::write_extended_xyz};
use carom_methods::AnySimulation;

use super::{state_table::StateTable, stop};
use crate::schedule::{Schedule, ScheduledStep, What, pieces::Pieces, stage_edits};
use crate::{
    animation,
    clock::Instant,
    file_names::TRAJECTORY,
    interruption::Signals,
    measures::Measures,
    progress::Progress,
    resumable::{Resumable, Task},
};

/// The first piece of a run between two looks at its progress, as a share of the run.
const FIRST_PIECE: f64 = 1.0 / 64.0;

/// Progress is shown about as often as this. More often: each look costs the time to store all
/// motions.
const PIECE: Duration = Duration::from_secs(1);

/// What a run writes besides checkpoints while it continues.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Output {
    /// Series, snapshots and the animation.
    Files,
    /// Nothing: only its sums are requested.
    Nothing,
}

/// Takes all steps of the run that remain, up to that at which it ends.
pub(super) fn proceed(
    going: &mut Resumable<Measures>,
    task: &Task<'_>,
    scene: &Scene,
    output: Output,
    progress: &Progress,
) -> Result<()> {
    let run = &scene.run;
    let mut pace = Pace {
        progress,
        pieces: Pieces::with_first(FIRST_PIECE * run.until, PIECE),
    };
    // A run killed before its first checkpoint after this point records the animation again.
    let begun = going.simulation.time().to_f64();
    let is_shown = output == Output::Files && run.animation && begun <= run.animation_from;
    let mut animation_from = is_shown.then_some(run.animation_from);
    let mut table = (output == Output::Files).then(|| StateTable::new(begun, run.until));
    for ScheduledStep { time, what } in Schedule::new(scene).skip(going.steps()) {
        if let Some(from) = animation_from.take_if(|from| *from < time) {
            // A run split in two makes the same contacts, to the bit.
            if going.simulation.time().to_f64() < from {
                pace.run_to(going, from, task)?;
            }
            animation::record(&going.simulation, task.folder)?;
        }
        pace.run_to(going, time, task)?;
        take(going, task, scene, what, output)?;
        if what == What::Sample
            && let Some(table) = &mut table
        {
            table.sample(&going.simulation.view(), &going.observers);
        }
        let is_last = what == What::Sample
            && stop::is_met(scene, &going.simulation.view(), &going.observers)?
            && time < run.until;
        if is_last {
            if animation_from.is_some() {
                animation::record(&going.simulation, task.folder)?;
            }
            return end_early(going, run, output);
        }
    }
    Ok(())
}

/// What happens at the end of a run, at a sample before that end.
fn end_early(going: &mut Resumable<Measures>, run: &RunSpec, output: Output) -> Result<()> {
    if run.snapshot_interval.is_some() && output == Output::Files {
        append_frame(going)?;
    }
    if run.check_interval.is_some() {
        going.observers.check(&going.simulation.view());
    }
    Ok(())
}

/// The progress of a run, shown about every second: a run split in two makes the same contacts, to
/// the bit.
struct Pace<'a> {
    progress: &'a Progress,
    pieces: Pieces,
}

impl Pace<'_> {
    fn run_to(
        &mut self,
        going: &mut Resumable<Measures>,
        time: f64,
        task: &Task<'_>,
    ) -> Result<()> {
        let now = |going: &Resumable<Measures>| {
            (
                going.simulation.time().to_f64(),
                going.simulation.view().counters().collisions,
            )
        };
        let mut before = now(going);
        // A piece shorter than a window of tiles would cut it.
        let length = |pace: &Self, going: &Resumable<Measures>| {
            pace.pieces.length().max(going.simulation.window_length())
        };
        while time - before.0 > 2.0 * length(self, going) {
            let clock = Instant::now();
            going.run_to_and(
                before.0 + length(self, going),
                task,
                Measures::append_contacts,
            )?;
            let after = now(going);
            self.progress
                .advance(after.0 - before.0, after.1 - before.1);
            before = after;
            self.pieces.has_taken(clock.elapsed());
        }
        going.run_to_and(time, task, Measures::append_contacts)?;
        self.progress
            .advance(time - before.0, now(going).1 - before.1);
        Ok(())
    }
}

/// Takes all steps of a run in memory, which writes nothing.
///
/// # Errors
/// The run fails, an edit is refused, or a signal has been received.
pub(super) fn take_all(
    simulation: &mut AnySimulation,
    measures: &mut Measures,
    scene: &Scene,
    mut actions: u64,
    signals: &Signals,
) -> Result<()> {
    for ScheduledStep { time, what } in Schedule::new(scene) {
        signals.check()?;
        while !simulation.observe_epoch(EpochTime::from(time), measures)? {
            signals.check()?;
        }
        match what {
            What::Sample => {
                measures.sample(&simulation.view());
                measures.start_anew_unless_settled(scene, &simulation.view())?;
            }
            What::Check => measures.check(&simulation.view()),
            What::Snapshot => (),
            What::Stage(_) | What::Thermostat { .. } => {
                measures.pause(&simulation.view());
                actions += stage_edits::change(simulation, scene, what, actions)?;
                measures.start(&simulation.view());
            }
        }
        if what == What::Sample && stop::is_met(scene, &simulation.view(), measures)? {
            if scene.run.check_interval.is_some() && time < scene.run.until {
                measures.check(&simulation.view());
            }
            return Ok(());
        }
    }
    Ok(())
}

/// Takes one step of the schedule at the present time.
fn take(
    going: &mut Resumable<Measures>,
    task: &Task<'_>,
    scene: &Scene,
    what: What,
    output: Output,
) -> Result<()> {
    match what {
        What::Sample => {
            going.sample();
            append_sample(going, &scene.run, output)?;
            return going
                .observers
                .start_anew_unless_settled(scene, &going.simulation.view());
        }
        What::Snapshot if output == Output::Files => append_frame(going)?,
        What::Snapshot => (),
        What::Check => going.observers.check(&going.simulation.view()),
        What::Stage(_) | What::Thermostat { .. } => {
            return going.edit(task, |simulation, actions| {
                stage_edits::change(simulation, scene, what, actions)
            });
        }
    }
    going.pass();
    Ok(())
}

/// Takes the sample at time 0.
pub(super) fn take_first(
    going: &mut Resumable<Measures>,
    run: &RunSpec,
    output: Output,
) -> Result<()> {
    going.observers.start(&going.simulation.view());
    going.observers.sample(&going.simulation.view());
    append_sample(going, run, output)?;
    if run.snapshot_interval.is_some() && output == Output::Files {
        append_frame(going)?;
    }
    going.observers.check(&going.simulation.view());
    Ok(())
}

/// Writes a snapshot.
fn append_frame(going: &mut Resumable<Measures>) -> Result<()> {
    let Resumable {
        simulation, files, ..
    } = going;
    files.append_frame(TRAJECTORY, |out| {
        write_extended_xyz(&simulation.view(), out)
    })
}

/// Writes the data of the last sample: a frame, and a row of each requested series.
fn append_sample(going: &mut Resumable<Measures>, run: &RunSpec, output: Output) -> Result<()> {
    if output == Output::Nothing {
        return Ok(());
    }
    if run.snapshots.is_some() && run.snapshot_interval.is_none() {
        append_frame(going)?;
    }
    going.observers.append(&mut going.files)
}
