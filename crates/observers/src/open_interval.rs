//! The open interval between two samples, with the time average of a quantity across edits.

use std::ops::{Add, Mul};

use carom_kinematics::EpochTime;
use serde::{Deserialize, Serialize};

/// An interval that has begun, and the mean of a quantity in it.
///
/// Edits divide the interval into parts. In each part the mean is that of the values at its two
/// ends (trapezoidal rule), so that a value may change at an edit.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct OpenInterval<T> {
    began: EpochTime,
    /// From the start of the interval to that of the present part (time).
    earlier: f64,
    /// Mean over the earlier parts; unused if there are none.
    mean: T,
    /// Value at the start of the present part.
    first: T,
    /// Whether an edit divides the interval now.
    is_paused: bool,
}

impl<T: Copy + Add<Output = T> + Mul<f64, Output = T>> OpenInterval<T> {
    /// An interval that begins at this time with this value.
    pub(crate) fn new(time: EpochTime, first: T) -> Self {
        Self { began: time, earlier: 0.0, mean: first, first, is_paused: false }
    }

    /// Its length at this time (time).
    pub(crate) fn duration(&self, time: EpochTime) -> f64 {
        time.since(self.began)
    }

    /// The mean from the start to this time, at which the quantity has this value.
    pub(crate) fn mean(&self, time: EpochTime, last: T) -> T {
        let duration = self.duration(time);
        if duration <= self.earlier {
            return self.mean;
        }
        let share = self.earlier / duration;
        let part = (self.first + last) * 0.5;
        if share == 0.0 { part } else { self.mean * share + part * (1.0 - share) }
    }

    /// Ends the present part, before an edit. If the edit fails, the next part begins with the same
    /// value.
    pub(crate) fn pause(&mut self, time: EpochTime, last: T) {
        self.mean = self.mean(time, last);
        self.earlier = self.duration(time);
        self.first = last;
        self.is_paused = true;
    }

    /// Begins the next part, after an edit. Returns false if the interval has not been paused at
    /// this time: what happened since is not known.
    pub(crate) fn go_on(&mut self, time: EpochTime, first: T) -> bool {
        let goes_on = self.is_paused && self.duration(time) == self.earlier;
        self.first = first;
        self.is_paused = false;
        goes_on
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_count_by_their_length() {
        let at = EpochTime::from;
        let mut interval = OpenInterval::new(at(1.0), 2.0);
        assert_eq!(interval.mean(at(3.0), 6.0), 4.0);
        interval.pause(at(2.0), 4.0);
        assert!(interval.go_on(at(2.0), 10.0));
        // Two edits at one time.
        interval.pause(at(2.0), 10.0);
        assert!(interval.go_on(at(2.0), 7.0));
        // 3 for 1, then 8 for 3.
        assert_eq!(interval.mean(at(5.0), 9.0), 0.25 * 3.0 + 0.75 * 8.0);
        assert_eq!(interval.duration(at(5.0)), 4.0);
        // A run that goes on without a pause, or later than it.
        assert!(!interval.go_on(at(5.0), 1.0));
        interval.pause(at(5.0), 1.0);
        assert!(!interval.go_on(at(6.0), 1.0));
    }
}
