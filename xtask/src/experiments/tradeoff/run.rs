//! Execution of the experiment: all settings in each scene, rapier, and output files.

use anyhow::Result;
use carom_experiments::trade::{
    self, knobs, page,
    plan::{Plan, from_now},
    results::SceneResult,
    run::{Prepared, of_scene},
};
use carom_methods::AnySimulation;
use carom_runs::{
    experiment::{Experiment, Opening, configuration},
    print_line,
    progress::Progress,
};
use carom_tables::Verdict;

use super::{
    Options, rapier, report,
    scenes::{self, Named},
    settle,
};

/// Cells a side of the thesis's grid.
const GRID: u32 = 50;

/// Runs the experiment and writes its folder.
///
/// # Errors
/// The folder is not empty or cannot be written, or an exact run fails.
pub fn run(options: &Options) -> Result<Verdict> {
    let plan = options.plan();
    let mut scenes = scenes::all(options.random.seed)?;
    scenes.retain(|named| named.name.starts_with(&options.scene));
    anyhow::ensure!(!scenes.is_empty(), "no scene has a name beginning with '{}'", options.scene);
    let scenes_of: Vec<&carom::Scene> = scenes.iter().map(|named| &named.scene).collect();
    let experiment = Experiment::begin(
        &options.common.destination,
        &Opening {
            folder: "out/tradeoff",
            note: &options.note(),
            command: &options.command(),
            configuration: configuration(&options.command(), &options.configuration()),
            scenes: &scenes_of,
        },
    )?;
    let folder = &experiment.folder;
    let results = scenes.iter().map(|named| of_named(named, &plan)).collect::<Result<Vec<_>>>()?;
    let mut compared = Vec::new();
    if options.rapier {
        print_line("rapier in closed boxes");
        for named in &scenes {
            let one = rapier::compare(named, &plan)?;
            for line in rapier::lines(&one) {
                print_line(&line);
            }
            compared.push(one);
        }
        folder.write_table("rapier.csv", &rapier::HEADER, compared.iter().flat_map(rapier::rows))?;
    } else {
        print_line("rapier is not run; the option --rapier compiles and runs it");
    }
    let summary = page::summary("Cost of accuracy in whole simulations".to_owned(), options.note(), &results);
    let charts = page::write(folder, &results, &summary)?;
    let report = report::page(&results, &charts, &compared, &summary, &options.command());
    folder.write("report.html", report.html())?;
    carom_runs::conclude(&experiment.complete()?, &summary);
    Ok(summary.verdict())
}

/// All settings in one scene.
fn of_named(named: &Named, plan: &Plan) -> Result<SceneResult> {
    let mut simulation = AnySimulation::new(&named.scene)?;
    let (states, chaos) = settle::states(&named.scene, &mut simulation, plan)?;
    let prepared = Prepared {
        name: named.name.to_owned(),
        about: named.about.to_owned(),
        scene: &named.scene,
        states,
        end: f64::MAX,
        // The amount of work is fixed.
        deadline: from_now(f64::MAX),
        chaos,
        more: vec![knobs::grid(format!("grid {GRID}, the thesis's"), GRID)],
        notes: Vec::new(),
    };
    let settings = prepared.knobs(plan.finest_step)?.0.len();
    print_line(&format!("{}: {}", named.name, named.about));
    let result = of_scene(prepared, plan, &Progress::items("steps", 2 * settings as u64))?;
    trade::print(&result);
    Ok(result)
}
