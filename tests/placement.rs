//! A gas can be placed densely, in mixtures and around other bodies, and starts with the requested
//! energy.

use carom_detection::Exact;
use carom_engine::{
    AtomSpec, CellsPerSide, GasSpec, HeapScheduler, Rotation, Scene, Simulation, WallSpec,
};

use crate::support::{bumper, gas, named, simulate};
use carom_response::Impact;
use glam::DVec2;

/// Builds a scene and asserts that no bodies touch.
fn filled(scene: &Scene) -> Simulation<Exact, Impact, HeapScheduler> {
    let simulation = simulate::<HeapScheduler>(scene, &CellsPerSide::Automatic);
    let census = simulation.view().overlaps();
    assert_eq!((census.pairs, census.deepest_length), (0, 0.0));
    simulation
}

fn by_area(shape: &str, atom_radius: f64, fraction: f64) -> GasSpec {
    GasSpec {
        count: None,
        area_fraction: Some(fraction),
        ..gas(shape, atom_radius, 0)
    }
}

#[test]
fn dense_gases_can_be_placed() {
    for (shape, radius, fraction) in [
        ("disc", 0.01, 0.7),
        ("disc", 0.02, 0.7),
        ("disc", 0.05, 0.65),
        ("dumbbell", 0.01, 0.4),
        ("tee", 0.01, 0.25),
        ("rod:4", 0.008, 0.2),
    ] {
        for seed in 0..3 {
            let mut scene = Scene {
                gas: vec![by_area(shape, radius, fraction)],
                ..Scene::default()
            };
            scene.bounds.seed = seed;
            let mut simulation = filled(&scene);
            let area: f64 = simulation
                .view()
                .bodies()
                .map(|view| view.body.molecule().area())
                .sum();
            // To the nearest number of molecules.
            let one = simulation
                .view()
                .bodies()
                .next()
                .unwrap()
                .body
                .molecule()
                .area();
            assert!(
                (area - fraction).abs() <= 0.5 * one + 1e-12,
                "{shape}: {area}"
            );
            simulation.step(1.0, &mut ()).unwrap();
            assert_eq!(simulation.view().overlaps().pairs, 0);
        }
    }
    // A box that is not square.
    let mut scene = Scene {
        gas: vec![by_area("disc", 0.02, 0.7)],
        ..Scene::default()
    };
    scene.bounds.sides = [2.0, 0.3];
    filled(&scene);
}

#[test]
fn overlapping_atoms_cover_the_requested_area_fraction() {
    // Two discs of radius r at distance r/5 together cover 1.13 of one disc, not 2.
    let r = 0.01;
    let atoms = [0.0, 0.2 * r].map(|x| AtomSpec {
        at: [x, 0.0],
        radius: r,
        mass: 1.0,
    });
    let fused = GasSpec {
        atoms: atoms.to_vec(),
        area_fraction: Some(0.4),
        energy: 1.0,
        ..GasSpec::default()
    };
    let simulation = filled(&Scene {
        gas: vec![fused],
        ..Scene::default()
    });
    let half = 0.1f64.acos();
    let one = r * r * (2.0 * std::f64::consts::PI - 2.0 * (half - half.sin() * half.cos()));
    assert_eq!(simulation.view().len(), (0.4 / one).round() as usize);
    let share: f64 = simulation
        .view()
        .bodies()
        .map(|view| view.body.molecule().area())
        .sum();
    assert!((share - 0.4).abs() <= 0.5 * one, "{share}");
}

#[test]
fn mixtures_can_be_placed_around_other_bodies() {
    // A size ratio of ten, with half of the covered area each.
    let scene = Scene {
        gas: vec![by_area("disc", 0.05, 0.2), by_area("disc", 0.005, 0.2)],
        ..Scene::default()
    };
    let simulation = filled(&scene);
    let large = simulation
        .view()
        .bodies()
        .filter(|view| view.body.molecule().bounding_radius() > 0.01)
        .count();
    assert_eq!(
        large,
        (0.2 / (std::f64::consts::PI * 0.0025)).round() as usize
    );

    let mut around = crate::support::scene(vec![
        named("tee", 0.04, 1.0, [0.5, 0.5]),
        named("rod:8", 0.03, 1.0, [0.5, 0.8]),
    ]);
    around.bumper = vec![bumper(0.1, [0.0, 0.0]), bumper(0.05, [0.05, 0.5])];
    around.gas = vec![by_area("dumbbell", 0.012, 0.15), by_area("disc", 0.01, 0.2)];
    filled(&around);
}

#[test]
fn a_gas_starts_with_its_energy_shared_over_its_degrees_of_freedom() {
    let mut scene = Scene {
        gas: vec![gas("dumbbell", 0.01, 200)],
        ..Scene::default()
    };
    scene.gas[0].energy = 2.5;
    let simulation = filled(&scene);
    for view in simulation.view().bodies() {
        assert!((view.energy() - 2.5).abs() < 1e-14);
        let spin = view.motion.angular_velocity;
        let turning = 0.5 * spin * spin / view.body.inertia().inverse_moment;
        assert!((turning - 2.5 / 3.0).abs() < 1e-14);
    }
    scene.gas[0].rotation = Rotation::Locked;
    let simulation = filled(&scene);
    assert!((simulation.view().energy() - 500.0).abs() < 1e-10);
    assert!(
        simulation
            .view()
            .bodies()
            .all(|view| view.motion.angular_velocity == 0.0)
    );
}

/// Total momentum of a gas of unit mass and energy in a scene, relative to √N times the speed.
fn drift(scene: &Scene) -> f64 {
    let simulation = filled(scene);
    let gas = simulation.find_tag("gas").unwrap();
    let velocities: Vec<DVec2> = simulation
        .view()
        .tagged(gas)
        .map(|view| view.motion.velocity)
        .collect();
    let speed = velocities[0].length();
    assert!(
        velocities
            .iter()
            .all(|velocity| (velocity.length() / speed - 1.0).abs() < 1e-15)
    );
    velocities.iter().sum::<DVec2>().length() / (speed * (velocities.len() as f64).sqrt())
}

#[test]
fn a_gas_starts_without_momentum_where_momentum_is_conserved() {
    let of = |count: usize, zero_momentum: Option<bool>| {
        let tags = vec!["gas".to_owned()];
        let gas = GasSpec {
            tags,
            zero_momentum,
            ..gas("disc", 0.005, count)
        };
        Scene {
            gas: vec![gas],
            ..Scene::default()
        }
    };
    let at = |x: Option<f64>, y: Option<f64>| WallSpec {
        x,
        y,
        ..WallSpec::default()
    };
    let open = at(None, None);
    let finite = WallSpec {
        from: Some([0.2, 0.5]),
        to: Some([0.8, 0.5]),
        ..open
    };
    // The default; 199 contains a triple.
    for count in [2, 3, 4, 199, 200] {
        assert!(drift(&of(count, None)) < 1e-14, "{count}");
        for wall in [at(Some(0.0), None), at(None, Some(0.0))] {
            assert!(
                drift(&Scene {
                    wall: vec![wall],
                    ..of(count, None)
                }) < 1e-14,
                "{count}"
            );
        }
    }
    // Directions are independent where a fixed body absorbs momentum, or if requested: the mean of
    // 200 unit vectors has a length of about 1/√200.
    let independent = [
        of(200, Some(false)),
        Scene {
            bumper: vec![bumper(0.1, [0.5, 0.5])],
            ..of(200, None)
        },
        Scene {
            wall: vec![finite],
            ..of(200, None)
        },
        Scene {
            wall: vec![at(Some(0.0), None), at(None, Some(0.0))],
            ..of(200, None)
        },
    ];
    for scene in independent {
        assert!((0.01..4.0).contains(&drift(&scene)), "{}", drift(&scene));
    }
    let asked = Scene {
        bumper: vec![bumper(0.1, [0.5, 0.5])],
        ..of(200, Some(true))
    };
    assert!(drift(&asked) < 1e-14);
    // A single molecule with energy must move, and so has momentum.
    assert!((drift(&of(1, None)) - 1.0).abs() < 1e-15);
    let refused = Simulation::new(&of(1, Some(true))).unwrap_err().to_string();
    assert!(refused.contains("zero_momentum"), "{refused}");
    // So the momentum of two gases of one molecule each is not 0, and that of two gases of two
    // molecules is.
    let momentum = |count: usize| {
        let scene = of(count, None);
        filled(&Scene {
            gas: [scene.gas[0].clone(), scene.gas[0].clone()].into(),
            ..scene
        })
        .view()
        .momentum()
        .length()
    };
    assert!(
        momentum(1) > 0.1 && momentum(2) < 1e-14,
        "{} {}",
        momentum(1),
        momentum(2)
    );
}

#[test]
fn given_velocities_are_not_changed() {
    let mut scene = crate::support::scene(vec![named("tee", 0.02, 1.0, [0.5, 0.5])]);
    scene.molecule[0].velocity = [0.3, -0.7];
    scene.gas = vec![gas("disc", 0.01, 50)];
    let simulation = filled(&scene);
    let view = simulation.view();
    let tee = view.bodies().next().unwrap();
    assert_eq!(tee.motion.velocity, DVec2::new(0.3, -0.7));
    let momentum = tee.motion.velocity / tee.body.inertia().inverse_mass;
    assert!((view.momentum() - momentum).length() < 1e-13);
}
