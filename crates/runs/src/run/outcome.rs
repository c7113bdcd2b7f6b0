//! Results of a run: series, figures, and page.

use std::fmt::Write as _;

use anyhow::Result;
use carom::{
    CollisionRate, EnergyLedger, Observer, OverlapCheck, Scene,
    engine::RunSpec,
    observers::{ImpulseLog, Pressure, PressurePoint, write_extended_xyz},
};
use carom_methods::{AnySimulation, Method};
use carom_report::{
    page::{Layout, Page},
    plot::{Axis, Chart, Layer, Shape, colour},
};
use carom_tables::{Figure, OVERLAPPING_PAIRS, Summary, Totals};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::{Options, gas};
use crate::{
    animation,
    output::Folder,
    progress::Progress,
    resumable::{FoundCheckpoint, Resumable, Start, Task},
    sampling_times::sampling_times,
    series,
    visible_region::{caption_of, picture_of},
};

/// Names allowed in `run.observe` besides those of [`gas`].
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
    totals: Totals,
    bodies: usize,
    /// kT at the end (mass × length² / time²); `None` without thermal motion.
    temperature: Option<f64>,
    /// Number of contacts whose elasticity the guard against inelastic collapse raised, and the
    /// energy that it spared divided by the energy lost; `None` if there was none.
    guarded: Option<(u64, f64)>,
}

/// Observers of a run; the last is present only if requested.
type Watched<O> = (EnergyLedger, CollisionRate, OverlapCheck, O);

/// Runs to the end, from the beginning or from a checkpoint, and writes series and snapshots.
///
/// # Errors
/// The run fails, a file cannot be written, or a signal has been received.
pub fn simulate(
    task: &Task<'_>,
    found: Option<FoundCheckpoint>,
    simulation: AnySimulation,
    run: &RunSpec,
    (at_samples, at_contacts): (gas::AtSamples, gas::AtContacts),
) -> Result<Outcome> {
    let with_pressure = run.observe.iter().any(|name| name == "pressure");
    if with_pressure || !at_contacts.is_empty() {
        let watchers = (at_samples, with_pressure.then(Pressure::default), at_contacts);
        simulate_with(task, found, simulation, run, watchers)
    } else {
        simulate_with(task, found, simulation, run, at_samples)
    }
}

/// Observers that a scene requests in addition to the standard ones.
trait Watchers: Observer + Serialize + DeserializeOwned {
    fn pressure(&self) -> Option<&Pressure>;

    fn impulses(&mut self) -> Option<&mut ImpulseLog>;

    /// Writes the tables that exist at the end only.
    fn write(&self, folder: &Folder) -> Result<()>;
}

/// Scenes that need no reports of contacts.
impl Watchers for gas::AtSamples {
    fn pressure(&self) -> Option<&Pressure> {
        None
    }

    fn impulses(&mut self) -> Option<&mut ImpulseLog> {
        None
    }

    fn write(&self, folder: &Folder) -> Result<()> {
        self.write(folder)
    }
}

impl Watchers for (gas::AtSamples, Option<Pressure>, gas::AtContacts) {
    fn pressure(&self) -> Option<&Pressure> {
        self.1.as_ref()
    }

    fn impulses(&mut self) -> Option<&mut ImpulseLog> {
        self.2.impulses()
    }

    fn write(&self, folder: &Folder) -> Result<()> {
        self.0.write(folder)?;
        self.2.write(folder)
    }
}

fn simulate_with<O: Watchers>(
    task: &Task<'_>,
    found: Option<FoundCheckpoint>,
    simulation: AnySimulation,
    run: &RunSpec,
    watchers: O,
) -> Result<Outcome> {
    let progress = Progress::new(run.until);
    let mut going = match task.start::<Watched<O>, Outcome>(found)? {
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
        Start::Anew => begin(task, simulation, run, watchers)?,
    };
    // A run killed before its first checkpoint after this point records the animation again.
    let begun = going.simulation.time().to_f64();
    let mut animation_from = (run.animation && begun <= run.animation_from).then_some(run.animation_from);
    for time in sampling_times(0.0, run.until, run.sample_interval).skip(going.samples()) {
        let before = (going.simulation.time().to_f64(), going.simulation.view().counters().collisions);
        if let Some(from) = animation_from.take_if(|from| *from < time) {
            // A run split in two makes the same contacts, to the bit.
            if going.simulation.time().to_f64() < from {
                going.run_to(from, task)?;
            }
            animation::record(&going.simulation, task.folder)?;
        }
        going.run_to(time, task)?;
        going.sample();
        append_sample(&mut going, run)?;
        progress.advance(time - before.0, going.simulation.view().counters().collisions - before.1);
    }
    drop(progress);
    task.folder.write_lasting(PICTURES[1], picture_of(&going.simulation.view(), PICTURE))?;
    going.observers.3.write(task.folder)?;
    let outcome = outcome_of(&going, run);
    going.end(task, &outcome)?;
    Ok(outcome)
}

/// Starts a run: initial picture, and the sample at time 0.
fn begin<O: Watchers>(
    task: &Task<'_>,
    simulation: AnySimulation,
    run: &RunSpec,
    watchers: O,
) -> Result<Resumable<Watched<O>>> {
    task.folder.write_lasting(PICTURES[0], picture_of(&simulation.view(), PICTURE))?;
    let observers = (EnergyLedger::default(), CollisionRate::default(), OverlapCheck::default(), watchers);
    let mut going = Resumable::begin(task, simulation, observers);
    going.observers.start(&going.simulation.view());
    going.observers.sample(&going.simulation.view());
    append_sample(&mut going, run)?;
    Ok(going)
}

/// The outcome of a run that has reached its end.
fn outcome_of<O: Watchers>(going: &Resumable<Watched<O>>, run: &RunSpec) -> Outcome {
    let view = going.simulation.view();
    let (energy, rate, overlaps, watchers) = &going.observers;
    let collisions = view.counters().collisions;
    Outcome {
        energy: energy.clone(),
        rate: rate.clone(),
        pressure: watchers.pressure().cloned(),
        overlaps: overlaps.clone(),
        totals: Totals {
            collisions,
            simulated_time: run.until,
            collisions_per_second: collisions as f64 / going.seconds().max(1e-9),
            energy_drift: energy.drift(),
            overlapping_pairs: overlaps.worst_pairs(),
            max_overlap: overlaps.deepest(),
        },
        bodies: view.len(),
        temperature: view.temperature(),
        guarded: (view.ledger().spared > 0.0).then(|| {
            let ledger = view.ledger();
            (view.counters().guarded_collisions, ledger.spared / ledger.lost.max(ledger.spared))
        }),
    }
}

/// Writes the data of the last sample: a frame, and a row of each requested series.
fn append_sample<O: Watchers>(going: &mut Resumable<Watched<O>>, run: &RunSpec) -> Result<()> {
    let Resumable { simulation, observers: (energy, rate, _, watchers), files, .. } = going;
    if run.snapshots.is_some() {
        files.append_frame(TRAJECTORY, |out| write_extended_xyz(&simulation.view(), out))?;
    }
    if let Some(impulses) = watchers.impulses() {
        files.append_new(&series::IMPULSES, &impulses.take())?;
    }
    for name in &run.observe {
        match name.as_str() {
            "energy" => files.append(&series::ENERGY, energy.series())?,
            "collision-rate" => files.append(&series::RATES, rate.series())?,
            "pressure" => {
                files.append(&series::PRESSURE, watchers.pressure().map_or(&[], Pressure::series))?;
            }
            // Its two figures are in the summary.
            _ => (),
        }
    }
    Ok(())
}

impl Outcome {
    /// Figures and checks.
    pub fn summary(&self, options: &Options, method: &Method) -> Summary {
        let mut figures = vec![Figure::new("bodies", self.bodies as f64, "1")];
        if let Some(temperature) = self.temperature {
            figures.push(Figure::new("temperature kT at the end", temperature, "mass·length²/time²"));
        }
        if let Some((mean, error)) = self.rate.mean() {
            figures.push(Figure::new("collisions per body that moves", mean, "1/time").error(error));
        }
        if let Some((mean, error)) = self.pressure.as_ref().and_then(Pressure::mean) {
            figures.push(Figure::new("pressure", mean, "mass/time²").error(error));
        }
        let factor = self.pressure.as_ref().and_then(Pressure::compressibility_factor);
        if let Some((mean, error)) = factor {
            figures.push(Figure::new("compressibility factor βpA/N", mean, "1").error(error));
        }
        if let Some((guarded, share)) = self.guarded {
            figures.push(Figure::new("contacts that the guard against collapse raised", guarded as f64, "1"));
            figures.push(Figure::new("energy that it spared, by energy lost", share, "1"));
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
        let title = format!("Scene {}", options.file.path.display());
        Summary { title, note, totals: self.totals, checks, figures, runs: Vec::new() }
    }

    /// Creates the page of the run.
    ///
    /// # Errors
    /// A series cannot be drawn, or a picture is missing.
    pub fn page(&self, folder: &Folder, summary: &Summary, scene: &Scene, command: &str) -> Result<String> {
        let run = &scene.run;
        let mut lead = format!("Run from t = 0 to {}, sampled every {}.", run.until, run.sample_interval);
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
        let charts = self.charts(run)?;
        let charts: Vec<(&str, &str)> =
            charts.iter().map(|(svg, caption)| (svg.as_str(), *caption)).collect();
        page.pictures(Layout::Full, &charts);
        page.heading("The system");
        let [start, end] = PICTURES.map(|name| folder.read(name));
        let (start, end) = (start?, end?);
        let captions = [
            format!("At the start.{}", caption_of(&start)),
            format!("At t = {}.{}", run.until, caption_of(&end)),
        ];
        page.pictures(Layout::Beside, &[(&start, &captions[0]), (&end, &captions[1])]);
        if run.animation {
            let caption = format!(
                "From t = {}: the flights of the run between contacts. All digits are in {}.",
                run.animation_from,
                animation::FLIGHTS
            );
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

    /// Data files that a run with these options writes.
    fn data(run: &RunSpec) -> Vec<&'static str> {
        let mut files = vec!["config.toml", "summary.json", "manifest.json"];
        files.extend(run.animation.then_some(animation::FLIGHTS));
        for name in &run.observe {
            match name.split(':').next() {
                Some("energy") => files.push(series::ENERGY.name),
                Some("collision-rate") => files.push(series::RATES.name),
                Some("pressure") => files.push(series::PRESSURE.name),
                Some("impulses") => files.push(series::IMPULSES.name),
                _ => (),
            }
        }
        files.extend(run.snapshots.is_some().then_some(TRAJECTORY));
        files
    }

    fn pressure_series(&self) -> &[PressurePoint] {
        self.pressure.as_ref().map_or(&[], Pressure::series)
    }

    /// Charts of the requested series.
    fn charts(&self, run: &RunSpec) -> Result<Vec<(String, &'static str)>> {
        let mut charts = Vec::new();
        let observes = |name: &str| run.observe.iter().any(|observed| observed == name);
        if observes("energy") {
            let first = self.energy.series().first().map_or(0.0, |point| point.energy);
            if first > 0.0 {
                let drift: Vec<(f64, f64)> = self
                    .energy
                    .series()
                    .iter()
                    .map(|point| (point.time, (point.energy - point.booked) / first))
                    .collect();
                let svg = series_chart(
                    "Energy drift relative to the ledger",
                    "(E − booked E) / E(0)",
                    run.until,
                    drift,
                )?;
                charts.push((svg, "The difference is rounding error; it must stay below 10⁻¹²."));
            }
        }
        if observes("collision-rate") {
            let rates: Vec<(f64, f64)> =
                self.rate.series().iter().map(|point| (point.time, point.rate)).collect();
            let svg = series_chart("Collisions", "collisions per body and time [1/time]", run.until, rates)?;
            charts.push((svg, "Mean over the moving bodies in each interval between samples."));
        }
        if observes("pressure") {
            let points = self.pressure_series().iter().map(|point| (point.time, point.pressure()));
            let svg = series_chart("Pressure", "p [mass/time²]", run.until, points.collect())?;
            charts.push((svg, "From the virial of the contacts in each interval between samples."));
        }
        Ok(charts)
    }
}

fn series_chart(title: &str, label: &str, until: f64, points: Vec<(f64, f64)>) -> Result<String> {
    let values = || points.iter().map(|point| point.1);
    let (low, high) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
    let room = if high > low { 0.1 * (high - low) } else { 1e-15 };
    Chart {
        title: title.to_owned(),
        x: Axis { label: "t [time]".to_owned(), range: (0.0, until) },
        y: Axis { label: label.to_owned(), range: (if low < 0.0 { low - room } else { 0.0 }, high + room) },
        layers: vec![Layer { name: String::new(), colour: colour::BLUE, shape: Shape::Line(points) }],
    }
    .svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_that_does_not_change_can_be_drawn() {
        assert!(series_chart("E", "E", 1.0, vec![(0.0, 0.0), (1.0, 0.0)]).is_ok());
        assert!(series_chart("E", "E", 1.0, Vec::new()).is_ok());
    }
}
