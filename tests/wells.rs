//! Wells and shoulders: single encounters in closed form, conserved quantities, all events against
//! brute force, resuming, edits, and exact averages.

use carom_detection::Exact;
use carom_engine::{
    CellScheduler, CellsPerSide, DrawKey, HeapScheduler, Instructions, Scene, Scheduler,
    Simulation, ThermostatRule, ThermostatTarget, View, WellSpec,
};
use carom_response::Impact;
use proptest::prelude::*;

use crate::support::property::cases;

/// A square well at moderate density; a shoulder and a well of two kinds, of which one has two
/// sizes; a well of three steps of large and small discs, with bumpers; discs with a well among
/// molecules; a few discs in a small box; chains with wells; rough and inelastic discs.
const SCENES: [&str; 7] = [
    "[[well]]\nbetween = [\"a\"]\nsteps = [[1.5, -1.0]]\n\
     [[gas]]\ntags = [\"a\"]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 80",
    "[[well]]\nbetween = [\"a\"]\nsteps = [[1.4, 0.7], [2.0, -0.2]]\n\
     [[well]]\nbetween = [\"a\", \"b\"]\nsteps = [[1.2, -2.0]]\n\
     [[gas]]\ntags = [\"a\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 50\n\
     [[gas]]\ntags = [\"b\"]\nradius = { values = [0.01, 0.03] }\nmass = 2.0\nenergy = 1.0\ncount = 40",
    "[[well]]\nbetween = [\"a\"]\nsteps = [[1.1, -3.0], [1.3, 0.5], [1.5, -0.25]]\n\
     [[bumper]]\ntags = [\"a\"]\nat = [0.2, 0.2]\nradius = 0.05\n\
     [[bumper]]\nat = [0.7, 0.2]\nradius = 0.05\n\
     [[molecule]]\ntags = [\"a\"]\natoms = [{ at = [0, 0], radius = 0.12, mass = 20.0 }]\n\
     at = [0.5, 0.7]\nvelocity = [0.3, 0.1]\n\
     [[gas]]\ntags = [\"a\"]\nradius = 0.015\nmass = 1.0\nenergy = 1.0\ncount = 60",
    "[[well]]\nbetween = [\"a\"]\nsteps = [[2.0, -0.5]]\n\
     [[gas]]\nshape = \"tee\"\natom_radius = 0.012\natom_mass = 1.0\nenergy = 1.0\ncount = 60\n\
     [[gas]]\ntags = [\"a\"]\nradius = 0.015\nmass = 1.0\nenergy = 1.0\ncount = 12",
    "[[well]]\nbetween = [\"a\"]\nsteps = [[1.5, -0.5], [2.2, 0.25]]\n\
     [[gas]]\ntags = [\"a\"]\nradius = 0.1\nmass = 1.0\nenergy = 1.0\ncount = 4",
    "[[well]]\nbetween = [\"a\"]\nsteps = [[1.5, -1.0]]\n\
     [[gas]]\ntags = [\"a\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 40\n\
     chain = { members = 4, tether = { max = 0.055 } }",
    "[elasticity]\ndefault = 0.9\ntangential = 0.5\ncontact_time = 1e-5\n\
     [[well]]\nbetween = [\"a\"]\nsteps = [[1.5, -0.3]]\n\
     [[gas]]\ntags = [\"a\"]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 60",
];

fn scene(number: usize, seed: u64) -> Scene {
    Scene::from_toml(&format!("[box]\nseed = {seed}\n{}", SCENES[number])).unwrap()
}

fn new(scene: &Scene) -> Simulation {
    Simulation::new(scene).unwrap()
}

fn total_energy(view: &View<'_>) -> f64 {
    view.energy() + view.energy_of_wells()
}

/// Two discs of radius 0.05 and masses 1 and 3, whose centres are on the line y = 0.5.
fn pair(steps: &str, places: [f64; 2], velocities: [f64; 2]) -> Simulation {
    let disc = |n: usize| {
        format!(
            "[[molecule]]\ntags = [\"a\"]\natoms = [{{ at = [0, 0], radius = 0.05, mass = {} }}]\n\
             at = [{}, 0.5]\nvelocity = [{}, 0.0]\n",
            [1.0, 3.0][n],
            places[n],
            velocities[n]
        )
    };
    let text = format!(
        "[[well]]\nbetween = [\"a\"]\nsteps = {steps}\n{}{}",
        disc(0),
        disc(1)
    );
    new(&Scene::from_toml(&text).unwrap())
}

fn relative_speed(simulation: &Simulation) -> f64 {
    let velocities: Vec<f64> = (simulation.view().bodies())
        .map(|body| body.motion.velocity.x)
        .collect();
    velocities[1] - velocities[0]
}

/// μ = 3/4: at the relative speed 2 the energy is 3/2.
#[test]
fn a_pair_passes_through_a_well_and_bounces_off_a_shoulder() {
    let at = |steps, times: &[f64]| {
        let mut simulation = pair(steps, [0.2, 0.8], [1.0, -1.0]);
        let mut speeds = Vec::new();
        for &time in times {
            simulation.run_until(time).unwrap();
            speeds.push(relative_speed(&simulation));
        }
        assert!((simulation.view().momentum().x + 2.0).abs() < 1e-14);
        (speeds, simulation)
    };
    // The pair reaches the range 0.3 after 0.15, the contact at 0.1 after another 0.2/√(4 + 8/3 ε)
    // and leaves the range after the same time.
    let inside = (4.0 + 8.0f64 / 3.0).sqrt();
    let (speeds, mut simulation) = at("[[3.0, -1.0]]", &[0.1, 0.2, 0.25, 0.35]);
    for (speed, expected) in speeds.iter().zip([-2.0, -inside, inside, 2.0]) {
        assert!((speed - expected).abs() < 1e-14, "{speeds:?}");
    }
    let crossed = 0.15 + 2.0 * (0.2 / inside);
    let counters = *simulation.view().counters();
    assert_eq!([counters.collisions, counters.step_collisions], [3, 2]);
    simulation.run_until(crossed + 0.05).unwrap();
    let places: Vec<f64> = (simulation.view().bodies())
        .map(|body| body.motion.position.x)
        .collect();
    assert!((places[1] - places[0] - 0.4).abs() < 1e-13);
    // A shoulder of half the energy slows it down by √½, and one of twice the energy reflects it.
    let (speeds, _) = at("[[3.0, 0.75]]", &[0.2, 0.45]);
    let slowed = 2.0f64.sqrt();
    assert!((speeds[0] + slowed).abs() < 1e-14 && (speeds[1] - 2.0).abs() < 1e-13);
    let (speeds, simulation) = at("[[3.0, 3.0]]", &[0.2]);
    assert!((speeds[0] - 2.0).abs() < 1e-14);
    assert_eq!(simulation.view().energy_of_wells(), 0.0);
    // A pair with 3/8 of energy in its centre of mass and a well of depth 1 stays bound.
    let mut bound = pair("[[3.0, -1.0]]", [0.4, 0.6], [0.5, -0.5]);
    assert_eq!(bound.view().energy_of_wells(), -1.0);
    bound.run_until(20.0).unwrap();
    assert_eq!(bound.view().pairs_in_wells().count(), 1);
    assert!(bound.view().counters().step_collisions > 40);
    assert!((total_energy(&bound.view()) / (0.5 - 1.0) - 1.0).abs() < 1e-12);
}

#[test]
fn energy_and_momentum_are_conserved() {
    for number in 0..SCENES.len() {
        let mut simulation = new(&scene(number, 3));
        let before = total_energy(&simulation.view());
        let momentum = simulation.view().momentum();
        let scale = simulation.view().energy();
        simulation.run_until(6.0).unwrap();
        let view = simulation.view();
        assert!(view.counters().step_collisions > 20, "scene {number}");
        assert_eq!(view.overlaps().pairs, 0, "scene {number}");
        let drift = view.energy() - view.ledger().booked();
        assert!(drift.abs() < 1e-12 * scale, "scene {number}: {drift:e}");
        let lost = view.ledger().lost;
        let change = total_energy(&view) + lost - before;
        assert!(change.abs() < 1e-12 * scale, "scene {number}: {change:e}");
        if view.counters().fixed_collisions == 0 {
            let change = (view.momentum() - momentum).length();
            assert!(change < 1e-11, "scene {number}: {change:e}");
        }
    }
}

/// A pair is always at the same distance when it reaches a step: roundings that depend on the
/// distance alone would add up.
#[test]
fn energy_does_not_drift_in_narrow_wells() {
    let disc = |mass: f64, place: &str, velocity: &str| {
        format!(
            "[[molecule]]\ntags = [\"a\"]\natoms = [{{ at = [0, 0], radius = 0.05, mass = {mass} }}]\n\
             at = {place}\nvelocity = {velocity}\n"
        )
    };
    // The pair bounces off the step of a deep well; it passes the inner of two steps.
    for steps in ["[[1.001, -8.0]]", "[[1.001, -3.0], [1.002, -2.9]]"] {
        for (masses, velocities) in [
            ([1.0, 1.0], ["[0.9, 0.4]", "[-0.3, -0.2]"]),
            ([1.0, 3.0], ["[0.9, 0.0]", "[-0.3, 0.0]"]),
        ] {
            let text = format!(
                "[[well]]\nbetween = [\"a\"]\nsteps = {steps}\n{}{}",
                disc(masses[0], "[0.45, 0.5]", velocities[0]),
                disc(masses[1], "[0.55005, 0.5]", velocities[1])
            );
            let mut simulation = new(&Scene::from_toml(&text).unwrap());
            let before = total_energy(&simulation.view());
            simulation.run_until(60.0).unwrap();
            let view = simulation.view();
            let events = view.counters().collisions as f64;
            assert!(events > 2e5, "{steps}: {events}");
            assert_eq!(view.pairs_in_wells().count(), 1);
            let drift = total_energy(&view) - before;
            let allowed = 4.0 * f64::EPSILON * events.sqrt() * view.energy();
            assert!(
                drift.abs() < allowed,
                "{steps}, {velocities:?}: {drift:e}, {allowed:e}"
            );
        }
    }
}

fn stepwise<S: Scheduler + Clone>(
    options: S::Options,
    scene: &Scene,
    until: f64,
) -> (Vec<f64>, [u64; 2]) {
    let mut simulation =
        Simulation::<_, _, S>::with(scene, Exact::default(), Impact, options).unwrap();
    simulation.run_until(until).unwrap();
    let counters = *simulation.view().counters();
    let motions = simulation.view().bodies();
    (
        motions
            .flat_map(|body| body.motion.position.to_array())
            .collect(),
        [counters.collisions, counters.step_collisions],
    )
}

/// Both are chaotic, so that they agree while rounding has not grown.
#[test]
fn both_schedulers_make_the_same_events() {
    for number in 0..SCENES.len() {
        let scene = scene(number, 5);
        let until = 0.2;
        let cells = stepwise::<CellScheduler>(Instructions::default(), &scene, until);
        let heap = stepwise::<HeapScheduler>(CellsPerSide::Automatic, &scene, until);
        assert_eq!(cells.1, heap.1, "scene {number}");
        assert!(cells.1[1] > 0, "scene {number}");
        for (one, other) in cells.0.iter().zip(&heap.0) {
            assert!((one - other).abs() < 1e-7, "scene {number}");
        }
    }
}

fn check<S: Scheduler + Clone>(options: S::Options, scene: &Scene, steps: usize) {
    let mut simulation =
        Simulation::<_, _, S>::with(scene, Exact::default(), Impact, options).unwrap();
    for step in 0..steps {
        simulation
            .check_invariants(0.05)
            .unwrap_or_else(|violation| panic!("step {step}: {violation}"));
        simulation.step(100.0, &mut ()).unwrap();
    }
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn no_event_is_missed(number in 0..SCENES.len(), seed in 0..1000u64) {
        let scene = scene(number, seed);
        check::<CellScheduler>(Instructions::default(), &scene, 40);
        check::<HeapScheduler>(CellsPerSide::Automatic, &scene, 40);
    }

    #[test]
    fn random_steps_conserve_energy(
        seed in 0..1000u64,
        ranges in prop::collection::vec(0.01..0.6f64, 1..6),
        energies in prop::collection::vec(-3.0..3.0f64, 5),
        count in 4..60usize,
        drag in prop::option::of(0.01..0.5f64),
    ) {
        let mut range = 1.0;
        let steps = ranges.iter().zip(&energies).map(|(width, &energy)| {
            range += width;
            [range, energy]
        });
        let mut scene = scene(0, seed);
        scene.well[0].steps = steps.collect();
        scene.gas[0].count = Some(count);
        scene.bounds.drag = drag.unwrap_or(0.0);
        let mut simulation = new(&scene);
        let before = total_energy(&simulation.view());
        simulation.run_until(1.0).unwrap();
        simulation.check_invariants(0.05).unwrap();
        let view = simulation.view();
        let ledger = view.ledger();
        prop_assert!((view.energy() - ledger.booked()).abs() < 1e-11 * (ledger.initial + ledger.wells.abs()));
        let total = total_energy(&view) + ledger.dragged;
        prop_assert!((total - before).abs() < 1e-10 * (ledger.initial + before.abs()));
    }
}

#[test]
fn time_reversal_returns() {
    let mut simulation = new(&scene(1, 8));
    let start: Vec<_> = simulation.view().bodies().map(|body| body.motion).collect();
    simulation.run_until(0.2).unwrap();
    assert!(simulation.view().counters().step_collisions > 30);
    simulation.reverse();
    simulation.run_until(0.4).unwrap();
    for (body, before) in simulation.view().bodies().zip(&start) {
        let apart = simulation
            .view()
            .bounds()
            .nearest_image(body.motion.position - before.position);
        assert!(apart.length() < 1e-8, "{apart}");
    }
}

#[test]
fn a_resumed_run_has_the_same_bits() {
    for number in 0..SCENES.len() {
        let mut simulation = new(&scene(number, 2));
        simulation.run_until(3.0).unwrap();
        let checkpoint = simulation.end_epoch_here();
        let mut resumed = Simulation::resume(&checkpoint).unwrap();
        for run in [&mut simulation, &mut resumed] {
            run.run_until(3.5).unwrap();
        }
        let bits = |simulation: &Simulation| -> Vec<u64> {
            let bodies = simulation.view().bodies();
            bodies
                .flat_map(|body| body.motion.position.to_array().map(f64::to_bits))
                .collect()
        };
        assert_eq!(bits(&simulation), bits(&resumed), "scene {number}");
        let energies = [&simulation, &resumed].map(|run| run.view().energy_of_wells().to_bits());
        assert_eq!(energies[0], energies[1]);
    }
}

/// Discs that have just passed a step, or have bounced back from it, are at its range to rounding.
#[test]
fn an_edit_after_a_step_moves_no_pair_over_it() {
    for number in 0..SCENES.len() {
        let scene = scene(number, 6);
        let mut simulation = new(&scene);
        let mut steps = 0;
        while steps < 40 {
            simulation.step(100.0, &mut ()).unwrap();
            let events = simulation.view().counters().step_collisions;
            if events > steps {
                steps = events;
                let before = simulation.view().energy_of_wells();
                simulation
                    .edit(|batch| batch.set_wells(&scene.well))
                    .unwrap();
                assert_eq!(
                    simulation.view().energy_of_wells(),
                    before,
                    "scene {number}"
                );
            }
        }
    }
}

/// A step of energy 0 changes nothing, also not to the guard against inelastic collapse.
#[test]
fn a_step_without_energy_does_not_change_the_cooling() {
    let run = |steps: &str| {
        let text = format!(
            "[elasticity]\ndefault = 0.9\ncontact_time = 0.02\n{steps}\
             [[gas]]\ntags = [\"a\"]\nradius = 0.02\nmass = 1.0\ntemperature = 1.0\ncount = 200"
        );
        let mut simulation = new(&Scene::from_toml(&text).unwrap());
        simulation.run_until(1.0).unwrap();
        let counters = *simulation.view().counters();
        (simulation.view().energy(), counters.guarded_collisions)
    };
    let (plain, guarded) = run("");
    let (with_step, also_guarded) = run("[[well]]\nbetween = [\"a\"]\nsteps = [[1.01, 0.0]]\n");
    assert!(
        (with_step / plain - 1.0).abs() < 0.05,
        "{with_step} {plain}"
    );
    assert!(
        guarded.abs_diff(also_guarded) < 20,
        "{guarded} {also_guarded}"
    );
}

#[test]
fn wells_change_in_a_run() {
    let mut simulation = new(&scene(0, 4));
    simulation.run_until(1.0).unwrap();
    let kinetic = simulation.view().energy();
    let deeper = WellSpec {
        between: vec!["a".to_owned()],
        steps: vec![[1.2, -4.0], [1.8, -0.5]],
    };
    simulation
        .edit(|batch| batch.set_wells(std::slice::from_ref(&deeper)))
        .unwrap();
    assert_eq!(simulation.view().energy(), kinetic);
    let total = total_energy(&simulation.view());
    simulation.check_invariants(0.01).unwrap();
    simulation.run_until(2.0).unwrap();
    simulation.check_invariants(0.01).unwrap();
    assert!((total_energy(&simulation.view()) - total).abs() < 1e-11 * kinetic);
    // A body that is removed leaves its wells; one that loses its tag, too.
    let key = simulation.view().bodies().next().unwrap().body.key();
    let other = simulation.view().bodies().nth(1).unwrap().body.key();
    simulation
        .edit(|batch| {
            batch.remove(key)?;
            batch.untag(other, "a")
        })
        .unwrap();
    simulation.check_invariants(0.01).unwrap();
    assert!(
        simulation
            .view()
            .pairs_in_wells()
            .all(|pair| !pair.bodies.contains(&key))
    );
    simulation.edit(|batch| batch.set_wells(&[])).unwrap();
    assert!(!simulation.view().has_wells());
    simulation.run_until(2.5).unwrap();
    simulation.check_invariants(0.01).unwrap();
}

/// Two discs alone in a box of area A with a heat bath: the share of the time in the shell k is
/// A_k e^{−u_k/kT} over the sum of all, with the area A_k of the shell.
#[test]
fn a_pair_with_a_heat_bath_has_the_boltzmann_weights() {
    let text = "[box]\nseed = 1\n[[well]]\nbetween = [\"a\"]\nsteps = [[1.5, -1.0], [2.0, 0.5]]\n\
         [[gas]]\ntags = [\"a\"]\nradius = 0.08\nmass = 1.0\ntemperature = 1.0\ncount = 2";
    let mut simulation = new(&Scene::from_toml(text).unwrap());
    let rule = ThermostatRule::Maxwell(ThermostatTarget::Temperature(1.0));
    let both = simulation.find_tag("a").unwrap();
    let samples = 40_000u32;
    let mut counts = [0.0; 3];
    for sample in 0..samples {
        let key = DrawKey {
            seed: 1,
            replica: 0,
            action: sample.into(),
        };
        simulation
            .edit(|batch| batch.thermostat(both, &rule, key))
            .unwrap();
        simulation.run_until(0.4 * f64::from(sample + 1)).unwrap();
        let shell = simulation.view().pairs_in_wells().next();
        counts[shell.map_or(2, |pair| pair.step)] += 1.0;
    }
    let area =
        |from: f64, to: f64| std::f64::consts::PI * (0.16f64 * 0.16) * (to * to - from * from);
    let outside = 1.0 - area(0.0, 2.0);
    let weights = [
        area(1.0, 1.5) * 1.0f64.exp(),
        area(1.5, 2.0) * (-0.5f64).exp(),
        outside,
    ];
    let sum: f64 = weights.iter().sum();
    for (count, weight) in counts.iter().zip(weights) {
        let (share, expected) = (count / f64::from(samples), weight / sum);
        // Samples are nearly independent: a disc crosses half the box between them.
        let error = (expected * (1.0 - expected) / f64::from(samples)).sqrt();
        assert!(
            (share - expected).abs() < 6.0 * error,
            "{share} instead of {expected}"
        );
    }
}
