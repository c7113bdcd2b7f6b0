//! Effective error of a setting: forward, all velocities reversed, and back, extrapolated to no collision at all.

use anyhow::Result;
use carom::Checkpoint;
use cpu_time::ThreadTime;

use super::{knobs::Setting, options::Plan, runner::begin};
use crate::experiments::time_reversal::{LARGEST, line};

/// Way forward, in mean times between two collisions of a body: the first, and how often it is doubled at the most.
const SHORTEST: f64 = 0.25;
const DOUBLINGS: i32 = 8;

/// States that are begun from, at the most.
const MOST_STARTS: usize = 8;

/// Nothing can be told from a rounding (box sides).
const SMALLEST: f64 = 1e-18;

/// Distances from the start after the way back.
#[derive(Debug, Clone, Default)]
pub struct Return {
    /// Collisions of each body on the way forward, and the logarithm of the distance (box sides), mean over the starts.
    points: Vec<(f64, f64)>,
    /// The logarithm of a first distance that was already too far for the law.
    lost: Option<f64>,
}

/// The effective error of a setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectiveError {
    /// d₀ (box sides).
    pub value: f64,
    /// Whether it may be larger: the run was off too far at once.
    pub at_least: bool,
}

/// Runs there and back from states, ever longer ways, until chaos has won or the time is over.
///
/// # Errors
/// A run that breaks off.
pub fn returns(setting: &Setting, states: &[Checkpoint], tau: f64, plan: &Plan) -> Result<Return> {
    let clock = ThreadTime::now();
    let mut found = Return::default();
    for doubling in 0..=DOUBLINGS {
        let (mut collisions, mut log, mut starts) = (0.0, 0.0, 0.0);
        for state in states.iter().take(MOST_STARTS) {
            if starts > 0.0 && clock.elapsed().as_secs_f64() > plan.most_seconds {
                break;
            }
            let (n, distance) =
                begin(setting, state)?.there_and_back(SHORTEST * 2f64.powi(doubling) * tau)?;
            collisions += n;
            log += distance.max(SMALLEST).ln();
            starts += 1.0;
        }
        let (collisions, log) = (collisions / starts, log / starts);
        if log >= LARGEST.ln() {
            found.lost = found.points.is_empty().then_some(log);
            break;
        }
        found.points.push((collisions, log));
        if clock.elapsed().as_secs_f64() > plan.most_seconds {
            break;
        }
    }
    Ok(found)
}

impl Return {
    /// κ of d₀ exp(κ n): e-foldings in a collision of each body. It is a property of the gas, not of the setting.
    pub fn rate(&self) -> f64 {
        line(&self.points).1
    }

    /// d₀, if the distance grows at this rate; none where nothing was run.
    pub fn effective_error(&self, rate: f64) -> Option<EffectiveError> {
        let logs = self.points.iter().map(|&(n, log)| log - rate * n);
        let mean = logs.sum::<f64>() / self.points.len() as f64;
        let error = |log: f64, at_least| EffectiveError { value: log.exp(), at_least };
        self.lost.map(|log| error(log, true)).or_else(|| mean.is_finite().then(|| error(mean, false)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_planted_law_is_found_again_and_what_is_lost_at_once_is_a_lower_bound() {
        let planted = |error: f64| Return {
            points: [0.5, 1.0, 2.0].map(|n| (n, error.ln() + 3.0 * n)).to_vec(),
            lost: None,
        };
        assert!((planted(1e-15).rate() - 3.0).abs() < 1e-12);
        let found = planted(1e-9).effective_error(3.0).unwrap();
        assert!((found.value / 1e-9 - 1.0).abs() < 1e-12 && !found.at_least);
        let lost = Return { points: Vec::new(), lost: Some(0.1f64.ln()) }.effective_error(3.0).unwrap();
        assert!((lost.value - 0.1).abs() < 1e-15 && lost.at_least);
        assert_eq!(Return::default().effective_error(3.0), None);
    }
}
