//! One atom of a molecule, as a scene describes it.

use serde::{Deserialize, Serialize};

/// One atom of a molecule given by a list of atoms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AtomSpec {
    /// Centre of the atom, in any frame of the molecule (length).
    pub at: [f64; 2],
    /// Radius (length).
    pub radius: f64,
    /// Mass.
    pub mass: f64,
}
