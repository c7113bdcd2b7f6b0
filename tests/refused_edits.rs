//! Invalid edits return an error that names their cause and change no bit of the run.

use crate::support::{
    bits, disc, head_on, reference_scene, rule, simulate, test_each_scheduler, velocity,
};
use carom_engine::{
    Batch, CellScheduler, CellsPerSide, EditError, ElasticitySpec, GridError, HeapScheduler,
    MoleculeSpec, Rotation, SceneError, Scheduler,
};
use glam::DVec2;

#[test]
fn the_rotation_of_a_fixed_body_cannot_be_changed() {
    let mut simulation = simulate::<HeapScheduler>(&reference_scene(0), &CellsPerSide::Automatic);
    let fixed = simulation
        .view()
        .bodies()
        .find(|view| view.body.is_fixed())
        .unwrap()
        .body
        .key();
    let refused = simulation.set_rotation(fixed, Rotation::Free).unwrap_err();
    assert!(
        matches!(&refused, EditError::Fixed(name) if name.key == fixed),
        "{refused}"
    );
    assert_eq!(
        refused.to_string(),
        "body 2 is fixed: neither its motion, its energy nor its rotation can be changed; give the \
         bodies that move a tag of their own"
    );
}

#[test]
fn another_grid_does_not_change_the_motion() {
    let mut simulation = head_on::<HeapScheduler>(&CellsPerSide::Given(2));
    simulation.run_until(1.0).unwrap();
    // Contact distance 1 in a box of 20 × 10.
    let refused = simulation.set_scheduler_options(&CellsPerSide::Given(11));
    let reason = GridError::TooFine {
        cells_per_side: 11,
        largest: 10,
        reach: 1.0,
        bodies: [0, 1],
    };
    let entry = "body 0 (tag left) and body 1".to_owned();
    assert_eq!(
        refused,
        Err(EditError::Scene(SceneError::Grid { entry, reason }))
    );
    for cells in [10, 1, 7] {
        simulation
            .set_scheduler_options(&CellsPerSide::Given(cells))
            .unwrap();
        let goal = simulation.time().to_f64() + 0.25;
        simulation.run_until(goal).unwrap();
    }
    assert!(simulation.step(10.0, &mut ()).unwrap());
    assert!((simulation.time().to_f64() - 2.0).abs() < 1e-15);
    // A body too large for the chosen grid is refused; the grid is not changed silently.
    simulation
        .set_scheduler_options(&CellsPerSide::Given(10))
        .unwrap();
    let large = disc(1.0, 1.0, [2.0, 2.0], [0.0; 2]);
    assert!(matches!(
        simulation.add(&large),
        Err(EditError::Scene(SceneError::Grid {
            reason: GridError::TooFine {
                cells_per_side: 10,
                largest: 6,
                ..
            },
            ..
        }))
    ));
}

test_each_scheduler! {
    an_edit_that_is_refused_changes_no_bit: check_refusals;
    a_batch_that_is_refused_changes_no_bit: check_refused_batches;
    no_key_is_reused_after_a_refused_batch: check_keys_of_refused_batches;
}

fn check_refusals<S: Scheduler>(options: &S::Options) {
    let mut scene = reference_scene(6);
    scene.gas[0].tags = vec!["a".to_owned()];
    scene.elasticity.pair = vec![rule(&["a"], 0.9), rule(&["b"], 0.8), rule(&["c", "a"], 2.0)];
    let mut untouched = simulate::<S>(&scene, options);
    untouched.run_until(1.0).unwrap();

    let mut simulation = simulate::<S>(&scene, options);
    simulation.run_until(0.3).unwrap();
    let keys: Vec<_> = simulation
        .view()
        .bodies()
        .map(|view| view.body.key())
        .collect();
    let view = simulation.view();
    let tag = view.tag_names().find("a").unwrap();
    let first = view.tagged(tag).next().unwrap();
    let (tagged, place) = (first.body.key(), first.motion.position);
    let on_top = disc(0.01, 1.0, place.to_array(), [0.0; 2]);
    let expect_overlap = simulation.add(&on_top);
    assert!(
        matches!(
            expect_overlap,
            Err(EditError::Scene(SceneError::Overlap { .. }))
        ),
        "{expect_overlap:?}"
    );
    let expect_entry = simulation.add(&MoleculeSpec {
        angular_velocity: 1.0,
        ..on_top.clone()
    });
    assert!(
        matches!(
            expect_entry,
            Err(EditError::Scene(SceneError::Entry { .. }))
        ),
        "{expect_entry:?}"
    );
    let expect_geometry = simulation.add(&disc(f64::NAN, 1.0, [0.0; 2], [0.0; 2]));
    assert!(
        matches!(
            expect_geometry,
            Err(EditError::Scene(SceneError::Geometry { .. }))
        ),
        "{expect_geometry:?}"
    );
    for energy in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            simulation.reset_energy(keys[0], energy),
            Err(EditError::Energy(_))
        ));
    }
    // Two rules for one tag each, with different coefficients.
    let ambiguous = simulation.tag(tagged, "b");
    assert!(
        matches!(
            ambiguous,
            Err(EditError::Scene(SceneError::AmbiguousElasticity { .. }))
        ),
        "{ambiguous:?}"
    );
    let bad = ElasticitySpec {
        default: -0.5,
        ..ElasticitySpec::default()
    };
    assert!(matches!(
        simulation.set_elasticity(&bad),
        Err(EditError::Scene(SceneError::Elasticity { entry, .. })) if entry == "elasticity.default"
    ));
    for contact_time in [-1e-9, 1.5, f64::NAN] {
        let bad = ElasticitySpec {
            contact_time,
            ..ElasticitySpec::default()
        };
        assert!(matches!(
            simulation.set_elasticity(&bad),
            Err(EditError::Scene(SceneError::Entry { entry, .. })) if entry == "elasticity.contact_time"
        ));
    }
    let rules = vec![rule(&["a"], 0.1), rule(&["a"], 0.2)];
    let disagreeing = ElasticitySpec {
        pair: rules,
        ..ElasticitySpec::default()
    };
    assert!(simulation.set_elasticity(&disagreeing).is_err());
    // Edits without effect.
    simulation.untag(tagged, "never given").unwrap();
    simulation.tag(tagged, "a").unwrap();
    simulation.set_elasticity(&scene.elasticity).unwrap();

    simulation.run_until(1.0).unwrap();
    assert_eq!(bits(&simulation.view()), bits(&untouched.view()));
    assert_eq!(simulation.view().counters(), untouched.view().counters());
}

fn check_refused_batches<S: Scheduler>(options: &S::Options) {
    let mut scene = reference_scene(6);
    scene.gas[0].tags = vec!["a".to_owned()];
    scene.elasticity.pair = vec![rule(&["a"], 0.9), rule(&["b"], 0.8)];
    let mut untouched = simulate::<S>(&scene, options);
    untouched.run_until(1.0).unwrap();

    let mut simulation = simulate::<S>(&scene, options);
    simulation.run_until(0.3).unwrap();
    let before = (
        bits(&simulation.view()),
        *simulation.view().counters(),
        simulation.view().ledger(),
    );
    let moving: Vec<_> = simulation
        .view()
        .bodies()
        .filter(|view| view.energy() > 0.0)
        .collect();
    let (first, place) = (moving[0].body.key(), moving[0].motion.position);
    let (second, tag) = (moving[1].body.key(), simulation.find_tag("a").unwrap());
    let tagged = simulation.view().tagged(tag).last().unwrap().body.key();
    let tiny = disc(1e-6, 1.0, place.to_array(), [0.0; 2]);
    let on_top = disc(0.01, 1.0, moving[1].motion.position.to_array(), [0.0; 2]);
    // Each batch makes all kinds of edits before the invalid one, which is refused in the batch or
    // at its end.
    let mut refused = |last: &dyn Fn(&mut Batch) -> Result<(), EditError>| {
        let batch = |batch: &mut Batch| {
            batch.remove(first)?;
            let newcomer = batch.add(&tiny)?;
            batch.tag(newcomer, "never heard of")?;
            batch.tag(second, "c")?;
            batch.untag(tagged, "a")?;
            batch.reset_energy(second, 3.0)?;
            batch.set_rotation(second, Rotation::Locked)?;
            batch.set_elasticity(&ElasticitySpec {
                default: 0.5,
                ..scene.elasticity.clone()
            })?;
            last(batch)
        };
        let error = simulation.edit(batch).unwrap_err();
        let after = (
            bits(&simulation.view()),
            *simulation.view().counters(),
            simulation.view().ledger(),
        );
        assert!(before == after, "{error}");
        assert_eq!(simulation.find_tag("never heard of"), None);
        error
    };
    assert_eq!(
        refused(&|batch| batch.remove(first)),
        EditError::NoSuchBody(first)
    );
    assert_eq!(
        refused(&|batch| batch.reset_energy(second, -1.0)),
        EditError::Energy(-1.0)
    );
    let overlap = refused(&|batch| batch.add(&on_top).map(|_| ()));
    assert!(
        matches!(overlap, EditError::Scene(SceneError::Overlap { .. })),
        "{overlap}"
    );
    let twice = refused(&|batch| batch.add(&tiny).map(|_| ()));
    assert!(
        matches!(twice, EditError::Scene(SceneError::Overlap { .. })),
        "{twice}"
    );
    // Refused as a whole: two rules for one tag each with different coefficients, and a body with
    // too large a reach.
    let ambiguous = refused(&|batch| {
        batch.tag(tagged, "a")?;
        batch.tag(tagged, "b").map(|_| ())
    });
    assert!(
        matches!(
            ambiguous,
            EditError::Scene(SceneError::AmbiguousElasticity { .. })
        ),
        "{ambiguous}"
    );
    let keys: Vec<_> = simulation
        .view()
        .bodies()
        .map(|view| view.body.key())
        .collect();
    let too_large = simulation.edit(|batch| {
        keys.iter().try_for_each(|&key| batch.remove(key))?;
        let side = scene.bounds.sides[0].min(scene.bounds.sides[1]);
        batch.add(&disc(0.6 * side, 1.0, [0.0; 2], [1.0; 2]))
    });
    assert!(
        matches!(&too_large, Err(EditError::Scene(SceneError::Grid { entry, .. })) if entry.contains("body")),
        "{too_large:?}"
    );
    // A refused edit that the batch handles leaves no trace either, not even an epoch.
    simulation
        .edit(|batch| {
            assert!(batch.add(&on_top).is_err());
            batch.untag(tagged, "never given")
        })
        .unwrap();

    simulation.run_until(1.0).unwrap();
    assert_eq!(bits(&simulation.view()), bits(&untouched.view()));
    assert_eq!(simulation.view().counters(), untouched.view().counters());
}

#[test]
fn an_energy_whose_speed_is_out_of_range_is_refused() {
    let mut simulation = head_on::<CellScheduler>(&carom_engine::Instructions::Widest);
    let key = simulation.view().bodies().next().unwrap().body.key();
    // Its speed would exceed the range of detection.
    assert!(matches!(
        simulation.reset_energy(key, 1e200),
        Err(EditError::Energy(_))
    ));
    simulation.run_until(1.0).unwrap();
    assert_eq!(velocity(&simulation.view(), 0), DVec2::X);
}

fn check_keys_of_refused_batches<S: Scheduler>(options: &S::Options) {
    let mut simulation = head_on::<S>(options);
    let known: Vec<_> = simulation
        .view()
        .bodies()
        .map(|view| view.body.key())
        .collect();
    let at = |x| disc(0.1, 1.0, [x, 1.0], [0.0; 2]);
    let mut kept = Vec::new();
    // Refused by the closure, and as a whole.
    let refused = simulation.edit(|batch| {
        kept.push(batch.add(&at(1.0))?);
        kept.push(batch.add(&at(2.0))?);
        batch.remove(kept[0])?;
        batch.reset_energy(kept[1], 1.0)
    });
    assert!(
        matches!(refused, Err(EditError::NoEnergy(_))),
        "{refused:?}"
    );
    let refused = simulation.edit(|batch| {
        kept.push(batch.add(&at(3.0))?);
        batch.add(&disc(6.0, 1.0, [2.0, 5.0], [0.0; 2])).map(|_| ())
    });
    assert!(matches!(refused, Err(EditError::Scene(_))), "{refused:?}");
    assert_eq!(kept.len(), 3);
    let added = simulation.add(&at(1.0)).unwrap();
    assert!(
        kept.iter().chain(&known).all(|&key| key < added),
        "{kept:?} {added:?}"
    );
    for key in kept {
        assert!(simulation.view().body(key).is_none());
        assert_eq!(simulation.remove(key), Err(EditError::NoSuchBody(key)));
    }
    assert_eq!(simulation.view().len(), 3);
}
