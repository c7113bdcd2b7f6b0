//! Observables of the whole gas: energy, collision rate, pressure, overlaps.

use std::f64::consts::PI;

use carom::{
    CellsPerSide, CollisionRate, CollisionReport, Detection, EnergyLedger, HeapScheduler, Impact,
    Observer, OverlapCheck, Scene, Simulation,
    detection::{Answer, Outcome},
    engine::{BumperSpec, ElasticitySpec, GasSpec},
    geometry::Outline,
    kinematics::RelativeMotion,
    observers::Pressure,
};
use glam::DVec2;

use super::{ByHand, disc, gas, observe, tee};

#[test]
fn energy_and_momentum_of_an_elastic_gas_are_conserved() {
    let mut scene = Scene {
        molecule: vec![tee(DVec2::new(0.5, 0.5), 0.7)],
        ..Scene::default()
    };
    scene.gas.push(gas("gas", 200));
    let mut simulation = Simulation::new(&scene).unwrap();
    let mut ledger = EnergyLedger::default();
    ledger.sample(&simulation.view());
    observe(&mut simulation, &mut ledger, 10.0, 20);
    assert!(simulation.view().counters().collisions > 10_000);
    assert!(ledger.drift() <= 1e-13, "{:e}", ledger.drift());
    let first = ledger.series()[0];
    assert_eq!((first.time, first.booked), (0.0, first.energy));
    assert!((first.energy - 200.0).abs() < 1e-10);
    for point in ledger.series() {
        assert_eq!(point.booked, first.booked);
        assert!(
            (point.momentum - first.momentum).length() < 1e-11,
            "{point:?}"
        );
    }
}

#[test]
fn losses_at_contacts_and_resets_agree_with_the_ledger() {
    let elasticity = ElasticitySpec {
        default: 0.9,
        ..ElasticitySpec::default()
    };
    let mut scene = Scene {
        elasticity,
        ..Scene::default()
    };
    scene.gas.push(gas("gas", 200));
    let mut simulation = Simulation::new(&scene).unwrap();
    // Equal discs of mass 1: μ = 1/2, and the loss is ½ (1 − e²) μ u².
    let by_hand = ByHand(Vec::new(), |report: &CollisionReport<'_>| {
        let [a, b] = &report.sides;
        let approach = (a.before.velocity - b.before.velocity).dot(report.normal);
        // 0.9, or a higher value if the guard against collapse has raised it.
        let e = report.elasticity.coefficient();
        Some(0.5 * (1.0 - e * e) * 0.5 * approach * approach)
    });
    let mut observers = (EnergyLedger::default(), by_hand);
    observers.sample(&simulation.view());
    observe(&mut simulation, &mut observers, 2.0, 10);
    let lost: f64 = observers.1.0.iter().sum();
    let (first, last) = (
        observers.0.series()[0],
        *observers.0.series().last().unwrap(),
    );
    assert!(lost > 0.3 * first.energy, "{lost} of {}", first.energy);
    assert!((first.energy - last.energy - lost).abs() < 1e-13 * first.energy);
    assert!((first.booked - last.booked - lost).abs() < 1e-13 * first.energy);
    let gas = simulation.find_tag("gas").unwrap();
    simulation.reset_energy_of_tag(gas, 1.0).unwrap();
    observers.sample(&simulation.view());
    let last = observers.0.series().last().unwrap();
    assert!(
        (last.energy - 200.0).abs() < 1e-11 && (last.booked - 200.0).abs() < 1e-11,
        "{last:?}"
    );
    assert!(observers.0.drift() <= 1e-13, "{:e}", observers.0.drift());
}

#[test]
fn an_empty_box_has_no_drift_rate_or_pressure() {
    let simulation = Simulation::new(&Scene::default()).unwrap();
    let mut observers = (
        EnergyLedger::default(),
        CollisionRate::default(),
        Pressure::default(),
    );
    assert_eq!(observers.0.drift(), 0.0);
    for _ in 0..3 {
        observers.sample(&simulation.view());
    }
    assert_eq!(observers.0.drift(), 0.0);
    assert_eq!((observers.1.mean(), observers.2.mean()), (None, None));
}

#[test]
fn a_disc_between_images_of_a_bumper_hits_at_even_times() {
    // From contact to contact it moves by 1 − 2 (0.05 + 0.05) at speed 1: one collision in each
    // 0.8, ten in each 8. Each adds r·J = 0.1 × 2 to the virial:
    // p A = 1/2 + (1/2) 0.2 / 0.8 = 0.625.
    let mut scene = Scene {
        molecule: vec![disc(DVec2::new(0.2, 0.5), DVec2::X, 0.05, 1.0)],
        ..Scene::default()
    };
    scene.bumper.push(BumperSpec {
        tags: vec![],
        radius: 0.05,
        at: [0.7, 0.5],
    });
    let mut simulation = Simulation::new(&scene).unwrap();
    let mut observers = (CollisionRate::default(), Pressure::default());
    observe(&mut simulation, &mut observers, 24.0, 3);
    let (rate, pressure) = observers;
    assert_eq!(rate.series().len(), 3);
    for (index, point) in rate.series().iter().enumerate() {
        let expected = (8.0 * (index + 1) as f64, 10, 1.25);
        assert_eq!((point.time, point.collisions, point.rate), expected);
    }
    assert_eq!(rate.mean(), Some((1.25, 0.0)));
    let (mean, error) = pressure.mean().unwrap();
    assert!(
        (mean - 0.625).abs() < 1e-12 && error < 1e-12,
        "{mean} ± {error}"
    );
}

#[test]
fn collision_rate_and_pressure_of_hard_discs_are_those_of_kinetic_theory() {
    // At area fraction 0.1 the virial series gives χ = 1.181 (Clisby & McCoy, J. Stat. Phys. 122
    // (2006) 15: Z = 1.2361 = 1 + 2 η χ), and a system of fixed N has (1 − 0.91/N) of it (Lebowitz
    // & Percus, Phys. Rev. 124 (1961) 1673). kT = E/(N − 1) at total momentum 0. The pressure has N
    // kT from the motion and N − 1 times 2 η χ kT from the contacts, as each disc has N − 1 others;
    // see the tests of two and of 72 discs.
    let (count, radius, eta) = (400, 0.5, 0.1);
    let side = (f64::from(count) * PI * radius * radius / eta).sqrt();
    let mut scene = Scene::default();
    (scene.bounds.sides, scene.bounds.seed) = ([side; 2], 20_170_131);
    scene.gas.push(GasSpec {
        radius: Some(radius.into()),
        mass: Some(1.0.into()),
        energy: 1.0,
        count: Some(count as usize),
        zero_momentum: Some(true),
        ..GasSpec::default()
    });
    let mut simulation = Simulation::new(&scene).unwrap();
    // About fifty collisions per disc, after which the lattice and the equal speeds are forgotten.
    simulation.run_until(100.0).unwrap();
    let mut observers = (CollisionRate::default(), Pressure::default());
    // Half a million collisions: standard errors of about 0.13 % for the rate and 0.04 % for the
    // pressure.
    observe(&mut simulation, &mut observers, 4900.0, 60);
    let (rate, error) = observers.0.mean().unwrap();

    let n = f64::from(count) / (side * side);
    let temperature = simulation.view().temperature().unwrap();
    assert!((temperature * f64::from(count - 1) / simulation.view().energy() - 1.0).abs() < 1e-12);
    let chi = 1.181 * (1.0 - 0.91 / f64::from(count));
    let predicted = 2.0 * n * (2.0 * radius) * chi * (PI * temperature).sqrt();
    assert!(error < 0.002 * predicted, "{error}");
    assert!(
        (rate - predicted).abs() < 4.0 * error + 0.001 * predicted,
        "{rate} ± {error}, predicted {predicted}"
    );

    let (pressure, error) = observers.1.mean().unwrap();
    let contacts = f64::from(count - 1) * 2.0 * eta * chi;
    let predicted = n * temperature * (1.0 + contacts / f64::from(count));
    assert!(error < 0.001 * predicted, "{error}");
    assert!(
        (pressure - predicted).abs() < 4.0 * error + 3e-4 * predicted,
        "{pressure} ± {error}, {predicted}"
    );
}

/// (Z − 1)/η of a gas of dumbbells at area fraction η, and its standard error.
fn virial_of_dumbbells(area_fraction: f64) -> (f64, f64) {
    let count = 300;
    let side = (f64::from(count) * 2.0 * PI * 0.25 / area_fraction).sqrt();
    let mut scene = Scene::default();
    scene.bounds.sides = [side; 2];
    scene.gas.push(GasSpec {
        shape: Some("dumbbell".into()),
        zero_momentum: Some(true),
        ..GasSpec {
            radius: Some(0.5.into()),
            ..gas("gas", count as usize)
        }
    });
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.run_until(2.0 / area_fraction).unwrap();
    let mut pressure = Pressure::default();
    observe(&mut simulation, &mut pressure, 302.0 / area_fraction, 50);
    // Total momentum 0 removes two of the 3N degrees of freedom, from translation: N − 1 times kT.
    let n = f64::from(count);
    let translation = simulation.view().energy() * (2.0 * n - 2.0) / (3.0 * n - 2.0);
    let points = pressure.series();
    let mean = points.iter().map(|point| point.virial).sum::<f64>() / 50.0;
    let squares: f64 = points
        .iter()
        .map(|point| (point.virial - mean).powi(2))
        .sum();
    let kinetic = points.iter().map(|point| point.kinetic).sum::<f64>() / 50.0;
    assert!(
        (kinetic * side * side / translation - 1.0).abs() < 0.03,
        "{kinetic}"
    );
    let scale = side * side / translation / area_fraction;
    (mean * scale, (squares / 49.0 / 50.0).sqrt() * scale)
}

#[test]
fn pressure_of_dumbbells_has_their_second_virial_coefficient() {
    // Half the area that a tangent dumbbell excludes for another, averaged over all orientations,
    // is 2.42064 times its own area (plane geometry): (Z − 1)/η approaches this value linearly as η
    // goes to 0.
    let [thin, thick] = [0.02, 0.04].map(virial_of_dumbbells);
    let limit = 2.0 * thin.0 - thick.0;
    let error = (4.0 * thin.1 * thin.1 + thick.1 * thick.1).sqrt();
    assert!(
        error < 0.02 * 2.42 && (limit - 2.420_64).abs() < 3.0 * error + 0.01,
        "{limit} ± {error}"
    );
    assert!(thick.0 > thin.0, "{thick:?} is not above {thin:?}");
}

/// A detector that never finds a contact.
#[derive(Clone)]
struct Blind;

impl Detection for Blind {
    fn first_contact(&self, _: Outline<'_>, _: Outline<'_>, _: &RelativeMotion, _: f64) -> Answer {
        Answer {
            outcome: Outcome::Free,
            evaluations: 0,
        }
    }
}

#[test]
fn overlaps_left_by_a_detector_without_contacts_are_found() {
    let molecule = vec![
        disc(DVec2::new(0.3, 0.5), DVec2::X, 0.05, 1.0),
        disc(DVec2::new(0.5, 0.5), DVec2::ZERO, 0.05, 1.0),
        disc(DVec2::new(0.98, 0.2), DVec2::X, 0.02, 1.0),
        disc(DVec2::new(0.12, 0.2), DVec2::ZERO, 0.04, 1.0),
    ];
    let scene = Scene {
        molecule,
        ..Scene::default()
    };
    let mut overlaps = OverlapCheck::default();
    let mut blind: Simulation<Blind, Impact, HeapScheduler> =
        Simulation::with(&scene, Blind, Impact, CellsPerSide::default()).unwrap();
    for (time, pairs) in [(0.05, 0), (0.15, 2), (0.3, 0)] {
        blind.run_until(time).unwrap();
        overlaps.sample(&blind.view());
        assert_eq!(blind.view().overlaps().pairs, pairs, "at {time}");
    }
    // At 0.15 the first pair is at distance 0.05, with diameter 0.1; the second at distance 0.01
    // across the border, with contact distance 0.06.
    assert_eq!((overlaps.checks(), overlaps.worst_pairs()), (3, 2));
    assert!(
        (overlaps.deepest() - 0.05 / 0.04).abs() < 1e-12,
        "{}",
        overlaps.deepest()
    );
    assert!(
        (overlaps.deepest_length() - 0.05).abs() < 1e-14,
        "{}",
        overlaps.deepest_length()
    );

    let mut overlaps = OverlapCheck::default();
    let mut seeing = Simulation::new(&scene).unwrap();
    observe(&mut seeing, &mut overlaps, 0.3, 6);
    assert_eq!((overlaps.checks(), overlaps.worst_pairs()), (6, 0));
    assert!(overlaps.deepest() < 1e-12);
}
