//! Simulations with any detector and scheduler as one trait object.

use anyhow::Result;
use carom::{
    Checkpoint, Detection, HeapScheduler, Impact, Response, RunError, Scheduler, Simulation, View,
    engine::{CellScheduler, Rotation},
};

use super::{
    epochs::Epochs,
    knobs::{Order, Setting},
    measures::Measures,
    replay::Log,
};
use crate::experiments::{detectors::Detector, time_reversal::there_and_back};

/// A simulation with any detector and scheduler.
pub trait Runner {
    /// The present state of all bodies.
    fn view(&self) -> View<'_>;
    /// Runs to a time.
    ///
    /// # Errors
    /// The run fails.
    fn run(&mut self, until: f64) -> Result<(), RunError>;
    /// Runs to a time with physical measurements.
    ///
    /// # Errors
    /// The run fails.
    fn measure(&mut self, until: f64, measures: &mut Measures) -> Result<(), RunError>;
    /// Runs to a time and records each contact.
    ///
    /// # Errors
    /// The run fails.
    fn log(&mut self, until: f64, log: &mut Log) -> Result<(), RunError>;
    /// Runs forward for a duration, reverses all velocities, and runs back. Returns the collisions
    /// of each body on the way forward and the largest distance from the initial state.
    ///
    /// # Errors
    /// The run fails.
    fn there_and_back(&mut self, duration: f64) -> Result<(f64, f64)>;
}

impl<D: Detection, R: Response, S: Scheduler> Runner for Simulation<D, R, S> {
    fn view(&self) -> View<'_> {
        self.view()
    }

    fn run(&mut self, until: f64) -> Result<(), RunError> {
        self.run_until(until)
    }

    fn measure(&mut self, until: f64, measures: &mut Measures) -> Result<(), RunError> {
        self.observe_until(until, measures)
    }

    fn log(&mut self, until: f64, log: &mut Log) -> Result<(), RunError> {
        self.observe_until(until, log)
    }

    fn there_and_back(&mut self, duration: f64) -> Result<(f64, f64)> {
        there_and_back(self, duration)
    }
}

/// Starts a setting from a state.
///
/// # Errors
/// The setting does not support the bodies.
pub fn begin(setting: &Setting, state: &Checkpoint) -> Result<Box<dyn Runner>> {
    Ok(match setting.order {
        Order::CellScheduler(instructions) => of::<CellScheduler>(setting, state, instructions)?,
        Order::Epochs1 => of::<Epochs<1>>(setting, state, carom::Instructions::Widest)?,
        Order::Epochs8 => of::<Epochs<8>>(setting, state, carom::Instructions::Widest)?,
        Order::Epochs512 => of::<Epochs<512>>(setting, state, carom::Instructions::Widest)?,
        Order::HeapScheduler(cells) => of::<HeapScheduler>(setting, state, cells)?,
    })
}

fn of<S: Scheduler + 'static>(
    setting: &Setting,
    state: &Checkpoint,
    options: S::Options,
) -> Result<Box<dyn Runner>>
where
    S::Options: 'static,
{
    // The exact detector has its own type here, as in normal runs.
    if let Detector::Exact(exact) = setting.detector {
        return finish(setting, Simulation::<_, Impact, S>::resume_with(state, exact, Impact, options)?);
    }
    finish(setting, Simulation::<_, Impact, S>::resume_with(state, setting.detector, Impact, options)?)
}

fn finish<D: Detection + 'static, S: Scheduler + 'static>(
    setting: &Setting,
    mut simulation: Simulation<D, Impact, S>,
) -> Result<Box<dyn Runner>>
where
    S::Options: 'static,
{
    if setting.locked {
        let moving = simulation.view().bodies().filter(|view| !view.body.is_fixed());
        let keys: Vec<_> = moving.map(|view| view.body.key()).collect();
        for key in keys {
            simulation.set_rotation(key, Rotation::Locked)?;
        }
    }
    Ok(Box::new(simulation))
}
