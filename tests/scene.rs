//! Valid scenes are accepted, and invalid ones are refused with an error that names the wrong
//! entry.

use crate::support::{bumper, disc, gas, named, scene, simulate, velocity};
use carom_detection::Exact;
use carom_engine::{
    AtomSpec, BumperSpec, CellScheduler, CellsPerSide, ElasticityRule, GasSpec, GridError,
    HeapScheduler, Instructions, MoleculeSpec, Placement, Rotation, Scene, SceneError, Simulation,
    WallSpec,
};
use carom_geometry::GeometryError;
use carom_response::Impact;

fn refusal(scene: &Scene) -> SceneError {
    Simulation::<Exact, Impact, HeapScheduler>::with(
        scene,
        Exact::default(),
        Impact,
        CellsPerSide::Automatic,
    )
    .expect_err("the scene is wrong")
}

/// Asserts that a molecule is refused, as the second of the scene, with a message that contains
/// `words`.
fn refuse_molecule(molecule: MoleculeSpec, words: &str) {
    let scene = scene(vec![disc(0.01, 1.0, [0.9, 0.9], [0.0; 2]), molecule]);
    let message = refusal(&scene).to_string();
    assert!(
        message.starts_with("molecule[1]: ") && message.contains(words),
        "{message:?} without {words:?}"
    );
}

fn refuse_gas(gas: GasSpec, words: &str) {
    let message = refusal(&Scene {
        gas: vec![gas],
        ..Scene::default()
    })
    .to_string();
    assert!(
        message.starts_with("gas[0]: ") && message.contains(words),
        "{message:?} without {words:?}"
    );
}

#[test]
fn text_with_unknown_or_missing_keys_is_refused_with_its_line() {
    for (text, words) in [
        ("[box]\nsize = [1.0, 1.0]", "size"),
        ("[[molecule]]\nshape = \"disc\"\nradius = 0.1", "radius"),
        (
            "[[bumper]]\nradius = 0.1\nat = [0.0, 0.0]\nmass = 1.0",
            "mass",
        ),
        ("[[bumper]]\nradius = 0.1", "at"),
        ("[[gas]]\nnumber = 5", "number"),
        ("[elasticity]\ncoefficient = 0.5", "coefficient"),
        ("[[elasticity.pair]]\nbetween = [\"a\"]", "coefficient"),
        ("[run]\nuntil = \"dawn\"", "until"),
        (
            "[[molecule]]\natoms = [{ at = [0.0, 0.0], radius = 0.1 }]",
            "mass",
        ),
        ("[[molecule]]\nrotation = \"none\"", "none"),
        ("[box]\nseed = -1", "seed"),
        ("[box]\nsides = [1.0]", "sides"),
        ("[spring]\nstiffness = 1.0", "spring"),
        ("molecule = ", "line 1"),
    ] {
        let refused = Scene::from_toml(text);
        let Err(SceneError::Syntax(message)) = &refused else {
            panic!("{text:?}: {refused:?}")
        };
        assert!(
            message.contains(words) && message.contains("line"),
            "{text:?}: {message}"
        );
    }
}

#[test]
fn a_scene_is_unchanged_by_writing_and_reading() {
    let mut scene = crate::support::reference_scene(9);
    scene.molecule[0].tags = vec!["a".to_owned()];
    scene.elasticity.pair = vec![ElasticityRule {
        between: vec!["a".to_owned()],
        coefficient: (0.1 + 0.2).into(),
        tangential: 0.25,
        friction: Some(0.5),
        kick: 0.125,
    }];
    scene.run.observe = vec!["energy".to_owned()];
    assert_eq!(Scene::from_toml(&scene.to_toml()).unwrap(), scene);
}

#[test]
fn the_old_name_of_the_sample_interval_is_read() {
    let scene = Scene::from_toml("[run]\nstandby = 0.25\n").unwrap();
    assert_eq!(scene.run.sample_interval, 0.25);
    assert!(scene.to_toml().contains("sample_interval = 0.25"));
    let twice = Scene::from_toml("[run]\nstandby = 0.25\nsample_interval = 0.5\n");
    assert!(matches!(twice, Err(SceneError::Syntax(_))), "{twice:?}");
}

#[test]
#[expect(clippy::too_many_lines, reason = "one table of refusals")]
fn impossible_molecules_are_refused_by_name() {
    let good = || named("tee", 0.01, 1.0, [0.5, 0.5]);
    let atom = |x: f64, radius: f64, mass: f64| AtomSpec {
        at: [x, 0.0],
        radius,
        mass,
    };
    let of_atoms = |atoms: Vec<AtomSpec>| MoleculeSpec {
        atoms,
        at: [0.5, 0.5],
        ..MoleculeSpec::default()
    };

    refuse_molecule(named("tea", 0.01, 1.0, [0.5, 0.5]), "unknown shape 'tea'");
    refuse_molecule(
        named("rod:0", 0.01, 1.0, [0.5, 0.5]),
        "a rod must have 1 to 4096 atoms, but has 0",
    );
    refuse_molecule(
        MoleculeSpec {
            atom_radius: None,
            ..good()
        },
        "`atom_radius`",
    );
    refuse_molecule(
        MoleculeSpec {
            atom_mass: None,
            ..good()
        },
        "`atom_mass`",
    );
    refuse_molecule(
        MoleculeSpec {
            atoms: vec![atom(0.0, 0.1, 1.0)],
            ..good()
        },
        "`shape` or `atoms`, not both",
    );
    refuse_molecule(
        MoleculeSpec {
            atom_radius: Some(0.1),
            ..of_atoms(vec![atom(0.0, 0.1, 1.0)])
        },
        "go with a named `shape`",
    );
    refuse_molecule(of_atoms(vec![]), "at least one atom");
    refuse_molecule(
        of_atoms(vec![atom(0.0, 0.1, 1.0), atom(0.0, 0.2, 1.0)]),
        "the same centre",
    );
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e61] {
        refuse_molecule(of_atoms(vec![atom(0.0, bad, 1.0)]), "must be positive");
        refuse_molecule(of_atoms(vec![atom(0.0, 0.1, bad)]), "must be positive");
        refuse_molecule(
            MoleculeSpec {
                atom_radius: Some(bad),
                ..good()
            },
            "must be",
        );
        refuse_molecule(
            MoleculeSpec {
                atom_mass: Some(bad),
                ..good()
            },
            "must be positive",
        );
    }
    for bad in [f64::NAN, f64::INFINITY, -1e61] {
        refuse_molecule(of_atoms(vec![atom(bad, 0.1, 1.0)]), "must be finite");
        refuse_molecule(
            MoleculeSpec {
                at: [0.5, bad],
                ..good()
            },
            "must be finite",
        );
        refuse_molecule(
            MoleculeSpec {
                velocity: [bad, 0.0],
                ..good()
            },
            "must be finite",
        );
        refuse_molecule(
            MoleculeSpec {
                angular_velocity: bad,
                ..good()
            },
            "must be finite",
        );
        refuse_molecule(
            MoleculeSpec {
                orientation: Some(bad),
                ..good()
            },
            "must be finite",
        );
        refuse_molecule(
            MoleculeSpec {
                orientation_turns: Some(bad),
                ..good()
            },
            "must be finite",
        );
    }
    refuse_molecule(
        MoleculeSpec {
            orientation: Some(0.0),
            orientation_turns: Some(0.0),
            ..good()
        },
        "`orientation` or `orientation_turns`, not both",
    );
    refuse_molecule(
        MoleculeSpec {
            angular_velocity: 1.0,
            ..disc(0.01, 1.0, [0.5, 0.5], [0.0; 2])
        },
        "a single disc must have angular velocity 0",
    );
    refuse_molecule(
        MoleculeSpec {
            angular_velocity: 1.0,
            rotation: Rotation::Locked,
            ..good()
        },
        "locked rotation must have angular velocity 0",
    );
    refuse_molecule(
        MoleculeSpec {
            velocity: [1.0, 0.0],
            fixed: true,
            ..good()
        },
        "must have no velocity",
    );
    refuse_molecule(
        MoleculeSpec {
            angular_velocity: 1.0,
            fixed: true,
            ..good()
        },
        "must have no velocity",
    );
}

#[test]
fn impossible_bumpers_and_boxes_are_refused_by_name() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut scene = scene(vec![]);
        scene.bumper = vec![bumper(0.1, [0.0, 0.0]), bumper(bad, [0.5, 0.5])];
        assert!(
            refusal(&scene)
                .to_string()
                .starts_with("bumper[1]: the radius"),
            "{}",
            refusal(&scene)
        );
        scene.bumper[1] = BumperSpec {
            radius: 0.1,
            at: [0.5, f64::NAN],
            tags: vec![],
        };
        assert!(refusal(&scene).to_string().starts_with("bumper[1]: "));
        scene.bumper.pop();
        scene.bounds.sides = [1.0, bad];
        let expected = matches!(refusal(&scene), SceneError::Geometry { entry, reason: GeometryError::NotPositive { .. } } if entry == "box");
        assert!(expected);
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "one table of refusals")]
fn impossible_gases_are_refused_by_name() {
    let good = || gas("disc", 0.01, 10);
    refuse_gas(
        GasSpec {
            area_fraction: Some(0.1),
            ..good()
        },
        "either `area_fraction` or `count`",
    );
    refuse_gas(
        GasSpec {
            count: None,
            ..good()
        },
        "either `area_fraction` or `count`",
    );
    for bad in [1.0, -0.1, f64::NAN, f64::INFINITY] {
        refuse_gas(
            GasSpec {
                count: None,
                area_fraction: Some(bad),
                ..good()
            },
            "`area_fraction` must be",
        );
    }
    refuse_gas(
        GasSpec {
            radius: Some(0.01.into()),
            ..good()
        },
        "give either `radius` or `atom_radius`, not both",
    );
    refuse_gas(
        GasSpec {
            mass: Some(1.0.into()),
            ..good()
        },
        "give either `mass` or `atom_mass`, not both",
    );
    refuse_gas(
        GasSpec {
            atom_radius: None,
            ..good()
        },
        "a disc needs a radius: `radius` in a gas",
    );
    refuse_gas(
        GasSpec {
            energy: -1.0,
            ..good()
        },
        "must not be negative",
    );
    refuse_gas(
        GasSpec {
            energy: f64::NAN,
            ..good()
        },
        "must be finite",
    );
    refuse_gas(
        GasSpec {
            atom_mass: Some(0.0.into()),
            ..good()
        },
        "must be positive",
    );
    refuse_gas(
        GasSpec {
            shape: Some("ring:2".to_owned()),
            ..good()
        },
        "a ring must have 3 to 4096 atoms, but has 2",
    );
    refuse_gas(
        GasSpec {
            atoms: vec![AtomSpec {
                at: [0.0; 2],
                radius: 0.01,
                mass: 1.0,
            }],
            ..good()
        },
        "`shape` or `atoms`, not both",
    );
    // More molecules than fit, by a little or by far.
    for count in [3000, 2_000_000] {
        let error = refusal(&Scene {
            gas: vec![gas("disc", 0.01, count)],
            ..Scene::default()
        });
        assert!(
            matches!(&error, SceneError::Full { entry, requested, placed } if entry == "gas[0]" && *requested == count && *placed < 3000),
            "{error}"
        );
    }
    // Numbers at the edge of the accepted range give an error, not an endless loop.
    refuse_gas(
        GasSpec {
            count: None,
            area_fraction: Some(0.5),
            ..gas("disc", 1e-60, 0)
        },
        "at most 2^27",
    );
    refuse_gas(gas("disc", 1e-9, usize::MAX), "at most 2^27");
    refuse_gas(gas("disc", 1e59, 1), "only 0 of 1");
    // A share of the box that is less than half a molecule; with more than half, there is one
    // molecule.
    let by_area = |fraction, radius| GasSpec {
        count: None,
        area_fraction: Some(fraction),
        ..gas("disc", radius, 0)
    };
    refuse_gas(by_area(0.5, 1e59), "rounds to 0 molecules");
    // π/16 = 0.196 of the box's area 1.
    let refused = refusal(&Scene {
        gas: vec![by_area(0.098, 0.25)],
        ..Scene::default()
    })
    .to_string();
    assert!(
        refused.starts_with("gas[0]: `area_fraction` = 0.098 of the box's area 1 "),
        "{refused}"
    );
    assert!(refused.contains("area 0.19634"), "{refused}");
    for (fraction, count) in [(0.099, 1), (0.0, 0)] {
        let scene = Scene {
            gas: vec![by_area(fraction, 0.25)],
            ..Scene::default()
        };
        assert_eq!(
            Simulation::new(&scene).unwrap().view().len(),
            count,
            "{fraction}"
        );
    }
}

#[test]
fn overlaps_are_refused_with_both_entries() {
    let overlap = |scene: &Scene| match refusal(scene) {
        SceneError::Overlap {
            first,
            second,
            depth,
        } => (first, second, depth),
        other => panic!("{other}"),
    };
    let mut discs = scene(vec![
        disc(0.1, 1.0, [0.5, 0.5], [0.0; 2]),
        disc(0.1, 1.0, [0.05, 0.5], [0.0; 2]),
        disc(0.1, 1.0, [0.9, 0.5], [0.0; 2]),
    ]);
    // The last two overlap across the border.
    let (first, second, depth) = overlap(&discs);
    assert_eq!(
        (first.as_str(), second.as_str()),
        ("molecule[1]", "molecule[2]")
    );
    assert!((depth - 0.05).abs() < 1e-15);
    discs.molecule.pop();
    discs.bumper = vec![bumper(0.2, [0.5, 0.79])];
    let (first, second, depth) = overlap(&discs);
    assert_eq!(
        (first.as_str(), second.as_str()),
        ("molecule[0]", "bumper[0]")
    );
    assert!((depth - 0.01).abs() < 1e-15);

    // An overlap of 1e-9 is not due to rounding; an overlap of 1e-16 is, and so is a contact.
    for (overlapping, by) in [
        (true, 1e-9),
        (true, 1e-12),
        (false, 1e-16),
        (false, 0.0),
        (false, -1e-12),
    ] {
        let pair = scene(vec![
            disc(0.1, 1.0, [0.4, 0.5], [1.0, 0.0]),
            disc(0.1, 1.0, [0.6 - by, 0.5], [0.0, 0.0]),
        ]);
        if overlapping {
            overlap(&pair);
        } else {
            let mut simulation = simulate::<HeapScheduler>(&pair, &CellsPerSide::Automatic);
            simulation.run_until(1e-6).unwrap();
            // For any last bit the pair closes, so it collides once.
            assert_eq!(simulation.view().counters().collisions, 1);
            assert!((velocity(&simulation.view(), 1).x - 1.0).abs() < 1e-15);
        }
    }

    // Molecules are accepted if their bounding circles overlap but their atoms do not; fixed bodies
    // may overlap.
    let mut tees = scene(vec![
        named("rod:5", 0.02, 1.0, [0.5, 0.5]),
        named("rod:5", 0.02, 1.0, [0.5, 0.541]),
    ]);
    tees.bumper = vec![bumper(0.1, [0.1, 0.1]), bumper(0.1, [0.15, 0.1])];
    simulate::<HeapScheduler>(&tees, &CellsPerSide::Automatic);
    tees.molecule[1].at = [0.5, 0.539];
    let (_, _, depth) = overlap(&tees);
    assert!((depth - 0.001).abs() < 1e-15);
}

#[test]
fn a_grid_too_fine_is_refused_and_the_error_gives_the_limit() {
    // The tee of relative size 0.5 (Montanari 2017, chapter 3): contact distance
    // 3.8 × 0.005 + 0.01 = 0.029.
    let mut thesis = scene(vec![named("tee", 0.005, 2.0, [0.5, 0.5])]);
    thesis.gas = vec![gas("disc", 0.01, 100)];
    let built = |cells| {
        Simulation::<Exact, Impact, HeapScheduler>::with(
            &thesis,
            Exact::default(),
            Impact,
            CellsPerSide::Given(cells),
        )
    };
    for cells in [50, 35] {
        let error = built(cells).expect_err("50 misses contacts");
        let SceneError::Grid {
            entry,
            reason:
                GridError::TooFine {
                    cells_per_side: asked,
                    largest,
                    reach,
                    ..
                },
        } = &error
        else {
            panic!("{error}")
        };
        assert_eq!((*asked, *largest), (cells, 34));
        assert_eq!(entry, "molecule[0] and gas[0]");
        assert!((reach - 0.029).abs() < 1e-16);
        assert!(error.to_string().contains("at most 34 are safe"), "{error}");
    }
    assert!(built(34).is_ok());
    for cells in [0, 4097, u32::MAX] {
        assert!(
            matches!(built(cells), Err(SceneError::Grid { reason: GridError::CellsPerSide(asked), .. }) if asked == cells)
        );
    }
}

#[test]
fn a_box_in_which_a_molecule_could_touch_its_own_image_is_refused() {
    let refused_entry = |scene: &Scene| match refusal(scene) {
        SceneError::Grid {
            entry,
            reason: GridError::BoxTooSmall { .. },
        } => entry,
        error => panic!("{error}"),
    };
    // A rod of bounding radius 0.5, and a slightly shorter one.
    assert_eq!(
        refused_entry(&scene(vec![named("rod:5", 0.1, 1.0, [0.5, 0.5])])),
        "molecule[0]"
    );
    simulate::<HeapScheduler>(
        &scene(vec![named("rod:5", 0.099, 1.0, [0.5, 0.5])]),
        &CellsPerSide::Given(1),
    );
    // The shorter side is the limit.
    let mut narrow = scene(vec![named("rod:5", 0.05, 1.0, [0.5, 0.25])]);
    narrow.bounds.sides = [1.0, 0.5];
    assert_eq!(refused_entry(&narrow), "molecule[0]");
    // Two bodies whose contact distance exceeds the box.
    let mut wall = scene(vec![disc(0.3, 1.0, [5.0, 0.5], [1.0, 0.0])]);
    wall.bounds.sides = [10.0, 1.0];
    wall.bumper = vec![bumper(0.6, [0.0, 0.5])];
    simulate::<HeapScheduler>(&wall, &CellsPerSide::Given(1));
    wall.bumper[0].radius = 0.8;
    assert_eq!(refused_entry(&wall), "molecule[0] and bumper[0]");
    // A fixed disc may cover the box if nothing moves.
    let mut covered = scene(vec![]);
    covered.bumper = vec![bumper(0.9, [0.5, 0.5])];
    simulate::<HeapScheduler>(&covered, &CellsPerSide::Automatic)
        .run_until(1.0)
        .unwrap();
    covered.bumper = vec![bumper(1.6, [0.5, 0.5]), bumper(3.0, [0.0, 0.0])];
    simulate::<HeapScheduler>(&covered, &CellsPerSide::Automatic)
        .run_until(1.0)
        .unwrap();
    simulate::<CellScheduler>(&covered, &Instructions::Widest)
        .run_until(1.0)
        .unwrap();
    // It may not cover many images of the box, where placing a gas would take for ever.
    covered.bumper[1].radius = 1e60;
    covered.gas = vec![gas("disc", 1e-3, 4)];
    assert_eq!(refused_entry(&covered), "bumper[1]");
    // Of two gases the one with the larger discs is named.
    let mut gases = scene(vec![]);
    gases.bounds.sides = [2.0, 0.2];
    gases.gas = vec![
        gas("disc", 0.01, 30),
        gas("disc", 0.099, 1),
        gas("disc", 0.02, 2),
    ];
    gases.bumper = vec![bumper(0.11, [1.0, 0.1])];
    assert_eq!(refused_entry(&gases), "gas[1] and bumper[0]");
}

/// Tags, and the coefficient of the pair.
type Rule<'a> = (&'a [&'a str], f64);

#[test]
fn elasticity_rules_are_checked_and_the_most_specific_wins() {
    let base = || {
        let mut scene = scene(vec![
            disc(0.1, 1.0, [0.25, 0.5], [1.0, 0.0]),
            disc(0.1, 1.0, [0.75, 0.5], [-1.0, 0.0]),
        ]);
        scene.molecule[0].tags = vec!["a".to_owned(), "c".to_owned()];
        scene.molecule[1].tags = vec!["b".to_owned()];
        scene.elasticity.default = 0.9;
        scene
    };
    let with = |rules: &[Rule<'_>]| {
        let mut scene = base();
        scene.elasticity.pair = rules
            .iter()
            .map(|(between, coefficient)| crate::support::rule(between, *coefficient))
            .collect();
        scene
    };
    let measured = |rules: &[Rule<'_>]| {
        let mut simulation = simulate::<HeapScheduler>(&with(rules), &CellsPerSide::Automatic);
        simulation.run_until(0.2).unwrap();
        velocity(&simulation.view(), 1).x
    };
    let cases: [(&[Rule<'_>], f64); 9] = [
        (&[], 0.9),
        (&[(&["a"], 0.5)], 0.5),
        (&[(&["a"], 0.5), (&["a", "b"], 0.25)], 0.25),
        (&[(&["b", "a"], 0.25), (&["b"], 0.5)], 0.25),
        // A rule for a tag with itself, or with a third tag, does not apply to this contact.
        (&[(&["a", "a"], 0.25), (&["a", "d"], 0.0)], 0.9),
        (&[(&["a", "c"], 0.25)], 0.9),
        // Two rules of one rank with equal coefficients.
        (&[(&["a"], 0.5), (&["b"], 0.5)], 0.5),
        // A disagreement resolved by the more specific rule.
        (
            &[(&["a"], 0.5), (&["b"], 0.25), (&["a", "b"], 0.125)],
            0.125,
        ),
        (&[(&["absent"], 0.0)], 0.9),
    ];
    for (rules, expected) in cases {
        assert!(
            (measured(rules) - expected).abs() < 1e-15,
            "{rules:?}: {}",
            measured(rules)
        );
    }

    let ambiguous = |rules: &[Rule<'_>]| match refusal(&with(rules)) {
        SceneError::AmbiguousElasticity {
            first,
            second,
            one,
            other,
        } => (first, second, one, other),
        other => panic!("{other}"),
    };
    let names = |list: &[&str]| list.iter().map(|&tag| tag.to_owned()).collect::<Vec<_>>();
    assert_eq!(
        ambiguous(&[(&["a"], 0.5), (&["b"], 0.25)]),
        (
            names(&["a"]),
            names(&["b"]),
            "0.5".to_owned(),
            "0.25".to_owned()
        )
    );
    assert_eq!(
        ambiguous(&[(&["a", "b"], 0.5), (&["b", "c"], 0.25)]),
        (
            names(&["a", "b"]),
            names(&["b", "c"]),
            "0.5".to_owned(),
            "0.25".to_owned()
        )
    );

    for bad in [-0.1, f64::NAN, f64::INFINITY, 1e7] {
        let error = refusal(&with(&[(&["a"], 1.0), (&["a", "b"], bad)]));
        assert!(
            error
                .to_string()
                .starts_with("elasticity.pair[1]: elasticity must be"),
            "{error}"
        );
        let mut scene = base();
        scene.elasticity.default = bad;
        assert!(
            refusal(&scene)
                .to_string()
                .starts_with("elasticity.default: elasticity must be")
        );
    }
    for between in [&[] as &[&str], &["a", "b", "c"]] {
        let error = refusal(&with(&[(between, 1.0)]));
        assert!(
            error
                .to_string()
                .starts_with("elasticity.pair[0]: `between` must name"),
            "{error}"
        );
    }
}

#[test]
fn boxes_and_walls_out_of_range_are_refused_quickly() {
    let begun = std::time::Instant::now();
    for sides in [[1.0, 1e20], [1.0, 1e60], [2.6e26, 1.0], [1e60, 1e-3]] {
        let mut boundless = Scene {
            gas: vec![gas("disc", 1e-4, 30)],
            ..Scene::default()
        };
        boundless.bounds.sides = sides;
        let message = refusal(&boundless).to_string();
        assert!(
            message.starts_with("gas[0]: the box is too large: atoms touch at 2e-4"),
            "{message}"
        );
    }
    // Single molecules are checked as well as gases.
    let mut boundless = scene(vec![disc(0.03, 1.0, [0.5, 0.5], [0.0; 2])]);
    boundless.bounds.sides = [1.0, 1e20];
    boundless.gas = vec![gas("disc", 0.3, 1)];
    let message = refusal(&boundless).to_string();
    assert!(
        message.starts_with("molecule[0] and gas[0]: the box is too large"),
        "{message}"
    );

    let mut walled = scene(vec![disc(1e-8, 1.0, [0.9, 0.3e-6], [1.0, 0.0])]);
    let wall = |from, to, radius| WallSpec {
        from: Some(from),
        to: Some(to),
        radius,
        ..WallSpec::default()
    };
    walled.wall = vec![wall([0.2, 0.3], [0.4, 0.1], 1e6)];
    let message = refusal(&walled).to_string();
    assert!(
        message.starts_with(
            "wall[0]: the radius of the wall must be at most the shorter side of the box, 1e0"
        ),
        "{message}"
    );
    walled.wall = vec![WallSpec {
        x: Some(0.5),
        radius: 1e59,
        ..WallSpec::default()
    }];
    assert!(
        refusal(&walled)
            .to_string()
            .starts_with("wall[0]: the radius of the wall")
    );
    walled.bounds.sides = [1.0, 1e-6];
    walled.wall = vec![wall([0.0, 0.0], [1.0, 1.0], 0.0)];
    let message = refusal(&walled).to_string();
    assert!(
        message.contains("16 times as long as the box, but is 1e0 along y, where the side is 1e-6"),
        "{message}"
    );
    // A line along the box is accepted.
    walled.wall = vec![wall([0.0, 0.0], [10.0, 1e-6], 0.0)];
    assert!(Simulation::new(&walled).is_ok());
    // A wall is not listed in billions of cells across a narrow box.
    walled.bounds.sides = [1.0, 9.4e18];
    walled.molecule.clear();
    walled.wall = vec![wall([1.0, 1.0], [1.0, 1.2e20], 0.0)];
    let message = refusal(&walled).to_string();
    assert!(
        message.contains("differ by a factor of at most 1e9, but they are 1e0 and 9.4e18"),
        "{message}"
    );

    // Molecules far too large for the box.
    let large = scene(vec![named("tee", 1e40, 1.0, [0.5, 0.5])]);
    assert!(
        refusal(&large)
            .to_string()
            .starts_with("molecule[0]: the box is too small")
    );
    let mut large = scene(vec![named("tee", 1.0, 1.0, [0.5, 0.5])]);
    large.molecule.push(disc(0.1, 1.0, [0.5, 0.5], [0.0; 2]));
    assert!(
        refusal(&large)
            .to_string()
            .starts_with("molecule[0] and molecule[1] overlap")
    );
    refuse_gas(gas("disc", 1e40, 30), "only 0 of 30");
    assert!(begun.elapsed().as_secs_f64() < 5.0, "{:?}", begun.elapsed());
}

/// A molecule is listed in cells around a shell, which is not as small as the discs.
#[test]
fn a_molecule_among_discs_of_any_size_needs_few_events() {
    for radius in [1e-30, 2e-11, 1e-4] {
        let mut mixed = scene(vec![MoleculeSpec {
            velocity: [-0.111, 0.338],
            angular_velocity: -18.0,
            ..named("cross", 0.0097, 4.2, [0.5, 0.5])
        }]);
        mixed
            .molecule
            .push(disc(radius, 0.35, [0.07, 0.33], [-0.34, 2.5]));
        // Two that touch at less than 1e-13 of the side are refused.
        if radius > 1e-13 {
            mixed
                .molecule
                .push(disc(radius, 0.35, [0.2, 0.7], [0.4, 1.5]));
        }
        let [cells, heap] = [
            {
                let mut run = simulate::<CellScheduler>(&mixed, &Instructions::Widest);
                run.run_until(20.0).unwrap();
                let counters = *run.view().counters();
                assert!(
                    counters.scheduler.pairs < 1_000_000,
                    "{radius:e}: {counters:?}"
                );
                (counters.collisions, run.view().overlaps().pairs)
            },
            {
                let mut run = simulate::<HeapScheduler>(&mixed, &CellsPerSide::Automatic);
                run.run_until(20.0).unwrap();
                (
                    run.view().counters().collisions,
                    run.view().overlaps().pairs,
                )
            },
        ];
        assert!(
            cells.0 > 0 && cells.1 == 0 && heap.1 == 0,
            "{radius:e}: {cells:?} {heap:?}"
        );
    }
}

#[test]
fn a_gas_can_be_placed_in_the_narrowest_box_that_is_accepted() {
    for sides in [
        [1.0, 1e12],
        [1e12, 1.0],
        [1.0, 3e12],
        [3e12, 1.0],
        [0.7, 1e6],
    ] {
        let mut narrow = Scene {
            gas: vec![gas("disc", 0.3, 30)],
            ..Scene::default()
        };
        narrow.bounds.sides = sides;
        narrow.bumper = vec![bumper(0.1, [0.0, 0.0])];
        let mut simulation = simulate::<CellScheduler>(&narrow, &Instructions::Widest);
        assert_eq!(
            (
                simulation.view().len(),
                simulation.view().overlaps().deepest
            ),
            (31, 0.0)
        );
        simulation.run_until(1.0).unwrap();
        assert_eq!(simulation.view().overlaps().pairs, 0);
    }
    // A wall along the box leaves no space, which is detected.
    let mut narrow = Scene {
        gas: vec![gas("disc", 0.3, 30)],
        ..Scene::default()
    };
    narrow.bounds.sides = [1.0, 1e6];
    narrow.wall = vec![WallSpec {
        x: Some(0.5),
        radius: 0.3,
        ..WallSpec::default()
    }];
    let error = Simulation::new(&narrow).unwrap_err();
    assert!(matches!(error, SceneError::Jammed { .. }), "{error}");
    narrow.start.placement = Some(Placement::Lattice);
    let error = Simulation::new(&narrow).unwrap_err();
    assert!(
        matches!(
            error,
            SceneError::Full {
                placed: 0,
                requested: 30,
                ..
            }
        ),
        "{error}"
    );
}
