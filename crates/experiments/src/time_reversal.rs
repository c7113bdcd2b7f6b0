//! Loschmidt's reversal: a run goes forward, all velocities are reversed, and it goes back; the
//! distance from the initial state measures its accuracy.
//!
//! Exact dynamics would return to the initial state. Chaos amplifies the errors: the distance is d₀
//! exp(κ n) after n collisions of each body, and d₀ is the effective error of the whole engine.

use anyhow::Result;
use carom_methods::AnySimulation;
use glam::DVec2;

/// Larger distances are not small compared with the free paths and do not follow the law (box
/// sides).
pub const MAX_DISTANCE: f64 = 1e-3;

/// Runs forward for a duration (time) and back. Returns the distance of the body that ends farthest
/// from its initial position (length), and the collisions of each moving body on the way forward.
///
/// # Errors
/// The run fails.
pub fn loschmidt_echo(simulation: &mut AnySimulation, duration: f64) -> Result<(f64, f64)> {
    let places = |simulation: &AnySimulation| -> Vec<DVec2> {
        let view = simulation.view();
        view.bodies()
            .filter(|body| body.body.is_free())
            .map(|body| body.motion.position)
            .collect()
    };
    let start = places(simulation);
    let before = simulation.view().counters().collisions;
    let (begin, turn) = (simulation.time(), simulation.time().after(duration));
    simulation.observe_until_epoch_time(turn, &mut ())?;
    let collisions = simulation.view().counters().collisions - before;
    // The actual duration, which may differ from the requested one by rounding.
    let ran = simulation.time().since(begin);
    simulation.reverse();
    let home = simulation.time().after(ran);
    simulation.observe_until_epoch_time(home, &mut ())?;
    let bounds = simulation.view().bounds();
    let distances = places(simulation)
        .into_iter()
        .zip(&start)
        .map(|(end, start)| bounds.nearest_image(end - *start).length());
    let farthest = distances.fold(0.0, f64::max);
    Ok((
        2.0 * collisions as f64 / start.len().max(1) as f64,
        farthest,
    ))
}

/// Intercept and slope of the least-squares line.
pub fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |sum, point| {
        (sum.0 + point.0 / n, sum.1 + point.1 / n)
    });
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

    #[test]
    fn a_planted_line_is_recovered() {
        let (intercept, slope) = line(&[(0.0, 1.0), (1.0, 3.0), (4.0, 9.0)]);
        assert!((intercept - 1.0).abs() < 1e-15 && (slope - 2.0).abs() < 1e-15);
    }
}
