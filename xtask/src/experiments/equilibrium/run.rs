//! Execution of the experiment: all scenes in parallel.

use anyhow::Result;
use carom::Scene;
use carom_experiments::common::ParallelRuns;
use carom_runs::{
    experiment::{Experiment, Opening, configuration},
    interruption::Signals,
    output::Destination,
    print_line,
    run::measure,
};
use carom_tables::{OneRun, Summary, Totals, Verdict};
use rayon::prelude::*;

use super::{
    report,
    results::{Measured, checks},
    scenes::{Case, cases},
};

/// Runs the experiment and writes its folder.
///
/// # Errors
/// The folder is not empty, a run fails, or a signal has been received.
pub fn run(options: &ParallelRuns<Destination>) -> Result<Verdict> {
    let common = &options.common;
    let command = options.command("equilibrium");
    let note = common.note(": deviations of some tenths of a per cent are not resolved.");
    let cases = cases(options.random.seed, common.select(1.0, 30.0))?;
    let scenes: Vec<&Scene> = cases.iter().map(|case| &case.scene).collect();
    let experiment = Experiment::begin(
        &common.destination,
        &Opening {
            folder: "out/equilibrium",
            note: &note,
            command: &command,
            configuration: configuration(&command, ""),
            scenes: &scenes,
        },
    )?;
    for (index, case) in cases.iter().enumerate() {
        experiment.folder.write(&format!("scene-{}.toml", index + 1), case.scene.to_toml())?;
    }
    let signals = Signals::watch()?;
    let measured = |case: Case| -> Result<Measured> {
        let summary = measure(&case.name, &case.scene, &signals)?;
        print_line(&format!("{}: {} collisions", case.name, summary.totals.collisions));
        Ok(Measured { case, summary })
    };
    let all: Vec<Measured> =
        options.threads.pool()?.install(|| cases.into_par_iter().map(measured).collect::<Result<_>>())?;
    let totals: Vec<Totals> = all.iter().map(|one| one.summary.totals).collect();
    let summary = Summary {
        title: "Equilibrium of gases".to_owned(),
        note,
        totals: Totals::of(&totals),
        checks: [Totals::of(&totals).checks(), checks(&all)].concat(),
        figures: all.iter().flat_map(Measured::figures).collect(),
        runs: all.iter().map(|one| OneRun::new(one.case.name.clone(), &one.summary.totals)).collect(),
    };
    let page = report::write(&experiment.folder, &all, &summary, &command)?;
    experiment.finish(&page, &summary, Some(summary.totals.cpu_seconds()))
}
