//! How exact a whole run is: forward, all velocities reversed, and back; how far from the start does it end?
//!
//! Errors made on the way forward are undone on the way back, except that chaos multiplies them: the distance is
//! d₀ exp(κ n) after n collisions of each disc, and d₀ is the effective error of the engine.

use anyhow::Result;
use carom::Scene;
use rayon::prelude::*;

use super::cases::{
    Engine,
    engine::{frozen, gas, in_box},
    watch::run_collisions,
};

/// Discs.
const COUNT: usize = 64;

/// Distances beyond this are no longer small against the paths (box sides), and those of no collision no longer law.
const LARGEST: f64 = 1e-3;

/// Result at one density.
#[derive(Debug, Clone)]
pub struct Reversal {
    /// Which engine.
    pub engine: &'static str,
    /// Share of the box covered by discs.
    pub fraction: f64,
    /// Collisions of each disc on the way forward, and the distance from the start after the way back (box sides):
    /// geometric mean over the starts of the largest of any disc.
    pub points: Vec<(f64, f64)>,
    /// d₀ over eps × side.
    pub effective_error: f64,
    /// κ: e-foldings in one collision of each.
    pub rate: f64,
}

/// The densities, each with how many e-foldings there are in one collision of each: λ₁/Γ, measured by the two-trajectory
/// method for 64 discs.
pub const DENSITIES: [(f64, f64); 5] = [(0.02, 6.40), (0.1, 2.68), (0.3, 1.16), (0.5, 0.647), (0.6, 0.469)];

/// Measures at all densities.
///
/// # Errors
/// A run that cannot go on.
pub fn reversals<E: Engine>(starts: usize) -> Result<Vec<Reversal>> {
    DENSITIES.par_iter().map(|&(fraction, rate)| reversal::<E>(fraction, rate, starts)).collect()
}

fn reversal<E: Engine>(fraction: f64, expected: f64, starts: usize) -> Result<Reversal> {
    // Up to where 1e-15 has grown to some 1e-5.
    let longest = 23.0 / expected;
    let mut points = Vec::new();
    for step in 1..=8 {
        let collisions = longest * f64::from(step) / 8.0;
        let mut logs = Vec::new();
        for seed in 0..starts {
            let (forward, distance) = there_and_back::<E>(&start::<E>(fraction, seed)?, collisions)?;
            logs.push((forward, distance.max(1e-18).ln()));
        }
        let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / logs.len() as f64;
        points.push((mean(|log| log.0), mean(|log| log.1).exp()));
    }
    let used: Vec<(f64, f64)> =
        points.iter().filter(|point| point.1 < LARGEST).map(|&(n, distance)| (n, distance.ln())).collect();
    let (intercept, rate) = line(&used);
    let effective_error = intercept.exp() / f64::EPSILON;
    Ok(Reversal { engine: E::NAME, fraction, points, effective_error, rate })
}

/// A gas at equilibrium.
fn start<E: Engine>(fraction: f64, seed: usize) -> Result<Scene> {
    let radius = (fraction / (std::f64::consts::PI * COUNT as f64)).sqrt();
    let mut scene = in_box([1.0, 1.0], Vec::new());
    scene.gas = vec![gas("disc", radius, 1.0, COUNT)];
    scene.bounds.replica = seed as u64;
    let mut run = E::simulate(&scene)?;
    run_collisions::<E, _>(&mut run, 10 * COUNT as u64, &mut (), |_| {})?;
    Ok(frozen(&run.view()))
}

/// Collisions of each disc on the way forward, and the largest distance from the start after the way back (length).
fn there_and_back<E: Engine>(scene: &Scene, collisions: f64) -> Result<(f64, f64)> {
    let mut forward = E::simulate(scene)?;
    let count = (collisions * COUNT as f64 / 2.0).ceil() as u64;
    for _ in 0..count {
        forward.step(1e9, &mut ())?;
    }
    let mut reversed = frozen(&forward.view());
    for molecule in &mut reversed.molecule {
        molecule.velocity = molecule.velocity.map(|v| -v);
        molecule.angular_velocity *= -1.0;
    }
    // On to a time between two collisions: the last one is not to be undone within a rounding of now.
    let mut back = E::simulate(&reversed)?;
    back.run_until(forward.time().to_f64())?;
    let view = back.view();
    let distance = view
        .bodies()
        .zip(&scene.molecule)
        .map(|(body, start)| {
            let off = body.motion.position - glam::DVec2::from(start.at);
            (off - off.round()).length()
        })
        .fold(0.0, f64::max);
    Ok((2.0 * count as f64 / COUNT as f64, distance))
}

/// Intercept and slope of the straight line of least squares.
pub fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |sum, point| (sum.0 + point.0 / n, sum.1 + point.1 / n));
    let (xx, xy) = points.iter().fold((0.0, 0.0), |sum, point| {
        let dx = point.0 - x;
        (sum.0 + dx * dx, sum.1 + dx * (point.1 - y))
    });
    let slope = xy / xx;
    (y - slope * x, slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment_extremes::cases::Ours;

    #[test]
    fn a_line_is_found_again() {
        let (intercept, slope) = line(&[(0.0, 1.0), (1.0, 3.0), (4.0, 9.0)]);
        assert!((intercept - 1.0).abs() < 1e-15 && (slope - 2.0).abs() < 1e-15);
    }

    #[test]
    fn the_distance_grows_by_the_lyapunov_law_from_a_few_roundings() {
        let found = reversal::<Ours>(0.3, 1.16, 3).unwrap();
        // As measured by two trajectories, within what three starts of up to 20 collisions each can show.
        assert!((found.rate / 1.16 - 1.0).abs() < 0.3, "{found:?}");
        assert!((0.01..100.0).contains(&found.effective_error), "{found:?}");
    }
}
