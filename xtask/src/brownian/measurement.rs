//! One run of the experiment: the gas settles, then every kick of the molecule is counted.

use anyhow::{Context, Result};
use carom::{
    CollisionRate, DirectionHistogram, EnergyLedger, Molecule, Observer, OverlapCheck, RunningAverage, Scene,
    Simulation, View,
    observers::{LedgerPoint, RatePoint, RunningPoint, picture, write_extended_xyz},
};
use cpu_time::ThreadTime;
use glam::DVec2;

use super::{Plan, kicks::FromGas};
use crate::{progress::Progress, standbys::standbys, summary::Totals};

/// Sectors of the histogram of directions: one a degree.
pub const SECTORS: usize = 360;

/// Longer side of a picture of the system (pixels).
const PICTURE: u32 = 720;

/// What one run has shown.
#[derive(Debug, Clone)]
pub struct Measurement {
    /// The molecule.
    pub molecule: Molecule,
    /// Kicks from the gas.
    pub kicks: Kicks,
    /// Running averages of what pushes the molecule, bumper included.
    pub averages: Vec<RunningPoint>,
    /// Energy over the whole run.
    pub energy: Vec<LedgerPoint>,
    /// Collisions per body while measuring.
    pub rates: Vec<RatePoint>,
    /// Mean of these with its standard error.
    pub rate: Option<(f64, f64)>,
    /// Twice the energy over the degrees of freedom (mass × length² / time²).
    pub temperature: f64,
    /// What it should be: the energy that was put in, over the same degrees of freedom.
    pub booked_temperature: f64,
    /// Gas discs per area of the box.
    pub density: f64,
    /// How long was measured (time).
    pub duration: f64,
    /// Totals of the whole run.
    pub totals: Totals,
    /// Before the first contact, and at the end.
    pub snapshots: [Snapshot; 2],
}

/// Kicks of the molecule, by direction in its own frame and by atom.
#[derive(Debug, Clone, PartialEq)]
pub struct Kicks {
    /// How many, by direction of the impulse.
    pub counts: Vec<u64>,
    /// Sum of their magnitudes, by direction (mass × length / time).
    pub impulse: Vec<f64>,
    /// How many on each atom.
    pub by_atom: Vec<u64>,
}

/// The system at one time.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// One frame of extended XYZ.
    pub frame: Vec<u8>,
    /// A picture, as SVG.
    pub picture: String,
}

impl Kicks {
    /// Kicks of several runs together.
    pub fn sum<'a>(kicks: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        kicks.into_iter().cloned().reduce(|mut sum, next| {
            sum.counts.iter_mut().zip(next.counts).for_each(|(total, part)| *total += part);
            sum.impulse.iter_mut().zip(next.impulse).for_each(|(total, part)| *total += part);
            sum.by_atom.iter_mut().zip(next.by_atom).for_each(|(total, part)| *total += part);
            sum
        })
    }

    /// How many.
    pub fn hits(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Sum of their magnitudes (mass × length / time).
    pub fn total_impulse(&self) -> f64 {
        self.impulse.iter().sum()
    }
}

impl Snapshot {
    fn of(view: &View<'_>) -> Result<Self> {
        let mut frame = Vec::new();
        write_extended_xyz(view, &mut frame)?;
        Ok(Self { frame, picture: picture(view, PICTURE) })
    }
}

/// Runs a scene by the plan.
///
/// # Errors
/// A scene that cannot be built, or a run that cannot go on.
pub fn measure(scene: &Scene, plan: &Plan, progress: &Progress) -> Result<Measurement> {
    let mut simulation = Simulation::new(scene)?;
    let first = simulation.view().bodies().next().context("a scene without bodies")?;
    let (key, molecule) = (first.body.key(), first.body.molecule().clone());
    let start = Snapshot::of(&simulation.view())?;
    let clock = ThreadTime::now();

    let mut books = (EnergyLedger::default(), OverlapCheck::default());
    books.standby(&simulation.view());
    for time in standbys(0.0, plan.from, plan.standby) {
        step(&mut simulation, time, &mut (), progress)?;
        books.standby(&simulation.view());
    }
    let mut watched =
        (FromGas(DirectionHistogram::new(key, SECTORS)), RunningAverage::new(key), CollisionRate::default());
    watched.start(&simulation.view());
    for time in standbys(plan.from, plan.until, plan.standby) {
        step(&mut simulation, time, &mut watched, progress)?;
        watched.standby(&simulation.view());
        books.standby(&simulation.view());
    }

    let seconds = clock.elapsed().as_secs_f64();
    let view = simulation.view();
    let (FromGas(histogram), average, rate) = watched;
    let (energy, overlaps) = books;
    let collisions = view.counters().collisions;
    let freedom = view.degrees_of_freedom() as f64;
    let mut by_atom = histogram.atom_counts().to_vec();
    by_atom.resize(molecule.atoms().len(), 0);
    // All bodies but the molecule and what is fixed are gas.
    let gas = view.bodies().filter(|view| !view.body.is_fixed() && view.body.key() != key).count();
    Ok(Measurement {
        kicks: Kicks { counts: histogram.counts().to_vec(), impulse: histogram.impulse().to_vec(), by_atom },
        averages: average.series().to_vec(),
        rates: rate.series().to_vec(),
        rate: rate.mean(),
        temperature: 2.0 * view.energy() / freedom,
        booked_temperature: 2.0 * view.ledger().booked() / freedom,
        density: gas as f64 / view.bounds().area(),
        duration: plan.until - plan.from,
        totals: Totals {
            collisions,
            simulated_time: plan.until,
            collisions_per_second: collisions as f64 / seconds.max(1e-9),
            energy_drift: energy.drift(),
            overlapping_pairs: overlaps.worst_pairs(),
            max_overlap: overlaps.deepest(),
        },
        energy: energy.series().to_vec(),
        snapshots: [start, Snapshot::of(&view)?],
        molecule,
    })
}

/// Runs to the next standby.
fn step<O: Observer>(
    simulation: &mut Simulation,
    time: f64,
    observer: &mut O,
    progress: &Progress,
) -> Result<()> {
    let before = (simulation.time().to_f64(), simulation.view().counters().collisions);
    simulation.observe_until(time, observer)?;
    let after = simulation.view().counters().collisions;
    progress.advance(time - before.0, after - before.1);
    Ok(())
}

/// Sums of the kicks between one standby and the next, in the molecule's frame (mass × length / time).
pub fn increments(averages: &[RunningPoint], from: f64) -> Vec<DVec2> {
    let mut before = DVec2::ZERO;
    let next = |point: &RunningPoint| {
        let sum = point.momentum * (point.time - from);
        let increment = sum - before;
        before = sum;
        increment
    };
    averages.iter().map(next).collect()
}
