//! A response written outside: the ledger records what its contacts lose, and nothing replaces its impulse.

#[path = "support/engine.rs"]
mod support;

use carom_detection::Exact;
use carom_engine::{
    CellScheduler, CollisionReport, HeapScheduler, Observer, RunError, Scene, Scheduler, Side, Simulation,
};
use carom_kinematics::{Inertia, Motion};
use carom_response::{ContactFrame, Elasticity, Impact, Response, approach_speed};
use glam::DVec2;
use support::{bumper, disc, gas, named, scene};

/// Elastic for slow contacts; e = 1/2 at ten times the reference speed and beyond. The example of the README.
#[derive(Debug, Clone)]
struct SpeedDependent {
    reference: f64,
}

impl Response for SpeedDependent {
    fn impulse(&self, frame: &ContactFrame, bodies: [(&Motion, &Inertia); 2], _: Elasticity) -> DVec2 {
        let approach = approach_speed(frame, [bodies[0].0, bodies[1].0]);
        let coefficient = (1.0 - 0.05 * approach / self.reference).clamp(0.5, 1.0);
        let elasticity = Elasticity::new(coefficient).expect("between a half and one");
        Impact.impulse(frame, bodies, elasticity)
    }
}

/// Loses all relative motion along the normal, whatever elasticity is asked for.
#[derive(Debug, Clone)]
struct Sticky;

impl Response for Sticky {
    fn impulse(&self, frame: &ContactFrame, bodies: [(&Motion, &Inertia); 2], _: Elasticity) -> DVec2 {
        Impact.impulse(frame, bodies, Elasticity::new(0.0).expect("in range"))
    }
}

/// Sums the energy that contacts change, from the reports.
#[derive(Debug, Default)]
struct Change(f64);

impl Observer for Change {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0 += report.sides.iter().map(Side::energy_change).sum::<f64>();
    }
}

fn simulate<R: Response, S: Scheduler>(scene: &Scene, response: R) -> Simulation<Exact, R, S> {
    Simulation::with(scene, Exact::default(), response, S::Options::default())
        .expect("the scene can be built")
}

fn mixture() -> Scene {
    let mut scene = scene(vec![named("tee", 0.02, 0.5, [0.25, 0.25])]);
    scene.bumper = vec![bumper(0.05, [0.75, 0.75])];
    scene.gas = vec![gas("disc", 0.02, 60), gas("dumbbell", 0.015, 12)];
    scene
}

#[test]
fn the_ledger_records_what_a_response_loses() {
    check_ledger::<HeapScheduler>(&mixture());
    check_ledger::<CellScheduler>(&mixture());
    // Discs alone take a shorter way through the engine.
    check_ledger::<CellScheduler>(&Scene { gas: vec![gas("disc", 0.02, 100)], ..Scene::default() });
}

fn check_ledger<S: Scheduler + Clone>(scene: &Scene) {
    let mut simulation = simulate::<_, S>(scene, SpeedDependent { reference: 1.0 });
    let before = simulation.view().energy();
    let mut change = Change::default();
    simulation.observe_until(1.0, &mut change).unwrap();
    let view = simulation.view();
    assert!(view.energy() < 0.9 * before);
    assert!((view.energy() - before - change.0).abs() < 1e-12 * before, "{change:?}");
    let ledger = view.ledger();
    assert!((ledger.lost + change.0).abs() < 1e-12 * before, "{ledger:?} {change:?}");
    assert!((view.energy() - ledger.booked()).abs() < 1e-12 * before);
    simulation.check_invariants(0.01).unwrap();
}

#[test]
fn a_fixed_body_is_met_by_the_impulse_of_the_response() {
    // At nine times the reference speed: e = 0.55.
    let mut billiard = scene(vec![disc(0.05, 2.0, [0.3, 0.5], [9.0, 0.0])]);
    billiard.bumper = vec![bumper(0.1, [0.7, 0.5])];
    for once in [check_bumper::<HeapScheduler>, check_bumper::<CellScheduler>] {
        once(&billiard);
    }
}

fn check_bumper<S: Scheduler>(billiard: &Scene) {
    let mut simulation = simulate::<_, S>(billiard, SpeedDependent { reference: 1.0 });
    assert!(simulation.step(1.0, &mut ()).unwrap());
    let velocity = support::velocity(&simulation.view(), 0);
    assert!((velocity - DVec2::new(-0.55 * 9.0, 0.0)).length() < 1e-14, "{velocity}");
    assert!((simulation.view().ledger().lost - 0.5 * 2.0 * 81.0 * (1.0 - 0.55 * 0.55)).abs() < 1e-12);
}

#[test]
fn a_response_that_ignores_the_guard_loses_what_it_says_and_a_collapse_has_a_name() {
    // A dumbbell that turns comes to lie against a disc: contacts without end, as the guard's elasticity is ignored.
    let mut lying =
        scene(vec![named("dumbbell", 0.05, 1.0, [0.4, 0.5]), disc(0.05, 1.0, [0.55, 0.6], [-0.5, -0.4])]);
    lying.molecule[0].angular_velocity = 3.0;
    let mut simulation = simulate::<_, CellScheduler>(&lying, Sticky);
    let initial = simulation.view().energy();
    let ended = simulation.run_until(20.0);
    assert!(matches!(ended, Ok(()) | Err(RunError::Stalled { .. })), "{ended:?}");
    let view = simulation.view();
    assert_eq!(view.overlaps().pairs, 0);
    assert!((view.energy() - view.ledger().booked()).abs() < 1e-12 * initial);
}
