//! Growth of small errors in a gas: how many e-foldings each collision of a body adds.

use carom::{Atom, View};

/// Estimate of λ₁/Γ: e-foldings of an error for each collision of a body, at least 0.1; `tau` is
/// the mean time between two collisions of a body (time).
///
/// A collision on a disc of diameter σ after a free path l turns an error of position into one of
/// about 2 l/σ times the size at the next collision. The largest error of many bodies grows about
/// twice as fast: 2 ln(1 + 2 l/σ) is 6.7, 3.5, 1.4 and 0.6 at the area fractions 0.02, 0.1, 0.3 and
/// 0.5, where 6.4, 2.7, 1.2 and 0.65 have been measured. For molecules, σ is the diameter of the
/// smallest atom that moves.
pub fn growth(view: &View<'_>, tau: f64) -> f64 {
    let (mut squares, mut moving, mut least) = (0.0, 0.0, f64::INFINITY);
    for body in view.bodies().filter(|body| body.body.is_free()) {
        squares += body.motion.velocity.length_squared();
        moving += 1.0;
        let molecule = body.body.molecule();
        least = if molecule.is_of_discs() {
            molecule
                .atoms()
                .iter()
                .map(Atom::radius)
                .fold(least, f64::min)
        } else {
            // Contacts at the tiny corners of a polygon are rare.
            least.min(molecule.mean_half_width())
        };
    }
    if moving == 0.0 {
        return MIN_GROWTH;
    }
    let path = (squares / moving).sqrt() * tau;
    (2.0 * (1.0 + path / least).ln()).clamp(MIN_GROWTH, MAX_GROWTH)
}

/// Bounds of the estimate: below, errors hardly grow within a replay; above, a single collision
/// turns rounding into a visible error.
const MIN_GROWTH: f64 = 0.1;
const MAX_GROWTH: f64 = 30.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::price::mean_time;
    use carom::Scene;
    use carom_methods::AnySimulation;

    #[test]
    fn the_estimate_is_near_the_measured_growth() {
        for (fraction, measured) in [(0.02, 6.40), (0.1, 2.68), (0.3, 1.16), (0.5, 0.647)] {
            let radius = (fraction / (64.0 * std::f64::consts::PI)).sqrt();
            let scene = Scene::from_toml(&format!(
                "[box]\nseed = 1\n[[gas]]\nradius = {radius}\nmass = 1.0\nenergy = 1.0\ncount = 64"
            ));
            let mut simulation = AnySimulation::new(&scene.unwrap()).unwrap();
            simulation.run_until(20.0).unwrap();
            let tau = mean_time(&simulation, [0, 0], 20.0).unwrap();
            let found = growth(&simulation.view(), tau);
            assert!(
                (0.5..2.0).contains(&(found / measured)),
                "{fraction}: {found}, not {measured}"
            );
        }
    }
}
