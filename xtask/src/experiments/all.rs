//! All experiments one after another, each a process of this program, and one table of their
//! verdicts.

use std::{
    process::{Command, Stdio},
    time::Instant,
};

use crate::experiments::common::Common;
use anyhow::{Context, Result};
use carom_report::page::{Page, PagePart};
use carom_runs::{
    interruption::Signals,
    output::{Destination, Folder},
    print_line,
};
use carom_tables::Verdict;
use clap::Args;
use serde::Serialize;
use serde_json::{Value, json};

/// The experiments, cheap ones first. Those of the thesis's tests and of capability costs measure
/// times alone, on an idle machine, and are left out.
const EXPERIMENTS: [&str; 14] = [
    "relaxation",
    "cooling",
    "heating",
    "thermostat",
    "virial",
    "freezing",
    "equilibrium",
    "depletion",
    "diffusion",
    "ratchet",
    "billiard",
    "brownian",
    "encounters",
    "extremes",
];

/// File of the verdicts.
const SUMMARY: &str = "summary.json";

/// Options of `cargo xtask experiment all`.
#[derive(Debug, Clone, Args)]
#[command(
    mut_arg("quick", |arg| arg.help("The short form of each, twenty minutes together (the default)")),
    mut_arg("paper", |arg| arg.help("Each for publication, up to half an hour"))
)]
pub struct AllOptions {
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<Destination>,
}

/// How an experiment ended.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Row {
    /// Name of the experiment with its options.
    name: &'static str,
    /// Folder inside.
    folder: String,
    verdict: String,
    checks: usize,
    /// Checks that failed, or the error.
    reasons: Vec<String>,
    seconds: f64,
}

/// Runs all experiments and prints the table.
///
/// # Errors
/// The folder cannot be written, a process cannot be started, or a signal has been received.
pub fn run(options: &AllOptions) -> Result<Verdict> {
    let common = &options.common;
    let (folder, _lock) = Folder::claim(
        &common.destination.folder("out/all"),
        common.destination.existing(),
    )?;
    let signals = Signals::watch()?;
    let mut rows = Vec::new();
    for name in EXPERIMENTS {
        let row = experiment(name, &folder, common.size())?;
        signals.check()?;
        print_line(&format!(
            "{:<32}{:<9}{:>4} checks {:>7.1} s",
            row.name, row.verdict, row.checks, row.seconds
        ));
        row.reasons
            .iter()
            .for_each(|reason| print_line(&format!("    {reason}")));
        rows.push(row);
    }
    folder.write_json(SUMMARY, &json!({ "experiments": rows }))?;
    write_page(&folder, &rows, common)?;
    let has_passed = rows.iter().all(|row| row.verdict == "passed");
    Ok(if has_passed {
        Verdict::Passed
    } else {
        Verdict::Failed
    })
}

/// Runs one experiment in a folder inside.
fn experiment(name: &'static str, folder: &Folder, size: &str) -> Result<Row> {
    let program = std::env::current_exe().context("the path of this program is unknown")?;
    let begun = Instant::now();
    let inside = folder_name(name);
    let output = Command::new(program)
        .arg("experiment")
        .args(name.split(' '))
        .args([size, "--force", "--quiet", "--json", "--out"])
        .arg(folder.path().join(&inside))
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("cannot start the experiment {name}"))?;
    let seconds = begun.elapsed().as_secs_f64();
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    let checks = answer["checks"].as_array().map_or(&[][..], Vec::as_slice);
    let failed = checks.iter().filter(|check| check["passed"] != true);
    let mut reasons: Vec<String> = failed
        .filter_map(|check| check["name"].as_str().map(str::to_owned))
        .collect();
    reasons.extend(answer["error"].as_str().map(str::to_owned));
    let verdict = answer["verdict"].as_str().unwrap_or("error").to_owned();
    Ok(Row {
        name,
        folder: inside,
        verdict,
        checks: checks.len(),
        reasons,
        seconds,
    })
}

/// The folder of an experiment: its name and the values of its options.
fn folder_name(name: &str) -> String {
    name.split(' ')
        .map(|word| word.trim_start_matches('-'))
        .collect::<Vec<_>>()
        .join("-")
}

fn write_page(folder: &Folder, rows: &[Row], common: &Common<Destination>) -> Result<()> {
    let failed = rows.iter().filter(|row| row.verdict != "passed").count();
    let mut page = Page::new(
        "All experiments",
        "Each experiment with its checks; their pages are linked below.",
    );
    page.verdict(&match failed {
        0 => format!("All {} experiments passed.", rows.len()),
        _ => format!("{failed} of {} experiments did not pass.", rows.len()),
    });
    for row in rows {
        row.reasons
            .iter()
            .for_each(|reason| page.error(&format!("{}: {reason}", row.name)));
    }
    page.part(PagePart::Answer);
    let cells = |row: &Row| {
        let seconds = format!("{:.1}", row.seconds);
        vec![
            row.name.to_owned(),
            row.verdict.clone(),
            row.checks.to_string(),
            seconds,
        ]
    };
    page.table(
        &["experiment", "verdict", "checks", "time (s)"],
        &rows.iter().map(cells).collect::<Vec<_>>(),
    );
    let link = |row: &Row| {
        (
            format!("{}/report.html", row.folder),
            format!("the page of {}", row.name),
        )
    };
    let mut files: Vec<_> = rows.iter().map(link).collect();
    files.push((SUMMARY.to_owned(), "this table".to_owned()));
    page.files(&files);
    page.code(&common.command("all"));
    folder.write("report.html", page.html())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_experiment_has_a_folder_of_its_own() {
        let folders: std::collections::BTreeSet<_> = EXPERIMENTS.map(folder_name).into();
        assert_eq!(folders.len(), EXPERIMENTS.len());
    }
}
