//! Physical results: pressure, collision rate, shares of hits, and the slope of the velocity
//! autocorrelation.

use anyhow::Result;
use carom::{Checkpoint, Observer, View};
use cpu_time::ThreadTime;
use glam::DVec2;

use super::{
    knobs::Setting,
    observers::{MOST_ATOMS, Measures},
    options::Plan,
};

/// Duration of a block, and lag of the autocorrelation, in mean times between two collisions of a
/// body.
pub const BLOCK: f64 = 10.0;
const LAG: f64 = 0.1;

/// A mean and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// The mean.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

/// Results.
#[derive(Debug, Clone, Default)]
pub struct Physics {
    /// Pressure (mass / time²).
    pub pressure: Option<Mean>,
    /// Collisions of a body per time.
    pub rate: Option<Mean>,
    /// −ln(C(δ)/C(0))/δ of the velocity autocorrelation C (1 / time).
    pub slope: Option<Mean>,
    /// Hits of each atom of the molecules.
    pub hits: [u64; MOST_ATOMS],
    /// Largest number of overlapping pairs at the end of a block.
    pub overlapping: usize,
    /// Deepest overlap at the end of a block, in units of the smaller diameter.
    pub deepest: f64,
    /// Number of blocks.
    pub blocks: u32,
    /// Error of a failed run.
    pub broke_off: Option<String>,
}

impl Physics {
    /// The share of hits that differs most from that of another run: the difference and its
    /// standard error.
    pub fn share_difference(&self, exact: &Self) -> Option<Mean> {
        let totals = [self, exact].map(|physics| physics.hits.iter().sum::<u64>() as f64);
        if totals.contains(&0.0) {
            return None;
        }
        let atoms = (0..MOST_ATOMS).map(|atom| {
            let [p, q] = [self.hits[atom] as f64 / totals[0], exact.hits[atom] as f64 / totals[1]];
            let error = (p * (1.0 - p) / totals[0] + q * (1.0 - q) / totals[1]).sqrt();
            Mean { value: (p - q).abs(), error }
        });
        atoms.max_by(|a, b| a.value.total_cmp(&b.value))
    }
}

/// Relative difference of two means.
pub fn relative(found: Option<Mean>, exact: Option<Mean>) -> Option<Mean> {
    let (found, exact) = (found?, exact?);
    let scale = exact.value.abs();
    Some(Mean { value: (found.value - exact.value) / scale, error: found.error.hypot(exact.error) / scale })
}

/// Runs a setting in blocks from a state; `tau` is the mean time between two collisions of a body.
/// A run that fails keeps its results so far.
///
/// # Errors
/// The run cannot start.
pub fn measure(setting: &Setting, state: &Checkpoint, tau: f64, plan: &Plan) -> Result<Physics> {
    let mut simulation = setting.resume(state)?;
    let mut measures = Measures::default();
    let mut physics = Physics::default();
    let mut slopes = Vec::new();
    let begin = state.time().to_f64();
    let clock = ThreadTime::now();
    measures.start(&simulation.view());
    for block in 0..plan.blocks {
        let from = begin + f64::from(block) * BLOCK * tau;
        let before = velocities(&simulation.view());
        let mut ran = simulation.observe_until(from + LAG * tau, &mut measures);
        let after = velocities(&simulation.view());
        ran = ran.and_then(|()| simulation.observe_until(from + BLOCK * tau, &mut measures));
        if let Err(error) = ran {
            physics.broke_off = Some(error.to_string());
            break;
        }
        measures.sample(&simulation.view());
        let [at_zero, at_lag] = [&before, &after]
            .map(|other| before.iter().zip(other).map(|(v, w): (&DVec2, &DVec2)| v.dot(*w)).sum::<f64>());
        slopes.push(-(at_lag / at_zero).ln() / (LAG * tau));
        let census = simulation.view().overlaps();
        physics.overlapping = physics.overlapping.max(census.pairs);
        physics.deepest = physics.deepest.max(census.deepest);
        physics.blocks += 1;
        if physics.blocks >= 2 && clock.elapsed().as_secs_f64() > plan.most_seconds {
            break;
        }
    }
    let mean = |(value, error)| Mean { value, error };
    physics.pressure = measures.pressure.mean().map(mean);
    physics.rate = measures.rate.mean().map(mean);
    physics.slope = mean_of(&slopes);
    physics.hits = measures.hits;
    Ok(physics)
}

fn mean_of(values: &[f64]) -> Option<Mean> {
    let n = values.len() as f64;
    if n < 2.0 {
        return None;
    }
    let value = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|x| (x - value) * (x - value)).sum::<f64>() / (n - 1.0);
    Some(Mean { value, error: (variance / n).sqrt() })
}

fn velocities(view: &View<'_>) -> Vec<DVec2> {
    view.bodies().filter(|view| !view.body.is_fixed()).map(|view| view.motion.velocity).collect()
}
