//! Sums of a quantity that an observer gives for each interval between samples.

use serde::{Deserialize, Serialize};

/// Σ x t and Σ t over the intervals of length t.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct IntervalSums {
    /// The sample at which the open interval began (time); `None` before the first.
    began: Option<f64>,
    sums: Vec<[f64; 2]>,
}

impl IntervalSums {
    /// Ends an interval at this sample (time). `values` has the mean of each quantity in it;
    /// without values the interval is left out.
    pub(super) fn end(&mut self, time: f64, values: &[f64]) {
        let duration = time - self.began.replace(time).unwrap_or(time);
        if duration <= 0.0 {
            return;
        }
        self.sums
            .resize(values.len().max(self.sums.len()), [0.0; 2]);
        for (sum, value) in self.sums.iter_mut().zip(values) {
            *sum = [sum[0] + value * duration, sum[1] + duration];
        }
    }

    /// Σ x t and Σ t of each quantity.
    pub(super) fn sums(&self) -> Vec<[f64; 2]> {
        self.sums.clone()
    }
}
