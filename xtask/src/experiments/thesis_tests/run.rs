//! Execution of a test: measurement of all cases, and output files.

use anyhow::Result;
use carom_runs::{
    experiment::{Experiment, Opening, configuration},
    output::Folder,
    work_items::WorkItems,
};
use carom_tables::{Summary, Totals, Verdict};

use super::{
    ThesisTestsOptions, report,
    results::{Test, ThesisResults},
    timing::ThesisTiming,
};

/// Measures with the time limit of each case (seconds) and writes the folder.
///
/// # Errors
/// The folder is not empty or cannot be written, or a run fails.
pub fn run_test(
    test: &Test,
    options: &ThesisTestsOptions,
    measure: impl FnOnce(f64, &WorkItems) -> Result<ThesisResults>,
) -> Result<Verdict> {
    let command = options.command(test.name);
    let experiment = Experiment::start_resumable(
        &options.common.destination,
        command.clone(),
        &Opening {
            folder: &format!("out/{}", test.name),
            note: &options.note(),
            command: &command,
            configuration: configuration(&command, ""),
            scenes: &[],
        },
    )?;
    let folder = &experiment.folder;
    let results = measure(options.budget(), &experiment.items)?;
    let totals: Vec<Totals> = results.timings.iter().map(|timing| timing.totals).collect();
    let totals = Totals::sum(&totals);
    let summary = Summary {
        title: test.title.to_owned(),
        note: options.note(),
        totals,
        checks: totals.checks(),
        figures: results.figures.clone(),
        runs: Vec::new(),
    };
    let charts: Vec<String> = results
        .charts
        .iter()
        .map(|costs| report::chart(test, costs))
        .collect::<Result<_>>()?;
    for (costs, chart) in results.charts.iter().zip(&charts) {
        folder.write(costs.file, chart)?;
    }
    write_times(folder, &results.timings)?;
    let seconds = results
        .timings
        .iter()
        .map(|timing| timing.whole.seconds)
        .sum();
    let page = report::page(test, &results, &summary, &charts, &command);
    experiment.finish(&page, &summary, Some(seconds))
}

fn write_times(folder: &Folder, timings: &[ThesisTiming]) -> Result<()> {
    let rows = timings.iter().map(|timing| {
        let ThesisTiming {
            engine,
            size,
            whole,
            ..
        } = timing;
        let (extrapolated, error) = timing.for_thesis_time().unzip();
        (
            engine,
            size,
            whole.time,
            whole.collisions,
            whole.queries,
            whole.seconds,
            extrapolated,
            error.flatten(),
        )
    });
    let header = [
        "engine",
        "size",
        "simulated_time",
        "collisions",
        "queries",
        "cpu_seconds",
        "cpu_seconds_for_100",
        "standard_error",
    ];
    folder.write_table("times.csv", &header, rows)
}
