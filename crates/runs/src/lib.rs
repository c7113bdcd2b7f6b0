//! Runs of scenes: folder, manifest, checkpoints for resuming, series as files, and a page.
//!
//! Internal: a part of the program `carom`. Its public items serve the other crates of it, and
//! change without notice.
//!
//! ```
//! use carom_runs::sampling_times::sampling_times;
//!
//! // A run to t = 1 is sampled each 0.4, and at its end.
//! assert_eq!(sampling_times(0.0, 1.0, 0.4).collect::<Vec<_>>(), [0.4, 0.8, 1.0]);
//! ```

pub mod animation;
pub mod append_file;
pub mod check;
pub mod checkpoint_file;
pub mod clock;
pub mod command_line;
pub mod console;
pub mod convert;
mod curves;
pub mod detect;
pub mod encounters;
pub mod examples;
pub mod exit;
pub mod experiment;
mod figure_lines;
mod file_names;
pub mod finite;
pub mod folder_lock;
mod foreign_frames;
pub mod interruption;
mod invalid_entries;
mod json_object;
pub mod left_out;
pub mod manifest;
pub mod measures;
pub mod memory;
pub mod merge;
pub mod other_run;
pub mod output;
pub mod overrides;
pub mod price;
pub mod progress;
pub mod record;
pub mod reference;
mod remarks;
pub mod report;
pub mod resumable;
pub mod run;
pub mod run_totals;
pub mod sampling_times;
pub mod schedule;
pub mod schema;
pub mod series;
mod terminal;
pub mod units;
mod visible_region;
mod whole_box;
pub mod whole_file;
pub mod work_items;
pub mod written_files;

pub use visible_region::picture_of;

use carom_tables::{Figure, ReportUnits, Summary, with_error};

use crate::{figure_lines::figure_lines, output::Folder};

pub use console::print_line;

/// Prints a line for each figure, unless a JSON object is written.
pub fn print_figures(figures: &[Figure]) {
    if !json_object::is_json() {
        for line in figure_lines(figures) {
            print_line(&line);
        }
    }
}

/// Prints the figures of a run, what is to be said of them, its totals and failed checks, and the
/// path of its page; adds folder, totals, figures and checks to the JSON object, if one is written.
/// Printed figures are in `units`, if some are given.
pub fn conclude(folder: &Folder, summary: &Summary, units: Option<&ReportUnits>) {
    console::put_summary(folder, summary);
    if json_object::is_json() {
        return;
    }
    let totals = &summary.totals;
    print_line(&format!(
        "{}: {} collisions, {:.0} per processor second; energy drift {}, overlapping pairs {}",
        summary.title,
        totals.collisions,
        totals.collisions_per_second,
        with_error(totals.energy_drift, None),
        totals.overlapping_pairs,
    ));
    let mut figures: Vec<Figure> = summary.figures.clone();
    if let Some(units) = units {
        for figure in &mut figures {
            units.apply_to_figure(figure);
        }
        print_line(&units::in_words(units));
    }
    for line in figure_lines(&figures) {
        print_line(&line);
    }
    let figures: Vec<_> = figures.iter().map(|figure| ("", figure)).collect();
    let judged = [
        report::stationarity_in_words(&figures),
        report::tests_in_words(&figures),
    ];
    for words in judged.into_iter().flatten() {
        print_line(&words);
    }
    if !summary.note.is_empty() {
        print_line(&summary.note);
    }
    for check in summary.checks.iter().filter(|check| !check.passed) {
        print_line(&format!(
            "FAILED: {} is {}, allowed is {}",
            check.name, check.found, check.allowed
        ));
    }
    print_line(&format!("{}", folder.path().join("report.html").display()));
}
