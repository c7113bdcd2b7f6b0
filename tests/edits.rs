//! Edits take effect at the time of the sample: each has a known consequence.

use crate::support::{
    disc, head_on, named, reference_scene, rule, scene, simulate, test_each_scheduler, velocity,
};
use carom_detection::Exact;
use carom_engine::{
    DrawKey, EditError, ElasticitySpec, MoleculeSpec, Rotation, Scheduler, SelfPropulsion,
    Simulation, ThermostatRule,
};
use carom_response::Impact;
use glam::DVec2;

test_each_scheduler! {
    a_predicted_contact_uses_an_elasticity_set_after_its_prediction: check_elasticity;
    a_rule_applies_while_a_body_carries_its_tag: check_tags;
    an_added_disc_is_hit_and_a_removed_one_is_not: check_coming_and_going;
    a_batch_is_equivalent_to_single_edits_and_starts_one_epoch: check_batches;
    energy_is_reset_to_the_last_bits: check_energy_resets;
    a_disc_with_more_energy_meets_its_partner_earlier: check_faster;
    a_reversed_run_repeats_its_contacts_in_reverse: check_reversal;
    a_locked_molecule_does_not_turn_and_a_freed_one_does: check_locking;
    edits_reset_no_counter: check_counters;
    a_thermostat_and_an_exchange_of_bodies_are_one_transaction: check_thermostat_with_exchange;
    discs_keep_the_axes_of_self_propulsion: check_axes;
}

/// Two discs that meet, and the axes along which a rule drives them.
fn check_axes<S: Scheduler>(options: &S::Options) {
    let mut simulation = head_on::<S>(options);
    let axes = |simulation: &Simulation<Exact, Impact, S>| -> Vec<Option<f64>> {
        let view = simulation.view();
        let axis = |key| view.axis(key).map(carom_kinematics::Orientation::turns);
        view.bodies().map(|body| axis(body.body.key())).collect()
    };
    assert_eq!(axes(&simulation), [None, None]);
    let left = simulation.find_tag("left").unwrap();
    let rule = ThermostatRule::Active(SelfPropulsion {
        speed: 1.0,
        rotational_diffusion: 1.0,
        translational_diffusion: 0.0,
        every: 0.1,
    });
    let mut before = None;
    for action in 0..20 {
        let key = DrawKey {
            seed: 1,
            replica: 0,
            action,
        };
        simulation
            .edit(|batch| batch.thermostat(left, &rule, key))
            .unwrap();
        let turned = axes(&simulation);
        assert!(turned[0].is_some() && turned[0] != before && turned[1].is_none());
        let axis = carom_kinematics::Orientation::from_turns(turned[0].unwrap());
        assert_eq!(velocity(&simulation.view(), 0), axis.cos_sin());
        simulation.run_until(0.1 * (action + 1) as f64).unwrap();
        simulation.end_epoch_here();
        assert_eq!(axes(&simulation), turned);
        before = turned[0];
    }
    // Another body keeps its axis when one is removed.
    let keys: Vec<_> = simulation
        .view()
        .bodies()
        .map(|body| body.body.key())
        .collect();
    simulation.tag(keys[1], "left").unwrap();
    let key = DrawKey {
        seed: 1,
        replica: 0,
        action: 20,
    };
    simulation
        .edit(|batch| batch.thermostat(left, &rule, key))
        .unwrap();
    let both = axes(&simulation);
    simulation.remove(keys[0]).unwrap();
    assert_eq!(axes(&simulation), [both[1]]);
}

fn check_elasticity<S: Scheduler>(options: &S::Options) {
    for (e, at) in [(0.0, 1.0), (0.5, 1.999), (1.5, 0.0)] {
        let mut simulation = head_on::<S>(options);
        simulation.run_until(at).unwrap();
        simulation
            .set_elasticity(&ElasticitySpec {
                default: e,
                ..ElasticitySpec::default()
            })
            .unwrap();
        simulation.run_until(2.5).unwrap();
        // At e = 0 discs separate at a speed above the rounding of velocities, so that they do not
        // sink into each other.
        for (index, expected) in [(0, -e), (1, e)] {
            let off = (velocity(&simulation.view(), index) - DVec2::new(expected, 0.0)).length();
            assert!(
                off <= if e == 0.0 { 1e-15 } else { 0.0 },
                "e = {e}: off by {off:e}"
            );
        }
        assert!((simulation.view().ledger().lost - (1.0 - e * e)).abs() < 1e-15);
    }
}

fn check_tags<S: Scheduler>(options: &S::Options) {
    let rules = ElasticitySpec {
        pair: vec![
            rule(&["sticky"], 0.5),
            rule(&["left", "sticky"], 0.0),
            rule(&["left", "right"], 0.25),
        ],
        ..ElasticitySpec::default()
    };
    // The tags of the second disc at the contact, and the ratio of the speeds after and before it.
    for (names, untagged, e) in [
        (vec![], None, 1.0),
        (vec!["right"], None, 0.25),
        // The rule for the pair of tags overrides that for the single tag.
        (vec!["sticky"], None, 0.0),
        (vec!["sticky"], Some("sticky"), 1.0),
        (vec!["right"], Some("sticky"), 0.25),
        (vec!["plain"], None, 1.0),
    ] {
        let mut simulation = head_on::<S>(options);
        let right = simulation.view().bodies().nth(1).unwrap().body.key();
        simulation.set_elasticity(&rules).unwrap();
        simulation.run_until(1.0).unwrap();
        for name in &names {
            let tag = simulation.tag(right, name).unwrap();
            assert!(
                simulation
                    .view()
                    .tagged(tag)
                    .any(|view| view.body.key() == right)
            );
        }
        if let Some(name) = untagged {
            simulation.untag(right, name).unwrap();
        }
        simulation.run_until(3.0).unwrap();
        let off = (velocity(&simulation.view(), 1) - DVec2::new(e, 0.0)).length();
        assert!(
            off <= if e == 0.0 { 1e-15 } else { 0.0 },
            "{names:?}: off by {off:e}"
        );
    }

    // The rule for the single tag applies where that for the pair does not.
    let mut simulation = head_on::<S>(options);
    let keys: Vec<_> = simulation
        .view()
        .bodies()
        .map(|view| view.body.key())
        .collect();
    simulation.set_elasticity(&rules).unwrap();
    simulation.untag(keys[0], "left").unwrap();
    simulation.tag(keys[1], "sticky").unwrap();
    simulation.run_until(3.0).unwrap();
    assert_eq!(velocity(&simulation.view(), 1), DVec2::new(0.5, 0.0));
}

fn check_coming_and_going<S: Scheduler>(options: &S::Options) {
    // Added in the path of the left disc at time 1: the gap of their surfaces is 0.5.
    let mut simulation = head_on::<S>(options);
    simulation.run_until(1.0).unwrap();
    let wall = MoleculeSpec {
        fixed: true,
        ..disc(0.5, 1.0, [10.0, 5.0], [0.0; 2])
    };
    let wall = simulation.add(&wall).unwrap();
    simulation.run_until(1.5).unwrap();
    // Both discs touch it at exactly this time, which belongs to the run.
    assert_eq!(simulation.view().counters().collisions, 2);
    assert_eq!(velocity(&simulation.view(), 0), DVec2::NEG_X);
    assert_eq!(velocity(&simulation.view(), 1), DVec2::X);

    // After its removal the wall is not found any more, and the discs meet through the border at
    // time 10.
    simulation.remove(wall).unwrap();
    assert_eq!(simulation.remove(wall), Err(EditError::NoSuchBody(wall)));
    assert!(simulation.view().body(wall).is_none());
    simulation.run_until(9.999).unwrap();
    assert_eq!(simulation.view().counters().collisions, 2);
    simulation.run_until(10.001).unwrap();
    assert_eq!(simulation.view().counters().collisions, 3);
    assert_eq!(simulation.view().ledger().put_in, 0.0);

    // The partner of a predicted contact is removed, and another body is added far away in its
    // slot: the predicted contact must not happen.
    let mut simulation = head_on::<S>(options);
    simulation.run_until(1.0).unwrap();
    let partner = simulation.view().bodies().nth(1).unwrap().body.key();
    simulation.remove(partner).unwrap();
    assert_eq!(simulation.view().ledger().put_in, -0.5);
    let newcomer = simulation
        .add(&disc(0.5, 1.0, [2.0, 2.0], [0.0; 2]))
        .unwrap();
    assert_ne!(newcomer, partner);
    assert_eq!(
        simulation.reset_energy(partner, 1.0),
        Err(EditError::NoSuchBody(partner))
    );
    simulation.run_until(8.0).unwrap();
    assert_eq!(simulation.view().counters().collisions, 0);
    assert_eq!(
        simulation.view().bodies().next().unwrap().motion.position,
        DVec2::new(15.5, 5.0)
    );
    let ids: Vec<u64> = simulation
        .view()
        .bodies()
        .map(|view| view.body.id())
        .collect();
    assert_eq!(ids, [0, 2]);
}

fn check_batches<S: Scheduler>(options: &S::Options) {
    let scene = reference_scene(8);
    let start = || {
        let mut simulation = simulate::<S>(&scene, options);
        simulation.run_until(0.3).unwrap();
        simulation
    };
    let (mut at_once, mut one_by_one) = (start(), start());
    let keys: Vec<_> = at_once
        .view()
        .bodies()
        .map(|view| view.body.key())
        .collect();
    let fixed = at_once
        .view()
        .bodies()
        .find(|view| view.body.is_fixed())
        .unwrap()
        .body
        .key();
    let leaver = at_once.view().body(keys[0]).unwrap().motion.position;
    let seeds: Vec<MoleculeSpec> = (0..40)
        .map(|n| {
            disc(
                1e-4,
                1.0,
                (leaver + 3e-4 * DVec2::new(f64::from(n % 7), f64::from(n / 7))).to_array(),
                [1.0, 0.5],
            )
        })
        .collect();
    // The new bodies are placed where a body was that the same batch removes; some do not fit and
    // are not added.
    let added = at_once
        .edit(|batch| {
            batch.remove(keys[0])?;
            batch.remove(fixed)?;
            let added: Vec<_> = seeds
                .iter()
                .filter_map(|seed| batch.add(seed).ok())
                .collect();
            batch.tag(added[0], "seed")?;
            batch.tag(keys[3], "seed")?;
            batch.reset_energy(keys[10], 2.0)?;
            batch.set_rotation(keys[10], Rotation::Locked)?;
            batch.set_elasticity(&ElasticitySpec {
                default: 0.9,
                ..ElasticitySpec::default()
            })?;
            Ok(added)
        })
        .unwrap();
    assert!(added.len() >= 20, "{}", added.len());
    one_by_one.remove(keys[0]).unwrap();
    one_by_one.remove(fixed).unwrap();
    let alone: Vec<_> = seeds
        .iter()
        .filter_map(|seed| one_by_one.add(seed).ok())
        .collect();
    one_by_one.tag(alone[0], "seed").unwrap();
    one_by_one.tag(keys[3], "seed").unwrap();
    one_by_one.reset_energy(keys[10], 2.0).unwrap();
    one_by_one.set_rotation(keys[10], Rotation::Locked).unwrap();
    one_by_one
        .set_elasticity(&ElasticitySpec {
            default: 0.9,
            ..ElasticitySpec::default()
        })
        .unwrap();
    assert_eq!(added, alone);
    assert!((at_once.view().ledger().put_in - one_by_one.view().ledger().put_in).abs() < 1e-12);
    let begun = at_once.view().counters().epochs;
    assert!(at_once.step(1.0, &mut ()).unwrap() && one_by_one.step(1.0, &mut ()).unwrap());
    assert_eq!(at_once.view().counters().epochs, begun + 1);
    for simulation in [&mut at_once, &mut one_by_one] {
        simulation.run_until(1.0).unwrap();
    }
    assert!(at_once.view().counters().collisions > 20);
    assert_eq!(
        crate::support::bits(&at_once.view()),
        crate::support::bits(&one_by_one.view())
    );
    let ids = |simulation: &Simulation<Exact, Impact, S>| -> Vec<u64> {
        simulation
            .view()
            .bodies()
            .map(|view| view.body.id())
            .collect()
    };
    assert_eq!(ids(&at_once), ids(&one_by_one));
    let seed = at_once.find_tag("seed").unwrap();
    let tagged: Vec<_> = at_once
        .view()
        .tagged(seed)
        .map(|view| view.body.key())
        .collect();
    assert_eq!(tagged, [keys[3], added[0]]);
}

#[test]
fn equal_bodies_share_their_description_after_many_edits_in_a_batch() {
    // A thousand discs are added to an empty box, at different positions, and half of them are
    // removed.
    let mut simulation = simulate::<carom_engine::CellScheduler>(
        &scene(Vec::new()),
        &carom_engine::Instructions::Widest,
    );
    let sides = simulation.view().bounds().sides();
    let place = |n: u32| {
        (sides * DVec2::new(f64::from(n % 50) / 50.0, f64::from(n / 50) / 50.0)).to_array()
    };
    let radius = 0.004 * sides.min_element();
    let keys = simulation
        .edit(|batch| {
            let keys: Vec<_> = (0..1000)
                .map(|n| batch.add(&disc(radius, 1.0, place(n), [1.0, 0.3])))
                .collect::<Result<_, _>>()?;
            keys.iter()
                .step_by(2)
                .try_for_each(|&key| batch.remove(key))?;
            keys.iter()
                .skip(1)
                .step_by(2)
                .try_for_each(|&key| batch.tag(key, "left over").map(|_| ()))?;
            Ok(keys)
        })
        .unwrap();
    let view = simulation.view();
    assert_eq!((view.len(), view.overlaps().pairs), (500, 0));
    assert!((view.ledger().put_in - view.energy()).abs() < 1e-13 * view.energy());
    let tag = simulation.find_tag("left over").unwrap();
    assert!(
        view.tagged(tag)
            .map(|view| view.body.key())
            .eq(keys.iter().skip(1).step_by(2).copied())
    );
    simulation.run_until(1.0).unwrap();
    assert_eq!(simulation.view().counters().epochs, 1);
}

fn check_energy_resets<S: Scheduler>(options: &S::Options) {
    let mut simulation = simulate::<S>(&reference_scene(5), options);
    let mut turnover = simulation.view().energy();
    for (round, energy) in [1.0, 0.1, 3.7e-9, 2.5e7, 1.0 / 3.0].into_iter().enumerate() {
        simulation.run_until(0.01 * round as f64).unwrap();
        let bodies: Vec<_> = simulation
            .view()
            .bodies()
            .map(|view| (view.body.key(), view.motion))
            .collect();
        for (key, before) in bodies {
            let present = simulation.view().body(key).unwrap();
            if present.body.is_fixed() {
                assert!(
                    matches!(simulation.reset_energy(key, energy), Err(EditError::Fixed(name)) if name.key == key)
                );
                continue;
            }
            if present.energy() == 0.0 {
                assert!(
                    matches!(simulation.reset_energy(key, energy), Err(EditError::NoEnergy(name)) if name.key == key)
                );
                continue;
            }
            simulation.reset_energy(key, energy).unwrap();
            let view = simulation.view();
            let after = view.body(key).unwrap();
            assert!((after.energy() - energy).abs() <= 4.0 * f64::EPSILON * energy);
            // Directions and the shares of translation and rotation remain.
            assert!(
                before.velocity.perp_dot(after.motion.velocity).abs()
                    <= 1e-15 * before.velocity.length() * after.motion.velocity.length()
            );
            assert!(before.velocity.dot(after.motion.velocity) >= 0.0);
            let ratio = after.motion.velocity.length() / before.velocity.length();
            let spin = ratio * before.angular_velocity;
            assert!((after.motion.angular_velocity - spin).abs() <= 1e-14 * spin.abs());
        }
        let view = simulation.view();
        turnover += view.energy();
        assert!((view.energy() - view.ledger().booked()).abs() <= 1e-12 * turnover);
    }
}

fn check_faster<S: Scheduler>(options: &S::Options) {
    let mut simulation = head_on::<S>(options);
    simulation.run_until(1.0).unwrap();
    let left = simulation.view().bodies().next().unwrap().body.key();
    // The speed changes from 1 to 7: the gap of 2 closes at relative speed 8.
    simulation.reset_energy(left, 24.5).unwrap();
    assert!(simulation.step(10.0, &mut ()).unwrap());
    assert!((simulation.time().to_f64() - 1.25).abs() < 1e-15);
    assert!((velocity(&simulation.view(), 1) - DVec2::new(7.0, 0.0)).length() < 1e-14);
    assert!((simulation.view().ledger().put_in - 24.0).abs() < 1e-14);

    // All bodies of a tag change together, or none if one of them is refused.
    let mut simulation = head_on::<S>(options);
    let keys: Vec<_> = simulation
        .view()
        .bodies()
        .map(|view| view.body.key())
        .collect();
    let tag = simulation.tag(keys[1], "left").unwrap();
    simulation.reset_energy_of_tag(tag, 2.0).unwrap();
    assert_eq!(simulation.view().energy(), 4.0);
    let idle = simulation
        .add(&disc(0.1, 1.0, [1.0, 1.0], [0.0; 2]))
        .unwrap();
    simulation.tag(idle, "left").unwrap();
    assert!(
        matches!(simulation.reset_energy_of_tag(tag, 1.0), Err(EditError::NoEnergy(name)) if name.key == idle)
    );
    assert_eq!(simulation.view().energy(), 4.0);

    // Fixed bodies have no energy and are skipped; all others are reset.
    simulation.remove(idle).unwrap();
    let fixed = MoleculeSpec {
        fixed: true,
        ..disc(0.1, 1.0, [1.0, 1.0], [0.0; 2])
    };
    let fixed = simulation.add(&fixed).unwrap();
    simulation.tag(fixed, "left").unwrap();
    simulation.reset_energy_of_tag(tag, 0.5).unwrap();
    assert_eq!(simulation.view().energy(), 1.0);
    simulation.reset_energy_of_all(3.0).unwrap();
    assert!((simulation.view().energy() - 6.0).abs() < 1e-14);
    assert!((simulation.view().ledger().put_in - 5.0).abs() < 1e-14);
}

fn check_reversal<S: Scheduler>(options: &S::Options) {
    // They meet at time 2, and again on the way back.
    let mut simulation = head_on::<S>(options);
    simulation.run_until(2.5).unwrap();
    simulation.reverse();
    simulation.run_until(5.0).unwrap();
    let view = simulation.view();
    assert_eq!(view.counters().collisions, 2);
    assert_eq!(velocity(&view, 0), DVec2::new(-1.0, 0.0));
    let x: Vec<f64> = view.bodies().map(|body| body.motion.position.x).collect();
    assert!(
        (x[0] - 7.5).abs() < 1e-14 && (x[1] - 12.5).abs() < 1e-14,
        "{x:?}"
    );
    assert_eq!(view.ledger().put_in, 0.0);

    // Angular velocities too: all collisions in a reference scene of molecules are reversed.
    let mut simulation = simulate::<S>(&reference_scene(7), options);
    let places = |simulation: &Simulation<Exact, Impact, S>| -> Vec<DVec2> {
        simulation
            .view()
            .bodies()
            .map(|body| body.motion.position)
            .collect()
    };
    let start = places(&simulation);
    let mut time = 0.0;
    while simulation.view().counters().collisions < 5 {
        time += 0.01;
        simulation.run_until(time).unwrap();
    }
    simulation.reverse();
    simulation.run_until(2.0 * time).unwrap();
    assert!(simulation.view().counters().collisions >= 10);
    for (end, start) in places(&simulation).into_iter().zip(start) {
        assert!((end - start).length() < 1e-9, "{end} {start}");
    }
}

fn check_locking<S: Scheduler>(options: &S::Options) {
    // A dumbbell turns without translation; its arm points at a resting disc after a quarter turn.
    let spinning = MoleculeSpec {
        orientation_turns: Some(0.25),
        angular_velocity: 1.0,
        ..named("dumbbell", 0.5, 1.0, [5.0, 5.0])
    };
    let mut scene = scene(vec![spinning, disc(0.5, 1.0, [6.25, 5.0], [0.0; 2])]);
    scene.bounds.sides = [10.0, 10.0];
    let mut free = simulate::<S>(&scene, options);
    free.run_until(3.0).unwrap();
    assert_eq!(free.view().counters().collisions, 1);

    let mut locked = simulate::<S>(&scene, options);
    locked.run_until(0.25).unwrap();
    let key = locked.view().bodies().next().unwrap().body.key();
    let energy = locked.view().energy();
    locked.set_rotation(key, Rotation::Locked).unwrap();
    assert_eq!(locked.view().energy(), 0.0);
    assert_eq!(locked.view().ledger().put_in, -energy);
    let turns = locked.view().body(key).unwrap().motion.orientation.turns();
    assert!((turns - (0.25 + 0.25 / std::f64::consts::TAU)).abs() < 1e-16);
    locked.run_until(20.0).unwrap();
    assert_eq!(locked.view().counters().collisions, 0);
    assert_eq!(
        locked.view().body(key).unwrap().motion.orientation.turns(),
        turns
    );

    // Hit at one end from below: locked it does not turn, free it does. The masses are 2 and 1, the
    // speed 1 each time.
    for (rotation, impulse, spin) in [
        (Rotation::Locked, 4.0 / 3.0, 0.0),
        (Rotation::Free, 12.0 / 11.0, 8.0 / 11.0),
    ] {
        let mut scene = crate::support::scene(vec![
            MoleculeSpec {
                rotation: Rotation::Locked,
                ..named("dumbbell", 0.5, 1.0, [5.0, 5.0])
            },
            disc(0.5, 1.0, [5.5, 3.0], [0.0, 1.0]),
        ]);
        scene.bounds.sides = [10.0, 10.0];
        let mut simulation = simulate::<S>(&scene, options);
        simulation.run_until(0.5).unwrap();
        let key = simulation.view().bodies().next().unwrap().body.key();
        simulation.set_rotation(key, rotation).unwrap();
        simulation.run_until(1.5).unwrap();
        let struck = simulation.view().body(key).unwrap().motion;
        assert!((struck.velocity - DVec2::new(0.0, 0.5 * impulse)).length() < 1e-15);
        assert!((struck.angular_velocity - spin).abs() < 1e-15);
    }
}

fn check_counters<S: Scheduler>(options: &S::Options) {
    let mut simulation = simulate::<S>(&reference_scene(9), options);
    let mut before = simulation.view().counters().scheduler;
    for round in 0..4 {
        simulation.run_until(0.3 * f64::from(round + 1)).unwrap();
        let now = simulation.view().counters().scheduler;
        assert!(
            now.crossings > before.crossings
                && now.pairs > before.pairs
                && now.stale > before.stale
        );
        before = now;
        let last = simulation.view().bodies().last().unwrap().body.key();
        match round {
            0 => simulation.remove(last).unwrap(),
            1 => simulation.set_scheduler_options(options).unwrap(),
            _ => simulation.reset_energy(last, 2.0).unwrap(),
        }
        assert_eq!(simulation.view().counters().scheduler, before);
    }
}

fn check_thermostat_with_exchange<S: Scheduler>(options: &S::Options) {
    let mut simulation = head_on::<S>(options);
    simulation.run_until(1.0).unwrap();
    let keys: Vec<_> = simulation
        .view()
        .bodies()
        .map(|view| view.body.key())
        .collect();
    let left = simulation.find_tag("left").unwrap();
    let moving = disc(0.1, 1.0, [1.0, 1.0], [0.0, 1.0]);
    let fixed = MoleculeSpec {
        fixed: true,
        ..disc(0.1, 1.0, [3.0, 1.0], [0.0; 2])
    };
    let idle = disc(0.1, 1.0, [1.0, 1.0], [0.0; 2]);
    // One body has no energy to scale: the edit changes neither bodies nor energies.
    let before = (
        crate::support::bits(&simulation.view()),
        simulation.view().ledger(),
    );
    let mut newcomer = None;
    let refused = simulation.edit(|batch| {
        batch.remove(keys[1])?;
        batch.reset_energy_of_tag(left, 7.0)?;
        newcomer = Some(batch.add(&idle)?);
        batch.reset_energy_of_all(3.0)
    });
    assert!(matches!(refused, Err(EditError::NoEnergy(name)) if Some(name.key) == newcomer));
    assert_eq!(
        (
            crate::support::bits(&simulation.view()),
            simulation.view().ledger()
        ),
        before
    );
    // A reset that is refused within a batch changes none of the other bodies.
    simulation
        .edit(|batch| {
            let idle = batch.add(&idle)?;
            assert!(batch.reset_energy_of_all(3.0).is_err());
            batch.remove(idle)
        })
        .unwrap();
    assert_eq!(
        (
            crate::support::bits(&simulation.view()),
            simulation.view().ledger()
        ),
        before
    );

    let epochs = simulation.view().counters().epochs;
    let (newcomer, other) = simulation
        .edit(|batch| {
            // A removed body has no energy to reset.
            batch.remove(keys[1])?;
            let (newcomer, fixed) = (batch.add(&moving)?, batch.add(&fixed)?);
            batch.tag(fixed, "left")?;
            batch.reset_energy_of_all(2.0)?;
            batch.reset_energy_of_tag(left, 0.5)?;
            Ok((newcomer, fixed))
        })
        .unwrap();
    let energies: Vec<_> = simulation
        .view()
        .bodies()
        .map(|view| (view.body.key(), view.energy()))
        .collect();
    assert_eq!(energies, [(keys[0], 0.5), (newcomer, 2.0), (other, 0.0)]);
    // The energy changes from 1 to 2.5.
    assert!((simulation.view().ledger().put_in - 1.5).abs() < 1e-14);
    assert!(simulation.step(1e3, &mut ()).unwrap());
    assert!(simulation.view().counters().epochs > epochs);
}
