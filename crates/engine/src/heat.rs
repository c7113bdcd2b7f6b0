//! Heat: the energy that thermostats have given to the bodies of each tag.

use serde::{Deserialize, Serialize};

use crate::{Tag, TagNames};

/// Energy given by thermostats to the bodies of each tag since the system was built, less the
/// energy taken from them (mass × length² / time²).
///
/// It is a part of [`Ledger::put_in`](crate::Ledger::put_in), which also includes all other edits.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HeatByTag(Vec<(Tag, f64)>);

/// The sum of numbers without the accumulation of rounding errors (A. Neumaier, Z. Angew. Math. Mech.
/// 54 (1974) 39): a ledger of many edits remains exact to some roundings of its largest entry.
pub(crate) fn exact_sum(numbers: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0f64, 0.0f64);
    for number in numbers {
        let next = sum + number;
        lost += if sum.abs() >= number.abs() { (sum - next) + number } else { (number - next) + sum };
        sum = next;
    }
    sum + lost
}

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
