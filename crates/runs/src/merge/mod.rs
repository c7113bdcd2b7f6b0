//! `carom merge`: the results of several replicas of a scene as those of one long run.

mod average;
mod calibration;
mod parts;
mod rebin;

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Result, ensure};
pub use average::results as merged;
pub use calibration::calibrations;
use carom::Scene;
use carom_tables::{Figure, Replica, Summary, SummaryFile, Table, Totals, Verdict};
use clap::Args;
use parts::MergedParts;
use serde::Serialize;
use serde_json::Value;

use crate::{
    command_line::command,
    left_out::{LeftOut, announce},
    manifest::Manifest,
    measures::Results,
    output::{Destination, Folder, is_same_folder},
    record::{MeasureRecord, Record, RunRecord},
    report::{self, FolderState, RUNS, few_samples_in_words},
    units::units,
};

/// Options of `carom merge`.
#[derive(Debug, Clone, Args)]
pub struct MergeOptions {
    /// Folders of runs of one scene with different seeds or replicas, or of merged runs
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// Output folder and its treatment
    #[command(flatten)]
    pub destination: Destination,
}

/// Merges the runs and writes a folder with their tables, figures and page. Runs that have not
/// ended
/// and damaged sums are left out; the verdict is then [`Verdict::Incomplete`].
///
/// # Errors
/// A folder holds no run or is the output folder, no run is left, the scenes differ, a run is there
/// twice, another process writes into a folder, or a file cannot be written.
pub fn run(options: &MergeOptions) -> Result<Verdict> {
    let path = options.destination.folder("out/merge");
    for source in &options.folders {
        ensure!(
            !is_same_folder(source, &path),
            "{} is one of the folders to merge: choose another with --out",
            path.display()
        );
    }
    let MergedParts {
        record,
        folders: kept,
        left_out,
    } = parts::read(&options.folders)?;
    let (folder, _lock) = Folder::claim(&path, options.destination.existing())?;
    let manifest = Manifest::write_new(&folder, &again(&options.folders, &path), &[])?;
    let seconds = kept.into_iter().map(seconds_of).sum();
    record.write(&folder)?;
    let mut merged = MergedRuns::new(
        &record,
        format!("{} merged runs", record.runs.len()),
        seconds,
    );
    merged.left_out = left_out;
    merged.write(&record, &folder)?;
    let MergedRuns {
        summary, left_out, ..
    } = merged;
    manifest.complete(&folder, summary.totals.cpu_seconds())?;
    announce(&left_out.missing, &left_out.damaged, &left_out.words());
    let units = units(&Scene::from_toml(&record.what)?)?;
    crate::conclude(&folder, &summary, units.as_ref());
    let verdict = summary.verdict();
    Ok(if left_out.is_empty() {
        verdict
    } else {
        verdict.of_incomplete()
    })
}

/// The command that merges these folders into `path`.
pub fn again(folders: &[PathBuf], path: &Path) -> String {
    let words = ["merge".as_ref()]
        .into_iter()
        .chain(folders.iter().map(|folder| folder.as_os_str()));
    command(words.chain(["--out".as_ref(), path.as_os_str()]))
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
    /// What the folders of the runs lack.
    pub left_out: LeftOut,
}

/// `summary.json` of merged runs.
#[derive(Debug, Serialize)]
struct MergedFile<'a> {
    #[serde(flatten)]
    summary: SummaryFile<'a>,
    #[serde(flatten)]
    left_out: &'a LeftOut,
}

impl MergedRuns {
    /// The results of the runs of a record, which took `seconds` of processor time.
    pub fn new(record: &Record, title: String, seconds: f64) -> Self {
        let results = average::results(record);
        let totals: Vec<Totals> = record.runs.values().map(|run| run.totals).collect();
        let totals = Totals::sum(&totals);
        let totals = Totals {
            collisions_per_second: totals.collisions as f64 / seconds.max(1e-9),
            ..totals
        };
        let mut notes = record.runs.values().map(|run| &run.note);
        let note = notes.find(|note| !note.is_empty()).cloned();
        let few = few_samples_in_words(&results.figures);
        let summary = Summary {
            title,
            note: note.into_iter().chain(few).collect::<Vec<_>>().join(" "),
            totals,
            checks: totals
                .checks()
                .into_iter()
                .chain(results.figures.iter().filter_map(Figure::check))
                .collect(),
            figures: results.figures.clone(),
            runs: Vec::new(),
        };
        Self {
            results,
            summary,
            left_out: LeftOut::default(),
        }
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
        folder.write_table(FIGURES_BY_RUN, &FIGURE_COLUMNS, figure_rows(record))?;
        self.results.write(folder)?;
        report::write_tables(&self.results, folder)?;
        let Self {
            summary, left_out, ..
        } = self;
        let summary = SummaryFile::new(summary);
        folder.write_json("summary.json", &MergedFile { summary, left_out })?;
        folder.write("config.toml", &record.what)?;
        report::write(folder, FolderState::Ended)
    }
}

/// A row of the table of merged runs: seed, replica, collisions, simulated time.
pub type RunRow = (u64, u64, u64, f64);

/// The figures of each merged run.
const FIGURES_BY_RUN: &str = "figures-by-run.csv";

/// Names of the columns of that table.
const FIGURE_COLUMNS: [&str; 6] = [
    "seed",
    "replica",
    "figure",
    "value",
    "standard_error",
    "unit",
];

/// A row for each figure of each run: seed, replica, name, value, standard error and unit.
fn figure_rows(record: &Record) -> Vec<(u64, u64, String, f64, Option<f64>, String)> {
    let of_run = |(replica, run): (&Replica, &RunRecord)| {
        let of_measures = run.measures.iter().flat_map(MeasureRecord::all_figures);
        let figures = run.figures.iter().chain(of_measures).cloned();
        let (seed, number) = (replica.seed, replica.number);
        let row = |figure: Figure| {
            let Figure {
                name,
                value,
                standard_error,
                unit,
                ..
            } = figure;
            (seed, number, name, value, standard_error, unit)
        };
        figures.map(row).collect::<Vec<_>>()
    };
    record.runs.iter().flat_map(of_run).collect()
}

/// Names of the columns of that table.
const COLUMNS: [&str; 4] = ["seed", "replica", "collisions", "simulated_time"];

/// The rows of the table of merged runs.
pub fn run_rows(record: &Record) -> Vec<RunRow> {
    let row = |(replica, run): (&Replica, &RunRecord)| {
        (
            replica.seed,
            replica.number,
            run.totals.collisions,
            run.totals.simulated_time,
        )
    };
    record.runs.iter().map(row).collect()
}

#[cfg(test)]
mod tests;
