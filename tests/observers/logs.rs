//! Event logs: the flights of all bodies, and all impulses on one body.

use carom::{
    BodyKey, CollisionReport, Observer, Scene, Simulation,
    kinematics::Orientation,
    observers::{FlightLog, ImpulseLog, LoggedFlight},
};
use glam::DVec2;

const SCENE: &str = "[[molecule]]\nshape = \"tee\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.5, 0.5]\n\
                     [[bumper]]\nradius = 0.02\nat = [0.1, 0.1]\n\
                     [[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 150\n";

fn simulation() -> Simulation {
    Simulation::new(&Scene::from_toml(SCENE).unwrap()).unwrap()
}

/// Position and angle of a body on a flight.
fn at(flight: &LoggedFlight, time: f64) -> (DVec2, f64) {
    let passed = time - flight.time;
    (
        flight.position + passed * flight.velocity,
        flight.angle + passed * flight.angular_velocity,
    )
}

#[test]
fn the_last_flight_of_each_body_gives_its_position_at_any_time() {
    let mut simulation = simulation();
    simulation.run_until(0.3).unwrap();
    let mut log = FlightLog::new(usize::MAX);
    log.start(&simulation.view());
    for step in 1..=40 {
        let time = 0.3 + 0.0173 * f64::from(step);
        simulation.observe_until(time, &mut log).unwrap();
        let view = simulation.view();
        for body in view.bodies() {
            let last = log
                .flights()
                .iter()
                .rfind(|flight| flight.body == body.body.id())
                .unwrap();
            let (place, angle) = at(last, time);
            let apart = place - body.motion.position;
            assert!((apart - apart.round()).length() < 1e-12, "{apart}");
            assert!((last.velocity - body.motion.velocity).length() < 1e-12);
            let off =
                Orientation::from_radians(angle - body.motion.orientation.radians()).cos_sin();
            assert!((off - DVec2::X).length() < 1e-11, "{off}");
        }
    }
    let counters = simulation.view().counters();
    assert!(log.flights().is_sorted_by_key(|flight| flight.time));
    assert!(counters.collisions > 1000 && log.flights()[0].angular_velocity != 0.0);
}

#[test]
fn a_full_log_is_the_beginning_of_a_longer_one() {
    let record = |capacity| {
        let mut log = FlightLog::new(capacity);
        let mut simulation = simulation();
        log.start(&simulation.view());
        simulation.observe_until(0.5, &mut log).unwrap();
        log
    };
    let (short, long) = (record(500), record(10_000));
    assert!(short.is_full() && !long.is_full());
    assert!(
        short.flights().len() >= 499 && short.flights() == &long.flights()[..short.flights().len()]
    );
    // There is not even space for one flight of each body.
    assert_eq!(record(3).flights(), &long.flights()[..3]);
    assert!(record(0).flights().is_empty());
}

/// Change of momentum of one body, from its mass and velocities.
struct Momentum(BodyKey, DVec2, u64);

impl Observer for Momentum {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        if let Some((side, _)) = report.side_of(self.0) {
            self.1 += 5.0 * (side.after.velocity - side.before.velocity);
            self.2 += 1;
        }
    }
}

#[test]
fn impulses_sum_to_the_change_of_momentum_and_are_returned_once() {
    let mut simulation = simulation();
    let tee = simulation.view().bodies().next().unwrap().body.key();
    let mut observers = (
        ImpulseLog::new(tee, u64::MAX),
        Momentum(tee, DVec2::ZERO, 0),
        ImpulseLog::new(tee, 7),
    );
    let mut impulses = Vec::new();
    for step in 1..=10 {
        simulation
            .observe_until(0.2 * f64::from(step), &mut observers)
            .unwrap();
        impulses.extend(observers.0.take());
    }
    let (log, Momentum(_, change, contacts), few) = &mut observers;
    assert!(*contacts > 50 && log.seen() == *contacts && few.seen() == *contacts);
    assert_eq!(impulses.len() as u64, *contacts);
    assert_eq!(few.take(), impulses[..7]);
    let sum: DVec2 = impulses.iter().map(|impulse| impulse.impulse).sum();
    assert!((sum - *change).length() < 1e-11, "{sum} {change}");
    for impulse in &impulses {
        // Smooth discs push along the line of their centres, and never pull.
        let size = impulse.impulse.length();
        assert!((impulse.impulse - size * impulse.normal).length() < 1e-13 * size);
        assert!((impulse.in_body_frame.length() - size).abs() < 1e-14 * size);
        assert!(impulse.atom.is_some_and(|atom| atom < 5) && impulse.other > 0);
    }
}
