//! Gases of ellipses: they conserve momentum and energy, never overlap by more than rounding, share
//! the energy with their rotation, and follow the same path with each scheduler, in tiles and after
//! a resumption.

use carom::{Scene, Simulation};
use carom_detection::{Exact, GoldenSecant};
use carom_engine::{CellScheduler, CollisionReport, Instructions, Observer, Tiling};
use carom_kinematics::angular_momentum;
use carom_response::Impact;

use crate::support::{bits, check_heap_against_cells, check_portable_and_resumed};

/// Ellipses of two kinds among discs, squares and capsules, beside a wall and a fixed ellipse.
fn mixed(elasticity: f64) -> Scene {
    let text = format!(
        r#"
        [box]
        sides = [1.0, 0.9]
        seed = 6
        [start]
        placement = "grown"
        relax = 1.0
        [[molecule]]
        shape = "ellipse:3"
        size = 0.2
        mass = 1.0
        fixed = true
        orientation = 0.4
        at = [0.5, 0.45]
        [[wall]]
        x = 0.0
        [[wall]]
        from = [0.7, 0.1]
        to = [0.8, 0.2]
        [[gas]]
        shape = "ellipse:2"
        size = 0.05
        mass = 1.0
        temperature = 1.0
        count = 40
        [[gas]]
        tags = ["thin"]
        shape = "ellipse:8"
        size = 0.08
        density = 600.0
        temperature = 1.0
        count = 25
        [[gas]]
        radius = 0.01
        mass = 0.5
        temperature = 1.0
        count = 30
        [[gas]]
        shape = "square"
        size = 0.03
        mass = 1.0
        temperature = 1.0
        count = 15
        [[gas]]
        shape = "capsule:3"
        size = 0.02
        mass = 1.0
        temperature = 1.0
        count = 10
        [elasticity]
        default = {elasticity}
        "#
    );
    Scene::from_toml(&text).unwrap()
}

/// Asserts that each contact has one normal and one place for both bodies.
#[derive(Default)]
struct Contacts(u32);

impl Observer for Contacts {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0 += 1;
        if report.points > 1 {
            return;
        }
        // An impulse without friction has no moment about the line of the normal through the point.
        let along = report.impulse.dot(report.normal);
        let across = (report.impulse - along * report.normal).length();
        assert!(across <= 1e-12 * along, "{across:e} of {along:e}");
        for side in &report.sides {
            let inertia = side.body.inertia();
            if inertia.inverse_moment > 0.0 {
                let about =
                    |motion| angular_momentum(motion, inertia, side.before.position + side.arm);
                let turning = side.before.angular_velocity.abs() / inertia.inverse_moment;
                let moving = side.before.velocity.length() / inertia.inverse_mass;
                let size = (report.impulse.length() + moving) * side.body.reach() + turning;
                let change = (about(&side.after) - about(&side.before)).abs();
                assert!(change < 1e-12 * size, "{change:e} of {size:e}");
            }
        }
    }
}

#[test]
fn ellipses_among_other_bodies_never_overlap_by_more_than_rounding() {
    for elasticity in [1.0, 0.9, 0.0] {
        let scene = mixed(elasticity);
        let mut simulation = Simulation::new(&scene).unwrap();
        let start = simulation.view().energy();
        let until = if elasticity == 0.0 { 0.5 } else { 2.0 };
        let mut contacts = Contacts::default();
        for step in 1..=20 {
            let until = until * f64::from(step) / 20.0;
            simulation.observe_until(until, &mut contacts).unwrap();
            let overlaps = simulation.view().overlaps();
            let deepest = overlaps.deepest_length / f64::EPSILON;
            assert!(
                deepest < 64.0 && overlaps.pairs == 0,
                "{elasticity}: {overlaps:?}"
            );
        }
        let counters = simulation.view().counters();
        assert!(contacts.0 > 1500, "{elasticity}: {counters:?}");
        if elasticity == 1.0 {
            // Slow contacts of other elasticities have times that differ by more than rounding.
            simulation.check_invariants(0.01).unwrap();
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
fn a_gas_of_ellipses_in_tiles_is_that_in_order_to_the_bit_and_shares_its_energy() {
    let scene = Scene::from_toml(
        r#"
        [[gas]]
        shape = "ellipse:2"
        size = 0.01
        mass = 1.0
        temperature = 1.0
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
        simulation.run_until(0.1).unwrap();
    }
    let view = in_order.view();
    assert!(view.counters().collisions > 50_000);
    assert_eq!(bits(&tiled.view()), bits(&view));
    // Equal energies at the start: 1.5 kT each; a third of the energy is that of the rotation.
    let turning: f64 = view
        .bodies()
        .map(|body| 0.5 * body.motion.angular_velocity.powi(2) / body.body.inertia().inverse_moment)
        .sum();
    let (share, count) = (turning / view.energy(), view.len() as f64);
    // ½ I ω² has the relative deviation √2, in a microcanonical mean √(2 · 2/3).
    assert!(
        (3.0 * share - 1.0).abs() < 4.0 * (4.0 / 3.0 / count).sqrt(),
        "{share}"
    );
}

/// Bodies of ellipses and a disc by a list share the energy over their degrees of freedom, and keep
/// it.
#[test]
fn bodies_of_listed_ellipses_come_to_equipartition() {
    let scene = Scene::from_toml(
        r"
        [[gas]]
        atoms = [{ at = [0.0, 0.0], radius = 0.01, mass = 2.0 }]
        ellipses = [
            { at = [0.02, 0.0], axes = [0.01, 0.004], mass = 1.0 },
            { at = [-0.02, 0.0], axes = [0.004, 0.01], turn = 1.5707963267948966, mass = 1.0 },
        ]
        energy = 1.5
        count = 150
        [[gas]]
        radius = 0.01
        mass = 1.0
        energy = 0.0
        count = 150
        ",
    )
    .unwrap();
    let mut simulation = Simulation::new(&scene).unwrap();
    let energy = simulation.view().energy();
    let first = simulation.view().bodies().next().unwrap();
    let molecule = first.body.molecule();
    // I = m r²/2 + 2 (m (a² + b²)/4 + m d²), A = π (r² + 2 a b).
    let inertia = 2.0 * 5e-5 + 2.0 * (0.25 * (1e-4 + 1.6e-5) + 4e-4);
    assert!((molecule.moment_of_inertia() / inertia - 1.0).abs() < 1e-12);
    let area = std::f64::consts::PI * (1e-4 + 2.0 * 4e-5);
    assert!((molecule.area() / area - 1.0).abs() < 1e-12);
    let (mut moves, mut turns, mut discs) = (0.0, 0.0, 0.0);
    let samples = 200;
    for sample in 0..samples {
        simulation.run_until(2.0 + 0.1 * f64::from(sample)).unwrap();
        for body in simulation.view().bodies() {
            let inertia = body.body.inertia();
            let of_place = 0.5 * body.motion.velocity.length_squared() / inertia.inverse_mass;
            if body.body.molecule().is_disc() {
                discs += of_place;
            } else {
                moves += of_place;
                turns += 0.5 * body.motion.angular_velocity.powi(2) / inertia.inverse_moment;
            }
        }
    }
    assert!((simulation.view().energy() / energy - 1.0).abs() < 1e-12);
    assert_eq!(simulation.view().overlaps().pairs, 0);
    // kT per degree of freedom is twice the mean; the energies of 150 bodies in 200 samples, some
    // of them dependent, scatter by less than 1 %.
    let all = (moves + turns + discs) / 5.0;
    for (found, degrees) in [(moves, 2.0), (turns, 1.0), (discs, 2.0)] {
        assert!((found / degrees / all - 1.0).abs() < 0.03, "{found} {all}");
    }
}

#[test]
fn a_detector_that_does_not_search_ellipses_is_refused() {
    let scene = Scene::from_toml(
        "[[gas]]\nshape = \"ellipse:2\"\nsize = 0.1\nmass = 1.0\nenergy = 1.0\ncount = 2",
    )
    .unwrap();
    let options = Instructions::default();
    let refused =
        Simulation::<_, _, CellScheduler>::with(&scene, GoldenSecant::default(), Impact, options)
            .err()
            .unwrap();
    assert!(
        refused.to_string().contains("does not search ellipses"),
        "{refused}"
    );
    let options = Instructions::default();
    Simulation::<_, _, CellScheduler>::with(&scene, Exact::default(), Impact, options).unwrap();
}

#[test]
fn no_ellipse_is_placed_in_a_solid_square() {
    for (gas, placement) in [
        ("fixed = true", "lattice"),
        ("mass = 1.0\ntemperature = 1.0", "lattice"),
        ("mass = 1.0\ntemperature = 1.0", "grown"),
    ] {
        let text = format!(
            r#"
            [start]
            placement = "{placement}"
            [[molecule]]
            shape = "square"
            size = 0.6
            mass = 1.0
            fixed = true
            at = [0.5, 0.5]
            [[gas]]
            tags = ["ellipse"]
            shape = "ellipse:2"
            size = 0.02
            count = 300
            {gas}
            "#
        );
        let simulation = Simulation::new(&Scene::from_toml(&text).unwrap()).unwrap();
        let view = simulation.view();
        assert_eq!(view.overlaps().pairs, 0, "{gas}, {placement}");
        let ellipses = view
            .bodies()
            .filter(|body| body.body.molecule().edges().is_empty());
        let from_middle = ellipses.map(|body| (body.motion.position - 0.5).abs().max_element());
        let nearest = from_middle.fold(f64::INFINITY, f64::min);
        assert!(nearest > 0.3, "{gas}, {placement}: {nearest}");
    }
}

/// An ellipse that turns about the centre of mass of the body around it: the line of their centres
/// has no direction, the contact has.
#[test]
fn a_body_about_the_centre_of_mass_of_another_touches_it_along_the_normal() {
    let text = "[[molecule]]\nat = [0.5, 0.5]\nangular_velocity = 3.0\nmass = 1.0\nshape = \"ellipse:10\"\nsize = 0.3\n\
        [[molecule]]\nat = [0.5, 0.5]\nellipses = [\n\
        { at = [0.1, 0.0], axes = [0.02, 0.03], mass = 1.0 },\n\
        { at = [-0.2, 0.0], axes = [0.02, 0.03], mass = 0.5 },\n]\norientation_turns = 0.25\nrotation = \"locked\"";
    let scene = Scene::from_toml(text).unwrap();
    let mut simulation = Simulation::new(&scene).unwrap();
    let energy = simulation.view().energy();
    simulation.step(1.0, &mut ()).unwrap();
    let view = simulation.view();
    assert_eq!(view.counters().collisions, 1);
    let motions: Vec<_> = view.bodies().map(|body| body.motion).collect();
    // The ellipse turns by less than a quarter, and pushes the other body ahead of it.
    assert!(motions[0].angular_velocity < 2.9, "{motions:?}");
    assert!(motions[1].velocity.x < -0.01, "{motions:?}");
    assert!((view.energy() - energy).abs() < 1e-15 * energy);
}
