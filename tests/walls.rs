//! Walls: bounces at known times, no body passes through, the ledger records the energy lost, and
//! invalid walls are refused.

use crate::support::{
    Encounters, bits, bumper, disc, gas, named, scene, simulate, test_each_scheduler, velocity,
};
use carom_detection::{BoundingCircles, Exact, GoldenSecant};
use carom_engine::{
    CellsPerSide, CollisionReport, EditError, ElasticityRule, HeapScheduler, Instructions,
    MoleculeSpec, Observer, Scene, SceneError, Scheduler, Simulation, WallSpec,
};
use carom_kinematics::EpochTime;
use carom_response::Impact;
use glam::DVec2;

fn line_x(x: f64) -> WallSpec {
    WallSpec {
        x: Some(x),
        ..WallSpec::default()
    }
}

fn line_y(y: f64) -> WallSpec {
    WallSpec {
        y: Some(y),
        ..WallSpec::default()
    }
}

fn segment(from: [f64; 2], to: [f64; 2]) -> WallSpec {
    WallSpec {
        from: Some(from),
        to: Some(to),
        ..WallSpec::default()
    }
}

fn with_walls(wall: Vec<WallSpec>, scene: Scene) -> Scene {
    Scene { wall, ..scene }
}

test_each_scheduler! {
    a_disc_between_two_walls_bounces_at_the_known_times: check_bounces;
    end_points_and_parts_across_the_border_are_hit_at_the_known_times: check_ends;
    an_oblique_wall_reflects_to_rounding_for_ten_thousand_bounces: check_oblique;
    a_closed_box_conserves_its_energy_and_lets_no_body_out: check_closed_box;
    velocities_times_two_give_the_same_paths: check_scaling;
    a_wall_can_be_added_and_removed: check_coming_and_going;
}

fn check_bounces<S: Scheduler>(options: &S::Options) {
    // Powers of two: each time and position is a float, so that all agree to the bit. The second
    // pair of walls is equivalent to the first, in other images: a segment with a thickness, and a
    // line.
    let thick = WallSpec {
        radius: 0.0625,
        ..segment([-2.1875, -2.0], [-2.1875, -1.0])
    };
    for walls in [vec![line_x(0.25), line_x(0.75)], vec![line_x(5.25), thick]] {
        let start = scene(vec![disc(0.125, 1.0, [0.5, 0.5], [0.5, 0.0])]);
        let mut simulation = simulate::<S>(&with_walls(walls, start), options);
        let mut bounces = Encounters::since(EpochTime::ZERO);
        simulation.observe_until(5100.0, &mut bounces).unwrap();
        assert_eq!(bounces.list.len(), 10_200);
        for (count, time) in bounces.times().into_iter().enumerate() {
            assert_eq!(time, 0.25 + 0.5 * count as f64, "bounce {count}");
        }
        assert_eq!(velocity(&simulation.view(), 0).abs(), DVec2::new(0.5, 0.0));
    }
    // Arbitrary numbers: the error grows with time only as rounding does.
    let mut odd = with_walls(vec![line_x(0.1), line_x(0.9)], scene_of_odd_numbers());
    for (sides, bounces_wanted) in [([1.0, 1.0], 10_000u32), ([3.0, 0.7], 2_000)] {
        odd.bounds.sides = sides;
        let mut simulation = simulate::<S>(&odd, options);
        let mut bounces = Encounters::since(EpochTime::ZERO);
        while bounces.list.len() < bounces_wanted as usize {
            simulation.step(1e9, &mut bounces).unwrap();
        }
        let (first, period) = ((0.9 - 0.07 - 0.5) / 0.37, (0.8 - 2.0 * 0.07) / 0.37);
        for (count, time) in bounces.times().into_iter().enumerate() {
            let expected = first + period * count as f64;
            assert!(
                (time - expected).abs() < 1e-12 * (1.0 + expected),
                "bounce {count}: {time} not {expected}"
            );
        }
        assert_eq!(
            velocity(&simulation.view(), 0).abs(),
            DVec2::new(0.37, 0.21)
        );
    }
}

fn scene_of_odd_numbers() -> Scene {
    scene(vec![disc(0.07, 1.3, [0.5, 0.3], [0.37, 0.21])])
}

fn check_ends<S: Scheduler>(options: &S::Options) {
    let wall = segment([0.9, 0.5], [1.25, 0.5]);
    let fall = |x: f64| disc(0.05, 1.0, [x, 0.875], [0.0, -0.5]);
    let first = |molecule: MoleculeSpec| {
        let mut simulation = simulate::<S>(
            &with_walls(vec![wall.clone()], scene(vec![molecule])),
            options,
        );
        let mut met = Encounters::since(EpochTime::ZERO);
        let contact = simulation.step(1.0, &mut met).unwrap();
        (
            contact.then(|| met.list[0]),
            velocity(&simulation.view(), 0),
        )
    };
    // On the face, on either side of the border: 0.325 down at speed 1/2, and straight back.
    for x in [0.95, 0.0, 0.1, 0.25] {
        let (met, after) = first(fall(x));
        let met = met.expect("the wall is hit");
        assert!(
            (met.time - 0.65).abs() < 1e-15 && met.atoms == [Some(0), None],
            "{x}: {met:?}"
        );
        assert_eq!(after, DVec2::new(0.0, 0.5), "{x}");
    }
    // 0.03 past the end: 0.04 above it at contact, and deflected by twice the angle of (3, 4)/5.
    for (x, end, sideways) in [(0.28, 1, 1.0), (0.87, 0, -1.0)] {
        let (met, after) = first(fall(x));
        let met = met.expect("the end is hit");
        assert!(
            (met.time - 2.0 * (0.375 - 0.04)).abs() < 1e-14 && met.atoms == [Some(0), Some(end)],
            "{met:?}"
        );
        let expected = 0.5 * DVec2::new(sideways * 0.96, 0.28);
        assert!(
            (after - expected).length() < 1e-14,
            "{after} against {expected}"
        );
    }
    // Past the end by more than the radius.
    for x in [0.301, 0.849] {
        assert_eq!(first(fall(x)).0, None, "{x}");
    }
    // Onto the end, along the wall.
    let (met, after) = first(disc(0.05, 1.0, [0.5, 0.5], [-1.0, 0.0]));
    assert!((met.expect("the wall is hit").time - 0.2).abs() < 1e-15);
    assert_eq!(after, DVec2::X);
}

fn check_oblique<S: Scheduler>(options: &S::Options) {
    // Two parallel walls tilted by 3 : 4, with a disc between them.
    let walls = vec![
        segment([-0.2, -0.1], [1.4, 1.1]),
        segment([0.1, -0.3], [1.7, 0.9]),
    ];
    let mut simulation = simulate::<S>(
        &with_walls(
            walls,
            scene(vec![disc(0.02, 1.0, [0.55, 0.25], [0.3, -0.4])]),
        ),
        options,
    );
    let (normal, along) = (DVec2::new(-0.6, 0.8), DVec2::new(0.8, 0.6));
    let mut bounces = Encounters::since(EpochTime::ZERO);
    while bounces.list.len() < 10_000 {
        simulation.step(1e9, &mut bounces).unwrap();
        let velocity = velocity(&simulation.view(), 0);
        // v = (0.3, −0.4) is perpendicular to the walls. Each bounce may round by 1e-16.
        assert!(
            (velocity.dot(normal).abs() - 0.5).abs() < 1e-12,
            "{velocity}"
        );
        assert!(velocity.dot(along).abs() < 1e-12, "{velocity}");
    }
    assert!((simulation.view().energy() - 0.125).abs() < 1e-13);
}

/// Five hundred discs and some molecules in a closed box with a flap in it.
fn closed_box(seed: u64) -> Scene {
    let flap = WallSpec {
        radius: 0.005,
        ..segment([0.3, 0.2], [0.6, 0.5])
    };
    let mut scene = with_walls(
        vec![
            line_x(0.0),
            line_y(0.0),
            flap,
            segment([0.7, 0.0], [0.7, 0.4]),
        ],
        scene(vec![]),
    );
    scene.bounds.seed = seed;
    scene.bumper = vec![bumper(0.03, [0.0, 0.0])];
    scene.gas = vec![
        gas("disc", 0.01, 200),
        gas("tee", 0.008, 20),
        gas("rod:7", 0.005, 10),
    ];
    scene
}

fn check_closed_box<S: Scheduler>(options: &S::Options) {
    let mut simulation = simulate::<S>(&closed_box(3), options);
    let energy = simulation.view().energy();
    let windings: Vec<_> = simulation
        .view()
        .bodies()
        .map(|body| body.winding)
        .collect();
    for stop in 1..=20 {
        simulation.run_until(0.1 * f64::from(stop)).unwrap();
        let view = simulation.view();
        assert_eq!(view.overlaps().pairs, 0, "{:?}", view.overlaps());
        assert!((view.energy() - energy).abs() < 1e-12 * energy);
        assert!(
            view.bodies()
                .zip(&windings)
                .all(|(body, winding)| body.winding == *winding)
        );
    }
    assert!(simulation.view().counters().fixed_collisions > 1000);
}

fn check_scaling<S: Scheduler>(options: &S::Options) {
    let run = |factor: f64| {
        let mut scene = closed_box(4);
        scene
            .gas
            .iter_mut()
            .for_each(|gas| gas.energy *= factor * factor);
        let mut simulation = simulate::<S>(&scene, options);
        simulation.run_until(1.0 / factor).unwrap();
        let motions: Vec<_> = simulation.view().bodies().map(|body| body.motion).collect();
        (motions, *simulation.view().counters())
    };
    let (one, counters) = run(1.0);
    for factor in [2.0, 2f64.powi(-20)] {
        let (other, scaled_counters) = run(factor);
        assert_eq!(scaled_counters, counters);
        for (a, b) in one.iter().zip(&other) {
            assert_eq!((a.position, a.orientation), (b.position, b.orientation));
            assert_eq!(a.velocity * factor, b.velocity);
        }
    }
}

#[test]
fn views_and_runs_in_pieces_change_no_bit() {
    let mut whole =
        simulate::<carom_engine::CellScheduler>(&closed_box(5), &Instructions::default());
    let mut pieces =
        simulate::<carom_engine::CellScheduler>(&closed_box(5), &Instructions::default());
    whole.run_until(1.0).unwrap();
    for stop in 1..=50 {
        pieces.run_until(0.02 * f64::from(stop)).unwrap();
        let _ = pieces.view().overlaps();
    }
    assert_eq!(bits(&whole.view()), bits(&pieces.view()));
}

/// ∫ Σ m v_x² dt, Σ x J_x over all contacts (on both bodies), and Σ |J| on walls in each of several
/// intervals.
#[derive(Default)]
struct Virial {
    time: f64,
    /// Σ m v_x² since `time`.
    squares: f64,
    integral: f64,
    contacts: f64,
    span: f64,
    on_walls: Vec<f64>,
}

impl Virial {
    fn proceed(&mut self, time: f64) {
        self.integral += self.squares * (time - self.time);
        self.time = time;
    }
}

impl Observer for Virial {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.proceed(report.time.to_f64());
        for (side, impulse) in report.sides.iter().zip([-report.impulse, report.impulse]) {
            if side.body.is_wall() {
                let span = (self.time / self.span) as usize;
                self.on_walls.resize(self.on_walls.len().max(span + 1), 0.0);
                self.on_walls[span] += impulse.length();
            } else {
                let mass = side.body.molecule().mass();
                let squared = |velocity: DVec2| mass * velocity.x * velocity.x;
                self.squares += squared(side.after.velocity) - squared(side.before.velocity);
                self.contacts += side.before.position.x * impulse.x;
            }
        }
    }
}

/// The virial theorem holds for each single run, to rounding: the change of Σ m x v_x is ∫ Σ m v_x²
/// dt + Σ x J_x, with the impulses of the walls. The walls of a dilute gas receive its pressure, n
/// kT (1 + B₂ n) with B₂ = 2 π r², where n is the density in the area accessible to the centres.
#[test]
fn walls_receive_the_pressure_of_the_gas() {
    let (radius, count, until) = (0.004, 80, 400.0);
    let mut scene = with_walls(vec![line_x(0.0), line_y(0.0)], scene(vec![]));
    scene.gas = vec![gas("disc", radius, count)];
    let mut simulation = Simulation::new(&scene).unwrap();
    let moment = |simulation: &Simulation| -> [f64; 2] {
        let view = simulation.view();
        let gas = view.bodies().filter(|body| !body.body.is_fixed());
        let sums = gas.map(|body| {
            let (x, v) = (body.motion.position.x, body.motion.velocity.x);
            DVec2::new(x * v, v * v)
        });
        sums.sum::<DVec2>().to_array()
    };
    let [before, squares] = moment(&simulation);
    let mut virial = Virial {
        squares,
        span: 10.0,
        ..Virial::default()
    };
    simulation.observe_until(until, &mut virial).unwrap();
    virial.proceed(until);
    let [after, _] = moment(&simulation);
    let theorem = virial.integral + virial.contacts;
    assert!(
        (after - before - theorem).abs() < 1e-9 * virial.integral,
        "{} not {theorem}",
        after - before
    );

    let spans = (until / virial.span) as usize;
    // Four sides, of the length accessible to the centres.
    let length = 4.0 * (1.0 - 2.0 * radius);
    let pressures: Vec<f64> = virial.on_walls[..spans]
        .iter()
        .map(|impulse| impulse / (virial.span * length))
        .collect();
    let mean = pressures.iter().sum::<f64>() / spans as f64;
    let spread = pressures.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / (spans - 1) as f64;
    let error = (spread / spans as f64).sqrt();
    // Energy 1 for each disc and two degrees of freedom: kT = 1.
    let density = count as f64 / (1.0 - 2.0 * radius).powi(2);
    let expected = density * (1.0 + 2.0 * std::f64::consts::PI * radius * radius * density);
    assert!(error < 0.005 * mean, "{error} of {mean}");
    assert!(
        (mean - expected).abs() < 3.0 * error,
        "{mean} ± {error} against {expected}"
    );
}

#[test]
fn the_loss_at_an_inelastic_wall_agrees_with_the_ledger() {
    let mut scene = with_walls(
        vec![WallSpec {
            tags: vec!["soft".to_owned()],
            ..line_x(0.0)
        }],
        scene(vec![]),
    );
    scene.molecule = vec![disc(0.1, 2.0, [0.5, 0.5], [1.0, 0.5])];
    scene.elasticity.pair = vec![ElasticityRule {
        between: vec!["soft".to_owned()],
        coefficient: 0.5.into(),
        ..ElasticityRule::default()
    }];
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.run_until(0.5).unwrap();
    assert_eq!(velocity(&simulation.view(), 0), DVec2::new(-0.5, 0.5));
    // ½ m v_x² (1 − e²)
    assert!((simulation.view().ledger().lost - 0.75).abs() < 1e-15);
}

#[test]
fn other_detectors_also_keep_molecules_inside() {
    let mut scene = with_walls(
        vec![line_x(0.0), line_y(0.0), segment([0.4, 0.5], [0.6, 0.5])],
        scene(vec![]),
    );
    scene.molecule = vec![MoleculeSpec {
        velocity: [0.7, 0.4],
        angular_velocity: 5.0,
        ..named("tee", 0.02, 1.0, [0.3, 0.3])
    }];
    let mut exact: Simulation<Exact, Impact, HeapScheduler> =
        Simulation::with(&scene, Exact::default(), Impact, CellsPerSide::Automatic).unwrap();
    let mut golden: Simulation<GoldenSecant, Impact, HeapScheduler> = Simulation::with(
        &scene,
        GoldenSecant::default(),
        Impact,
        CellsPerSide::Automatic,
    )
    .unwrap();
    let mut circles: Simulation<BoundingCircles, Impact> =
        Simulation::with(&scene, BoundingCircles, Impact, Instructions::default()).unwrap();
    for _ in 0..12 {
        exact.step(1e3, &mut ()).unwrap();
        golden.step(1e3, &mut ()).unwrap();
        let off = exact.time().since(golden.time()).abs();
        assert!(off < 1e-6, "{off:e}");
    }
    for _ in 0..1000 {
        circles.step(1e3, &mut ()).unwrap();
        let view = circles.view();
        assert_eq!(view.overlaps().pairs, 0);
        let tee = view.bodies().next().unwrap();
        let (place, radius) = (tee.motion.position, tee.body.molecule().bounding_radius());
        assert!(place.min_element() > radius - 1e-12 && place.max_element() < 1.0 - radius + 1e-12);
        assert_eq!(
            tee.motion.angular_velocity, 5.0,
            "a contact cannot turn a circle"
        );
    }
}

fn check_coming_and_going<S: Scheduler>(options: &S::Options) {
    let mut simulation = simulate::<S>(
        &scene(vec![disc(0.125, 1.0, [0.5, 0.5], [0.5, 0.0])]),
        options,
    );
    simulation.run_until(1.0).unwrap();
    assert_eq!(simulation.view().bodies().next().unwrap().winding, [1, 0]);
    let EditError::Scene(SceneError::Overlap { depth, .. }) =
        simulation.add_wall(&line_x(0.0625)).unwrap_err()
    else {
        panic!("the disc is at 0")
    };
    assert!((depth - 0.0625).abs() < 1e-15);
    let wall = simulation.add_wall(&line_x(0.375)).unwrap();
    simulation.run_until(2.0).unwrap();
    assert_eq!(simulation.view().counters().collisions, 1);
    assert_eq!(velocity(&simulation.view(), 0), DVec2::new(-0.5, 0.0));
    simulation.remove(wall).unwrap();
    simulation.run_until(10.0).unwrap();
    assert_eq!(simulation.view().counters().collisions, 1);
    // A molecule cannot be added across a wall either.
    simulation.add_wall(&line_y(0.0)).unwrap();
    let across = MoleculeSpec {
        orientation_turns: Some(0.25),
        ..named("rod:4", 0.01, 1.0, [0.3, 0.99])
    };
    let refused = simulation.add(&across).unwrap_err();
    assert!(
        matches!(refused, EditError::Scene(SceneError::Overlap { .. })),
        "{refused}"
    );
}

#[test]
fn a_scene_with_walls_is_unchanged_by_writing_and_reading() {
    let thick = WallSpec {
        radius: 0.005,
        tags: vec!["flap".to_owned()],
        ..segment([0.3, 0.2], [0.6, 0.5])
    };
    let scene = with_walls(vec![line_x(0.0), thick], scene(vec![]));
    assert_eq!(Scene::from_toml(&scene.to_toml()).unwrap(), scene);
    assert!(Scene::from_toml("[[wall]]\nx = 0.0\nlenght = 3").is_err());
}

#[test]
fn invalid_walls_are_refused_with_their_entry() {
    let words = |wall: WallSpec, others: Scene| {
        let scene = with_walls(vec![line_y(0.5), wall], others);
        Simulation::new(&scene).map(|_| ()).unwrap_err().to_string()
    };
    let nothing = || scene(vec![]);
    let cases = [
        (
            segment([0.1, 0.2], [0.1, 0.2]),
            "wall[1]: the length of a wall",
        ),
        (
            segment([0.1, 0.2], [f64::NAN, 0.2]),
            "wall[1]: a place of a wall",
        ),
        (line_x(f64::INFINITY), "wall[1]: a place of a wall"),
        (
            segment([0.0, 0.0], [17.0, 0.0]),
            "wall[1]: the wall must be at most 16 times",
        ),
        (
            line_x(1e12),
            "wall[1]: the wall must be at most 2^31 boxes away",
        ),
        (
            WallSpec {
                radius: -0.1,
                ..line_x(0.0)
            },
            "wall[1]: the radius of a wall",
        ),
        (
            WallSpec {
                radius: f64::NAN,
                ..line_x(0.0)
            },
            "wall[1]: the radius of a wall",
        ),
        (WallSpec::default(), "wall[1]: give a wall"),
        (
            WallSpec {
                x: Some(0.0),
                ..line_y(0.0)
            },
            "wall[1]: give a wall",
        ),
        (
            WallSpec {
                to: None,
                ..segment([0.1, 0.2], [0.3, 0.4])
            },
            "wall[1]: give a wall",
        ),
        (
            WallSpec {
                x: Some(0.1),
                ..segment([0.1, 0.2], [0.3, 0.4])
            },
            "wall[1]: give a wall",
        ),
    ];
    for (wall, start) in cases {
        let message = words(wall.clone(), nothing());
        assert!(message.starts_with(start), "{wall:?}: {message}");
    }
    // Across a molecule, in the middle and at its very edge, also through the border; a wall across
    // a fixed molecule is accepted.
    let across =
        |molecule: MoleculeSpec| words(segment([0.9, 0.1], [1.2, 0.1]), scene(vec![molecule]));
    for at in [[0.95, 0.1], [0.05, 0.12], [0.1, 0.071], [0.0, 0.129]] {
        let message = across(disc(0.03, 1.0, at, [0.0; 2]));
        assert!(
            message.starts_with("molecule[0] and wall[1] overlap by"),
            "{message}"
        );
    }
    let beside = with_walls(
        vec![segment([0.9, 0.1], [1.2, 0.1])],
        Scene {
            bumper: vec![bumper(0.05, [0.1, 0.1])],
            ..scene(vec![
                disc(0.03, 1.0, [0.231, 0.1], [0.0; 2]),
                disc(0.03, 1.0, [0.0, 0.131], [0.0; 2]),
            ])
        },
    );
    Simulation::new(&beside).unwrap();
    // A gas that does not fit between two walls.
    let mut narrow = with_walls(vec![line_x(0.0), line_x(0.1), line_x(0.2)], scene(vec![]));
    narrow.gas = vec![gas("disc", 0.03, 400)];
    assert!(matches!(
        Simulation::new(&narrow),
        Err(SceneError::Full { .. })
    ));
}
