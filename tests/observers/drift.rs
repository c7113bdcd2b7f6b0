//! Momentum and displacement of a body in its own frame: rotation in empty space, sums against
//! changes of momentum.

use carom::{
    Scene, Simulation,
    engine::{MoleculeSpec, Rotation},
    observers::Drift,
};
use glam::DVec2;

use super::{ByHand, gas, key, observe, tee};

fn close(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() < 1e-10 * expected.abs().max(1.0),
        "{found} is not {expected}"
    );
}

/// In its own frame a rotating body moves on a circle: with v along x and θ = θ₀ + ωt the
/// displacement is (sin θ, cos θ) v / ω.
#[test]
fn a_rotating_tee_in_empty_space_has_the_known_displacement() {
    let (speed, spin, start, until) = (0.7, 2.3, 0.4, 3.1);
    for samples in [1, 7, 64] {
        let planted = MoleculeSpec {
            velocity: [speed, 0.0],
            angular_velocity: spin,
            ..tee(DVec2::new(0.9, 0.5), start)
        };
        let scene = Scene {
            molecule: vec![planted],
            ..Scene::default()
        };
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut drift = Drift::new(key(&simulation, 0));
        observe(&mut simulation, &mut drift, until, samples);
        let end = start + spin * until;
        close(drift.path().x, speed / spin * (end.sin() - start.sin()));
        close(drift.path().y, speed / spin * (end.cos() - start.cos()));
        close(drift.turn(), spin * until);
        close(drift.duration(), until);
        assert_eq!(
            (drift.impulse(), drift.angular_impulse()),
            (DVec2::ZERO, 0.0)
        );
        assert_eq!(drift.samples(), u64::from(samples));
        close(
            drift.velocity_squares().element_sum(),
            f64::from(samples) * speed * speed,
        );
        close(drift.spin_squares(), f64::from(samples) * spin * spin);
    }
}

fn tee_in_a_gas(rotation: Rotation) -> Simulation {
    let mut scene = Scene {
        molecule: vec![MoleculeSpec {
            rotation,
            ..tee(DVec2::new(0.5, 0.5), 0.7)
        }],
        ..Scene::default()
    };
    scene.gas.push(gas("gas", 100));
    Simulation::new(&scene).unwrap()
}

/// R(−θ) v.
fn turned_back(v: DVec2, theta: f64) -> DVec2 {
    DVec2::from_angle(-theta).rotate(v)
}

#[test]
fn sums_over_a_locked_tee_are_its_momentum_and_its_displacement() {
    let mut simulation = tee_in_a_gas(Rotation::Locked);
    let watched = key(&simulation, 0);
    // The tee was inserted first, so the point of contact is given in the image next to it.
    let torques = ByHand(Vec::new(), |report: &carom::CollisionReport<'_>| {
        let (side, impulse) = report.side_of(watched)?;
        Some((report.point - side.before.position).perp_dot(impulse))
    });
    let mut observers = (Drift::new(watched), torques);
    let state = |simulation: &Simulation| {
        let view = simulation.view();
        let tee = view.body(watched).unwrap();
        (tee.motion.velocity, tee.unwrapped(&view.bounds()))
    };
    let (velocity, place) = state(&simulation);
    observe(&mut simulation, &mut observers, 5.0, 3);
    let (drift, torques) = observers;
    let (velocity_there, place_there) = state(&simulation);
    let (impulse, path) = (
        turned_back(10.0 * (velocity_there - velocity), 0.7),
        turned_back(place_there - place, 0.7),
    );
    assert!(torques.0.len() > 30, "{}", torques.0.len());
    close(drift.angular_impulse(), torques.0.iter().sum());
    for axis in 0..2 {
        close(drift.impulse()[axis], impulse[axis]);
        close(drift.path()[axis], path[axis]);
    }
    assert_eq!(drift.turn(), 0.0);
}

#[test]
fn torques_on_a_free_tee_sum_to_its_angular_momentum() {
    let mut simulation = tee_in_a_gas(Rotation::Free);
    let watched = key(&simulation, 0);
    let spin = |simulation: &Simulation| {
        simulation
            .view()
            .body(watched)
            .unwrap()
            .motion
            .angular_velocity
    };
    let moment = simulation
        .view()
        .body(watched)
        .unwrap()
        .body
        .molecule()
        .moment_of_inertia();
    let before = spin(&simulation);
    let mut drift = Drift::new(watched);
    observe(&mut simulation, &mut drift, 5.0, 3);
    let change = moment * (spin(&simulation) - before);
    assert!(
        (drift.angular_impulse() - change).abs() < 1e-12 * moment.sqrt(),
        "{change}"
    );
    assert!(drift.turn() != 0.0);
}
