//! Execution of the experiment: all replicas in parallel.

use anyhow::Result;
use carom::Scene;
use carom_experiments::common::ParallelRuns;
use carom_runs::{
    experiment::{Experiment, Opening, configuration},
    interruption::Signals,
    measures::Results,
    output::Destination,
    progress::Progress,
    run::tables,
};
use carom_tables::{Summary, Totals, Verdict};
use rayon::prelude::*;

use super::{
    report,
    results::{Compared, compare},
};

/// The gas: 106 discs of diameter 1 at area fraction 0.3 and kT = 1. A disc has about 2.4
/// collisions a unit of time; a run measures about 950 of each.
const SCENE: &str = r#"
[box]
sides = [16.66, 16.66]
[[molecule]]
tags = ["tracer"]
atoms = [{ at = [0.0, 0.0], radius = 0.5, mass = 1.0 }]
at = [8.33, 8.33]
[[gas]]
radius = 0.5
mass = 1.0
temperature = 1.0
velocities = "maxwell"
count = 105
[run]
until = 440.0
sample_interval = 0.2
measure_from = 40.0
animation = false
observe = ["pressure", "directions:tracer"]
[[measure]]
kind = "correlation"
max = 2.0
[[measure]]
kind = "pair-distribution"
every = 5
bins = 30
max = 3.0
"#;

/// Runs the experiment and writes its folder.
///
/// # Errors
/// The folder is not empty, a run fails, or a signal has been received.
pub fn run(options: &ParallelRuns<Destination>) -> Result<Verdict> {
    let common = &options.common;
    let (command, note) = (options.command("errors"), common.note(": the band is wide."));
    let replicas = common.select(60, 400);
    let mut scene = Scene::from_toml(SCENE)?;
    scene.bounds.seed = options.random.seed;
    let experiment = Experiment::begin(
        &common.destination,
        &Opening {
            folder: "out/errors",
            note: &note,
            command: &command,
            configuration: configuration(&command, &format!("replicas = {replicas}\n")),
            scenes: &[&scene],
        },
    )?;
    experiment.folder.write("scene.toml", scene.to_toml())?;
    let signals = Signals::watch()?;
    let progress = Progress::items("replicas", replicas);
    let replica = |number: u64| -> Result<(Results, Totals)> {
        let mut scene = scene.clone();
        scene.bounds.replica = number;
        let measured = tables(&scene, &signals)?;
        progress.count(1);
        Ok(measured)
    };
    let all: Vec<(Results, Totals)> = options
        .threads
        .pool()?
        .install(|| (0..replicas).into_par_iter().map(replica).collect::<Result<_>>())?;
    let (results, totals): (Vec<Results>, Vec<Totals>) = all.into_iter().unzip();
    let compared = compare(&results);
    let summary = Summary {
        title: "Standard errors against the scatter of replicas".to_owned(),
        note,
        totals: Totals::of(&totals),
        checks: [Totals::of(&totals).checks(), compared.iter().map(Compared::check).collect()].concat(),
        figures: compared.iter().map(Compared::figure).collect(),
        runs: Vec::new(),
    };
    let page = report::write(&experiment.folder, &compared, &summary, &command)?;
    experiment.finish(&page, &summary, Some(summary.totals.cpu_seconds()))
}
