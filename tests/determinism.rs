//! Guarantees to the bit: a run does not depend on observers, views, pieces of time, the unit of
//! time, or the order of bodies.

use crate::support::{
    Encounters, bits, bumper, frozen, gas, reference_scene, scenes, simulate,
    test_each_instruction_set, test_each_scheduler,
};
use carom_detection::Exact;
use carom_engine::{
    CellScheduler, CellsPerSide, HeapScheduler, Instructions, Observer, Rotation, Scene, Scheduler,
    Simulation, View, WallSpec,
};
use carom_kinematics::{EpochTime, Motion, Orientation};
use carom_response::Impact;
use glam::DVec2;
use rand::{RngExt, SeedableRng, seq::SliceRandom};
use rand_pcg::Pcg64;

/// Long enough for about thirty collisions of each body, after which a difference in the last bit
/// has grown to the first.
const UNTIL: f64 = 3.0;

test_each_scheduler! {
    views_and_runs_in_pieces_change_no_bit: check_pieces;
    velocities_times_a_power_of_two_give_the_same_paths: check_scaling;
    the_order_of_bodies_does_not_change_their_motions: check_permutation;
    velocities_times_a_power_of_two_give_the_same_paths_between_walls_and_at_any_restitution: check_scaling_between_walls;
    exchanging_x_and_y_exchanges_the_motions_of_bodies_that_do_not_turn: check_exchange;
}

test_each_instruction_set! {
    views_during_a_run_change_no_bit_in_any_kind_of_scene: check_looking;
    the_trajectory_is_pinned: check_pinned;
    a_scene_file_has_the_bits_that_the_command_and_python_have: check_three_ways;
}

fn check_pieces<S: Scheduler>(options: &S::Options) {
    let scene = reference_scene(1);
    let mut whole = simulate::<S>(&scene, options);
    whole.run_until(UNTIL).unwrap();
    let expected = bits(&whole.view());
    let collisions = whole.view().counters().collisions;
    assert!(
        collisions > 30 * whole.view().len() as u64 / 2,
        "{collisions}"
    );

    let mut random = Pcg64::seed_from_u64(7);
    let mut pieces = simulate::<S>(&scene, options);
    let mut time = 0.0;
    while time < UNTIL {
        pieces.run_until(time).unwrap();
        let view = pieces.view();
        assert_eq!(view.overlaps().pairs, 0);
        assert!((view.energy() - view.ledger().booked()).abs() < 1e-12 * view.energy());
        time += 0.01 * random.random::<f64>();
    }
    pieces.run_until(UNTIL).unwrap();
    assert_eq!(bits(&pieces.view()), expected);
    assert_eq!(pieces.view().counters(), whole.view().counters());

    // With a stop and a view at each contact and a little later.
    let mut steps = simulate::<S>(&scene, options);
    let mut watched = Encounters::since(EpochTime::ZERO);
    while steps.step(UNTIL, &mut watched).unwrap() {
        let now = steps.time().to_f64();
        steps.run_until((now + 1e-9).min(UNTIL)).unwrap();
        assert_eq!(steps.view().bodies().len(), expected.len());
    }
    assert_eq!(bits(&steps.view()), expected);

    // With an observer: one report for each collision.
    let mut watched = simulate::<S>(&scene, options);
    let mut seen = (Encounters::since(EpochTime::ZERO), Silent);
    watched.observe_until(UNTIL, &mut seen).unwrap();
    assert_eq!(bits(&watched.view()), expected);
    assert_eq!(seen.0.list.len() as u64, collisions);
}

/// An observer that wants no reports.
struct Silent;

impl Observer for Silent {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }
}

fn check_scaling<S: Scheduler>(options: &S::Options) {
    for scene in [reference_scene(2), dilute(2)] {
        let mut base = frozen(&simulate::<S>(&scene, options).view());
        base.elasticity.default = 0.95;
        check_scaling_of::<S>(&base, options, &[-60, -31, -1, 1, 30, 61]);
    }
}

/// A gas so dilute that discs store contacts later than their next crossing.
fn dilute(seed: u64) -> Scene {
    let mut scene = Scene {
        gas: vec![gas("disc", 0.008, 120)],
        ..Scene::default()
    };
    scene.bounds.seed = seed;
    scene
}

/// Runs a scene of single bodies, and again with velocities times powers of two; returns the first
/// run.
fn check_scaling_of<S: Scheduler>(
    base: &Scene,
    options: &S::Options,
    exponents: &[i32],
) -> Simulation<Exact, Impact, S> {
    let run = |factor: f64| {
        let mut scaled = base.clone();
        for molecule in &mut scaled.molecule {
            molecule.velocity = molecule.velocity.map(|v| v * factor);
            molecule.angular_velocity *= factor;
        }
        let mut simulation = simulate::<S>(&scaled, options);
        simulation.run_until(UNTIL / factor).unwrap();
        simulation
    };
    let one = run(1.0);
    for &exponent in exponents {
        let factor = 2f64.powi(exponent);
        let scaled = run(factor);
        let case = format!("e = {}, 2^{exponent}", base.elasticity.default);
        assert_eq!(scaled.view().counters(), one.view().counters(), "{case}");
        for (found, expected) in scaled.view().bodies().zip(one.view().bodies()) {
            let (found, expected) = (found.motion, expected.motion);
            assert_eq!(found.position, expected.position, "{case}");
            assert_eq!(found.orientation, expected.orientation, "{case}");
            assert_eq!(found.velocity, expected.velocity * factor, "{case}");
            assert_eq!(
                found.angular_velocity,
                expected.angular_velocity * factor,
                "{case}"
            );
        }
    }
    one
}

fn check_permutation<S: Scheduler>(options: &S::Options) {
    let molecules = vec![gas("dumbbell", 0.02, 60), gas("disc", 0.02, 20)];
    // A gas so dilute that discs store contacts later than their next crossing; discs of two sizes,
    // one too large for a cell.
    let dilute = vec![gas("disc", 0.008, 120)];
    let unlike = vec![gas("disc", 0.015, 60), gas("disc", 0.1, 3)];
    // Long molecules among discs; each molecule covers several cells.
    let rods = vec![gas("rod:8", 0.008, 20), gas("disc", 0.02, 100)];
    let gases = [molecules, dilute, unlike, rods].map(|gas| Scene {
        gas,
        ..Scene::default()
    });
    for start in [reference_scene(3)].into_iter().chain(gases) {
        check_permutation_of::<S>(&start, options);
    }
}

fn check_permutation_of<S: Scheduler>(start: &Scene, options: &S::Options) {
    let base = frozen(&simulate::<S>(start, options).view());
    let mut straight = simulate::<S>(&base, options);
    straight.run_until(UNTIL).unwrap();
    let expected = bits(&straight.view());
    let mut random = Pcg64::seed_from_u64(11);
    for _ in 0..4 {
        let mut order: Vec<usize> = (0..expected.len()).collect();
        order.shuffle(&mut random);
        let permuted = Scene {
            molecule: order
                .iter()
                .map(|&index| base.molecule[index].clone())
                .collect(),
            ..base.clone()
        };
        let mut simulation = simulate::<S>(&permuted, options);
        simulation.run_until(UNTIL).unwrap();
        for (place, motion) in bits(&simulation.view()).into_iter().enumerate() {
            assert_eq!(motion, expected[order[place]], "body {}", order[place]);
        }
    }
}

/// Bodies between walls at e < 1, where the guard against inelastic collapse measures times.
fn check_scaling_between_walls<S: Scheduler>(options: &S::Options) {
    for (e, contact_time) in [(0.5, 1e-4), (0.0, 1e-2), (0.95, 0.0)] {
        let mut base = walled::<S>(options, Rotation::Free);
        base.elasticity.default = e;
        base.elasticity.contact_time = contact_time;
        let one = check_scaling_of::<S>(&base, options, &[-50, -1, 31]);
        assert!(one.view().counters().fixed_collisions > 20);
        assert_eq!(
            one.view().counters().guarded_collisions > 0,
            contact_time > 1e-3,
            "e = {e}"
        );
    }
}

/// Discs and dumbbells in a closed box with fixed discs, as single molecules.
fn walled<S: Scheduler>(options: &S::Options, rotation: Rotation) -> Scene {
    let line = |x: Option<f64>, y: Option<f64>| WallSpec {
        x,
        y,
        ..WallSpec::default()
    };
    let mut scene = Scene {
        wall: vec![line(Some(0.0), None), line(None, Some(0.25))],
        bumper: vec![bumper(0.05, [0.4, 0.75])],
        gas: vec![
            gas("disc", 0.02, 50),
            gas("disc", 0.03, 10),
            gas("dumbbell", 0.02, 10),
        ],
        ..Scene::default()
    };
    scene.gas[2].rotation = rotation;
    scene.bounds.seed = 8;
    let mut base = frozen(&simulate::<S>(&scene, options).view());
    base.molecule.retain(|molecule| !molecule.atoms.is_empty());
    assert_eq!(base.molecule.len(), 71, "all but the walls");
    base.wall = scene.wall;
    base
}

fn check_exchange<S: Scheduler>(options: &S::Options) {
    let mut straight = walled::<S>(options, Rotation::Locked);
    straight.bounds.sides = [1.0, 1.0];
    for molecule in &mut straight.molecule {
        // Turned atoms instead of an orientation, which would have to be mirrored.
        let turn =
            Orientation::from_turns(molecule.orientation_turns.take().unwrap_or(0.0)).cos_sin();
        for atom in &mut molecule.atoms {
            atom.at = turn.rotate(DVec2::from(atom.at)).to_array();
        }
    }
    let swap = |[x, y]: [f64; 2]| [y, x];
    let mut mirrored = straight.clone();
    for molecule in &mut mirrored.molecule {
        molecule
            .atoms
            .iter_mut()
            .for_each(|atom| atom.at = swap(atom.at));
        (molecule.at, molecule.velocity) = (swap(molecule.at), swap(molecule.velocity));
    }
    for wall in &mut mirrored.wall {
        (wall.x, wall.y) = (wall.y, wall.x);
    }
    for e in [1.0, 0.9] {
        let run = |scene: &Scene| {
            let mut scene = scene.clone();
            scene.elasticity.default = e;
            let mut simulation = simulate::<S>(&scene, options);
            simulation.run_until(UNTIL).unwrap();
            simulation
        };
        let (one, other) = (run(&straight), run(&mirrored));
        assert!(one.view().counters().collisions > 700);
        assert_eq!(
            one.view().counters().collisions,
            other.view().counters().collisions
        );
        for (place, (a, b)) in one.view().bodies().zip(other.view().bodies()).enumerate() {
            assert_eq!(
                a.motion.position.to_array(),
                swap(b.motion.position.to_array()),
                "e = {e}, body {place}"
            );
            assert_eq!(
                a.motion.velocity.to_array(),
                swap(b.motion.velocity.to_array()),
                "e = {e}, body {place}"
            );
        }
    }
}

mod vector_instructions_give_the_bits_of_the_portable_path {
    crate::support::test_of_instructions!(cells_avx512, Widest, |&set| {
        super::check_against_portable(set);
    });
    crate::support::test_of_instructions!(cells_avx2, Avx2, |&set| super::check_against_portable(
        set
    ));
}

fn check_against_portable(instructions: Instructions) {
    let many = Scene {
        gas: vec![gas("disc", 0.015, 400)],
        ..Scene::default()
    };
    for (name, scene) in scenes().into_iter().chain([
        ("reference_scene", reference_scene(4)),
        ("many discs", many),
    ]) {
        let [found, portable] = [instructions, Instructions::Portable].map(|instructions| {
            let mut simulation = simulate::<CellScheduler>(&scene, &instructions);
            simulation.run_until(UNTIL).unwrap();
            bits(&simulation.view())
        });
        assert_eq!(found, portable, "{name}");
    }
}

fn check_looking(instructions: Instructions) {
    for (name, scene) in scenes() {
        let [straight, stopping] = [1, 97].map(|stops| {
            let mut simulation = simulate::<CellScheduler>(&scene, &instructions);
            let mut seen = Encounters::since(EpochTime::ZERO);
            for stop in 1..=stops {
                let until = 1.5 * f64::from(stop) / f64::from(stops);
                simulation.observe_until(until, &mut seen).unwrap();
                assert!(simulation.view().energy() > 0.0);
            }
            bits(&simulation.view())
        });
        assert_eq!(straight, stopping, "{name}");
    }
}

#[test]
fn the_seed_and_the_replica_determine_the_run() {
    let run = |seed, replica| {
        let mut scene = reference_scene(seed);
        scene.bounds.replica = replica;
        let mut simulation = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
        simulation.run_until(0.5).unwrap();
        bits(&simulation.view())
    };
    let first = run(5, 0);
    assert_eq!(first, run(5, 0));
    assert_ne!(first, run(6, 0));
    assert_ne!(first, run(5, 1));
}

fn fingerprint(view: &View<'_>) -> u64 {
    fnv(bits(view).as_flattened().iter().copied())
}

/// FNV-1a, 64 bits (Fowler, Noll, Vo 1991).
fn fnv(words: impl Iterator<Item = u64>) -> u64 {
    words
        .flat_map(u64::to_le_bytes)
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
}

fn fingerprint_after<S: Scheduler>(scene: &Scene, collisions: u64, options: &S::Options) -> u64 {
    let mut simulation = simulate::<S>(scene, options);
    for _ in 0..collisions {
        assert!(simulation.step(1e9, &mut ()).unwrap());
    }
    fingerprint(&simulation.view())
}

/// Every bit of every motion after 3000 collisions of a fixed scene, and of a dilute gas.
///
/// These may change the bits: the generator of random numbers and its use (placement, velocities),
/// the order of operations in prediction or response, the rule by which epochs end, another
/// scheduler. These may not: the processor, the level of optimisation, observers, output. If a
/// change of the second kind fails here, it is an error. After a change of the first kind, run
/// these tests and copy the numbers that they print.
fn check_pinned(instructions: Instructions) {
    let found = [
        fingerprint_after::<CellScheduler>(&reference_scene(42), 3000, &instructions),
        fingerprint_after::<CellScheduler>(&dilute(42), 3000, &instructions),
    ];
    assert_eq!(found, PINNED[1..], "found {found:#018x?}");
}

#[test]
fn the_trajectory_of_the_thesis_scheduler_is_pinned() {
    let found =
        fingerprint_after::<HeapScheduler>(&reference_scene(42), 3000, &CellsPerSide::Automatic);
    assert_eq!(found, PINNED[0], "found {found:#018x?}");
}

/// Fingerprints with `HeapScheduler` and with `CellScheduler`; the third is the dilute gas with the
/// latter.
const PINNED: [u64; 3] = [
    0xc57d_9500_1952_43ae,
    0xe7ed_c253_211b_6309,
    0x43cf_21bd_d020_406b,
];

/// The scene file is that of a test of the Python package, which runs it by the command too and has
/// angles in radians. A change of these bits changes `PINNED` as well.
fn check_three_ways(instructions: Instructions) {
    let scene = Scene::from_toml(include_str!("data/three_ways.toml")).unwrap();
    let mut simulation = simulate::<CellScheduler>(&scene, &instructions);
    simulation.run_until(scene.run.until).unwrap();
    let numbers = |motion: Motion| {
        let (position, velocity) = (motion.position, motion.velocity);
        let (angle, angular_velocity) = (motion.orientation.radians(), motion.angular_velocity);
        [
            position.x,
            position.y,
            velocity.x,
            velocity.y,
            angle,
            angular_velocity,
        ]
        .map(f64::to_bits)
    };
    let found = fnv(simulation
        .view()
        .bodies()
        .flat_map(|body| numbers(body.motion)));
    let pinned = include_str!("data/three_ways.fingerprint").trim();
    assert_eq!(format!("{found:#018x}"), pinned);
}
