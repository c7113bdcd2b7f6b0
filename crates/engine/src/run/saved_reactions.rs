//! The reactions in a checkpoint: each as the text of a scene, in a form that any encoding can
//! hold, with what it has done.

use serde::{Deserialize, Serialize};

use crate::{
    contact::reaction_table::ReactionTable,
    scene::{error::SceneError, reaction_spec::ReactionSpec},
    world::{
        reaction_record::{ReactionCounts, ReactionRecord},
        tags::TagNames,
    },
};

/// The reactions of a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct SavedReactions {
    /// Those that are or have been in force, in the order of their records.
    records: Vec<SavedReaction>,
    /// Those in force, by their place among the records.
    in_force: Vec<u32>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct SavedReaction {
    /// A table of a scene, in TOML.
    spec: String,
    counts: ReactionCounts,
}

impl SavedReactions {
    pub(crate) fn new(table: &ReactionTable) -> Self {
        let record = |one: &ReactionRecord| SavedReaction {
            // Numbers are written with all their digits.
            spec: toml::to_string(&one.spec).unwrap_or_default(),
            counts: one.counts,
        };
        Self {
            records: table.records.iter().map(record).collect(),
            in_force: table.in_force().map(|place| place as u32).collect(),
        }
    }

    /// The reactions in force, with all counts at 0.
    pub(crate) fn restarted(&self) -> Self {
        let in_force = self.in_force.iter();
        let records = in_force.filter_map(|&place| {
            let spec = self.records.get(place as usize)?.spec.clone();
            let counts = ReactionCounts::default();
            Some(SavedReaction { spec, counts })
        });
        let records: Vec<SavedReaction> = records.collect();
        Self {
            in_force: (0..records.len() as u32).collect(),
            records,
        }
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.records
            .iter()
            .all(|record| record.counts.energy.is_finite())
    }

    pub(crate) fn largest_count(&self) -> u64 {
        let counts = self.records.iter().map(|record| record.counts);
        counts
            .flat_map(|counts| [counts.contacts, counts.reactions, counts.blocked])
            .max()
            .unwrap_or(0)
    }

    /// The table of these reactions.
    ///
    /// # Errors
    /// A rule is not one of a scene, or one in force has no record.
    pub(crate) fn table(&self, names: &mut TagNames) -> Result<ReactionTable, SceneError> {
        let entry = "reaction of the checkpoint";
        let specs = self.records.iter().map(|record| {
            let spec = toml::from_str::<ReactionSpec>(&record.spec);
            spec.map_err(|reason| SceneError::Syntax(reason.to_string()))
        });
        let specs: Vec<ReactionSpec> = specs.collect::<Result<_, _>>()?;
        let mut table = ReactionTable::default();
        table.set(entry, &specs, names)?;
        let in_force = self.in_force.iter().map(|&place| {
            let spec = specs.get(place as usize).cloned();
            spec.ok_or_else(|| SceneError::of_entry(entry, "one in force has no record"))
        });
        table.set(entry, &in_force.collect::<Result<Vec<_>, _>>()?, names)?;
        for (record, saved) in table.records.iter_mut().zip(&self.records) {
            record.counts = saved.counts;
        }
        Ok(table)
    }
}
