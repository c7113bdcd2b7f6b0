//! Effective error of a setting by time reversal, extrapolated to zero collisions.

use anyhow::Result;
use carom::Checkpoint;
use cpu_time::ThreadTime;

use super::{knobs::Setting, options::Plan};
use crate::experiments::time_reversal::{LARGEST, line, loschmidt_echo};

/// Duration of the way forward, in mean times between two collisions of a body: the shortest, and
/// the largest number of doublings.
const SHORTEST: f64 = 0.25;
const DOUBLINGS: i32 = 8;

/// Largest number of initial states.
const MOST_STARTS: usize = 8;

/// Smaller distances are rounding errors (box sides).
const SMALLEST: f64 = 1e-18;

/// Distances from the initial state after the way back.
#[derive(Debug, Clone, Default)]
pub struct Return {
    /// Collisions of each body on the way forward, and the logarithm of the distance (box sides),
    /// mean over the initial states.
    points: Vec<(f64, f64)>,
    /// Logarithm of a first distance that is already outside the exponential law.
    lost: Option<f64>,
}

/// Effective error of a setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectiveError {
    /// d₀ (box sides).
    pub value: f64,
    /// True if it is a lower bound: the first distance was outside the exponential law.
    pub at_least: bool,
}

/// Runs forward and back from several states, with increasing duration, until the exponential law
/// ends or the time limit is reached.
///
/// # Errors
/// A run fails.
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
                loschmidt_echo(&mut setting.resume(state)?, SHORTEST * 2f64.powi(doubling) * tau)?;
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
    /// κ of d₀ exp(κ n): e-foldings for each collision of a body. It is a property of the gas, not
    /// of the setting.
    pub fn rate(&self) -> f64 {
        line(&self.points).1
    }

    /// d₀ for the given growth rate; `None` without data.
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
    fn a_planted_law_is_recovered_and_an_immediate_loss_is_a_lower_bound() {
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
