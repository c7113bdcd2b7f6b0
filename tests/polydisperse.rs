//! Gases of drawn sizes and masses: the sizes are those of the distribution, dense starts have no
//! overlap, and heavy and light molecules share the energy by equipartition.

use carom_detection::Exact;
use carom_engine::{
    CellScheduler, Distribution, GasSpec, HeapScheduler, Placement, Scene, Simulation,
    StartVelocities, View,
};
use carom_response::Impact;

/// Standard errors by which a random quantity may differ from its expectation.
const TOLERANCE: f64 = 5.0;

fn read(text: &str) -> Scene {
    Scene::from_toml(text).unwrap()
}

fn refusal(gas: &str) -> String {
    let text = format!("[[gas]]\ntemperature = 1.0\ncount = 10\n{gas}");
    match Scene::from_toml(&text) {
        Ok(scene) => Simulation::new(&scene).expect_err("refused").to_string(),
        Err(error) => error.to_string(),
    }
}

fn radii(view: &View<'_>) -> Vec<f64> {
    view.bodies()
        .map(|body| body.body.molecule().bounding_radius())
        .collect()
}

fn covered(view: &View<'_>) -> f64 {
    view.bodies()
        .map(|body| body.body.molecule().area())
        .sum::<f64>()
        / view.bounds().area()
}

#[test]
fn drawn_radii_have_the_moments_of_their_distribution() {
    let scene =
        read("[[gas]]\nradius = { uniform = [7e-4, 13e-4] }\nmass = 2\nenergy = 1.0\ncount = 5000");
    let simulation = Simulation::new(&scene).unwrap();
    let radii = radii(&simulation.view());
    let count = radii.len() as f64;
    let mean = radii.iter().sum::<f64>() / count;
    // (a + b)/2, with the standard error (b − a)/√(12 N).
    assert!(
        (mean - 1e-3).abs() < TOLERANCE * 6e-4 / (12.0 * count).sqrt(),
        "{mean}"
    );
    let square = radii.iter().map(|radius| radius * radius).sum::<f64>() / count;
    // (a² + ab + b²)/3; ⟨r⁴⟩ = (b⁵ − a⁵)/5(b − a).
    let (expected, fourth) = (1.03e-6, (1.3f64.powi(5) - 0.7f64.powi(5)) / 3.0 * 1e-12);
    let error = ((fourth - expected * expected) / count).sqrt();
    assert!((square - expected).abs() < TOLERANCE * error, "{square}");
    assert!(radii.iter().all(|radius| (7e-4..=13e-4).contains(radius)));
}

#[test]
fn each_kind_of_gas_reaches_its_area_fraction_with_masses_by_area() {
    for shape in ["disc", "dumbbell", "tee"] {
        let scene = read(&format!(
            "[[gas]]\nshape = \"{shape}\"\natom_radius = {{ normal = [0.004, 0.001] }}\ndensity = 500.0\n\
             temperature = 2.0\nvelocities = \"maxwell\"\narea_fraction = 0.1"
        ));
        let simulation = Simulation::new(&scene).unwrap();
        let view = simulation.view();
        let largest = view
            .bodies()
            .map(|body| body.body.molecule().area())
            .fold(0.0, f64::max);
        assert!((covered(&view) - 0.1).abs() <= 0.5 * largest, "{shape}");
        for body in view.bodies() {
            let molecule = body.body.molecule();
            assert!((molecule.mass() / (500.0 * molecule.area()) - 1.0).abs() < 1e-12);
        }
        assert!((view.temperature().unwrap() / 2.0 - 1.0).abs() < 1e-12);
        assert!(view.momentum().length() < 1e-10);
        assert_eq!(view.overlaps().pairs, 0);
    }
}

#[test]
fn a_list_of_atoms_has_a_scale() {
    let scene = read(
        "[[gas]]\natoms = [{ at = [0, 0], radius = 0.01, mass = 3 }, { at = [0.012, 0], radius = 0.005, mass = 1 }]\n\
         scale = { values = [0.5, 1.0], weights = [3, 1] }\nenergy = 1.0\ncount = 400",
    );
    let simulation = Simulation::new(&scene).unwrap();
    let largest = radii(&simulation.view()).into_iter().fold(0.0, f64::max);
    let (mut large, mut small) = (0, 0);
    for body in simulation.view().bodies() {
        let molecule = body.body.molecule();
        assert!((molecule.mass() - 4.0).abs() < 1e-12);
        if molecule.bounding_radius() > 0.9 * largest {
            large += 1;
        } else {
            small += 1;
        }
        assert!(molecule.bounding_radius() > 0.499 * largest);
    }
    assert_eq!(large + small, 400);
    // Binomial: 100 ± √(400 · 3/16).
    assert!(
        (f64::from(large) - 100.0).abs() < TOLERANCE * 75f64.sqrt(),
        "{large}"
    );
}

#[test]
fn the_seed_fixes_the_sizes_and_other_gases_keep_their_bits() {
    let drawn = "[[gas]]\nradius = { uniform = [0.01, 0.02] }\nmass = { uniform = [1, 2] }\nenergy = 1.0\ncount = 40\n";
    let bits = |text: &str| -> Vec<[u64; 3]> {
        let simulation = Simulation::new(&read(text)).unwrap();
        let of = |body: carom_engine::BodyView<'_>| {
            [
                body.body.molecule().bounding_radius(),
                body.body.molecule().mass(),
                body.motion.position.x,
            ]
            .map(f64::to_bits)
        };
        simulation.view().bodies().map(of).collect()
    };
    assert_eq!(bits(drawn), bits(drawn));
    let replica = format!("box.replica = 1\n{drawn}");
    assert!(
        bits(drawn)
            .iter()
            .zip(bits(&replica))
            .all(|(one, other)| one[0] != other[0])
    );
    // Sizes do not depend on the gases before.
    let plain = "[[gas]]\nradius = 0.005\nmass = 1.0\nenergy = 1.0\ncount = 3\n";
    let second = bits(&format!("{drawn}{plain}"));
    assert!(
        bits(drawn)
            .iter()
            .zip(second)
            .all(|(one, other)| one[..2] == other[..2])
    );
    // One value is no distribution: the gas has the bits of equal molecules.
    let one = "[[gas]]\nradius = { values = [0.01] }\nmass = 1.0\nenergy = 1.0\ncount = 40\n";
    let equal = "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 40\n";
    assert_eq!(bits(one), bits(equal));
}

#[test]
fn a_dense_polydisperse_gas_is_grown_without_overlap() {
    let scene = read(
        "[start]\nrelax = 20\n[[gas]]\nradius = { uniform = [0.021, 0.039] }\ndensity = 1.0\ntemperature = 1.0\n\
         area_fraction = 0.80",
    );
    let mut simulation = Simulation::new(&scene).unwrap();
    assert!((covered(&simulation.view()) - 0.8).abs() < 0.0025);
    assert_eq!(simulation.view().overlaps().pairs, 0);
    assert!((simulation.view().temperature().unwrap() - 1.0).abs() < 1e-12);
    assert!(
        radii(&simulation.view())
            .iter()
            .all(|radius| (0.021..=0.039).contains(radius))
    );
    let time = 0.02;
    simulation.run_until(time).unwrap();
    assert_eq!(simulation.view().overlaps().pairs, 0);
    // A growth stored half way continues to the same state.
    let mut growth = carom_engine::Growth::new(&scene).unwrap();
    for _ in 0..20 {
        growth.step().unwrap();
    }
    let stored = postcard::to_stdvec(&growth).unwrap();
    let resumed: carom_engine::Growth = postcard::from_bytes(&stored).unwrap();
    let mut resumed = resumed.finish().unwrap();
    resumed.run_until(time).unwrap();
    let energies = [&simulation, &resumed].map(|one| one.view().energy().to_bits());
    assert_eq!(energies[0], energies[1]);
    let places = |one: &Simulation| -> Vec<[u64; 2]> {
        one.view()
            .bodies()
            .map(|body| body.motion.position.to_array().map(f64::to_bits))
            .collect()
    };
    assert_eq!(places(&simulation), places(&resumed));
}

#[test]
fn heavy_and_light_molecules_share_the_energy() {
    // At equal energies all have the mean energy; after many collisions heavy and light ones still
    // do, and the speeds of all are Maxwell's: ⟨E²⟩ = 2⟨E⟩² in two dimensions.
    let mut scene = read(
        "[[gas]]\nradius = { uniform = [0.007, 0.013] }\nmass = { values = [1.0, 20.0] }\ntemperature = 1.0\n\
         count = 600",
    );
    scene.bounds.seed = 3;
    let mut simulation = Simulation::new(&scene).unwrap();
    let (mut light, mut heavy, mut squares, mut samples) = (0.0, 0.0, 0.0, 0.0);
    let mut counts = [0.0; 2];
    for sample in 1..=40 {
        simulation.run_until(0.15 * f64::from(sample)).unwrap();
        if sample <= 10 {
            continue;
        }
        samples += 1.0;
        for body in simulation.view().bodies() {
            let mass = body.body.molecule().mass();
            let energy = 0.5 * mass * body.motion.velocity.length_squared();
            squares += energy * energy;
            if mass > 2.0 {
                heavy += energy;
                counts[1] += 1.0;
            } else {
                light += energy;
                counts[0] += 1.0;
            }
        }
    }
    let (light, heavy) = (light / counts[0], heavy / counts[1]);
    let independent = 300.0 * samples / 10.0;
    assert!(
        (light - 1.0).abs() < TOLERANCE / f64::sqrt(independent),
        "{light}"
    );
    assert!(
        (heavy - 1.0).abs() < TOLERANCE / f64::sqrt(independent),
        "{heavy}"
    );
    let fourth = squares / (600.0 * samples);
    assert!(
        (fourth - 2.0).abs() < TOLERANCE * (20.0 / (2.0 * independent)).sqrt(),
        "{fourth}"
    );
}

#[test]
fn both_schedulers_agree_and_equal_energies_have_no_momentum() {
    let scene = read(
        "[[gas]]\nradius = { values = [0.004, 0.03], weights = [9, 1] }\nmass = { normal = [1.0, 0.3] }\n\
         energy = 1.0\ncount = 300",
    );
    let mut cells = Simulation::<Exact, Impact, CellScheduler>::new(&scene).unwrap();
    let view = cells.view();
    assert!((view.energy() / 300.0 - 1.0).abs() < 1e-12);
    assert!(view.momentum().length() < 1e-11);
    for body in view.bodies() {
        let energy = 0.5 * body.body.molecule().mass() * body.motion.velocity.length_squared();
        assert!((energy - 1.0).abs() < 0.5, "{energy}");
    }
    let mut heap: Simulation<Exact, Impact, HeapScheduler> = Simulation::with(
        &scene,
        Exact::default(),
        Impact,
        carom_engine::CellsPerSide::Automatic,
    )
    .unwrap();
    cells.run_until(0.05).unwrap();
    heap.run_until(0.05).unwrap();
    assert_eq!(
        cells.view().counters().collisions,
        heap.view().counters().collisions
    );
    assert_eq!(cells.view().overlaps().pairs, 0);
}

#[test]
fn a_scene_with_distributions_survives_its_text() {
    let scene = read(
        "[[gas]]\nradius = { normal = [0.01, 0.001] }\natom_mass = { values = [1.0, 2.0] }\ntemperature = 1.0\ncount = 9\n\
         [[gas]]\nshape = \"tee\"\natom_radius = 0.01\ndensity = 3.0\nscale = { uniform = [1, 2] }\nenergy = 1.0\ncount = 3\n",
    );
    assert_eq!(
        scene.gas[0].radius,
        Some(Distribution::Normal([0.01, 0.001]).into())
    );
    assert_eq!(Scene::from_toml(&scene.to_toml()).unwrap(), scene);
    let by_code = GasSpec {
        radius: Some(Distribution::Uniform([0.01, 0.02]).into()),
        mass: Some(1.0.into()),
        temperature: Some(1.0),
        velocities: StartVelocities::Maxwell,
        count: Some(10),
        ..GasSpec::default()
    };
    let mut scene = Scene {
        gas: vec![by_code],
        ..Scene::default()
    };
    scene.start.placement = Some(Placement::Lattice);
    assert_eq!(Scene::from_toml(&scene.to_toml()).unwrap(), scene);
    assert_eq!(Simulation::new(&scene).unwrap().view().len(), 10);
}

#[test]
fn distributions_out_of_range_are_refused_by_name() {
    for (gas, expected) in [
        (
            "radius = { uniform = [0.02, 0.01] }\nmass = 1.0",
            "gas[0]: `radius`: `uniform` must be two numbers",
        ),
        (
            "radius = { uniform = [0.0, 0.01] }\nmass = 1.0",
            "ascending order from 1e-60",
        ),
        (
            "radius = { normal = [0.01, -1] }\nmass = 1.0",
            "standard deviation from 0",
        ),
        (
            "radius = { normal = [nan, 1] }\nmass = 1.0",
            "`normal` must be a mean",
        ),
        (
            "radius = { values = [] }\nmass = 1.0",
            "at least one number",
        ),
        (
            "radius = { values = [1, 2], weights = [1] }\nmass = 1.0",
            "2 `values` have 1 `weights`",
        ),
        (
            "radius = { values = [0.1, 0.2], weights = [0, 0] }\nmass = 1.0",
            "must be above 0",
        ),
        (
            "radius = { values = [0.1, 0.2], weights = [1, -1] }\nmass = 1.0",
            "`weights` must be from 0",
        ),
        (
            "radius = { uniform = [1, 2], normal = [1, 2] }\nmass = 1.0",
            "unexpected key `uniform`",
        ),
        (
            "radius = { lognormal = [1, 2] }\nmass = 1.0",
            "unexpected key `lognormal`: give `{ uniform",
        ),
        ("radius = { weights = [1] }\nmass = 1.0", "give `{ uniform"),
        ("radius = \"large\"\nmass = 1.0", "a number, `{ uniform"),
        (
            "radius = { uniform = [1, 2] }\natom_radius = 1.0\nmass = 1.0",
            "either `radius` or `atom_radius`",
        ),
        (
            "radius = { uniform = [1, 2] }\natom_radius = { uniform = [1, 2] }",
            "either `radius` or `atom_radius`",
        ),
        (
            "radius = 0.01\nmass = { uniform = [1, 2] }\ndensity = 1.0",
            "either `density` or a mass",
        ),
        ("radius = 0.01\ndensity = -1.0", "`density` must be from"),
        (
            "radius = { uniform = [0.01, 0.02] }",
            "a disc needs a mass: `mass` in a gas",
        ),
        ("density = 1.0", "a disc needs a radius: `radius` in a gas"),
        (
            "atoms = [{ at = [0, 0], radius = 0.01, mass = 1 }]\nradius = { uniform = [1, 2] }",
            "a list of atoms or ellipses has a `scale`",
        ),
        (
            "radius = { uniform = [0.4, 0.9] }\nmass = 1.0",
            "only 0 of 10 molecules can be placed",
        ),
    ] {
        let message = refusal(gas);
        assert!(message.contains(expected), "{gas}: {message}");
    }
}

#[test]
fn too_many_drawn_molecules_are_refused_before_they_are_drawn() {
    // About 1e10 molecules: as many would not fit into the memory.
    for gas in [
        "radius = { uniform = [0.01, 0.02] }\nmass = 1.0\nenergy = 1.0\narea_fraction = 0.2",
        "radius = { normal = [0.015, 0.001] }\nmass = 1.0\nenergy = 1.0\narea_fraction = 0.2",
        "shape = \"tee\"\natom_radius = 1.0\ndensity = 1.0\nscale = { values = [0.01, 0.02], weights = [1, 3] }\n\
         energy = 1.0\narea_fraction = 0.5",
    ] {
        let scene = read(&format!(
            "box.sides = [134217729.0, 0.3376]\n[[gas]]\n{gas}"
        ));
        let error = Simulation::new(&scene).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("at most 2^27 molecules"), "{error}");
    }
}
