//! The page of a sweep: how much is done, the main charts, a table of all points, and their pages.

use std::fmt::Write as _;

use anyhow::Result;
use carom_report::page::{Page, PagePart, checks_in_words};
use carom_runs::{
    left_out::Damaged,
    output::Folder,
    report::{PAGE, stationarity_in_words, tests_in_words},
};
use carom_tables::Summary;

use crate::{
    charts::{charts, overlaid},
    errors,
    expect::{EXPECTATIONS, ExpectationAnswer},
    layout::{STUDY, SweepFolder},
    missing::Missing,
    motion,
    results::{self, PointResults},
    study::Study,
    table::{TABLE, on_page, tests_on_page},
};

/// Charts that lead the page.
const LEADING: usize = 2;

/// What a page shows besides the points.
#[derive(Debug)]
pub struct PageFrame<'a> {
    /// Totals and checks.
    pub summary: &'a Summary,
    /// What has not been done.
    pub missing: &'a Missing,
    /// Replicas that ended with an error, in words.
    pub failures: &'a [String],
    /// Files of replicas that cannot be used.
    pub damaged: &'a [Damaged],
    /// Remarks, such as replicas that were there twice.
    pub notes: &'a [String],
    /// The command that continues or repeats the sweep.
    pub again: &'a str,
}

/// Writes the page.
///
/// # Errors
/// A chart cannot be drawn, or the file cannot be written.
pub fn write(
    folder: &Folder,
    study: &Study,
    points: &[PointResults],
    frame: &PageFrame<'_>,
) -> Result<()> {
    let mut page = Page::new(&frame.summary.title, &lead(study));
    page.verdict(&verdict(study, points, frame));
    show_remarks(&mut page, study, frame);
    let (mut all, left_out) = charts(study, points)?;
    let others = all.split_off(LEADING.min(all.len()));
    page.part(PagePart::Answer);
    failures(&mut page, points);
    page.charts(&all);
    curves(&mut page, points);
    if let Some(first) = study
        .points
        .first()
        .filter(|_| points.iter().any(|point| !point.evidence.is_empty()))
    {
        motion::show(&mut page, first);
    }
    page.part(PagePart::Results);
    expectations(&mut page, study, points);
    page.heading("All points");
    let (header, rows) = on_page(study, points);
    page.table(
        &header.iter().map(String::as_str).collect::<Vec<_>>(),
        &rows,
    );
    smallest_differences(&mut page, study, points);
    let overlaid = overlaid(points)?;
    if !overlaid.is_empty() {
        page.heading("The curves of all points");
        page.charts(&overlaid);
    }
    page.heading("All figures");
    page.charts(&others);
    if left_out > 0 {
        page.paragraph(&format!("{left_out} more figures are in {TABLE}."));
    }
    errors::show(&mut page, points);
    page.files(&list_files(points));
    page.code(frame.again);
    page.folded("The study, study.toml", &study.text());
    page.checks(&results::checks(points));
    page.totals(&frame.summary.totals);
    folder.write_lasting(PAGE, page.html())
}

/// What went wrong, what is missing, and the notes of the sweep, at the head of the page.
fn show_remarks(page: &mut Page, study: &Study, frame: &PageFrame<'_>) {
    frame
        .failures
        .iter()
        .for_each(|failure| page.error(failure));
    if !frame.missing.is_empty() {
        page.error(&frame.missing.words(study));
    }
    frame
        .damaged
        .iter()
        .for_each(|damaged| page.error(&damaged.words()));
    if !frame.summary.note.is_empty() {
        page.note(&frame.summary.note);
    }
    frame.notes.iter().for_each(|note| page.note(note));
}

/// The files of the sweep and the pages of its points, each with what it holds.
fn list_files(points: &[PointResults]) -> Vec<(String, String)> {
    let mut files = vec![
        (
            TABLE.to_owned(),
            "all figures of all points, with errors and predictions".to_owned(),
        ),
        (
            "summary.json".to_owned(),
            "figures, totals and checks of all points".to_owned(),
        ),
        (
            STUDY.to_owned(),
            "the study, with the scene and all values".to_owned(),
        ),
    ];
    if errors::are_compared(points) {
        files.push((
            errors::FILE.to_owned(),
            "standard errors over the scatter of replicas".to_owned(),
        ));
    }
    let with_page = points.iter().filter(|results| !results.replicas.is_empty());
    files.extend(with_page.map(|results| {
        (
            format!("{}/{PAGE}", SweepFolder::point_name(results.point)),
            results.label.clone(),
        )
    }));
    files
}

/// The main charts of each point, where there are few.
fn curves(page: &mut Page, points: &[PointResults]) {
    for point in points.iter().filter(|point| !point.evidence.is_empty()) {
        if points.len() > 1 {
            page.subheading(&point.short_label());
        }
        page.charts(&point.evidence);
    }
}

/// The quantities that are not as expected.
fn failures(page: &mut Page, points: &[PointResults]) {
    let failed: Vec<_> = answers(points)
        .into_iter()
        .filter(|(_, answer)| answer.has_failed())
        .collect();
    if !failed.is_empty() {
        page.heading("Not as expected");
        page.table(&EXPECTATIONS, &failed.iter().map(row).collect::<Vec<_>>());
    }
}

/// All quantities of which something is expected.
fn expectations(page: &mut Page, study: &Study, points: &[PointResults]) {
    let answers = answers(points);
    let untested = study.expected_answers() - answers.len();
    if answers.is_empty() && untested == 0 {
        return;
    }
    page.heading("Expectations");
    page.table(&EXPECTATIONS, &answers.iter().map(row).collect::<Vec<_>>());
    if untested > 0 {
        page.paragraph(&format!(
            "{untested} more are not tested: their points have no replicas yet."
        ));
    }
}

/// The figures that test their predictions, with the smallest differences that would have been
/// found.
fn smallest_differences(page: &mut Page, study: &Study, points: &[PointResults]) {
    let (header, rows) = tests_on_page(study, points);
    if !rows.is_empty() {
        page.heading("Smallest differences that would have been found");
        page.paragraph(
            "A difference from the prediction counts as found above 4 standard errors; one of the smallest \
             size would have been found with probability 0.95.",
        );
        page.table(
            &header.iter().map(String::as_str).collect::<Vec<_>>(),
            &rows,
        );
    }
}

fn answers(points: &[PointResults]) -> Vec<(&PointResults, &ExpectationAnswer)> {
    points
        .iter()
        .flat_map(|point| point.answers.iter().map(move |answer| (point, answer)))
        .collect()
}

fn row(&(point, answer): &(&PointResults, &ExpectationAnswer)) -> Vec<String> {
    answer.cells(point.short_label())
}

/// What was varied.
fn lead(study: &Study) -> String {
    let question = study.question.iter().map(|question| format!("{question} "));
    let plural = if study.replicas == 1 {
        "replica"
    } else {
        "replicas"
    };
    let mut lead =
        question.collect::<String>() + &format!("{} {plural} of each point.", study.replicas);
    for vary in &study.vary {
        let count = vary.settings.len();
        let plural = if count == 1 { "value" } else { "values" };
        let name = vary
            .label
            .clone()
            .unwrap_or_else(|| vary.keys.join(" with "));
        let _ = write!(lead, " {count} {plural} of {name}.");
    }
    lead.push_str(
        " Dots are means over all replicas, bars two standard errors, rings predictions and what is \
         expected. Errors are from the blocks of all replicas.",
    );
    lead
}

/// What changed during the measurements, and the verdict on the figures of all points that test
/// their predictions, in sentences.
pub fn judgements(study: &Study, points: &[PointResults]) -> Vec<String> {
    let names: Vec<String> = (0..points.len()).map(|point| study.name(point)).collect();
    let named = names.iter().zip(points);
    let figures: Vec<_> = named
        .flat_map(|(name, point)| {
            point
                .figures
                .iter()
                .map(move |figure| (name.as_str(), figure))
        })
        .collect();
    stationarity_in_words(&figures)
        .into_iter()
        .chain(tests_in_words(&figures))
        .collect()
}

fn verdict(study: &Study, points: &[PointResults], frame: &PageFrame<'_>) -> String {
    let totals = &frame.summary.totals;
    let done: usize = points.iter().map(|results| results.replicas.len()).sum();
    let complete = frame.missing.complete_points(points.len());
    let state = if frame.missing.is_empty() {
        if complete == 1 {
            "The point is complete".to_owned()
        } else {
            format!("All {complete} points are complete")
        }
    } else {
        format!("Incomplete: {complete} of {} points", points.len())
    };
    let exact = if frame.summary.note.contains(carom_runs::report::NOT_EXACT) {
        "NOT EXACT"
    } else {
        "exact"
    };
    let judged = judgements(study, points)
        .into_iter()
        .fold(String::new(), |all, words| all + &words + " ");
    let plural = if done == 1 { "" } else { "s" };
    format!(
        "{judged}{state}, with {done} replica{plural} and {} {exact} collisions. {}",
        totals.collisions,
        checks_in_words(&frame.summary.checks)
    )
}
