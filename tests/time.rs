//! Time: runs end at their target at any age of the system, and without events only the time
//! changes.

use crate::support::{
    Encounters, bits, bumper, disc, frozen, named, reference_scene, scene, simulate,
    test_each_scheduler, velocity,
};
use carom_engine::{MoleculeSpec, RunError, Scene, Scheduler};
use carom_kinematics::EpochTime;
use glam::DVec2;

test_each_scheduler! {
    without_events_only_the_time_changes: check_nothing;
    a_past_time_changes_nothing_and_an_infinite_one_is_refused: check_times;
    an_event_after_the_least_positive_time_is_no_obstacle: check_least_times;
    events_at_exactly_the_end_belong_to_the_run: check_last_instant;
    the_trajectory_does_not_depend_on_the_age_of_the_system: check_age;
    a_million_epochs_do_not_accumulate_rounding_of_time: check_long_run;
}

fn check_nothing<S: Scheduler>(options: &S::Options) {
    let mut only_bumpers = scene(vec![]);
    only_bumpers.bumper = vec![
        bumper(0.1, [0.0, 0.0]),
        bumper(0.2, [0.1, 0.1]),
        bumper(0.3, [0.5, 0.5]),
    ];
    let at_rest = scene(vec![
        disc(0.1, 1.0, [0.2, 0.2], [0.0; 2]),
        // Touching, to the bit.
        disc(0.125, 1.0, [0.5, 0.5], [0.0; 2]),
        disc(0.125, 1.0, [0.75, 0.5], [0.0; 2]),
        named("tee", 0.02, 1.0, [0.2, 0.8]),
    ]);
    let mut alone = scene(vec![MoleculeSpec {
        angular_velocity: 3.0,
        velocity: [0.1, 0.7],
        ..named("tee", 0.05, 1.0, [0.5, 0.5])
    }]);
    alone.bounds.sides = [1.0, 2.0];
    for scene in [Scene::default(), only_bumpers, at_rest, alone] {
        let mut simulation = simulate::<S>(&scene, options);
        let start = bits(&simulation.view());
        for time in [0.0, 1e-300, 1.0, 50.0] {
            simulation.run_until(time).unwrap();
            assert_eq!(simulation.time().to_f64(), time);
        }
        assert!(!simulation.step(60.0, &mut ()).unwrap());
        assert_eq!(simulation.time().to_f64(), 60.0);
        let view = simulation.view();
        assert_eq!((view.counters().collisions, view.overlaps().pairs), (0, 0));
        assert_eq!(view.len(), start.len());
        if view.energy() == 0.0 {
            assert_eq!(bits(&view), start);
        }
    }
}

fn check_times<S: Scheduler>(options: &S::Options) {
    let mut simulation = simulate::<S>(&reference_scene(12), options);
    simulation.run_until(0.5).unwrap();
    let (now, counters) = (bits(&simulation.view()), *simulation.view().counters());
    for present in [0.5, 0.5 - 1e-16] {
        simulation.run_until(present).unwrap();
        assert!(!simulation.step(present, &mut ()).unwrap());
    }
    for past in [0.499, 0.5 - 1e-14, 0.0, -1.0, -1e300] {
        let expected = RunError::Past {
            until: past,
            now: simulation.time(),
        };
        assert_eq!(simulation.run_until(past), Err(expected.clone()));
        assert_eq!(simulation.step(past, &mut ()), Err(expected.clone()));
        assert_eq!(simulation.sample_every(0.1, past, &mut ()), Err(expected));
    }
    assert_eq!(simulation.run_until(1e301), Err(RunError::Time(1e301)));
    assert_eq!(
        simulation.sample_every(1e290, 1e301, &mut ()),
        Err(RunError::Time(1e301))
    );
    for never in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(matches!(
            simulation.run_until(never),
            Err(RunError::Time(_))
        ));
        assert!(matches!(
            simulation.step(never, &mut ()),
            Err(RunError::Time(_))
        ));
    }
    assert_eq!(simulation.time().to_f64(), 0.5);
    assert_eq!(
        (bits(&simulation.view()), *simulation.view().counters()),
        (now, counters)
    );
}

/// A disc leaves the box or a cell after a time so short that its reciprocal is infinite.
fn check_least_times<S: Scheduler>(options: &S::Options) {
    for distance in [0.0, 5e-324, 5.93e-317, 1e-308] {
        let falling = |x: f64| disc(0.02, 1.0, [x, distance], [0.0, -2.6]);
        let mut start = scene([0.1, 0.3, 0.5, 0.7, 0.9].map(falling).to_vec());
        start.bumper = vec![bumper(0.01, [0.11, 0.3]), bumper(0.01, [0.52, 0.45])];
        let mut simulation = simulate::<S>(&start, options);
        simulation.run_until(20.0).unwrap();
        let view = simulation.view();
        assert!(view.counters().collisions > 0 && view.overlaps().pairs == 0);
        assert!((view.energy() / (5.0 * 0.5 * 6.76) - 1.0).abs() < 1e-13);
    }
}

fn check_last_instant<S: Scheduler>(options: &S::Options) {
    // The gap of 0.25 closes at speed 1 at exactly 0.25.
    let pair = scene(vec![
        disc(0.125, 1.0, [0.25, 0.5], [1.0, 0.0]),
        disc(0.125, 1.0, [0.75, 0.5], [0.0; 2]),
    ]);
    let mut simulation = simulate::<S>(&pair, options);
    simulation.run_until(0.25f64.next_down()).unwrap();
    assert_eq!(simulation.view().counters().collisions, 0);
    simulation.run_until(0.25).unwrap();
    assert_eq!(simulation.view().counters().collisions, 1);
    assert_eq!(velocity(&simulation.view(), 1), DVec2::X);
    simulation.run_until(0.25).unwrap();
    assert_eq!(simulation.view().counters().collisions, 1);
}

fn check_age<S: Scheduler>(options: &S::Options) {
    let bodies = frozen(&simulate::<S>(&reference_scene(13), options).view()).molecule;
    let run = |start: f64| {
        // An empty box reaches the age in one step; then all bodies are added.
        let mut simulation = simulate::<S>(&Scene::default(), options);
        simulation.run_until(start).unwrap();
        for body in &bodies {
            simulation.add(body).unwrap();
        }
        let mut list = Encounters::since(EpochTime::from(start));
        simulation.observe_until(start + 2.0, &mut list).unwrap();
        assert!(list.list.len() > 500);
        let motions: Vec<_> = simulation.view().bodies().map(|body| body.motion).collect();
        (motions, list.list)
    };
    let (motions, list) = run(0.0);
    for age in [1.0, 1e6, 1e12, 2f64.powi(50)] {
        let (aged_motions, aged_list) = run(age);
        for (aged, young) in aged_list.iter().zip(&list) {
            assert_eq!(
                (aged.bodies, aged.atoms, aged.image),
                (young.bodies, young.atoms, young.image)
            );
            assert!((aged.time - young.time).abs() < 1e-15, "at {age:e}");
        }
        for (aged, young) in aged_motions.iter().zip(&motions) {
            assert_eq!(aged.velocity, young.velocity, "at {age:e}");
            assert_eq!(aged.angular_velocity, young.angular_velocity);
            // The last flight ends at a float of that age.
            assert!((aged.position - young.position).length() < 1e-15);
        }
    }
}

fn check_long_run<S: Scheduler>(options: &S::Options) {
    // Back and forth between two bumpers: a free path of 0.3 at speed 0.7.
    let mut scene = scene(vec![disc(0.1, 1.0, [0.5, 0.5], [0.7, 0.0])]);
    scene.bumper = vec![bumper(0.25, [0.0, 0.5])];
    let mut simulation = simulate::<S>(&scene, options);
    let mut last: Option<EpochTime> = None;
    let mut hits = 0u32;
    while hits < 200_000 {
        assert!(simulation.step(1e9, &mut ()).unwrap());
        hits += 1;
        if let Some(last) = last {
            // Roundings of positions of order 1. A time in one float would have an error of 7e-12
            // at the end.
            let error = simulation.time().since(last) - 0.3 / 0.7;
            assert!(error.abs() < 4e-15, "hit {hits}: {error:e}");
        }
        last = Some(simulation.time());
    }
    assert_eq!(velocity(&simulation.view(), 0).length(), 0.7);
    let expected = (0.15 + 0.3 * f64::from(hits - 1)) / 0.7;
    assert!((simulation.time().to_f64() / expected - 1.0).abs() < 1e-14);
}
