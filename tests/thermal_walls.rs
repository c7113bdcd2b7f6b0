//! Walls with a temperature: equal ones bring a gas to that temperature, in translation and in
//! rotation; between unequal ones flows the heat of a collisionless gas; the ledger closes; and
//! runs are the same for both schedulers, in pieces and after a resume.

use std::f64::consts::PI;

use carom_detection::Exact;
use carom_engine::{
    CellsPerSide, CollisionReport, HeapScheduler, Observer, Placement, Scene, SceneError,
    Simulation, WallSpec,
};
use carom_kinematics::EpochTime;
use carom_response::Impact;

/// Standard errors by which a random quantity may differ from its expectation.
const TOLERANCE: f64 = 5.0;

/// A channel between thermal walls at x = 0 and x = 0.5 of the unit box, with a gas on both sides.
fn channel(temperatures: [f64; 2], gas: &str) -> Scene {
    let [one, other] = temperatures;
    Scene::from_toml(&format!(
        "[[wall]]\ntags = [\"one\"]\nx = 0.0\ntemperature = {one:?}\n\
         [[wall]]\ntags = [\"other\"]\nx = 0.5\ntemperature = {other:?}\n[[gas]]\n{gas}"
    ))
    .unwrap()
}

/// Mean of blocks with its standard error.
fn mean(blocks: &[f64]) -> (f64, f64) {
    let count = blocks.len() as f64;
    let mean = blocks.iter().sum::<f64>() / count;
    let squares: f64 = blocks.iter().map(|block| (block - mean).powi(2)).sum();
    (mean, (squares / (count * (count - 1.0))).sqrt())
}

fn assert_near(blocks: &[f64], expected: f64, what: &str) {
    let (mean, error) = mean(blocks);
    assert!(
        error < 0.01 * expected.abs(),
        "{what}: {mean} ± {error} is too uncertain"
    );
    assert!(
        (mean - expected).abs() < TOLERANCE * error,
        "{what}: {mean} ± {error}, expected {expected}"
    );
}

fn assert_booked(simulation: &Simulation) {
    let view = simulation.view();
    let error = (view.energy() - view.ledger().booked()).abs() / view.energy();
    assert!(error < 1e-10, "{error:e}");
    assert!(view.ledger().heat != 0.0 && view.counters().thermal_collisions > 100);
}

/// kT of motion along x, along y and of rotation of all bodies: ⟨m v_x²⟩, ⟨m v_y²⟩, ⟨I ω²⟩.
fn temperatures(simulation: &Simulation) -> [f64; 3] {
    let moving = || {
        simulation
            .view()
            .bodies()
            .filter(|body| !body.body.is_fixed())
            .collect::<Vec<_>>()
    };
    let count = moving().len() as f64;
    let mut sums = [0.0; 3];
    for body in moving() {
        let (inertia, velocity) = (body.body.inertia(), body.motion.velocity);
        sums[0] += velocity.x * velocity.x / inertia.inverse_mass / count;
        sums[1] += velocity.y * velocity.y / inertia.inverse_mass / count;
        sums[2] += body.motion.angular_velocity.powi(2) / inertia.inverse_moment / count;
    }
    sums
}

#[test]
fn a_gas_of_discs_reaches_the_temperature_of_its_walls() {
    // It starts ten times hotter.
    let gas = "radius = 0.01\nmass = 2.0\ntemperature = 15.0\ncount = 100";
    let mut simulation = Simulation::new(&channel([1.5, 1.5], gas)).unwrap();
    simulation.run_until(10.0).unwrap();
    let mut blocks = [vec![], vec![]];
    for sample in 1..=1500 {
        simulation
            .run_until(10.0 + 1.5 * f64::from(sample))
            .unwrap();
        let [x, y, _] = temperatures(&simulation);
        blocks[0].push(x);
        blocks[1].push(y);
    }
    // Isotropic: the kinetic pressure is the same along and across the walls.
    assert_near(&blocks[0], 1.5, "kT along x");
    assert_near(&blocks[1], 1.5, "kT along y");
    assert_booked(&simulation);
    assert_eq!(simulation.view().overlaps().pairs, 0);
    // No momentum is conserved: f = 2 N.
    let kt = simulation.view().temperature().unwrap();
    assert!((kt * 100.0 - simulation.view().energy()).abs() < 1e-9);
}

#[test]
fn dumbbells_between_equal_walls_share_the_energy_with_their_rotation() {
    // Without collisions between them, the walls alone must give the distribution: single
    // dumbbells, one on each side, in many replicas of a long run.
    let gas = "shape = \"dumbbell\"\natom_radius = 0.03\natom_mass = 1.0\ntemperature = 5.0\ncount = 2\n\
               zero_momentum = false";
    let mut blocks = [vec![], vec![], vec![]];
    for replica in 0..40 {
        let mut scene = channel([0.7, 0.7], gas);
        scene.bounds.replica = replica;
        let mut simulation = Simulation::new(&scene).unwrap();
        simulation.run_until(20.0).unwrap();
        let mut sums = [0.0; 3];
        let samples = 2000;
        for sample in 1..=samples {
            simulation
                .run_until(20.0 + 0.5 * f64::from(sample))
                .unwrap();
            for (sum, kt) in sums.iter_mut().zip(temperatures(&simulation)) {
                *sum += kt / f64::from(samples);
            }
        }
        for (blocks, sum) in blocks.iter_mut().zip(sums) {
            blocks.push(sum);
        }
        assert_booked(&simulation);
    }
    for (blocks, what) in blocks.iter().zip(["x", "y", "rotation"]) {
        assert_near(blocks, 0.7, what);
    }
}

#[test]
fn a_dense_gas_of_dumbbells_and_discs_is_isotropic_at_the_temperature_of_all_walls() {
    // Walls with end points, of some thickness, and across the box.
    let scene = Scene::from_toml(
        "[[wall]]\nfrom = [0.3, 0.2]\nto = [0.5, 0.6]\nradius = 0.01\ntemperature = 2.0\n\
         [[wall]]\ny = 0.0\ntemperature = 2.0\n\
         [[gas]]\nshape = \"dumbbell\"\natom_radius = 0.02\natom_mass = 1.0\ntemperature = 0.5\ncount = 60\n\
         [[gas]]\nradius = 0.03\nmass = 5.0\ntemperature = 0.5\ncount = 40",
    )
    .unwrap();
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.run_until(10.0).unwrap();
    let mut blocks = [vec![], vec![]];
    for sample in 1..=800 {
        simulation.run_until(10.0 + f64::from(sample)).unwrap();
        let [x, y, _] = temperatures(&simulation);
        blocks[0].push(x);
        blocks[1].push(y);
    }
    assert_near(&blocks[0], 2.0, "kT along x");
    assert_near(&blocks[1], 2.0, "kT along y");
    assert_booked(&simulation);
    assert_eq!(simulation.view().overlaps().pairs, 0);
}

/// Heat given by each of two walls, and the contacts with it.
#[derive(Default)]
struct Heat {
    given: [f64; 2],
    hits: [f64; 2],
}

impl Observer for Heat {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let Some(wall) = report
            .sides
            .iter()
            .position(|side| side.body.wall_temperature().is_some())
        else {
            return;
        };
        let side = &report.sides[1 - wall];
        let mass = 1.0 / side.body.inertia().inverse_mass;
        let change = side.after.velocity.length_squared() - side.before.velocity.length_squared();
        let index = report.sides[wall].body.id() as usize;
        self.given[index] += 0.5 * mass * change;
        self.hits[index] += 1.0;
    }
}

#[test]
fn heat_flows_between_walls_as_in_a_collisionless_gas() {
    // Free molecular flow in two dimensions, exact for points that never meet. A body leaves a wall
    // of temperature T with the flux-weighted energy ⟨½ m v²⟩ = kT (normal: ∫ ½ m v³ e / ∫ v e =
    // kT) + ½ kT (along the wall) = 3/2 kT, and carries it to the other wall. With ⟨1/v_x⟩ = √(π
    // m/2kT) over the flux, a round trip over the width W of the channel takes W √(π m/2) (1/√kT₁ +
    // 1/√kT₂) on average, so that the heat per time and body is
    //     q = 3/2 (kT₁ − kT₂) / (W √(π m/2) (1/√kT₁ + 1/√kT₂)).
    // One disc between the walls on each side: the two never touch.
    let (hot, cold, mass, radius) = (4.0f64, 1.0f64, 2.0, 0.01);
    let gas = format!("radius = {radius}\nmass = {mass:?}\ntemperature = 1.0\ncount = 1");
    let width = 0.5 - 2.0 * radius;
    let round_trip = width * (0.5 * PI * mass).sqrt() * (hot.powf(-0.5) + cold.powf(-0.5));
    let expected = 1.5 * (hot - cold) / round_trip;
    let (mut flux, mut rate) = (vec![], vec![]);
    for replica in 0..40 {
        let mut scene = channel([hot, cold], &gas);
        scene.bounds.replica = replica;
        let mut simulation = Simulation::new(&scene).unwrap();
        simulation.run_until(20.0).unwrap();
        let mut heat = Heat::default();
        let time = 15_000.0;
        simulation.observe_until(20.0 + time, &mut heat).unwrap();
        assert_eq!(
            simulation.view().counters().collisions,
            simulation.view().counters().thermal_collisions
        );
        flux.push(0.5 * (heat.given[0] - heat.given[1]) / time);
        rate.push(0.5 * (heat.hits[0] + heat.hits[1]) / time);
        assert_booked(&simulation);
    }
    assert_near(&flux, expected, "heat per time");
    assert_near(&rate, 1.0 / round_trip, "round trips per time");
}

/// A scene with thermal walls and all kinds of bodies.
fn mixed() -> Scene {
    let mut scene = crate::support::reference_scene(8);
    scene.wall = channel(
        [1.0, 3.0],
        "radius = 0.1\nmass = 1.0\nenergy = 1.0\ncount = 1",
    )
    .wall;
    scene.wall[1].x = Some(0.13);
    scene.molecule.retain(|molecule| !molecule.fixed);
    scene.gas.truncate(1);
    scene.gas.push(crate::support::gas("dumbbell", 0.01, 12));
    scene.bumper.retain(|bumper| bumper.at[0] > 0.2);
    scene
}

/// The bits of all motions.
fn bits(bodies: impl Iterator<Item = carom_kinematics::Motion>) -> Vec<[u64; 6]> {
    let of = |motion: carom_kinematics::Motion| {
        let (place, velocity) = (motion.position, motion.velocity);
        [
            place.x,
            place.y,
            velocity.x,
            velocity.y,
            motion.orientation.turns(),
            motion.angular_velocity,
        ]
        .map(f64::to_bits)
    };
    bodies.map(of).collect()
}

#[test]
fn a_resumed_run_has_the_bits_of_an_uninterrupted_one() {
    let scene = mixed();
    let mut whole = Simulation::new(&scene).unwrap();
    whole.run_until(1.0).unwrap();
    let mut parts = Simulation::new(&scene).unwrap();
    let mut resumes = 0;
    while !parts.observe_epoch(EpochTime::from(1.0), &mut ()).unwrap() {
        let Some(checkpoint) = parts.checkpoint() else {
            continue;
        };
        let written = postcard::to_stdvec(&checkpoint).unwrap();
        parts = Simulation::resume(&postcard::from_bytes(&written).unwrap()).unwrap();
        resumes += 1;
    }
    assert!(resumes > 2, "{resumes}");
    let motions = [&whole, &parts].map(|one| bits(one.view().bodies().map(|body| body.motion)));
    assert_eq!(motions[0], motions[1]);
    assert_eq!(whole.view().ledger(), parts.view().ledger());
    assert!(whole.view().counters().thermal_collisions > 50);
    // Another replica has other random numbers, from the same start.
    let mut other = scene.clone();
    other.bounds.replica = 1;
    let start = bits(
        Simulation::new(&scene)
            .unwrap()
            .view()
            .bodies()
            .map(|body| body.motion),
    );
    let again = bits(
        Simulation::new(&other)
            .unwrap()
            .view()
            .bodies()
            .map(|body| body.motion),
    );
    assert_ne!(start, again);
}

#[test]
fn both_schedulers_draw_the_same_numbers() {
    let scene = mixed();
    let mut cells = Simulation::new(&scene).unwrap();
    let mut heap: Simulation<Exact, Impact, HeapScheduler> =
        Simulation::with(&scene, Exact::default(), Impact, CellsPerSide::Automatic).unwrap();
    // Until chaos has amplified their different rounding.
    let time = 0.1;
    cells.run_until(time).unwrap();
    heap.run_until(time).unwrap();
    assert_eq!(
        cells.view().counters().thermal_collisions,
        heap.view().counters().thermal_collisions
    );
    assert!(cells.view().counters().thermal_collisions > 3);
    let heats = [cells.view().ledger().heat, heap.view().ledger().heat];
    assert!((heats[0] / heats[1] - 1.0).abs() < 1e-6, "{heats:?}");
}

#[test]
fn walls_are_elastic_while_a_dense_gas_is_grown() {
    let mut scene = channel(
        [1.0, 1.0],
        "shape = \"dumbbell\"\natom_radius = 0.03\natom_mass = 1.0\ntemperature = 2.0\ncount = 90",
    );
    scene.start.placement = Some(Placement::Grown);
    scene.start.relax = Some(20.0);
    let mut simulation = Simulation::new(&scene).unwrap();
    assert!((simulation.view().energy() / 270.0 - 1.0).abs() < 1e-12);
    assert_eq!(simulation.view().ledger().heat, 0.0);
    simulation.run_until(0.5).unwrap();
    assert_booked(&simulation);
    assert_eq!(simulation.view().overlaps().pairs, 0);
}

#[test]
fn a_wall_added_during_a_run_heats_too() {
    let gas = "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 1";
    let mut simulation = Simulation::new(&Scene::from_toml(gas).unwrap()).unwrap();
    simulation.run_until(1.0).unwrap();
    assert_eq!(simulation.view().counters().thermal_collisions, 0);
    let place = simulation.view().bodies().next().unwrap().motion.position;
    let x = (place.x + 0.5).fract();
    let wall = WallSpec {
        x: Some(x),
        temperature: Some(100.0),
        ..WallSpec::default()
    };
    let wall = simulation.edit(|batch| batch.add_wall(&wall)).unwrap();
    simulation.run_until(200.0).unwrap();
    assert_booked(&simulation);
    assert!(simulation.view().ledger().heat > 1.0);
    let hits = simulation.view().counters().thermal_collisions;
    simulation.edit(|batch| batch.remove(wall)).unwrap();
    simulation.run_until(300.0).unwrap();
    assert_eq!(simulation.view().counters().thermal_collisions, hits);
}

#[test]
fn temperatures_out_of_range_are_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e61] {
        let mut scene = channel(
            [1.0, 1.0],
            "radius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 10",
        );
        scene.wall[1].temperature = Some(bad);
        let error = Simulation::new(&scene).unwrap_err();
        assert!(matches!(error, SceneError::Entry { .. }), "{error}");
        assert!(
            error
                .to_string()
                .contains("wall[1]: `temperature` of a wall must be from 1e-60"),
            "{error}"
        );
    }
    let scene = channel(
        [1.0, 2.0],
        "radius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 10",
    );
    assert_eq!(Scene::from_toml(&scene.to_toml()).unwrap(), scene);
}

/// A hot wall at 0 and a cold one at the side of the box are one line: which of the two a body
/// meets would be decided by rounding.
#[test]
fn unlike_walls_in_the_same_place_are_refused() {
    let segment = |from, to, temperature| WallSpec {
        from: Some(from),
        to: Some(to),
        temperature,
        ..WallSpec::default()
    };
    let line = |x, temperature| WallSpec {
        x: Some(x),
        temperature,
        ..WallSpec::default()
    };
    let build = |wall: &[WallSpec]| {
        let mut scene = Scene::from_toml("box.sides = [2.0, 1.0]").unwrap();
        scene.wall = wall.to_vec();
        Simulation::new(&scene).map(|_| ())
    };
    let (hot, cold) = (Some(2.0), Some(0.5));
    for pair in [
        [line(0.0, hot), line(2.0, cold)],
        [line(0.0, hot), line(2.0, None)],
        [line(0.7, hot), line(-3.3, cold)],
        [line(0.7, hot), segment([0.7, 0.2], [0.7, 0.4], cold)],
        [
            segment([0.1, 0.9], [0.6, 1.4], hot),
            segment([0.3, 0.1], [0.4, 0.2], cold),
        ],
        [
            segment([-9.0, 0.5], [9.0, 0.5], hot),
            segment([1.9, 3.5], [1.95, 3.5], None),
        ],
    ] {
        let error = build(&pair).unwrap_err().to_string();
        assert!(
            error.starts_with("wall[1]: the wall has ") && error.contains("same place"),
            "{error}"
        );
    }
    for allowed in [
        vec![line(0.0, hot), line(1.0, cold)],
        vec![line(0.0, hot), line(2.0, hot)],
        vec![
            segment([0.0, 0.0], [0.0, 0.5], hot),
            segment([0.0, 0.5], [0.0, 1.0], cold),
        ],
        vec![line(0.0, hot), segment([0.0, 0.5], [1.0, 0.5], cold)],
        vec![
            segment([0.1, 0.9], [0.6, 1.4], hot),
            segment([0.3, 0.15], [0.4, 0.25], cold),
        ],
    ] {
        build(&allowed).unwrap();
    }
}
