//! Brute-force checks after each event: no overlap, no missed contact, and the energy agrees with
//! the ledger.

use crate::support::{bumper, gas, named, scene, scenes, simulate};
use carom_engine::{CellScheduler, CellsPerSide, HeapScheduler, Instructions, Scene, Scheduler};

fn walk<S: Scheduler + Clone>(name: &str, scene: &Scene, options: &S::Options, events: usize) {
    let mut simulation = simulate::<S>(scene, options);
    for event in 0..events {
        // A horizon of a few flights: the scheduler's next contact is well before it.
        if let Err(violation) = simulation.check_invariants(1.0) {
            panic!("{name}, event {event}: {violation}");
        }
        assert!(
            simulation.step(1e3, &mut ()).unwrap(),
            "{name}: there are no more contacts"
        );
    }
}

fn walk_with_each(name: &str, mut scene: Scene) {
    for (seed, cells) in [1, 2, 3, 5].into_iter().enumerate() {
        scene.bounds.seed = seed as u64;
        walk::<HeapScheduler>(
            &format!("{name}, {cells} cells per side"),
            &scene,
            &CellsPerSide::Given(cells),
            60,
        );
    }
    scene.bounds.seed = 17;
    walk::<CellScheduler>(&format!("{name}, fast"), &scene, &Instructions::Widest, 60);
    scene.elasticity.default = 0.7;
    walk::<HeapScheduler>(
        &format!("{name}, inelastic"),
        &scene,
        &CellsPerSide::Automatic,
        60,
    );
    walk::<CellScheduler>(
        &format!("{name}, fast and inelastic"),
        &scene,
        &Instructions::Widest,
        60,
    );
}

#[test]
fn discs() {
    walk_with_each(
        "discs",
        Scene {
            gas: vec![gas("disc", 0.08, 10)],
            ..Scene::default()
        },
    );
}

#[test]
fn mixtures() {
    let gases = vec![gas("disc", 0.1, 3), gas("disc", 0.03, 10)];
    walk_with_each(
        "mixture",
        Scene {
            gas: gases,
            ..Scene::default()
        },
    );
    // Cells so small that some lie wholly inside a large disc. The large discs are light and so
    // fast that they often leave their shells and hit each other, the bumper and the tee.
    let mut start = scene(vec![named("tee", 0.02, 1.0, [0.5, 0.5])]);
    start.bumper = vec![bumper(0.1, [0.0, 0.0])];
    start.gas = vec![gas("disc", 0.13, 4), gas("disc", 0.008, 300)];
    start.gas[0].atom_mass = Some(0.01.into());
    walk::<CellScheduler>("fast large discs", &start, &Instructions::Widest, 80);
    start.molecule.clear();
    walk::<CellScheduler>(
        "fast large discs among discs alone",
        &start,
        &Instructions::Widest,
        80,
    );
}

#[test]
fn tees_and_dumbbells() {
    let gases = vec![
        gas("tee", 0.025, 3),
        gas("dumbbell", 0.04, 4),
        gas("disc", 0.04, 5),
    ];
    walk_with_each(
        "tees",
        Scene {
            gas: gases,
            ..Scene::default()
        },
    );
}

#[test]
fn bumpers() {
    let mut start = scene(vec![named("tee", 0.02, 1.0, [0.5, 0.5])]);
    start.molecule[0].fixed = true;
    start.bumper = vec![bumper(0.1, [0.0, 0.0]), bumper(0.05, [0.5, 0.999])];
    start.gas = vec![gas("dumbbell", 0.03, 4), gas("disc", 0.05, 6)];
    walk_with_each("bumpers", start);
}

#[test]
fn all_kinds_of_scenes_keep_the_invariants() {
    for (name, scene) in scenes() {
        let mut cells = simulate::<CellScheduler>(&scene, &Instructions::Widest);
        for _ in 0..60 {
            cells
                .check_invariants(0.05)
                .unwrap_or_else(|violation| panic!("{name}: {violation}"));
            for _ in 0..7 {
                cells.step(1e3, &mut ()).unwrap();
            }
        }
    }
}

#[test]
fn the_invariants_hold_after_edits() {
    let mut start = scene(vec![]);
    start.gas = vec![gas("dumbbell", 0.03, 4), gas("disc", 0.05, 8)];
    let mut simulation = simulate::<HeapScheduler>(&start, &CellsPerSide::Given(3));
    for round in 0..12 {
        for _ in 0..7 {
            simulation.step(1e3, &mut ()).unwrap();
        }
        let keys: Vec<_> = simulation
            .view()
            .bodies()
            .map(|body| body.body.key())
            .collect();
        match round % 4 {
            0 => simulation.remove(keys[keys.len() / 2]).unwrap(),
            1 => simulation.reset_energy(keys[0], 3.0).unwrap(),
            2 => simulation
                .set_scheduler_options(&CellsPerSide::Given(2 + round % 3))
                .unwrap(),
            _ => {
                let spot = (0..100).find_map(|k| {
                    let at = [f64::from(k % 10) / 10.0, f64::from(k / 10) / 10.0];
                    simulation
                        .add(&crate::support::disc(0.02, 0.5, at, [1.0, 0.3]))
                        .ok()
                });
                assert!(spot.is_some(), "no space for one more disc");
            }
        }
        simulation.check_invariants(1.0).unwrap();
    }
}
