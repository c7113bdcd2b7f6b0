//! `carom merge`: the results of several replicas of a scene as those of one long run.

mod average;

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use carom_report::page::Page;
use carom_tables::{Summary, Totals, Verdict};
use clap::Args;
use serde_json::Value;

use crate::{
    manifest::{Manifest, program},
    output::{Destination, Folder},
    record::{Record, SUMS},
    run::outcome::{describe_tables, draw_tables},
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
/// A folder has no sums, the scenes differ, a run is there twice, or a file cannot be written.
pub fn run(options: &Options) -> Result<Verdict> {
    let mut record: Option<Record> = None;
    for folder in &options.folders {
        let part = Record::read(folder)?;
        match &mut record {
            None => record = Some(part),
            Some(all) => all.merge(part).with_context(|| format!("cannot merge {}", folder.display()))?,
        }
    }
    let record = record.context("there are no folders")?;
    let folder = Folder::create(&options.destination.folder("out/merge"), options.destination.existing())?;
    let folders: Vec<String> = options.folders.iter().map(|folder| folder.display().to_string()).collect();
    let command = format!("{} merge {}", program(), folders.join(" "));
    let manifest = Manifest::begin(&folder, &command, &[])?;
    let seconds = options.folders.iter().map(|folder| seconds_of(folder)).sum();
    let summary = write(&record, &folder, &command, seconds)?;
    manifest.complete(&folder, summary.totals.cpu_seconds())?;
    crate::conclude(&folder, &summary);
    Ok(summary.verdict())
}

/// Processor time of the runs in a folder, from its summary; 0 without one (seconds).
fn seconds_of(folder: &Path) -> f64 {
    let text = fs::read_to_string(folder.join("summary.json")).unwrap_or_default();
    let summary: Value = serde_json::from_str(&text).unwrap_or_default();
    let number = |key: &str| summary[key].as_f64().unwrap_or(0.0);
    let (collisions, speed) = (number("collisions"), number("collisions_per_second"));
    if speed > 0.0 { collisions / speed } else { 0.0 }
}

/// Writes tables, figures, sums and page of merged runs, which took `seconds` of processor time.
fn write(record: &Record, folder: &Folder, command: &str, seconds: f64) -> Result<Summary> {
    let results = average::results(record);
    let totals: Vec<Totals> = record.runs.values().map(|run| run.totals).collect();
    let totals = Totals::of(&totals);
    let totals = Totals { collisions_per_second: totals.collisions as f64 / seconds.max(1e-9), ..totals };
    let runs = record.runs.iter().map(|(replica, run)| {
        let numbers = [replica.seed, replica.number, run.totals.collisions].map(|number| number.to_string());
        [numbers.to_vec(), vec![run.totals.simulated_time.to_string()]].concat()
    });
    let runs: Vec<Vec<String>> = runs.collect();
    let notes = record.runs.values().map(|run| &run.note);
    let summary = Summary {
        title: format!("{} merged runs", record.runs.len()),
        note: notes.into_iter().find(|note| !note.is_empty()).cloned().unwrap_or_default(),
        totals,
        checks: totals.checks(),
        figures: results.figures.clone(),
        runs: Vec::new(),
    };
    results.write(folder, |_| false)?;
    describe_tables(&results, folder)?;
    folder.write_json("summary.json", &summary)?;
    folder.write("config.toml", &record.what)?;
    record.write(folder)?;
    let lead = "Means of all runs, with errors from the blocks of all runs. What is no mean of sums is averaged \
                over the runs, with the error of its scatter among them.";
    let mut page = Page::new(&summary.title, lead);
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.heading("Results");
    page.totals(&summary.totals);
    page.figures(&summary.figures);
    page.subheading("Checks");
    page.checks(&summary.checks);
    draw_tables(&results, &mut page)?;
    page.heading("Runs");
    page.table(&["seed", "replica", "collisions", "simulated time"], &runs);
    page.heading("Data");
    page.links(["config.toml", "summary.json", "tables.json", "manifest.json", SUMS]);
    page.heading("Reproduction");
    page.code(command);
    folder.write("report.html", page.html())?;
    Ok(summary)
}

#[cfg(test)]
mod tests;
