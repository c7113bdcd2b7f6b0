//! Records pairs from real runs with a detector that stores some of its queries.

use std::{
    f64::consts::{PI, TAU},
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use anyhow::{Context, Result};
use carom::{
    CellsPerSide, Detection, Exact, HeapScheduler, Impact, Scene, Simulation,
    engine::{BoxSpec, MoleculeSpec, RunSpec},
    geometry::Outline,
    kinematics::RelativeMotion,
};
use carom_detection::{Answer, encounters::Encounter, skim};
use carom_geometry::Molecule;
use carom_runs::run_totals::RunTotals;
use carom_sweeps::{Size, Study};
use carom_tables::Totals;
use cpu_time::ThreadTime;
use glam::DVec2;

/// One query in this many is recorded; a prime number, so that all kinds of queries occur.
const STRIDE: u64 = 37;

/// Duration of a run before recording, and of the steps afterwards (time). A mean free time is some
/// hundredths.
const WARM_UP: f64 = 0.5;
const STEP: f64 = 0.05;

/// Largest number of steps until enough pairs are recorded.
const MAX_STEPS: u32 = 4000;

/// Dumbbells in a row at the start.
const COLUMNS: u32 = 12;

/// Pairs from one run.
#[derive(Debug)]
pub struct Recording {
    /// Name of the class.
    pub name: &'static str,
    /// Description of the run.
    pub about: &'static str,
    /// The pairs; at least one body of each can turn.
    pub encounters: Vec<Encounter>,
    /// Totals of the run.
    pub totals: Totals,
}

/// The detector [`Exact`]; it records pairs in which a body has several atoms.
#[derive(Debug, Clone)]
struct Recorder {
    notes: Arc<Mutex<Notes>>,
}

impl Recorder {
    fn notes(&self) -> MutexGuard<'_, Notes> {
        self.notes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[derive(Debug, Default)]
struct Notes {
    questions: u64,
    requested: usize,
    encounters: Vec<Encounter>,
}

impl Detection for Recorder {
    fn first_contact(
        &self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        if a.atoms.len() > 1 || b.atoms.len() > 1 {
            self.notes().note(a, b, motion, horizon);
        }
        Exact::default().first_contact(a, b, motion, horizon)
    }
}

impl Notes {
    fn note(&mut self, a: Outline<'_>, b: Outline<'_>, motion: &RelativeMotion, horizon: f64) {
        self.questions += 1;
        if self.encounters.len() >= self.requested || !self.questions.is_multiple_of(STRIDE) {
            return;
        }
        let molecule = |outline: Outline<'_>| Molecule::new(outline.atoms.iter().copied());
        let (Ok(first), Ok(second)) = (molecule(a), molecule(b)) else {
            return;
        };
        let reach = first.bounding_radius() + second.bounding_radius();
        let parted = skim(motion, reach, f64::MAX).map_or(f64::MAX, |window| window.end);
        let horizon = horizon.min(parted);
        if horizon < f64::MAX {
            self.encounters.push(Encounter {
                molecules: [first, second],
                motion: *motion,
                horizon,
            });
        }
    }
}

/// Records `count` pairs from each of three runs: a tee in its gas, and dumbbells at two densities.
///
/// # Errors
/// A scene cannot be built, or a run fails.
pub fn recordings(seed: u64, count: usize) -> Result<Vec<Recording>> {
    let run = RunSpec {
        until: 2.0,
        sample_interval: 0.5,
        ..RunSpec::default()
    };
    let tee = tee(seed, &run)?;
    Ok(vec![
        record(
            "recorded_tee",
            "a tee in its gas, area fraction 0.5",
            &tee,
            count,
        )?,
        record(
            "recorded_dumbbells_0.3",
            "dumbbells at area fraction 0.3",
            &dumbbells(seed, 0.3),
            count,
        )?,
        record(
            "recorded_dumbbells_0.6",
            "dumbbells at area fraction 0.6",
            &dumbbells(seed, 0.6),
            count,
        )?,
    ])
}

/// The first point of the study of the thesis: a tee in its gas.
fn tee(seed: u64, run: &RunSpec) -> Result<Scene> {
    let study = Study::parse(
        include_str!("../../../studies/brownian.toml"),
        Path::new(""),
        Size::default(),
    )?;
    let mut scene = study
        .points
        .first()
        .context("the study of the thesis has no point")?
        .scene
        .clone();
    scene.bounds.seed = seed;
    scene.run = RunSpec {
        observe: scene.run.observe,
        ..run.clone()
    };
    Ok(scene)
}

/// 288 dumbbells of mass 1, initially in rows, each with an energy of about 1 in its own direction;
/// the initial order is lost when the recording begins.
///
/// A box of 12 × 24 of them has room up to the area fraction π/4, far above that of a random
/// placement.
fn dumbbells(seed: u64, area_fraction: f64) -> Scene {
    let count = COLUMNS * 2 * COLUMNS;
    let radius = (area_fraction / (2.0 * PI * f64::from(count))).sqrt();
    let dumbbell = |index: u32| {
        let (column, row) = (index % COLUMNS, index / COLUMNS);
        let width = 1.0 / f64::from(COLUMNS);
        // Multiples of the golden section of a turn give evenly spread directions.
        let turn = 0.618_033_988_749_894_9 * (f64::from(index) + 0.1 * seed as f64);
        let velocity = (4f64 / 3.0).sqrt() * DVec2::from_angle(TAU * turn.fract());
        let sign = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        MoleculeSpec {
            shape: Some("dumbbell".to_owned()),
            atom_radius: Some(radius),
            atom_mass: Some(0.5),
            at: [width * f64::from(column), 0.5 * width * f64::from(row)],
            velocity: velocity.to_array(),
            // I = 3 m r²/2 with m = 1: I ω²/2 = 1/3.
            angular_velocity: sign * (4f64 / 9.0).sqrt() / radius,
            ..MoleculeSpec::default()
        }
    };
    Scene {
        bounds: BoxSpec {
            seed,
            ..BoxSpec::default()
        },
        molecule: (0..count).map(dumbbell).collect(),
        ..Scene::default()
    }
}

fn record(
    name: &'static str,
    about: &'static str,
    scene: &Scene,
    count: usize,
) -> Result<Recording> {
    let recorder = Recorder {
        notes: Arc::default(),
    };
    let mut simulation: Simulation<Recorder, Impact, HeapScheduler> =
        Simulation::with(scene, recorder.clone(), Impact, CellsPerSide::default())?;
    let mut totals = RunTotals::new(&simulation.view());
    let begun = ThreadTime::now();
    let mut time = WARM_UP;
    simulation.run_until(time)?;
    recorder.notes().requested = count;
    for _ in 0..MAX_STEPS {
        if recorder.notes().encounters.len() >= count {
            break;
        }
        time += STEP;
        simulation.run_until(time)?;
    }
    let seconds = begun.elapsed().as_secs_f64();
    totals.sample(&simulation.view());
    let totals = totals.totals(&simulation.view(), seconds);
    let encounters = std::mem::take(&mut recorder.notes().encounters);
    Ok(Recording {
        name,
        about,
        encounters,
        totals,
    })
}
