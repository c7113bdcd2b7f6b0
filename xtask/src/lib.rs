//! Runners on top of carom: experiments, scenes, encounter files, and checks of the repository itself.

pub mod animation;
pub mod append_file;
pub mod bench;
pub mod billiard;
pub mod brownian;
pub mod canvas;
pub mod capability_cost;
pub mod checkpoint_file;
pub mod chi_square;
pub mod cli;
pub mod detect;
pub mod encounters;
pub mod experiment;
pub mod experiment_encounters;
pub mod experiment_extremes;
pub mod fixed_energy;
pub mod fuzz;
pub mod interruption;
pub mod manifest;
pub mod molecule_picture;
pub mod oracle;
pub mod output;
pub mod overrides;
pub mod page;
pub mod part;
pub mod plot;
pub mod polar;
pub mod power_law;
pub mod progress;
pub mod resumable;
pub mod run;
pub mod sampling_times;
pub mod scatter;
pub mod series;
pub mod summary;
pub mod thesis_tests;
pub mod tidy;
pub mod time_reversal;
pub mod tradeoff;
pub mod work_items;

use std::io::Write as _;

use crate::{output::Folder, page::with_error, summary::Summary};

/// A line to whoever started the program.
pub fn say(text: &str) {
    // A reader who has gone away misses nothing that is not in the files.
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// The end of a run: what failed, and where to look.
pub fn conclude(folder: &Folder, summary: &Summary) {
    let totals = &summary.totals;
    say(&format!(
        "{}: {} collisions, {:.0} per processor second; energy drift {}, overlapping pairs {}",
        summary.title,
        totals.collisions,
        totals.collisions_per_second,
        with_error(totals.energy_drift, None),
        totals.overlapping_pairs,
    ));
    for check in summary.checks.iter().filter(|check| !check.passed) {
        say(&format!("FAILED: {} is {}, allowed is {}", check.name, check.found, check.allowed));
    }
    say(&format!("{}", folder.path().join("report.html").display()));
}
