//! Runs a gas until its start is forgotten, and measures the mean time between two collisions of a
//! body.

use anyhow::Result;
use carom_methods::AnySimulation;

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
