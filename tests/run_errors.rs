//! Runs with very many events in a short time end at their target time, or with a named error.

use crate::support::{
    Encounters, bits, bumper, disc, gas, named, scene, simulate, test_each_scheduler, velocity,
};
use carom_engine::{MoleculeSpec, RunError, Scene, Scheduler, Simulation};
use carom_kinematics::EpochTime;
use glam::DVec2;

test_each_scheduler! {
    superelastic_contacts_end_with_a_blow_up_error: check_blow_up;
    a_refused_contact_changes_no_counter_and_no_ledger: check_refused_contact;
    an_inelastic_collapse_without_a_guard_ends_at_rest_or_with_an_error: check_collapse;
    a_chain_of_touching_discs_transfers_a_velocity_at_one_instant: check_chain;
    simultaneous_contacts_happen_in_the_order_of_insertion: check_lattice;
    a_stalled_run_does_not_change_any_more: check_stall;
    a_wedge_with_contacts_without_end_gives_a_stall_error: check_wedge;
    a_body_too_fast_for_another_to_move_measurably_is_named: check_outpaced;
}

fn check_blow_up<S: Scheduler>(options: &S::Options) {
    // Each hit doubles the speed: after 60/lg 2 = 200 hits it exceeds 1e60, at a time given by the
    // geometric series of the flights: 0.15 + 0.3 (1/2 + 1/4 + …).
    let mut between = scene(vec![disc(0.1, 1.0, [0.5, 0.5], [1.0, 0.0])]);
    between.bumper = vec![bumper(0.25, [0.0, 0.5])];
    between.elasticity.default = 2.0;
    let mut simulation = simulate::<S>(&between, options);
    let ended = simulation.run_until(10.0).unwrap_err();
    assert!(ended.to_string().contains("body 0 is too fast"), "{ended}");
    let RunError::BlowUp { time, speed, .. } = ended else {
        panic!("{ended}")
    };
    assert!((time.to_f64() - 0.45).abs() < 1e-12 && speed > 1e60);
    assert!((199..=201).contains(&simulation.view().counters().collisions));
    // The run cannot continue, and a further call changes nothing.
    let stopped = simulation.view().bodies().next().unwrap().motion;
    let (at, collisions) = (simulation.time(), simulation.view().counters().collisions);
    assert!(matches!(
        simulation.run_until(10.0),
        Err(RunError::BlowUp { .. })
    ));
    let still = simulation.view().bodies().next().unwrap().motion;
    assert_eq!(still.velocity, stopped.velocity);
    assert!((still.position - stopped.position).length() < 1e-15);
    assert!(simulation.time().since(at).abs() < 1e-30);
    assert_eq!(simulation.view().counters().collisions, collisions);
    assert!((simulation.view().energy() / simulation.view().ledger().booked() - 1.0).abs() < 1e-12);

    // A gas of molecules with an elasticity just above 1.
    let mut gas = Scene {
        gas: vec![gas("disc", 0.05, 20), gas("dumbbell", 0.03, 10)],
        ..Scene::default()
    };
    gas.elasticity.default = 1.2;
    let mut simulation = simulate::<S>(&gas, options);
    // At such speeds the clock may stop advancing before a speed is out of range.
    let ended = simulation.run_until(1e3);
    assert!(matches!(
        ended,
        Err(RunError::BlowUp { .. } | RunError::TimeStandsStill { .. })
    ));
    let energy = simulation.view().energy();
    assert!(energy.is_finite(), "{energy}");
    assert_eq!(simulation.view().overlaps().pairs, 0);
}

fn check_refused_contact<S: Scheduler>(options: &S::Options) {
    // A disc hit by the heavy disc leaves with twice its speed, above 1e60, since the guard makes
    // the contact elastic.
    let mut scene = scene(vec![
        disc(0.05, 1e9, [0.25, 0.5], [0.9e60, 0.0]),
        MoleculeSpec {
            orientation_turns: Some(0.25),
            ..named("dumbbell", 0.05, 1.0, [0.6, 0.53])
        },
    ]);
    scene.elasticity.default = 0.0;
    scene.elasticity.contact_time = 1.0;
    let mut simulation = simulate::<S>(&scene, options);
    for _ in 0..3 {
        assert!(matches!(
            simulation.run_until(1e-59),
            Err(RunError::BlowUp { .. })
        ));
        let view = simulation.view();
        assert_eq!(
            (
                view.counters().guarded_collisions,
                view.counters().collisions
            ),
            (0, 0)
        );
        assert_eq!((view.ledger().spared, view.ledger().lost), (0.0, 0.0));
    }
}

fn check_collapse<S: Scheduler>(options: &S::Options) {
    // Three discs in a row that are pressed together: below e = 7 − 4√3 = 0.0718 they collide
    // infinitely often in a finite time (McNamara and Young 1992).
    for e in [0.0, 0.01, 0.05, 0.07, 0.1, 0.5] {
        for squeeze in [false, true] {
            let mut row = scene(vec![
                disc(0.05, 1.0, [0.25, 0.5], [1.0, 0.0]),
                disc(0.05, 1.0, [0.5, 0.5], [0.1, 0.0]),
                disc(0.05, 1.0, [0.75, 0.5], [-1.0, 0.0]),
            ]);
            if squeeze {
                row.bumper = vec![bumper(0.05, [0.1, 0.5]), bumper(0.05, [0.9, 0.5])];
            }
            row.elasticity.default = e;
            row.elasticity.contact_time = 0.0;
            let mut simulation = simulate::<S>(&row, options);
            let ended = simulation.run_until(100.0);
            let view = simulation.view();
            match ended {
                Ok(()) => assert_eq!(view.time().to_f64(), 100.0),
                Err(RunError::Stalled { contacts, .. }) => assert!(contacts > 100),
                Err(error) => panic!("{error}"),
            }
            assert!(view.counters().collisions < 100_000);
            let energy = view.energy();
            assert!((0.0..0.5).contains(&energy), "e = {e}: {energy}");
            assert_eq!(view.overlaps().pairs, 0, "e = {e}");
            if !squeeze {
                assert!((view.momentum().x - 0.1).abs() < 1e-14);
            }
        }
    }
}

fn check_chain<S: Scheduler>(options: &S::Options) {
    const COUNT: usize = 100;
    let mut list = vec![disc(0.5, 1.0, [1.0, 2.0], [1.0, 0.0])];
    list.extend((0..COUNT).map(|i| disc(0.5, 1.0, [3.0 + i as f64, 2.0], [0.0; 2])));
    let mut scene = scene(list);
    scene.bounds.sides = [128.0, 4.0];
    let mut simulation = simulate::<S>(&scene, options);
    let mut blows = Encounters::since(EpochTime::ZERO);
    simulation.observe_until(1.5, &mut blows).unwrap();
    assert_eq!(blows.list.len(), COUNT);
    assert!(
        blows
            .list
            .iter()
            .all(|blow| (blow.time - 1.0).abs() < 1e-13)
    );
    assert!((velocity(&simulation.view(), COUNT) - DVec2::X).length() < 1e-13);
}

fn check_lattice<S: Scheduler>(options: &S::Options) {
    // 64 discs on a square lattice whose first events are all at time 0: they start on the borders
    // of cells and move outwards.
    const SIDE: usize = 8;
    let lattice = |velocity: fn(usize, usize) -> [f64; 2]| {
        let place = |k: usize| {
            [
                (k % SIDE) as f64 / SIDE as f64,
                (k / SIDE) as f64 / SIDE as f64,
            ]
        };
        scene(
            (0..SIDE * SIDE)
                .map(|k| disc(0.03125, 1.0, place(k), velocity(k % SIDE, k / SIDE)))
                .collect(),
        )
    };
    let mut together = simulate::<S>(&lattice(|_, _| [-1.0, -1.0]), options);
    together.run_until(3.0).unwrap();
    assert_eq!(together.view().counters().collisions, 0);
    assert_eq!(velocity(&together.view(), 17), DVec2::splat(-1.0));

    // Neighbours in a row move towards each other: 32 pairs collide at one instant, and so on after
    // each reversal.
    let mirrored = lattice(|column, _| {
        if column % 2 == 0 {
            [1.0, 0.0]
        } else {
            [-1.0, 0.0]
        }
    });
    let mut simulation = simulate::<S>(&mirrored, options);
    let mut list = Encounters::since(EpochTime::ZERO);
    simulation.observe_until(0.5, &mut list).unwrap();
    // Each has a free path of 0.0625 on either side: collisions at 1/32, 3/32, … 15/32.
    assert_eq!(list.list.len(), 8 * SIDE * SIDE / 2);
    for (n, encounter) in list.list.iter().enumerate() {
        let round = n / (SIDE * SIDE / 2);
        assert!((encounter.time - (2.0 * round as f64 + 1.0) / 32.0).abs() < 1e-15);
    }
    assert_eq!(simulation.view().energy(), 32.0);
    assert_eq!(simulation.view().momentum(), DVec2::ZERO);
    // Events at the same instant, to the last bit, are in order of insertion of the first body.
    let ties: Vec<_> = list
        .list
        .windows(2)
        .filter(|pair| pair[0].time == pair[1].time)
        .collect();
    assert!(ties.len() > SIDE * SIDE && ties.iter().all(|pair| pair[0].bodies < pair[1].bodies));

    // Four discs meet at one point, from four sides.
    let four = [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]];
    let run = || {
        let discs =
            four.map(|[x, y]| disc(0.0625, 1.0, [0.5 + 0.25 * x, 0.5 + 0.25 * y], [-x, -y]));
        let mut simulation = simulate::<S>(&scene(discs.to_vec()), options);
        simulation.run_until(0.5).unwrap();
        simulation
    };
    let simulation = run();
    assert!((simulation.view().energy() - 2.0).abs() < 1e-14);
    assert!(simulation.view().momentum().length() < 1e-14);
    assert_eq!(simulation.view().overlaps().pairs, 0);
    assert_eq!(bits(&simulation.view()), bits(&run().view()));
}

fn check_stall<S: Scheduler>(options: &S::Options) {
    // A disc is held between a bumper and a heavy disc that approaches. The faster it moves back
    // and forth, the smaller the gap, and elastic contacts would reverse the heavy disc. The
    // momentum of the heavy disc wins with e = 0.05.
    let mut vice = scene(vec![
        disc(0.05, 1e-9, [0.2, 0.5], [0.0; 2]),
        disc(0.1, 1e9, [0.5, 0.5], [-1.0, 0.0]),
    ]);
    vice.bumper = vec![bumper(0.1, [0.0, 0.5])];
    vice.molecule[0].tags = vec!["small".to_owned(), "held".to_owned()];
    vice.elasticity.default = 0.05;
    vice.elasticity.contact_time = 0.0;
    let mut simulation = simulate::<S>(&vice, options);
    let ended = simulation.run_until(10.0).unwrap_err();
    assert!(
        ended
            .to_string()
            .contains("body 0 (tags small, held) has had"),
        "{ended}"
    );
    let RunError::Stalled { time, contacts, .. } = ended else {
        panic!("{ended}")
    };
    // The gap between bumper and heavy disc, 0.5 − 0.2 − 0.1, closes at speed 1.
    assert!(
        (time.to_f64() - 0.2).abs() < 1e-9 && contacts > 100,
        "{time}"
    );
    for _ in 0..2 {
        assert!(matches!(
            simulation.run_until(10.0),
            Err(RunError::Stalled { .. })
        ));
        assert!(simulation.time().since(time).abs() < 1e-12);
        assert!(simulation.view().overlaps().deepest_length < 1e-12);
    }
}

#[test]
fn bodies_too_small_for_the_rounding_of_positions_are_refused() {
    // Discs of radius r in the unit square touch at 2r: the least is 1e-13 of the side.
    let pair = |radius: f64| {
        scene(vec![
            disc(radius, 1.0, [0.25, 0.5], [1.0, 0.0]),
            disc(radius, 1.0, [0.75, 0.5], [0.0; 2]),
            disc(0.1, 1.0, [0.5, 0.2], [0.0; 2]),
        ])
    };
    let refusal = |scene: &Scene| Simulation::new(scene).err().map(|error| error.to_string());
    let message = refusal(&pair(4e-14)).expect("it is refused");
    assert!(
        message.contains("molecule[0] and molecule[1]") && message.contains("8e-14"),
        "{message}"
    );
    assert_eq!(refusal(&pair(6e-14)), None);
    // A point among large discs is accepted.
    let mut point = pair(0.05);
    point.molecule[0] = disc(1e-40, 1.0, [0.25, 0.5], [1.0, 0.0]);
    assert_eq!(refusal(&point), None);
}

#[test]
fn a_guard_below_the_rounding_of_positions_is_refused() {
    let refusal = |contact_time: f64| {
        let mut scene = Scene::default();
        scene.elasticity.contact_time = contact_time;
        Simulation::new(&scene).err().map(|error| error.to_string())
    };
    assert_eq!(refusal(0.0), None);
    assert_eq!(refusal(1e-5), None);
    let message = refusal(2e-6).expect("it is refused");
    assert!(
        message.contains("elasticity.contact_time") && message.contains("2e-6"),
        "{message}"
    );
}

fn check_wedge<S: Scheduler>(options: &S::Options) {
    // Two bumpers with a gap too narrow by 1e-9: on the axis the disc touches both at one instant,
    // as at the tip of a wedge of 5e-5 radians, with π/5e-5 contacts in no time.
    let mut funnel = scene(vec![disc(0.0625, 1.0, [0.25, 0.5], [1.0, 0.0])]);
    let away = 0.125 + 0.0625 * (1.0 - 1e-9);
    funnel.bumper = vec![
        bumper(0.125, [0.625, 0.5 - away]),
        bumper(0.125, [0.625, 0.5 + away]),
    ];
    let ended = simulate::<S>(&funnel, options).run_until(1.0);
    assert!(
        matches!(ended, Err(RunError::Stalled { contacts: 1001, .. })),
        "{ended:?}"
    );
}

fn check_outpaced<S: Scheduler>(options: &S::Options) {
    let with_slow = |fast| scene(vec![fast, disc(0.02, 1.0, [0.7, 0.1], [1.0, 0.25])]);
    // An epoch ends after 64 turns, or a few crossings of the box, in which the slow disc moves by
    // about 1e-14 of the side.
    let rotor = |spin: f64| MoleculeSpec {
        angular_velocity: spin,
        ..named("rod:6", 0.02, 10.0, [0.3, 0.5])
    };
    let flier = |speed: f64| disc(0.02, 1.0, [0.3, 0.5], [speed, 0.0]);
    let ended = |scene: &Scene, until: f64| simulate::<S>(scene, options).run_until(until);
    for fast in [rotor(4e16), rotor(4e30), flier(1e14), flier(1e30)] {
        let scene = with_slow(fast);
        let mut simulation = simulate::<S>(&scene, options);
        let error = simulation.run_until(0.2).unwrap_err();
        let RunError::TimeScalesTooFarApart {
            time,
            speed,
            spin,
            way,
            ..
        } = error.clone()
        else {
            panic!("{error}")
        };
        assert!(
            spin == scene.molecule[0].angular_velocity && speed == scene.molecule[0].velocity[0]
        );
        // The error is returned before any position has an error above 1e-10.
        assert!(
            time.to_f64() > 0.0 && time.to_f64() < 1e-8 && way < 1e-13,
            "{time} {way}"
        );
        assert!(
            error.to_string().contains("body 0") && error.to_string().contains("body 1"),
            "{error}"
        );
        // The run cannot continue, and a further call changes nothing.
        assert_eq!(simulation.run_until(0.2), Err(error));
        assert_eq!(simulation.view().overlaps().pairs, 0);
    }
    // Also within a run, and no earlier than if the run had begun there.
    let mut simulation = simulate::<S>(&with_slow(flier(1.0)), options);
    simulation.run_until(0.05).unwrap();
    let key = simulation.view().bodies().next().unwrap().body.key();
    simulation.reset_energy(key, 0.5e28).unwrap();
    let error = simulation.run_until(0.2).unwrap_err();
    assert!(
        matches!(error, RunError::TimeScalesTooFarApart { time, .. } if time.to_f64() > 0.05 + 1e-10),
        "{error}"
    );
    // Equal at any speed, to the bit.
    let times = [0, 40].map(|power: i32| {
        let factor = 2f64.powi(power);
        let mut scene = with_slow(rotor(4e16 * factor));
        scene.molecule[1].velocity = [factor, 0.25 * factor];
        let Err(RunError::TimeScalesTooFarApart { time, .. }) = ended(&scene, 0.2 / factor) else {
            panic!()
        };
        time.to_f64() * factor
    });
    assert!(times[1] == times[0], "{times:?}");
    // Accepted: a body that is only fast, turns among bodies at rest, or need not move so far.
    assert_eq!(ended(&with_slow(flier(1e3)), 100.0), Ok(()));
    let mut resting = with_slow(rotor(1.0));
    resting.molecule[1].velocity = [0.0; 2];
    assert_eq!(ended(&resting, 3e7), Ok(()));
    resting.molecule[1].velocity = [1e-20, 0.0];
    assert_eq!(ended(&resting, 3e7), Ok(()));
}
