//! Results of a run: series, figures, and page.

use std::fmt::Write as _;

use anyhow::Result;
use carom::{
    Observer, Scene, View,
    engine::{ElasticitySpec, RunSpec},
    observers::write_extended_xyz,
};
use carom_methods::{AnySimulation, Method};
use carom_report::{
    page::{Layout, Page},
    table_chart,
};
use carom_tables::{Figure, OVERLAPPING_PAIRS, Summary, Totals};
use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{
    schedule::{Schedule, Step, What},
    stage_edits, stages,
};
use crate::{
    animation,
    interruption::Signals,
    measures::{self, HardDiscs, Measures, Results},
    output::Folder,
    progress::Progress,
    record::{Record, RunRecord},
    resumable::{FoundCheckpoint, Resumable, Start, Task},
    visible_region::{caption_of, picture_of},
};

/// Longer side of a picture of the system (pixels).
const PICTURE: u32 = 720;

/// Files of the pictures of the initial and the final state.
const PICTURES: [&str; 2] = ["start.svg", "end.svg"];

/// A longer scene file is not repeated in the report (bytes).
const LONGEST_SCENE: usize = 100_000;

/// File of the snapshots.
const TRAJECTORY: &str = "trajectory.extxyz";

/// Results of a run.
#[derive(Debug, Serialize, Deserialize)]
pub struct Outcome {
    /// Tables and figures of the measures.
    pub results: Results,
    totals: Totals,
    bodies: usize,
    /// kT at the end (mass × length² / time²); `None` without thermal motion.
    temperature: Option<f64>,
    /// Number of contacts whose elasticity the guard against inelastic collapse raised, and the
    /// energy that it spared divided by the energy lost; `None` if there was none.
    guarded: Option<(u64, f64)>,
    /// Number of bodies at rest that thermostats have left out, summed over their actions, by tag.
    left_at_rest: Vec<(String, u64)>,
}

/// A simulation at the start of a run, its measures, and the number of draws of random numbers by
/// the first stage.
pub type Begun = (AnySimulation, Measures, u64);

/// Runs to the end, from the beginning (`start`) or from a checkpoint, and writes series and
/// snapshots.
///
/// # Errors
/// The run fails, a file cannot be written, or a signal has been received.
pub fn simulate(
    task: &Task<'_>,
    found: Option<FoundCheckpoint>,
    scene: &Scene,
    start: impl FnOnce() -> Result<Begun>,
) -> Result<Outcome> {
    let run = &scene.run;
    let progress = Progress::new(run.until);
    let mut going = match task.start::<Measures, Outcome>(found)? {
        Start::Ended(outcome) => return Ok(outcome),
        Start::From(going) => {
            // The picture is needed at the end; a missing one is an error now rather than then.
            task.folder.read(PICTURES[0])?;
            if run.animation && going.simulation.time().to_f64() > run.animation_from {
                task.folder.read(animation::ANIMATION)?;
            }
            progress.skip(going.simulation.time().to_f64());
            *going
        }
        Start::Anew => begin(task, start()?, run)?,
    };
    // A run killed before its first checkpoint after this point records the animation again.
    let begun = going.simulation.time().to_f64();
    let mut animation_from = (run.animation && begun <= run.animation_from).then_some(run.animation_from);
    for Step { time, what } in Schedule::new(scene).skip(going.steps()) {
        let before = (going.simulation.time().to_f64(), going.simulation.view().counters().collisions);
        if let Some(from) = animation_from.take_if(|from| *from < time) {
            // A run split in two makes the same contacts, to the bit.
            if going.simulation.time().to_f64() < from {
                going.run_to_and(from, task, Measures::append_contacts)?;
            }
            animation::record(&going.simulation, task.folder)?;
        }
        going.run_to_and(time, task, Measures::append_contacts)?;
        take(&mut going, task, scene, what)?;
        progress.advance(time - before.0, going.simulation.view().counters().collisions - before.1);
    }
    drop(progress);
    task.folder.write_lasting(PICTURES[1], picture_of(&going.simulation.view(), PICTURE))?;
    going.observers.finish(&going.simulation.view());
    let outcome = outcome_of(&going.simulation.view(), &going.observers, going.seconds(), scene);
    outcome.results.write(task.folder, |name| going.files.holds(name))?;
    going.end(task, &outcome)?;
    Ok(outcome)
}

/// Runs a scene in memory and writes nothing.
///
/// # Errors
/// The scene is invalid, the run fails, or a signal has been received.
pub fn in_memory(scene: &Scene, signals: &Signals) -> Result<Outcome> {
    let clock = ThreadTime::now();
    stages::check(scene)?;
    let mut simulation = AnySimulation::new(scene)?;
    let mut actions = stage_edits::prepare(&mut simulation, scene, 0)?;
    let mut measures = Measures::begin(scene, &simulation.view())?;
    measures.start(&simulation.view());
    measures.sample(&simulation.view());
    measures.check(&simulation.view());
    for Step { time, what } in Schedule::new(scene) {
        signals.check()?;
        simulation.observe_until(time, &mut measures)?;
        match what {
            What::Sample => measures.sample(&simulation.view()),
            What::Check => measures.check(&simulation.view()),
            What::Snapshot => (),
            What::Stage(_) | What::Thermostat { .. } => {
                actions += stage_edits::change(&mut simulation, scene, what, actions)?;
                measures.start(&simulation.view());
            }
        }
    }
    measures.finish(&simulation.view());
    Ok(outcome_of(&simulation.view(), &measures, clock.elapsed().as_secs_f64(), scene))
}

/// Takes one step of the schedule at the present time.
fn take(going: &mut Resumable<Measures>, task: &Task<'_>, scene: &Scene, what: What) -> Result<()> {
    match what {
        What::Sample => {
            going.sample();
            return append_sample(going, &scene.run);
        }
        What::Snapshot => append_frame(going)?,
        What::Check => going.observers.check(&going.simulation.view()),
        What::Stage(_) | What::Thermostat { .. } => {
            return going
                .edit(task, |simulation, actions| stage_edits::change(simulation, scene, what, actions));
        }
    }
    going.pass();
    Ok(())
}

/// Starts a run: initial picture, and the sample at time 0.
fn begin(
    task: &Task<'_>,
    (simulation, measures, actions): Begun,
    run: &RunSpec,
) -> Result<Resumable<Measures>> {
    task.folder.write_lasting(PICTURES[0], picture_of(&simulation.view(), PICTURE))?;
    let mut going = Resumable::begin(task, simulation, measures);
    going.observers.start(&going.simulation.view());
    going.actions = actions;
    going.observers.sample(&going.simulation.view());
    append_sample(&mut going, run)?;
    if run.snapshot_interval.is_some() {
        append_frame(&mut going)?;
    }
    going.observers.check(&going.simulation.view());
    Ok(going)
}

/// The outcome of a run that has reached its end.
fn outcome_of(view: &View<'_>, measures: &Measures, seconds: f64, scene: &Scene) -> Outcome {
    let (hard_discs, judged) = theory(view, scene);
    let results = measures.results(&judged, &hard_discs);
    let collisions = view.counters().collisions;
    Outcome {
        totals: Totals {
            collisions,
            simulated_time: scene.run.until,
            collisions_per_second: collisions as f64 / seconds.max(1e-9),
            ..results.totals
        },
        results,
        bodies: view.len(),
        temperature: view.temperature(),
        left_at_rest: left_at_rest(view),
        guarded: (view.ledger().spared > 0.0).then(|| {
            let ledger = view.ledger();
            (view.counters().guarded_collisions, ledger.spared / ledger.lost.max(ledger.spared))
        }),
    }
}

/// The gas to which theory applies in the measured part of a run, or why there is none; and the
/// scene with the elasticity in force there.
fn theory(view: &View<'_>, scene: &Scene) -> (Result<HardDiscs, String>, Scene) {
    let in_force = stages::measured_elasticities(scene);
    let is_elastic =
        |spec: &ElasticitySpec| spec.default == 1.0 && spec.pair.iter().all(|rule| rule.coefficient == 1.0);
    let judged = in_force.iter().find(|spec| !is_elastic(spec)).unwrap_or(&in_force[0]);
    let hard_discs = match stages::is_disturbed(scene) {
        Some(reason) => Err(reason.to_owned()),
        None => HardDiscs::of(view, judged),
    };
    (hard_discs, Scene { elasticity: (*judged).clone(), ..scene.clone() })
}

/// Names of tags with bodies that thermostats have left out because they were at rest, with their
/// number.
fn left_at_rest(view: &View<'_>) -> Vec<(String, u64)> {
    let heats = view.heat().all().iter().filter(|heat| heat.counts.at_rest > 0);
    heats.map(|heat| (view.tag_names().name(heat.tag).to_owned(), heat.counts.at_rest)).collect()
}

/// Writes a snapshot.
fn append_frame(going: &mut Resumable<Measures>) -> Result<()> {
    let Resumable { simulation, files, .. } = going;
    files.append_frame(TRAJECTORY, |out| write_extended_xyz(&simulation.view(), out))
}

/// Writes the data of the last sample: a frame, and a row of each requested series.
fn append_sample(going: &mut Resumable<Measures>, run: &RunSpec) -> Result<()> {
    if run.snapshots.is_some() && run.snapshot_interval.is_none() {
        append_frame(going)?;
    }
    going.observers.append(&mut going.files)
}

impl Outcome {
    /// Totals of the run.
    pub fn totals(&self) -> Totals {
        self.totals
    }

    /// Figures of the whole system at the end.
    fn system_figures(&self) -> Vec<Figure> {
        let bodies = Figure::new("bodies", self.bodies as f64, "1");
        let temperature = |kt: f64| Figure::new("temperature kT at the end", kt, "mass·length²/time²");
        std::iter::once(bodies).chain(self.temperature.map(temperature)).collect()
    }

    /// Figures and checks.
    pub fn summary(&self, title: String, method: &Method) -> Summary {
        let mut figures = self.system_figures();
        figures.extend(self.results.figures.iter().cloned());
        if let Some((guarded, share)) = self.guarded {
            figures.push(Figure::new("contacts that the guard against collapse raised", guarded as f64, "1"));
            figures.push(Figure::new("energy that it spared, by energy lost", share, "1"));
        }
        for (tag, count) in &self.left_at_rest {
            let name = format!("bodies at rest that thermostats left out, {tag}");
            figures.push(Figure::new(name, *count as f64, "1"));
        }
        let mut checks = self.totals.checks();
        let mut note = String::new();
        if !method.is_exact() {
            note = format!(
                "NOT EXACT. Method: {method}. Contacts may be missed, late or invented, so overlaps are a \
                 result here and not a fault."
            );
            checks.retain(|check| check.name != OVERLAPPING_PAIRS);
            let pairs = self.totals.overlapping_pairs as f64;
            figures.push(Figure::new("overlapping pairs at a sample, at most", pairs, "1"));
            let depth = self.totals.max_overlap;
            figures.push(Figure::new("deepest overlap at a sample, by the smaller diameter", depth, "1"));
        }
        Summary { title, note, totals: self.totals, checks, figures, runs: Vec::new() }
    }

    /// Creates the page of the run.
    ///
    /// # Errors
    /// A series cannot be drawn, or a picture is missing.
    pub fn page(&self, folder: &Folder, summary: &Summary, scene: &Scene, command: &str) -> Result<String> {
        let run = &scene.run;
        let mut lead = format!("Run from t = 0 to {}, sampled every {}.", run.until, run.sample_interval);
        if run.measure_from > 0.0 {
            let _ = write!(lead, " Measured from t = {} on.", run.measure_from);
        }
        for (index, stage) in stages::describe(scene).iter().enumerate() {
            let _ = write!(lead, " Stage {}: {stage}.", index + 1);
        }
        let measured = scene.measure.iter().map(|entry| entry.name.as_ref().unwrap_or(&entry.kind));
        let observed: Vec<&str> = run.observe.iter().chain(measured).map(String::as_str).collect();
        if !observed.is_empty() {
            let _ = write!(lead, " Observed: {}.", observed.join(", "));
        }
        let mut page = Page::new(&summary.title, &lead);
        if !summary.note.is_empty() {
            page.note(&summary.note);
        }
        page.heading("Results");
        page.totals(&summary.totals);
        page.figures(&summary.figures);
        page.subheading("Checks");
        page.paragraph(&format!("The overlap check ran at {} samples.", self.results.overlap_checks));
        page.checks(&summary.checks);
        draw_tables(&self.results, &mut page)?;
        page.heading("The system");
        let [start, end] = PICTURES.map(|name| folder.read(name));
        let (start, end) = (start?, end?);
        let captions = [
            format!("At the start.{}", caption_of(&start)),
            format!("At t = {}.{}", run.until, caption_of(&end)),
        ];
        page.pictures(Layout::Beside, &[(&start, &captions[0]), (&end, &captions[1])]);
        if run.animation {
            let mut caption = format!(
                "From t = {}: the flights of the run between contacts. All digits are in {}.",
                run.animation_from,
                animation::FLIGHTS
            );
            if !scene.stage.is_empty() {
                caption.push_str(" Later stages and thermostats do not act in it.");
            }
            page.animation(&folder.read(animation::ANIMATION)?, &caption);
        }
        page.heading("Data");
        page.links(self.data(run));
        page.heading("Reproduction");
        page.code(command);
        let text = scene.to_toml();
        if text.len() <= LONGEST_SCENE {
            page.paragraph("The scene with all options:");
            page.code(&text);
        } else {
            page.paragraph("The scene with all options is in config.toml.");
        }
        Ok(page.html())
    }

    /// Data files of the run, besides those of the tables.
    fn data(&self, run: &RunSpec) -> Vec<&str> {
        let mut files = vec!["config.toml", "summary.json", "tables.json", "manifest.json", "sums"];
        files.extend(run.animation.then_some(animation::FLIGHTS));
        files.extend(self.results.files.iter().map(String::as_str));
        files.extend(run.snapshots.is_some().then_some(TRAJECTORY));
        files
    }

    /// What other runs of the scene are merged with.
    pub fn record(&self, scene: &Scene, method: &Method) -> Record {
        let note = self.summary(String::new(), method).note;
        let run = RunRecord {
            // The speed differs between runs of the same bits.
            totals: Totals { collisions_per_second: 0.0, ..self.totals },
            note,
            figures: self.system_figures(),
            measures: self.results.records.clone(),
        };
        Record::of(scene, run)
    }
}

/// Draws the charts of all tables, each with its caption and a link to its file.
///
/// # Errors
/// A chart cannot be drawn.
pub fn draw_tables(results: &Results, page: &mut Page) -> Result<()> {
    for table in &results.tables {
        let charts = table_chart::charts(table)?;
        let last = charts.len().saturating_sub(1);
        for (index, svg) in charts.iter().enumerate() {
            let caption = if index == last { table.caption.as_str() } else { "" };
            page.pictures(Layout::Full, &[(svg, caption)]);
        }
        page.links([measures::file_name(table).as_str()]);
    }
    Ok(())
}

/// Writes what the columns of the measures' tables hold, with units and sources of predictions.
///
/// # Errors
/// The file cannot be written.
pub fn describe_tables(results: &Results, folder: &Folder) -> Result<()> {
    let heads = results.tables.iter().map(|table| {
        let file = measures::file_name(table);
        let columns = table.in_file().map(|column| {
            let (role, source) = column.role.words();
            json!({ "name": column.name, "unit": column.unit, "role": role, "source": source })
        });
        let columns: Vec<Value> = columns.collect();
        json!({ "file": file, "title": table.title, "caption": table.caption, "columns": columns })
    });
    folder.write_json("tables.json", &heads.collect::<Vec<Value>>())
}
