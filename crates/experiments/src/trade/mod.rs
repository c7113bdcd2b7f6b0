//! How much time does each knob save on a scene, and what does it get wrong?
//!
//! `carom trade SCENE`: wrong contacts, overlaps, effective error, and the scene's own measures
//! with each setting, and its processor time relative to the exact run, in short replays from
//! states of the exact run.

pub mod advice;
pub mod chart;
pub mod curves;
pub mod difference;
pub mod effective_error;
pub mod knobs;
mod options;
pub mod page;
pub mod physics;
pub mod plan;
pub mod results;
pub mod run;
pub mod states;
pub mod table;

use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use carom::Scene;
use carom_report::page::Page;
use carom_runs::{
    console::{is_json, put, put_summary},
    experiment::{Experiment, Opening},
    interruption::OnlyAtEnd,
    price::{Course, build},
    print_line,
    progress::Progress,
};
use carom_tables::Verdict;

pub use self::options::TradeOptions;
use self::{
    plan::{KnobCost, TradePlan},
    results::SceneResult,
    run::{Prepared, of_scene, resume_seconds},
    states::{Along, chaos},
};

/// Shares of the time allowed until which the start must be placed, the first state reached, and
/// the growth of errors measured.
const PLACED: f64 = 0.5;
const SETTLED: f64 = 0.12;
const GROWN: f64 = 0.04;

/// States from which the growth of errors is measured.
const FIRST_STATES: usize = 4;

/// Share of the time allowed for files and page, and for rounding up.
const RESERVE: f64 = 0.06;

/// Compares all settings on a scene and writes the folder.
///
/// # Errors
/// The scene or an option is invalid, the folder is not empty, or the exact run fails.
pub fn run(options: &TradeOptions) -> Result<Verdict> {
    let begun = Instant::now();
    let seconds = options.seconds()?;
    let scene = options.file.read(None)?;
    options.destination.check(&options.folder())?;
    let signals = OnlyAtEnd::watch()?;
    let prepared = start(options, &scene, begun, seconds)?;
    let experiment = Experiment::reserve(
        &options.destination,
        &Opening {
            folder: &options.folder(),
            note: "",
            command: &options.command(),
            configuration: String::new(),
            scenes: &[&scene],
        },
    )?;
    let (prepared, plan) = prepared;
    let settings = prepared.knobs()?.0.len();
    let result = of_scene(
        prepared,
        &plan,
        &Progress::items("steps", 2 * settings as u64),
    )?;
    signals.write();
    let folder = &experiment.folder;
    folder.write("config.toml", scene.to_toml())?;
    if let Some(frame) = &scene.start.snapshot {
        folder.write(carom_runs::run::START, frame.as_bytes())?;
    }
    let title = format!("What exactness costs in {}", options.name());
    let note = "Short replays from states of the exact run; --minutes gives them more time.";
    let summary = page::summary(title, note.to_owned(), &result);
    let charts = page::write(folder, &result, &summary)?;
    let mut page = Page::new(&summary.title, &summary.note);
    page.verdict(&advice::advice(&result));
    page::show(&mut page, &result, &charts);
    page.checks(&summary.checks);
    page.links(page::files(&charts));
    page.code(&options.command());
    folder.write("report.html", page.html())?;
    if is_json() {
        put("advice", &advice::advice(&result));
        put("settings", &results::rows(&result));
    } else {
        print(&result);
    }
    let path = experiment.complete()?;
    put_summary(&path, &summary);
    print_line(&format!("{}", path.path().join("report.html").display()));
    Ok(summary.verdict())
}

/// Places the scene, runs to its first state, and plans the rest of the time.
fn start<'a>(
    options: &TradeOptions,
    scene: &'a Scene,
    begun: Instant,
    seconds: f64,
) -> Result<(Prepared<'a>, TradePlan)> {
    let at = |share: f64| begun + Duration::from_secs_f64(share * seconds);
    let course = place(options, scene, at(PLACED))?;
    let left = || (1.0 - RESERVE) * seconds - begun.elapsed().as_secs_f64();
    let mut along = Along::settle(scene, course, plan::from_now(SETTLED * left()))?;
    let view = along.course.simulation().view();
    let moving = view.bodies().filter(|body| body.body.is_free()).count();
    let bodies = view.len();
    ensure!(
        bodies > 1 && moving > 0,
        "scene {}: no contact is possible: number of bodies {bodies}, of which move {moving}",
        options.file.path.display()
    );
    let first = along.course.state(along.tau);
    let resume = resume_seconds(scene, &first)?;
    let few = along.take_soon(FIRST_STATES, SETTLED * left())?;
    let chaos = chaos(scene, &few, plan::from_now(GROWN * left()))?;
    let mut prepared = Prepared {
        name: options.name(),
        scene,
        states: few,
        end: along.end,
        deadline: at(1.0 - RESERVE),
        chaos,
        notes: Vec::new(),
    };
    let cost = KnobCost {
        tau: along.seconds * 0.5 * moving as f64,
        resume,
        bodies,
        settings: prepared.knobs()?.0.len(),
        stretch: prepared.chaos.stretch,
        threads: rayon::current_num_threads(),
    };
    let plan = TradePlan::within(left(), &cost);
    if plan.stretch < prepared.chaos.stretch {
        along.notes.push(format!(
            "replays last {:.2} τ: longer ones do not end in the time allowed",
            plan.stretch
        ));
        prepared.chaos.stretch = plan.stretch;
    }
    let more = plan.states.saturating_sub(prepared.states.len());
    if more > 0 {
        prepared
            .states
            .extend(along.take(scene, more, plan.state_seconds)?);
    }
    prepared.notes = along.notes;
    Ok((prepared, plan))
}

/// Places the bodies of a scene before the deadline.
fn place<'a>(options: &TradeOptions, scene: &'a Scene, deadline: Instant) -> Result<Course<'a>> {
    let name = options.file.path.display();
    let simulation = build(scene, deadline).with_context(|| format!("scene {name}"))?;
    let simulation = simulation.with_context(|| {
        format!(
            "scene {name}: its gases are not placed in {PLACED} of the {} minutes allowed; give more --minutes",
            options.minutes
        )
    })?;
    Course::new(scene, simulation)
}

/// Prints a line for each setting and the advice.
pub fn print(result: &SceneResult) {
    let head = [
        "setting",
        "time over exact",
        "wrong per 1e6",
        "overlap/diameter",
        "effective error/side",
        "measures",
    ];
    let rows = std::iter::once(head.map(str::to_owned).to_vec()).chain(table::short(result));
    for row in rows {
        let [setting, time, wrong, deepest, effective, worst] =
            [0, 1, 2, 3, 4, 5].map(|column| &row[column]);
        print_line(&format!(
            "{setting:<38}  {time:>15}  {wrong:>13}  {deepest:>16}  {effective:>20}  {worst}"
        ));
    }
    print_line(&advice::advice(result));
}
