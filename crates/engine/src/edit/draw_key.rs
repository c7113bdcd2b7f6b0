//! The key of the random numbers of a thermostat.

/// Selects the random numbers of one draw. Two draws of a run that differ in `action` are
/// independent; equal keys give each body the same numbers again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrawKey {
    /// Seed of the scene.
    pub seed: u64,
    /// Replica of the scene.
    pub replica: u64,
    /// Number of the action in the run.
    pub action: u64,
}
