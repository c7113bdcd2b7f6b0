//! Execution of the experiment: flights, comparison with the prediction, and output files.

use anyhow::Result;
use carom_runs::{
    experiment::{Experiment, Opening},
    print_line,
};
use carom_tables::{Summary, Verdict};

use super::{Options, flights::fly, report, results::Comparison};

/// Runs the experiment and writes its folder.
///
/// # Errors
/// An option is invalid, the folder is not empty, or a run fails.
pub fn run(options: &Options) -> Result<Verdict> {
    let setup = options.setup()?;
    let command = options.command(&setup);
    let scenes = (0..setup.flights()).map(|replica| setup.scene(replica)).collect::<Result<Vec<_>>>()?;
    let head = format!("# Written by `{command}`: the first of {} flights.\n\n", scenes.len());
    let experiment = Experiment::begin_resumable(
        &options.common.destination,
        options.what(&setup),
        &Opening {
            folder: &options.usual_folder(),
            note: &options.note(),
            command: &command,
            configuration: head + &scenes[0].to_toml(),
            scenes: &scenes.iter().collect::<Vec<_>>(),
        },
    )?;
    let folder = &experiment.folder;
    let hits = options.threads.pool()?.install(|| fly(&setup, &experiment.items))?;
    let comparison = Comparison::new(&setup, &hits);
    let summary = Summary {
        title: format!("Billiard around a fixed {}", setup.shape),
        note: options.note(),
        totals: hits.totals,
        checks: comparison.checks(&setup, &hits),
        figures: comparison.figures(&setup, &hits),
        runs: Vec::new(),
    };
    report::write(folder, &setup, &hits, &comparison, &summary, &command)?;
    folder.write_json("summary.json", &summary)?;
    for figure in &summary.figures[..4] {
        print_line(&format!(
            "{}: {}",
            figure.name,
            carom_report::page::with_error(figure.value, figure.standard_error)
        ));
    }
    carom_runs::conclude(&experiment.complete_after(summary.totals.cpu_seconds())?, &summary);
    Ok(summary.verdict())
}
