//! What the observers measure: planted contacts whose answer is known, sums by hand, and kinetic theory.

#[path = "observers/one_body.rs"]
mod one_body;
#[path = "observers/subscriptions.rs"]
mod subscriptions;
#[path = "observers/text.rs"]
mod text;
#[path = "observers/whole_gas.rs"]
mod whole_gas;

use carom::{
    BodyKey, CollisionRate, CollisionReport, DirectionHistogram, EnergyLedger, Observer, Orientation,
    OverlapCheck, RunningAverage, Scene, Simulation, Subscriptions,
    engine::{AtomSpec, GasSpec, MoleculeSpec},
    observers::{Pressure, TagFilter},
};
use glam::DVec2;

fn disc(at: DVec2, velocity: DVec2, radius: f64, mass: f64) -> MoleculeSpec {
    MoleculeSpec {
        atoms: vec![AtomSpec { at: [0.0; 2], radius, mass }],
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
        radius: Some(0.02),
        mass: Some(1.0),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    }
}

fn key(simulation: &Simulation, index: usize) -> BodyKey {
    simulation.view().bodies().nth(index).unwrap().body.key()
}

/// Starts, and stands by `standbys` times at even intervals until `until`.
fn observe<O: Observer>(simulation: &mut Simulation, observer: &mut O, until: f64, standbys: u32) {
    observer.start(&simulation.view());
    let from = simulation.time().to_f64();
    for standby in 1..=standbys {
        let time = from + (until - from) * f64::from(standby) / f64::from(standbys);
        simulation.observe_until(time, observer).unwrap();
        observer.standby(&simulation.view());
    }
}

/// Keeps what a closure makes of each collision: the filters and sums written by hand.
struct ByHand<T, F>(Vec<T>, F);

impl<T, F: FnMut(&CollisionReport<'_>) -> Option<T>> Observer for ByHand<T, F> {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0.extend((self.1)(report));
    }
}

#[test]
fn watching_changes_no_bit() {
    let mut scene = Scene { molecule: vec![tee(DVec2::new(0.5, 0.5), 0.7)], ..Scene::default() };
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
    observe(&mut watched, &mut observers, 3.0, 7);
    for (one, other) in alone.view().bodies().zip(watched.view().bodies()) {
        assert_eq!((one.motion, one.winding), (other.motion, other.winding));
    }
    assert_ne!(alone.view().bodies().next().unwrap().motion.orientation, Orientation::from_radians(0.7));
}
