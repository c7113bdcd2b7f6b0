//! Runs with a known course: two discs, cradles, break shots, lines, billiards, very heavy and very
//! light bodies.

use crate::support::{
    Encounters, bits, bumper, disc, named, scene, simulate, test_each_scheduler, velocity,
};
use carom_engine::{MoleculeSpec, Scene, Scheduler};
use carom_kinematics::EpochTime;
use glam::DVec2;
use rand::{SeedableRng, seq::SliceRandom};
use rand_pcg::Pcg64;

test_each_scheduler! {
    two_discs_head_on: check_head_on;
    two_discs_off_centre: check_oblique;
    newtons_cradle_transfers_the_velocity_for_any_gaps: check_cradle;
    a_break_shot_is_resolved_in_the_order_of_insertion: check_break_shot;
    discs_on_a_line_sort_their_velocities: check_line;
    a_dumbbell_on_the_axis_of_two_bumpers_never_turns: check_dumbbell;
    a_billiard_keeps_its_speed: check_billiard;
    heavy_and_light_bodies_conserve_the_energy: check_masses;
}

fn check_head_on<S: Scheduler>(options: &S::Options) {
    for (m1, m2, e, v) in [
        (1.0, 1.0, 1.0, 1.0),
        (3.0, 1.0, 1.0, 0.25),
        (1.0, 1e8, 0.5, 7.0),
        (1e8, 1.0, 1.0, 1e-9),
        (2.0, 5.0, 0.0, 1e9),
    ] {
        let mut scene = scene(vec![
            disc(0.05, m1, [0.25, 0.5], [v, 0.0]),
            disc(0.1, m2, [0.65, 0.5], [0.0; 2]),
        ]);
        scene.elasticity.default = e;
        let mut simulation = simulate::<S>(&scene, options);
        let mut list = Encounters::since(EpochTime::ZERO);
        simulation.observe_until(0.3 / v, &mut list).unwrap();
        // The gap is 0.25.
        assert_eq!(list.list.len(), 1);
        assert!((list.list[0].time * v - 0.25).abs() < 1e-15);
        let expected = [
            (m1 - e * m2) * v / (m1 + m2),
            (1.0 + e) * m1 * v / (m1 + m2),
        ];
        for (index, expected) in expected.into_iter().enumerate() {
            assert!(
                (velocity(&simulation.view(), index) - DVec2::new(expected, 0.0)).length()
                    < 1e-15 * (v + expected)
            );
        }
    }
}

fn check_oblique<S: Scheduler>(options: &S::Options) {
    // Impact parameter b = 3/5 and 12/13 of σ: the normal has the slope of a Pythagorean triangle.
    for (b, cos) in [
        (0.6, 0.8),
        (12.0 / 13.0, 5.0 / 13.0),
        (0.0, 1.0),
        (1.0 - 1e-9, (2e-9f64 - 1e-18).sqrt()),
    ] {
        let sigma = 1.0;
        let mut scene = scene(vec![
            disc(0.5, 1.0, [2.0, 5.0], [1.0, 0.0]),
            disc(0.5, 1.0, [5.0, 5.0 + b * sigma], [0.0; 2]),
        ]);
        scene.bounds.sides = [10.0, 10.0];
        let mut simulation = simulate::<S>(&scene, options);
        let mut list = Encounters::since(EpochTime::ZERO);
        simulation.observe_until(3.0, &mut list).unwrap();
        let tolerance = 1e-15 / cos.max(1e-4);
        assert!(
            (list.list[0].time - (3.0 - cos)).abs() < 4.0 * tolerance,
            "b = {b}"
        );
        // The target moves along the line of centres with v cos, the other disc at right angles
        // with v b/σ.
        let target = cos * DVec2::new(cos, b);
        assert!((velocity(&simulation.view(), 1) - target).length() < 2.0 * tolerance);
        assert!((velocity(&simulation.view(), 0) - (DVec2::X - target)).length() < 2.0 * tolerance);
    }
    // With an impact parameter of σ they miss.
    let mut scene = scene(vec![
        disc(0.5, 1.0, [2.0, 5.0], [1.0, 0.0]),
        disc(0.5, 1.0, [5.0, 6.0 + 1e-12], [0.0; 2]),
    ]);
    scene.bounds.sides = [10.0, 10.0];
    let mut simulation = simulate::<S>(&scene, options);
    simulation.run_until(8.0).unwrap();
    assert_eq!(simulation.view().counters().collisions, 0);
}

fn check_cradle<S: Scheduler>(options: &S::Options) {
    const COUNT: usize = 7;
    for gap in [1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 0.0] {
        let at = |index: usize| 4.0 + index as f64 * (1.0 + gap);
        let mut list: Vec<_> = (0..COUNT)
            .map(|i| disc(0.5, 1.0, [at(i), 5.0], [0.0; 2]))
            .collect();
        list.insert(0, disc(0.5, 1.0, [2.0, 5.0], [1.0, 0.0]));
        let mut scene = scene(list);
        scene.bounds.sides = [40.0, 10.0];
        let mut simulation = simulate::<S>(&scene, options);
        let mut blows = Encounters::since(EpochTime::ZERO);
        simulation.observe_until(2.5, &mut blows).unwrap();
        let pairs: Vec<_> = blows.list.iter().map(|blow| blow.bodies).collect();
        let expected: Vec<_> = (0..COUNT as u64).map(|i| [i, i + 1]).collect();
        assert_eq!(pairs, expected, "gap {gap:e}");
        for index in 0..COUNT {
            assert!(
                velocity(&simulation.view(), index).length() < 1e-14,
                "gap {gap:e}, disc {index}"
            );
        }
        assert!((velocity(&simulation.view(), COUNT) - DVec2::X).length() < 1e-14);
        assert!((simulation.view().energy() - 0.5).abs() < 1e-15);
        assert!((blows.list[COUNT - 1].time - (1.0 + (COUNT - 1) as f64 * gap)).abs() < 1e-14);
        assert_eq!(simulation.view().overlaps().pairs, 0);
    }
}

fn check_break_shot<S: Scheduler>(options: &S::Options) {
    // The cue disc hits two discs that touch each other, both at one instant. The contacts are
    // resolved one after the other: the disc inserted first gets cos 30° of the speed, the second
    // half of that.
    let r = 0.0625;
    let x = 0.5 + (3.0f64).sqrt() * r;
    let targets = [
        disc(r, 1.0, [x, 0.5 + r], [0.0; 2]),
        disc(r, 1.0, [x, 0.5 - r], [0.0; 2]),
    ];
    let cue = disc(r, 1.0, [0.25, 0.5], [1.0, 0.0]);
    for upper_first in [true, false] {
        let mut list = targets.to_vec();
        if !upper_first {
            list.reverse();
        }
        let side = if upper_first { 1.0 } else { -1.0 };
        let run = || {
            let mut simulation = simulate::<S>(
                &scene([list.as_slice(), std::slice::from_ref(&cue)].concat()),
                options,
            );
            simulation.run_until(0.3).unwrap();
            simulation
        };
        let simulation = run();
        let view = simulation.view();
        assert_eq!(view.counters().collisions, 2);
        let (sin, cos) = (0.5, 0.75f64.sqrt());
        let first = cos * DVec2::new(cos, side * sin);
        let second = 0.5 * cos * DVec2::new(cos, -side * sin);
        assert!((velocity(&view, 0) - first).length() < 1e-15);
        assert!((velocity(&view, 1) - second).length() < 1e-15);
        assert!((velocity(&view, 2) - (DVec2::X - first - second)).length() < 1e-15);
        assert!((view.energy() - 0.5).abs() < 1e-15);
        assert_eq!(bits(&run().view()), bits(&view));
    }
}

fn check_line<S: Scheduler>(options: &S::Options) {
    const COUNT: usize = 16;
    let mut random = Pcg64::seed_from_u64(3);
    for _ in 0..10 {
        // All velocities differ by at least 0.1, so that the last two discs meet soon enough.
        let mut before: Vec<f64> = (0..COUNT).map(|i| 0.1 * i as f64 - 0.8).collect();
        before.shuffle(&mut random);
        let mut scene = scene(
            (0..COUNT)
                .map(|i| disc(0.4, 1.0, [5000.0 + i as f64, 5.0], [before[i], 0.0]))
                .collect(),
        );
        scene.bounds.sides = [10_000.0, 10.0];
        let mut simulation = simulate::<S>(&scene, options);
        // No disc has moved by half the box, so none has met another through the periodic border.
        simulation.run_until(4000.0).unwrap();
        let inversions = (0..COUNT)
            .flat_map(|j| (0..j).map(move |i| (i, j)))
            .filter(|&(i, j)| before[i] > before[j])
            .count();
        assert_eq!(simulation.view().counters().collisions, inversions as u64);
        let mut sorted = before.clone();
        sorted.sort_by(f64::total_cmp);
        for (index, expected) in sorted.into_iter().enumerate() {
            let found = velocity(&simulation.view(), index);
            assert!((found.x - expected).abs() < 1e-14);
            assert_eq!(found.y, 0.0);
        }
    }
}

fn check_dumbbell<S: Scheduler>(options: &S::Options) {
    // Motion along the x axis; the free path from one bumper to the other and back is
    // 2 × (0.6 − 0.4 − 0.1).
    let dumbbell = MoleculeSpec {
        velocity: [0.3, 0.0],
        ..named("dumbbell", 0.1, 1.0, [0.5, 0.5])
    };
    let mut scene = scene(vec![dumbbell]);
    scene.bumper = vec![bumper(0.05, [0.2, 0.5]), bumper(0.05, [0.8, 0.5])];
    let mut simulation = simulate::<S>(&scene, options);
    let mut bounces = Encounters::since(EpochTime::ZERO);
    for _ in 0..100 {
        for _ in 0..100 {
            assert!(simulation.step(1e9, &mut bounces).unwrap());
        }
        let motion = simulation.view().bodies().next().unwrap().motion;
        assert_eq!(
            (motion.angular_velocity, motion.orientation.turns()),
            (0.0, 0.0)
        );
        assert_eq!(
            (
                motion.velocity.x.abs(),
                motion.velocity.y,
                motion.position.y
            ),
            (0.3, 0.0, 0.5)
        );
    }
    for (n, bounce) in bounces.list.iter().enumerate() {
        let (bumper, atom) = if n % 2 == 0 { (2, 1) } else { (1, 0) };
        assert_eq!(
            (bounce.bodies, bounce.atoms),
            ([0, bumper], [Some(atom), Some(0)])
        );
        // The first gap is 0.05 on each side, the later ones 0.1.
        let expected = (0.05 + 0.1 * n as f64) / 0.3;
        assert!(
            (bounce.time / expected - 1.0).abs() < 1e-14,
            "bounce {n}: {} for {expected}",
            bounce.time
        );
    }
}

fn check_billiard<S: Scheduler>(options: &S::Options) {
    // Sinai (1970): one disc and one scatterer on the torus.
    let mut scene = scene(vec![disc(0.05, 1.0, [0.1, 0.2], [0.6, 0.8])]);
    scene.bumper = vec![bumper(0.3, [0.5, 0.5])];
    let mut simulation = simulate::<S>(&scene, options);
    simulation.run_until(45_000.0).unwrap();
    let view = simulation.view();
    // Mean free path (L² − π R²)/(2 R) with R the sum of the radii (Santaló 1976).
    let free_path = (1.0 - std::f64::consts::PI * 0.35 * 0.35) / 0.7;
    let hits = view.counters().collisions as f64;
    assert!(
        hits > 4e4 && (hits * free_path / 45_000.0 - 1.0).abs() < 0.02,
        "{hits} hits"
    );
    // Roundings of one sign at each hit would give 1e-11; a random walk of them gives 5e-14.
    let drift = velocity(&view, 0).length_squared() - 1.0;
    assert!(drift.abs() < 1e-12, "{drift:e}");
    assert_eq!(view.overlaps().pairs, 0);
}

fn check_masses<S: Scheduler>(options: &S::Options) {
    for ratio in [1e8, 1e-8] {
        let mut scene = Scene {
            gas: vec![crate::support::gas("disc", 0.03, 40)],
            ..Scene::default()
        };
        scene.molecule = vec![named("tee", 0.02, ratio, [0.5, 0.5])];
        let mut simulation = simulate::<S>(&scene, options);
        simulation.run_until(20.0).unwrap();
        let view = simulation.view();
        assert!(view.counters().collisions > 3000);
        assert!((view.energy() / view.ledger().initial - 1.0).abs() < 1e-11);
        assert_eq!(view.overlaps().pairs, 0);
    }
}
