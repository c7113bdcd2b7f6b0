//! One run of the experiment: the gas settles, then every kick of the molecule is counted.

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

/// Bins of the distribution of Δp along an axis, and the largest Δp in them (mass × length / time): six standard deviations
/// of the control.
pub const PROJECTION: (usize, f64) = (96, 12.0);

/// Bins of the contact density round each atom: one for three degrees.
const CONTACT_BINS: usize = 120;

/// What one run has shown.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Measurement {
    /// The molecule.
    pub molecule: Molecule,
    /// Kicks from the gas.
    pub kicks: Kicks,
    /// Directions of the kicks from the gas, block by block of time.
    pub directions: Blocks<DirectionHistogram>,
    /// Components of the kicks from the gas along x′ and y′, block by block.
    pub projections: [Blocks<ProjectionHistogram>; 2],
    /// Density of the gas at contact, times kT, along the boundary of the excluded region,
    /// block by block.
    pub contacts: Blocks<ContactDensity>,
    /// What drives the molecule, bumper included, block by block.
    pub drift: Blocks<Drift>,
    /// Running averages of what pushes the molecule, bumper included.
    pub averages: Vec<RunningPoint>,
    /// Energy over the whole run.
    pub energy: Vec<LedgerPoint>,
    /// Collisions per body while measuring.
    pub rates: Vec<RatePoint>,
    /// Mean of these with its standard error.
    pub rate: Option<(f64, f64)>,
    /// kT of all bodies (mass × length² / time²). The bumper breaks the conservation of momentum, so
    /// that it is twice the whole energy over the degrees of freedom.
    pub temperature: f64,
    /// What it should be: the energy that was put in, over the same degrees of freedom.
    pub booked_temperature: f64,
    /// Gas discs per area of the box.
    pub density: f64,
    /// How long was measured (time).
    pub duration: f64,
    /// Totals of the whole run.
    pub totals: Totals,
}

/// Kicks of the molecule, by direction in its own frame and by atom.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Kicks {
    /// How many, by direction of the impulse.
    pub counts: Vec<u64>,
    /// Sum of their magnitudes, by direction (mass × length / time).
    pub impulse: Vec<f64>,
    /// How many on each atom.
    pub by_atom: Vec<u64>,
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

/// What watches a run: its books all the time, the molecule and the collisions while measuring.
type Watched = (EnergyLedger, OverlapCheck, Option<Measuring>, Option<FromGas<ImpulseLog>>);

type Measuring = (FromGas<Kicked>, RunningAverage, Blocks<Drift>, CollisionRate);

/// The kicks of the gas: by direction, along x′ and y′, and along the boundary of the excluded region.
type Kicked = (
    Blocks<DirectionHistogram>,
    Blocks<ProjectionHistogram>,
    Blocks<ProjectionHistogram>,
    Blocks<ContactDensity>,
);

/// Runs a scene by the plan, from its beginning or from a checkpoint, and writes series, snapshots, an animation of how measuring
/// begins, and the first `impulses` kicks.
///
/// # Errors
/// A scene that cannot be built, a run that cannot go on, a file that cannot be written, or the program has been asked to
/// end.
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
            // Needed at the end: that it is gone must not come out then.
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
    let first = going.simulation.view().bodies().next().context("a scene without bodies")?;
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
        going.stand_by();
        write_on(&mut going)?;
        progress.advance(time - before.0, going.simulation.view().counters().collisions - before.1);
    }
    let measured = Measurement::of(&going, key, molecule, plan)?;
    snapshots::snapshot(&going.simulation.view(), "end", task.folder)?;
    going.end(task, &measured)?;
    Ok(measured)
}

/// Writes what the last sample has brought.
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
            measuring.as_ref().context("nothing was measured")?;
        let histogram = directions.total().observed;
        let view = going.simulation.view();
        let collisions = view.counters().collisions;
        let thermal = view.centre_of_mass_frame().thermal(view.bodies());
        let mut by_atom = histogram.atom_counts().to_vec();
        by_atom.resize(molecule.atoms().len(), 0);
        // All bodies but the molecule and what is fixed are gas.
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
            temperature: thermal.temperature().context("nothing has a thermal motion")?,
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

/// Sums of the kicks between one sample and the next, in the molecule's frame (mass × length / time).
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
