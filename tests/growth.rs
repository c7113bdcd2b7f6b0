//! Gases can be grown to densities at which no lattice holds them, around other bodies that stay at
//! their places, with the same result to the bit from each scene.

use std::ops::ControlFlow;

use crate::support::{bits, bumper, gas, named, simulate};
use carom_detection::Exact;
use carom_engine::{
    AtomSpec, CellsPerSide, GasSpec, Growth, HeapScheduler, Instructions, MoleculeSpec, Placement,
    Quantity, Scene, SceneError, Simulation, StartSpec, WallSpec,
};
use carom_geometry::{Atom, Molecule};
use carom_response::Impact;
use glam::DVec2;

/// Gases that are grown, and relaxed for so many collisions a molecule.
fn grown(gas: Vec<GasSpec>, relax: f64) -> Scene {
    let start = StartSpec {
        placement: Some(Placement::Grown),
        relax: Some(relax),
        ..StartSpec::default()
    };
    let mut scene = Scene {
        gas,
        start,
        ..Scene::default()
    };
    scene.bounds.seed = 3;
    scene
}

/// So many molecules of a shape, of the size at which they cover this share of the unit box.
fn covering(shape: &str, count: usize, area_fraction: f64) -> GasSpec {
    let one = Molecule::named(shape.parse().unwrap(), 1.0, 1.0)
        .unwrap()
        .area();
    gas(shape, (area_fraction / (count as f64 * one)).sqrt(), count)
}

/// Three touching discs around a right angle.
fn corner(count: usize, area_fraction: f64) -> GasSpec {
    let radius = (area_fraction / (3.0 * std::f64::consts::PI * count as f64)).sqrt();
    let atom = |x, y| AtomSpec {
        at: [2.0 * radius * x, 2.0 * radius * y],
        radius,
        mass: 0.4,
    };
    let atoms = vec![atom(0.0, 0.0), atom(1.0, 0.0), atom(0.0, 1.0)];
    GasSpec {
        atoms,
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    }
}

fn tagged(tag: &str, gas: GasSpec) -> GasSpec {
    GasSpec {
        tags: vec![tag.to_owned()],
        ..gas
    }
}

/// The molecule that the entry of a gas describes.
fn molecule(gas: &GasSpec) -> Molecule {
    if let Some(shape) = &gas.shape {
        let [radius, mass] = [&gas.atom_radius, &gas.atom_mass]
            .map(|given| given.as_ref().and_then(Quantity::number).unwrap());
        return Molecule::named(shape.parse().unwrap(), radius, mass).unwrap();
    }
    let atom = |spec: &AtomSpec| Atom::new(DVec2::from(spec.at), spec.radius, spec.mass).unwrap();
    Molecule::new(gas.atoms.iter().map(atom)).unwrap()
}

#[test]
fn each_shape_reaches_its_density_without_overlap_and_unchanged() {
    let gases = [
        covering("disc", 80, 0.80),
        covering("dumbbell", 60, 0.78),
        covering("tee", 50, 0.62),
        covering("cross", 50, 0.62),
        corner(50, 0.68),
        covering("rod:4", 50, 0.66),
        covering("rod:8", 40, 0.54),
        covering("ring:8", 40, 0.52),
    ];
    for gas in gases {
        let scene = grown(vec![gas.clone()], 0.0);
        let simulation = Simulation::new(&scene).unwrap();
        let view = simulation.view();
        let name = gas.shape.clone().unwrap_or("corner".to_owned());
        assert_eq!(
            (view.len(), view.overlaps().deepest_length),
            (gas.count.unwrap(), 0.0),
            "{name}"
        );
        // Equal to the bit.
        let whole = molecule(&gas);
        assert!(
            view.bodies().all(|body| *body.body.molecule() == whole),
            "{name}"
        );
        assert!(
            view.bodies()
                .all(|body| (body.energy() - 1.0).abs() < 1e-14),
            "{name}"
        );
        // The clock and the counters of the run begin here.
        assert_eq!((view.time().to_f64(), view.counters().collisions), (0.0, 0));
    }
}

#[test]
fn gases_that_fit_on_no_lattice_are_grown_and_relaxed() {
    let mut scene = Scene {
        gas: vec![covering("tee", 60, 0.6)],
        ..Scene::default()
    };
    let mut simulation = Simulation::new(&scene).unwrap();
    assert_eq!(simulation.view().overlaps().pairs, 0);
    // The total is that of the scene; collisions have shared it.
    let energies = || {
        simulation
            .view()
            .bodies()
            .map(|body| body.energy())
            .collect::<Vec<_>>()
    };
    assert!((energies().iter().sum::<f64>() - 60.0).abs() < 1e-12);
    assert!(energies().iter().any(|energy| (energy - 1.0).abs() > 0.1));
    assert!(simulation.view().momentum().length() < 1e-12);
    simulation.run_until(0.2).unwrap();
    assert!(simulation.view().counters().collisions > 1000);
    assert_eq!(simulation.view().overlaps().pairs, 0);
    // A lattice alone, if that is what the scene says.
    scene.start.placement = Some(Placement::Lattice);
    assert!(matches!(
        Simulation::new(&scene),
        Err(SceneError::Full { requested: 60, .. })
    ));
}

#[test]
fn a_mixture_grows_together() {
    let shapes = ["disc", "dumbbell", "tee", "rod:8", "ring:8"];
    let atoms = 1.0 + 2.0 + 5.0 + 8.0 + 8.0;
    let radius = (0.56 / (12.0 * atoms * std::f64::consts::PI)).sqrt();
    let gases: Vec<GasSpec> = shapes
        .map(|shape| tagged(shape, gas(shape, radius, 12)))
        .into();
    let scene = grown(gases.clone(), 5.0);
    let mut simulation = Simulation::new(&scene).unwrap();
    for gas in &gases {
        let whole = molecule(gas);
        let tag = simulation.find_tag(&gas.tags[0]).unwrap();
        assert_eq!(
            simulation
                .view()
                .tagged(tag)
                .filter(|body| *body.body.molecule() == whole)
                .count(),
            12
        );
    }
    simulation.run_until(0.05).unwrap();
    assert_eq!(simulation.view().overlaps().pairs, 0);
    // Unlike sizes, too: the area of the small discs is that of the large ones.
    let unlike = [covering("disc", 8, 0.38), covering("disc", 400, 0.38)];
    let simulation = Simulation::new(&grown(unlike.to_vec(), 0.0)).unwrap();
    assert_eq!(simulation.view().overlaps().deepest_length, 0.0);
}

/// Dense dumbbells between walls, around a bumper, a fixed and two free molecules.
fn among_others(relax: f64) -> Scene {
    let mut scene = grown(vec![covering("dumbbell", 50, 0.5)], relax);
    scene.wall = vec![
        WallSpec {
            x: Some(0.0),
            ..WallSpec::default()
        },
        WallSpec {
            from: Some([0.2, 0.8]),
            to: Some([0.4, 0.7]),
            radius: 0.01,
            ..WallSpec::default()
        },
    ];
    scene.bumper = vec![bumper(0.1, [0.7, 0.7])];
    scene.molecule = vec![
        MoleculeSpec {
            fixed: true,
            orientation: Some(0.3),
            ..named("tee", 0.02, 1.0, [0.3, 0.3])
        },
        MoleculeSpec {
            velocity: [0.3, -0.7],
            angular_velocity: 2.0,
            ..named("rod:4", 0.02, 1.0, [0.7, 0.3])
        },
        MoleculeSpec {
            velocity: [1e-3, 0.0],
            ..named("disc", 0.05, 1.0, [0.5, 0.5])
        },
    ];
    scene
}

#[test]
fn walls_bumpers_and_single_molecules_stay_as_given() {
    for relax in [0.0, 10.0] {
        let scene = among_others(relax);
        let mut simulation = Simulation::new(&scene).unwrap();
        let alone = Simulation::new(&Scene {
            gas: vec![],
            ..scene.clone()
        })
        .unwrap();
        let given = bits(&alone.view());
        assert_eq!(bits(&simulation.view())[..given.len()], given);
        for (one, other) in simulation.view().bodies().zip(alone.view().bodies()) {
            assert_eq!(
                (one.body.molecule(), one.body.inertia()),
                (other.body.molecule(), other.body.inertia())
            );
        }
        assert_eq!(simulation.view().overlaps().pairs, 0);
        let energy: f64 = simulation
            .view()
            .bodies()
            .skip(given.len())
            .map(|body| body.energy())
            .sum();
        assert!((energy - 50.0).abs() < 1e-12, "{energy}");
        simulation.run_until(0.1).unwrap();
        assert_eq!(simulation.view().overlaps().pairs, 0);
    }
}

#[test]
fn the_gases_start_with_the_energy_and_the_momentum_of_the_scene() {
    let hot = GasSpec {
        energy: 3.0,
        ..covering("dumbbell", 30, 0.35)
    };
    let drifting = GasSpec {
        zero_momentum: Some(false),
        ..covering("disc", 20, 0.25)
    };
    let momentum = |gases: &[GasSpec], relax: f64, molecule: &[MoleculeSpec]| {
        let scene = Scene {
            molecule: molecule.to_vec(),
            ..grown(gases.to_vec(), relax)
        };
        let simulation = Simulation::new(&scene).unwrap();
        let gas = simulation.view().bodies().skip(molecule.len());
        let sum = |energy: f64, body: carom_engine::BodyView<'_>| energy + body.energy();
        let energy = gas.fold(0.0, sum);
        let expected: f64 = gases
            .iter()
            .map(|gas| gas.energy * gas.count.unwrap() as f64)
            .sum();
        assert!(
            (energy / expected - 1.0).abs() < 1e-13,
            "{energy} of {expected}"
        );
        simulation.view().momentum()
    };
    // A free molecule at rest, which the relaxation holds at its place, takes no momentum.
    let molecule = &[named("tee", 0.03, 1.0, [0.5, 0.5])];
    for relax in [0.0, 10.0] {
        assert!(momentum(std::slice::from_ref(&hot), relax, &[]).length() < 1e-12);
        assert!(momentum(&[hot.clone(), hot.clone()], relax, molecule).length() < 1e-12);
    }
    // The drift of a gas whose velocities are independent remains.
    let gases = [hot.clone(), drifting];
    let (drawn, relaxed) = (
        momentum(&gases, 0.0, molecule),
        momentum(&gases, 10.0, molecule),
    );
    assert!(
        drawn.length() > 0.1 && (drawn - relaxed).length() < 1e-12,
        "{drawn} {relaxed}"
    );
    // A gas at rest grows, and is at rest.
    let cold = GasSpec { energy: 0.0, ..hot };
    let simulation = Simulation::new(&grown(vec![cold], 10.0)).unwrap();
    assert_eq!(simulation.view().energy(), 0.0);
}

#[test]
fn inelastic_gases_start_with_all_of_their_energy() {
    let mut scene = grown(vec![covering("disc", 60, 0.7)], 20.0);
    scene.elasticity.default = 0.5;
    let mut simulation = Simulation::new(&scene).unwrap();
    assert!((simulation.view().energy() - 60.0).abs() < 1e-12);
    assert_eq!(simulation.view().ledger().lost, 0.0);
    simulation.run_until(0.1).unwrap();
    assert!(simulation.view().energy() < 50.0);
}

#[test]
fn a_lattice_can_be_relaxed_too() {
    let mut scene = Scene {
        gas: vec![covering("disc", 60, 0.5)],
        ..Scene::default()
    };
    let lattice = Simulation::new(&scene).unwrap();
    scene.start.relax = Some(20.0);
    let simulation = Simulation::new(&scene).unwrap();
    assert!((simulation.view().energy() - 60.0).abs() < 1e-12);
    assert!(simulation.view().momentum().length() < 1e-12);
    let speed = |simulation: &Simulation| {
        simulation
            .view()
            .bodies()
            .map(|body| body.motion.velocity.length().powi(4))
            .sum::<f64>()
            / 60.0
    };
    // ⟨v⁴⟩ is 4 for one speed √2, and 8 for Maxwell's distribution of N → ∞ molecules.
    assert!((speed(&lattice) - 4.0).abs() < 1e-12 && (5.0..12.0).contains(&speed(&simulation)));
    // No relaxation is the default of a lattice.
    scene.start.relax = Some(0.0);
    assert_eq!(
        bits(&Simulation::new(&scene).unwrap().view()),
        bits(&lattice.view())
    );
    // Few molecules in a large box: the relaxation ends although they never meet.
    let mut dilute = grown(vec![gas("disc", 1e-6, 2)], 100.0);
    Simulation::new(&dilute).unwrap();
    dilute.gas[0].count = Some(1);
    Simulation::new(&dilute).unwrap();
    dilute.gas[0].count = Some(0);
    assert!(Simulation::new(&dilute).unwrap().view().is_empty());
}

#[test]
fn a_scene_grows_to_the_same_bits_in_any_thread_scheduler_and_pieces() {
    let scene = Scene {
        gas: vec![covering("tee", 25, 0.34), corner(20, 0.15)],
        ..among_others(30.0)
    };
    let mut whole = Growth::new(&scene).unwrap();
    let mut stored = whole.clone();
    let mut steps = 0;
    while !whole.is_done() {
        let progress = whole.step().unwrap();
        // Stored and continued in each third step.
        let step = stored.step().unwrap();
        assert_eq!(progress, step);
        if steps % 3 == 0 {
            let bytes = postcard::to_stdvec(&stored).unwrap();
            stored = postcard::from_bytes(&bytes).unwrap();
        }
        steps += 1;
    }
    assert!(steps > 20 && stored.is_done(), "{steps}");
    let expected = bits(&whole.finish().unwrap().view());
    assert_eq!(bits(&stored.finish().unwrap().view()), expected);
    let heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
    assert_eq!(bits(&heap.view()), expected);
    let elsewhere = std::thread::scope(|scope| {
        let both = [(); 2].map(|()| scope.spawn(|| bits(&Simulation::new(&scene).unwrap().view())));
        both.map(|thread| thread.join().unwrap())
    });
    assert!(elsewhere.iter().all(|bits| *bits == expected));
    // Another seed gives another state.
    let mut other = scene.clone();
    other.bounds.seed += 1;
    assert!(bits(&Simulation::new(&other).unwrap().view()) != expected);
}

#[test]
fn jammed_gases_end_with_an_error_that_names_the_density() {
    let scene = grown(vec![covering("tee", 25, 0.85)], 0.0);
    let error = Simulation::new(&scene).unwrap_err();
    let SceneError::Jammed {
        reached, requested, ..
    } = error
    else {
        panic!("{error}")
    };
    // Jammed states of tees: 0.70 at N = 1000.
    assert!(
        (0.62..0.76).contains(&reached) && (requested - 0.85).abs() < 1e-12,
        "{reached} {requested}"
    );
    assert!(
        error.to_string().contains(&format!("{reached:.4}")),
        "{error}"
    );
    // Discs that a wall keeps from growing.
    let mut narrow = grown(vec![gas("disc", 0.3, 2)], 0.0);
    narrow.bounds.sides = [1.0, 10.0];
    narrow.wall = vec![WallSpec {
        x: Some(0.5),
        radius: 0.3,
        ..WallSpec::default()
    }];
    assert!(matches!(
        Simulation::new(&narrow),
        Err(SceneError::Jammed { .. })
    ));
    // More than the box, and more than the densest lattice, are refused at once.
    for count in [100_000_000, 2900] {
        let crowd = grown(vec![gas("disc", 0.01, count)], 0.0);
        let error = Simulation::new(&crowd).unwrap_err();
        assert!(
            matches!(&error, SceneError::Full { entry, placed, requested } if entry == "gas[0]" && *requested == count && *placed < 3200),
            "{error}"
        );
    }
    let large = grown(vec![gas("rod:8", 0.07, 1)], 0.0);
    assert!(matches!(
        Simulation::new(&large),
        Err(SceneError::Grid { .. })
    ));
}

fn with_progress(
    scene: &Scene,
    progress: &mut dyn FnMut(&Growth) -> ControlFlow<()>,
) -> Result<Simulation, SceneError> {
    Simulation::with_progress(
        scene,
        Exact::default(),
        Impact,
        Instructions::Widest,
        progress,
    )
}

#[test]
fn progress_is_shown_and_growth_can_be_interrupted() {
    let scene = grown(vec![covering("dumbbell", 40, 0.7)], 40.0);
    let mut seen = Vec::new();
    let simulation = with_progress(&scene, &mut |growth| {
        seen.push(growth.progress());
        ControlFlow::Continue(())
    });
    let expected = Simulation::new(&scene).unwrap();
    assert_eq!(bits(&simulation.unwrap().view()), bits(&expected.view()));
    assert!(seen.is_sorted_by(|one, next| {
        one.area_fraction <= next.area_fraction
            && one.smallest_scale <= next.smallest_scale
            && one.collisions <= next.collisions
            && one.relaxed <= next.relaxed
    }));
    let last = seen.last().unwrap();
    assert_eq!((last.smallest_scale, last.relaxed), (1.0, 1.0));
    assert!((last.area_fraction - 0.7).abs() < 1e-12 && last.collisions >= 40 * 20 + 400);
    let mut steps = 0;
    let interrupted = with_progress(&scene, &mut |_| {
        steps += 1;
        if steps < 5 {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    });
    assert!(matches!(interrupted, Err(SceneError::Interrupted)) && steps == 5);
    // On a lattice there is nothing to show.
    let lattice = Scene {
        start: StartSpec::default(),
        gas: vec![covering("disc", 10, 0.1)],
        ..scene
    };
    with_progress(&lattice, &mut |_| panic!("no step")).unwrap();
}

#[test]
fn invalid_starts_are_refused_by_name() {
    for relax in [-1.0, 1e10, f64::NAN] {
        let refused = Simulation::new(&grown(vec![covering("disc", 5, 0.1)], relax))
            .unwrap_err()
            .to_string();
        assert!(
            refused.starts_with("start: `relax` must be from 0 to 1e9"),
            "{refused}"
        );
    }
    assert!(Scene::from_toml("[start]\nplacement = \"random\"").is_err());
    let text = "[start]\nplacement = \"grown\"\nrelax = 10\n";
    let read = Scene::from_toml(text).unwrap();
    assert_eq!(
        read.start,
        StartSpec {
            placement: Some(Placement::Grown),
            relax: Some(10.0),
            ..StartSpec::default()
        }
    );
    assert_eq!(Scene::from_toml(&read.to_toml()).unwrap(), read);
    assert!(!Scene::default().to_toml().contains("start"));
}

/// In a box a million times as long as wide 20 discs seldom meet: runs end after a bounded number
/// of events, not after the collisions that a dense gas has.
#[test]
fn growth_and_relaxation_of_gases_that_seldom_collide_end() {
    let gas = GasSpec {
        radius: Some(0.02.into()),
        mass: Some(1.0.into()),
        count: Some(20),
        ..GasSpec::default()
    };
    let mut scene = Scene {
        gas: vec![GasSpec { energy: 1.0, ..gas }],
        ..Scene::default()
    };
    scene.bounds.sides = [1.0, 1e6];
    scene.start = StartSpec {
        placement: Some(Placement::Grown),
        relax: Some(5.0),
        ..StartSpec::default()
    };
    let simulation = Simulation::new(&scene).unwrap();
    assert_eq!(simulation.view().overlaps().pairs, 0);
    assert!((simulation.view().energy() - 20.0).abs() < 1e-12);
}

/// Dumbbells of atoms of 2 · 10⁻¹¹ turn 10⁹ times while they cross the box: an epoch is over long
/// before the next collision, so runs end after a bounded number of epochs.
#[test]
fn growth_of_molecules_that_turn_fast_ends() {
    let mut scene = grown(vec![gas("dumbbell", 2e-11, 20)], 5.0);
    scene.gas[0].energy = 1.0;
    let simulation = Simulation::new(&scene).unwrap();
    assert_eq!(simulation.view().overlaps().pairs, 0);
    assert!((simulation.view().energy() - 20.0).abs() < 1e-12);
}

/// A thick slanted wall leaves slivers of the box free: molecules a million times smaller would not
/// find room either, and the number of places tried is bounded.
#[test]
fn a_box_that_a_wall_fills_is_refused() {
    let mut scene = grown(vec![gas("disc", 0.02, 20)], 0.0);
    scene.bounds.sides = [1.0, 1.66];
    let ends = (Some([0.97, 0.79]), Some([1.0, 2.63]));
    scene.wall = vec![WallSpec {
        from: ends.0,
        to: ends.1,
        radius: 0.5,
        ..WallSpec::default()
    }];
    let error = Simulation::new(&scene).unwrap_err();
    assert!(
        matches!(error, SceneError::Full { requested: 20, .. }),
        "{error}"
    );
}
