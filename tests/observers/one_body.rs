//! Observables of one body: directions, projections, running averages.

use std::f64::consts::PI;

use carom::{
    CollisionReport, DirectionHistogram, Molecule, Observer, RunningAverage, Scene, Shape,
    Simulation,
    engine::{BumperSpec, MoleculeSpec, Rotation},
    observers::{BodyAxis, ImpulseLog, ProjectionHistogram},
};
use glam::DVec2;

use super::{ByHand, disc, gas, key, observe, tee};

/// R(−θ) v, written out.
fn turned_back(v: DVec2, theta: f64) -> DVec2 {
    let (sin, cos) = theta.sin_cos();
    DVec2::new(v.x * cos + v.y * sin, v.y * cos - v.x * sin)
}

/// A tee that turns and flies across the border is hit at a known time and orientation on its atom
/// `atom`, from the direction `phi` in its own frame: the impulse on it points along `phi` + π.
fn planted_hit(atom: usize, phi: f64, tee_first: bool) {
    const CONTACT: f64 = 0.25;
    let (theta, spin, drift) = (2.345, 1.3, DVec2::new(0.5, 0.3));
    let (radius, mass) = (0.02, 0.7);
    let shape = Molecule::named(Shape::Tee, 0.01, 2.0).unwrap();
    let normal = DVec2::from_angle(theta + phi);
    let arm = DVec2::from_angle(theta).rotate(shape.atoms()[atom].offset());
    let tee_there = DVec2::new(0.99, 0.02);
    let disc_there = tee_there + arm + (0.01 + radius) * normal;
    // Fast enough not to hit another atom before, and not along the normal.
    let fall = -2.0 * normal + 0.4 * normal.perp();

    let planted_tee = MoleculeSpec {
        velocity: drift.into(),
        angular_velocity: spin,
        ..tee(tee_there - drift * CONTACT, theta - spin * CONTACT)
    };
    let planted_disc = disc(disc_there - fall * CONTACT, fall, radius, mass);
    let molecule = if tee_first {
        vec![planted_tee, planted_disc]
    } else {
        vec![planted_disc, planted_tee]
    };
    let mut simulation = Simulation::new(&Scene {
        molecule,
        ..Scene::default()
    })
    .unwrap();
    let watched = key(&simulation, usize::from(!tee_first));
    let mut observers = (
        DirectionHistogram::new(watched, 720),
        ProjectionHistogram::new(watched, BodyAxis::X, 10.0, 200).unwrap(),
        ProjectionHistogram::new(watched, BodyAxis::Y, 10.0, 200).unwrap(),
        ImpulseLog::new(watched, 9),
    );
    observe(&mut simulation, &mut observers, 0.27, 1);
    let (directions, along_x, along_y, mut log) = observers;

    // J = 2 μ u (Montanari 2017, equation 2.9).
    let approach = (drift + spin * arm.perp() - fall).dot(normal);
    let lever = arm.perp_dot(normal);
    let inverse = 1.0 / mass + 1.0 / shape.mass() + lever * lever / shape.moment_of_inertia();
    let impulse = 2.0 * approach / inverse;
    let mut expected = vec![0; 720];
    expected[((phi + PI).rem_euclid(2.0 * PI).to_degrees() * 2.0) as usize] = 1;
    assert_eq!(directions.counts(), expected, "atom {atom} from {phi}");
    assert_eq!(directions.hits(), 1);
    assert!((directions.total_impulse() - impulse).abs() < 1e-10 * impulse);
    let bin = expected.iter().position(|&count| count == 1).unwrap();
    assert_eq!(directions.impulse()[bin], directions.total_impulse());
    let mut atoms = [0; 5];
    atoms[atom] = 1;
    assert_eq!(directions.atom_counts(), atoms);
    let noted = log.take();
    assert_eq!((noted.len(), noted[0].atom), (1, Some(atom as u32)));
    assert!((noted[0].time - CONTACT).abs() < 1e-9 && (noted[0].normal + normal).length() < 1e-9);
    assert!((noted[0].impulse + impulse * normal).length() < 1e-9 * impulse);
    assert!((noted[0].in_body_frame + impulse * DVec2::from_angle(phi)).length() < 1e-9 * impulse);
    assert!((along_x.mean().unwrap() + impulse * phi.cos()).abs() < 1e-9 * impulse);
    assert!((along_y.mean().unwrap() + impulse * phi.sin()).abs() < 1e-9 * impulse);
    let along_x = along_x.components();
    let bin = along_x
        .counts()
        .iter()
        .position(|&count| count == 1)
        .unwrap();
    assert!((along_x.bins().edges()[bin] + 0.05 + impulse * phi.cos()).abs() <= 0.05);
}

#[test]
fn the_direction_of_a_known_hit_is_relative_to_the_turned_molecule() {
    // Normals that these atoms expose: atom 2 from −73° to 109°, atom 0 from 71° to 253°, atom 4
    // from 161° to 379°.
    for tee_first in [true, false] {
        for (atom, phi) in [
            (2, 0.301),
            (2, -0.7),
            (0, 2.5),
            (0, 3.3),
            (4, 4.567),
            (4, 5.5),
            (1, 1.6),
        ] {
            planted_hit(atom, phi, tee_first);
        }
    }
}

#[test]
fn contacts_out_of_the_range_of_a_histogram_are_not_in_its_end_bins() {
    // Head-on against a fixed disc: the impulse on the moving disc is −2 m v = −2 along x.
    for (half_width, inside) in [(1.9, false), (2.1, true)] {
        let mut scene = Scene {
            molecule: vec![disc(DVec2::new(0.3, 0.5), DVec2::X, 0.05, 1.0)],
            ..Scene::default()
        };
        scene.bumper.push(BumperSpec {
            tags: vec![],
            radius: 0.05,
            at: [0.5, 0.5],
        });
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut along_x =
            ProjectionHistogram::new(key(&simulation, 0), BodyAxis::X, half_width, 10).unwrap();
        observe(&mut simulation, &mut along_x, 0.2, 1);
        let bins = along_x.components();
        assert_eq!(
            (bins.counts()[0] == 1, bins.beyond() == 0),
            (inside, inside)
        );
        assert!((along_x.mean().unwrap() + 2.0).abs() < 1e-14);
        assert!((along_x.mean_square().unwrap() - 4.0).abs() < 1e-13);
    }
}

#[test]
fn hits_on_fixed_bodies_are_counted() {
    let mut scene = Scene {
        molecule: vec![disc(DVec2::new(0.3, 0.5), DVec2::X, 0.05, 1.0)],
        ..Scene::default()
    };
    scene.bumper.push(BumperSpec {
        tags: vec![],
        radius: 0.05,
        at: [0.5, 0.5],
    });
    let mut simulation = Simulation::new(&scene).unwrap();
    let mut directions = DirectionHistogram::new(key(&simulation, 1), 3);
    observe(&mut simulation, &mut directions, 0.2, 1);
    assert_eq!(directions.counts(), [1, 0, 0]);
    assert!((directions.total_impulse() - 2.0).abs() < 1e-14);
}

#[test]
fn running_averages_are_the_sums_by_hand() {
    let mut scene = Scene {
        molecule: vec![tee(DVec2::new(0.5, 0.5), 0.7)],
        ..Scene::default()
    };
    scene.gas.push(gas("gas", 100));
    let mut simulation = Simulation::new(&scene).unwrap();
    let watched = key(&simulation, 0);
    simulation.run_until(0.5).unwrap();
    let by_hand = ByHand(Vec::new(), |report: &CollisionReport<'_>| {
        let (side, _) = report.side_of(watched)?;
        let change = 10.0 * (side.after.velocity - side.before.velocity);
        Some((
            report.time.to_f64(),
            turned_back(change, side.before.orientation.radians()),
        ))
    });
    let mut velocities = Vec::new();
    let mut observers = (RunningAverage::new(watched), by_hand);
    observers.start(&simulation.view());
    for sample in 1..=20 {
        simulation
            .observe_until(0.5 + 0.5 * f64::from(sample), &mut observers)
            .unwrap();
        observers.sample(&simulation.view());
        let motion = simulation.view().body(watched).unwrap().motion;
        velocities.push(turned_back(motion.velocity, motion.orientation.radians()));
    }
    let (average, ByHand(hits, _)) = observers;
    assert!(hits.len() > 100, "{} hits", hits.len());
    assert_eq!(average.series().len(), 20);
    for (index, point) in average.series().iter().enumerate() {
        assert_eq!(point.time, 1.0 + 0.5 * index as f64);
        let sum: DVec2 = hits
            .iter()
            .filter(|(time, _)| *time <= point.time)
            .map(|(_, change)| *change)
            .sum();
        assert!(
            (point.momentum - sum / (point.time - 0.5)).length() < 1e-11,
            "{point:?}"
        );
        let mean = velocities[..=index].iter().sum::<DVec2>() / (index + 1) as f64;
        assert!((point.velocity - mean).length() < 1e-13, "{point:?}");
    }
}

#[test]
fn mean_force_on_a_locked_molecule_is_its_change_of_momentum() {
    let theta = 0.7;
    let locked = MoleculeSpec {
        rotation: Rotation::Locked,
        ..tee(DVec2::new(0.5, 0.5), theta)
    };
    let mut scene = Scene {
        molecule: vec![locked],
        ..Scene::default()
    };
    scene.gas.push(gas("gas", 100));
    let mut simulation = Simulation::new(&scene).unwrap();
    let watched = key(&simulation, 0);
    let projection = |axis| ProjectionHistogram::new(watched, axis, 20.0, 40).unwrap();
    let mut observers = (
        RunningAverage::new(watched),
        projection(BodyAxis::X),
        projection(BodyAxis::Y),
        DirectionHistogram::new(watched, 0),
    );
    observe(&mut simulation, &mut observers, 5.0, 10);
    let (average, along_x, along_y, directions) = observers;
    let gained = turned_back(
        10.0 * simulation.view().body(watched).unwrap().motion.velocity,
        theta,
    );
    let last = average.series().last().unwrap();
    assert!(
        (5.0 * last.momentum - gained).length() < 1e-11,
        "{gained} against {last:?}"
    );
    let hits = along_x.hits() as f64;
    assert!((along_x.mean().unwrap() * hits - gained.x).abs() < 1e-11);
    assert!((along_y.mean().unwrap() * hits - gained.y).abs() < 1e-11);
    // No bins were requested: a single bin counts all.
    assert_eq!(directions.counts(), [along_x.hits()]);
}

#[test]
fn a_removed_body_is_not_observed_any_more() {
    let mut scene = Scene::default();
    scene.gas.push(gas("gas", 50));
    let mut simulation = Simulation::new(&scene).unwrap();
    let watched = key(&simulation, 7);
    let mut observers = (
        RunningAverage::new(watched),
        DirectionHistogram::new(watched, 8),
    );
    observers.start(&simulation.view());
    observers.sample(&simulation.view());
    assert_eq!(
        observers.0.series()[0].momentum,
        DVec2::ZERO,
        "no time has passed"
    );
    observe(&mut simulation, &mut observers, 1.0, 1);
    let hits = observers.1.hits();
    assert!(hits > 0);
    simulation.remove(watched).unwrap();
    observe(&mut simulation, &mut observers, 2.0, 1);
    assert_eq!((observers.0.series().len(), observers.1.hits()), (2, hits));
}
