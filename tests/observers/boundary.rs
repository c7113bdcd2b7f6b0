//! The density at contact along a body: exact for an ideal gas of one disc, and for a dilute gas.

use std::f64::consts::PI;

use carom::{
    Observer, Scene, Simulation,
    engine::{BumperSpec, GasSpec, MoleculeSpec},
    observers::{ContactDensity, ContactPoint},
};
use glam::DVec2;

use super::{disc, gas, hard_discs, key, observe, tee};

/// χ² of the bins with many contacts against a uniform pressure, and their number.
fn chi_squared(points: &[ContactPoint], expected: f64) -> (f64, f64) {
    let many: Vec<&ContactPoint> = points
        .iter()
        .filter(|point| point.contacts >= 100)
        .collect();
    let deviation =
        |point: &&ContactPoint| ((point.pressure - expected) / point.standard_error).powi(2);
    (many.iter().map(deviation).sum(), many.len() as f64)
}

#[test]
fn one_disc_hits_the_boundary_of_a_fixed_molecule_uniformly() {
    // One disc of speed v on a torus with a fixed body is an ideal gas of n = 1 / (L² − A_excl) and
    // kT = ½ m v² (the billiard is ergodic; Σ|J| per time and arc is n v/π × 2 m v π/4). For the T
    // with atoms a = 0.005 and discs r = 0.01: P = 0.16448117 and A_excl = 0.00180353, from plane
    // geometry.
    let side = 0.13;
    let still = MoleculeSpec {
        fixed: true,
        atom_radius: Some(0.005),
        ..tee(DVec2::new(0.06, 0.07), 0.7)
    };
    let flight = disc(DVec2::new(0.013, 0.011), DVec2::new(0.6, 0.8), 0.01, 3.0);
    let mut scene = Scene {
        molecule: vec![still, flight],
        ..Scene::default()
    };
    scene.bounds.sides = [side; 2];
    let mut simulation = Simulation::new(&scene).unwrap();
    let body = simulation
        .view()
        .body(key(&simulation, 0))
        .unwrap()
        .body
        .clone();
    let mut contacts = ContactDensity::new(&body, 0.01, 72).unwrap();
    assert!(
        (contacts.perimeter() - 0.164_481_17).abs() < 1e-8,
        "{}",
        contacts.perimeter()
    );
    assert!(contacts.mean().is_none() && contacts.points().is_empty());
    let time = 80_000.0;
    observe(&mut simulation, &mut contacts, time, 1);

    let pressure = 0.5 * 3.0 / (side * side - 0.001_803_53);
    let points = contacts.points();
    let hits: u64 = points.iter().map(|point| point.contacts).sum();
    // v P / π (L² − A_excl) per time (Santaló's mean free path), Poisson to within a factor.
    let expected = time * contacts.perimeter() / (PI * (side * side - 0.001_803_53));
    assert!(
        (hits as f64 / expected - 1.0).abs() < 0.006,
        "{hits} of {expected}"
    );
    assert_eq!(
        (contacts.others(), contacts.duration(), contacts.body()),
        (0, time, body.key())
    );
    assert!(
        (contacts.mean().unwrap() / pressure - 1.0).abs() < 0.006,
        "{:?} {pressure}",
        contacts.mean()
    );
    let (chi, bins) = chi_squared(&points, pressure);
    assert!(
        bins > 100.0 && (chi - bins).abs() < 4.0 * (2.0 * bins).sqrt(),
        "{chi} of {bins} bins"
    );
    // Each piece of the boundary belongs to a point, and the stem (atom 3) has two pieces of only
    // 2.6°.
    let arcs = |atom| {
        points
            .iter()
            .filter(move |point| point.atom == atom)
            .map(|point| point.arc)
            .sum::<f64>()
    };
    assert!(
        (arcs(3) - 0.015 * 5.193_5f64.to_radians()).abs() < 1e-7,
        "{}",
        arcs(3)
    );
    assert!(
        points
            .iter()
            .filter(|point| point.atom == 3)
            .all(|point| (190.0..350.0).contains(&point.angle.to_degrees()))
    );
}

#[test]
fn a_dilute_gas_at_a_fixed_disc_has_the_density_of_the_gas() {
    // A fixed disc equal to the others is one of N + 1: ρ_c = χ N/A, χ = 1 + 1.564 η at low density
    // (third virial coefficient 4/3 − √3/π of B₂²: Z − 1 = 2 η χ).
    let (count, eta) = (20, 0.005);
    let mut scene = hard_discs(count, eta, 11);
    scene.gas[0].zero_momentum = Some(false);
    let side = scene.bounds.sides[0];
    scene.bumper.push(BumperSpec {
        tags: vec![],
        radius: 0.5,
        at: [0.3 * side, 0.9 * side],
    });
    let mut simulation = Simulation::new(&scene).unwrap();
    let fixed = simulation
        .view()
        .bodies()
        .find(|view| view.body.is_fixed())
        .unwrap()
        .body
        .clone();
    let mut contacts = ContactDensity::new(&fixed, 0.5, 12).unwrap();
    simulation.run_until(1000.0).unwrap();
    observe(&mut simulation, &mut contacts, 1.0e6, 2);
    let density = count as f64 / (side * side) * (1.0 + 1.564 * eta);
    let temperature = simulation.view().energy() / count as f64;
    let points = contacts.points();
    let hits: u64 = points.iter().map(|point| point.contacts).sum();
    // ⟨J²⟩/⟨J⟩² = 4/π for a Rayleigh distribution.
    let error = (4.0 / PI / hits as f64).sqrt();
    let found = contacts.mean().unwrap() / (temperature * density);
    assert!(
        error < 0.012 && (found - 1.0).abs() < 4.0 * error,
        "{found} ± {error}"
    );
    let (chi, bins) = chi_squared(&points, temperature * density);
    assert!(
        bins == 12.0 && (chi - bins).abs() < 4.0 * (2.0 * bins).sqrt(),
        "{chi}"
    );
}

#[test]
fn bodies_other_than_the_discs_of_the_gas_are_counted_separately() {
    let mut scene = Scene::default();
    scene.gas.push(gas("gas", 60));
    scene.gas.push(GasSpec {
        radius: Some(0.03.into()),
        ..gas("large", 10)
    });
    scene.bumper.push(BumperSpec {
        tags: vec![],
        radius: 0.1,
        at: [0.5, 0.5],
    });
    let mut simulation = Simulation::new(&scene).unwrap();
    let fixed = simulation
        .view()
        .bodies()
        .find(|view| view.body.is_fixed())
        .unwrap()
        .body
        .clone();
    let mut observers = (
        ContactDensity::new(&fixed, 0.02, 1).unwrap(),
        ContactDensity::new(&fixed, 0.03, 1).unwrap(),
        ContactDensity::new(&fixed, 0.04, 0).unwrap(),
    );
    observe(&mut simulation, &mut observers, 5.0, 1);
    let (small, large, none) = observers;
    let contacts = |observer: &ContactDensity| observer.points()[0].contacts;
    assert!(contacts(&small) > contacts(&large) && contacts(&large) > 0);
    assert_eq!(
        (contacts(&small), contacts(&large)),
        (large.others(), small.others())
    );
    assert_eq!(
        (contacts(&none), none.others()),
        (0, contacts(&small) + contacts(&large))
    );
    assert_eq!(none.points()[0].standard_error, 0.0);
    assert!(ContactDensity::new(&fixed, -0.02, 1).is_err());
    // After its removal the observation time stops.
    let mut small = small;
    simulation.remove(fixed.key()).unwrap();
    observe(&mut simulation, &mut small, 6.0, 1);
    assert_eq!(small.duration(), 5.0);
    small.sample(&simulation.view());
}
