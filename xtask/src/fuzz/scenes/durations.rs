//! Differences of times in double-double precision.

use carom_kinematics::EpochTime;
use carom_testkit::oracle::{DoubleDouble, Number as _};

/// Difference of two times in double-double precision (time).
pub fn duration(from: EpochTime, to: EpochTime) -> DoubleDouble {
    let part = |to: f64, from: f64| DoubleDouble::new(to).minus(&DoubleDouble::new(from));
    part(to.epoch(), from.epoch())
        .plus(&part(to.epoch_low(), from.epoch_low()))
        .plus(&part(to.offset(), from.offset()))
}
