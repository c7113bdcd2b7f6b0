//! Effective error of a setting by time reversal, extrapolated to zero collisions.

use std::time::Instant;

use anyhow::Result;
use carom::{Scene, View};
use carom_runs::price::{CourseState, Setting};

use crate::time_reversal::{MAX_DISTANCE, line, loschmidt_echo};

/// Why no run of a scene can be reversed; `None` if all can. `view` is that of its bodies.
pub fn irreversible(scene: &Scene, view: &View<'_>) -> Option<String> {
    let mut rules = std::iter::once(&scene.elasticity).chain(
        scene
            .stage
            .iter()
            .filter_map(|stage| stage.elasticity.as_ref()),
    );
    if let Some(spec) = rules.find(|spec| !spec.is_elastic()) {
        let coefficients = spec
            .pair
            .iter()
            .filter_map(|rule| rule.coefficient.number());
        let changing = coefficients
            .chain([spec.default])
            .find(|&coefficient| coefficient != 1.0);
        return Some(match changing {
            Some(coefficient) => {
                format!("contacts with elasticity {coefficient} cannot be reversed")
            }
            None => {
                "rough contacts, and those whose elasticity depends on the speed, are not reversed"
                    .to_owned()
            }
        });
    }
    if scene.stage.iter().any(|stage| !stage.thermostat.is_empty()) {
        return Some("the actions of a thermostat cannot be reversed".to_owned());
    }
    let is_thermal = view
        .bodies()
        .any(|body| body.body.wall_temperature().is_some());
    is_thermal.then(|| "contacts with a wall that has a temperature cannot be reversed".to_owned())
}

/// Duration of the way forward, in mean times between two collisions of a body: the shortest, and
/// the largest number of doublings.
const MIN_DURATION: f64 = 0.25;
const DOUBLINGS: i32 = 8;

/// Largest number of initial states.
const MAX_STARTS: usize = 8;

/// Smaller distances are rounding errors (box sides).
const MIN_DISTANCE: f64 = 1e-18;

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
pub fn returns(setting: &Setting, states: &[CourseState], deadline: Instant) -> Result<Return> {
    let mut found = Return::default();
    for doubling in 0..=DOUBLINGS {
        let (mut collisions, mut log, mut starts) = (0.0, 0.0, 0.0);
        for state in states.iter().take(MAX_STARTS) {
            if starts > 0.0 && Instant::now() >= deadline {
                break;
            }
            let (n, distance) = loschmidt_echo(
                &mut setting.resume(state.checkpoint())?,
                MIN_DURATION * 2f64.powi(doubling) * state.tau,
            )?;
            collisions += n;
            log += distance.max(MIN_DISTANCE).ln();
            starts += 1.0;
        }
        let (collisions, log) = (collisions / starts, log / starts);
        if log >= MAX_DISTANCE.ln() {
            found.lost = found.points.is_empty().then_some(log);
            break;
        }
        found.points.push((collisions, log));
        if Instant::now() >= deadline {
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

    /// Whether there are distances at two or more durations, so that a rate can be fitted.
    pub fn has_rate(&self) -> bool {
        self.points.len() >= 2 && self.rate().is_finite()
    }

    /// d₀ for the given growth rate; `None` without data.
    pub fn effective_error(&self, rate: f64) -> Option<EffectiveError> {
        let logs = self.points.iter().map(|&(n, log)| log - rate * n);
        let mean = logs.sum::<f64>() / self.points.len() as f64;
        let error = |log: f64, at_least| EffectiveError {
            value: log.exp(),
            at_least,
        };
        self.lost
            .map(|log| error(log, true))
            .or_else(|| mean.is_finite().then(|| error(mean, false)))
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
        let lost = Return {
            points: Vec::new(),
            lost: Some(0.1f64.ln()),
        }
        .effective_error(3.0)
        .unwrap();
        assert!((lost.value - 0.1).abs() < 1e-15 && lost.at_least);
        assert_eq!(Return::default().effective_error(3.0), None);
    }
}
