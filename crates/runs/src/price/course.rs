//! The course of a scene: its simulation with the edits and thermostats of its stages, from the
//! start or from any state on the way.

use std::time::Duration;

use anyhow::Result;
use carom::{Checkpoint, EpochTime, Observer, Scene};
use carom_methods::{AnySimulation, Method};

use super::Setting;
use crate::clock::Instant;
use crate::schedule::{Schedule, ScheduledStep, What, pieces::Pieces, stage_edits};

/// A flight is made in pieces of about this processor time, so that a limit of time is kept. The
/// pieces change no bit of the run. Shorter: clocks cost time. Longer: the limit is passed.
const PIECE: Duration = Duration::from_millis(20);

/// A flight begins with this share of its length. Smaller: more pieces. Larger: a slow detector
/// passes its limit in the first one.
const FIRST_PIECE: f64 = 1.0 / 1024.0;

/// A state of the run of a scene, from which any setting can start.
#[derive(Debug, Clone)]
pub struct CourseState {
    checkpoint: Checkpoint,
    rest: Rest,
    /// Mean time between two collisions of a body from here on (time).
    pub tau: f64,
}

impl CourseState {
    /// A state of a system that no stage edits later; `tau` is its mean time between two collisions
    /// of a body (time).
    pub fn undisturbed(checkpoint: Checkpoint, tau: f64) -> Self {
        Self {
            checkpoint,
            rest: Rest::default(),
            tau,
        }
    }

    /// The bodies and their motion.
    pub fn checkpoint(&self) -> &Checkpoint {
        &self.checkpoint
    }

    /// Its time in the run (time).
    pub fn time(&self) -> f64 {
        self.checkpoint.time().to_f64()
    }
}

/// What the schedule of a scene still holds.
#[derive(Debug, Clone, Default)]
struct Rest {
    next: Option<ScheduledStep>,
    later: Option<Schedule>,
    /// Number of draws of random numbers by thermostats so far.
    actions: u64,
}

impl Rest {
    /// The edits and actions after time 0.
    fn new(scene: &Scene, actions: u64) -> Self {
        let mut run = scene.run.clone();
        // Samples and snapshots change nothing.
        run.sample_interval = run.until;
        (run.snapshot_interval, run.check_interval) = (None, None);
        let mut rest = Self {
            next: None,
            later: Some(Schedule::new(&Scene {
                run,
                ..scene.clone()
            })),
            actions,
        };
        rest.advance();
        rest
    }

    fn advance(&mut self) {
        let is_edit =
            |step: &ScheduledStep| matches!(step.what, What::Stage(_) | What::Thermostat { .. });
        self.next = self.later.as_mut().and_then(|later| later.find(is_edit));
    }
}

/// Whether a course has reached its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reached {
    /// It is at the requested time.
    Target,
    /// The time allowed has passed before.
    Deadline,
}

/// A simulation on its way through the schedule of a scene.
#[derive(Debug)]
pub struct Course<'a> {
    scene: &'a Scene,
    simulation: AnySimulation,
    rest: Rest,
}

impl<'a> Course<'a> {
    /// The exact run of a scene at its start, where `simulation` has its bodies.
    ///
    /// # Errors
    /// An edit of a stage is refused.
    pub fn new(scene: &'a Scene, mut simulation: AnySimulation) -> Result<Self> {
        let actions = stage_edits::prepare(&mut simulation, scene, 0)?;
        Ok(Self {
            scene,
            simulation,
            rest: Rest::new(scene, actions),
        })
    }

    /// The run with a setting from a state on.
    ///
    /// # Errors
    /// The bodies do not suit the setting.
    pub fn resume(scene: &'a Scene, setting: &Setting, state: &CourseState) -> Result<Self> {
        let simulation = setting.resume(&state.checkpoint)?;
        Ok(Self {
            scene,
            simulation,
            rest: state.rest.clone(),
        })
    }

    /// The simulation at the present time.
    pub fn simulation(&self) -> &AnySimulation {
        &self.simulation
    }

    /// The present time.
    pub fn time(&self) -> f64 {
        self.simulation.time().to_f64()
    }

    /// Runs to `until`, with the edits before it, and reports each contact.
    ///
    /// # Errors
    /// The run fails, or an edit is refused.
    pub fn run_to(
        &mut self,
        until: f64,
        observer: &mut dyn Observer,
        deadline: Instant,
    ) -> Result<Reached> {
        loop {
            let next = self.rest.next.filter(|step| step.time < until);
            let target = next.map_or(until, |step| step.time);
            if self.fly(target, observer, deadline)? == Reached::Deadline {
                return Ok(Reached::Deadline);
            }
            let Some(ScheduledStep { what, .. }) = next else {
                return Ok(Reached::Target);
            };
            observer.pause(&self.simulation.view());
            let actions = self.rest.actions;
            self.rest.actions +=
                stage_edits::change(&mut self.simulation, self.scene, what, actions)?;
            self.rest.advance();
            observer.start(&self.simulation.view());
        }
    }

    /// Flies to `until` in pieces.
    fn fly(
        &mut self,
        until: f64,
        observer: &mut dyn Observer,
        deadline: Instant,
    ) -> Result<Reached> {
        let mut pieces = Pieces::with_first(FIRST_PIECE * (until - self.time()), PIECE);
        let until = EpochTime::from(until);
        loop {
            let clock = Instant::now();
            let end = pieces.end(self.simulation.time(), until);
            self.simulation.observe_until_epoch_time(end, observer)?;
            if end == until {
                return Ok(Reached::Target);
            }
            if Instant::now() >= deadline {
                return Ok(Reached::Deadline);
            }
            pieces.has_taken(clock.elapsed());
        }
    }

    /// The present state. Ends the epoch: later bits differ, the run remains exact.
    pub fn state(&mut self, tau: f64) -> CourseState {
        CourseState {
            checkpoint: self.simulation.end_epoch_here(),
            rest: self.rest.clone(),
            tau,
        }
    }
}

/// Mean time between two collisions of a moving body over a duration, from the counters of contacts
/// and of contacts with fixed bodies before and after; `None` without a contact.
pub fn mean_time(simulation: &AnySimulation, before: [u64; 2], duration: f64) -> Option<f64> {
    let view = simulation.view();
    let moving = view.bodies().filter(|view| view.body.is_free()).count() as f64;
    let [all, fixed] = contacts(simulation);
    // A contact of two moving bodies counts for both.
    let each = 2 * (all - before[0]) - (fixed - before[1]);
    (each > 0).then(|| duration * moving / each as f64)
}

/// Contacts since the system was built, and those of them with a fixed body.
pub fn contacts(simulation: &AnySimulation) -> [u64; 2] {
    let counters = *simulation.view().counters();
    [counters.collisions, counters.fixed_collisions]
}

/// The simulation of a scene at its start with the exact method, if its gases can be placed before
/// the deadline.
///
/// # Errors
/// The scene cannot be built.
pub fn build(scene: &Scene, deadline: Instant) -> Result<Option<AnySimulation>> {
    use std::ops::ControlFlow;
    let mut watch = |_: &carom::engine::Growth| {
        if Instant::now() < deadline {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    };
    match AnySimulation::with_progress(scene, &Method::default(), &mut watch) {
        Ok(simulation) => Ok(Some(simulation)),
        Err(carom::SceneError::Interrupted) => Ok(None),
        Err(error) => Err(error.into()),
    }
}
