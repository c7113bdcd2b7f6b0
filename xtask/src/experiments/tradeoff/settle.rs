//! Runs a gas until its start is forgotten, measures the mean time between two collisions of a
//! body, and takes states from there on.

use anyhow::Result;
use carom::{Checkpoint, Scene, kinematics::EpochTime};
use carom_experiments::trade::{
    plan::{Plan, from_now},
    states::{APART, Chaos, chaos},
};
use carom_methods::AnySimulation;
use carom_runs::price::{LONGEST, State};

/// Time until the lattice of the start is forgotten, in mean times between two collisions of a
/// body.
const WARM_UP: f64 = 50.0;

/// Equilibrates the gas; returns the time reached and the mean time between two collisions of a
/// body.
///
/// # Errors
/// The run fails.
pub fn settle(simulation: &mut AnySimulation) -> Result<(f64, f64)> {
    // Γ is unknown at first: an estimate from a short run, then equilibration, then the final
    // value.
    let mut length = 1e-3;
    while simulation.view().counters().collisions < 4 * simulation.view().len() as u64 {
        length *= 2.0;
        simulation.run_until(length)?;
    }
    let guess = tau(simulation, length, 1.5 * length)?;
    let begin = 1.5 * length + WARM_UP * guess;
    let end = begin + 20.0 * guess;
    Ok((end, tau(simulation, begin, end)?))
}

/// Mean time between two collisions of a body, measured from one time to another.
///
/// # Errors
/// The run breaks off.
pub fn tau(simulation: &mut AnySimulation, from: f64, to: f64) -> Result<f64> {
    simulation.run_until(from)?;
    let before = simulation.view().counters().collisions;
    simulation.run_until(to)?;
    let view = simulation.view();
    let moving = view.bodies().filter(|view| !view.body.is_fixed()).count();
    let collisions = (view.counters().collisions - before).max(1);
    Ok((to - from) * moving as f64 / (2.0 * collisions as f64))
}

/// States of the exact run at ends of its epochs, at least so many, 5 τ apart, and how errors grow
/// from them. Shorter replays start from more states, so that the number of contacts is the same.
///
/// # Errors
/// A run fails.
pub fn states(scene: &Scene, simulation: &mut AnySimulation, plan: &Plan) -> Result<(Vec<State>, Chaos)> {
    let (first, tau) = settle(simulation)?;
    let mut state = |index: usize| {
        let checkpoint = state_at(simulation, first + index as f64 * APART * tau)?;
        Ok(State::undisturbed(checkpoint, tau))
    };
    let mut states = (0..plan.states).map(&mut state).collect::<Result<Vec<_>>>()?;
    let chaos = chaos(scene, &states, from_now(plan.reversal_seconds))?;
    let more = (plan.states as f64 * LONGEST / chaos.stretch).ceil() as usize;
    states.extend((plan.states..more).map(&mut state).collect::<Result<Vec<_>>>()?);
    Ok((states, chaos))
}

/// Continues the exact run to a state from which every setting can start.
fn state_at(simulation: &mut AnySimulation, time: f64) -> Result<Checkpoint> {
    while !simulation.observe_epoch(EpochTime::from(time), &mut ())? {}
    // The end of the epoch follows after a bounded number of contacts.
    loop {
        if let Some(state) = simulation.checkpoint() {
            return Ok(state);
        }
        simulation.observe_epoch(EpochTime::from(2.0 * time + 1e6), &mut ())?;
    }
}
