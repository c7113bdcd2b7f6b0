//! What a run of any scene has shown: its series, its figures, its page.

use std::{fmt::Write as _, io::Write as _};

use anyhow::{Context, Result};
use carom::{
    CollisionRate, EnergyLedger, Observer, OverlapCheck, Scene, Simulation, View,
    engine::RunSpec,
    observers::{Pressure, PressurePoint, picture, write_extended_xyz},
};
use cpu_time::ThreadTime;

use super::{Options, gas};
use crate::{
    output::Folder,
    page::{Layout, Page},
    plot::{Axis, Chart, Layer, Shape, colour},
    progress::Progress,
    series,
    standbys::standbys,
    summary::{Figure, Summary, Totals},
};

/// What `run.observe` may name, and what [`gas`] knows.
pub const OBSERVERS: [&str; 4] = ["energy", "collision-rate", "pressure", "overlap"];

/// Longer side of a picture of the system (pixels).
const PICTURE: u32 = 720;

/// What a run has shown.
pub struct Outcome {
    energy: EnergyLedger,
    rate: CollisionRate,
    /// Only where it was asked for: it needs a report of every contact.
    pressure: Option<Pressure>,
    overlaps: OverlapCheck,
    totals: Totals,
    pictures: [String; 2],
}

/// Runs to the end, and writes snapshots on the way.
///
/// # Errors
/// A run that cannot go on, or a snapshot that cannot be written.
pub fn simulate(
    simulation: &mut Simulation,
    run: &RunSpec,
    (mut lookers, densities): (gas::AtStandbys, gas::AtContacts),
    folder: &Folder,
) -> Result<Outcome> {
    let asks_for_pressure = run.observe.iter().any(|name| name == "pressure");
    let outcome = if asks_for_pressure || !densities.is_empty() {
        let mut contacts = (asks_for_pressure.then(Pressure::default), densities);
        let outcome = simulate_with(simulation, run, folder, &mut (&mut lookers, &mut contacts))?;
        let (pressure, densities) = contacts;
        densities.write(folder)?;
        Outcome { pressure, ..outcome }
    } else {
        simulate_with(simulation, run, folder, &mut lookers)?
    };
    lookers.write(folder)?;
    Ok(outcome)
}

fn simulate_with<O: Observer>(
    simulation: &mut Simulation,
    run: &RunSpec,
    folder: &Folder,
    asked: &mut O,
) -> Result<Outcome> {
    let mut observers = (EnergyLedger::default(), CollisionRate::default(), OverlapCheck::default(), asked);
    let mut trajectory = match run.snapshots {
        Some(_) => Some(folder.growing("trajectory.extxyz")?),
        None => None,
    };
    let mut snapshot = |view: &View<'_>| -> Result<()> {
        if let Some(file) = &mut trajectory {
            write_extended_xyz(view, file).context("cannot write a snapshot")?;
            file.flush().context("cannot write a snapshot")?;
        }
        Ok(())
    };
    let before = picture(&simulation.view(), PICTURE);
    let progress = Progress::new(run.until);
    let clock = ThreadTime::now();
    observers.start(&simulation.view());
    observers.standby(&simulation.view());
    snapshot(&simulation.view())?;
    let mut last = (0.0, 0);
    for time in standbys(0.0, run.until, run.standby) {
        simulation.observe_until(time, &mut observers)?;
        observers.standby(&simulation.view());
        snapshot(&simulation.view())?;
        let collisions = simulation.view().counters().collisions;
        progress.advance(time - last.0, collisions - last.1);
        last = (time, collisions);
    }
    let seconds = clock.elapsed().as_secs_f64();
    let (energy, rate, overlaps, _) = observers;
    let collisions = simulation.view().counters().collisions;
    let totals = Totals {
        collisions,
        simulated_time: run.until,
        collisions_per_second: collisions as f64 / seconds.max(1e-9),
        energy_drift: energy.drift(),
        overlapping_pairs: overlaps.worst_pairs(),
        max_overlap: overlaps.deepest(),
    };
    Ok(Outcome {
        energy,
        rate,
        pressure: None,
        overlaps,
        totals,
        pictures: [before, picture(&simulation.view(), PICTURE)],
    })
}

impl Outcome {
    /// Figures and checks.
    pub fn summary(&self, options: &Options, view: &View<'_>) -> Summary {
        let freedom = view.degrees_of_freedom() as f64;
        let mut figures = vec![Figure::new("bodies", view.len() as f64, "1")];
        if freedom > 0.0 {
            figures.push(Figure::new(
                "temperature kT at the end",
                2.0 * view.energy() / freedom,
                "mass·length²/time²",
            ));
        }
        if let Some((mean, error)) = self.rate.mean() {
            figures.push(Figure::new("collisions per body that moves", mean, "1/time").error(error));
        }
        if let Some((mean, error)) = self.pressure.as_ref().and_then(Pressure::mean) {
            figures.push(Figure::new("pressure", mean, "mass/time²").error(error));
        }
        let (counters, ledger) = (view.counters(), view.ledger());
        if ledger.spared > 0.0 {
            let guarded = counters.guarded_collisions as f64;
            figures.push(Figure::new("contacts that the guard against collapse raised", guarded, "1"));
            let share = ledger.spared / ledger.lost.max(ledger.spared);
            figures.push(Figure::new("energy that it spared, by energy lost", share, "1"));
        }
        let checks = self.totals.checks();
        let title = format!("Scene {}", options.scene.display());
        Summary { title, note: String::new(), totals: self.totals, checks, figures, runs: Vec::new() }
    }

    /// Writes the series that were asked for, and the pictures.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_series(&self, folder: &Folder, run: &RunSpec) -> Result<()> {
        for name in &run.observe {
            match name.as_str() {
                "energy" => series::write_energy(folder, self.energy.series())?,
                "collision-rate" => series::write_rates(folder, self.rate.series())?,
                "pressure" => series::write_pressure(folder, self.pressure_series())?,
                // Its two figures stand in the summary.
                _ => (),
            }
        }
        for (name, picture) in ["start.svg", "end.svg"].iter().zip(&self.pictures) {
            folder.write(name, picture)?;
        }
        Ok(())
    }

    /// The page about the run.
    ///
    /// # Errors
    /// A series that cannot be drawn.
    pub fn page(&self, summary: &Summary, scene: &Scene, command: &str) -> Result<String> {
        let run = &scene.run;
        let mut lead = format!("Run from t = 0 to {}, standby every {}.", run.until, run.standby);
        if !run.observe.is_empty() {
            let _ = write!(lead, " Watched: {}.", run.observe.join(", "));
        }
        let mut page = Page::new(&summary.title, &lead);
        page.heading("What was found");
        page.totals(&summary.totals);
        page.figures(&summary.figures);
        page.subheading("Checks");
        page.paragraph(&format!("Overlaps were looked for at {} standbys.", self.overlaps.checks()));
        page.checks(&summary.checks);
        let charts = self.charts(run)?;
        let charts: Vec<(&str, &str)> =
            charts.iter().map(|(svg, caption)| (svg.as_str(), *caption)).collect();
        page.pictures(Layout::Full, &charts);
        page.heading("The system");
        let end = format!("At t = {}.", run.until);
        let [start_picture, end_picture] = &self.pictures;
        page.pictures(Layout::Beside, &[(start_picture, "At the start."), (end_picture, &end)]);
        page.heading("How to run it again");
        page.code(command);
        page.paragraph("The scene with every choice written out:");
        page.code(&scene.to_toml());
        Ok(page.html())
    }

    fn pressure_series(&self) -> &[PressurePoint] {
        self.pressure.as_ref().map_or(&[], Pressure::series)
    }

    /// The series that were asked for.
    fn charts(&self, run: &RunSpec) -> Result<Vec<(String, &'static str)>> {
        let mut charts = Vec::new();
        let asked = |name: &str| run.observe.iter().any(|observed| observed == name);
        if asked("energy") {
            let first = self.energy.series().first().map_or(0.0, |point| point.energy);
            if first > 0.0 {
                let drift: Vec<(f64, f64)> = self
                    .energy
                    .series()
                    .iter()
                    .map(|point| (point.time, (point.energy - point.booked) / first))
                    .collect();
                let svg =
                    series_chart("Energy against the books", "(E − booked E) / E(0)", run.until, drift)?;
                charts.push((svg, "What is left is rounding: it must not grow beyond 10⁻¹²."));
            }
        }
        if asked("collision-rate") {
            let rates: Vec<(f64, f64)> =
                self.rate.series().iter().map(|point| (point.time, point.rate)).collect();
            let svg = series_chart("Collisions", "collisions per body and time [1/time]", run.until, rates)?;
            charts.push((svg, "Mean over the bodies that move, for each interval between standbys."));
        }
        if asked("pressure") {
            let points = self.pressure_series().iter().map(|point| (point.time, point.pressure()));
            let svg = series_chart("Pressure", "p [mass/time²]", run.until, points.collect())?;
            charts.push((svg, "From the virial of the contacts, for each interval between standbys."));
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
