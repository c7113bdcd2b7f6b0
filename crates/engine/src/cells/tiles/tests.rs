//! Tiles give the bits of the global order, for any division of the box, any window, any margin and
//! any number of threads.

mod frequent_stops;
mod other_bodies;

use glam::DVec2;

use crate::{
    run::{observer::Observer, simulation::Simulation},
    scene::{
        MoleculeSpec, Scene,
        atom_spec::AtomSpec,
        distribution::Quantity,
        elasticity_spec::{ElasticityRule, ElasticitySpec, Restitution},
        error::RunError,
        gas_spec::GasSpec,
    },
    tiling::{TileCounters, Tiling},
    world::{
        counters::{Counters, Ledger},
        report::CollisionReport,
    },
};

/// The radius of the discs of a gas.
fn radius_of(gas: &GasSpec) -> f64 {
    gas.radius.as_ref().and_then(Quantity::number).unwrap()
}

/// A gas of discs of mass 1 and energy 1 at this area fraction.
fn gas(count: usize, area_fraction: f64, seed: u64) -> Scene {
    let radius = (area_fraction / (std::f64::consts::PI * count as f64)).sqrt();
    let gas = GasSpec {
        radius: Some(radius.into()),
        mass: Some(1.0.into()),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    };
    let mut scene = Scene {
        gas: vec![gas],
        ..Scene::default()
    };
    scene.bounds.seed = seed;
    scene
}

/// The time in which a disc of such a gas has about this many contacts.
fn time_of(scene: &Scene, contacts: f64) -> f64 {
    let gas = &scene.gas[0];
    let (radius, count) = (radius_of(gas), gas.count.unwrap() as f64);
    let filled = count * std::f64::consts::PI * radius * radius;
    let contact_value = (1.0 - 7.0 / 16.0 * filled) / (1.0 - filled).powi(2);
    contacts / (4.0 * radius * count * contact_value * std::f64::consts::PI.sqrt())
}

/// What a run has computed.
#[derive(PartialEq)]
struct Computed {
    /// All motions and windings at some times, and the velocities after each reported contact.
    bits: Vec<u64>,
    counters: Counters,
    ledger: Ledger,
}

/// The velocities after each contact, as bits.
#[derive(Default)]
struct Contacts(Vec<u64>);

impl Observer for Contacts {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0.push(report.time.to_f64().to_bits());
        for vector in report
            .sides
            .each_ref()
            .map(|side| side.after.velocity)
            .into_iter()
            .chain([report.impulse])
        {
            self.0.extend(vector.to_array().map(f64::to_bits));
        }
        self.0.extend(
            report
                .sides
                .each_ref()
                .map(|side| side.after.angular_velocity.to_bits()),
        );
        self.0.extend(report.image.map(|boxes| boxes as u64));
    }
}

fn add_motions(simulation: &Simulation, bits: &mut Vec<u64>) {
    for body in simulation.view().bodies() {
        let vectors = [body.motion.position, body.motion.velocity];
        bits.extend(vectors.iter().flat_map(DVec2::to_array).map(f64::to_bits));
        bits.extend(
            [
                body.motion.orientation.turns(),
                body.motion.angular_velocity,
            ]
            .map(f64::to_bits),
        );
        bits.extend(body.winding.map(|boxes| boxes as u64));
    }
}

fn add_last_contacts(simulation: &Simulation, bits: &mut Vec<u64>) {
    let view = simulation.view();
    bits.extend(view.world.last_contacts().iter().map(|time| time.to_bits()));
}

/// Runs a scene with a division to some times.
fn run(scene: &Scene, tiling: &Tiling, times: &[f64]) -> (Computed, TileCounters) {
    let mut simulation = Simulation::new(scene).unwrap();
    simulation.set_tiling(tiling);
    let mut bits = Vec::new();
    for &time in times {
        simulation.run_until(time).unwrap();
        add_motions(&simulation, &mut bits);
    }
    let (counters, ledger) = (*simulation.view().counters(), simulation.view().ledger());
    // Times of last contacts decide what the guard against inelastic collapse does next.
    add_last_contacts(&simulation, &mut bits);
    (
        Computed {
            bits,
            counters,
            ledger,
        },
        simulation.tile_counters(),
    )
}

/// Asserts that two runs agree.
fn assert_same(what: &str, expected: &Computed, found: &Computed, tiles: &TileCounters) {
    assert_eq!(found.counters, expected.counters, "{what}: {tiles:?}");
    assert_eq!(found.ledger, expected.ledger, "{what}: {tiles:?}");
    assert!(
        found.bits == expected.bits,
        "{what}: bits differ; {tiles:?}"
    );
}

/// Asserts that an observer sees the same contacts in the same order in tiles, and that the run
/// ends in the same state.
fn assert_same_reports(name: &str, scene: &Scene, until: f64) {
    let [expected, found] = [
        Tiling::NONE,
        Tiling {
            threads: 2,
            side: 25,
            ..SMALL
        },
    ]
    .map(|tiling| {
        let mut simulation = Simulation::new(scene).unwrap();
        simulation.set_tiling(&tiling);
        let mut contacts = Contacts::default();
        simulation.observe_until(until, &mut contacts).unwrap();
        add_motions(&simulation, &mut contacts.0);
        contacts.0.extend(
            simulation
                .view()
                .world
                .last_contacts()
                .iter()
                .map(|time| time.to_bits()),
        );
        assert_eq!(
            simulation.tile_counters().windows > 0,
            tiling != Tiling::NONE,
            "{name}"
        );
        (
            contacts.0,
            simulation.view().ledger(),
            *simulation.view().counters(),
        )
    });
    assert!(expected == found, "{name}: reports differ");
}

/// Small tiles, for small systems.
const SMALL: Tiling = Tiling {
    threads: 1,
    least_bodies: 1,
    least_molecules: 1,
    side: 40,
    window: 1.0,
    margin: 6,
    front: 3.0,
};

#[test]
fn tiles_give_the_bits_of_the_global_order() {
    for (count, area_fraction, window) in
        [(20_000, 0.5, 1.0), (20_000, 0.2, 2.0), (10_000, 0.65, 1.0)]
    {
        let scene = gas(count, area_fraction, 5);
        // Two epochs, each of which is cut at a contact.
        let times = [time_of(&scene, 70.0)];
        let (expected, _) = run(&scene, &Tiling::NONE, &times);
        let (found, tiles) = run(&scene, &Tiling { window, ..SMALL }, &times);
        assert_same(
            &format!("area fraction {area_fraction}"),
            &expected,
            &found,
            &tiles,
        );
        assert!(
            tiles.contacts * 10 > found.counters.collisions * 9,
            "{tiles:?}"
        );
        assert!(tiles.refused == 0 && tiles.cut > 0, "{tiles:?}");
    }
}

#[test]
fn threads_windows_sides_and_margins_change_no_bit() {
    let scene = gas(8000, 0.5, 3);
    let times = [3.0, 5.5, 5.6, 12.0].map(|contacts| time_of(&scene, contacts));
    let (expected, _) = run(&scene, &Tiling::NONE, &times);
    let mut repeated = 0;
    for threads in [1, 2, 3, 5] {
        for (side, window, margin, front) in [
            (30, 1.0, 6, 3.0),
            (20, 0.5, 1, 3.0),
            (25, 1.0, 1, 1.0),
            (40, 1.5, 2, 1.0),
            (25, 0.7, 3, 2.0),
        ] {
            let tiling = Tiling {
                threads,
                side,
                window,
                margin,
                front,
                ..SMALL
            };
            let (found, tiles) = run(&scene, &tiling, &times);
            assert_same(&format!("{tiling:?}"), &expected, &found, &tiles);
            assert!(tiles.windows > 0);
            repeated += tiles.repeated;
        }
    }
    // Margins too small on purpose: disagreements are seen, and mended.
    assert!(repeated > 100, "{repeated}");
}

/// Gases whose contacts lose or gain energy: name and scene.
fn inelastic_gases() -> Vec<(&'static str, Scene)> {
    let rules = |default, contact_time, pair: &[(&str, f64)]| ElasticitySpec {
        default,
        contact_time,
        pair: pair
            .iter()
            .map(|&(tag, coefficient)| ElasticityRule {
                between: vec![tag.to_owned()],
                coefficient: coefficient.into(),
                ..ElasticityRule::default()
            })
            .collect(),
        ..ElasticitySpec::default()
    };
    let with = |area_fraction, elasticity: ElasticitySpec| {
        let mut scene = gas(8000, area_fraction, 41);
        scene.gas[0].count = Some(4000);
        let mut second = scene.gas[0].clone();
        second.tags = vec!["second".to_owned()];
        scene.gas.push(second);
        Scene {
            elasticity,
            ..scene
        }
    };
    vec![
        ("guarded", with(0.4, rules(0.9, 1e-4, &[]))),
        ("guarded often", with(0.6, rules(0.9, 0.03, &[]))),
        ("not guarded", with(0.4, rules(0.8, 0.0, &[]))),
        (
            "of two kinds",
            with(0.5, rules(1.0, 1e-2, &[("second", 0.7)])),
        ),
        ("gaining energy", with(0.4, rules(1.004, 0.0, &[]))),
        (
            "rough",
            with(
                0.4,
                ElasticitySpec {
                    tangential: 0.5,
                    friction: Some(0.3),
                    ..rules(0.9, 1e-4, &[])
                },
            ),
        ),
        (
            "of which one is rough",
            with(
                0.5,
                ElasticitySpec {
                    pair: vec![ElasticityRule {
                        between: vec!["second".to_owned(), "second".to_owned()],
                        coefficient: Restitution::Power {
                            power: -0.2,
                            at: 0.5,
                        },
                        tangential: 0.9,
                        ..ElasticityRule::default()
                    }],
                    ..ElasticitySpec::default()
                },
            ),
        ),
    ]
}

#[test]
fn inelastic_gases_keep_their_bits_and_their_ledger() {
    for (name, scene) in inelastic_gases() {
        let times = [2.0, 2.5, 6.0, 12.0].map(|contacts| time_of(&scene, 2.0 * contacts));
        let (expected, _) = run(&scene, &Tiling::NONE, &times);
        assert!(expected.ledger.lost != 0.0, "{name}");
        assert!(
            !name.starts_with("guarded") || expected.counters.guarded_collisions > 0,
            "{name}"
        );
        for (threads, margin, window) in [(1, 6, 1.0), (2, 3, 0.7), (3, 1, 1.5)] {
            let tiling = Tiling {
                threads,
                side: 25,
                margin,
                window,
                ..SMALL
            };
            let (found, tiles) = run(&scene, &tiling, &times);
            assert_same(name, &expected, &found, &tiles);
            assert!(
                margin < 6 || tiles.contacts * 2 > found.counters.collisions,
                "{name}: {tiles:?}"
            );
            assert!(tiles.windows > 0, "{name}: {tiles:?}");
        }
    }
}

#[test]
fn contacts_are_reported_in_order_with_the_same_bits() {
    for (name, scene) in inelastic_gases()
        .into_iter()
        .chain([("elastic", gas(8000, 0.4, 9))])
    {
        assert_same_reports(name, &scene, time_of(&scene, 30.0));
    }
}

#[test]
fn a_gas_that_heats_up_without_end_stops_with_the_same_error() {
    let mut scene = gas(3000, 0.4, 42);
    scene.elasticity = ElasticitySpec {
        default: 2.0,
        contact_time: 0.0,
        ..ElasticitySpec::default()
    };
    let until = time_of(&scene, 1000.0);
    let [expected, found] = [
        Tiling::NONE,
        Tiling {
            threads: 2,
            side: 20,
            ..SMALL
        },
    ]
    .map(|tiling| {
        let mut simulation = Simulation::new(&scene).unwrap();
        simulation.set_tiling(&tiling);
        let error = simulation.run_until(until).unwrap_err();
        assert!(matches!(error, RunError::BlowUp { .. }), "{error}");
        assert_eq!(
            simulation.tile_counters().windows > 0,
            tiling != Tiling::NONE
        );
        let mut bits = Vec::new();
        add_motions(&simulation, &mut bits);
        (error.to_string(), bits, simulation.view().ledger())
    });
    assert!(expected == found, "{}, {}", expected.0, found.0);
}

#[test]
fn a_collapse_is_left_to_the_global_order() {
    // Without a guard, discs that lose most of their energy come to rest against each other, until
    // rounding alone separates their surfaces and the run ends with an error.
    let mut scene = gas(3000, 0.4, 6);
    scene.elasticity = ElasticitySpec {
        default: 0.4,
        contact_time: 0.0,
        ..ElasticitySpec::default()
    };
    let until = time_of(&scene, 1e5);
    let [expected, found] = [Tiling::NONE, Tiling { side: 20, ..SMALL }].map(|tiling| {
        let mut simulation = Simulation::new(&scene).unwrap();
        simulation.set_tiling(&tiling);
        let ended = simulation
            .run_until(until)
            .map_err(|error| error.to_string());
        let tiles = simulation.tile_counters();
        assert!(
            tiling == Tiling::NONE || tiles.windows > 0 && tiles.refused > 0,
            "{tiles:?}"
        );
        let mut bits = Vec::new();
        add_motions(&simulation, &mut bits);
        (ended, bits, simulation.view().ledger())
    });
    assert!(expected == found, "{:?}, {:?}", expected.0, found.0);
    assert!(expected.0.is_err());
}

#[test]
fn hostile_scenes_keep_their_bits() {
    // A projectile of thirty times the speed of the gas, one that is hit by it later, and half the
    // box hot.
    let mut projectile = gas(8000, 0.5, 11);
    let radius = radius_of(&projectile.gas[0]);
    let disc = MoleculeSpec {
        atoms: vec![AtomSpec {
            at: [0.0; 2],
            radius,
            mass: 1.0,
        }],
        at: [0.5, 0.5],
        velocity: [30.0, 17.0],
        ..MoleculeSpec::default()
    };
    projectile.molecule.push(disc.clone());
    let mut late = gas(8000, 0.3, 12);
    let heavy = AtomSpec {
        at: [0.0; 2],
        radius: radius_of(&late.gas[0]),
        mass: 1e6,
    };
    late.molecule.push(MoleculeSpec {
        atoms: vec![heavy],
        velocity: [8.0, 3.0],
        ..disc
    });
    let mut hot = gas(8000, 0.5, 13);
    hot.gas[0].count = Some(4000);
    let mut second = hot.gas[0].clone();
    second.energy = 25.0;
    hot.gas.push(second);
    let jammed = gas(8000, 0.7, 14);
    for (name, scene) in [
        ("projectile", projectile),
        ("heavy", late),
        ("hot", hot),
        ("dense", jammed),
    ] {
        let times = [2.0, 9.0, 40.0].map(|contacts| time_of(&scene, contacts));
        let (expected, _) = run(&scene, &Tiling::NONE, &times);
        let (found, tiles) = run(
            &scene,
            &Tiling {
                threads: 2,
                side: 25,
                margin: 4,
                ..SMALL
            },
            &times,
        );
        assert_same(name, &expected, &found, &tiles);
        assert!(tiles.windows > 0, "{name}");
    }
}

#[test]
fn a_mixture_keeps_its_bits() {
    let mut scene = gas(4000, 0.25, 21);
    let mut smaller = scene.gas[0].clone();
    smaller.radius = Some((0.7 * radius_of(&scene.gas[0])).into());
    smaller.mass = Some(0.3.into());
    scene.gas.push(smaller);
    let times = [4.0, 30.0].map(|contacts| time_of(&scene, contacts));
    let (expected, _) = run(&scene, &Tiling::NONE, &times);
    let (found, tiles) = run(
        &scene,
        &Tiling {
            threads: 2,
            side: 25,
            ..SMALL
        },
        &times,
    );
    assert_same("mixture", &expected, &found, &tiles);
    assert!(tiles.contacts > 0);
}

#[test]
fn runs_in_pieces_and_single_steps_change_no_bit() {
    let scene = gas(8000, 0.5, 31);
    let unit = time_of(&scene, 1.0);
    let (expected, _) = run(&scene, &Tiling::NONE, &[40.0 * unit]);
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.set_tiling(&Tiling {
        threads: 2,
        side: 25,
        ..SMALL
    });
    let mut time = 0.0;
    for (number, piece) in [0.01, 3.0, 0.02, 0.01, 7.0, 0.1, 0.1, 0.1, 0.1, 0.1, 9.0]
        .into_iter()
        .enumerate()
    {
        time += piece * unit;
        simulation.run_until(time).unwrap();
        for _ in 0..number % 3 {
            simulation.step(1e9, &mut ()).unwrap();
            time = time.max(simulation.time().to_f64());
        }
    }
    simulation.run_until(40.0 * unit).unwrap();
    assert!(
        simulation.tile_counters().windows > 3,
        "{:?}",
        simulation.tile_counters()
    );
    let mut bits = Vec::new();
    add_motions(&simulation, &mut bits);
    assert!(bits == expected.bits, "bits differ");
    assert_eq!(*simulation.view().counters(), expected.counters);
}

#[test]
fn tiles_that_are_too_large_for_the_box_are_not_used() {
    let scene = gas(1000, 0.5, 1);
    let until = time_of(&scene, 5.0);
    let (_, tiles) = run(
        &scene,
        &Tiling {
            least_bodies: 1,
            ..Tiling::default()
        },
        &[until],
    );
    assert_eq!(tiles, TileCounters::default());
}

#[test]
fn any_division_is_accepted() {
    let scene = gas(2000, 0.5, 2);
    let times = [0.0, 2.0, 2.0].map(|contacts| time_of(&scene, contacts));
    let (expected, _) = run(&scene, &Tiling::NONE, &times);
    for number in [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        0.0,
        1e-300,
        1e300,
    ] {
        for whole in [0, 1, 9, u32::MAX] {
            let tiling = Tiling {
                threads: whole as usize % 7,
                least_bodies: 0,
                least_molecules: 0,
                side: whole,
                window: number,
                margin: whole,
                front: number,
            };
            let (found, tiles) = run(&scene, &tiling, &times);
            assert_same(&format!("{tiling:?}"), &expected, &found, &tiles);
        }
    }
}

#[test]
fn a_gas_at_rest_and_a_single_moving_disc_keep_their_bits() {
    let mut scene = gas(3000, 0.3, 6);
    scene.gas[0].energy = 0.0;
    let radius = radius_of(&scene.gas[0]);
    for velocity in [[0.0, 0.0], [1.0, 0.3]] {
        let disc = AtomSpec {
            at: [0.0; 2],
            radius,
            mass: 1.0,
        };
        scene.molecule = vec![MoleculeSpec {
            atoms: vec![disc],
            at: [0.3; 2],
            velocity,
            ..MoleculeSpec::default()
        }];
        let (expected, _) = run(&scene, &Tiling::NONE, &[0.01, 0.3]);
        let (found, tiles) = run(&scene, &Tiling { side: 20, ..SMALL }, &[0.01, 0.3]);
        assert_same(&format!("{velocity:?}"), &expected, &found, &tiles);
    }
}

/// A unit of length in which numbers are dyadic, and the radius of discs in it.
const UNIT: f64 = 1.0 / 4096.0;
const RADIUS: f64 = 23.0 * UNIT;

/// Discs of [`RADIUS`] at rest.
fn at_rest() -> Scene {
    let mut scene = gas(3000, 0.3, 6);
    (scene.gas[0].radius, scene.gas[0].energy) = (Some(RADIUS.into()), 0.0);
    scene
}

/// A disc of [`RADIUS`] that moves along x, `x` units right of the middle of the box.
fn disc(x: f64, y: f64, speed: f64) -> MoleculeSpec {
    MoleculeSpec {
        atoms: vec![AtomSpec {
            at: [0.0; 2],
            radius: RADIUS,
            mass: 1.0,
        }],
        at: [0.5 + x * UNIT, y],
        velocity: [speed, 0.0],
        ..MoleculeSpec::default()
    }
}

#[test]
fn two_contacts_of_a_disc_at_one_instant_in_two_tiles_are_left_to_the_global_order() {
    // The middle disc is in the tile right of the border at column 38 of 77, the left one in
    // another tile. All numbers are dyadic, so both contacts are at the same time to the bit.
    for outer_first in [true, false] {
        let mut three = vec![
            disc(-60.0, 0.25, 1.0),
            disc(0.0, 0.25, 0.0),
            disc(60.0, 0.25, -1.0),
        ];
        if !outer_first {
            three.swap(0, 1);
        }
        let scene = Scene {
            molecule: three,
            ..at_rest()
        };
        let tiling = Tiling { side: 20, ..SMALL };
        let (expected, _) = run(&scene, &Tiling::NONE, &[0.2]);
        let (found, tiles) = run(&scene, &tiling, &[0.2]);
        assert_same("three in a row", &expected, &found, &tiles);
        assert_eq!((tiles.windows, tiles.refused), (0, 1), "{tiles:?}");
    }
}
