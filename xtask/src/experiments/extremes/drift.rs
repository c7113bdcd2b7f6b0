//! Energy drift over very many collisions: a random walk of rounding errors, or a bias.

use anyhow::Result;
use carom::Scene;
use carom_runs::progress::Progress;
use carom_tables::{Totals, allowed_drift};
use carom_testkit::extremes::{
    Engine,
    bodies::{bumper, disc},
    engine::{gas, in_box},
    watch::run_collisions,
};

use super::gaps::GapStatistics;
use carom_experiments::time_reversal::line;

/// Drift in one scene.
#[derive(Debug, Clone)]
pub struct EnergyDrift {
    /// The scene.
    pub name: &'static str,
    /// Number of collisions, and relative change of the energy since the start.
    pub points: Vec<(f64, f64)>,
    /// Number of collisions, and root mean square change of the energy over them.
    pub changes: Vec<(f64, f64)>,
    /// Exponent p of change ∝ collisions^p: 1/2 for a random walk, 1 for a bias.
    pub exponent: f64,
    /// Totals of the run.
    pub totals: Totals,
    /// Gaps between the discs at their contacts.
    pub gaps: GapStatistics,
}

/// The scenes by name.
pub fn scenes() -> [(&'static str, Scene); 3] {
    let mut sinai = in_box([1.0, 1.0], vec![disc(0.1, 1.0, [0.05, 0.15], [0.6, 0.8])]);
    sinai.bumper = vec![bumper(0.2, [0.5, 0.5])];
    let mut thesis = in_box([1.0, 1.0], Vec::new());
    thesis.gas = vec![gas("disc", 0.01, 1.0, 1592)];
    // Few collisions, so that epochs are as long as they get in a gas.
    let mut few = in_box([1.0, 0.75], Vec::new());
    few.gas = vec![gas("disc", 0.001, 1.0, 50)];
    [
        ("Sinai billiard", sinai),
        ("gas of the thesis, 1592 discs at 0.5", thesis),
        ("50 small discs", few),
    ]
}

/// Number of energy samples.
const SAMPLES: u64 = 2048;

/// Runs a scene for a number of collisions.
///
/// # Errors
/// The scene cannot be built, or the run fails.
pub fn drift(
    engine: Engine,
    name: &'static str,
    scene: &Scene,
    collisions: u64,
    progress: &Progress,
) -> Result<EnergyDrift> {
    let begun = cpu_time::ThreadTime::now();
    let mut run = engine.simulate(scene)?;
    let mut points = vec![(0.0, 0.0)];
    let (mut pairs, mut deepest) = (0, 0.0f64);
    let mut worst = 0.0f64;
    let mut gaps = GapStatistics::new(&run.view().bounds());
    for sample in 1..=SAMPLES {
        let before = run.view().counters().collisions;
        let requested = collisions * sample / SAMPLES;
        run_collisions(
            &mut run,
            requested.saturating_sub(before),
            &mut gaps,
            |_| {},
        )?;
        let view = run.view();
        let energy = view.energy() / view.ledger().initial - 1.0;
        points.push((view.counters().collisions as f64, energy));
        worst = worst.max(energy.abs());
        if sample % 32 == 0 {
            let overlaps = view.overlaps();
            (pairs, deepest) = (overlaps.pairs.max(pairs), overlaps.deepest.max(deepest));
        }
        let new = view.counters().collisions - before;
        progress.advance(new as f64, new);
    }
    let done = run.view().counters().collisions;
    let totals = Totals {
        collisions: done,
        simulated_time: run.time().to_f64(),
        collisions_per_second: done as f64 / begun.elapsed().as_secs_f64(),
        energy_drift: worst,
        // That of a random walk: a bias is what this experiment looks for.
        allowed_drift: allowed_drift(done, None),
        overlapping_pairs: pairs,
        max_overlap: deepest,
    };
    let changes = changes(&points);
    let logs: Vec<(f64, f64)> = changes
        .iter()
        .filter(|change| change.1 > 0.0)
        .map(|(n, change)| (n.ln(), change.ln()))
        .collect();
    Ok(EnergyDrift {
        name,
        points,
        changes,
        exponent: line(&logs).1,
        totals,
        gaps,
    })
}

/// Root mean square change over 1, 2, 4, … samples, up to an eighth of all.
fn changes(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    (0..usize::BITS)
        .map(|power| 1usize << power)
        .take_while(|lag| 8 * lag <= points.len())
        .map(|lag| {
            let pairs = || points.iter().zip(&points[lag..]);
            let n = pairs().count() as f64;
            let mean = pairs().map(|(a, b)| b.0 - a.0).sum::<f64>() / n;
            let square = pairs().map(|(a, b)| (b.1 - a.1).powi(2)).sum::<f64>() / n;
            (mean, square.sqrt())
        })
        .collect()
}

impl EnergyDrift {
    /// Description of the law.
    pub fn law(&self) -> &'static str {
        // Short intervals show the random walk even if a bias dominates in the long run.
        let (Some(&(n, end)), Some(&(lag, step))) = (self.points.last(), self.changes.first())
        else {
            return "unknown";
        };
        if end.abs() > 5.0 * step * (n / lag).sqrt() {
            return "linear: a bias in addition to the walk";
        }
        match self.exponent {
            p if p < 0.25 => "hardly any drift",
            p if p < 0.75 => "random walk",
            p if p < 1.25 => "linear",
            _ => "neither",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_random_walk_and_a_bias_are_distinguished() {
        // Steps of a walk from the bits of a linear congruential generator (Knuth's MMIX).
        let mut state = 1u64;
        let mut place = 0.0;
        let walk: Vec<(f64, f64)> = (0..4096)
            .map(|n| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                place += if state >> 63 == 0 { 1.0 } else { -1.0 };
                (f64::from(n), place)
            })
            .collect();
        let drift: Vec<(f64, f64)> = (0..4096)
            .map(|n| (f64::from(n), 1e-3 * f64::from(n)))
            .collect();
        let exponent = |points: &[(f64, f64)]| {
            let logs: Vec<_> = changes(points)
                .iter()
                .map(|(n, change)| (n.ln(), change.ln()))
                .collect();
            line(&logs).1
        };
        assert!((exponent(&walk) - 0.5).abs() < 0.15, "{}", exponent(&walk));
        assert!((exponent(&drift) - 1.0).abs() < 1e-9);
    }
}
