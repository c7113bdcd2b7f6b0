//! Temperature relative to the centre of mass: given velocities, and equipartition for groups.

use carom::{
    Observer, Scene, Simulation,
    engine::{AtomSpec, BumperSpec, GasSpec, MoleculeSpec, WallSpec},
    observers::{Estimate, Group, VelocityDistribution},
};
use glam::DVec2;

use super::{disc, gas};

fn wall(x: Option<f64>, y: Option<f64>) -> WallSpec {
    WallSpec {
        x,
        y,
        ..WallSpec::default()
    }
}

fn bumper() -> BumperSpec {
    BumperSpec {
        tags: vec![],
        radius: 0.02,
        at: [0.5, 0.5],
    }
}

#[test]
fn a_wall_across_the_box_breaks_one_component_of_momentum_and_other_fixed_bodies_both() {
    let conserved = |wall: Vec<WallSpec>, bumper: Vec<BumperSpec>| {
        let simulation = Simulation::new(&Scene {
            wall,
            bumper,
            ..Scene::default()
        })
        .unwrap();
        simulation
            .view()
            .centre_of_mass_frame()
            .conserves_momentum()
    };
    let part = WallSpec {
        from: Some([0.2, 0.1]),
        to: Some([0.2, 0.4]),
        ..WallSpec::default()
    };
    let upright = || wall(Some(0.3), None);
    let level = || WallSpec {
        radius: 0.01,
        ..wall(None, Some(0.3))
    };
    assert_eq!(conserved(vec![], vec![]), [true, true]);
    assert_eq!(
        conserved(vec![upright(), wall(Some(0.8), None)], vec![]),
        [false, true]
    );
    assert_eq!(conserved(vec![level()], vec![]), [true, false]);
    assert_eq!(conserved(vec![upright(), level()], vec![]), [false, false]);
    assert_eq!(conserved(vec![part], vec![]), [false, false]);
    assert_eq!(conserved(vec![level()], vec![bumper()]), [false, false]);
}

#[test]
fn a_drift_of_the_whole_system_is_not_thermal() {
    let drift = DVec2::new(30.0, -20.0);
    let molecules = |drift: DVec2| {
        vec![
            disc(
                DVec2::new(0.2, 0.2),
                drift + DVec2::new(1.0, 0.0),
                0.05,
                1.0,
            ),
            disc(
                DVec2::new(0.8, 0.2),
                drift + DVec2::new(-0.5, 0.4),
                0.05,
                2.0,
            ),
            disc(
                DVec2::new(0.2, 0.8),
                drift + DVec2::new(0.0, -0.2),
                0.05,
                4.0,
            ),
        ]
    };
    let view = |drift: DVec2, wall: Vec<WallSpec>| {
        Simulation::new(&Scene {
            molecule: molecules(drift),
            wall,
            ..Scene::default()
        })
        .unwrap()
    };
    // P = 0 without the drift: K = ½ (1 + 2 × 0.41 + 4 × 0.04) = 0.99, f = 4.
    let kt = |simulation: &Simulation| simulation.view().temperature().unwrap();
    for drift in [DVec2::ZERO, drift] {
        assert!((kt(&view(drift, vec![])) - 0.495).abs() < 1e-12);
        let mut velocities = VelocityDistribution::new(Group::All, 2.0, 10).unwrap();
        velocities.sample(&view(drift, vec![]).view());
        let mean_square = velocities.series()[0].mean_square;
        assert!(
            (mean_square - (1.0 + 0.41 + 0.04) / 3.0).abs() < 1e-12,
            "{mean_square}"
        );
    }
    // Walls perpendicular to x turn the drift along x into heat, and f = 5.
    let heated = view(drift, vec![wall(Some(0.5), None)]);
    let expected = 2.0 * (0.99 + 0.5 * 7.0 * 900.0) / 5.0;
    assert!((kt(&heated) / expected - 1.0).abs() < 1e-12);
    // A system in which no body moves, and a single body.
    assert_eq!(
        Simulation::new(&Scene::default())
            .unwrap()
            .view()
            .temperature(),
        None
    );
    let alone = Scene {
        molecule: molecules(drift)[..1].to_vec(),
        ..Scene::default()
    };
    assert_eq!(Simulation::new(&alone).unwrap().view().temperature(), None);
}

/// A heavy disc with half of the total mass, among light ones, has the kT of all. Without the
/// correction for its share of the centre of mass it would seem colder, by a factor of 2 without
/// fixed bodies and of 4/3 beside a wall.
#[test]
fn groups_of_different_mass_have_one_temperature_with_any_fixed_bodies() {
    for (walls, bumpers) in [
        (vec![], vec![]),
        (vec![wall(Some(0.0), None)], vec![]),
        (vec![], vec![bumper()]),
    ] {
        let mut heavy = disc(DVec2::new(0.25, 0.25), DVec2::new(0.3, 0.2), 0.1, 10.0);
        heavy.tags = vec!["heavy".into()];
        let mut scene = Scene {
            molecule: vec![heavy],
            wall: walls,
            bumper: bumpers,
            ..Scene::default()
        };
        scene.gas.push(gas("gas", 10));
        let mut simulation = Simulation::new(&scene).unwrap();
        let tag = simulation.find_tag("heavy").unwrap();
        simulation.run_until(50.0).unwrap();
        let mut ratios = Vec::new();
        for block in 0..100 {
            let mut sum = (0.0, 0.0);
            for sample in 1..=400 {
                let time = 50.0 + 80.0 * f64::from(block) + 0.2 * f64::from(sample);
                simulation.run_until(time).unwrap();
                let view = simulation.view();
                let frame = view.centre_of_mass_frame();
                sum.0 += frame.thermal(view.tagged(tag)).temperature().unwrap();
                sum.1 += view.temperature().unwrap();
            }
            ratios.push((sum.0, sum.1));
        }
        let found = Estimate::of_ratio(ratios).unwrap();
        assert!(found.standard_error < 0.03, "{found:?}");
        assert!(
            (found.mean - 1.0).abs() < 3.5 * found.standard_error,
            "{found:?} in {scene:?}"
        );
    }
}

/// Two small atoms hidden in a disc change its moment of inertia, but no smooth contact turns it:
/// its energy is that of two degrees of freedom, and it behaves as a disc without them.
#[test]
fn hidden_atoms_add_no_degree_of_freedom() {
    let atom = |x: f64, radius: f64, mass: f64| AtomSpec {
        at: [x, 0.0],
        radius,
        mass,
    };
    let atoms = vec![
        atom(0.0, 0.02, 0.5),
        atom(-0.015, 0.005, 0.25),
        atom(0.015, 0.005, 0.25),
    ];
    let loaded = GasSpec {
        radius: None,
        mass: None,
        atoms,
        ..gas("gas", 50)
    };
    let mut scene = Scene {
        gas: vec![loaded],
        ..Scene::default()
    };
    let mut simulation = Simulation::new(&scene).unwrap();
    // Σ ½ m v² = 50 at P = 0, over 2 × 50 − 2 degrees of freedom.
    let thermal = |simulation: &Simulation| {
        let view = simulation.view();
        view.centre_of_mass_frame().thermal(view.bodies())
    };
    assert_eq!(thermal(&simulation).degrees_of_freedom, 98.0);
    let kt = simulation.view().temperature().unwrap();
    assert!((kt / (100.0 / 98.0) - 1.0).abs() < 1e-12, "{kt}");
    simulation.run_until(20.0).unwrap();
    assert!(simulation.view().counters().collisions > 1000);
    let fastest = simulation
        .view()
        .bodies()
        .map(|body| body.motion.angular_velocity.abs())
        .fold(0.0, f64::max);
    assert!(fastest < 1e-10, "{fastest}");
    assert!((simulation.view().temperature().unwrap() / kt - 1.0).abs() < 1e-12);
    // A given angular velocity is conserved, and is not thermal.
    let of_gas = scene.gas.remove(0);
    scene.molecule = [0.2, 0.7]
        .map(|x| MoleculeSpec {
            atoms: of_gas.atoms.clone(),
            at: [x, 0.5],
            velocity: [if x < 0.5 { 1.0 } else { -1.0 }, 0.1],
            angular_velocity: 100.0,
            ..MoleculeSpec::default()
        })
        .to_vec();
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.run_until(1.0).unwrap();
    assert!(simulation.view().counters().collisions > 0);
    // Relative velocities ± 1 along x: Σ ½ m v² = 1, and f = 2.
    let found = thermal(&simulation);
    assert_eq!(found.degrees_of_freedom, 2.0);
    assert!((found.energy() - 1.0).abs() < 1e-12, "{found:?}");
    for body in simulation.view().bodies() {
        assert!((body.motion.angular_velocity / 100.0 - 1.0).abs() < 1e-10);
    }
}
