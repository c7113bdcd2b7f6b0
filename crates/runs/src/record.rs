//! The file `sums` of a run folder: what the runs of several replicas are merged from.

use std::{collections::BTreeMap, path::Path};

use anyhow::{Context, Result, bail};
use carom::Scene;
use carom_tables::{Figure, Replica, RunSums, Table, Totals};
use serde::{Deserialize, Serialize};

use crate::{checkpoint_file, other_run::refuse_other, output::Folder};

/// Name of the file.
pub const SUMS: &str = "sums";

/// Runs of one scene that differ in their random numbers. Parts are merged by the keys of their
/// runs, so that no order of merging changes a digit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The scene without seed and replica.
    pub what: String,
    /// The runs by seed and number of the replica.
    pub runs: BTreeMap<Replica, RunRecord>,
}

/// What is kept of one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Totals of the run, without its speed.
    pub totals: Totals,
    /// First note to the reader.
    pub note: String,
    /// Figures of the whole system, such as the temperature at the end.
    pub figures: Vec<Figure>,
    /// The measures, in the order of the run.
    pub measures: Vec<MeasureRecord>,
}

/// What is kept of one measure of one run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MeasureRecord {
    /// Sums over the run and over its blocks.
    pub sums: RunSums,
    /// Its tables.
    pub tables: Vec<Table>,
    /// Its figures, with the number of their sums.
    pub figures: Vec<(Figure, Option<usize>)>,
}

/// The scene as text with all options, without what distinguishes its replicas.
pub fn description(scene: &Scene) -> String {
    let mut any = scene.clone();
    (any.bounds.seed, any.bounds.replica) = (0, 0);
    // The animation changes no result.
    (any.run.animation, any.run.animation_from) = (true, 0.0);
    any.to_toml()
}

impl Record {
    /// The record of one run.
    pub fn of(scene: &Scene, run: RunRecord) -> Self {
        let replica = Replica { seed: scene.bounds.seed, number: scene.bounds.replica };
        Self { what: description(scene), runs: BTreeMap::from([(replica, run)]) }
    }

    /// Adds the runs of another part of the same scene.
    ///
    /// # Errors
    /// The scenes differ, or a run is in both parts.
    pub fn merge(&mut self, other: Self) -> Result<()> {
        refuse_other(&self.what, &other.what)?;
        if let Some(Replica { seed, number }) = other.runs.keys().find(|key| self.runs.contains_key(key)) {
            bail!("the run with seed {seed} and replica {number} is there twice");
        }
        self.runs.extend(other.runs);
        Ok(())
    }

    /// Writes the file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, folder: &Folder) -> Result<()> {
        checkpoint_file::write(&folder.file(SUMS)?, &[&checkpoint_file::encode(self)?])
    }

    /// Reads the file of a run folder.
    ///
    /// # Errors
    /// It cannot be read, or another version of the program wrote it.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(SUMS);
        let read = || -> Result<Self> { Ok(checkpoint_file::Body::read(&path)?.take()?) };
        read().with_context(|| format!("cannot merge {}", path.display()))
    }
}
