//! The slowest and the fastest bodies: superelastic contacts displace no body, and bodies too slow
//! to compute with are refused in a scene, by an edit, and during a run.

use crate::support::{
    Encounters, bumper, disc, gas, named, reference_scene, scene, simulate, test_each_scheduler,
};
use carom_engine::{
    CellScheduler, EditError, Instructions, MIN_SPEED, MoleculeSpec, RunError, Scene, SceneError,
    Scheduler, Simulation, WallSpec,
};

test_each_scheduler! {
    a_superelastic_contact_does_not_displace_bodies: check_superelastic;
    velocities_times_a_power_of_two_give_the_same_trajectory_or_an_error: check_powers;
    a_system_that_has_become_too_slow_ends_with_an_error_and_a_correct_ledger: check_cooling;
}

fn check_superelastic<S: Scheduler + Clone>(options: &S::Options) {
    for power in 2..=6 {
        let elasticity = 10f64.powi(power);
        for (place, velocity) in [
            ([0.3, 0.137], [0.9, 0.41]),
            ([0.31, 0.61], [0.7, -0.33]),
            ([0.05, 0.37], [-0.2, 0.001]),
        ] {
            let mut scene = scene(vec![
                disc(0.05, 1.0, place, velocity),
                disc(0.05, 1.0, [0.1, 0.7], [0.0; 2]),
                disc(0.05, 1.0, [0.55, 0.9], [0.0; 2]),
                named("dumbbell", 0.03, 1.0, [0.6, 0.15]),
            ]);
            scene.bumper = vec![bumper(0.05, [0.83, 0.37])];
            scene.elasticity.default = elasticity;
            let mut simulation = simulate::<S>(&scene, options);
            assert!(simulation.step(10.0, &mut ()).unwrap());
            let view = simulation.view();
            let [fast, bumper] = [0, 4].map(|index| view.bodies().nth(index).unwrap().motion);
            assert!(
                fast.velocity.length() > 0.1 * elasticity,
                "the contact is that of the disc with the bumper"
            );
            let mut d = fast.position - bumper.position;
            d -= d.round();
            // The guaranteed bound for any contact is sixteen roundings of the side.
            assert!(
                (d.length() - 0.1).abs() < 16.0 * f64::EPSILON,
                "e = {elasticity}: {:e}",
                d.length() - 0.1
            );
            simulation.check_invariants(1e-3 / elasticity).unwrap();
            // The run continues.
            for _ in 0..4 {
                let Ok(true) = simulation.step(10.0, &mut ()) else {
                    break;
                };
                let deepest = simulation.view().overlaps().deepest_length;
                assert!(
                    deepest < 16.0 * f64::EPSILON,
                    "e = {elasticity}: {deepest:e}"
                );
            }
        }
    }
}

/// Two discs that at `factor` 1 meet at time 2, each at speed 1; all velocities are multiplied by
/// `factor`.
fn pair(factor: f64) -> Scene {
    scene(vec![
        disc(0.125, 1.0, [0.25, 0.5], [0.0625 * factor, 0.0]),
        disc(0.125, 1.0, [0.75, 0.5], [-0.0625 * factor, 0.0]),
    ])
}

#[test]
fn slow_discs_are_refused_with_an_error_that_names_them() {
    let refused = |scene: &Scene| Simulation::new(scene).expect_err("it is too slow");
    let error = refused(&pair(2f64.powi(-540)));
    let SceneError::TooSlow {
        entry,
        quantity: "the speed",
        speed,
    } = &error
    else {
        panic!("{error}")
    };
    assert!(entry == "molecule[0]" && *speed == 0.0625 * 2f64.powi(-540));
    let message = error.to_string();
    assert!(
        message.starts_with("molecule[0]: the speed must be 0 or at least 1e-70, but is "),
        "{message}"
    );
    // Also where the square of the speed, or the speed itself, is a denormal number.
    for speed in [0.99 * MIN_SPEED, 1e-160, 5e-324] {
        refused(&scene(vec![disc(0.1, 1.0, [0.5, 0.5], [0.0, -speed])]));
    }
    let turning = |angular_velocity| {
        scene(vec![MoleculeSpec {
            angular_velocity,
            ..named("tee", 0.01, 1.0, [0.5; 2])
        }])
    };
    let error = refused(&turning(-1e-69));
    assert!(
        matches!(error, SceneError::TooSlow { quantity, .. } if quantity.starts_with("the rim speed")),
        "{error}"
    );
    assert!(Simulation::new(&turning(1e-68)).is_ok());
    let mut of_gas = Scene {
        gas: vec![gas("dumbbell", 0.01, 10)],
        ..Scene::default()
    };
    of_gas.gas[0].energy = 1e-141;
    let error = refused(&of_gas);
    assert!(
        matches!(&error, SceneError::TooSlow { entry, .. } if entry == "gas[0]"),
        "{error}"
    );
    // Energies and masses must not give speeds that are too large either.
    (of_gas.gas[0].energy, of_gas.gas[0].atom_mass) = (1e60, Some(1e-60.into()));
    let message = refused(&of_gas).to_string();
    assert!(
        message.contains("gas[0]: the angular velocity that `energy` gives must be finite"),
        "{message}"
    );
    of_gas.gas[0].energy = 0.0;
    assert!(Simulation::new(&of_gas).is_ok());
}

fn check_powers<S: Scheduler>(options: &S::Options) {
    let mut lossy = pair(1.0);
    lossy.molecule[0].at[1] = 0.45;
    lossy.elasticity.default = 0.7;
    let scenes = [
        ("a pair", pair(1.0), 8.0),
        ("a lossy pair", lossy, 8.0),
        ("a reference_scene", reference_scene(3), 0.2),
    ];
    for (name, scene, until) in scenes {
        let run = |power: i32| -> Result<_, SceneError> {
            let factor = 2f64.powi(power);
            let mut scaled = scene.clone();
            for molecule in &mut scaled.molecule {
                molecule.velocity = molecule.velocity.map(|v| v * factor);
                molecule.angular_velocity *= factor;
            }
            for gas in &mut scaled.gas {
                gas.energy *= factor * factor;
            }
            let mut simulation = Simulation::<_, _, S>::with(
                &scaled,
                carom_detection::Exact::default(),
                carom_response::Impact,
                options.clone(),
            )?;
            simulation
                .run_until(until / factor)
                .expect("it is fast enough");
            assert!(simulation.view().counters().collisions > 0);
            let bodies = simulation.view().bodies().map(|body| {
                let motion = body.motion;
                (
                    motion.position,
                    motion.velocity / factor,
                    motion.orientation,
                    motion.angular_velocity / factor,
                )
            });
            Ok(bodies.collect::<Vec<_>>())
        };
        let expected = run(0).unwrap();
        let mut refused = 0;
        for power in [
            -20, -100, -200, -225, -229, -231, -233, -240, -300, -500, -540, -600, 20, 90,
        ] {
            match run(power) {
                Ok(found) => assert!(found == expected, "{name} × 2^{power}"),
                Err(error) => {
                    assert!(
                        matches!(error, SceneError::TooSlow { .. }) && power < -220,
                        "2^{power}: {error}"
                    );
                    refused += 1;
                }
            }
        }
        assert!((5..=8).contains(&refused), "{name}: {refused}");
    }
}

#[test]
fn edits_that_make_bodies_too_slow_are_refused_by_name() {
    let mut simulation = simulate::<CellScheduler>(&pair(1.0), &Instructions::Widest);
    let key = simulation.view().bodies().next().unwrap().body.key();
    // ½ m v² of the least speed is 5e-141.
    for energy in [4.9e-141, 1e-200, 1e-320] {
        let error = simulation.reset_energy(key, energy).unwrap_err();
        assert_eq!(error, EditError::Energy(energy));
        assert!(
            error.to_string().contains("a speed from 1e-70 to 1e60"),
            "{error}"
        );
    }
    simulation.reset_energy(key, 5.1e-141).unwrap();
    let slow = simulation
        .add(&disc(0.01, 1.0, [0.5, 0.1], [1e-80, 0.0]))
        .unwrap_err();
    assert!(
        matches!(&slow, EditError::Scene(SceneError::TooSlow { .. })),
        "{slow}"
    );
    assert_eq!(simulation.view().len(), 2);
    simulation.reverse();
    simulation.run_until(1.0).unwrap();
}

fn check_cooling<S: Scheduler>(options: &S::Options) {
    // A disc between two walls: each contact takes all but a millionth of its speed.
    let mut cooling = scene(vec![disc(0.125, 1.0, [0.5, 0.5], [1e-50, 0.0])]);
    cooling.wall = vec![WallSpec {
        x: Some(0.0),
        ..WallSpec::default()
    }];
    cooling.elasticity.default = 1e-6;
    let mut simulation = simulate::<S>(&cooling, options);
    let mut contacts = Encounters::since(simulation.time());
    let ended = simulation.observe_until(1e200, &mut contacts).unwrap_err();
    let RunError::TooSlow { body, speed, .. } = &ended else {
        panic!("{ended}")
    };
    // The rounding of a speed v (1 + e) − v is 1e-10 of the result: 1e-50, 1e-56, 1e-62, 1e-68,
    // 1e-74.
    assert!(
        body.id == 0 && (speed / 1e-74 - 1.0).abs() < 1e-9 && contacts.list.len() == 4,
        "{ended}"
    );
    assert!(
        ended.to_string().contains("body 0, of speed 9.99"),
        "{ended}"
    );
    let view = simulation.view();
    assert!((view.energy() - view.ledger().booked()).abs() < 1e-12 * view.ledger().initial);
    assert_eq!(view.overlaps().pairs, 0);
    // The run cannot continue, and a further call changes nothing; an edit of the body helps.
    assert_eq!(simulation.run_until(1e200), Err(ended));
    let key = simulation.view().bodies().next().unwrap().body.key();
    simulation.reset_energy(key, 0.5e-60).unwrap();
    let now = simulation.time().to_f64();
    simulation.run_until(now + 1e28).unwrap();

    // Slow bodies among faster ones end no run: their motion is lost in the rounding of positions.
    let light = disc(0.05, 1e-60, [0.25, 0.5], [1.0, 0.0]);
    let heavy = disc(0.05, 1e60, [0.75, 0.5], [0.0; 2]);
    let mut simulation = simulate::<S>(&scene(vec![light, heavy]), options);
    // It is pushed to the right and to the left in turn.
    for contact in 0..7 {
        assert!(simulation.step(100.0, &mut ()).unwrap());
        let speed = simulation.view().bodies().nth(1).unwrap().motion.velocity.x;
        let expected = if contact % 2 == 0 { 2e-120 } else { 0.0 };
        assert!(
            (speed - expected).abs() < 1e-132 && speed < MIN_SPEED,
            "{speed:e}"
        );
    }
}
