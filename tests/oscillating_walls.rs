//! Walls that oscillate: shakers and breathing boxes.

use carom_detection::{Exact, GoldenSecant};
use carom_engine::{
    CellScheduler, CellsPerSide, HeapScheduler, Instructions, RunError, Scene, Simulation,
    WallMotionSpec,
};
use carom_kinematics::EpochTime;
use carom_observers::WallWork;
use carom_response::Impact;
use carom_testkit::oracle::{DoubleDouble, Number as _};

fn scene(text: &str) -> Scene {
    Scene::from_toml(text).unwrap()
}

const AMPLITUDE: f64 = 0.05;
const FREQUENCY: f64 = 3.0;
const PHASE: f64 = 0.4;

/// The face of the right wall of a ball's table from some time on, by its phase there: 13/16 from
/// the ball's centre at the start of the run.
struct Face {
    cos_sin: [f64; 2],
}

impl Face {
    /// The phase at a time keeps all digits of the time, at any age.
    fn at(time: EpochTime) -> Self {
        let parts = [time.epoch(), time.epoch_low(), time.offset()].map(DoubleDouble::new);
        let [epoch, low, offset] = &parts;
        let time = epoch.plus(low).plus(offset);
        let [cos, sin] = DoubleDouble::cos_sin(0.0, FREQUENCY, &time).map(|part| part.value());
        let (of_start, to_start) = PHASE.sin_cos();
        Self {
            cos_sin: [
                cos * to_start - sin * of_start,
                sin * to_start + cos * of_start,
            ],
        }
    }

    /// cos and sin of the phase after a duration.
    fn turned(&self, after: f64) -> [f64; 2] {
        let ([cos, sin], (by_sin, by_cos)) = (self.cos_sin, (FREQUENCY * after).sin_cos());
        [cos * by_cos - sin * by_sin, sin * by_cos + cos * by_sin]
    }

    fn place(&self, after: f64) -> f64 {
        0.8125 + AMPLITUDE * (self.turned(after)[1] - f64::sin(PHASE))
    }

    fn speed(&self, after: f64) -> f64 {
        AMPLITUDE * FREQUENCY * self.turned(after)[0]
    }
}

/// The first duration up to `end` after which a ball at `place` with `velocity` meets the face,
/// infinite if it does not: a scan for a change of sign, and bisection.
fn meeting(face: &Face, place: f64, velocity: f64, end: f64) -> f64 {
    let gap = |after: f64| face.place(after) - (place + velocity * after);
    let step = 1e-4;
    let mut from = 1e-9;
    while gap(from + step) > 0.0 {
        from += step;
        if from > end {
            return f64::INFINITY;
        }
    }
    let mut to = from + step;
    for _ in 0..80 {
        let middle = 0.5 * (from + to);
        if gap(middle) > 0.0 {
            from = middle;
        } else {
            to = middle;
        }
    }
    0.5 * (from + to)
}

/// Fermi and Ulam's ball between a fixed and an oscillating wall: each contact follows from the one
/// before as an independent reference has it.
#[test]
fn a_ball_between_a_wall_and_an_oscillating_wall_follows_its_recursion() {
    let text = format!(
        "[[wall]]\nx = 0.125\n[[wall]]\nx = 0.875\n\
         motion = {{ amplitude = [{AMPLITUDE:?}, 0.0], frequency = {FREQUENCY:?}, phase = {PHASE:?} }}\n\
         [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 2.0\nat = [0.5, 0.5]\n\
         velocity = [0.7, 0.25]"
    );
    let mut simulation = Simulation::new(&scene(&text)).unwrap();
    let (mut time, mut place, mut velocity) = (EpochTime::ZERO, 0.5, 0.7);
    let mut with_wall = 0;
    for contact in 0..2000 {
        let face = Face::at(time);
        let to_the_left = (place - 0.1875) / -velocity;
        let right = if velocity < 0.0 {
            // The face may catch up with a ball that leaves it slowly.
            meeting(&face, place, velocity, to_the_left)
        } else {
            meeting(&face, place, velocity, 100.0)
        };
        let expected = if right < f64::INFINITY {
            with_wall += 1;
            let w = face.speed(right);
            (right, face.place(right), 2.0 * w - velocity)
        } else {
            (to_the_left, 0.1875, -velocity)
        };
        assert!(simulation.step(1e9, &mut ()).unwrap());
        let view = simulation.view();
        let motion = view.bodies().next().unwrap().motion;
        let found = (
            view.time().since(time),
            motion.position.x,
            motion.velocity.x,
        );
        let off = [
            (found.0 - expected.0).abs(),
            (found.1 - expected.1).abs(),
            (found.2 - expected.2).abs(),
        ];
        assert!(
            off.iter().all(|off| *off < 1e-12),
            "contact {contact}: {found:?}, expected {expected:?}"
        );
        (time, place, velocity) = (view.time(), found.1, found.2);
    }
    assert!(with_wall > 900, "{with_wall}");
    let (view, ledger) = (simulation.view(), simulation.view().ledger());
    assert!((ledger.booked() - view.energy()).abs() < 1e-12);
}

/// A ball that meets the wall each time where it turns back, after one period: a fixed point of the
/// map of phase and velocity (Lichtenberg, Lieberman and Cohen 1980).
#[test]
fn a_fixed_point_of_the_table_stays_one() {
    // The face oscillates by 0.01 about 0.8025, is there at the start and moves inwards; it turns
    // back at 0.8125 at times 3/4, 7/4, …
    let frequency = std::f64::consts::TAU;
    let phase = std::f64::consts::PI;
    let text = format!(
        "[[wall]]\nx = 0.125\n[[wall]]\nx = 0.865\n\
         motion = {{ amplitude = [0.01, 0.0], frequency = {frequency:?}, phase = {phase:?} }}\n\
         [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 1.0\nat = [0.5, 0.5]\n\
         velocity = [-1.25, 0.0]"
    );
    let mut simulation = Simulation::new(&scene(&text)).unwrap();
    for contact in 0..20 {
        assert!(simulation.step(1e9, &mut ()).unwrap());
        let view = simulation.view();
        let motion = view.bodies().next().unwrap().motion;
        let sign = if contact % 2 == 0 { 1.0 } else { -1.0 };
        let expected = (0.25 + 0.5 * f64::from(contact), sign * 1.25);
        let found = (view.time().to_f64(), motion.velocity.x);
        let off = (found.0 - expected.0)
            .abs()
            .max((found.1 - expected.1).abs());
        assert!(off < 1e-9, "contact {contact}: {found:?} {expected:?}");
    }
}

const SHAKER: &str = "[box]\nseed = 5\n[elasticity]\ndefault = 0.9\n[[wall]]\nx = 0.0\n[[wall]]\ny = 0.05\n\
    motion = { amplitude = [0.0, 0.04], frequency = 20.0 }\n";

const GASES: [&str; 5] = [
    // Discs, few and many with large ones; molecules; bodies with sides; ellipses.
    "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 60\nregion.y = [0.1, 0.98]",
    "[[gas]]\nradius = 0.008\nmass = 1.0\nenergy = 1.0\ncount = 500\nregion.y = [0.1, 0.98]\n\
     [[gas]]\nradius = 0.05\nmass = 9.0\nenergy = 1.0\ncount = 4\nregion.y = [0.1, 0.98]",
    "[[gas]]\nshape = \"tee\"\natom_radius = 0.008\natom_mass = 1.0\nenergy = 1.0\ncount = 120\nregion.y = [0.1, 0.98]",
    "[[gas]]\nshape = \"square\"\nsize = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 120\nregion.y = [0.1, 0.98]",
    "[[gas]]\nshape = \"ellipse:3\"\nsize = 0.04\nmass = 1.0\nenergy = 1.0\ncount = 120\nregion.y = [0.1, 0.98]",
];

#[test]
fn the_ledger_balances_and_no_body_passes_a_shaker() {
    for gas in GASES {
        let mut simulation = Simulation::new(&scene(&format!("{SHAKER}{gas}"))).unwrap();
        let tagged = carom_observers::Group::All;
        let mut work = WallWork::new(tagged);
        for step in 1..=8 {
            let until = 0.125 * f64::from(step);
            simulation.observe_until(until, &mut work).unwrap();
            let (view, ledger) = (simulation.view(), simulation.view().ledger());
            let energy = view.energy();
            let off = ledger.booked() - energy;
            assert!(off.abs() < 1e-12 * energy, "{gas}: {off:e} of {energy}");
            assert_eq!(view.overlaps().pairs, 0, "{gas} at step {step}");
            let wall = view.bodies().find(|b| b.body.id() == 1).unwrap();
            let expected = 0.05 + 0.04 * f64::sin(20.0 * until);
            assert!((wall.motion.position.y - expected).abs() < 1e-13);
            let speed = 0.8 * f64::cos(20.0 * until);
            assert!((wall.motion.velocity.y - speed).abs() < 1e-12);
        }
        let ledger = simulation.view().ledger();
        assert!((work.energy() - ledger.work).abs() < 1e-12 * ledger.work);
        assert!(ledger.work > 0.0 && ledger.lost > 0.0, "{ledger:?}");
        let counters = simulation.view().counters();
        assert!(counters.fixed_collisions > 100, "{counters:?}");
    }
}

#[test]
fn no_contact_with_a_shaker_is_missed() {
    for gas in GASES {
        let mut simulation = Simulation::new(&scene(&format!("{SHAKER}{gas}"))).unwrap();
        let small = simulation.view().bodies().count() < 200;
        for step in 1..if small { 20 } else { 4 } {
            simulation.run_until(0.03 * f64::from(step)).unwrap();
            simulation.check_invariants(0.02).unwrap();
        }
    }
}

#[test]
fn cells_and_the_heap_agree_on_a_shaker() {
    for gas in GASES {
        let scene = scene(&format!("{SHAKER}{gas}"));
        let mut cells = Simulation::<Exact, Impact, CellScheduler>::with(
            &scene,
            Exact::default(),
            Impact,
            Instructions::Widest,
        )
        .unwrap();
        let mut heap = Simulation::<Exact, Impact, HeapScheduler>::with(
            &scene,
            Exact::default(),
            Impact,
            CellsPerSide::Automatic,
        )
        .unwrap();
        let until = if gas.contains("500") { 0.04 } else { 0.2 };
        cells.run_until(until).unwrap();
        heap.run_until(until).unwrap();
        let (one, other) = (cells.view(), heap.view());
        let counts = [one.counters(), other.counters()]
            .map(|counters| [counters.collisions, counters.fixed_collisions]);
        assert_eq!(counts[0], counts[1], "{gas}");
        assert!(counts[0][1] > 3, "{gas}: {counts:?}");
        for (a, b) in one.bodies().zip(other.bodies()) {
            let off = (a.motion.velocity - b.motion.velocity).length();
            assert!(off < 1e-7, "{gas}: {off:e}");
        }
    }
}

#[test]
fn a_run_with_a_shaker_is_resumed_to_the_bit() {
    for gas in GASES {
        let mut simulation = Simulation::new(&scene(&format!("{SHAKER}{gas}"))).unwrap();
        simulation.run_until(0.3).unwrap();
        let state = simulation.end_epoch_here();
        let mut resumed = Simulation::resume(&state).unwrap();
        simulation.run_until(0.6).unwrap();
        resumed.run_until(0.6).unwrap();
        assert_eq!(simulation.view().ledger(), resumed.view().ledger());
        for (a, b) in simulation.view().bodies().zip(resumed.view().bodies()) {
            assert_eq!(a.motion, b.motion);
            assert_eq!(a.winding, b.winding);
        }
    }
}

#[test]
fn a_shaken_gas_returns_when_all_velocities_are_reversed() {
    let text = SHAKER.replace("[elasticity]\ndefault = 0.9\n", "");
    let mut simulation = Simulation::new(&scene(&format!("{text}{}", GASES[0]))).unwrap();
    let places = |simulation: &Simulation| -> Vec<_> {
        let view = simulation.view();
        view.bodies().map(|body| body.motion.position).collect()
    };
    let start = places(&simulation);
    simulation.run_until(0.125).unwrap();
    assert!(simulation.view().ledger().work.abs() > 0.0);
    simulation.reverse();
    simulation.run_until(0.25).unwrap();
    assert!(simulation.view().ledger().work.abs() < 1e-9);
    for (place, start) in places(&simulation).iter().zip(start) {
        assert!((*place - start).length() < 1e-9);
    }
}

/// A box whose walls all oscillate together, in the frame of which each body is shaken by the same
/// force: a body at rest in the laboratory stays at rest until a wall meets it.
#[test]
fn a_box_shaken_as_a_whole_keeps_its_walls_apart_and_its_centre() {
    let motion = "motion = { amplitude = [0.1, 0.05], frequency = 6.0 }";
    let text = format!(
        "[box]\nseed = 3\n[[wall]]\nx = 0.2\n{motion}\n[[wall]]\nx = 0.9\n{motion}\n[[wall]]\ny = 0.5\n{motion}\n\
         [[gas]]\nradius = 0.01\nmass = 1.0\ntemperature = 0.01\ncount = 100\nregion.x = [0.25, 0.85]"
    );
    let mut simulation = Simulation::new(&scene(&text)).unwrap();
    for step in 1..=20 {
        simulation.run_until(0.5 * f64::from(step)).unwrap();
        let (view, ledger) = (simulation.view(), simulation.view().ledger());
        assert_eq!(view.overlaps().pairs, 0);
        assert!((ledger.booked() - view.energy()).abs() < 1e-12 * view.energy());
        let time = view.time().to_f64();
        let shift = 0.1 * f64::sin(6.0 * time);
        for body in view.bodies().filter(|body| !body.body.is_fixed()) {
            let x = body.motion.position.x - shift;
            assert!((0.21 - 1e-12..0.89 + 1e-12).contains(&x), "{x}");
        }
    }
}

#[test]
fn a_wall_that_oscillates_into_another_ends_the_run_there() {
    let text = "[[wall]]\nx = 0.5\nmotion = { amplitude = [0.25, 0.0], frequency = 2.0 }\n[[wall]]\nx = 0.625";
    let mut simulation = Simulation::new(&scene(text)).unwrap();
    match simulation.run_until(10.0) {
        Err(RunError::WallsMeet { time, .. }) => {
            let expected = std::f64::consts::PI / 12.0;
            assert!(
                (time.to_f64() - expected).abs() < 1e-12,
                "{}",
                time.to_f64()
            );
        }
        other => panic!("{other:?}"),
    }
    // One that turns back before the other goes on.
    let text = text.replace("0.625", "0.751");
    let mut simulation = Simulation::new(&scene(&text)).unwrap();
    simulation.run_until(100.0).unwrap();
}

#[test]
fn a_shaker_is_started_stopped_and_replaced() {
    let text = "[[wall]]\ntags = [\"s\"]\nx = 0.5\n[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 20\n\
        region.x = [0.6, 0.95]";
    let mut simulation = Simulation::new(&scene(text)).unwrap();
    let shaker = simulation
        .view()
        .bodies()
        .find(|body| body.body.is_wall())
        .map(|body| body.body.key())
        .unwrap();
    let place = |simulation: &Simulation| {
        let view = simulation.view();
        view.bodies()
            .find(|body| body.body.is_wall())
            .unwrap()
            .motion
    };
    let oscillation = WallMotionSpec {
        amplitude: [0.0625, 0.0],
        frequency: 4.0,
        ..WallMotionSpec::default()
    };
    simulation.run_until(0.5).unwrap();
    simulation.move_wall(shaker, &oscillation).unwrap();
    simulation.run_until(1.25).unwrap();
    let expected = 0.5 + 0.0625 * f64::sin(3.0);
    assert!((place(&simulation).position.x - expected).abs() < 1e-14);
    // It stops where it is, and later oscillates about another middle.
    simulation
        .move_wall(shaker, &WallMotionSpec::default())
        .unwrap();
    simulation.run_until(2.0).unwrap();
    assert!((place(&simulation).position.x - expected).abs() < 1e-14);
    assert!(place(&simulation).is_at_rest());
    let phase = std::f64::consts::FRAC_PI_2;
    simulation
        .move_wall(
            shaker,
            &WallMotionSpec {
                phase,
                ..oscillation
            },
        )
        .unwrap();
    simulation.run_until(2.5).unwrap();
    let later = expected + 0.0625 * (f64::cos(2.0) - 1.0);
    assert!((place(&simulation).position.x - later).abs() < 1e-14);
    let ledger = simulation.view().ledger();
    assert!((ledger.booked() - simulation.view().energy()).abs() < 1e-12);
}

#[test]
fn oscillations_out_of_range_are_refused_by_name() {
    for (motion, word) in [
        ("amplitude = [0.1, 0.0]", "`frequency`"),
        ("frequency = 1.0", "`amplitude`"),
        ("amplitude = [0.1, 0.0], frequency = -1.0", "above 0"),
        ("amplitude = [1.0, 0.0], frequency = 1.0", "shorter side"),
        ("amplitude = [0.1, 0.0], frequency = 1e60", "acceleration"),
        (
            "amplitude = [0.1, 0.0], frequency = 1.0, turn = 1.0",
            "either",
        ),
        (
            "amplitude = [0.1, 0.0], frequency = 1.0, times = [0.0, 1.0], places = [[0.0, 0.0], [0.1, 0.0]]",
            "either",
        ),
        ("amplitude = [nan, 0.0], frequency = 1.0", "finite"),
    ] {
        let text = format!("[[wall]]\nx = 0.5\nmotion = {{ {motion} }}");
        let words = Simulation::new(&scene(&text)).unwrap_err().to_string();
        assert!(words.contains("wall[0]") && words.contains(word), "{words}");
    }
    let wall = "[[wall]]\nx = 0.5\nmotion = { amplitude = [0.1, 0.0], frequency = 1.0 }";
    let text = format!("box.drag = 0.1\n{wall}");
    let words = Simulation::new(&scene(&text)).unwrap_err().to_string();
    assert!(words.contains("drag"), "{words}");
    let other = Simulation::<GoldenSecant, Impact, CellScheduler>::with(
        &scene(wall),
        GoldenSecant::default(),
        Impact,
        Instructions::Widest,
    );
    let words = other.unwrap_err().to_string();
    assert!(words.contains("oscillate"), "{words}");
}

#[test]
fn a_shaker_that_crosses_the_border_is_reversed_and_resumed() {
    let text = "[[wall]]\ny = 0.98\nmotion = { amplitude = [0.0, 0.05], frequency = 3.0 }\n\
        [[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 40\nregion.y = [0.1, 0.9]";
    let mut simulation = Simulation::new(&scene(text)).unwrap();
    let place = |simulation: &Simulation| {
        let view = simulation.view();
        let wall = view.bodies().find(|body| body.body.is_wall()).unwrap();
        (wall.unwrapped(&view.bounds()).y, wall.motion.velocity.y)
    };
    simulation.run_until(0.5).unwrap();
    let before = place(&simulation);
    assert!((before.0 - 0.98 - 0.05 * f64::sin(1.5)).abs() < 1e-13);
    simulation.reverse();
    let after = place(&simulation);
    assert!((after.0 - before.0).abs() < 1e-13 && (after.1 + before.1).abs() < 1e-13);
    let mut resumed = Simulation::resume(&simulation.end_epoch_here()).unwrap();
    resumed.run_until(0.75).unwrap();
    assert!((place(&resumed).0 - 0.98 - 0.05 * f64::sin(0.75)).abs() < 1e-13);
    assert_eq!(resumed.view().overlaps().pairs, 0);
}

#[test]
fn walls_that_touch_or_rest_at_the_start_of_an_oscillation_meet() {
    let quarter = std::f64::consts::FRAC_PI_2;
    // Away from the other first, and from a turning point, with nothing else in the box.
    let away = "[[wall]]\nx = 0.5\nradius = 0.0625\n\
        motion = { amplitude = [-0.125, 0.0], frequency = 1.0 }\n[[wall]]\nx = 0.625\nradius = 0.0625";
    let turning = format!(
        "[[wall]]\nx = 0.5\nmotion = {{ amplitude = [-0.125, 0.0], frequency = 1.0, phase = {quarter:?} }}\n\
         [[wall]]\nx = 0.625"
    );
    for text in [away, &turning] {
        let mut simulation = Simulation::new(&scene(text)).unwrap();
        let ended = simulation.run_until(50.0);
        assert!(
            matches!(ended, Err(RunError::WallsMeet { .. })),
            "{ended:?}"
        );
    }
}

#[test]
fn shakers_with_end_points_and_oblique_amplitudes_let_nothing_through() {
    let text = "[box]\nseed = 2\n[[wall]]\nfrom = [0.3, 0.3]\nto = [0.7, 0.4]\nradius = 0.01\n\
        motion = { amplitude = [0.05, 0.15], frequency = 9.0, phase = 1.0 }\n\
        [[wall]]\nfrom = [0.1, 0.7]\nto = [0.1, 0.9]\ntemperature = 1.0\n\
        motion = { amplitude = [0.05, 0.0], frequency = 5.0 }\n";
    for gas in [
        "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 100",
        "[[gas]]\nshape = \"tee\"\natom_radius = 0.01\natom_mass = 1.0\nenergy = 1.0\ncount = 60",
        "[[gas]]\nshape = \"square\"\nsize = 0.04\nmass = 1.0\nenergy = 1.0\ncount = 60",
    ] {
        let mut simulation = Simulation::new(&scene(&format!("{text}{gas}"))).unwrap();
        for step in 1..=20 {
            simulation.run_until(0.05 * f64::from(step)).unwrap();
            simulation.check_invariants(0.02).unwrap();
        }
        assert!(simulation.view().counters().fixed_collisions > 10);
    }
}
