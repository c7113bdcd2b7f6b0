//! Times, replays, reversals and measures of all settings in one scene.

use std::time::Instant;

use anyhow::{Context, Result};
use carom::Scene;
use carom_methods::Method;
use carom_runs::{
    price::{
        CourseState, ReplayLog, ReplayTally, Setting, TimedRun, add, contacts, interval, time,
    },
    progress::Progress,
};
use rayon::prelude::*;

use super::{
    effective_error,
    knobs::{self, Knob, LeftOutKnob},
    physics::{self, Physics},
    plan::{TradePlan, from_now},
    results::{KnobResult, SceneResult},
    states::Chaos,
};

/// A setting that takes this many times its share of the time is not continued with slower ones.
const TOO_SLOW: f64 = 4.0;

/// The first replay of a setting may take this many times its share of the time.
const FIRST: f64 = 3.0;

/// In turns shorter than this (mean times between two collisions of a body) the start of an epoch
/// has less than its share.
const SHORT_TURN: f64 = 32.0;

/// A scene with the states from which its settings start.
#[derive(Debug)]
pub struct Prepared<'a> {
    /// Name of the scene.
    pub name: String,
    /// The scene.
    pub scene: &'a Scene,
    /// States of the exact run.
    pub states: Vec<CourseState>,
    /// End of the run (time), or infinite.
    pub end: f64,
    /// When the time allowed has passed: what has not begun then is left out.
    pub deadline: Instant,
    /// How errors grow.
    pub chaos: Chaos,
    /// What could not be reached in the time allowed.
    pub notes: Vec<String>,
}

impl Prepared<'_> {
    /// The settings of this scene: the exact run, then the scene's own method, then all knobs.
    ///
    /// # Errors
    /// The first state cannot be resumed.
    pub fn knobs(&self) -> Result<(Vec<Knob>, Vec<LeftOutKnob>)> {
        let first = self
            .states
            .first()
            .context("the run has no state to start from")?;
        let simulation = Setting::default().resume(first.checkpoint())?;
        let (mut knobs, left_out) = knobs::knobs(&simulation.view());
        let own = Method::try_from(&self.scene.method).context("[method]")?;
        knobs.splice(1..1, knobs::of_scene(own));
        Ok((knobs, left_out))
    }
}

/// The price of all settings in a scene. The progress is that of twice as many steps as settings.
///
/// # Errors
/// The exact run fails.
pub fn of_scene(given: Prepared<'_>, plan: &TradePlan, progress: &Progress) -> Result<SceneResult> {
    let (knobs, left_out) = given.knobs()?;
    let first = &given.states[0];
    let simulation = Setting::default().resume(first.checkpoint())?;
    let moving = simulation
        .view()
        .bodies()
        .filter(|body| body.body.is_free())
        .count();
    let mut found: Vec<KnobResult> = knobs.into_iter().map(KnobResult::new).collect();
    let (nanoseconds, turn) = times(&given, plan, &mut found, progress)?;
    let exact = exact_logs(&given, plan)?;
    let duration = physics_duration(&given, plan);
    let suited = physics::suited(given.scene, duration);
    found.par_iter_mut().try_for_each(|found| {
        compare(&given, &exact, (&suited, duration), plan, found)?;
        progress.count(1);
        anyhow::Ok(())
    })?;
    let mut notes = given.notes;
    if turn < SHORT_TURN {
        notes.push(format!(
            "a turn of the timing lasts {turn:.2} τ only: the times hold little of the cost of starting epochs"
        ));
    }
    let (judged, states) = (found[0].tally.intervals as usize, given.states.len());
    if judged < states {
        notes.push(format!(
            "{judged} of {states} states were replayed in the time allowed"
        ));
    }
    let times = given.states.iter().map(CourseState::time);
    let span = times.fold([f64::INFINITY, 0.0], |[low, high], time| {
        [time.min(low), time.max(high)]
    });
    Ok(SceneResult {
        name: given.name,
        moving,
        nanoseconds,
        rate: given.chaos.rate,
        stretch: given.chaos.stretch,
        tau: first.tau,
        span,
        states,
        irreversible: given.chaos.irreversible,
        left_out,
        notes,
        found,
    })
}

/// Times all settings in turn against the exact run; returns the processor time of one of its
/// collisions (nanoseconds), and the length of its turns (τ).
fn times(
    given: &Prepared<'_>,
    plan: &TradePlan,
    found: &mut [KnobResult],
    progress: &Progress,
) -> Result<(f64, f64)> {
    let first = &given.states[0];
    let mut exact = TimedRun::new(
        given.scene,
        Setting::default(),
        first,
        given.end,
        &plan.timing(),
    )?;
    let turn = exact.turn(from_now(plan.timing_seconds))?;
    let nanoseconds = 1e9 * turn.seconds / turn.collisions.max(1) as f64;
    // Family, and time that its last setting took (seconds).
    let mut last: Option<(usize, f64)> = None;
    for found in found {
        let family = found.knob.family;
        let predicted = found.knob.slower.zip(last.filter(|last| last.0 == family));
        let predicted = predicted.map(|(slower, (_, seconds))| slower * seconds);
        if let Some(seconds) = predicted.filter(|&seconds| seconds > TOO_SLOW * plan.timing_seconds)
        {
            found.is_skipped = true;
            found.notes.push(format!(
                "left out: its times alone would take about {seconds:.1} s"
            ));
            last = Some((family, seconds));
            continue;
        }
        let clock = Instant::now();
        match time(&mut exact, found.knob.setting, &plan.timing()) {
            Ok(Some(time)) => found.time = Some(time),
            Ok(None) => {
                let seconds = plan.timing_seconds;
                found.notes.push(format!(
                    "not timed: no round ends in {seconds:.1} s, on a machine as busy as this"
                ));
            }
            Err(error) => found.notes.push(format!("its timing fails: {error:#}")),
        }
        last = Some((family, clock.elapsed().as_secs_f64()));
        progress.count(1);
    }
    Ok((nanoseconds, exact.length()))
}

/// Replays, reverses and measures a setting, as far as the time allowed reaches.
fn compare(
    given: &Prepared<'_>,
    exact: &[Option<ReplayLog>],
    (suited, duration): (&Scene, f64),
    plan: &TradePlan,
    found: &mut KnobResult,
) -> Result<()> {
    let is_late = || Instant::now() >= given.deadline;
    if !found.is_skipped && !is_late() {
        replays(given, exact, plan, found);
        if !is_late() {
            reversals(given, plan, found);
        }
        if !is_late() {
            let first = &given.states[0];
            found.physics = measures(suited, first, duration, plan, found)?;
        }
    }
    if !found.is_skipped && is_late() && !found.physics.is_measured() {
        found.notes.push("the time allowed has passed".to_owned());
    }
    Ok(())
}

/// The exact contacts from all states, as far as the time reaches.
fn exact_logs(given: &Prepared<'_>, plan: &TradePlan) -> Result<Vec<Option<ReplayLog>>> {
    let deadline = from_now(2.0 * plan.replay_seconds);
    let log = |(index, state): (usize, &CourseState)| {
        if index > 0 && Instant::now() >= deadline {
            return Ok(None);
        }
        // The first one is needed.
        let deadline = if index == 0 {
            from_now(FIRST * plan.replay_seconds)
        } else {
            deadline
        };
        interval(
            given.scene,
            &Setting::default(),
            state,
            replay_length(given, state),
            deadline,
        )
    };
    given.states.par_iter().enumerate().map(log).collect()
}

/// Length of a replay (time), which ends with the run.
fn replay_length(given: &Prepared<'_>, state: &CourseState) -> f64 {
    (given.chaos.stretch * state.tau)
        .min(given.end - state.time())
        .max(0.0)
}

/// Replays a setting from all states, or from as many as fit into its time. A replay that fails is
/// not counted.
fn replays(
    given: &Prepared<'_>,
    exact: &[Option<ReplayLog>],
    plan: &TradePlan,
    found: &mut KnobResult,
) {
    let deadline = from_now(plan.replay_seconds);
    let mut tally = ReplayTally::default();
    let mut failed = 0;
    for (state, exact) in given.states.iter().zip(exact) {
        let Some(exact) = exact else { continue };
        if tally.intervals > 0 && Instant::now() >= deadline {
            break;
        }
        let length = replay_length(given, state);
        let limit = if tally.intervals == 0 {
            from_now(FIRST * plan.replay_seconds)
        } else {
            deadline
        };
        match interval(given.scene, &found.knob.setting, state, length, limit) {
            Ok(Some(log)) => add(exact, &log, length, state.tau, &mut tally),
            Ok(None) => break,
            Err(_) => failed += 1,
        }
    }
    if failed > 0 {
        found.notes.push(format!("{failed} replays failed"));
    }
    let requested = exact.iter().flatten().count() as u64;
    if tally.intervals == 0 && failed == 0 {
        let seconds = plan.replay_seconds;
        found.notes.push(format!(
            "no replay of {:.2} τ ends in {seconds:.1} s",
            given.chaos.stretch
        ));
    } else if tally.intervals + failed < requested {
        found.notes.push(format!(
            "{} of {requested} states replayed",
            tally.intervals
        ));
    }
    found.tally = tally;
}

/// The effective error, where runs can be reversed and the setting is not another model.
fn reversals(given: &Prepared<'_>, plan: &TradePlan, found: &mut KnobResult) {
    if given.chaos.irreversible.is_some() || found.knob.is_model() || found.tally.intervals == 0 {
        return;
    }
    let deadline = from_now(plan.reversal_seconds);
    let returned = effective_error::returns(&found.knob.setting, &given.states, deadline);
    match returned {
        Ok(returned) => found.effective = returned.effective_error(given.chaos.rate),
        Err(error) => found.notes.push(format!("its reversal fails: {error:#}")),
    }
}

/// Length of the measures (time), which end with the run.
fn physics_duration(given: &Prepared<'_>, plan: &TradePlan) -> f64 {
    let first = &given.states[0];
    (plan.physics * first.tau).min(given.end - first.time())
}

/// The scene's own measures with a setting. A setting that is slower than the exact run is measured
/// for a shorter time.
fn measures(
    suited: &Scene,
    first: &CourseState,
    duration: f64,
    plan: &TradePlan,
    found: &mut KnobResult,
) -> Result<Physics> {
    if found.tally.intervals == 0 {
        found
            .notes
            .push("not measured: it takes too long".to_owned());
        return Ok(Physics::default());
    }
    let deadline = from_now(plan.physics_seconds);
    let mut physics = physics::measure(suited, &found.knob.setting, first, duration, deadline)?;
    let shorter = physics.span[1] - physics.span[0];
    if physics.is_measured() && shorter < duration - suited.run.sample_interval {
        // In a system that changes, means over different times differ.
        let limit = from_now(FIRST * plan.physics_seconds);
        let exact = physics::measure(suited, &Setting::default(), first, shorter, limit)?;
        physics.reference = Some(Box::new(exact));
    }
    if let Some(error) = &physics.broke_off {
        found.notes.push(format!("the run fails: {error}"));
    }
    Ok(physics)
}

/// Time of the exact run to resume from a state and to predict all bodies (seconds).
///
/// # Errors
/// The state cannot be resumed.
pub fn resume_seconds(scene: &Scene, state: &CourseState) -> Result<f64> {
    let clock = Instant::now();
    let mut course = carom_runs::price::Course::resume(scene, &Setting::default(), state)?;
    course.run_to(state.time() + 1e-6 * state.tau, &mut (), from_now(60.0))?;
    let _ = contacts(course.simulation());
    Ok(clock.elapsed().as_secs_f64())
}
