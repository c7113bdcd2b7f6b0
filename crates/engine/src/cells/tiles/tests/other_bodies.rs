//! Molecules, walls and fixed bodies in tiles.

use super::{Computed, SMALL, add_motions, assert_same, assert_same_reports, run};
use crate::{
    run::simulation::Simulation,
    scene::Scene,
    tiling::{TileCounters, TileUse, Tiling},
};

/// Scenes of all kinds of bodies that tiles can run, with a time in which each body has some
/// contacts.
#[expect(clippy::too_many_lines, reason = "one table of scenes")]
pub(super) fn scenes() -> Vec<(&'static str, Scene, f64)> {
    let mut scenes = Vec::new();
    let mut add = |name, until, toml: &str| {
        let scene = Scene::from_toml(toml).unwrap_or_else(|error| panic!("{name}: {error}"));
        scenes.push((name, scene, until));
    };
    let dumbbells = "
        [[gas]]
        shape = \"dumbbell\"
        atom_radius = 0.004
        atom_mass = 0.5
        energy = 1.0
        area_fraction = 0.3
    ";
    add("dumbbells", 0.08, dumbbells);
    add("locked", 0.08, &format!("{dumbbells}rotation = \"locked\""));
    add(
        "molecules of three kinds",
        0.08,
        "
        [[gas]]
        shape = \"tee\"
        atom_radius = 0.002
        atom_mass = 1.0
        energy = 2.0
        count = 1500
        [[gas]]
        shape = \"ring:5\"
        atom_radius = 0.002
        atom_mass = 0.2
        energy = 0.5
        count = 1500
        [[gas]]
        radius = 0.004
        mass = 0.1
        energy = 1.0
        count = 1000
        ",
    );
    let guarded = "
        [elasticity]
        default = 0.8
    ";
    add(
        "dumbbells that lose energy",
        0.2,
        &format!("{dumbbells}{guarded}"),
    );
    let discs = "
        [[gas]]
        radius = 0.004
        mass = 1.0
        energy = 1.0
        area_fraction = 0.3
    ";
    let walls = "
        [[wall]]
        x = 0.0
        [[wall]]
        y = 0.5
        [[wall]]
        from = [0.2, 0.1]
        to = [0.9, 0.45]
        radius = 0.002
        [[wall]]
        from = [0.9, 0.9]
        to = [1.2, 0.7]
    ";
    add("discs between walls", 0.1, &format!("{walls}{discs}"));
    add(
        "dumbbells between walls",
        0.1,
        &format!("{walls}{dumbbells}"),
    );
    add(
        "discs that lose energy between walls",
        0.2,
        &format!("{walls}{discs}{guarded}"),
    );
    let squeezing = "
        [[wall]]
        x = 0.2
        motion = { velocity = [0.5, 0.0] }
        [[wall]]
        x = 0.9
        motion = { velocity = [-0.5, 0.0] }
        [[wall]]
        from = [0.45, 0.1]
        to = [0.6, 0.1]
        radius = 0.002
        motion = { turn = 12.0 }
    ";
    let shaking = "
        [[wall]]
        y = 0.5
        motion = { amplitude = [0.0, 0.02], frequency = 40.0, phase = 0.3 }
        [[wall]]
        from = [0.2, 0.1]
        to = [0.3, 0.3]
        motion = { times = [0.0, 0.03, 0.06], places = [[0.0, 0.0], [0.02, 0.0], [0.0, 0.0]], repeat = true }
    ";
    add(
        "discs between walls that move",
        0.1,
        &format!("{squeezing}{discs}"),
    );
    add(
        "dumbbells between walls that move",
        0.1,
        &format!("{squeezing}{dumbbells}"),
    );
    add(
        "discs between walls that shake",
        0.1,
        &format!("{shaking}{discs}"),
    );
    add(
        "dumbbells that lose energy between walls that shake",
        0.1,
        &format!("{shaking}{dumbbells}{guarded}"),
    );
    let bumper = |place: usize| {
        let (column, row) = (place % 20, place / 20);
        // Radii from half that of the gas to two and a half times it.
        let radius = [0.002, 0.01, 0.005, 0.008][(column + 3 * row) % 4];
        let [x, y] = [column, row].map(|number| 0.05 * number as f64 + 0.013);
        format!("[[bumper]]\nat = [{x}, {y}]\nradius = {radius}\n")
    };
    let bed = "
        [gravity]
        acceleration = [0.5, -4.0]
        [[wall]]
        y = 0.01
        [[wall]]
        x = 0.99
    ";
    add("discs that fall on walls", 0.1, &format!("{bed}{discs}"));
    add(
        "dumbbells that fall on walls, and lose energy",
        0.1,
        &format!("{bed}{shaking}{dumbbells}{guarded}"),
    );
    let pair_rules = "
        [[transparent]]
        between = [\"small\"]
        [[diameter]]
        between = [\"small\", \"large\"]
        factor = 1.2
    ";
    let two_tags = "
        [[gas]]
        tags = [\"small\"]
        radius = 0.004
        mass = 0.5
        energy = 1.0
        count = 3000
        [[gas]]
        tags = [\"large\"]
        radius = 0.006
        mass = 1.0
        energy = 1.0
        count = 2500
    ";
    let sieve = "
        [[transparent]]
        between = [\"small\", \"sieve\"]
        [[wall]]
        x = 0.4
        tags = [\"sieve\"]
    ";
    add(
        "discs of two tags with rules for pairs",
        0.12,
        &format!("{pair_rules}{two_tags}"),
    );
    add(
        "discs with rules for pairs between walls that one tag passes",
        0.12,
        &format!("{pair_rules}{sieve}{walls}{two_tags}"),
    );
    let seeing_dumbbells = dumbbells.replace("[[gas]]", "[[gas]]\ntags = [\"small\"]");
    add(
        "dumbbells and discs that do not see each other",
        0.1,
        &format!(
            "{}{}{seeing_dumbbells}",
            "[[transparent]]\nbetween = [\"small\", \"large\"]\n",
            "[[gas]]\ntags = [\"large\"]\nradius = 0.004\nmass = 1.0\nenergy = 1.0\ncount = 1500\n"
        ),
    );
    let bumpers: String = (0..400).map(bumper).collect();
    let fixed = "
        [[molecule]]
        shape = \"tee\"
        atom_radius = 0.015
        atom_mass = 1.0
        at = [0.5, 0.99]
        orientation = 0.7
        fixed = true
    ";
    let thin = discs.replace("0.3", "0.12");
    add("discs among bumpers", 0.2, &format!("{bumpers}{thin}"));
    add(
        "discs around fixed bodies",
        0.1,
        &format!("{fixed}{walls}{discs}"),
    );
    add(
        "dumbbells among fixed bodies",
        0.1,
        &format!("{bumpers}{}", dumbbells.replace("0.3", "0.1")),
    );
    add(
        "discs that lose energy among bumpers",
        0.3,
        &format!("{bumpers}{thin}{guarded}"),
    );
    scenes
}

#[test]
fn molecules_walls_and_fixed_bodies_keep_their_bits() {
    for (name, scene, until) in scenes() {
        let times = [0.2, 0.21, 0.5].map(|share| share * until);
        let (expected, _) = run(&scene, &Tiling::NONE, &times);
        assert!(
            expected.counters.collisions > 2000,
            "{name}: {:?}",
            expected.counters
        );
        assert!(
            !name.contains("lose energy") || expected.ledger.lost > 0.0,
            "{name}"
        );
        let is_among_fixed =
            name.contains("walls") || name.contains("bumpers") || name.contains("fixed");
        assert_eq!(
            expected.counters.fixed_collisions > 50,
            is_among_fixed,
            "{name}"
        );
        for (threads, side, window, margin, front) in [
            (1, 25, 1.0, 6, 4.0),
            (2, 20, 0.5, 1, 3.0),
            (3, 25, 1.0, 2, 1.0),
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
            assert_same(&format!("{name}, {tiling:?}"), &expected, &found, &tiles);
            assert!(tiles.windows > 0, "{name}: {tiles:?}");
            let in_tiles = tiles.contacts as f64 / found.counters.collisions as f64;
            assert!(
                front < 4.0 || in_tiles > 0.9,
                "{name}: {in_tiles}, {tiles:?}"
            );
        }
    }
}

#[test]
fn their_contacts_are_reported_in_order_with_the_same_bits() {
    for (name, scene, until) in scenes() {
        assert_same_reports(name, &scene, until);
    }
}

#[test]
fn their_runs_in_pieces_and_single_steps_change_no_bit() {
    for (name, scene, until) in scenes()
        .into_iter()
        .filter(|(name, ..)| !name.contains("three kinds"))
    {
        let (expected, _) = run(&scene, &Tiling::NONE, &[until]);
        let mut simulation = Simulation::new(&scene).unwrap();
        simulation.set_tiling(&Tiling {
            threads: 2,
            side: 25,
            ..SMALL
        });
        let mut time = 0.0;
        for (number, share) in [0.001, 0.2, 0.002, 0.001, 0.4, 0.01, 0.01]
            .into_iter()
            .enumerate()
        {
            time += share * until;
            simulation.run_until(time).unwrap();
            for _ in 0..number % 3 {
                simulation.step(1e9, &mut ()).unwrap();
                time = time.max(simulation.time().to_f64());
            }
        }
        simulation.run_until(until).unwrap();
        let tiles = simulation.tile_counters();
        assert!(tiles.windows > 1, "{name}: {tiles:?}");
        let mut bits = Vec::new();
        add_motions(&simulation, &mut bits);
        bits.extend(
            simulation
                .view()
                .world
                .last_contacts()
                .iter()
                .map(|time| time.to_bits()),
        );
        let (counters, ledger) = (*simulation.view().counters(), simulation.view().ledger());
        assert_same(
            name,
            &expected,
            &Computed {
                bits,
                counters,
                ledger,
            },
            &tiles,
        );
    }
}

#[test]
fn two_bodies_that_touch_one_wall_at_the_same_instant_are_left_to_the_global_order() {
    // All numbers are dyadic; the two are in tiles of their own.
    let scene = Scene::from_toml(
        "
        [[wall]]
        y = 0.5
        [[molecule]]
        shape = \"disc\"
        atom_radius = 0.0078125
        atom_mass = 1.0
        at = [0.25, 0.4912109375]
        velocity = [0.0, 1.0]
        [[molecule]]
        shape = \"disc\"
        atom_radius = 0.0078125
        atom_mass = 1.0
        at = [0.75, 0.4912109375]
        velocity = [0.0, 1.0]
        [[gas]]
        radius = 0.0078125
        mass = 1.0
        energy = 0.0
        count = 1000
        region = { y = [0.55, 0.95] }
        ",
    )
    .unwrap();
    let (expected, _) = run(&scene, &Tiling::NONE, &[0.3]);
    assert_eq!(expected.counters.fixed_collisions, 2);
    let (found, tiles) = run(&scene, &Tiling { side: 20, ..SMALL }, &[0.3]);
    assert_same("two at a wall", &expected, &found, &tiles);
    assert_eq!((tiles.windows, tiles.refused), (0, 1), "{tiles:?}");
}

#[test]
fn a_partner_that_leaves_and_comes_back_has_changed_all_the_same() {
    // A disc is predicted to touch another of version 0, which then has one contact, is not among
    // its neighbours when a window begins, and is again when the next one does. A window that
    // forgot the version of the prediction took the pair for one in contact.
    let scene = Scene::from_toml(
        "
        [box]
        seed = 11
        [[wall]]
        x = 0.0
        [[wall]]
        y = 0.3
        [[wall]]
        from = [0.1, 0.5]
        to = [0.8, 0.9]
        [[gas]]
        radius = 0.004
        mass = 1.0
        energy = 1.0
        area_fraction = 0.3
        ",
    )
    .unwrap();
    let times = [18.0 * 0.0005];
    let (expected, _) = run(&scene, &Tiling::NONE, &times);
    let tiling = Tiling {
        side: 18,
        window: 0.7,
        margin: 3,
        front: 2.0,
        ..SMALL
    };
    let (found, tiles) = run(&scene, &tiling, &times);
    assert_same("a partner that comes back", &expected, &found, &tiles);
    assert!(tiles.windows > 1, "{tiles:?}");
}

#[test]
fn what_tiles_cannot_run_is_refused_by_name() {
    let gas =
        "[[gas]]\ntags = [\"a\"]\nradius = 0.004\nmass = 1.0\nenergy = 1.0\narea_fraction = 0.2\n";
    let large =
        "[[molecule]]\nshape = \"tee\"\natom_radius = 0.03\natom_mass = 1.0\nat = [0.5, 0.5]\n";
    let warm = "[[wall]]\nx = 0.0\ntemperature = 1.0\n";
    let sticky = "[[well]]\nbetween = [\"a\"]\nsteps = [[1.5, 1.0]]\n";
    let cases = [
        (large, TileUse::LargeBodies),
        (warm, TileUse::ThermalWalls),
        (sticky, TileUse::Wells),
    ];
    for (other, expected) in cases {
        let scene = Scene::from_toml(&format!("{other}{gas}")).unwrap();
        let tiling = Tiling { side: 20, ..SMALL };
        let mut simulation = Simulation::new(&scene).unwrap();
        simulation.set_tiling(&tiling);
        assert_eq!(simulation.tile_use(), expected);
        let (_, tiles) = run(&scene, &tiling, &[0.05]);
        assert_eq!(tiles, TileCounters::default());
    }
}
