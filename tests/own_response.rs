//! A user-defined response: the ledger records the energy that its contacts lose, and its impulse
//! is never replaced.

use std::hash::{DefaultHasher, Hash, Hasher};

use crate::support::{bits, bumper, disc, gas, named, scene};
use carom_detection::Exact;
use carom_engine::{
    CellScheduler, CollisionReport, HeapScheduler, Observer, RunError, Scene, Scheduler, Side,
    Simulation,
};
use carom_kinematics::{EpochTime, Inertia, Motion};
use carom_response::{ContactFrame, Elasticity, Impact, Response, approach_speed};
use glam::DVec2;

/// Elastic for slow contacts; the elasticity of the scene at ten times the reference speed and
/// above. The example of the README.
#[derive(Debug, Clone)]
struct SpeedDependent {
    reference: f64,
}

impl Response for SpeedDependent {
    fn impulse(
        &self,
        frame: &ContactFrame,
        bodies: [(&Motion, &Inertia); 2],
        e: Elasticity,
    ) -> DVec2 {
        let approach = approach_speed(frame, [bodies[0].0, bodies[1].0]);
        let share = (0.1 * approach / self.reference).clamp(0.0, 1.0);
        // 1 where e is 1, so that the engine's guard against inelastic collapse works.
        let coefficient = 1.0 - share * (1.0 - e.coefficient());
        let elasticity = Elasticity::new(coefficient).expect("between e and 1");
        Impact.impulse(frame, bodies, elasticity)
    }
}

/// Removes all relative motion along the normal, at any elasticity.
#[derive(Debug, Clone)]
struct Sticky;

impl Response for Sticky {
    fn impulse(
        &self,
        frame: &ContactFrame,
        bodies: [(&Motion, &Inertia); 2],
        _: Elasticity,
    ) -> DVec2 {
        Impact.impulse(frame, bodies, Elasticity::new(0.0).expect("in range"))
    }
}

/// Sums the changes of energy at contacts, from the reports.
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
    scene.elasticity.default = 0.5;
    scene
}

#[test]
fn the_ledger_records_what_a_response_loses() {
    let response = SpeedDependent { reference: 1.0 };
    check_ledger::<HeapScheduler, _>(&mixture(), &response);
    check_ledger::<CellScheduler, _>(&mixture(), &response);
    // A gas of discs uses a faster path of the engine.
    let mut discs = Scene {
        gas: vec![gas("disc", 0.02, 100)],
        ..Scene::default()
    };
    discs.elasticity.default = 0.5;
    check_ledger::<CellScheduler, _>(&discs, &response);
}

fn check_ledger<S: Scheduler + Clone, R: Response + Clone>(scene: &Scene, response: &R) {
    let mut simulation = simulate::<_, S>(scene, response.clone());
    let before = simulation.view().energy();
    let mut change = Change::default();
    simulation.observe_until(1.0, &mut change).unwrap();
    let view = simulation.view();
    assert!(view.energy() < 0.9 * before);
    assert!(
        (view.energy() - before - change.0).abs() < 1e-12 * before,
        "{change:?}"
    );
    let ledger = view.ledger();
    assert!(
        (ledger.lost + change.0).abs() < 1e-12 * before,
        "{ledger:?} {change:?}"
    );
    assert!((view.energy() - ledger.booked()).abs() < 1e-12 * before);
    simulation.check_invariants(0.01).unwrap();
}

#[test]
fn a_contact_with_a_fixed_body_has_the_impulse_of_the_response() {
    // At nine times the reference speed: e = 0.55.
    let mut billiard = scene(vec![disc(0.05, 2.0, [0.3, 0.5], [9.0, 0.0])]);
    billiard.bumper = vec![bumper(0.1, [0.7, 0.5])];
    billiard.elasticity.default = 0.5;
    for once in [check_bumper::<HeapScheduler>, check_bumper::<CellScheduler>] {
        once(&billiard);
    }
}

fn check_bumper<S: Scheduler>(billiard: &Scene) {
    let mut simulation = simulate::<_, S>(billiard, SpeedDependent { reference: 1.0 });
    assert!(simulation.step(1.0, &mut ()).unwrap());
    let velocity = crate::support::velocity(&simulation.view(), 0);
    assert!(
        (velocity - DVec2::new(-0.55 * 9.0, 0.0)).length() < 1e-14,
        "{velocity}"
    );
    assert!(
        (simulation.view().ledger().lost - 0.5 * 2.0 * 81.0 * (1.0 - 0.55 * 0.55)).abs() < 1e-12
    );
}

/// Loses a share of the energy that the table gives: 1 − share (1 − e) instead of e.
#[derive(Debug, Clone)]
struct Milder {
    share: f64,
}

impl Response for Milder {
    fn impulse(
        &self,
        frame: &ContactFrame,
        bodies: [(&Motion, &Inertia); 2],
        e: Elasticity,
    ) -> DVec2 {
        let milder =
            Elasticity::new(1.0 - self.share * (1.0 - e.coefficient())).expect("from e to 1");
        Impact.impulse(frame, bodies, milder)
    }
}

/// Has the elasticity 3/4 for any argument.
#[derive(Debug, Clone)]
struct ThreeQuarters;

impl Response for ThreeQuarters {
    fn impulse(
        &self,
        frame: &ContactFrame,
        bodies: [(&Motion, &Inertia); 2],
        _: Elasticity,
    ) -> DVec2 {
        Impact.impulse(frame, bodies, Elasticity::new(0.75).expect("in range"))
    }
}

#[test]
fn saved_energy_is_counted_only_if_the_response_uses_the_raised_elasticity() {
    for once in [
        check_rattle::<HeapScheduler, _>,
        check_rattle::<CellScheduler, _>,
    ] {
        // The first contact has no contact before it. Each later one would lose ½ (1 − 9/16) u².
        once(
            Milder { share: 0.5 },
            0.75,
            9,
            9.0 * 0.5 * (7.0 / 16.0) * (9.0 / 16.0),
        );
    }
    for once in [
        check_rattle::<HeapScheduler, _>,
        check_rattle::<CellScheduler, _>,
    ] {
        once(ThreeQuarters, 0.75f64.powi(10), 0, 0.0);
    }
}

/// A disc of mass 1 and speed 1 between two bumpers at so small a distance that all ten contacts
/// but the first are guarded: checks its speed at the end, the number of contacts that the guard
/// has changed, and the energy saved.
fn check_rattle<S: Scheduler, R: Response>(response: R, speed: f64, guarded: u64, spared: f64) {
    let mut narrow = scene(vec![disc(0.05, 1.0, [0.5, 0.5], [1.0, 0.0])]);
    narrow.bumper = vec![
        bumper(0.1, [0.35 - 4.5e-6, 0.5]),
        bumper(0.1, [0.65 + 4.5e-6, 0.5]),
    ];
    narrow.elasticity.default = 0.5;
    let mut simulation = simulate::<R, S>(&narrow, response);
    for _ in 0..10 {
        assert!(simulation.step(1.0, &mut ()).unwrap());
    }
    let view = simulation.view();
    assert!((crate::support::velocity(&view, 0).x.abs() - speed).abs() < 1e-15);
    assert_eq!(view.counters().guarded_collisions, guarded);
    let ledger = view.ledger();
    assert!((ledger.spared - spared).abs() < 1e-14, "{ledger:?}");
    assert!(
        (ledger.lost - 0.5 * (1.0 - speed * speed)).abs() < 1e-15,
        "{ledger:?}"
    );
}

/// Elasticities uniformly distributed from e to 1, by a hash of the velocities. These are rounded
/// to single precision, so that two schedulers whose last digits differ give the same contacts.
#[derive(Debug, Clone)]
struct RandomRestitution {
    seed: u64,
}

impl Response for RandomRestitution {
    fn impulse(
        &self,
        frame: &ContactFrame,
        bodies: [(&Motion, &Inertia); 2],
        e: Elasticity,
    ) -> DVec2 {
        let mut hasher = DefaultHasher::new();
        self.seed.hash(&mut hasher);
        for (motion, _) in bodies {
            motion
                .velocity
                .to_array()
                .map(|v| (v as f32).to_bits())
                .hash(&mut hasher);
        }
        let share = (hasher.finish() >> 11) as f64 / (1u64 << 53) as f64;
        let coefficient = 1.0 - share * (1.0 - e.coefficient());
        Impact.impulse(
            frame,
            bodies,
            Elasticity::new(coefficient).expect("from e to 1"),
        )
    }
}

fn random_mixture() -> (Scene, RandomRestitution) {
    let mut scene = mixture();
    scene.elasticity.default = 0.6;
    (scene, RandomRestitution { seed: 20_261_123 })
}

#[test]
fn the_ledger_records_what_random_restitution_loses() {
    let (scene, response) = random_mixture();
    check_ledger::<HeapScheduler, _>(&scene, &response);
    check_ledger::<CellScheduler, _>(&scene, &response);
}

/// The share of energy along the normal that remains after each contact, with its bodies.
#[derive(Debug, Default)]
struct Restitutions(Vec<([u64; 2], f64)>);

impl Observer for Restitutions {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let sides = &report.sides;
        let frame = ContactFrame {
            line_of_centres: report.normal,
            arms: [sides[0].arm, sides[1].arm],
        };
        let before = approach_speed(&frame, [&sides[0].before, &sides[1].before]);
        let after = approach_speed(&frame, [&sides[0].after, &sides[1].after]);
        self.0
            .push(([sides[0].body.id(), sides[1].body.id()], -after / before));
    }
}

fn restitutions<S: Scheduler>() -> Restitutions {
    let (scene, response) = random_mixture();
    let mut simulation = simulate::<_, S>(&scene, response);
    let mut seen = Restitutions::default();
    for _ in 0..100 {
        assert!(simulation.step(10.0, &mut seen).unwrap());
    }
    seen
}

#[test]
fn random_restitution_is_the_same_with_two_schedulers() {
    let (one, other) = (
        restitutions::<HeapScheduler>(),
        restitutions::<CellScheduler>(),
    );
    for (n, ((bodies, e), (others, f))) in one.0.iter().zip(&other.0).enumerate() {
        assert_eq!(bodies, others, "contact {n}");
        assert!(
            (e - f).abs() < 1e-6,
            "contact {n} of {bodies:?}: {e} and {f}"
        );
        assert!((0.6 - 1e-9..=1.0 + 1e-9).contains(e), "contact {n}: {e}");
    }
    // Uniform from 0.6 to 1: the mean of 100 is 0.8 with a standard error of 0.4/√(12 · 100).
    let mean = one.0.iter().map(|(_, e)| e).sum::<f64>() / one.0.len() as f64;
    assert!((mean - 0.8).abs() < 4.0 * 0.4 / 1200.0f64.sqrt(), "{mean}");
}

#[test]
fn random_restitution_is_the_same_after_a_checkpoint() {
    for once in [check_resume::<HeapScheduler>, check_resume::<CellScheduler>] {
        once();
    }
}

fn check_resume<S: Scheduler>() {
    let (scene, response) = random_mixture();
    let mut simulation = simulate::<_, S>(&scene, response.clone());
    assert!(
        !simulation
            .observe_epoch(EpochTime::from(1e3), &mut ())
            .unwrap()
    );
    let checkpoint = simulation.checkpoint().unwrap();
    let collisions = simulation.view().counters().collisions;
    let mut resumed = Simulation::<_, _, S>::resume_with(
        &checkpoint,
        Exact::default(),
        response,
        S::Options::default(),
    )
    .unwrap();
    let until = simulation.time().to_f64() + 3.0;
    simulation.run_until(until).unwrap();
    resumed.run_until(until).unwrap();
    assert!(simulation.view().counters().collisions > collisions + 500);
    assert_eq!(bits(&simulation.view()), bits(&resumed.view()));
    assert_eq!(simulation.view().ledger(), resumed.view().ledger());
}

#[test]
fn a_response_that_ignores_the_guard_loses_its_own_energy() {
    // A dumbbell that turns comes to rest against a disc: contacts without end, since the response
    // ignores the guard's elasticity.
    let mut lying = scene(vec![
        named("dumbbell", 0.05, 1.0, [0.4, 0.5]),
        disc(0.05, 1.0, [0.55, 0.6], [-0.5, -0.4]),
    ]);
    lying.molecule[0].angular_velocity = 3.0;
    let mut simulation = simulate::<_, CellScheduler>(&lying, Sticky);
    let initial = simulation.view().energy();
    let ended = simulation.run_until(20.0);
    assert!(
        matches!(ended, Ok(()) | Err(RunError::Stalled { .. })),
        "{ended:?}"
    );
    let view = simulation.view();
    assert_eq!(view.overlaps().pairs, 0);
    assert!((view.energy() - view.ledger().booked()).abs() < 1e-12 * initial);
}

#[test]
fn a_collapse_with_a_response_that_ignores_the_guard_ends_with_an_error() {
    for once in [
        check_collapse::<HeapScheduler>,
        check_collapse::<CellScheduler>,
    ] {
        for default in [0.5, 1.0] {
            once(default);
        }
    }
}

fn check_collapse<S: Scheduler>(default: f64) {
    // A light disc is held between a bumper and a heavy disc that approaches. It takes the velocity
    // of the heavy disc and loses it at the bumper, 10¹⁸ times before the heavy disc has lost its
    // momentum.
    let mut vice = scene(vec![
        disc(0.05, 1e-9, [0.2, 0.5], [0.0; 2]),
        disc(0.1, 1e9, [0.5, 0.5], [-1.0, 0.0]),
    ]);
    vice.bumper = vec![bumper(0.1, [0.0, 0.5])];
    vice.elasticity.default = default;
    let mut simulation = simulate::<_, S>(&vice, Sticky);
    let ended = simulation.run_until(20.0);
    let Err(RunError::Stalled { time, contacts, .. }) = ended else {
        panic!("{default}: {ended:?}")
    };
    // The two gaps between the three bodies, 0.5 − 0.2 − 0.1 together, close at speed 1.
    assert!(
        (time.to_f64() - 0.2).abs() < 1e-9 && contacts > 100,
        "{default}: {time}, {contacts}"
    );
    assert_eq!(simulation.view().overlaps().pairs, 0);
}
