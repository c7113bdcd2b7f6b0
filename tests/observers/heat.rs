//! The thermostat ledger: hot and cold resets against sums by hand.

use carom::{
    CollisionReport, Observer, Scene, Simulation,
    engine::{DrawKey, ElasticitySpec, Tag, ThermostatRule, ThermostatTarget},
    observers::{HeatOfTag, ThermostatLedger},
};

use super::{ByHand, gas, observe};

const KEY: DrawKey = DrawKey {
    seed: 1,
    replica: 0,
    action: 0,
};

#[test]
fn heat_from_hot_to_cold_agrees_with_sums_by_hand_to_rounding() {
    let elasticity = ElasticitySpec {
        default: 0.95,
        ..ElasticitySpec::default()
    };
    let mut scene = Scene {
        elasticity,
        ..Scene::default()
    };
    scene
        .gas
        .extend([gas("hot", 60), gas("cold", 60), gas("between", 80)]);
    let mut simulation = Simulation::new(&scene).unwrap();
    let tag = |name: &str| simulation.find_tag(name).unwrap();
    let (hot, cold) = (tag("hot"), tag("cold"));
    // Equal discs of mass 1: μ = ½, and the loss is ½ (1 − e²) μ u².
    let loss = ByHand(Vec::new(), |report: &CollisionReport<'_>| {
        let [a, b] = &report.sides;
        let approach = (a.before.velocity - b.before.velocity).dot(report.normal);
        // 0.95, or 1 for the one or two contacts that the guard against collapse makes elastic.
        let e = report.elasticity.coefficient();
        Some(0.5 * (1.0 - e * e) * 0.5 * approach * approach)
    });
    let mut observers = (ThermostatLedger::default(), loss);
    let energy_of = |simulation: &Simulation, tag: Tag| -> f64 {
        simulation
            .view()
            .tagged(tag)
            .map(|body| body.energy())
            .sum()
    };
    let initial = simulation.view().energy();
    observers.0.sample(&simulation.view());
    assert_eq!(
        (observers.0.mean_power(), observers.0.imbalance()),
        (None, 0.0)
    );
    let (mut heated, mut cooled) = (0.0, 0.0);
    for _ in 0..20 {
        // A sample after each reset records it separately, in an interval of length 0.
        let until = simulation.time().to_f64() + 0.1;
        observe(&mut simulation, &mut observers, until, 1);
        heated += 60.0 * 4.0 - energy_of(&simulation, hot);
        simulation.reset_energy_of_tag(hot, 4.0).unwrap();
        observers.0.sample(&simulation.view());
        cooled += 60.0 * 0.25 - energy_of(&simulation, cold);
        simulation.reset_energy_of_tag(cold, 0.25).unwrap();
        observers.0.sample(&simulation.view());
    }
    let (ledger, ByHand(losses, _)) = observers;
    let lost: f64 = losses.iter().sum();
    assert!(
        losses.len() > 1000 && lost > 1.0,
        "{} contacts took {lost}",
        losses.len()
    );
    // The largest amount in the ledger determines the last digit.
    let near = |found: f64, expected: f64| (found - expected).abs() < 1e-12 * (heated + lost);
    let put_in = |step: usize| {
        ledger
            .series()
            .iter()
            .skip(step)
            .step_by(3)
            .map(|point| point.put_in)
            .sum::<f64>()
    };
    assert_eq!((ledger.series().len(), put_in(0)), (60, 0.0));
    assert!(
        heated > 0.0 && near(put_in(1), heated),
        "{} against {heated}",
        put_in(1)
    );
    assert!(
        cooled < 0.0 && near(put_in(2), cooled),
        "{} against {cooled}",
        put_in(2)
    );
    assert!(near(ledger.total_put_in(), heated + cooled) && near(ledger.total_lost(), lost));
    assert!(near(
        simulation.view().energy() - initial,
        heated + cooled - lost
    ));
    assert!(ledger.imbalance() < 1e-12, "{:e}", ledger.imbalance());
    for (index, point) in ledger.series().iter().enumerate() {
        let flown = index % 3 == 0;
        assert_eq!(
            (point.power().is_some(), point.lost > 0.0),
            (flown, flown),
            "{point:?}"
        );
        assert!(
            point
                .dissipation()
                .is_none_or(|rate| (rate * 0.1 - point.lost).abs() < 1e-9)
        );
    }
    assert!((ledger.mean_power().unwrap() - f64::midpoint(heated, cooled)).abs() < 1e-9);
}

#[test]
fn the_ledger_begins_at_the_first_sample() {
    let mut scene = Scene::default();
    scene.gas.push(gas("gas", 50));
    let mut simulation = Simulation::new(&scene).unwrap();
    let gas = simulation.find_tag("gas").unwrap();
    simulation.reset_energy_of_tag(gas, 2.0).unwrap();
    let mut ledger = ThermostatLedger::default();
    assert_eq!(
        (
            ledger.total_put_in(),
            ledger.total_lost(),
            ledger.imbalance()
        ),
        (0.0, 0.0, 0.0)
    );
    ledger.sample(&simulation.view());
    observe(&mut simulation, &mut ledger, 1.0, 4);
    simulation.reset_energy_of_tag(gas, 1.0).unwrap();
    // Recorded only at the next sample, in the interval that begins now.
    observe(&mut simulation, &mut ledger, 2.0, 4);
    let put_in: Vec<f64> = ledger.series().iter().map(|point| point.put_in).collect();
    let near = |found: f64, expected: f64| (found - expected).abs() < 1e-11;
    assert!(
        put_in
            .iter()
            .zip([0.0, 0.0, 0.0, 0.0, -50.0, 0.0, 0.0, 0.0])
            .all(|(&found, expected)| near(found, expected))
    );
    assert!(
        near(ledger.mean_power().unwrap(), -25.0)
            && near(ledger.series()[4].power().unwrap(), -200.0)
    );
    assert_eq!(ledger.total_lost(), 0.0);
}

/// Actions every 0.3 that give each disc the energy 1, and samples every 0.2: an interval between
/// samples holds none or one action, but those between actions hold one each.
#[test]
fn heat_is_counted_between_actions() {
    let mut scene = Scene::default();
    scene.gas.push(gas("gas", 50));
    let mut simulation = Simulation::new(&scene).unwrap();
    let gas = simulation.find_tag("gas").unwrap();
    let mut ledger = ThermostatLedger::default();
    ledger.start(&simulation.view());
    ledger.sample(&simulation.view());
    let (mut actions, mut samples) = (0, 0);
    for step in 1..=60 {
        simulation
            .observe_until(0.1 * f64::from(step), &mut ledger)
            .unwrap();
        if step % 3 == 0 {
            actions += 1;
            ledger.pause(&simulation.view());
            let target = ThermostatTarget::Energy(1.0 + f64::from(actions));
            let rule = ThermostatRule::EnergyReset(target);
            simulation
                .edit(|batch| batch.thermostat(gas, &rule, KEY))
                .unwrap();
            ledger.start(&simulation.view());
        }
        if step % 2 == 0 {
            samples += 1;
            ledger.sample(&simulation.view());
            let expected = (actions > 1).then(|| f64::from(actions - 1));
            let found = ledger.heats().first().and_then(HeatOfTag::between_actions);
            let is_near = |[heat, time]: [f64; 2], count: f64| {
                (heat - 50.0 * count).abs() < 1e-9 && (time - 0.3 * count).abs() < 1e-12
            };
            assert_eq!(found.is_some(), expected.is_some(), "{step}");
            assert!(
                found
                    .zip(expected)
                    .is_none_or(|(found, count)| is_near(found, count)),
                "{found:?}"
            );
        }
    }
    let [lost, time] = ledger.lost_until_action();
    assert!(actions == 20 && samples == 30 && lost == 0.0 && (time - 6.0).abs() < 1e-12);
}
