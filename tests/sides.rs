//! Gases of bodies with straight sides: they conserve momentum and energy, never overlap by more
//! than rounding, and follow the same path with each scheduler, in tiles, and after a resumption.

use carom::{Scene, Simulation};
use carom_engine::Tiling;
use carom_geometry::{Interior, Molecule};
use glam::DVec2;

use crate::support::{bits, check_heap_against_cells, check_portable_and_resumed};

/// Bodies of all families among discs, between two walls, in a box of sides 1 and 0.9.
fn mixed(elasticity: f64) -> Scene {
    let text = format!(
        r#"
        [box]
        sides = [1.0, 0.9]
        seed = 5
        [start]
        placement = "grown"
        relax = 1.0
        [[molecule]]
        tags = ["ring"]
        atoms = [
            {{ at = [0.0, 0.0], radius = 0.004, mass = 1.0 }},
            {{ at = [0.3, 0.0], radius = 0.004, mass = 1.0 }},
            {{ at = [0.3, 0.3], radius = 0.004, mass = 1.0 }},
            {{ at = [0.0, 0.3], radius = 0.004, mass = 1.0 }},
        ]
        edges = [[0, 1], [1, 2], [2, 3], [3, 0]]
        hollow = true
        at = [0.5, 0.45]
        [[wall]]
        x = 0.0
        [[wall]]
        from = [0.05, 0.2]
        to = [0.25, 0.1]
        [[gas]]
        radius = 0.01
        mass = 0.5
        temperature = 1.0
        count = 20
        [[gas]]
        shape = "square"
        size = 0.04
        mass = 1.0
        temperature = 1.0
        count = 25
        [[gas]]
        shape = "capsule:3"
        size = 0.02
        mass = 1.0
        temperature = 1.0
        count = 20
        [[gas]]
        polygon = [[0.0, 0.0], [0.05, 0.0], [0.05, 0.015], [0.015, 0.015], [0.015, 0.05], [0.0, 0.05]]
        density = 1000.0
        temperature = 1.0
        count = 15
        [[gas]]
        atoms = [
            {{ at = [0.0, 0.0], radius = 0.01, mass = 1.0 }},
            {{ at = [0.05, 0.0], radius = 0.006, mass = 1.0 }},
        ]
        edges = [[0, 1]]
        edge_radius = 0.002
        temperature = 1.0
        count = 10
        [elasticity]
        default = {elasticity}
        "#
    );
    Scene::from_toml(&text).unwrap()
}

#[test]
fn bodies_of_all_families_never_overlap_by_more_than_rounding() {
    for elasticity in [1.0, 0.9, 0.0] {
        let scene = mixed(elasticity);
        let mut simulation = Simulation::new(&scene).unwrap();
        let start = simulation.view().energy();
        let until = if elasticity == 0.0 { 0.5 } else { 2.0 };
        for step in 1..=20 {
            simulation
                .run_until(until * f64::from(step) / 20.0)
                .unwrap();
            let overlaps = simulation.view().overlaps();
            let deepest = overlaps.deepest_length / f64::EPSILON;
            assert!(
                deepest < 64.0 && overlaps.pairs == 0,
                "{elasticity}: {overlaps:?}"
            );
        }
        let counters = simulation.view().counters();
        assert!(counters.collisions > 1500, "{elasticity}: {counters:?}");
        if elasticity == 1.0 {
            let energy = simulation.view().energy();
            assert!((energy / start - 1.0).abs() < 1e-12, "{energy} of {start}");
        }
    }
}

#[test]
fn portable_code_and_a_resumed_run_agree_to_the_bit() {
    check_portable_and_resumed(&mixed(0.95));
}

#[test]
fn the_heap_finds_the_same_contacts_as_the_cells() {
    check_heap_against_cells(&mixed(1.0));
}

#[test]
fn a_gas_of_squares_in_tiles_is_that_in_order_to_the_bit() {
    let scene = Scene::from_toml(
        r#"
        [[gas]]
        shape = "square"
        size = 0.004
        mass = 1.0
        temperature = 1.0
        velocities = "maxwell"
        area_fraction = 0.2
        "#,
    )
    .unwrap();
    let mut in_order = Simulation::new(&scene).unwrap();
    in_order.set_tiling(&Tiling::NONE);
    let mut tiled = Simulation::new(&scene).unwrap();
    tiled.set_tiling(&Tiling {
        least_molecules: 100,
        ..Tiling::with_threads(2)
    });
    for simulation in [&mut in_order, &mut tiled] {
        simulation.run_until(0.01).unwrap();
    }
    assert!(in_order.view().counters().collisions > 5000);
    assert_eq!(bits(&tiled.view()), bits(&in_order.view()));
}

/// Velocities along the flight and spins of two equal unit squares that have met flat, with this
/// impact parameter (length); the first flies at 1, the second at -1/2 against it.
fn after_flat_contact(aside: f64) -> [[f64; 2]; 2] {
    let scene = Scene::from_toml(&format!(
        r#"
        [box]
        sides = [10.0, 10.0]
        [[molecule]]
        shape = "square"
        size = 1.0
        mass = 1.0
        at = [3.0, 5.0]
        velocity = [1.0, 0.0]
        [[molecule]]
        shape = "square"
        size = 1.0
        mass = 1.0
        at = [6.0, {}]
        velocity = [-0.5, 0.0]
        "#,
        5.0 + aside
    ))
    .unwrap();
    let mut simulation = Simulation::new(&scene).unwrap();
    // The faces are 2 - 2e-6 apart.
    simulation.run_until(2.0 / 1.5 - 1e-5).unwrap();
    assert_eq!(simulation.view().counters().collisions, 0);
    simulation.run_until(2.0).unwrap();
    assert_eq!(simulation.view().counters().joint_collisions, 1);
    let motions: Vec<_> = simulation.view().bodies().map(|body| body.motion).collect();
    [0, 1].map(|index| [motions[index].velocity.x, motions[index].angular_velocity])
}

#[test]
fn squares_that_meet_flat_and_centrally_exchange_their_velocities_without_spin() {
    let [[first, spin], [second, other_spin]] = after_flat_contact(0.0);
    assert!((first + 0.5).abs() < 1e-13 && (second - 1.0).abs() < 1e-13);
    assert!(
        spin.abs().max(other_spin.abs()) < 1e-13,
        "{spin} {other_spin}"
    );
}

/// At an impact parameter of 1/4 the faces share the part from -1/4 to 1/2 of the first. Each of
/// its ends separates as fast as it has closed, 3/2: two impulses of 24/35 do that, in the limit
/// of sharp corners, with moments of inertia of 1/6.
#[test]
fn squares_that_meet_flat_beside_their_centres_turn_alike() {
    let [[first, spin], [second, other_spin]] = after_flat_contact(0.25);
    for (found, expected) in [
        (first, 1.0 - 48.0 / 35.0),
        (second, -0.5 + 48.0 / 35.0),
        (spin, 36.0 / 35.0),
        (other_spin, 36.0 / 35.0),
    ] {
        assert!((found - expected).abs() < 1e-5, "{found} for {expected}");
    }
}

/// Two unit squares, one flat on a wall and at rest, the other above it and shifted by `aside`,
/// after the upper one has fallen flat on it at a speed of 1.
fn stacked(elasticity: f64, aside: f64, until: f64) -> Simulation {
    let half = 0.5 + 1e-6;
    let scene = Scene::from_toml(&format!(
        r#"
        [box]
        sides = [10.0, 10.0]
        [elasticity]
        default = {elasticity}
        contact_time = 0.0
        [[wall]]
        y = 2.0
        [[molecule]]
        shape = "square"
        size = 1.0
        mass = 1.0
        at = [5.0, {}]
        [[molecule]]
        shape = "square"
        size = 1.0
        mass = 1.0
        at = [{}, {}]
        velocity = [0.0, -1.0]
        "#,
        2.0 + half,
        5.0 + aside,
        3.0 + 3.0 * half,
    ))
    .unwrap();
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.run_until(until).unwrap();
    assert_eq!(simulation.view().overlaps().pairs, 0);
    simulation
}

/// The blow passes through the lower square to the wall and back, as through balls in a row.
#[test]
fn a_blow_passes_through_a_square_that_lies_on_a_wall() {
    let simulation = stacked(1.0, 0.0, 3.0);
    let motions: Vec<_> = simulation.view().bodies().map(|body| body.motion).collect();
    let [lower, upper] = [motions[0], motions[1]];
    assert!(lower.velocity.length() < 1e-13, "{motions:?}");
    assert!((upper.velocity - DVec2::Y).length() < 1e-13, "{motions:?}");
    assert!(
        lower
            .angular_velocity
            .abs()
            .max(upper.angular_velocity.abs())
            < 1e-13
    );
    // Beside its middle the blow turns the lower one, which returns it to the upper one.
    let simulation = stacked(1.0, 0.25, 3.0);
    assert!((simulation.view().energy() - 0.5).abs() < 1e-13);
}

/// At an elasticity of 0 the two squares keep one velocity at each blow, the wall takes that of the
/// lower one, and so on without end: all energy is lost, and neither turns nor sinks.
#[test]
fn two_squares_that_fall_flat_stay_stacked() {
    let simulation = stacked(0.0, 0.0, 1e6);
    let view = simulation.view();
    assert!(view.energy() < 1e-30, "{:e}", view.energy());
    assert!(view.counters().joint_collisions > 100);
    for body in view.bodies().take(2) {
        let spin = body.motion.angular_velocity.abs();
        assert!(spin < 1e-25, "{spin:e}");
    }
    let deepest = view.overlaps().deepest_length / f64::EPSILON;
    assert!(deepest < 64.0 * 10.0, "{deepest} roundings of a side of 10");
}

/// A square that falls flat on a narrower wall rests on the two ends of it and returns unturned.
#[test]
fn a_square_returns_flat_from_a_wall_narrower_than_its_side() {
    let scene = Scene::from_toml(
        r#"
        [box]
        sides = [10.0, 10.0]
        [[wall]]
        from = [4.5, 5.0]
        to = [5.5, 5.0]
        [[molecule]]
        shape = "square"
        size = 3.0
        mass = 1.0
        at = [5.0, 7.0]
        velocity = [0.0, -1.0]
        "#,
    )
    .unwrap();
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.run_until(1.0).unwrap();
    let motion = simulation.view().bodies().next().unwrap().motion;
    assert_eq!(simulation.view().counters().joint_collisions, 1);
    assert!((motion.velocity - DVec2::Y).length() < 1e-13, "{motion:?}");
    assert!(motion.angular_velocity.abs() < 1e-13, "{motion:?}");
}

/// A dense start of squares, triangles and hexagons, grown, covers what the scene asks for.
#[test]
fn sides_are_grown_to_dense_starts_without_overlap() {
    for (shape, fraction) in [
        ("square", 0.7),
        ("triangle", 0.6),
        ("polygon:6", 0.7),
        ("capsule:4", 0.6),
    ] {
        let scene = Scene::from_toml(&format!(
            "[[gas]]\nshape = \"{shape}\"\nsize = 1.0\nmass = 1.0\ntemperature = 1.0\ncount = 60\n\
             area_fraction = {fraction}\n[start]\nplacement = \"grown\"\nrelax = 20\n"
        ))
        .unwrap();
        let simulation = Simulation::new(&scene).unwrap();
        let view = simulation.view();
        assert_eq!(view.overlaps().pairs, 0, "{shape}");
        let area: f64 = view.bodies().map(|body| body.body.molecule().area()).sum();
        assert!(
            (area / view.bounds().sides().element_product() - fraction).abs() < 1e-9,
            "{shape}"
        );
    }
}

/// One rule of overlap for all bodies: crossed bars and a body inside a filled ring overlap, one
/// inside a hollow ring does not.
#[test]
fn a_scene_with_crossed_or_swallowed_bodies_is_refused() {
    let refused = |rest: &str| {
        let bar =
            "[[molecule]]\nshape = \"rectangle:8\"\nsize = 0.02\nmass = 1.0\nat = [0.5, 0.5]\n";
        let scene = Scene::from_toml(&format!("{bar}{rest}")).unwrap();
        Simulation::new(&scene).map(drop).unwrap_err().to_string()
    };
    let crossed = refused(
        "[[molecule]]\nshape = \"rectangle:8\"\nsize = 0.02\nmass = 1.0\nat = [0.5, 0.5]\norientation_turns = 0.25\n",
    );
    assert!(crossed.contains("overlap"), "{crossed}");
    let inside = refused(
        "[[molecule]]\nshape = \"disc\"\natom_radius = 0.001\natom_mass = 1.0\nat = [0.5, 0.5]\n",
    );
    assert!(inside.contains("overlap"), "{inside}");
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(DVec2::from);
    let filled = Molecule::polygon(&corners, 1e-3, 1.0).unwrap();
    let edges: Vec<_> = (0..4)
        .map(|index| ([index, (index + 1) % 4], 1e-3))
        .collect();
    let hollow =
        Molecule::with_edges(filled.atoms().iter().copied(), &edges, Interior::Hollow).unwrap();
    let disc = Molecule::disc(0.5, 1.0).unwrap();
    let gap = |ring| carom_geometry::gap_between(ring, DVec2::X, &disc, DVec2::X, DVec2::ZERO);
    assert!((gap(&hollow) - 0.499).abs() < 1e-12 && gap(&filled) < -1.0);
}
