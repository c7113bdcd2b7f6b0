//! A user-defined shape is data: any list of atoms, in code or in a scene file. Only a named family
//! of shapes needs code.

use std::f64::consts::TAU;

use carom::{Atom, Molecule, Scene, Shape, Simulation};
use carom_detection::first_contact_of_convex;
use carom_geometry::{Ellipse, Support, SupportPoint};
use carom_kinematics::{Orientation, RelativeMotion};
use glam::DVec2;

/// A hook of five unequal discs.
const HOOK: [([f64; 2], f64, f64); 5] = [
    ([0.0, 0.0], 0.03, 3.0),
    ([0.05, 0.0], 0.02, 1.0),
    ([0.09, 0.01], 0.02, 1.0),
    ([0.1, 0.045], 0.015, 0.5),
    ([0.08, 0.07], 0.01, 0.25),
];

fn atoms() -> Vec<Atom> {
    let atom = |(at, radius, mass): ([f64; 2], f64, f64)| Atom::new(DVec2::from(at), radius, mass);
    HOOK.into_iter()
        .map(|atom_of| atom(atom_of).unwrap())
        .collect()
}

#[test]
fn a_list_of_atoms_is_a_molecule_with_the_mass_and_moment_of_its_discs() {
    let hook = Molecule::new(atoms()).unwrap();
    let mass: f64 = HOOK.iter().map(|&(_, _, mass)| mass).sum();
    let centre: DVec2 = HOOK
        .iter()
        .map(|&(at, _, mass)| mass * DVec2::from(at))
        .sum::<DVec2>()
        / mass;
    // Each disc turns about its own centre (m r²/2), which is displaced from the common centre
    // (Steiner).
    let moment: f64 = HOOK
        .iter()
        .map(|&(at, radius, mass)| {
            mass * (0.5 * radius * radius + (DVec2::from(at) - centre).length_squared())
        })
        .sum();
    assert!((hook.mass() - mass).abs() < 1e-15 * mass);
    assert!((hook.moment_of_inertia() - moment).abs() < 1e-14 * moment);
}

#[test]
fn a_scene_of_molecules_from_a_list_of_atoms_conserves_energy_and_momentum() {
    let atom = |(at, radius, mass)| format!("{{ at = {at:?}, radius = {radius}, mass = {mass} }}");
    let atoms = HOOK.map(atom).join(",\n");
    let scene = Scene::from_toml(&format!(
        "[box]\nseed = 3\n[[gas]]\ncount = 12\nenergy = 1.0\natoms = [\n{atoms}]\n"
    ))
    .unwrap();
    let mut simulation = Simulation::new(&scene).unwrap();
    let before = (simulation.view().energy(), simulation.view().momentum());
    simulation.run_until(10.0).unwrap();
    let view = simulation.view();
    assert!(view.counters().collisions > 100, "{:?}", view.counters());
    assert_eq!(view.overlaps().pairs, 0);
    assert!((view.energy() - before.0).abs() < 1e-13 * before.0);
    assert!((view.momentum() - before.1).length() < 1e-12);
    let by_code = Molecule::new(self::atoms()).unwrap();
    assert!(view.bodies().all(|body| *body.body.molecule() == by_code));
}

#[test]
fn a_named_shape_gives_the_atoms_that_a_list_would() {
    let named: Shape = "rod:3".parse().unwrap();
    let listed: Vec<Atom> = [-2.0, 0.0, 2.0]
        .map(|x| Atom::new(DVec2::new(0.01 * x, 0.0), 0.01, 1.0).unwrap())
        .into();
    let [named, listed] =
        [named.atoms(0.01, 1.0).unwrap(), listed].map(|atoms| Molecule::new(atoms).unwrap());
    assert_eq!(named.bounding_radius(), listed.bounding_radius());
    assert_eq!(named.moment_of_inertia(), listed.moment_of_inertia());
}

/// A rounded triangle of constant width 2 with h = 1 + cos(3 φ)/16.
struct Cam;

impl Support for Cam {
    fn at(&self, normal: DVec2) -> SupportPoint {
        let angle = 3.0 * normal.to_angle();
        SupportPoint {
            distance: 1.0 + angle.cos() / 16.0,
            slope: -3.0 * angle.sin() / 16.0,
            curvature_radius: 1.0 - 8.0 * angle.cos() / 16.0,
        }
    }

    fn reach(&self) -> f64 {
        1.0 + 1.0 / 16.0
    }

    fn max_bend(&self) -> f64 {
        9.0 / 16.0
    }

    fn max_third(&self) -> f64 {
        27.0 / 16.0
    }
}

#[test]
fn a_convex_shape_of_ones_own_meets_others_where_its_support_function_says() {
    // Two cams that do not turn: the one at the right shows its side at 180 degrees, 1 − 1/16 away.
    let pair = RelativeMotion::exactly(DVec2::new(5.0, 0.0), DVec2::NEG_X);
    let found = first_contact_of_convex(&Cam, &Cam, &pair, 10.0);
    let time = found.outcome.contact().unwrap().time;
    assert!((time - 3.0).abs() < 1e-14, "{time}");
    // A cam that turns beside a disc: their gap is the largest distance of two facing tangents.
    let pair = RelativeMotion {
        angular_velocity: [0.5, 0.0],
        ..RelativeMotion::exactly(DVec2::new(2.0 + 1.0 / 32.0, 0.0), DVec2::ZERO)
    };
    let gap = |t: f64| {
        let (turn, sides) = (0.5 * t, 20_000);
        let across = |step: i32| {
            let angle = 1e-4 * f64::from(step);
            let normal = DVec2::from_angle(angle - turn);
            angle.cos() * pair.separation.x - Cam.at(normal).distance - 1.0
        };
        (-sides..sides)
            .map(across)
            .fold(f64::NEG_INFINITY, f64::max)
    };
    assert!(gap(1.0) > 0.01);
    let pair = RelativeMotion {
        orientation: [Orientation::from_turns(0.5 / TAU), Orientation::default()],
        ..pair
    };
    let found = first_contact_of_convex(&Cam, &Ellipse::round(1.0), &pair, 10.0);
    let time = found.outcome.contact().unwrap().time;
    assert!(gap(1.0 + time).abs() < 1e-8, "{time} {}", gap(1.0 + time));
    for part in 0..100 {
        assert!(gap(1.0 + time * f64::from(part) / 100.0) > 0.0);
    }
}
