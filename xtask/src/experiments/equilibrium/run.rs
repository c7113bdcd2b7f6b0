//! Execution of the experiment: all scenes in parallel.

use anyhow::Result;
use carom::Scene;
use carom_runs::{
    experiment::{Experiment, Opening, configuration},
    interruption::Signals,
    print_line,
    run::measure,
};
use carom_tables::{OneRun, Summary, Totals, Verdict};
use rayon::prelude::*;

use super::{
    Options, report,
    results::{Measured, checks},
    scenes::{Case, cases},
};

/// Runs the experiment and writes its folder.
///
/// # Errors
/// The folder is not empty, a run fails, or a signal has been received.
pub fn run(options: &Options) -> Result<Verdict> {
    let (command, note) = (options.command(), options.note());
    let cases = cases(options.random.seed, options.length())?;
    let scenes: Vec<&Scene> = cases.iter().map(|case| &case.scene).collect();
    let experiment = Experiment::begin(
        &options.common.destination,
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
    report::write(&experiment.folder, &all, &summary, &command)?;
    experiment.folder.write_json("summary.json", &summary)?;
    carom_runs::conclude(&experiment.complete_after(summary.totals.cpu_seconds())?, &summary);
    Ok(summary.verdict())
}
