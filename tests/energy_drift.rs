//! The energy of contacts: elastic runs along an axis drift as a random walk, and contacts at
//! elasticity below 1 separate no faster than they should, or are refused.

use crate::support::{bumper, disc, scene, simulate, test_each_scheduler, velocity};
use carom_detection::Exact;
use carom_engine::{
    AtomSpec, GridError, MoleculeSpec, Rotation, RunError, Scene, SceneError, Scheduler,
    Simulation, StallCause, WallSpec,
};
use carom_response::Impact;

test_each_scheduler! {
    unequal_masses_and_a_wall_on_an_axis_keep_the_energy: check_line_with_wall;
    masses_in_powers_of_100_collide_as_often_as_the_digits_of_pi: check_pi;
    a_stalled_run_names_its_cause_and_the_remedy: check_words;
    small_atoms_keep_their_coefficient_or_are_refused: check_small_atoms;
}

/// The largest drift that a random walk of rounding errors explains, ten standard deviations.
fn allowed(contacts: u64) -> f64 {
    16.0 * f64::EPSILON * (contacts as f64).sqrt()
}

fn check_line_with_wall<S: Scheduler>(options: &S::Options) {
    for masses in [[1.0, 3.0], [1.0, 7.0], [60.0, 2.0], [5.0, 7.0], [1.0, 1.0]] {
        for along_y in [false, true] {
            let turned = |[x, y]: [f64; 2]| if along_y { [y, x] } else { [x, y] };
            let mut line = scene(vec![
                disc(0.05, masses[0], turned([0.3, 0.5]), turned([1.0, 0.0])),
                disc(0.05, masses[1], turned([0.7, 0.5]), turned([-0.3, 0.0])),
            ]);
            line.wall = vec![if along_y {
                WallSpec {
                    y: Some(0.0),
                    ..WallSpec::default()
                }
            } else {
                WallSpec {
                    x: Some(0.0),
                    ..WallSpec::default()
                }
            }];
            let mut simulation = simulate::<S>(&line, options);
            simulation.run_until(30_000.0).unwrap();
            let view = simulation.view();
            let contacts = view.counters().collisions;
            let drift = (view.energy() / view.ledger().initial - 1.0).abs();
            assert!(contacts > 20_000, "{masses:?}: {contacts}");
            assert!(
                drift < allowed(contacts),
                "{masses:?}: {drift:e} after {contacts} contacts"
            );
        }
    }
}

fn check_pi<S: Scheduler>(options: &S::Options) {
    // Galperin, Playing pool with π (2003): a wall, a disc at rest, and one of mass 100ⁿ.
    for (mass, expected) in [(1.0, 3), (1e2, 31), (1e4, 314), (1e6, 3141), (1e8, 31_415)] {
        let mut pool = scene(vec![
            disc(0.05, 1.0, [0.3, 0.5], [0.0; 2]),
            disc(0.05, mass, [0.6, 0.5], [-1.0, 0.0]),
        ]);
        pool.bounds.sides = [4.0, 1.0];
        pool.wall = vec![WallSpec {
            x: Some(0.1),
            ..WallSpec::default()
        }];
        let mut simulation = simulate::<S>(&pool, options);
        simulation.run_until(2.0).unwrap();
        let view = simulation.view();
        assert_eq!(view.counters().collisions, expected, "mass {mass:e}");
        let drift = (view.energy() / view.ledger().initial - 1.0).abs();
        assert!(drift < allowed(expected), "mass {mass:e}: {drift:e}");
    }
}

fn check_words<S: Scheduler>(options: &S::Options) {
    let cause = |scene: &Scene| match simulate::<S>(scene, options).run_until(10.0) {
        Err(error @ RunError::Stalled { cause, .. }) => (cause, error.to_string()),
        ended => panic!("{ended:?}"),
    };
    // A light disc between a wall and a heavy disc that presses on it.
    let mut vice = scene(vec![
        disc(0.05, 1e-2, [0.3, 0.0], [0.0; 2]),
        disc(0.1, 1e2, [0.6, 0.0], [-1.0, 0.0]),
    ]);
    vice.wall = vec![WallSpec {
        x: Some(0.1),
        ..WallSpec::default()
    }];
    vice.elasticity.default = 0.05;
    vice.elasticity.contact_time = 0.0;
    let (found, words) = cause(&vice);
    assert_eq!(found, StallCause::InelasticCollapse);
    assert!(
        words.contains("inelastic collapse") && words.contains("elasticity.contact_time"),
        "{words}"
    );
    // An elastic disc in a wedge that it touches on both sides at one instant.
    let mut funnel = scene(vec![disc(0.0625, 1.0, [0.25, 0.5], [1.0, 0.0])]);
    let away = 0.125 + 0.0625 * (1.0 - 1e-9);
    funnel.bumper = vec![
        bumper(0.125, [0.625, 0.5 - away]),
        bumper(0.125, [0.625, 0.5 + away]),
    ];
    let (found, words) = cause(&funnel);
    assert_eq!(found, StallCause::NoFreeSpace);
    assert!(
        words.contains("no free space") && !words.contains("contact_time"),
        "{words}"
    );
}

fn check_small_atoms<S: Scheduler>(options: &S::Options) {
    for others in [0, 1] {
        for e in [0.0, 0.5, 0.9] {
            for radius in [
                1e-2, 1e-4, 1e-6, 1e-8, 1e-9, 1e-11, 1e-12, 2e-13, 1e-13, 5.1e-14,
            ] {
                let atom = |x| AtomSpec {
                    at: [x, 0.0],
                    radius,
                    mass: 1.0,
                };
                let mut head_on = scene(vec![MoleculeSpec {
                    atoms: vec![atom(-0.05), atom(0.05)],
                    at: [0.6, 0.5],
                    velocity: [-1.0, 0.0],
                    rotation: Rotation::Locked,
                    ..MoleculeSpec::default()
                }]);
                head_on
                    .molecule
                    .extend((0..others).map(|_| disc(0.01, 1.0, [0.5, 0.1], [0.0, 0.01])));
                head_on.bumper = vec![bumper(radius, [0.25, 0.5])];
                head_on.elasticity.default = e;
                let built = Simulation::<Exact, Impact, S>::with(
                    &head_on,
                    Exact::default(),
                    Impact,
                    options.clone(),
                );
                if radius < 2e-11 {
                    let Err(SceneError::Grid { reason, .. }) = built else {
                        panic!("{radius:e} is accepted")
                    };
                    let GridError::UnresolvedElasticity { reach, least, .. } = reason else {
                        panic!("{reason}")
                    };
                    assert!(
                        (reach / (2.0 * radius) - 1.0).abs() < 1e-12
                            && least > reach
                            && least < 1e-9
                    );
                    continue;
                }
                let mut simulation = built.unwrap();
                simulation.run_until(0.31).unwrap();
                assert_eq!(simulation.view().counters().collisions, 1);
                let parting = velocity(&simulation.view(), 0).x;
                // Up to 3e-4 at e = 0 for a radius of 1e-9.
                assert!(
                    (parting - e).abs() < 1e-3 && parting > 0.0,
                    "{radius:e}, e = {e}: {parting}"
                );
                assert!(
                    e == 0.0 || (parting - e).abs() < 1e-12,
                    "{radius:e}, e = {e}: {parting}"
                );
            }
        }
    }
}
