//! `carom merge`: the results of several replicas of a scene as those of one long run.

mod average;

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, ensure};
pub use average::results as merged;
use carom_tables::{Replica, Summary, Table, Totals, Verdict};
use clap::Args;
use serde_json::Value;

use crate::{
    command_line::command,
    folder_lock::FolderLock,
    manifest::Manifest,
    measures::Results,
    output::{Destination, Folder, is_same_folder},
    progress::Progress,
    record::{Record, RunRecord},
    report::{self, RUNS, State},
};

/// Options of `carom merge`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Folders of runs of one scene with different seeds or replicas, or of merged runs
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// Output folder and its treatment
    #[command(flatten)]
    pub destination: Destination,
}

/// Merges the runs and writes a folder with their tables, figures and page.
///
/// # Errors
/// A folder has no sums or is the output folder, the scenes differ, a run is there twice, another
/// process writes into a folder, or a file cannot be written.
pub fn run(options: &Options) -> Result<Verdict> {
    let path = options.destination.folder("out/merge");
    for source in &options.folders {
        ensure!(
            !is_same_folder(source, &path),
            "{} is one of the folders to merge: choose another with --out",
            path.display()
        );
    }
    let (record, seconds) = read(&options.folders)?;
    let (folder, _lock) = Folder::claim(&path, options.destination.existing())?;
    let manifest = Manifest::begin(&folder, &again(&options.folders, &path), &[])?;
    record.write(&folder)?;
    let merged = MergedRuns::of(&record, format!("{} merged runs", record.runs.len()), seconds);
    merged.write(&record, &folder)?;
    let summary = merged.summary;
    manifest.complete(&folder, summary.totals.cpu_seconds())?;
    crate::conclude(&folder, &summary);
    Ok(summary.verdict())
}

/// The command that merges these folders into `path`.
pub fn again(folders: &[PathBuf], path: &Path) -> String {
    let words = ["merge".as_ref()].into_iter().chain(folders.iter().map(|folder| folder.as_os_str()));
    command(words.chain(["--out".as_ref(), path.as_os_str()]))
}

/// Reads the runs of all folders and their processor time (seconds). Each folder is locked while it
/// is read.
fn read(folders: &[PathBuf]) -> Result<(Record, f64)> {
    let mut seconds = 0.0;
    let mut record: Option<Record> = None;
    let progress = Progress::items("runs", folders.len() as u64);
    for folder in folders {
        // A folder that is not there has no sums.
        let _lock = if folder.is_dir() { Some(FolderLock::shared(folder)?) } else { None };
        let part = Record::read(folder)?;
        match &mut record {
            None => record = Some(part),
            Some(all) => all.merge(part).with_context(|| format!("cannot merge {}", folder.display()))?,
        }
        seconds += seconds_of(folder);
        progress.count(1);
    }
    Ok((record.context("there are no folders")?, seconds))
}

/// Processor time of the runs in a folder, from its summary; 0 without one (seconds).
fn seconds_of(folder: &Path) -> f64 {
    let text = fs::read_to_string(folder.join("summary.json")).unwrap_or_default();
    let summary: Value = serde_json::from_str(&text).unwrap_or_default();
    let number = |key: &str| summary[key].as_f64().unwrap_or(0.0);
    let (collisions, speed) = (number("collisions"), number("collisions_per_second"));
    if speed > 0.0 { collisions / speed } else { 0.0 }
}

/// The results of merged runs.
#[derive(Debug)]
pub struct MergedRuns {
    /// Tables and figures.
    results: Results,
    /// Figures, totals and checks.
    pub summary: Summary,
}

impl MergedRuns {
    /// The results of the runs of a record, which took `seconds` of processor time.
    pub fn of(record: &Record, title: String, seconds: f64) -> Self {
        let results = average::results(record);
        let totals: Vec<Totals> = record.runs.values().map(|run| run.totals).collect();
        let totals = Totals::of(&totals);
        let totals = Totals { collisions_per_second: totals.collisions as f64 / seconds.max(1e-9), ..totals };
        let notes = record.runs.values().map(|run| &run.note);
        let summary = Summary {
            title,
            note: notes.into_iter().find(|note| !note.is_empty()).cloned().unwrap_or_default(),
            totals,
            checks: totals.checks(),
            figures: results.figures.clone(),
            runs: Vec::new(),
        };
        Self { results, summary }
    }

    /// The tables.
    pub fn tables(&self) -> &[Table] {
        &self.results.tables
    }

    /// Writes tables, figures and page.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, record: &Record, folder: &Folder) -> Result<()> {
        folder.write_table(RUNS, &COLUMNS, run_rows(record))?;
        self.results.write(folder, |_| false)?;
        report::write_tables(&self.results, folder)?;
        folder.write_json("summary.json", &self.summary)?;
        folder.write("config.toml", &record.what)?;
        report::write(folder, State::Ended)
    }
}

/// A row of the table of merged runs: seed, replica, collisions, simulated time.
pub type RunRow = (u64, u64, u64, f64);

/// Names of the columns of that table.
const COLUMNS: [&str; 4] = ["seed", "replica", "collisions", "simulated_time"];

/// The rows of the table of merged runs.
pub fn run_rows(record: &Record) -> Vec<RunRow> {
    let row = |(replica, run): (&Replica, &RunRecord)| {
        (replica.seed, replica.number, run.totals.collisions, run.totals.simulated_time)
    };
    record.runs.iter().map(row).collect()
}

#[cfg(test)]
mod tests;
