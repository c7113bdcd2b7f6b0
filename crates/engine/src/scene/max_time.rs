//! The latest time at which a run can end.

/// Latest end of a run (time). Sums of such times remain finite.
pub const MAX_TIME: f64 = 1e300;
