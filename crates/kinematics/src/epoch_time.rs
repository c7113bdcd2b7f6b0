//! Times that keep their resolution at any age: the start of an epoch and an offset from it.

use std::{cmp::Ordering, fmt};

use serde::{Deserialize, Serialize};

use crate::two_sum;

/// A time, as the start of an epoch (a double-double: the exact sum of two floats) and an offset
/// from it.
///
/// Inside an epoch, times are offsets, so a run at t = 10¹² resolves time as finely as at t = 0.
///
/// ```
/// use carom_kinematics::EpochTime;
///
/// let old = EpochTime::from(1e12).after(1e-9);
/// assert_eq!(old.since(EpochTime::from(1e12)), 1e-9);
/// assert_eq!(old.to_f64(), 1e12);
/// ```
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct EpochTime {
    epoch: f64,
    epoch_low: f64,
    offset: f64,
}

impl EpochTime {
    /// Time zero.
    pub const ZERO: Self = Self {
        epoch: 0.0,
        epoch_low: 0.0,
        offset: 0.0,
    };

    /// The start of the epoch that begins `duration` after this time; the offset is added to it.
    #[must_use]
    pub fn new_epoch(self, duration: f64) -> Self {
        let (high, error) = two_sum(self.epoch, self.offset + duration);
        let (epoch, epoch_low) = two_sum(high, error + self.epoch_low);
        Self {
            epoch,
            epoch_low,
            offset: 0.0,
        }
    }

    /// This time plus `offset` (time) in its epoch.
    #[must_use]
    pub fn after(self, offset: f64) -> Self {
        Self {
            offset: self.offset + offset,
            ..self
        }
    }

    /// Start of the epoch, rounded to one float (time).
    pub fn epoch(self) -> f64 {
        self.epoch
    }

    /// The part of the epoch's start below the rounding of [`Self::epoch`] (time).
    pub fn epoch_low(self) -> f64 {
        self.epoch_low
    }

    /// Offset from the start of the epoch (time).
    pub fn offset(self) -> f64 {
        self.offset
    }

    /// The duration from `other` to this time (time), exact in its leading float at any age.
    pub fn since(self, other: Self) -> f64 {
        let (high, error) = two_sum(self.epoch, -other.epoch);
        let low = self.epoch_low - other.epoch_low;
        let (offsets, offset_error) = two_sum(self.offset, -other.offset);
        let (sum, sum_error) = two_sum(high, offsets);
        sum + (sum_error + (error + (low + offset_error)))
    }

    /// This time rounded to one float.
    pub fn to_f64(self) -> f64 {
        self.since(Self::ZERO)
    }
}

impl From<f64> for EpochTime {
    fn from(time: f64) -> Self {
        Self {
            epoch: time,
            epoch_low: 0.0,
            offset: 0.0,
        }
    }
}

impl PartialEq for EpochTime {
    fn eq(&self, other: &Self) -> bool {
        self.since(*other) == 0.0
    }
}

impl PartialOrd for EpochTime {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.since(*other).partial_cmp(&0.0)
    }
}

impl fmt::Display for EpochTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.to_f64().fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_short_epochs_add_up_at_any_age() {
        // 2^-20 is exact, so the sum is known exactly.
        let step = 2f64.powi(-20);
        for start in [0.0, 1e6, 1e12, 1e15] {
            let mut now = EpochTime::from(start);
            for _ in 0..1 << 20 {
                now = now.new_epoch(step);
            }
            assert_eq!(now.since(EpochTime::from(start)), 1.0, "from {start}");
        }
    }

    #[test]
    fn epoch_times_are_ordered_by_time() {
        let early = EpochTime::from(1e12).after(1e-6);
        let late = EpochTime::from(1e12).after(2e-6);
        assert!(early < late);
        assert!(late > early);
        assert_eq!(early, early.new_epoch(0.0));
    }
}
