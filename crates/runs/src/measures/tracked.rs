//! A measure of a simulation that continues and is edited, with the times of its samples.

use carom::{EpochTime, Observer, View};
use serde::{Deserialize, Serialize};

use super::SingleMeasure;

/// A sample lies at the end of a run if at most this share of its interval is missing: rounding.
const ROUNDING: f64 = 1e-9;

/// A measure with its sampling times, begin + k · interval.
#[derive(Serialize, Deserialize)]
pub struct Tracked {
    /// The measure.
    pub measure: SingleMeasure,
    /// Whether the system has been edited since it began.
    pub is_disturbed: bool,
    /// Whether it receives samples.
    pub is_active: bool,
    begin: EpochTime,
    /// Number of its next sample, from 0.
    next: u64,
}

impl Tracked {
    /// A measure whose first sample is at the present time.
    pub fn new(measure: SingleMeasure, view: &View<'_>) -> Self {
        let begin = view.time();
        let mut tracked = Self {
            measure,
            is_disturbed: false,
            is_active: true,
            begin,
            next: 0,
        };
        tracked.sample(view);
        tracked
    }

    /// The time of its next sample.
    pub fn time(&self) -> EpochTime {
        self.begin.after(self.next as f64 * self.measure.interval())
    }

    /// Number of its samples so far.
    pub fn samples(&self) -> u64 {
        self.next
    }

    /// Takes the next sample.
    pub fn sample(&mut self, view: &View<'_>) {
        self.measure.sample(view);
        self.next += 1;
    }

    /// Whether its next sample is at `time`, to rounding.
    pub fn is_due(&self, time: EpochTime) -> bool {
        self.is_active && self.time().since(time) <= ROUNDING * self.measure.interval()
    }
}
