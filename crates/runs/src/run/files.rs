//! Names of files in the folder of a run.

/// Pictures of the initial and the final state.
pub const PICTURES: [&str; 2] = ["start.svg", "end.svg"];

/// Snapshots.
pub const TRAJECTORY: &str = "trajectory.extxyz";
