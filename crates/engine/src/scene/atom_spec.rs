//! One atom of a molecule, as a scene describes it.

#[cfg(feature = "schema")]
use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE};
use serde::{Deserialize, Serialize};

use crate::scene::two_numbers::vector;

/// One atom of a molecule given by a list of atoms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AtomSpec {
    /// Centre of the atom, in any frame of the molecule (length).
    #[serde(deserialize_with = "vector")]
    pub at: [f64; 2],
    /// Radius (length).
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub radius: f64,
    /// Mass (mass).
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub mass: f64,
}
