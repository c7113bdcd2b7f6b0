//! The results of the observers: constructed contacts with a known answer, sums by hand, and
//! kinetic theory.

mod boundary;
mod correlations;
mod drift;
mod heat;
mod logs;
mod one_body;
mod pairs;
mod pressure;
mod subscriptions;
mod temperature;
mod text;
mod velocities;
mod whole_gas;

use std::f64::consts::PI;

use carom::{
    BodyKey, CollisionRate, CollisionReport, DirectionHistogram, EnergyLedger, Observer,
    Orientation, OverlapCheck, RunningAverage, Scene, Simulation, Subscriptions,
    engine::{AtomSpec, GasSpec, MoleculeSpec},
    observers::{
        BodyAxis, ContactDensity, Drift, Group, ImpulseLog, PairDistribution, Pressure,
        ProjectionHistogram, TagFilter, ThermostatLedger, TimeCorrelation, VelocityDistribution,
    },
};
use glam::DVec2;

fn disc(at: DVec2, velocity: DVec2, radius: f64, mass: f64) -> MoleculeSpec {
    MoleculeSpec {
        atoms: vec![AtomSpec {
            at: [0.0; 2],
            radius,
            mass,
        }],
        at: at.into(),
        velocity: velocity.into(),
        ..MoleculeSpec::default()
    }
}

fn tee(at: DVec2, orientation: f64) -> MoleculeSpec {
    MoleculeSpec {
        tags: vec!["tee".into()],
        shape: Some("tee".into()),
        atom_radius: Some(0.01),
        atom_mass: Some(2.0),
        at: at.into(),
        orientation: Some(orientation),
        ..MoleculeSpec::default()
    }
}

fn gas(tag: &str, count: usize) -> GasSpec {
    GasSpec {
        tags: vec![tag.into()],
        radius: Some(0.02.into()),
        mass: Some(1.0.into()),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    }
}

fn key(simulation: &Simulation, index: usize) -> BodyKey {
    simulation.view().bodies().nth(index).unwrap().body.key()
}

/// A gas of discs of radius ½ and mass 1 in a square box at this area fraction, with kT = 1 and
/// total momentum 0.
fn hard_discs(count: usize, area_fraction: f64, seed: u64) -> Scene {
    let side = (count as f64 * 0.25 * PI / area_fraction).sqrt();
    let mut scene = Scene::default();
    (scene.bounds.sides, scene.bounds.seed) = ([side; 2], seed);
    let spec = GasSpec {
        radius: Some(0.5.into()),
        zero_momentum: Some(true),
        ..gas("gas", count)
    };
    scene.gas.push(spec);
    scene
}

/// Starts the observer, and samples `samples` times at equal intervals until `until`.
fn observe<O: Observer>(simulation: &mut Simulation, observer: &mut O, until: f64, samples: u32) {
    observer.start(&simulation.view());
    let from = simulation.time().to_f64();
    for sample in 1..=samples {
        let time = from + (until - from) * f64::from(sample) / f64::from(samples);
        simulation.observe_until(time, observer).unwrap();
        observer.sample(&simulation.view());
    }
}

/// Stores the result of a closure for each collision, for filters and sums written by hand.
struct ByHand<T, F>(Vec<T>, F);

impl<T, F: FnMut(&CollisionReport<'_>) -> Option<T>> Observer for ByHand<T, F> {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0.extend((self.1)(report));
    }
}

/// Collisions that an observer does not want are reported to it only if another observer wants
/// them; this must not change its results.
#[test]
fn results_for_one_body_do_not_depend_on_other_observers() {
    let mut scene = Scene {
        molecule: vec![tee(DVec2::new(0.5, 0.5), 0.7)],
        ..Scene::default()
    };
    scene.gas.push(gas("gas", 100));
    let mut alone = Simulation::new(&scene).unwrap();
    let mut in_company = alone.clone();
    let tee = key(&alone, 0);
    let contacts = ContactDensity::new(alone.view().body(tee).unwrap().body, 0.02, 36).unwrap();
    let of_the_tee = || {
        (
            DirectionHistogram::new(tee, 360),
            RunningAverage::new(tee),
            Drift::new(tee),
            ImpulseLog::new(tee, 50),
            ProjectionHistogram::new(tee, BodyAxis::X, 3.0, 24).unwrap(),
            contacts.clone(),
        )
    };
    let (mut one, mut other) = (of_the_tee(), of_the_tee());
    let mut all = ByHand(Vec::new(), |report: &CollisionReport<'_>| {
        Some(report.side_of(tee).is_some())
    });
    observe(&mut alone, &mut one, 3.0, 7);
    observe(&mut in_company, &mut (&mut other, &mut all), 3.0, 7);
    assert_eq!(format!("{one:?}"), format!("{other:?}"));
    // The other observer has received all collisions, including the tee's.
    assert_eq!(all.0.len() as u64, in_company.view().counters().collisions);
    assert_eq!(
        one.0.counts().iter().sum::<u64>(),
        all.0.iter().filter(|&&of_the_tee| of_the_tee).count() as u64
    );
    assert!(all.0.contains(&true) && all.0.contains(&false));
}

#[test]
fn observers_change_no_bit() {
    let mut scene = Scene {
        molecule: vec![tee(DVec2::new(0.5, 0.5), 0.7)],
        ..Scene::default()
    };
    scene.gas.push(gas("gas", 100));
    let mut alone = Simulation::new(&scene).unwrap();
    let mut watched = alone.clone();
    alone.run_until(3.0).unwrap();
    let tee = key(&watched, 0);
    let mut subscriptions = Subscriptions::default();
    subscriptions.subscribe_collisions(TagFilter::Any, |_| {});
    let mut observers = (
        DirectionHistogram::new(tee, 360),
        RunningAverage::new(tee),
        EnergyLedger::default(),
        CollisionRate::default(),
        Pressure::default(),
        OverlapCheck::default(),
        subscriptions,
    );
    let contacts = ContactDensity::new(watched.view().body(tee).unwrap().body, 0.02, 36).unwrap();
    let mut more = (
        ThermostatLedger::default(),
        VelocityDistribution::adaptive(Group::All, 20),
        TimeCorrelation::new(Group::All, 3.0 / 7.0, 3.0).unwrap(),
        PairDistribution::new([Group::All; 2], &watched.view().bounds(), 0.3, 30).unwrap(),
        contacts,
    );
    let mut observers = (&mut observers, &mut more);
    observe(&mut watched, &mut observers, 3.0, 7);
    for (one, other) in alone.view().bodies().zip(watched.view().bodies()) {
        assert_eq!((one.motion, one.winding), (other.motion, other.winding));
    }
    assert_ne!(
        alone.view().bodies().next().unwrap().motion.orientation,
        Orientation::from_radians(0.7)
    );
}
