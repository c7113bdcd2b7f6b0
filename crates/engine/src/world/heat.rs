//! Heat: the energy that thermostats have given to the bodies of each tag.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use crate::world::tags::{Tag, TagNames};

/// The heat of each tag to which a thermostat has been applied since the system was built.
///
/// It is a part of [`Ledger::put_in`](crate::Ledger::put_in), which also includes all other edits.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HeatByTag(Vec<TagHeat>);

/// The heat of one tag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TagHeat {
    /// The tag.
    pub tag: Tag,
    /// Energy given by thermostats to the bodies of the tag, less the energy taken from them
    /// (mass × length² / time²).
    pub energy: f64,
    /// The bodies changed and left out, summed over all actions.
    pub counts: ThermostatCounts,
}

/// The bodies of a tag that a thermostat has changed or left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ThermostatCounts {
    /// Bodies with a new motion.
    pub changed: u64,
    /// Bodies at rest, which have no direction of motion to keep and remain at rest.
    pub at_rest: u64,
    /// Fixed bodies, which have no energy.
    pub fixed: u64,
}

impl AddAssign for ThermostatCounts {
    fn add_assign(&mut self, other: Self) {
        self.changed += other.changed;
        self.at_rest += other.at_rest;
        self.fixed += other.fixed;
    }
}

/// The sum of numbers without the accumulation of rounding errors (A. Neumaier, Z. Angew. Math.
/// Mech. 54 (1974) 39): a ledger of many edits remains exact to some roundings of its largest
/// entry.
pub(crate) fn exact_sum(numbers: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0f64, 0.0f64);
    for number in numbers {
        let next = sum + number;
        lost += if sum.abs() >= number.abs() {
            (sum - next) + number
        } else {
            (number - next) + sum
        };
        sum = next;
    }
    sum + lost
}

impl HeatByTag {
    /// The tags to which a thermostat has been applied, in the order of their first use.
    pub fn all(&self) -> &[TagHeat] {
        &self.0
    }

    /// The energy given to the bodies of a tag (mass × length² / time²); 0 without a thermostat.
    pub fn heat(&self, tag: Tag) -> f64 {
        self.0
            .iter()
            .find(|given| given.tag == tag)
            .map_or(0.0, |given| given.energy)
    }

    pub(crate) fn give(&mut self, tag: Tag, energy: f64, counts: ThermostatCounts) {
        match self.0.iter_mut().find(|given| given.tag == tag) {
            Some(given) => {
                given.energy += energy;
                given.counts += counts;
            }
            None => self.0.push(TagHeat {
                tag,
                energy,
                counts,
            }),
        }
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.0.iter().all(|given| given.energy.is_finite())
    }

    /// Whether each tag has a name.
    pub(crate) fn is_named(&self, names: &TagNames) -> bool {
        self.0.iter().all(|given| names.knows(given.tag))
    }

    /// The largest count; 0 without thermostats.
    pub(crate) fn largest_count(&self) -> u64 {
        let of = |TagHeat {
                      counts:
                          ThermostatCounts {
                              changed,
                              at_rest,
                              fixed,
                          },
                      ..
                  }: &TagHeat| { *changed.max(at_rest).max(fixed) };
        self.0.iter().map(of).max().unwrap_or(0)
    }
}
