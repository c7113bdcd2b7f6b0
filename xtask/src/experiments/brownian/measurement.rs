//! One run of the experiment: equilibration, then the measurement of every kick of the molecule.

use anyhow::{Context, Result};
use carom::{
    BodyKey, CollisionRate, ContactDensity, DirectionHistogram, EnergyLedger, Molecule, Observer,
    OverlapCheck, ProjectionHistogram, RunningAverage, Scene, Simulation,
    observers::{Axis, Blocks, Drift, ImpulseLog, LedgerPoint, RatePoint, RunningPoint},
};
use carom_runs::{
    animation,
    progress::Progress,
    resumable::{Found, Resumable, Start, Task},
    series,
};
use carom_tables::Totals;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::{Plan, kicks::FromGas, snapshots};
use crate::experiments::thesis_scene::GAS_RADIUS;

/// Sectors of the histogram of directions: one a degree.
pub const SECTORS: usize = 360;

/// Bins of the distribution of Δp along an axis, and its largest Δp (mass × length / time): six
/// standard deviations of the control.
pub const PROJECTION: (usize, f64) = (96, 12.0);

/// Bins of the contact density around each atom: one for three degrees.
const CONTACT_BINS: usize = 120;

/// Results of one run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Measurement {
    /// The molecule.
    pub molecule: Molecule,
    /// Kicks by the gas.
    pub kicks: Kicks,
    /// Directions of the kicks by the gas, by block of time.
    pub directions: Blocks<DirectionHistogram>,
    /// Components of the kicks by the gas along x′ and y′, by block.
    pub projections: [Blocks<ProjectionHistogram>; 2],
    /// Density of the gas at contact, times kT, along the boundary of the excluded region, by
    /// block.
    pub contacts: Blocks<ContactDensity>,
    /// Impulse and displacement of the molecule, including kicks by the bumper, by block.
    pub drift: Blocks<Drift>,
    /// Running averages of the force on the molecule, including the bumper.
    pub averages: Vec<RunningPoint>,
    /// Energy over the whole run.
    pub energy: Vec<LedgerPoint>,
    /// Collisions per body during the measurement.
    pub rates: Vec<RatePoint>,
    /// Their mean and its standard error.
    pub rate: Option<(f64, f64)>,
    /// kT of all bodies (mass × length² / time²): twice the total energy divided by the degrees of
    /// freedom, because the bumper breaks the conservation of momentum.
    pub temperature: f64,
    /// Predicted kT: the initial energy with the same degrees of freedom.
    pub booked_temperature: f64,
    /// Gas discs per area of the box.
    pub density: f64,
    /// Duration of the measurement (time).
    pub duration: f64,
    /// Totals of the whole run.
    pub totals: Totals,
}

/// Kicks of the molecule, by direction in its body frame and by atom.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Kicks {
    /// Number of kicks, by direction of the impulse.
    pub counts: Vec<u64>,
    /// Sum of impulse magnitudes, by direction (mass × length / time).
    pub impulse: Vec<f64>,
    /// Number of kicks on each atom.
    pub by_atom: Vec<u64>,
}

impl Kicks {
    /// Sum of the kicks of several runs.
    pub fn sum<'a>(kicks: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        kicks.into_iter().cloned().reduce(|mut sum, next| {
            sum.counts.iter_mut().zip(next.counts).for_each(|(total, part)| *total += part);
            sum.impulse.iter_mut().zip(next.impulse).for_each(|(total, part)| *total += part);
            sum.by_atom.iter_mut().zip(next.by_atom).for_each(|(total, part)| *total += part);
            sum
        })
    }

    /// Total number of kicks.
    pub fn hits(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Total impulse magnitude (mass × length / time).
    pub fn total_impulse(&self) -> f64 {
        self.impulse.iter().sum()
    }
}

/// Observers of a run: ledger and overlap check throughout, molecule and collisions during the
/// measurement.
type Watched = (EnergyLedger, OverlapCheck, Option<Measuring>, Option<FromGas<ImpulseLog>>);

type Measuring = (FromGas<Kicked>, RunningAverage, Blocks<Drift>, CollisionRate);

/// Observers of the kicks by the gas: by direction, along x′ and y′, and along the boundary of the
/// excluded region.
type Kicked = (
    Blocks<DirectionHistogram>,
    Blocks<ProjectionHistogram>,
    Blocks<ProjectionHistogram>,
    Blocks<ContactDensity>,
);

/// Runs a scene by the plan, from the beginning or from a checkpoint. Writes series, snapshots, an
/// animation from the start of the measurement, and the first `impulses` kicks.
///
/// # Errors
/// The scene cannot be built, the run fails, a file cannot be written, or a signal has been
/// received.
pub fn measure(
    task: &Task<'_>,
    found: Option<Found>,
    scene: &Scene,
    plan: &Plan,
    impulses: u64,
    progress: &Progress,
) -> Result<Measurement> {
    let mut going = match task.start::<Watched, Measurement>(found)? {
        Start::Ended(measured) => {
            progress.skip(plan.until);
            return Ok(measured);
        }
        Start::From(going) => {
            // The files are needed at the end; a missing one is an error now rather than then.
            snapshots::check(task.folder, going.observers.2.is_some())?;
            progress.skip(going.simulation.time().to_f64());
            *going
        }
        Start::Anew => {
            let simulation = Simulation::new(scene)?;
            snapshots::snapshot(&simulation.view(), "start", task.folder)?;
            if let Some(first) = simulation.view().bodies().next() {
                snapshots::snapshot_of(&simulation.view(), first.body.key(), task.folder)?;
            }
            let mut going = Resumable::begin(task, simulation, Watched::default());
            going.observers.sample(&going.simulation.view());
            write_on(&mut going)?;
            going
        }
    };
    let first = going.simulation.view().bodies().next().context("the scene has no bodies")?;
    let (body, key, molecule) = (first.body.clone(), first.body.key(), first.body.molecule().clone());
    let settled = plan.settling().count();
    let times = plan.settling().chain(plan.measuring()).enumerate().skip(going.samples());
    for (index, time) in times {
        if index == settled && going.observers.2.is_none() {
            let along =
                |axis| ProjectionHistogram::new(key, axis, PROJECTION.1, PROJECTION.0).map(Blocks::new);
            let kicked = (
                Blocks::new(DirectionHistogram::new(key, SECTORS)),
                along(Axis::X)?,
                along(Axis::Y)?,
                Blocks::new(ContactDensity::new(&body, GAS_RADIUS, CONTACT_BINS)?),
            );
            let drift = Blocks::new(Drift::new(key));
            let (average, rate) = (RunningAverage::new(key), CollisionRate::default());
            let measuring = going.observers.2.insert((FromGas(kicked), average, drift, rate));
            measuring.start(&going.simulation.view());
            going.observers.3 = Some(FromGas(ImpulseLog::new(key, impulses)));
            animation::record(&going.simulation, task.folder)?;
        }
        let before = (going.simulation.time().to_f64(), going.simulation.view().counters().collisions);
        going.run_to(time, task)?;
        going.sample();
        write_on(&mut going)?;
        progress.advance(time - before.0, going.simulation.view().counters().collisions - before.1);
    }
    let measured = Measurement::of(&going, key, molecule, plan)?;
    snapshots::snapshot(&going.simulation.view(), "end", task.folder)?;
    going.end(task, &measured)?;
    Ok(measured)
}

/// Writes the data of the last sample.
fn write_on(going: &mut Resumable<Watched>) -> Result<()> {
    let Resumable { observers: (energy, _, measuring, impulses), files, .. } = going;
    let new = impulses.as_mut().map_or_else(Vec::new, |FromGas(log)| log.take());
    files.append_new(&series::IMPULSES, &new)?;
    files.append(&series::ENERGY, energy.series())?;
    let (averages, rates) = match measuring {
        Some((_, average, _, rate)) => (average.series(), rate.series()),
        None => (&[][..], &[][..]),
    };
    files.append(&series::AVERAGES, averages)?;
    files.append(&series::RATES, rates)
}

impl Measurement {
    fn of(going: &Resumable<Watched>, key: BodyKey, molecule: Molecule, plan: &Plan) -> Result<Self> {
        let (energy, overlaps, measuring, _) = &going.observers;
        let (FromGas((directions, along_x, along_y, contacts)), average, drift, rate) =
            measuring.as_ref().context("the run has no measurement")?;
        let histogram = directions.total().observed;
        let view = going.simulation.view();
        let collisions = view.counters().collisions;
        let thermal = view.centre_of_mass_frame().thermal(view.bodies());
        let mut by_atom = histogram.atom_counts().to_vec();
        by_atom.resize(molecule.atoms().len(), 0);
        // All bodies except the molecule and fixed bodies are gas.
        let gas = view.bodies().filter(|view| !view.body.is_fixed() && view.body.key() != key).count();
        Ok(Self {
            kicks: Kicks {
                counts: histogram.counts().to_vec(),
                impulse: histogram.impulse().to_vec(),
                by_atom,
            },
            directions: directions.clone(),
            projections: [along_x.clone(), along_y.clone()],
            contacts: contacts.clone(),
            drift: drift.clone(),
            averages: average.series().to_vec(),
            rates: rate.series().to_vec(),
            rate: rate.mean(),
            temperature: thermal.temperature().context("no body has thermal motion")?,
            booked_temperature: 2.0 * view.ledger().booked() / thermal.degrees_of_freedom,
            density: gas as f64 / view.bounds().area(),
            duration: plan.until - plan.from,
            totals: Totals {
                collisions,
                simulated_time: plan.until,
                collisions_per_second: collisions as f64 / going.seconds().max(1e-9),
                energy_drift: energy.drift(),
                overlapping_pairs: overlaps.worst_pairs(),
                max_overlap: overlaps.deepest(),
            },
            energy: energy.series().to_vec(),
            molecule,
        })
    }
}

/// Sums of the kicks between consecutive samples, in the body frame (mass × length / time).
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
