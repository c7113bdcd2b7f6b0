//! Results of a run: series, figures, and page.

use std::fmt::Write as _;

use anyhow::Result;
use carom::{
    CollisionRate, EnergyLedger, Observer, OverlapCheck, Scene, View,
    engine::{ElasticitySpec, RunSpec},
    observers::{ImpulseLog, Pressure, write_extended_xyz},
};
use carom_methods::{AnySimulation, Method};
use carom_report::{
    page::{Layout, Page},
    table_chart,
};
use carom_tables::{BlockSums, Figure, OVERLAPPING_PAIRS, Summary, Table, Totals};
use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{
    impulses,
    schedule::{Schedule, Step, What},
    stage_edits, stages,
};
use crate::{
    animation,
    interruption::Signals,
    measures::{self, Delayed, ENSKOG, HardDiscs, LIU, Measures, Results},
    output::Folder,
    progress::Progress,
    resumable::{FoundCheckpoint, Resumable, Start, Task},
    series,
    visible_region::{caption_of, picture_of},
};

/// Names allowed in `run.observe` besides those of the measures.
pub const OBSERVERS: [&str; 4] = ["energy", "collision-rate", "pressure", "overlap"];

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
    energy: EnergyLedger,
    rate: CollisionRate,
    /// `None` unless requested: it needs a report of every contact.
    pressure: Option<Pressure>,
    overlaps: OverlapCheck,
    /// Tables and figures of the measures.
    results: Results,
    /// The gas, if it is one of equal hard discs.
    hard_discs: Option<HardDiscs>,
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

/// Observers of a run; the optional ones only if the scene requests them.
type Watched = (EnergyLedger, Checks, Delayed<Averages>, Option<ImpulseLog>);

/// The check for overlaps: at each sample, or at times of its own.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Checks {
    is_apart: bool,
    check: OverlapCheck,
}

impl Observer for Checks {
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        if !self.is_apart {
            self.check.sample(view);
        }
    }
}

/// A simulation at the start of a run, its observers, and the number of draws of random numbers by
/// the first stage.
pub type Begun = (AnySimulation, Watched, u64);

/// What is averaged over the time of the measurement.
type Averages = (CollisionRate, Option<Pressure>, Measures);

/// Creates the observers that a scene requests.
///
/// # Errors
/// No body carries a tag, or a body or gas is not unique.
pub fn observers(scene: &Scene, view: &View<'_>) -> Result<Watched> {
    let run = &scene.run;
    let pressure = run.observe.iter().any(|name| name == "pressure").then(Pressure::default);
    let measured = (CollisionRate::default(), pressure, Measures::begin(run, view)?);
    let (from, until) = stages::window(scene);
    let measured = Delayed::new(from, until, measured);
    let checks = Checks { is_apart: run.check_interval.is_some(), check: OverlapCheck::default() };
    Ok((EnergyLedger::default(), checks, measured, impulses::log(run, view)?))
}

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
    let mut going = match task.start::<Watched, Outcome>(found)? {
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
                going.run_to(from, task)?;
            }
            animation::record(&going.simulation, task.folder)?;
        }
        going.run_to(time, task)?;
        take(&mut going, task, scene, what)?;
        progress.advance(time - before.0, going.simulation.view().counters().collisions - before.1);
    }
    drop(progress);
    task.folder.write_lasting(PICTURES[1], picture_of(&going.simulation.view(), PICTURE))?;
    let outcome = outcome_of(&going.simulation.view(), &going.observers, going.seconds(), scene);
    outcome.results.write(task.folder)?;
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
    let mut observers = observers(scene, &simulation.view())?;
    observers.start(&simulation.view());
    observers.sample(&simulation.view());
    for Step { time, what } in Schedule::new(scene) {
        signals.check()?;
        simulation.observe_until(time, &mut observers)?;
        match what {
            What::Sample => observers.sample(&simulation.view()),
            What::Check => observers.1.check.sample(&simulation.view()),
            What::Snapshot => (),
            What::Stage(_) | What::Thermostat { .. } => {
                actions += stage_edits::change(&mut simulation, scene, what, actions)?;
                observers.start(&simulation.view());
            }
        }
    }
    Ok(outcome_of(&simulation.view(), &observers, clock.elapsed().as_secs_f64(), scene))
}

/// Takes one step of the schedule at the present time.
fn take(going: &mut Resumable<Watched>, task: &Task<'_>, scene: &Scene, what: What) -> Result<()> {
    match what {
        What::Sample => {
            going.sample();
            return append_sample(going, &scene.run);
        }
        What::Snapshot => append_frame(going)?,
        What::Check => going.observers.1.check.sample(&going.simulation.view()),
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
    (simulation, observers, actions): Begun,
    run: &RunSpec,
) -> Result<Resumable<Watched>> {
    task.folder.write_lasting(PICTURES[0], picture_of(&simulation.view(), PICTURE))?;
    let mut going = Resumable::begin(task, simulation, observers);
    going.observers.start(&going.simulation.view());
    going.actions = actions;
    going.observers.sample(&going.simulation.view());
    append_sample(&mut going, run)?;
    if run.snapshot_interval.is_some() {
        append_frame(&mut going)?;
    }
    if run.check_interval.is_some() {
        going.observers.1.check.sample(&going.simulation.view());
    }
    Ok(going)
}

/// The outcome of a run that has reached its end.
fn outcome_of(view: &View<'_>, observers: &Watched, seconds: f64, scene: &Scene) -> Outcome {
    let run = &scene.run;
    let (energy, Checks { check: overlaps, .. }, Delayed { observer: (rate, pressure, measures), .. }, _) =
        observers;
    let (hard_discs, judged) = theory(view, scene);
    let collisions = view.counters().collisions;
    Outcome {
        energy: energy.clone(),
        rate: rate.clone(),
        pressure: pressure.clone(),
        results: measures.results(&judged, &hard_discs),
        hard_discs: hard_discs.ok(),
        overlaps: overlaps.clone(),
        totals: Totals {
            collisions,
            simulated_time: run.until,
            collisions_per_second: collisions as f64 / seconds.max(1e-9),
            energy_drift: energy.drift(),
            overlapping_pairs: overlaps.worst_pairs(),
            max_overlap: overlaps.deepest(),
        },
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
fn append_frame(going: &mut Resumable<Watched>) -> Result<()> {
    let Resumable { simulation, files, .. } = going;
    files.append_frame(TRAJECTORY, |out| write_extended_xyz(&simulation.view(), out))
}

/// Writes the data of the last sample: a frame, and a row of each requested series.
fn append_sample(going: &mut Resumable<Watched>, run: &RunSpec) -> Result<()> {
    if run.snapshots.is_some() && run.snapshot_interval.is_none() {
        append_frame(going)?;
    }
    let Resumable { observers: (energy, _, measured, impulses), files, .. } = going;
    let (rate, pressure, _) = &measured.observer;
    if let Some(impulses) = impulses {
        files.append_new(&series::IMPULSES, &impulses.take())?;
    }
    for name in &run.observe {
        match name.as_str() {
            "energy" => files.append(&series::ENERGY, energy.series())?,
            "collision-rate" => files.append(&series::RATES, rate.series())?,
            "pressure" => {
                files.append(&series::PRESSURE, pressure.as_ref().map_or(&[], Pressure::series))?;
            }
            // Its two figures are in the summary.
            _ => (),
        }
    }
    Ok(())
}

impl Outcome {
    /// Figures and checks.
    pub fn summary(&self, title: String, method: &Method) -> Summary {
        let mut figures = vec![Figure::new("bodies", self.bodies as f64, "1")];
        if let Some(temperature) = self.temperature {
            figures.push(Figure::new("temperature kT at the end", temperature, "mass·length²/time²"));
        }
        if let Some((mean, error)) = in_blocks(self.rate.series().iter().map(|p| (p.time, p.rate))) {
            let figure = Figure::new("collisions per body that moves", mean, "1/time").error(error);
            figures.push(figure.predicted(self.hard_discs.map(|gas| gas.collision_rate()), ENSKOG));
        }
        let pressures = self.pressure.as_ref().map_or(&[][..], Pressure::series).iter();
        if let Some((mean, error)) = in_blocks(pressures.clone().map(|p| (p.time, p.pressure()))) {
            let figure = Figure::new("pressure", mean, "mass/time²").error(error);
            figures.push(figure.predicted(self.hard_discs.map(|gas| gas.pressure()), LIU));
        }
        let factors = pressures.map(|p| Some((p.time, p.compressibility_factor()?)));
        let factors: Option<Vec<(f64, f64)>> = factors.collect();
        if let Some((mean, error)) = factors.and_then(|factors| in_blocks(factors.into_iter())) {
            let figure = Figure::new("compressibility factor βpA/N", mean, "1").error(error);
            figures.push(figure.predicted(self.hard_discs.map(|gas| gas.compressibility_factor()), LIU));
        }
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
        if !run.observe.is_empty() {
            let _ = write!(lead, " Observed: {}.", run.observe.join(", "));
        }
        let mut page = Page::new(&summary.title, &lead);
        if !summary.note.is_empty() {
            page.note(&summary.note);
        }
        page.heading("Results");
        page.totals(&summary.totals);
        page.figures(&summary.figures);
        page.subheading("Checks");
        page.paragraph(&format!("The overlap check ran at {} samples.", self.overlaps.checks()));
        page.checks(&summary.checks);
        for (table, files) in self.tables(run) {
            let charts = table_chart::charts(&table)?;
            let last = charts.len().saturating_sub(1);
            for (index, svg) in charts.iter().enumerate() {
                let caption = if index == last { table.caption.as_str() } else { "" };
                page.pictures(Layout::Full, &[(svg, caption)]);
            }
            page.links([files.as_str()]);
        }
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
        page.links(Self::data(run));
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

    /// Data files that a run with these options writes, besides those of the tables.
    fn data(run: &RunSpec) -> Vec<&'static str> {
        let mut files = vec!["config.toml", "summary.json", "tables.json", "manifest.json"];
        files.extend(run.animation.then_some(animation::FLIGHTS));
        files.extend(run.observe.iter().any(|name| impulses::is_log(name)).then_some(series::IMPULSES.name));
        files.extend(run.snapshots.is_some().then_some(TRAJECTORY));
        files
    }

    /// Writes what the columns of the measures' tables hold, with units and sources of predictions.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn describe_tables(&self, folder: &Folder) -> Result<()> {
        let heads = self.results.tables.iter().map(|table| {
            let file = measures::file_name(table);
            let columns = table.columns.iter().map(|column| {
                let (role, source) = column.role.words();
                json!({ "name": column.name, "unit": column.unit, "role": role, "source": source })
            });
            let columns: Vec<Value> = columns.collect();
            json!({ "file": file, "title": table.title, "caption": table.caption, "columns": columns })
        });
        folder.write_json("tables.json", &heads.collect::<Vec<Value>>())
    }

    /// All tables, each with the name of its file.
    fn tables(&self, run: &RunSpec) -> Vec<(Table, String)> {
        let is_asked = |name: &str| run.observe.iter().any(|observed| observed == name);
        let mut tables = Vec::new();
        if is_asked("energy") {
            tables.push((self.drift_table(), series::ENERGY.name.to_owned()));
        }
        if is_asked("collision-rate") {
            tables.push((self.rate_table(), series::RATES.name.to_owned()));
        }
        if is_asked("pressure") {
            tables.push((self.pressure_table(), series::PRESSURE.name.to_owned()));
        }
        let measured = self.results.tables.iter().map(|table| (table.clone(), measures::file_name(table)));
        tables.extend(measured);
        tables
    }

    fn drift_table(&self) -> Table {
        let points = self.energy.series();
        let first = points.first().map_or(0.0, |point| point.energy);
        let drift =
            points.iter().map(|point| Some((point.energy - point.booked) / first.max(point.exchanged)));
        Table::new("energy", "Energy drift relative to the ledger")
            .abscissa("time", "time", points.iter().map(|point| point.time).collect())
            .value("(E − booked E) / E(0)", "1", drift.collect())
            .caption(
                "The difference is rounding error; it must stay below 10⁻¹². Once contacts have lost, or edits put \
                 in, more than E(0), it is relative to that.",
            )
    }

    fn rate_table(&self) -> Table {
        let points = self.rate.series();
        let table = Table::new("collision-rate", "Collisions")
            .abscissa("time", "time", points.iter().map(|point| point.time).collect())
            .value("collisions per body", "1/time", points.iter().map(|point| Some(point.rate)).collect())
            .caption("Mean over the moving bodies in each interval between samples.");
        constant(table, points.len(), self.hard_discs.map(|gas| gas.collision_rate()), "Enskog", ENSKOG)
    }

    fn pressure_table(&self) -> Table {
        let points = self.pressure.as_ref().map_or(&[][..], Pressure::series);
        let table = Table::new("pressure", "Pressure")
            .abscissa("time", "time", points.iter().map(|point| point.time).collect())
            .value("pressure", "mass/time²", points.iter().map(|point| Some(point.pressure())).collect())
            .caption("From the virial of the contacts in each interval between samples.");
        constant(table, points.len(), self.hard_discs.map(|gas| gas.pressure()), "Liu", LIU)
    }
}

/// Mean over time of a series of (end of an interval, mean in it), and its standard error from
/// blocks. The first interval is taken as long as the second.
fn in_blocks(points: impl Iterator<Item = (f64, f64)> + Clone) -> Option<(f64, Option<f64>)> {
    let (first, second) = (points.clone().next()?.0, points.clone().nth(1)?.0);
    let mut blocks = BlockSums::default();
    let (mut before, mut sums) = (2.0 * first - second, [0.0; 2]);
    for (time, value) in points {
        sums = [sums[0] + value * (time - before), sums[1] + (time - before)];
        before = time;
        blocks.record(&[sums]);
    }
    let mean = blocks.means()[0];
    Some((mean.value?, mean.standard_error))
}

/// Adds a prediction that does not depend on the abscissa.
fn constant(table: Table, rows: usize, prediction: Option<f64>, label: &str, source: &str) -> Table {
    match prediction {
        Some(value) => table.prediction(label, vec![Some(value); rows], source),
        None => table,
    }
}
