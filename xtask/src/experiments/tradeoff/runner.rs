//! Simulations with any detector and scheduler as one trait object.

use anyhow::{Result, bail};
use carom::{
    Checkpoint, Detection, HeapScheduler, Impact, Observer, Response, RunError, Scheduler, Simulation, View,
    engine::{CellScheduler, Rotation},
};

use super::{
    epochs::Epochs,
    knobs::{Order, Setting},
};
use crate::experiments::{detectors::AnyDetector, time_reversal::loschmidt_echo};

/// A simulation with any detector and scheduler.
pub trait Runner {
    /// The present state of all bodies.
    fn view(&self) -> View<'_>;
    /// Runs to a time.
    ///
    /// # Errors
    /// The run fails.
    fn run(&mut self, until: f64) -> Result<(), RunError>;
    /// Runs on with an observer. It is called dynamically, so that the loop is compiled once for
    /// all observers; only [`run`](Self::run) is timed.
    ///
    /// # Errors
    /// The run breaks off.
    fn observe(&mut self, until: f64, observer: &mut dyn Observer) -> Result<(), RunError>;
    /// Runs forward for a duration, reverses all velocities, and runs back. Returns the collisions
    /// of each body on the way forward and the largest distance from the initial state.
    ///
    /// # Errors
    /// The run fails.
    fn loschmidt_echo(&mut self, duration: f64) -> Result<(f64, f64)>;
}

impl<D: Detection, R: Response, S: Scheduler> Runner for Simulation<D, R, S> {
    fn view(&self) -> View<'_> {
        self.view()
    }

    fn run(&mut self, until: f64) -> Result<(), RunError> {
        self.run_until(until)
    }

    fn observe(&mut self, until: f64, observer: &mut dyn Observer) -> Result<(), RunError> {
        self.observe_until(until, observer)
    }

    fn loschmidt_echo(&mut self, duration: f64) -> Result<(f64, f64)> {
        loschmidt_echo(self, duration)
    }
}

/// The simulation of a setting, from a state on.
///
/// One knob is turned at a time: another detector than the exact one comes with the cell scheduler,
/// so that other combinations need not be compiled.
///
/// # Errors
/// The bodies do not suit the setting, or it turns two knobs.
pub fn begin(setting: &Setting, state: &Checkpoint) -> Result<Box<dyn Runner>> {
    let widest = carom::Instructions::Widest;
    match (setting.detector, setting.order) {
        (AnyDetector::Exact(exact), Order::CellScheduler(instructions)) => {
            of::<_, CellScheduler>(setting, state, exact, instructions)
        }
        (AnyDetector::Exact(exact), Order::Epochs1) => of::<_, Epochs<1>>(setting, state, exact, widest),
        (AnyDetector::Exact(exact), Order::Epochs8) => of::<_, Epochs<8>>(setting, state, exact, widest),
        (AnyDetector::Exact(exact), Order::Epochs512) => of::<_, Epochs<512>>(setting, state, exact, widest),
        (AnyDetector::Exact(exact), Order::HeapScheduler(cells)) => {
            of::<_, HeapScheduler>(setting, state, exact, cells)
        }
        (detector, Order::CellScheduler(instructions)) => {
            of::<_, CellScheduler>(setting, state, detector, instructions)
        }
        (detector, _) => bail!("{} is compared with the cell scheduler only", detector.name()),
    }
}

fn of<D: Detection + 'static, S: Scheduler + 'static>(
    setting: &Setting,
    state: &Checkpoint,
    detector: D,
    options: S::Options,
) -> Result<Box<dyn Runner>>
where
    S::Options: 'static,
{
    finish(setting, Simulation::<D, Impact, S>::resume_with(state, detector, Impact, options)?)
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
