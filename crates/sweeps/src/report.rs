//! The results of a sweep in its folder: table, summary and page, and the same on the terminal.

use std::collections::BTreeMap;

use anyhow::Result;
use carom_runs::{
    conclude,
    console::is_json,
    left_out::{Damaged, announce},
    manifest::Manifest,
    print_figures, print_line,
};
use carom_tables::{Summary, Totals, Verdict, are_stationary};
use rayon::ThreadPool;
use serde::Serialize;

use crate::{
    errors,
    layout::{Shards, SweepFolder},
    missing::{Missing, MissingOfPoint},
    page::{self, PageFrame},
    results::{self, PointResults},
    study::Study,
    table,
};

/// Most replicas that ended with an error and are named.
const MAX_FAILURES: usize = 8;

/// What is known besides the files in the folder.
#[derive(Debug, Default)]
pub struct Remarks {
    /// Replicas that ended with an error, in words.
    pub failures: Vec<String>,
    /// Remarks for the reader.
    pub notes: Vec<String>,
    /// Files of replicas that cannot be used.
    pub damaged: Vec<Damaged>,
}

impl Remarks {
    /// Keeps the first failures, and says how many more there are.
    fn shorten_failures(&mut self) {
        let more = self.failures.len().saturating_sub(MAX_FAILURES);
        self.failures.truncate(MAX_FAILURES);
        if more > 0 {
            self.failures
                .push(format!("{more} more replicas ended with an error."));
        }
    }
}

/// `summary.json`.
#[derive(Debug, Serialize)]
struct File<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    /// Whether no figure changed during its measurement.
    stationary: Option<bool>,
    /// Number of points of the study, and of those that are complete.
    points_wanted: usize,
    points_complete: usize,
    replicas_wanted: u64,
    missing: &'a [MissingOfPoint<'a>],
    damaged: &'a [Damaged],
    /// The units of the columns of `table.csv`.
    units: BTreeMap<String, String>,
    points: &'a [PointResults],
}

/// Merges the replicas of each point, writes pages, table and summary, and prints the totals. The
/// manifest says that the folder is complete only after table, summary and page are on disk.
/// Returns [`Verdict::Incomplete`] if replicas are missing.
///
/// # Errors
/// A file cannot be read or written.
pub fn write(
    sweep: &SweepFolder,
    study: &Study,
    shards: &Shards,
    (manifest, again): (Manifest, &str),
    mut remarks: Remarks,
    pool: &ThreadPool,
) -> Result<Verdict> {
    let points = results::of_points(sweep, study, (&manifest, again), pool)?;
    let missing = Missing::new(study, &points, shards);
    remarks.shorten_failures();
    let summary = summary(study, &points);
    let folder = &sweep.folder;
    table::write(folder, study, &points)?;
    errors::write(folder, &points)?;
    let file = File {
        summary: &summary,
        stationary: are_stationary(points.iter().flat_map(|point| &point.figures)),
        points_wanted: points.len(),
        points_complete: missing.complete_points(points.len()),
        replicas_wanted: study.replicas,
        missing: &missing.by_point(study),
        damaged: &remarks.damaged,
        units: table::units(&points),
        points: &points,
    };
    folder.write_lasting("summary.json", serde_json::to_string_pretty(&file)? + "\n")?;
    let Remarks {
        failures,
        notes,
        damaged,
    } = &remarks;
    let frame = PageFrame {
        summary: &summary,
        missing: &missing,
        failures,
        damaged,
        notes,
        again,
    };
    page::write(folder, study, &points, &frame)?;
    manifest.complete(folder, summary.totals.cpu_seconds())?;
    announce_remarks(study, points.len(), &missing, &remarks);
    if !is_json() {
        print_judgements(study, &points);
    }
    // The figures of one point are those of the sweep.
    if let [only] = &points[..] {
        print_figures(&only.figures);
    }
    conclude(folder, &summary, None);
    let verdict = summary.verdict();
    Ok(if missing.is_empty() {
        verdict
    } else {
        verdict.of_incomplete()
    })
}

/// Announces what is missing and damaged, and the notes; `count` is the number of points.
fn announce_remarks(study: &Study, count: usize, missing: &Missing, remarks: &Remarks) {
    let Remarks { notes, damaged, .. } = remarks;
    let lacking = (!missing.is_empty()).then(|| {
        format!(
            "Incomplete: {} of {count} points. {}",
            missing.complete_points(count),
            missing.words(study)
        )
    });
    let words: Vec<String> = lacking
        .into_iter()
        .chain(damaged.iter().map(Damaged::words))
        .chain(notes.iter().cloned())
        .collect();
    announce(&missing.by_point(study), damaged, &words);
}

/// Prints how many expectations are met, and what is to be said of the figures.
fn print_judgements(study: &Study, points: &[PointResults]) {
    let answers = || points.iter().flat_map(|point| &point.answers);
    let judged = study.expected_answers() - answers().filter(|answer| answer.show_only).count();
    if judged > 0 {
        let met = answers()
            .filter(|answer| answer.passed && !answer.show_only)
            .count();
        print_line(&format!("{met} of {judged} expectations are met"));
    }
    for words in page::judgements(study, points) {
        print_line(&words);
    }
}

fn summary(study: &Study, points: &[PointResults]) -> Summary {
    let totals: Vec<Totals> = points.iter().map(|results| results.totals).collect();
    let notes = points.iter().map(|results| &results.note);
    let plural =
        |count: usize, one: &str| format!("{count} {one}{}", if count == 1 { "" } else { "s" });
    let replicas: usize = points.iter().map(|results| results.replicas.len()).sum();
    let (of_points, of_replicas) = (
        plural(study.points.len(), "point"),
        plural(replicas, "replica"),
    );
    Summary {
        title: study
            .title
            .clone()
            .unwrap_or_else(|| format!("Sweep of {of_points} with {of_replicas}")),
        note: notes
            .into_iter()
            .find(|note| !note.is_empty())
            .cloned()
            .unwrap_or_default(),
        totals: Totals::sum(&totals),
        checks: [results::checks(points), results::expected(points)].concat(),
        figures: Vec::new(),
        runs: Vec::new(),
    }
}
