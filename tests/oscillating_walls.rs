//! Walls that oscillate: shakers and breathing boxes.

use std::f64::consts::{PI, TAU};

use carom_detection::GoldenSecant;
use carom_engine::{
    CellScheduler, CellsPerSide, HeapScheduler, Instructions, RunError, Scene, Simulation,
    WallMotionSpec,
};
use carom_kinematics::{EpochTime, Motion};
use carom_observers::WallWork;
use carom_response::Impact;
use carom_testkit::oracle::{DoubleDouble, Number as _};

use crate::support::simulate;

fn scene(text: &str) -> Scene {
    Scene::from_toml(text).unwrap()
}

const AMPLITUDE: f64 = 0.05;
const FREQUENCY: f64 = 3.0;
const PHASE: f64 = 0.4;

/// The face of the right wall of a ball's table, as the ball's centre meets it: 13/16 at time 0.
struct Face {
    /// Phase at the time at which durations begin (radians).
    phase: f64,
}

fn exact(value: f64) -> DoubleDouble {
    DoubleDouble::new(value)
}

/// cos and sin of an angle (radians).
fn cos_sin(angle: &DoubleDouble) -> [DoubleDouble; 2] {
    DoubleDouble::cos_sin(0.0, 1.0, angle)
}

impl Face {
    /// The face of a wall, by its place and its velocity.
    fn of(wall: &Motion) -> Self {
        let displacement = wall.position.x - (0.875 - AMPLITUDE * PHASE.sin());
        let phase = displacement.atan2(wall.velocity.x / FREQUENCY);
        Self { phase }
    }

    /// The place of the wall at a time since the start of the run, in double-double arithmetic at
    /// any age.
    fn wall_at(time: EpochTime) -> f64 {
        let [epoch, low, offset] = [time.epoch(), time.epoch_low(), time.offset()].map(exact);
        let turned = epoch.plus(&low).plus(&offset).times(&exact(FREQUENCY));
        let [_, now] = cos_sin(&turned.plus(&exact(PHASE)));
        let [_, start] = cos_sin(&exact(PHASE));
        let shift = exact(AMPLITUDE).times(&now.minus(&start));
        exact(0.875).plus(&shift).value()
    }

    /// Place of the face and its velocity after a duration.
    fn exactly(&self, after: &DoubleDouble) -> [DoubleDouble; 2] {
        let turned = after.times(&exact(FREQUENCY));
        let [cos, sin] = cos_sin(&exact(self.phase).plus(&turned));
        let [_, start] = cos_sin(&exact(PHASE));
        let shift = exact(AMPLITUDE).times(&sin.minus(&start));
        let speed = exact(AMPLITUDE).times(&exact(FREQUENCY)).times(&cos);
        [exact(0.8125).plus(&shift), speed]
    }

    /// Distance from a ball to the face after a duration, rounded.
    fn gap(&self, [place, velocity]: [f64; 2], after: f64) -> f64 {
        let shift = (self.phase + FREQUENCY * after).sin() - PHASE.sin();
        0.8125 + AMPLITUDE * shift - (place + velocity * after)
    }

    /// The durations up to `end` at which the face has the velocity of the ball: between two of
    /// them the distance is monotone.
    fn turning_points(&self, velocity: f64, end: f64) -> Vec<f64> {
        let ratio = velocity / (AMPLITUDE * FREQUENCY);
        if ratio.abs() > 1.0 {
            return Vec::new();
        }
        let mut points = Vec::new();
        let angle = ratio.acos();
        for turn in 0.. {
            let before = points.len();
            for angle in [-angle, angle] {
                let turned = angle + TAU * f64::from(turn) - self.phase;
                let after = turned / FREQUENCY;
                if (0.0..end).contains(&after) {
                    points.push(after);
                }
            }
            if turn > 1 && points.len() == before {
                return points;
            }
        }
        points
    }

    /// The first duration up to `end` after which a ball meets the face: a change of sign between
    /// two turning points of the distance, bisection, and Newton's steps in double-double
    /// arithmetic. `leaves` says that the ball has just met the face.
    fn meeting(&self, ball: [f64; 2], leaves: bool, end: f64) -> Option<DoubleDouble> {
        let mut points = self.turning_points(ball[1], end);
        points.push(end);
        let mut from = 0.0;
        if leaves {
            // The distance grows from 0 to its first turning point.
            from = points.remove(0);
        }
        for mut to in points {
            if self.gap(ball, to) > 0.0 {
                from = to;
                continue;
            }
            for _ in 0..64 {
                let middle = 0.5 * (from + to);
                if self.gap(ball, middle) > 0.0 {
                    from = middle;
                } else {
                    to = middle;
                }
            }
            let mut time = exact(0.5 * (from + to));
            for _ in 0..3 {
                let [place, speed] = self.exactly(&time);
                let [x, v] = ball.map(exact);
                let gap = place.minus(&x.plus(&v.times(&time)));
                time = time.minus(&gap.over(&speed.minus(&v)));
            }
            return Some(time);
        }
        None
    }
}

/// Follows Fermi and Ulam's ball between a fixed and an oscillating wall for 10⁵ contacts, and
/// compares each with the reference; returns the lowest and the highest speed of the ball after
/// contacts with the oscillating wall.
///
/// The reference begins anew from the motions of the ball and of the wall after each contact.
/// Between two contacts an error of rounding grows by a factor of order 1 alone, so that one bound
/// holds for all contacts of a chaotic orbit; over many contacts chaos would multiply it, and even
/// a regular orbit adds it up. The clock of the wall is compared apart, with its phase at the time
/// since the start of the run.
fn follow([mut place, mut velocity]: [f64; 2]) -> [f64; 2] {
    let text = format!(
        "[[wall]]\nx = 0.125\n[[wall]]\nx = 0.875\n\
         motion = {{ amplitude = [{AMPLITUDE:?}, 0.0], frequency = {FREQUENCY:?}, phase = {PHASE:?} }}\n\
         [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 2.0\n\
         at = [{place:?}, 0.5]\nvelocity = [{velocity:?}, 0.25]"
    );
    let mut simulation = Simulation::new(&scene(&text)).unwrap();
    let motions = |simulation: &Simulation| {
        let view = simulation.view();
        let ball = view.bodies().next().unwrap().motion;
        let mut walls = view.bodies().filter(|body| body.body.is_wall());
        let wall = walls.find(|wall| wall.motion.position.x > 0.5).unwrap();
        (view.time(), ball, wall.motion)
    };
    let (mut time, _, mut wall) = motions(&simulation);
    let mut leaves = false;
    let (mut with_wall, mut slowest) = (0, f64::INFINITY);
    let mut speeds = [f64::INFINITY, 0.0f64];
    let (mut latest, mut farthest, mut slip) = (0.0f64, 0.0f64, 0.0f64);
    for contact in 0..100_000 {
        let face = Face::of(&wall);
        let to_the_left = exact(0.1875).minus(&exact(place)).over(&exact(velocity));
        let end = if velocity < 0.0 {
            // The face may catch up with a ball that leaves it slowly.
            to_the_left.value()
        } else {
            (0.8125 - place + 3.0 * AMPLITUDE) / velocity
        };
        let right = face.meeting([place, velocity], leaves, end);
        leaves = right.is_some();
        let (after, at, onwards, closing) = if let Some(after) = right {
            with_wall += 1;
            let [at, speed] = face.exactly(&after).map(|part| part.value());
            (after, at, 2.0 * speed - velocity, (velocity - speed).abs())
        } else {
            (to_the_left, 0.1875, -velocity, velocity.abs())
        };
        assert!(simulation.step(1e9, &mut ()).unwrap());
        let (now, ball, moved) = motions(&simulation);
        let late = exact(now.since(time)).minus(&after).value().abs();
        let away = (ball.position.x - at).abs();
        let off = (ball.velocity.x - onwards).abs();
        // A place that is rounded by ε moves the contact by ε over the closing speed.
        let allowed = 1e-13 * (0.1 / closing).max(1.0);
        assert!(
            late.max(away).max(off) < allowed,
            "contact {contact} at {closing}: {late:e}, {away:e}, {off:e}"
        );
        if closing > 0.1 {
            latest = latest.max(late);
        }
        farthest = farthest.max(away);
        slowest = slowest.min(closing);
        slip = slip.max((moved.position.x - Face::wall_at(now)).abs());
        (time, wall, place, velocity) = (now, moved, ball.position.x, ball.velocity.x);
        if leaves {
            speeds = [speeds[0].min(velocity.abs()), speeds[1].max(velocity.abs())];
        }
    }
    eprintln!(
        "{with_wall} of 100000 contacts with the wall until {time}: times to {latest:e}, places to \
         {farthest:e}, slowest approach {slowest:e}, wall to {slip:e}, speeds {speeds:?}"
    );
    assert!(with_wall > 40_000, "{with_wall}");
    // The phase of the wall has a rounding in each epoch.
    assert!(slip < 1e-11, "{slip:e}");
    let (view, ledger) = (simulation.view(), simulation.view().ledger());
    assert!((ledger.booked() - view.energy()).abs() < 1e-10);
    speeds
}

/// A slow ball moves chaotically below the lowest invariant curve, which is near the speed
/// √(4 L A ω²) = 1.1 at which the map is the standard map with K = 1.
#[test]
fn a_slow_ball_follows_its_recursion_for_1e5_contacts_with_an_oscillating_wall() {
    let [low, high] = follow([0.5, 0.7]);
    assert!(low < 0.4 && high < 1.5, "{low} {high}");
}

/// A fast ball stays on an invariant curve (Lichtenberg, Lieberman and Cohen, Physica D 1 (1980)
/// 291): its speed remains near that of the start, where the wall changes it by up to 0.3 at once.
#[test]
fn a_fast_ball_follows_its_recursion_for_1e5_contacts_with_an_oscillating_wall() {
    let [low, high] = follow([0.5, 5.0]);
    assert!(low > 4.5 && high < 5.7, "{low} {high}");
}

/// The fixed points of Fermi and Ulam's table, at which a ball meets the face each time where it
/// turns back, after m periods, with their stability (Lichtenberg, Lieberman and Cohen, Physica D 1
/// (1980) 291).
///
/// With the period 1, the amplitude A and the way L the speed is v = 2 L/m. A small delay δ of a
/// contact obeys δ₊ + δ₋ = (2 ∓ K) δ with K = 4π² m² A/L, with − where the face is outermost and +
/// where it is innermost: such an orbit is stable if 2 ∓ K is between −2 and 2.
#[test]
fn the_fixed_points_of_the_table_have_their_known_stability() {
    let (amplitude, way) = (0.01, 0.625);
    for (m, is_outer) in [1, 2, 3].into_iter().flat_map(|m| [(m, true), (m, false)]) {
        let period = f64::from(m);
        let speed = 2.0 * way / period;
        // The centre meets the face at 13/16 at 3/4, when the face turns back.
        let (wall, phase) = if is_outer { (0.865, PI) } else { (0.885, 0.0) };
        let back = 0.8125 - 0.75 * speed;
        let (at, sign) = if back < 0.1875 {
            (0.375 - back, -1.0)
        } else {
            (back, 1.0)
        };
        let run = |kick: f64| -> Vec<[f64; 2]> {
            let velocity = sign * (speed + kick);
            let text = format!(
                "[[wall]]\nx = 0.125\n[[wall]]\nx = {wall:?}\n\
                 motion = {{ amplitude = [{amplitude:?}, 0.0], frequency = {TAU:?}, phase = {phase:?} }}\n\
                 [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 1.0\n\
                 at = [{at:?}, 0.5]\nvelocity = [{velocity:?}, 0.0]"
            );
            let mut simulation = Simulation::new(&scene(&text)).unwrap();
            let mut delays = Vec::new();
            while delays.len() < 6 {
                assert!(simulation.step(1e9, &mut ()).unwrap());
                let view = simulation.view();
                let motion = view.bodies().next().unwrap().motion;
                if motion.velocity.x < 0.0 {
                    let expected = 0.75 + period * delays.len() as f64;
                    let late = view.time().since(EpochTime::from(expected));
                    delays.push([late, -motion.velocity.x - speed]);
                }
            }
            delays
        };
        let stays = run(0.0).into_iter().flatten().take(6);
        assert!(stays.map(f64::abs).fold(0.0, f64::max) < 1e-11, "{m}");
        let trace =
            2.0 - if is_outer { 1.0 } else { -1.0 } * (TAU * period).powi(2) * amplitude / way;
        let delays = run(1e-9);
        let largest = delays
            .iter()
            .fold(0.0f64, |most, [late, _]| most.max(late.abs()));
        assert_eq!(
            largest > 2e-8,
            trace.abs() > 2.0,
            "{m}: {largest:e} {trace}"
        );
        for three in delays.windows(3) {
            let [[before, _], [now, _], [next, _]] = [three[0], three[1], three[2]];
            let off = (next + before - trace * now).abs();
            assert!(off < 1e-4 * largest, "{m}, {trace}: {off:e} of {largest:e}");
        }
    }
}

/// A ball that meets the wall each time where it turns back, after one period: a fixed point of the
/// map of phase and velocity (Lichtenberg, Lieberman and Cohen 1980).
#[test]
fn a_fixed_point_of_the_table_stays_one() {
    // The face oscillates by 0.01 about 0.8025, is there at the start and moves inwards; it turns
    // back at 0.8125 at times 3/4, 7/4, …
    let frequency = TAU;
    let phase = PI;
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
        let mut cells = simulate::<CellScheduler>(&scene, &Instructions::Widest);
        let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
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
            let expected = PI / 12.0;
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
