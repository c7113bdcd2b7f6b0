//! Times of a run: approach to equilibrium, then measurement.

use anyhow::{Result, ensure};
use carom::engine::RunSpec;
use carom_runs::sampling_times::sampling_times;

/// Times of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Start of the measurement (time).
    pub from: f64,
    /// End of the run (time).
    pub until: f64,
    /// Interval between samples (time).
    pub sample_interval: f64,
}

impl Plan {
    /// A short run in a dense gas of discs of radius 0.01.
    pub const DENSE: Self = Self { from: 5.0, until: 200.0, sample_interval: 0.5 };

    /// A short run in a dilute gas of discs of radius 0.01: kicks are rare and cheap.
    pub const DILUTE: Self = Self { from: 100.0, until: 20_000.0, sample_interval: 20.0 };

    /// The times of a scene.
    pub fn of(run: &RunSpec) -> Self {
        Self { from: run.measure_from, until: run.until, sample_interval: run.sample_interval }
    }

    /// This plan with other times from the command line.
    ///
    /// # Errors
    /// A time is not finite, or the measurement would not start after 0 and before the end.
    pub fn with(self, from: Option<f64>, until: Option<f64>) -> Result<Self> {
        let plan = Self { from: from.unwrap_or(self.from), until: until.unwrap_or(self.until), ..self };
        ensure!(
            plan.until.is_finite() && plan.until > 0.0,
            "--until {:?}: it must be positive and finite",
            plan.until
        );
        ensure!(
            plan.from >= 0.0 && plan.from < plan.until,
            "the measurement would start at {} and end at {}: choose --from smaller than --until",
            plan.from,
            plan.until
        );
        Ok(plan)
    }

    /// This plan with all times multiplied by `scale`.
    #[must_use]
    pub fn scaled(self, scale: f64) -> Self {
        Self {
            from: scale * self.from,
            until: scale * self.until,
            sample_interval: scale * self.sample_interval,
        }
    }

    /// The `[run]` table for this plan.
    pub fn run(&self, run: RunSpec) -> RunSpec {
        RunSpec { until: self.until, sample_interval: self.sample_interval, ..run }
    }

    /// Sampling times during equilibration.
    pub fn settling(&self) -> impl Iterator<Item = f64> + use<> {
        sampling_times(0.0, self.from, self.sample_interval)
    }

    /// Sampling times during the measurement.
    pub fn measuring(&self) -> impl Iterator<Item = f64> + use<> {
        sampling_times(self.from, self.until, self.sample_interval)
    }
}
