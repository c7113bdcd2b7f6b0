//! Heat: the energy that thermostats have given to the bodies of each tag.

use serde::{Deserialize, Serialize};

use crate::{Tag, TagNames};

/// Energy given by thermostats to the bodies of each tag since the system was built, less the
/// energy taken from them (mass × length² / time²).
///
/// It is a part of [`Ledger::put_in`](crate::Ledger::put_in), which also includes all other edits.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HeatByTag(Vec<(Tag, f64)>);

impl HeatByTag {
    /// The tags to which a thermostat has been applied, in the order of their first use, with the
    /// energy given (mass × length² / time²).
    pub fn all(&self) -> &[(Tag, f64)] {
        &self.0
    }

    /// The energy given to the bodies of a tag (mass × length² / time²); 0 without a thermostat.
    pub fn of(&self, tag: Tag) -> f64 {
        self.0.iter().find(|(given, _)| *given == tag).map_or(0.0, |(_, heat)| *heat)
    }

    pub(crate) fn give(&mut self, tag: Tag, heat: f64) {
        match self.0.iter_mut().find(|(given, _)| *given == tag) {
            Some((_, sum)) => *sum += heat,
            None => self.0.push((tag, heat)),
        }
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.0.iter().all(|(_, heat)| heat.is_finite())
    }

    /// Whether each tag has a name.
    pub(crate) fn is_named(&self, names: &TagNames) -> bool {
        self.0.iter().all(|&(tag, _)| names.knows(tag))
    }
}
