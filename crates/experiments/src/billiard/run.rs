//! Execution of the experiment: flights, comparison with the prediction, and output files.

use anyhow::Result;
use carom_methods::AnySimulation;
use carom_runs::{
    experiment::{Experiment, Opening},
    print_line,
};
use carom_tables::{Summary, Verdict};

use super::{Mover, Options, Setup, flights::fly, report, results::Comparison};

/// Runs the experiment and writes its folder. `note` is printed and shown first; it may be empty.
///
/// # Errors
/// An option is invalid, the folder is not empty, or a run fails.
pub fn run(options: &Options, note: &str) -> Result<Verdict> {
    let setup = options.setup()?;
    let command = options.command(&setup);
    let scenes = (0..setup.flights()).map(|replica| setup.scene(replica)).collect::<Result<Vec<_>>>()?;
    // Refused before a folder is made; all flights have the same bodies.
    AnySimulation::new(&scenes[0])?;
    let head = format!("# Written by `{command}`: the first of {} flights.\n\n", scenes.len());
    let experiment = Experiment::begin_resumable(
        &options.destination,
        options.what(&setup)?,
        &Opening {
            folder: &options.usual_folder(&setup),
            note,
            command: &command,
            configuration: head + &scenes[0].to_toml(),
            scenes: &scenes.iter().collect::<Vec<_>>(),
        },
    )?;
    let hits = options.threads.pool()?.install(|| fly(&setup, &experiment.items))?;
    let comparison = Comparison::new(&setup, &hits);
    let summary = Summary {
        title: title(&setup),
        note: note.to_owned(),
        totals: hits.totals,
        checks: comparison.checks(&setup, &hits),
        figures: comparison.figures(&setup, &hits),
        runs: Vec::new(),
    };
    let page = report::write(&experiment.folder, &setup, &hits, &comparison, &summary, &command)?;
    for figure in &summary.figures[..4] {
        print_line(&format!(
            "{}: {}",
            figure.name,
            carom_report::page::with_error(figure.value, figure.standard_error)
        ));
    }
    experiment.finish(&page, &summary, Some(summary.totals.cpu_seconds()))
}

fn title(setup: &Setup) -> String {
    let (name, several) = (&setup.named.spec.shape, setup.obstacles.count > 1);
    let name = name.as_ref().unwrap_or(&setup.named.name);
    match setup.mover {
        Mover::Disc if several => format!("Billiard among fixed molecules, {name}"),
        Mover::Disc => format!("Billiard around a fixed {name}"),
        Mover::Molecule => format!("Billiard of the molecule {name} among fixed discs"),
        Mover::LockedMolecule => format!("Billiard of the molecule {name}, locked, among fixed discs"),
    }
}
