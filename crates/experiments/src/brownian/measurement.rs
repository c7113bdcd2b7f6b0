//! One run of the experiment: equilibration, then the measurement of every kick of the molecule.

use anyhow::{Context, Result};
use carom::{
    BodyKey, CollisionRate, ContactDensity, DirectionHistogram, EnergyLedger, Molecule, Observer,
    OverlapCheck, ProjectionHistogram, RunningAverage, Scene, View,
    engine::Body,
    observers::{Axis, Blocks, Drift, ImpulseLog},
};
use carom_methods::AnySimulation;
use carom_runs::{
    animation,
    measures::kicks::FromGas,
    progress::Progress,
    resumable::{FoundCheckpoint, Resumable, Start, Task},
    series,
};
use carom_tables::Totals;

use super::{
    plan::Plan,
    pockets,
    results::{Kicks, Measurement, PROJECTION_BINS, SECTORS, projection_range},
    setting::Setting,
    snapshots,
};

/// Bins of the contact density around each atom: one for three degrees.
const CONTACT_BINS: usize = 120;

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

/// Runs one replica of a setting by the plan, from the beginning or from a checkpoint. Writes
/// series, snapshots, an animation from the start of the measurement, and the first `impulses`
/// kicks.
///
/// # Errors
/// The scene cannot be built, the run fails, a file cannot be written, or a signal has been
/// received.
pub fn measure(
    task: &Task<'_>,
    found: Option<FoundCheckpoint>,
    (setting, scene): (&Setting, &Scene),
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
            let mut simulation = AnySimulation::with(scene, &task.method)?;
            pockets::empty(&mut simulation, setting)?;
            snapshots::snapshot(&simulation.view(), "start", task.folder)?;
            if let Some(molecule) = simulation.view().bodies().nth(setting.body) {
                snapshots::snapshot_of(&simulation.view(), molecule.body.key(), task.folder)?;
            }
            let mut going = Resumable::begin(task, simulation, Watched::default());
            going.observers.sample(&going.simulation.view());
            append_series(&mut going)?;
            going
        }
    };
    let observed = going.simulation.view().bodies().nth(setting.body).context("the scene has no bodies")?;
    let body = observed.body.clone();
    let (key, molecule) = (body.key(), body.molecule().clone());
    let settled = plan.settling().count();
    let times = plan.settling().chain(plan.measuring()).enumerate().skip(going.samples());
    for (index, time) in times {
        if index == settled && going.observers.2.is_none() {
            let measuring = going.observers.2.insert(observers(&going.simulation.view(), setting, &body)?);
            measuring.start(&going.simulation.view());
            going.observers.3 = Some(FromGas::new(key, ImpulseLog::new(key, impulses)));
            animation::record(&going.simulation, task.folder)?;
        }
        let before = (going.simulation.time().to_f64(), going.simulation.view().counters().collisions);
        going.run_to(time, task)?;
        going.sample();
        append_series(&mut going)?;
        progress.advance(time - before.0, going.simulation.view().counters().collisions - before.1);
    }
    let measured = Measurement::of(&going, key, molecule, plan)?;
    snapshots::snapshot(&going.simulation.view(), "end", task.folder)?;
    going.end(task, &measured)?;
    Ok(measured)
}

/// Observers of a molecule during the measurement.
fn observers(view: &View<'_>, setting: &Setting, body: &Body) -> Result<Measuring> {
    let key = body.key();
    let gas = setting.surroundings()?;
    let range = projection_range(body.molecule().mass(), gas.largest_mass(), booked_temperature(view));
    let along = |axis| ProjectionHistogram::new(key, axis, range, PROJECTION_BINS).map(Blocks::new);
    let kicked = (
        Blocks::new(DirectionHistogram::new(key, SECTORS)),
        along(Axis::X)?,
        along(Axis::Y)?,
        Blocks::new(ContactDensity::new(body, gas.probe(), CONTACT_BINS)?),
    );
    let drift = Blocks::new(Drift::new(key));
    Ok((FromGas::new(key, kicked), RunningAverage::new(key), drift, CollisionRate::default()))
}

/// kT from the initial energy and all degrees of freedom (mass × length² / time²).
fn booked_temperature(view: &View<'_>) -> f64 {
    let thermal = view.centre_of_mass_frame().thermal(view.bodies());
    2.0 * view.ledger().booked() / thermal.degrees_of_freedom
}

/// Writes the data of the last sample.
fn append_series(going: &mut Resumable<Watched>) -> Result<()> {
    let Resumable { observers: (energy, _, measuring, impulses), files, .. } = going;
    let new = impulses.as_mut().map_or_else(Vec::new, |kicks| kicks.observer.take());
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
        let (kicks, average, drift, rate) = measuring.as_ref().context("the run has no measurement")?;
        let (directions, along_x, along_y, contacts) = &kicks.observer;
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
            booked_temperature: booked_temperature(&view),
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
