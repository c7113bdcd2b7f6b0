//! The wells in a checkpoint: their numbers alone, where a scene reads lists of pairs.

use serde::{Deserialize, Serialize};

use crate::scene::well_spec::WellSpec;

/// A well.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct SavedWell {
    between: Vec<String>,
    steps: Vec<[f64; 2]>,
}

impl From<&WellSpec> for SavedWell {
    fn from(well: &WellSpec) -> Self {
        Self {
            between: well.between.clone(),
            steps: well.steps.clone(),
        }
    }
}

impl From<&SavedWell> for WellSpec {
    fn from(well: &SavedWell) -> Self {
        Self {
            between: well.between.clone(),
            steps: well.steps.clone(),
        }
    }
}
