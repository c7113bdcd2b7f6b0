//! Bonds between bodies: conserved quantities, all events against brute force, chains, resuming,
//! and exact averages.

use carom_detection::Exact;
use carom_engine::{
    BondSpec, CellScheduler, CellsPerSide, DrawKey, HeapScheduler, Instructions, Scene, Scheduler,
    Simulation, TetherSpec, ThermostatRule, ThermostatTarget, View,
};
use carom_response::Impact;
use glam::DVec2;
use proptest::prelude::*;

use crate::support::{property::cases, simulate};

/// Chains of discs, with and without a shortest length, a ring and a star of discs, dumbbells
/// hinged at their ends, squares hinged at their corners, discs tied to bumpers, pairs on long
/// tethers, and locked discs tied at their rims.
const SCENES: [&str; 8] = [
    "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 60\n\
     chain = { members = 6, tether = { max = 0.06 } }",
    "[[gas]]\nradius = 0.015\nmass = 1.0\nenergy = 1.0\ncount = 40\n\
     chain = { members = 4, tether = { max = 0.2, min = 0.1 } }\n\
     [[gas]]\nradius = 0.03\nmass = 3.0\nenergy = 1.0\ncount = 20",
    "[[gas]]\nradius = 0.015\nmass = 1.0\nenergy = 1.0\ncount = 12\n\
     chain = { members = 12, ring = true, tether = { max = 0.05 } }\n\
     [[gas]]\nradius = 0.015\nmass = 1.0\nenergy = 1.0\ncount = 26\n\
     chain = { members = 13, arms = 3, tether = { max = 0.04 } }",
    "[[gas]]\nshape = \"dumbbell\"\natom_radius = 0.02\natom_mass = 1.0\nenergy = 1.0\ncount = 30\n\
     chain = { members = 3, tether = { max = 0.02, points = [[0.045, 0.0], [-0.045, 0.0]] } }",
    "[[gas]]\nshape = \"square\"\nsize = 0.06\nmass = 1.0\nenergy = 1.0\ncount = 20\n\
     chain = { members = 2, tether = { max = 0.03, points = [[0.03, 0.03], [-0.03, 0.03]] } }",
    "[[bond]]\npairs = [[0, 2]]\ntether = { max = 0.1, points = [[0.02, 0.0], [0.0, 0.0]] }\n\
     [[bond]]\npairs = [[1, 3]]\ntether = { max = 0.1 }\n\
     [[molecule]]\nshape = \"dumbbell\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.3, 0.3]\n\
     velocity = [1.0, 0.2]\n\
     [[molecule]]\natoms = [{ at = [0, 0], radius = 0.03, mass = 2.0 }]\nat = [0.7, 0.7]\n\
     [[bumper]]\nat = [0.3, 0.35]\nradius = 0.01\n\
     [[bumper]]\nat = [0.7, 0.75]\nradius = 0.01\n\
     [[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 30",
    "[[gas]]\nradius = 0.004\nmass = 1.0\nenergy = 1.0\ncount = 8\n\
     chain = { members = 2, tether = { max = 0.4 } }",
    "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 40\nrotation = \"locked\"\n\
     chain = { members = 2, tether = { max = 0.03, points = [[0.02, 0.0], [0.0, 0.02]] } }",
];

fn scene(number: usize, seed: u64) -> Scene {
    let text = format!("[box]\nseed = {seed}\n{}", SCENES[number]);
    Scene::from_toml(&text).unwrap()
}

fn angular_momentum(view: &View<'_>, about: DVec2) -> f64 {
    let of_body = |body: carom_engine::BodyView<'_>| {
        let inertia = body.body.inertia();
        let unwrapped = body.unwrapped(&view.bounds()) - about;
        unwrapped.perp_dot(body.motion.velocity) / inertia.inverse_mass
            + if inertia.inverse_moment > 0.0 {
                body.motion.angular_velocity / inertia.inverse_moment
            } else {
                0.0
            }
    };
    view.bodies().map(of_body).sum()
}

#[test]
fn two_tied_discs_keep_momentum_energy_and_angular_momentum() {
    let text = "[[bond]]\npairs = [[0, 1]]\ntether = { max = 0.3, min = 0.1, points = [[0.0, 0.03], [0.0, -0.02]] }\n\
        [[molecule]]\nshape = \"dumbbell\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.4, 0.5]\n\
        velocity = [0.7, 0.4]\nangular_velocity = 3.0\n\
        [[molecule]]\nshape = \"dumbbell\"\natom_radius = 0.02\natom_mass = 2.5\nat = [0.6, 0.5]\n\
        velocity = [-0.1, 0.9]\nangular_velocity = -7.0";
    let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    let before = (
        simulation.view().momentum(),
        simulation.view().energy(),
        angular_momentum(&simulation.view(), DVec2::ZERO),
    );
    simulation.run_until(50.0).unwrap();
    let view = simulation.view();
    assert!(view.counters().bond_collisions > 100);
    assert!((view.momentum() - before.0).length() < 1e-12);
    assert!((view.energy() / before.1 - 1.0).abs() < 1e-12);
    // The pair drifts away over many boxes; its angular momentum about the origin stays.
    let after = angular_momentum(&view, DVec2::ZERO);
    assert!((after - before.2).abs() < 1e-9, "{after} {}", before.2);
    let bond = view.bonds().next().unwrap();
    assert!(bond.bond.excess(bond.length) < 1e-13);
}

fn check<S: Scheduler + Clone>(options: &S::Options) {
    for number in 0..SCENES.len() {
        let scene = scene(number, 7);
        let mut simulation: Simulation<Exact, Impact, S> = simulate(&scene, options);
        let energy = simulation.view().energy();
        for step in 1..=30 {
            simulation.run_until(0.004 * f64::from(step)).unwrap();
            simulation
                .check_invariants(0.01)
                .unwrap_or_else(|violation| panic!("scene {number}, step {step}: {violation}"));
        }
        let view = simulation.view();
        assert!(view.counters().bond_collisions > 0, "scene {number}");
        assert!(
            (view.energy() / energy - 1.0).abs() < 1e-12,
            "scene {number}"
        );
    }
}

#[test]
fn no_event_is_missed_in_cells() {
    check::<CellScheduler>(&Instructions::default());
}

#[test]
fn no_event_is_missed_by_the_heap() {
    check::<HeapScheduler>(&CellsPerSide::Automatic);
}

/// Both schedulers have the same contacts until chaos has amplified their rounding.
#[test]
fn both_schedulers_have_the_same_events() {
    for number in 0..SCENES.len() {
        let scene = scene(number, 3);
        let mut cells = Simulation::<Exact, Impact, CellScheduler>::new(&scene).unwrap();
        let mut heap: Simulation<Exact, Impact, HeapScheduler> =
            simulate(&scene, &CellsPerSide::Automatic);
        cells.run_until(0.05).unwrap();
        heap.run_until(0.05).unwrap();
        let (cells, heap) = (cells.view(), heap.view());
        let counts = [cells, heap].map(|view| {
            let counters = view.counters();
            [counters.collisions, counters.bond_collisions]
        });
        assert_eq!(counts[0], counts[1], "scene {number}");
        for (one, other) in cells.bodies().zip(heap.bodies()) {
            let off = (one.motion.velocity - other.motion.velocity).length();
            assert!(off < 1e-6, "scene {number}: {off:e}");
        }
    }
}

#[test]
fn time_reversal_returns_to_the_start() {
    for number in 0..SCENES.len() {
        let mut simulation = Simulation::new(&scene(number, 11)).unwrap();
        let start: Vec<_> = simulation.view().bodies().map(|body| body.motion).collect();
        let until = [0.05, 0.05, 0.05, 0.05, 0.05, 0.1, 0.3, 0.05][number];
        simulation.run_until(until).unwrap();
        let events = simulation.view().counters().bond_collisions;
        assert!(events > 0, "scene {number}");
        simulation.reverse();
        simulation.run_until(2.0 * until).unwrap();
        let bounds = simulation.view().bounds();
        for (body, motion) in simulation.view().bodies().zip(&start) {
            let off = bounds.nearest_image(body.motion.position - motion.position);
            assert!(off.length() < 1e-7, "scene {number}: {off}");
        }
    }
}

#[test]
fn a_run_is_resumed_to_the_bit() {
    for number in 0..SCENES.len() {
        let mut simulation = Simulation::new(&scene(number, 5)).unwrap();
        simulation.run_until(0.1).unwrap();
        let checkpoint = simulation.end_epoch_here();
        let mut resumed = Simulation::resume(&checkpoint).unwrap();
        simulation.run_until(0.4).unwrap();
        resumed.run_until(0.4).unwrap();
        assert_eq!(simulation.view().counters(), resumed.view().counters());
        for (one, other) in simulation.view().bodies().zip(resumed.view().bodies()) {
            assert_eq!(one.motion, other.motion, "scene {number}");
        }
        assert_eq!(
            simulation.view().bonds().count(),
            resumed.view().bonds().count()
        );
    }
}

/// In equilibrium the distance of two points that do nothing but stay between their bounds is
/// uniform over the area between them: ⟨d²⟩ = (min² + max²)/2.
#[test]
fn the_squared_length_of_a_bond_is_uniform() {
    let text = "[box]\nsides = [1.0, 1.0]\n\
        [[gas]]\nradius = 1e-9\nmass = 1.0\ntemperature = 1.0\ncount = 2\n\
        tags = [\"pair\"]\nchain = { members = 2, tether = { max = 0.4, min = 0.2 } }";
    let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    let rule = ThermostatRule::Maxwell(ThermostatTarget::Temperature(1.0));
    let pair = simulation.find_tag("pair").unwrap();
    let (mut sum, mut below, samples) = (0.0, 0_u32, 40_000_u32);
    for number in 0..samples {
        simulation.run_until(0.5 * f64::from(number)).unwrap();
        let squared = simulation.view().bonds().next().unwrap().length.powi(2);
        sum += squared;
        below += u32::from(squared < 0.1);
        let key = DrawKey {
            seed: 1,
            replica: 0,
            action: number.into(),
        };
        simulation
            .edit(|batch| batch.thermostat(pair, &rule, key))
            .unwrap();
    }
    // Uniform between 0.04 and 0.16: the mean is 0.1, its deviation 0.12/√12 over √n.
    let mean = sum / f64::from(samples);
    assert!(
        (mean - 0.1).abs() < 4.0 * 0.12 / (12.0 * f64::from(samples)).sqrt(),
        "{mean}"
    );
    let share = f64::from(below) / f64::from(samples);
    assert!(
        (share - 0.5).abs() < 4.0 * 0.5 / f64::from(samples).sqrt(),
        "{share}"
    );
}

#[test]
fn bonds_are_added_cut_and_lost_with_their_bodies() {
    let text = "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 12\ntags = [\"chain\"]\n\
        chain = { members = 4, tether = { max = 0.06 } }";
    let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    assert_eq!(simulation.view().bonds().count(), 9);
    simulation.run_until(0.1).unwrap();
    let keys: Vec<_> = simulation
        .view()
        .bodies()
        .map(|body| body.body.key())
        .collect();
    // Its first chain loses its second member, and with it two bonds; keys stay.
    simulation.remove(keys[1]).unwrap();
    assert_eq!(simulation.view().bonds().count(), 7);
    assert!(
        simulation
            .view()
            .bonds()
            .all(|bond| !bond.bodies.contains(&keys[1]))
    );
    simulation.run_until(0.2).unwrap();
    assert!(simulation.view().overlaps().pairs == 0);
    // Tied once more at the distance that they have.
    let tie = |max: f64| BondSpec {
        pairs: vec![[keys[0].id(), keys[2].id()]],
        tether: TetherSpec {
            max,
            ..TetherSpec::default()
        },
    };
    let bounds = simulation.view().bounds();
    let [a, b] = [0, 2].map(|n| simulation.view().body(keys[n]).unwrap().motion.position);
    let apart = bounds.nearest_image(b - a).length();
    let error = simulation.bond(&tie(0.9 * apart)).unwrap_err().to_string();
    assert!(error.contains("beyond its bounds"), "{error}");
    assert_eq!(simulation.view().bonds().count(), 7);
    if apart < 0.45 {
        simulation.bond(&tie(1.05 * apart)).unwrap();
        assert_eq!(simulation.view().bonds().count(), 8);
        simulation.run_until(0.4).unwrap();
        assert!(simulation.view().overlaps().pairs == 0);
    }
    let tag = simulation.find_tag("chain").unwrap();
    simulation
        .edit(|batch| {
            batch.unbond_tag(tag);
            Ok(())
        })
        .unwrap();
    assert_eq!(simulation.view().bonds().count(), 0);
    simulation.run_until(0.5).unwrap();
}

/// A bond with elasticity 0 pulls its points along, and loses what they had along it.
#[test]
fn an_inelastic_bond_loses_the_speed_along_it() {
    let text = "[elasticity]\ncontact_time = 1e-4\n\
        [[bond]]\npairs = [[0, 1]]\ntether = { max = 0.3, elasticity = 0.0 }\n\
        [[molecule]]\natoms = [{ at = [0, 0], radius = 0.02, mass = 1.0 }]\nat = [0.4, 0.5]\n\
        [[molecule]]\natoms = [{ at = [0, 0], radius = 0.02, mass = 3.0 }]\nat = [0.5, 0.5]\n\
        velocity = [1.0, 0.0]";
    let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    simulation.run_until(0.25).unwrap();
    let view = simulation.view();
    assert_eq!(view.counters().bond_collisions, 1);
    // The guard lets the points part by 1e-4 of their speed, the contact time.
    for body in view.bodies() {
        assert!((body.motion.velocity - DVec2::new(0.75, 0.0)).length() < 1e-4);
    }
    // ½ (1 − e²) μ u² with μ = 3/4.
    assert!((view.ledger().lost - 0.375 * (1.0 - 1e-8)).abs() < 1e-12);
}

/// A point that has lost its speed along the tether goes round the other: its bounces would follow
/// each other ever faster.
#[test]
fn a_taut_inelastic_bond_does_not_collapse() {
    let text = "[elasticity]\ncontact_time = 1e-3\n\
        [[bond]]\npairs = [[0, 1]]\ntether = { max = 0.3, elasticity = 0.0 }\n\
        [[molecule]]\natoms = [{ at = [0, 0], radius = 0.02, mass = 1.0 }]\nat = [0.5, 0.5]\n\
        [[molecule]]\natoms = [{ at = [0, 0], radius = 0.02, mass = 1.0 }]\nat = [0.7, 0.5]\n\
        velocity = [0.5, 1.0]";
    let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    simulation.run_until(20.0).unwrap();
    let view = simulation.view();
    // Chords of about 2 c times the diameter of a disc at a relative speed of about 1.
    let events = view.counters().bond_collisions;
    assert!((1000..200_000).contains(&events), "{events}");
    assert_eq!(view.overlaps().pairs, 0);
}

/// A dense melt is grown, and its bonds hold.
#[test]
fn chains_grow_to_a_melt() {
    let text = "[box]\nseed = 3\n[elasticity]\ncontact_time = 1e-4\n\
        [[gas]]\nradius = 0.02\nmass = 1.0\ntemperature = 1.0\narea_fraction = 0.6\ncount = 480\n\
        chain = { members = 8, tether = { max = 0.056, elasticity = 0.99 } }";
    let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    let bonds = simulation.view().bonds().count();
    assert_eq!(bonds, 420);
    assert_eq!(simulation.view().overlaps().pairs, 0);
    simulation.run_until(0.2).unwrap();
    let view = simulation.view();
    assert_eq!(view.overlaps().pairs, 0);
    assert!(view.counters().bond_collisions > 1000);
}

/// A random walk traps itself, on average after 71 steps of the square lattice: members are taken
/// back.
#[test]
fn a_long_chain_is_placed() {
    let text = "[box]\nsides = [200.0, 200.0]\nseed = 4\n\
        [[gas]]\nradius = 0.5\nmass = 1.0\ntemperature = 1.0\ncount = 1000\n\
        chain = { members = 1000, tether = { max = 1.3 } }";
    let simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    assert_eq!(simulation.view().overlaps().pairs, 0);
    assert_eq!(simulation.view().bonds().count(), 999);
}

/// At distances of 1 to 2.5 contacts from the first more discs have room than touch at 2.5: 15.
#[test]
fn a_star_of_more_arms_than_fit_on_a_circle_is_placed() {
    let text = "[box]\nsides = [20.0, 20.0]\nseed = 4\n\
        [[gas]]\nradius = 0.5\nmass = 1.0\ntemperature = 1.0\ncount = 18\n\
        chain = { members = 18, arms = 17, tether = { max = 2.5 } }";
    let simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    assert_eq!(simulation.view().overlaps().pairs, 0);
    assert_eq!(simulation.view().bonds().count(), 17);
}

proptest! {
    #![proptest_config(cases(12))]

    /// Random lists of bonds between bodies of random shapes, with walls, drag or gravity.
    #[test]
    fn random_bonds_hold(
        seed in 0..1000_u64, max in 0.05..0.4f64, min in prop_oneof![Just(0.0), 0.2..0.9f64],
        points in prop::array::uniform4(-0.03..0.03f64), shape in 0..3_usize, beside in 0..4_usize,
    ) {
        let shape = [
            "radius = 0.02\nmass = 1.0",
            "shape = \"tee\"\natom_radius = 0.01\natom_mass = 1.0",
            "shape = \"triangle\"\nsize = 0.05\nmass = 1.0",
        ][shape];
        let beside = [
            "",
            "[[wall]]\nx = 0.0",
            "[[wall]]\ny = 0.0\n[gravity]\nacceleration = [0.0, -3.0]",
            "",
        ][beside];
        let drag = if beside.is_empty() && seed % 2 == 0 { 0.4 } else { 0.0 };
        let [ax, ay, bx, by] = points;
        let (points, least) = if shape.starts_with("radius") {
            (String::new(), min.max(0.0))
        } else {
            (format!(", points = [[{ax:?}, {ay:?}], [{bx:?}, {by:?}]]"), min)
        };
        let text = format!(
            "[box]\nseed = {seed}\ndrag = {drag:?}\n{beside}\n[[gas]]\n{shape}\nenergy = 1.0\ncount = 12\n\
             chain = {{ members = 3, tether = {{ max = {max:?}, min = {:?}{points} }} }}",
            least * max,
        );
        let Ok(mut simulation) = Simulation::new(&Scene::from_toml(&text).unwrap()) else {
            // Short tethers of large bodies leave no room.
            return Ok(());
        };
        for step in 1..=12 {
            simulation.run_until(0.01 * f64::from(step)).unwrap();
            let checked = simulation.check_invariants(0.02);
            prop_assert!(checked.is_ok(), "{text}\n{checked:?}");
        }
    }
}
