//! Stops that are closer than a window: the window is run ahead, and no bit changes.

use super::{
    Computed, Contacts, SMALL, add_last_contacts, add_motions, assert_same, at_rest, disc, gas,
    inelastic_gases, other_bodies, time_of,
};
use crate::{
    edit::draw_key::DrawKey,
    run::simulation::Simulation,
    scene::{
        Scene,
        elasticity_spec::ElasticitySpec,
        kick_momentum::KickMomentum,
        thermostat_rule::{LangevinStep, SelfPropulsion, ThermostatRule},
    },
    tiling::{TileCounters, Tiling},
    world::counters::SchedulerCounters,
};

/// Runs a scene to `stops` equally spaced times; `between` is called before each.
fn run(
    scene: &Scene,
    tiling: &Tiling,
    until: f64,
    stops: u32,
    mut between: impl FnMut(u32, &mut Simulation, &mut Contacts),
) -> (Computed, TileCounters) {
    let mut simulation = Simulation::new(scene).unwrap();
    simulation.set_tiling(tiling);
    let (mut bits, mut reports) = (Vec::new(), Contacts::default());
    for stop in 1..=stops {
        let time = until * f64::from(stop) / f64::from(stops);
        between(stop, &mut simulation, &mut reports);
        if time > simulation.time().to_f64() {
            simulation.run_until(time).unwrap();
        }
        add_motions(&simulation, &mut bits);
        bits.push(simulation.view().counters().collisions);
        add_last_contacts(&simulation, &mut bits);
    }
    bits.append(&mut reports.0);
    // This has no contact, and needs the scheduler at the present: all counters are then complete.
    simulation
        .step(simulation.time().to_f64(), &mut ())
        .unwrap();
    let (counters, ledger) = (*simulation.view().counters(), simulation.view().ledger());
    (
        Computed {
            bits,
            counters,
            ledger,
        },
        simulation.tile_counters(),
    )
}

/// The result without the counters of the scheduler, which omit a window that an edit has ended.
fn without_work(computed: (Computed, TileCounters)) -> (Computed, TileCounters) {
    let (mut computed, tiles) = computed;
    computed.counters.scheduler = SchedulerCounters::default();
    (computed, tiles)
}

fn nothing(_: u32, _: &mut Simulation, _: &mut Contacts) {}

/// Scenes of all kinds, with a time.
fn scenes() -> Vec<(&'static str, Scene, f64)> {
    let discs = gas(8000, 0.4, 51);
    let until = time_of(&discs, 12.0);
    let mut scenes = vec![("discs", discs, until)];
    scenes.extend(inelastic_gases().into_iter().map(|(name, scene)| {
        let until = time_of(&scene, 5.0);
        (name, scene, until)
    }));
    let others = other_bodies::scenes();
    scenes.extend(others.into_iter().map(|(name, scene, until)| {
        // Few molecules have few contacts.
        let share = if name == "dumbbells among fixed bodies" {
            1.0
        } else {
            0.4
        };
        (name, scene, share * until)
    }));
    scenes
}

#[test]
fn frequent_stops_change_no_bit_and_cut_no_window() {
    for (name, scene, until) in scenes() {
        let (expected, _) = run(&scene, &Tiling::NONE, until, 60, nothing);
        for (threads, margin, front) in [(1, 6, 4.0), (2, 2, 1.0)] {
            let tiling = Tiling {
                threads,
                side: 25,
                margin,
                front,
                ..SMALL
            };
            let (found, tiles) = run(&scene, &tiling, until, 60, nothing);
            assert_same(&format!("{name}, {tiling:?}"), &expected, &found, &tiles);
            let in_tiles = tiles.contacts as f64 / found.counters.collisions as f64;
            assert!(tiles.windows > 0 && tiles.windows < 40, "{name}: {tiles:?}");
            assert!(
                front < 4.0 || in_tiles > 0.75,
                "{name}: {in_tiles}, {tiles:?}"
            );
        }
    }
}

#[test]
fn contacts_between_frequent_stops_are_reported_in_order() {
    for (name, scene, until) in scenes() {
        let observe = |stop: u32, simulation: &mut Simulation, reports: &mut Contacts| {
            simulation
                .observe_until(until * f64::from(stop) / 50.0, reports)
                .unwrap();
        };
        let (expected, _) = run(&scene, &Tiling::NONE, until, 50, observe);
        let (found, tiles) = run(
            &scene,
            &Tiling {
                threads: 2,
                side: 25,
                ..SMALL
            },
            until,
            50,
            observe,
        );
        assert_same(name, &expected, &found, &tiles);
        assert!(tiles.windows > 0 && tiles.windows < 40, "{name}: {tiles:?}");
        assert!(
            tiles.contacts * 4 > found.counters.collisions * 3,
            "{name}: {tiles:?}"
        );
    }
}

#[test]
fn a_window_that_is_given_up_changes_no_bit() {
    for (name, scene, until) in scenes() {
        // Single steps and an observer for one stretch only.
        let disturb = |stop: u32, simulation: &mut Simulation, reports: &mut Contacts| match stop {
            7 | 23 => {
                simulation.step(1e9, &mut ()).unwrap();
            }
            13 | 31 | 32 => {
                let time = until * f64::from(stop) / 60.0;
                simulation.observe_until(time, reports).unwrap();
            }
            41 => *simulation = simulation.clone(),
            _ => {}
        };
        let (expected, _) = run(&scene, &Tiling::NONE, until, 60, disturb);
        let (found, tiles) = run(
            &scene,
            &Tiling {
                threads: 2,
                side: 25,
                ..SMALL
            },
            until,
            60,
            disturb,
        );
        assert_same(name, &expected, &found, &tiles);
        assert!(tiles.windows > 0 && tiles.given_up > 0, "{name}: {tiles:?}");
    }
}

#[test]
fn edits_within_a_window_change_no_bit() {
    let mut given_up = Vec::new();
    for (name, scene, until) in scenes() {
        let elasticity = |default: f64, contact_time: f64| ElasticitySpec {
            default,
            contact_time,
            ..ElasticitySpec::default()
        };
        // Elasticities do not end an epoch; the others do.
        let edit = |stop: u32, simulation: &mut Simulation, _: &mut Contacts| match stop {
            6 => simulation.set_elasticity(&elasticity(0.9, 0.0)).unwrap(),
            13 => simulation.set_elasticity(&elasticity(0.6, 0.0)).unwrap(),
            19 | 49 => simulation.set_elasticity(&elasticity(0.8, 1e-3)).unwrap(),
            27 => simulation.reset_energy_of_all(1.0).unwrap(),
            // Discs get spins, and keep them when their contacts are smooth again.
            31 => simulation
                .set_elasticity(&ElasticitySpec {
                    tangential: 0.5,
                    ..elasticity(0.9, 0.0)
                })
                .unwrap(),
            37 | 55 => simulation.set_elasticity(&elasticity(1.0, 0.0)).unwrap(),
            43 => simulation.reverse(),
            46 => drop(simulation.end_epoch_here()),
            58 => {
                let key = simulation.view().bodies().next().unwrap().body.key();
                simulation.tag(key, "first").unwrap();
            }
            _ => {}
        };
        let (expected, _) = without_work(run(&scene, &Tiling::NONE, until, 60, edit));
        let tiling = Tiling {
            threads: 2,
            side: 25,
            ..SMALL
        };
        let (found, tiles) = without_work(run(&scene, &tiling, until, 60, edit));
        assert_same(name, &expected, &found, &tiles);
        assert!(
            expected.ledger.lost != 0.0 && tiles.given_up > 0,
            "{name}: {tiles:?}"
        );
        given_up.push(tiles.given_up);
    }
    // Most edits are within a window.
    assert!(
        given_up.iter().sum::<u64>() > 2 * given_up.len() as u64,
        "{given_up:?}"
    );
}

#[test]
fn epochs_that_begin_between_frequent_stops_change_no_bit() {
    for (name, scene, until) in scenes() {
        let begin = |stop: u32, simulation: &mut Simulation, _: &mut Contacts| match stop {
            1 => simulation.set_contacts_per_epoch(3),
            20 | 21 | 33 => drop(simulation.end_epoch_here()),
            22 | 36 | 50 => {
                simulation.step(1e9, &mut ()).unwrap();
            }
            _ => {}
        };
        let (expected, _) = without_work(run(&scene, &Tiling::NONE, until, 60, begin));
        let tiling = Tiling {
            threads: 2,
            side: 25,
            ..SMALL
        };
        let (found, tiles) = without_work(run(&scene, &tiling, until, 60, begin));
        assert_same(name, &expected, &found, &tiles);
        assert!(
            expected.counters.epochs > 3 && tiles.windows > 0,
            "{name}: {tiles:?}"
        );
    }
}

#[test]
fn edits_at_each_stop_end_the_running_ahead() {
    let scene = gas(8000, 0.4, 52);
    let until = time_of(&scene, 20.0);
    let edit = |_: u32, simulation: &mut Simulation, _: &mut Contacts| {
        simulation.reset_energy_of_all(1.0).unwrap();
    };
    let (expected, _) = without_work(run(&scene, &Tiling::NONE, until, 100, edit));
    let (found, tiles) = without_work(run(&scene, &Tiling { side: 25, ..SMALL }, until, 100, edit));
    assert_same("edits", &expected, &found, &tiles);
    assert_eq!(tiles.given_up, 0, "{tiles:?}");
}

#[test]
fn rules_that_set_velocities_at_each_stop_change_no_bit() {
    let mut scene = gas(8000, 0.4, 53);
    scene.gas[0].tags = vec!["all".to_owned()];
    let until = time_of(&scene, 20.0);
    let every = until / 100.0;
    let rules = [
        ThermostatRule::Active(SelfPropulsion {
            speed: 1.0,
            rotational_diffusion: 1.0,
            translational_diffusion: 0.01,
            every,
        }),
        ThermostatRule::Langevin(LangevinStep {
            friction: 10.0,
            temperature: 1.0,
            every,
        }),
        ThermostatRule::Rotate,
        ThermostatRule::Kick(KickMomentum::Magnitude(0.1)),
    ];
    let edit = |stop: u32, simulation: &mut Simulation, _: &mut Contacts| {
        let all = simulation.find_tag("all").unwrap();
        let rule = rules[stop as usize / 25 % rules.len()];
        let key = DrawKey {
            seed: 1,
            replica: 0,
            action: u64::from(stop),
        };
        simulation
            .edit(|batch| batch.thermostat(all, &rule, key))
            .unwrap();
    };
    let (expected, _) = without_work(run(&scene, &Tiling::NONE, until, 100, edit));
    let (found, tiles) = without_work(run(&scene, &Tiling { side: 25, ..SMALL }, until, 100, edit));
    assert_same("rules", &expected, &found, &tiles);
}

#[test]
fn two_last_contacts_at_one_instant_before_a_stop_are_left_to_the_global_order() {
    // Two pairs far from each other, which touch at 8/4096. All numbers are dyadic, so both
    // contacts are at the same time to the bit.
    let pairs = [0.25, 0.75]
        .into_iter()
        .flat_map(|y| [disc(-31.0, y, 1.0), disc(31.0, y, -1.0)]);
    let scene = Scene {
        molecule: pairs.collect(),
        ..at_rest()
    };
    let (expected, _) = run(&scene, &Tiling::NONE, 0.01, 30, nothing);
    let (found, tiles) = run(&scene, &Tiling { side: 20, ..SMALL }, 0.01, 30, nothing);
    assert_same("two pairs", &expected, &found, &tiles);
    assert!(expected.counters.collisions >= 2, "{:?}", expected.counters);
    assert_eq!(tiles.refused, 1, "{tiles:?}");
}
