//! Accuracy of a whole run by time reversal: forward, all velocities reversed, and back; the
//! distance from the initial state is measured.

use anyhow::Result;
use carom_methods::AnySimulation;
use carom_testkit::extremes::{
    Engine,
    engine::{gas, in_box},
    watch::run_collisions,
};
use rayon::prelude::*;

use carom_experiments::time_reversal::{MAX_DISTANCE, line, loschmidt_echo};

/// Number of discs.
const COUNT: usize = 64;

/// Result at one density.
#[derive(Debug, Clone)]
pub struct Reversal {
    /// Name of the engine.
    pub engine: &'static str,
    /// Area fraction of the discs.
    pub fraction: f64,
    /// Collisions of each disc on the way forward, and the distance from the initial state after
    /// the way back (box sides): the largest of any disc, geometric mean over the starts.
    pub points: Vec<(f64, f64)>,
    /// Effective error d₀ in units of ε × side.
    pub effective_error: f64,
    /// Growth rate κ: e-foldings for each collision of a disc.
    pub rate: f64,
}

/// The densities, each with its e-foldings for each collision of a disc: λ₁/Γ, measured by the
/// two-trajectory method for 64 discs.
pub const DENSITIES: [(f64, f64); 5] = [
    (0.02, 6.40),
    (0.1, 2.68),
    (0.3, 1.16),
    (0.5, 0.647),
    (0.6, 0.469),
];

/// Measures at all densities.
///
/// # Errors
/// A run fails.
pub fn reversals(engine: Engine, starts: usize) -> Result<Vec<Reversal>> {
    DENSITIES
        .par_iter()
        .map(|&(fraction, rate)| reversal(engine, fraction, rate, starts))
        .collect()
}

fn reversal(engine: Engine, fraction: f64, expected: f64, starts: usize) -> Result<Reversal> {
    // Up to the time at which 1e-15 has grown to about 1e-5.
    let longest = 23.0 / expected;
    let mut points = Vec::new();
    for step in 1..=8 {
        let collisions = longest * f64::from(step) / 8.0;
        let mut logs = Vec::new();
        for seed in 0..starts {
            let (mut run, tau) = start(engine, fraction, seed)?;
            let (forward, distance) = loschmidt_echo(&mut run, collisions * tau)?;
            logs.push((forward, distance.max(1e-18).ln()));
        }
        let mean =
            |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / logs.len() as f64;
        points.push((mean(|log| log.0), mean(|log| log.1).exp()));
    }
    let used: Vec<(f64, f64)> = points
        .iter()
        .filter(|point| point.1 < MAX_DISTANCE)
        .map(|&(n, distance)| (n, distance.ln()))
        .collect();
    let (intercept, rate) = line(&used);
    let effective_error = intercept.exp() / f64::EPSILON;
    Ok(Reversal {
        engine: engine.name(),
        fraction,
        points,
        effective_error,
        rate,
    })
}

/// A gas at equilibrium, and its mean time between two collisions of a disc.
fn start(engine: Engine, fraction: f64, seed: usize) -> Result<(AnySimulation, f64)> {
    let radius = (fraction / (std::f64::consts::PI * COUNT as f64)).sqrt();
    let mut scene = in_box([1.0, 1.0], Vec::new());
    scene.gas = vec![gas("disc", radius, 1.0, COUNT)];
    scene.bounds.replica = seed as u64;
    let mut run = engine.simulate(&scene)?;
    run_collisions(&mut run, 10 * COUNT as u64, &mut (), |_| {})?;
    let tau = run.time().to_f64() * COUNT as f64 / (2.0 * run.view().counters().collisions as f64);
    Ok((run, tau))
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_testkit::extremes::Engine;

    #[test]
    fn the_distance_grows_by_the_lyapunov_law_from_a_few_roundings() {
        let found = reversal(Engine::Default, 0.3, 1.16, 3).unwrap();
        // Agreement with the two-trajectory method within the error of three starts of up to 20
        // collisions each.
        assert!((found.rate / 1.16 - 1.0).abs() < 0.3, "{found:?}");
        assert!((0.01..100.0).contains(&found.effective_error), "{found:?}");
    }
}
