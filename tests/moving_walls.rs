//! Walls that move: pistons, shakers and boxes that fly with their contents.

use carom_engine::{
    CellScheduler, CellsPerSide, HeapScheduler, Instructions, Observer, RunError, Scene,
    Simulation, WallMotionSpec,
};
use carom_kinematics::{EpochTime, Motion};
use carom_observers::{Group, WallHeat, WallPressure, WallWork};
use carom_response::Impact;
use glam::DVec2;

use crate::support::simulate;

fn scene(text: &str) -> Scene {
    Scene::from_toml(text).unwrap()
}

/// A ball between a fixed wall and a piston, by the recursion of its contacts: the piston is at
/// p₀ + w t, and each contact with it changes the ball's speed v to |2 w − v|.
struct Ball {
    time: f64,
    place: f64,
    velocity: f64,
}

impl Ball {
    /// The next contact, with the centre between `low` and the piston's face, `high` + w t.
    fn bounce(&mut self, low: f64, high: f64, w: f64) {
        if self.velocity < 0.0 {
            self.time += (self.place - low) / -self.velocity;
            self.place = low;
            self.velocity = -self.velocity;
        } else {
            let gap = high + w * self.time - self.place;
            self.time += gap / (self.velocity - w);
            self.place = high + w * self.time;
            self.velocity = 2.0 * w - self.velocity;
        }
    }
}

/// Runs a ball of radius 1/16 between a wall at 1/8 and a piston that starts at 7/8, and compares
/// contact by contact with the recursion; returns the largest deviation of a velocity.
fn deviation(w: f64, velocity: f64, contacts: usize) -> f64 {
    let text = format!(
        "[[wall]]\nx = 0.125\n[[wall]]\nx = 0.875\nmotion = {{ velocity = [{w:?}, 0.0] }}\n\
         [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 2.0\nat = [0.5, 0.5]\n\
         velocity = [{velocity:?}, 0.25]"
    );
    let mut simulation = Simulation::new(&scene(&text)).unwrap();
    let mut ball = Ball {
        time: 0.0,
        place: 0.5,
        velocity,
    };
    let mut worst = 0.0f64;
    for contact in 0..contacts {
        assert!(simulation.step(1e9, &mut ()).unwrap());
        ball.bounce(0.1875, 0.8125, w);
        let view = simulation.view();
        let motion = view.bodies().next().unwrap().motion;
        let off = (motion.velocity.x - ball.velocity).abs() / ball.velocity.abs();
        let late = (view.time().to_f64() - ball.time).abs() / ball.time;
        let away = (motion.position.x - ball.place).abs();
        assert!(
            off.max(late).max(away) < 1e-10,
            "contact {contact}: {off:e}, {late:e}, {away:e}"
        );
        assert_eq!(motion.velocity.y, 0.25);
        worst = worst.max(off).max(late).max(away);
    }
    let (view, ledger) = (simulation.view(), simulation.view().ledger());
    let energy = view.energy();
    assert!((ledger.booked() - energy).abs() < 1e-13 * energy.max(1.0));
    assert!(w == 0.0 || (ledger.work - (energy - ledger.initial)).abs() < 1e-13 * energy.max(1.0));
    worst
}

#[test]
fn a_ball_between_a_wall_and_a_piston_follows_its_recursion() {
    // Compression, in which the speed grows from 1 to 60, and expansion.
    assert!(deviation(-1.0 / 1024.0, 1.0, 20_000) < 1e-11);
    assert!(deviation(1.0 / 4096.0, -1.0, 200) < 1e-12);
}

#[test]
fn a_wall_that_recedes_faster_than_the_ball_does_nothing_and_one_at_its_speed_does_not_stick() {
    for w in [0.75, 0.5] {
        let text = format!(
            "box.sides = [64.0, 1.0]\n[[wall]]\nx = 0.25\nmotion = {{ velocity = [{w:?}, 0.0] }}\n\
             [[molecule]]\nshape = \"disc\"\natom_radius = 0.125\natom_mass = 1.0\nat = [0.125, 0.5]\n\
             velocity = [0.5, 0.0]"
        );
        let mut simulation = Simulation::new(&scene(&text)).unwrap();
        simulation.run_until(60.0).unwrap();
        assert_eq!(simulation.view().counters().collisions, 0, "{w}");
        assert_eq!(simulation.view().ledger().work, 0.0);
    }
}

/// A wall recedes at the speed of a ball that touches it, and then rests: the ball is reflected
/// when the wall stops, not before, and leaves.
#[test]
fn a_ball_that_touches_a_receding_wall_is_reflected_when_the_wall_stops() {
    let text = "box.sides = [8.0, 1.0]\n[[wall]]\nx = 2.0\n\
        motion = { times = [0.0, 1.0, 2.0], places = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.0]] }\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.125\natom_mass = 1.0\nat = [1.875, 0.5]\n\
        velocity = [0.5, 0.0]";
    let scene = scene(text);
    let mut cells = Simulation::new(&scene).unwrap();
    let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
    let mut at = |time: f64| -> [(u64, Motion); 2] {
        cells.run_until(time).unwrap();
        heap.run_until(time).unwrap();
        [cells.view(), heap.view()].map(|view| {
            let ball = view.bodies().next().unwrap().motion;
            (view.counters().collisions, ball)
        })
    };
    for (time, contacts, place, velocity) in [(0.75, 0, 2.25, 0.5), (2.5, 1, 1.625, -0.5)] {
        for (found, ball) in at(time) {
            assert_eq!(found, contacts, "{time}");
            assert_eq!((ball.position.x, ball.velocity.x), (place, velocity));
        }
    }
}

/// `wall-pressure` of a ball between a fixed wall and a piston: the impulses by the recursion of
/// the contacts, 2 m v on the one and 2 m (v − w) on the other, and distances from the walls where
/// they are.
#[test]
fn the_pressure_on_a_moving_wall_is_that_of_the_recursion() {
    let w = -1.0 / 64.0;
    let text = format!(
        "[[wall]]\nx = 0.125\n[[wall]]\nx = 0.875\nmotion = {{ velocity = [{w:?}, 0.0] }}\n\
         [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 3.0\nat = [0.5, 0.5]\n\
         velocity = [0.75, 0.0]"
    );
    let mut simulation = Simulation::new(&scene(&text)).unwrap();
    let mut sums = WallPressure::new(&simulation.view(), Group::All, 8, 0.25).unwrap();
    let mut ball = Ball {
        time: 0.0,
        place: 0.5,
        velocity: 0.75,
    };
    let (mut inwards, mut net) = (0.0, 0.0);
    sums.start(&simulation.view());
    let mut far_area = 0.0;
    for sample in 1..=64 {
        let time = 0.25 * f64::from(sample);
        simulation.observe_until(time, &mut sums).unwrap();
        sums.sample(&simulation.view());
        loop {
            let mut next = Ball { ..ball };
            next.bounce(0.1875, 0.8125, w);
            if next.time > time {
                break;
            }
            let impulse = 3.0 * (next.velocity - ball.velocity);
            inwards += impulse.abs();
            net -= impulse;
            ball = next;
        }
        // The walls are 3/4 + w t and the rest of the box apart; both gaps count.
        let gaps = [0.75 + w * time, 0.25 - w * time];
        far_area += gaps.map(|gap| (gap - 0.5).max(0.0)).iter().sum::<f64>();
    }
    let ([impulse, sides], [force, length]) = (sums.momentum(), sums.net_momentum());
    assert!((impulse - inwards).abs() < 1e-12 * inwards, "{impulse}");
    assert!((force - net).abs() < 1e-12 * inwards, "{force} {net}");
    // Over 16 units of time two walls of length 1, with two sides each.
    assert_eq!([sides, length], [64.0, 32.0]);
    assert!((sums.far_from_walls()[1] - far_area).abs() < 1e-12);
    let area: f64 = sums.layers().iter().map(|layer| layer.area).sum();
    let count: u64 = sums.layers().iter().map(|layer| layer.count).sum();
    assert!((area - 64.0).abs() < 1e-12 && count == 64, "{area} {count}");
    // The work of the piston is that of its share of the force.
    let ledger = simulation.view().ledger();
    assert!((ledger.booked() - simulation.view().energy()).abs() < 1e-13);
}

/// Walton's law in the frame of a wall: velocity and spin of a uniform disc after one contact, by
/// the closed form (O. R. Walton and R. L. Braun, J. Rheol. 30 (1986) 949).
///
/// With the normal n away from the wall, the tangent t = −n^⊥, and the velocity g of the disc's
/// point of contact relative to the wall's, J_n = −(1 + e) m g_n and J_t = −(1 + β) m g_t/3, or
/// −μ J_n sign(g_t) if that is smaller.
fn bounced(
    disc: &Motion,
    (mass, radius): (f64, f64),
    (normal, of_wall): (DVec2, DVec2),
    (e, beta, friction): (f64, f64, f64),
) -> (DVec2, f64, DVec2) {
    let tangent = -normal.perp();
    let surface = disc.velocity - disc.angular_velocity * radius * normal.perp();
    let relative = surface - of_wall;
    let along = -(1.0 + e) * mass * relative.dot(normal);
    let sticking = -(1.0 + beta) * mass * relative.dot(tangent) / 3.0;
    let across = sticking.clamp(-friction * along, friction * along);
    let impulse = along * normal + across * tangent;
    // The moment of a uniform disc is m r²/2, and the torque (−r n) × J.
    let spin = -radius * normal.perp_dot(impulse) / (0.5 * mass * radius * radius);
    (
        disc.velocity + impulse / mass,
        disc.angular_velocity + spin,
        impulse,
    )
}

#[test]
fn a_rough_disc_leaves_moving_walls_as_the_law_says() {
    let (mass, radius, at) = (2.0, 0.0625, 0.5);
    let law = |friction: Option<f64>| (0.5, 0.25, friction.unwrap_or(f64::INFINITY));
    let disc = |place: [f64; 2]| {
        format!(
            "[[molecule]]\nshape = \"disc\"\natom_radius = {radius:?}\natom_mass = {mass:?}\n\
             at = {place:?}\nvelocity = [0.75, -1.0]\nangular_velocity = 6.0\n"
        )
    };
    for friction in [None, Some(0.1)] {
        let elasticity = format!(
            "[elasticity]\ndefault = 0.5\ntangential = 0.25\n{}",
            friction.map_or(String::new(), |mu| format!("friction = {mu:?}\n"))
        );
        // The face is at 1/4 + s(t) with the velocity u(t), and the disc meets it at 1/2.
        let (amplitude, frequency, phase) = ([0.0625, 0.03125], 5.0, 0.75f64);
        let turned = phase + frequency * at;
        let oscillation =
            format!("amplitude = {amplitude:?}, frequency = {frequency:?}, phase = {phase:?}");
        let table = "times = [0.0, 0.25, 1.0], places = [[0.0, 0.0], [0.0, 0.0], [0.75, 0.1875]]";
        for (motion, height, of_wall) in [
            ("velocity = [0.5, 0.25]", 0.125, [0.5, 0.25]),
            (
                oscillation.as_str(),
                amplitude[1] * (turned.sin() - phase.sin()),
                amplitude.map(|part| part * frequency * turned.cos()),
            ),
            (table, 0.0625, [1.0, 0.25]),
        ] {
            let place = [0.25, 0.25 + height + radius + at];
            let text = format!(
                "{elasticity}[[wall]]\ny = 0.25\nmotion = {{ {motion} }}\n{}",
                disc(place)
            );
            let mut simulation = Simulation::new(&scene(&text)).unwrap();
            let before = simulation.view().bodies().next().unwrap().motion;
            assert!(simulation.step(10.0, &mut ()).unwrap());
            let (view, ledger) = (simulation.view(), simulation.view().ledger());
            let late = view.time().since(EpochTime::from(at));
            assert!(late.abs() < 1e-15, "{motion}: {late:e}");
            let of_wall = DVec2::from(of_wall);
            let (velocity, spin, impulse) =
                bounced(&before, (mass, radius), (DVec2::Y, of_wall), law(friction));
            let after = view.bodies().next().unwrap().motion;
            let off = (after.velocity - velocity).length();
            let turned = (after.angular_velocity - spin).abs();
            assert!(
                off < 1e-14 && turned < 1e-13,
                "{motion}: {off:e} {turned:e}"
            );
            // The wall does the work J·u, with its velocity along the tangent too.
            let work = impulse.dot(of_wall);
            assert!((ledger.work - work).abs() < 1e-14, "{motion}: {work}");
            assert!((ledger.booked() - view.energy()).abs() < 1e-14);
            assert!(ledger.lost > 0.0);
        }
    }
}

/// A rough paddle of the thickness ρ on a hinge: its face moves with ω s along the normal, at the
/// distance s from the hinge, and with −ω ρ along the paddle.
#[test]
fn a_rough_paddle_turns_a_ball_by_the_speed_along_its_face() {
    let (omega, thickness, radius, mass) = (0.5, 0.03125, 0.0625, 3.0);
    for friction in [None, Some(0.01)] {
        let mu = friction.map_or(String::new(), |mu: f64| format!("friction = {mu:?}\n"));
        let text = format!(
            "[elasticity]\ndefault = 0.75\ntangential = 0.5\n{mu}\
             [[wall]]\nfrom = [0.25, 0.5]\nto = [0.5, 0.25]\nradius = {thickness:?}\n\
             motion = {{ about = [0.25, 0.5], turn = {omega:?} }}\n\
             [[molecule]]\nshape = \"disc\"\natom_radius = {radius:?}\natom_mass = {mass:?}\nat = [0.5, 0.5]"
        );
        let mut simulation = Simulation::new(&scene(&text)).unwrap();
        let before = simulation.view().bodies().next().unwrap().motion;
        assert!(simulation.step(10.0, &mut ()).unwrap());
        let (distance, apart) = (0.25f64, radius + thickness);
        let angle = -(apart / distance).asin();
        let time = (angle + std::f64::consts::FRAC_PI_4) / omega;
        assert!((simulation.time().to_f64() - time).abs() < 1e-14);
        let along = DVec2::from_angle(angle);
        let normal = along.perp();
        let from_hinge = (distance * distance - apart * apart).sqrt();
        let of_wall = omega * (from_hinge * normal - thickness * along);
        let law = (0.75, 0.5, friction.unwrap_or(f64::INFINITY));
        let (velocity, spin, impulse) = bounced(&before, (mass, radius), (normal, of_wall), law);
        let (view, ledger) = (simulation.view(), simulation.view().ledger());
        let after = view.bodies().next().unwrap().motion;
        let off = (after.velocity - velocity).length();
        assert!(off < 1e-14, "{off:e}: {} {velocity}", after.velocity);
        assert!((after.angular_velocity - spin).abs() < 1e-13 && spin != 0.0);
        assert!((ledger.work - impulse.dot(of_wall)).abs() < 1e-14);
        assert!((ledger.booked() - view.energy()).abs() < 1e-14);
    }
}

/// One disc between thermal walls that move with u: after each contact its velocity relative to
/// the walls has the distribution of the flux of a gas at rest in their frame, with
/// ⟨(v − u)_n²⟩ = 2 kT/m along the normal and ⟨(v − u)_t²⟩ = kT/m along the wall.
#[test]
fn a_thermal_wall_that_moves_draws_the_flux_of_a_gas_in_its_frame() {
    for motion in ["velocity = [2.0, -1.0]", "velocity = [-0.25, 3.0]"] {
        let text = format!(
            "[box]\nseed = 9\n[[wall]]\nx = 0.0\ntemperature = 0.5\nmotion = {{ {motion} }}\n\
             [[wall]]\nx = 0.5\ntemperature = 0.5\nmotion = {{ {motion} }}\n\
             [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 2.0\nat = [0.25, 0.5]\n\
             velocity = [1.5, 0.0]"
        );
        let mut simulation = Simulation::new(&scene(&text)).unwrap();
        let u = simulation
            .view()
            .bodies()
            .find(|body| body.body.is_wall())
            .unwrap()
            .motion
            .velocity;
        let (mut squares, mut mean, mut last) = (DVec2::ZERO, 0.0, DVec2::X);
        let contacts = 12_000;
        for contact in 0..contacts {
            assert!(simulation.step(1e9, &mut ()).unwrap());
            let disc = simulation.view().bodies().next().unwrap().motion;
            let relative = disc.velocity - u;
            assert!(relative.x != 0.0);
            // The disc goes from wall to wall.
            assert!(contact == 0 || relative.x * last.x < 0.0, "{contact}");
            last = relative;
            squares += relative * relative;
            mean += relative.y;
        }
        let number = f64::from(contacts);
        let [normal, tangent] = (squares / number).to_array();
        // kT/m = 1/4; the standard errors are 0.9 %, 1.3 %, and 0.0046 of the mean.
        assert!((normal - 0.5).abs() < 0.02, "{motion}: {normal}");
        assert!((tangent - 0.25).abs() < 0.014, "{motion}: {tangent}");
        assert!((mean / number).abs() < 0.02, "{motion}: {mean}");
        let (view, ledger) = (simulation.view(), simulation.view().ledger());
        assert!((ledger.booked() - view.energy()).abs() < 1e-9);
        assert!(ledger.work != 0.0 && ledger.heat != 0.0);
    }
}

const PISTON: &str = "[box]\nseed = 5\n[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n\
    [[wall]]\nx = 0.98\nmotion = { velocity = [-0.25, 0.0] }\n";

const GASES: [&str; 4] = [
    // Discs, few and many; discs and large ones; molecules; discs with molecules.
    "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 60\nregion.x = [0.0, 0.9]",
    "[[gas]]\nradius = 0.008\nmass = 1.0\nenergy = 1.0\ncount = 500\nregion.x = [0.0, 0.9]\n\
     [[gas]]\nradius = 0.05\nmass = 9.0\nenergy = 1.0\ncount = 4\nregion.x = [0.0, 0.9]",
    "[[gas]]\nshape = \"tee\"\natom_radius = 0.008\natom_mass = 1.0\nenergy = 1.0\ncount = 120\nregion.x = [0.0, 0.9]",
    "[[gas]]\nshape = \"square\"\nsize = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 120\nregion.x = [0.0, 0.9]",
];

#[test]
fn the_ledger_balances_and_no_body_passes_a_piston() {
    for gas in GASES {
        let mut simulation = Simulation::new(&scene(&format!("{PISTON}{gas}"))).unwrap();
        for step in 1..=8 {
            simulation.run_until(0.25 * f64::from(step)).unwrap();
            let (view, ledger) = (simulation.view(), simulation.view().ledger());
            let energy = view.energy();
            let off = ledger.booked() - energy;
            assert!(off.abs() < 1e-13 * energy, "{gas}: {off:e} of {energy}");
            assert!(ledger.work > 0.0 && ledger.lost.abs() < 1e-12 * energy);
            assert_eq!(view.overlaps().pairs, 0, "{gas} at step {step}");
            let wall = view.bodies().find(|b| b.body.id() == 2).unwrap();
            let face = wall.motion.position.x;
            assert!((face - (0.98 - 0.0625 * f64::from(step))).abs() < 1e-14);
            for body in view.bodies().filter(|body| !body.body.is_fixed()) {
                assert!(body.motion.position.x < face, "{gas}");
            }
        }
        let counters = simulation.view().counters();
        assert!(
            counters.fixed_collisions > 100,
            "{}",
            counters.fixed_collisions
        );
    }
}

#[test]
fn cells_and_the_heap_agree_on_a_piston() {
    for gas in GASES {
        let scene = scene(&format!("{PISTON}{gas}"));
        let mut cells = simulate::<CellScheduler>(&scene, &Instructions::Widest);
        let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
        // Chaos multiplies the roundings, in which the two differ, by ten in a few contacts a body.
        let until = if gas.contains("500") { 0.04 } else { 0.15 };
        cells.run_until(until).unwrap();
        heap.run_until(until).unwrap();
        let (one, other) = (cells.view(), heap.view());
        assert_eq!(
            one.counters().collisions,
            other.counters().collisions,
            "{gas}"
        );
        assert_eq!(
            one.counters().fixed_collisions,
            other.counters().fixed_collisions
        );
        assert!(one.counters().fixed_collisions > 5);
        for (a, b) in one.bodies().zip(other.bodies()) {
            let off = (a.motion.velocity - b.motion.velocity).length();
            assert!(off < 1e-7, "{gas}: {off:e}");
        }
    }
}

/// A gas in a box whose walls all move with u, and the gas with them, follows the path of the gas
/// in the box at rest, shifted by u t.
#[test]
fn a_box_that_flies_holds_a_gas_of_the_same_trajectory() {
    let walls = |u: [f64; 2]| {
        let motion = format!("motion = {{ velocity = [{:?}, {:?}] }}", u[0], u[1]);
        let frame = [
            ("0.125, 0.125", "0.875, 0.125"),
            ("0.875, 0.125", "0.875, 0.875"),
            ("0.875, 0.875", "0.125, 0.875"),
            ("0.125, 0.875", "0.125, 0.125"),
            // A flap inside.
            ("0.5, 0.25", "0.625, 0.5"),
        ];
        let wall = |(from, to)| format!("[[wall]]\nfrom = [{from}]\nto = [{to}]\n{motion}\n");
        let walls: String = frame.map(wall).concat();
        let balls = (0..24).map(|ball| {
            let at = [
                0.1875 + 0.03125 * f64::from(ball % 4),
                0.25 + 0.09375 * f64::from(ball / 4),
            ];
            let angle = f64::from(ball);
            let [vx, vy] = [angle.cos() + u[0], angle.sin() + u[1]];
            let shape = if ball % 3 == 0 { "tee" } else { "disc" };
            format!(
                "[[molecule]]\nshape = \"{shape}\"\natom_radius = 0.00390625\natom_mass = 1.0\n\
                 at = [{:?}, {:?}]\nvelocity = [{vx:?}, {vy:?}]\n",
                at[0], at[1]
            )
        });
        let balls: String = balls.collect();
        Simulation::new(&scene(&format!("{balls}{walls}"))).unwrap()
    };
    let u = [0.75, -0.5];
    let (mut at_rest, mut flying) = (walls([0.0; 2]), walls(u));
    for step in 1..=5 {
        let time = 0.125 * f64::from(step);
        at_rest.run_until(time).unwrap();
        flying.run_until(time).unwrap();
        let (one, other) = (at_rest.view(), flying.view());
        assert_eq!(one.counters().collisions, other.counters().collisions);
        for (a, b) in one.bodies().zip(other.bodies()) {
            let shift = DVec2::from(u);
            let away = b.unwrapped(&other.bounds()) - a.unwrapped(&one.bounds()) - shift * time;
            assert!(away.length() < 1e-7, "{} at {time}: {away}", a.body.id());
            if !a.body.is_fixed() {
                assert!((b.motion.velocity - a.motion.velocity - shift).length() < 1e-7);
            }
        }
    }
    assert!(at_rest.view().counters().fixed_collisions > 15);
}

#[test]
fn a_run_with_a_piston_is_resumed_to_the_bit() {
    for gas in GASES {
        let mut simulation = Simulation::new(&scene(&format!("{PISTON}{gas}"))).unwrap();
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

/// A paddle that begins across a wall leaves it, and ends the run half a turn later, where it meets
/// the wall with its other blade; a resumed run ends there too.
#[test]
fn a_paddle_meets_again_the_wall_that_it_has_left() {
    let text = format!(
        "[[wall]]\nfrom = [0.3, 0.5]\nto = [0.7, 0.5]\nmotion = {{ turn = 1.0 }}\n\
         [[wall]]\nfrom = [0.6, 0.45]\nto = [0.6, 0.55]\n{}",
        GASES[0]
    );
    let mut simulation = Simulation::new(&scene(&text)).unwrap();
    // The paddle leaves the wall at the angle arctan 1/2.
    simulation.run_until(1.0).unwrap();
    let mut resumed = Simulation::resume(&simulation.end_epoch_here()).unwrap();
    let meets = std::f64::consts::PI - 0.5f64.atan();
    for simulation in [&mut simulation, &mut resumed] {
        let error = simulation.run_until(4.0).unwrap_err();
        assert!(matches!(error, RunError::WallsMeet { .. }), "{error}");
        let time = simulation.time().to_f64();
        assert!((time - meets).abs() < 1e-4, "{time}");
    }
    assert_eq!(simulation.time(), resumed.time());
}

/// Mirrors the velocities of all bodies and walls: the gas returns to its start.
#[test]
fn a_compressed_gas_returns_when_all_velocities_are_reversed() {
    let mut simulation = Simulation::new(&scene(&format!("{PISTON}{}", GASES[0]))).unwrap();
    let start: Vec<_> = simulation
        .view()
        .bodies()
        .map(|b| b.motion.position)
        .collect();
    simulation.run_until(0.125).unwrap();
    assert!(simulation.view().ledger().work > 0.0);
    simulation.reverse();
    simulation.run_until(0.25).unwrap();
    assert!(simulation.view().ledger().work.abs() < 1e-9);
    for (body, start) in simulation.view().bodies().zip(start) {
        assert!((body.motion.position - start).length() < 1e-9);
    }
}

#[test]
fn a_thermal_wall_that_moves_draws_in_its_own_frame() {
    // Gas and walls at rest relative to each other, in a frame that moves: kT stays 1 there.
    let text = "[box]\nseed = 3\nsides = [1.0, 1.0]\n\
        [[wall]]\nx = 0.0\ntemperature = 1.0\nmotion = { velocity = [2.0, 0.0] }\n\
        [[wall]]\nx = 0.5\ntemperature = 1.0\nmotion = { velocity = [2.0, 0.0] }\n\
        [[gas]]\nradius = 0.004\nmass = 1.0\nenergy = 1.0\ncount = 400";
    let mut simulation = Simulation::new(&scene(text)).unwrap();
    simulation.run_until(5.0).unwrap();
    let (mut mean, mut samples) = (0.0, 0.0);
    for step in 0..40 {
        simulation.run_until(5.0 + 0.5 * f64::from(step)).unwrap();
        for body in simulation
            .view()
            .bodies()
            .filter(|body| !body.body.is_fixed())
        {
            let v = body.motion.velocity - DVec2::new(2.0, 0.0);
            mean += 0.5 * v.length_squared();
            samples += 1.0;
        }
    }
    let kt = mean / samples;
    assert!((kt - 1.0).abs() < 0.05, "{kt}");
    let (view, ledger) = (simulation.view(), simulation.view().ledger());
    assert!((ledger.booked() - view.energy()).abs() < 1e-10);
    assert!(ledger.heat.abs() > 1.0 && ledger.work.abs() > 1.0);
    let mut sums = (WallHeat::new(Group::All), WallWork::new(Group::All));
    simulation.observe_until(30.0, &mut sums).unwrap();
    let after = simulation.view().ledger();
    let [heat, work] = [after.heat - ledger.heat, after.work - ledger.work];
    assert!((sums.0.energy() - heat).abs() < 1e-9, "{heat}");
    assert!(
        (sums.1.energy() - work).abs() < 1e-9 && work != 0.0,
        "{work}"
    );
}

#[test]
fn a_piston_is_stopped_and_sent_back() {
    let mut simulation = Simulation::new(&scene(&format!("{PISTON}{}", GASES[0]))).unwrap();
    let piston = simulation
        .view()
        .bodies()
        .find(|b| b.body.id() == 2)
        .unwrap()
        .body
        .key();
    simulation.run_until(1.0).unwrap();
    simulation
        .move_wall(piston, &WallMotionSpec::default())
        .unwrap();
    let compressed = simulation.view().energy();
    simulation.run_until(2.0).unwrap();
    assert!((simulation.view().energy() - compressed).abs() < 1e-12 * compressed);
    assert!((simulation.view().body(piston).unwrap().motion.position.x - 0.73).abs() < 1e-15);
    let back = WallMotionSpec {
        velocity: [0.25, 0.0],
        ..WallMotionSpec::default()
    };
    simulation.move_wall(piston, &back).unwrap();
    simulation.run_until(3.0).unwrap();
    assert!((simulation.view().body(piston).unwrap().motion.position.x - 0.98).abs() < 1e-15);
    assert!(simulation.view().energy() < compressed);
}

#[test]
fn bodies_without_a_way_out_end_a_run_by_name() {
    let ball = "[[wall]]\nx = 0.125\n[[wall]]\nx = 0.875\ntags = [\"press\"]\nmotion = { velocity = [-0.25, 0.0] }\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 2.0\nat = [0.5, 0.5]\nvelocity = [1.0, 0.25]";
    let mut simulation = Simulation::new(&scene(ball)).unwrap();
    let error = simulation.run_until(10.0).unwrap_err();
    assert!(matches!(error, RunError::Squeezed { .. }), "{error}");
    assert!(error.to_string().contains("(tag press)"), "{error}");
    // The gap of 0.625 closes at 2.5; the run ends where it is about a thousandth of that.
    assert!((simulation.time().to_f64() - 2.5).abs() < 1e-2);
    let gas = "[box]\nsides = [1.0, 0.1]\n[[wall]]\nx = 0.0\n[[wall]]\nx = 0.8\nmotion = { velocity = [-2.0, 0.0] }\n\
        [[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 12\nregion.x = [0.0, 0.8]";
    let mut simulation = Simulation::new(&scene(gas)).unwrap();
    let error = simulation.run_until(10.0).unwrap_err();
    assert!(matches!(error, RunError::Squeezed { .. }), "{error}");
}

#[test]
fn motions_out_of_range_and_drags_are_refused_by_name() {
    let refused = |text: &str| Simulation::new(&scene(text)).unwrap_err().to_string();
    let words = refused("[[wall]]\nx = 0.1\nmotion = { velocity = [inf, 0.0] }");
    assert!(
        words.contains("wall[0]") && words.contains("motion of a wall"),
        "{words}"
    );
    let words = refused("[[wall]]\nx = 0.1\nmotion = { velocity = [1e-80, 0.0] }");
    assert!(words.contains("wall[0]"), "{words}");
    let words = refused("box.drag = 0.5\n[[wall]]\nx = 0.1\nmotion = { velocity = [1.0, 0.0] }");
    assert!(
        words.contains("wall[0]") && words.contains("drag"),
        "{words}"
    );
    let scene = scene("[[wall]]\nx = 0.1\n[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]");
    let mut simulation = Simulation::new(&scene).unwrap();
    let keys: Vec<_> = simulation.view().bodies().map(|b| b.body.key()).collect();
    let motion = WallMotionSpec {
        velocity: [1.0, 0.0],
        ..WallMotionSpec::default()
    };
    let words = simulation
        .move_wall(keys[0], &motion)
        .unwrap_err()
        .to_string();
    assert!(words.contains("no wall"), "{words}");
    simulation.move_wall(keys[1], &motion).unwrap();
    let words = simulation.set_drag(1.0).unwrap_err().to_string();
    assert!(words.contains("drag"), "{words}");
}

#[test]
fn a_paddle_strikes_a_ball_at_the_computed_time_with_twice_the_speed_of_its_face() {
    // The hinge at (1/4, 1/2), the ball at a distance of 1/4 along x, and the paddle at -45
    // degrees.
    for (about, hinge) in [("about = [0.25, 0.5], ", true), ("", false)] {
        let (from, to) = if hinge {
            ([0.25, 0.5], [0.5, 0.25])
        } else {
            ([0.0, 0.75], [0.5, 0.25])
        };
        let text = format!(
            "[[wall]]\nfrom = {from:?}\nto = {to:?}\nmotion = {{ {about}turn = 0.5 }}\n\
             [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 3.0\nat = [0.5, 0.5]"
        );
        let mut simulation = Simulation::new(&scene(&text)).unwrap();
        assert!(simulation.step(10.0, &mut ()).unwrap());
        let (distance, radius, omega) = (0.25f64, 0.0625f64, 0.5);
        let angle = -(radius / distance).asin();
        let time = (angle + std::f64::consts::FRAC_PI_4) / omega;
        assert!((simulation.time().to_f64() - time).abs() < 1e-14);
        let speed = 2.0 * omega * (distance * distance - radius * radius).sqrt();
        let normal = DVec2::from_angle(angle).perp();
        let ball = simulation.view().bodies().next().unwrap().motion.velocity;
        assert!((ball - speed * normal).length() < 1e-14, "{ball}");
        let (energy, work) = (simulation.view().energy(), simulation.view().ledger().work);
        assert!((energy - 1.5 * speed * speed).abs() < 1e-14 && (work - energy).abs() < 1e-14);
    }
}

/// A box with a paddle on a hinge and a stirrer.
const PADDLES: &str = "[box]\nseed = 8\n[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n\
    [[wall]]\nfrom = [0.2, 0.3]\nto = [0.35, 0.3]\nmotion = { turn = 3.0, about = [0.2, 0.3] }\n\
    [[wall]]\nfrom = [0.6, 0.6]\nto = [0.8, 0.7]\nradius = 0.004\nmotion = { turn = -2.0, velocity = [-0.05, 0.02] }\n";

const STIRRED: [&str; 3] = [
    "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 200",
    "[[gas]]\nshape = \"tee\"\natom_radius = 0.006\natom_mass = 1.0\nenergy = 1.0\ncount = 120",
    "[[gas]]\nshape = \"rectangle:2\"\nsize = 0.015\nmass = 1.0\nenergy = 1.0\ncount = 100",
];

#[test]
fn paddles_stir_with_a_balanced_ledger_and_without_overlap() {
    for gas in STIRRED {
        let mut simulation = Simulation::new(&scene(&format!("{PADDLES}{gas}"))).unwrap();
        for step in 1..=6 {
            simulation.run_until(0.2 * f64::from(step)).unwrap();
            let (view, ledger) = (simulation.view(), simulation.view().ledger());
            let energy = view.energy();
            assert!((ledger.booked() - energy).abs() < 1e-12 * energy, "{gas}");
            assert_eq!(view.overlaps().pairs, 0, "{gas} at step {step}");
        }
        assert!(simulation.view().ledger().work != 0.0);
        assert!(simulation.view().counters().fixed_collisions > 100);
        assert_eq!(simulation.view().counters().scheduler.unresolved, 0);
    }
}

#[test]
fn cells_and_the_heap_agree_on_paddles_and_a_resumed_run_on_its_bits() {
    for gas in STIRRED {
        let scene = scene(&format!("{PADDLES}{gas}"));
        let mut cells = Simulation::new(&scene).unwrap();
        let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
        cells.run_until(0.06).unwrap();
        heap.run_until(0.06).unwrap();
        assert!(cells.view().counters().fixed_collisions > 3);
        assert_eq!(
            cells.view().counters().fixed_collisions,
            heap.view().counters().fixed_collisions
        );
        for (a, b) in cells.view().bodies().zip(heap.view().bodies()) {
            assert!(
                (a.motion.velocity - b.motion.velocity).length() < 1e-6,
                "{gas}"
            );
        }
        let mut resumed = Simulation::resume(&cells.end_epoch_here()).unwrap();
        cells.run_until(0.3).unwrap();
        resumed.run_until(0.3).unwrap();
        assert_eq!(cells.view().ledger(), resumed.view().ledger());
        for (a, b) in cells.view().bodies().zip(resumed.view().bodies()) {
            assert_eq!(a.motion, b.motion);
        }
    }
}

#[test]
fn a_paddle_that_has_stopped_is_the_wall_between_its_end_points() {
    let gas =
        "[[gas]]\nshape = \"tee\"\natom_radius = 0.006\natom_mass = 1.0\nenergy = 1.0\ncount = 60";
    let mut simulation = Simulation::new(&scene(&format!("{PADDLES}{gas}"))).unwrap();
    simulation.run_until(0.1).unwrap();
    let walls: Vec<_> = simulation
        .view()
        .bodies()
        .filter_map(|body| Some((body.body.key(), body.wall()?, body.body.reach())))
        .skip(2)
        .collect();
    assert_eq!(walls.len(), 2);
    let mut replaced = simulation.clone();
    for (key, [from, to], radius) in walls {
        simulation
            .move_wall(key, &WallMotionSpec::default())
            .unwrap();
        let wall = carom_engine::WallSpec {
            from: Some(from.to_array()),
            to: Some(to.to_array()),
            radius,
            ..carom_engine::WallSpec::default()
        };
        replaced.remove(key).unwrap();
        replaced.add_wall(&wall).unwrap();
    }
    simulation.run_until(0.4).unwrap();
    replaced.run_until(0.4).unwrap();
    let (one, other) = (simulation.view(), replaced.view());
    assert_eq!(one.counters().collisions, other.counters().collisions);
    for body in one.bodies().filter(|body| !body.body.is_fixed()) {
        let same = other.body(body.body.key()).unwrap();
        assert!((body.motion.velocity - same.motion.velocity).length() < 1e-6);
    }
}

#[test]
fn a_paddle_ends_the_run_where_it_meets_a_post() {
    let text = "[[bumper]]\nradius = 0.0625\nat = [0.5, 0.5]\n\
        [[wall]]\nfrom = [0.25, 0.5]\nto = [0.5, 0.25]\nmotion = { turn = 0.5, about = [0.25, 0.5] }";
    let mut simulation = Simulation::new(&scene(text)).unwrap();
    let error = simulation.run_until(10.0).unwrap_err();
    assert!(matches!(error, RunError::WallsMeet { .. }), "{error}");
    let time = (std::f64::consts::FRAC_PI_4 - 0.25f64.asin()) / 0.5;
    assert!((simulation.time().to_f64() - time).abs() < 1e-11);
}

#[test]
fn turning_walls_that_cannot_be_searched_are_refused_by_name() {
    let refused = |text: &str| Simulation::new(&scene(text)).unwrap_err().to_string();
    let words = refused("[[wall]]\nx = 0.5\nmotion = { turn = 1.0 }");
    assert!(
        words.contains("wall[0]") && words.contains("`from` and `to`"),
        "{words}"
    );
    let words = refused("[[wall]]\nfrom = [0.0, 0.0]\nto = [1.0, 0.5]\nmotion = { turn = 1.0 }");
    assert!(words.contains("shorter than the shorter side"), "{words}");
    let paddle = "[[wall]]\nfrom = [0.1, 0.1]\nto = [0.3, 0.1]\nmotion = { turn = 1.0 }\n";
    let ellipse = "[[molecule]]\nshape = \"ellipse:2\"\nsize = 0.1\nmass = 1.0\nat = [0.5, 0.5]";
    let words = refused(&format!("{paddle}{ellipse}"));
    assert!(
        words.contains("wall[0]") && words.contains("ellipses"),
        "{words}"
    );
    let other = Simulation::<_, _, CellScheduler>::with(
        &scene(paddle),
        carom_detection::BoundingCircles,
        Impact,
        Instructions::Widest,
    );
    let words = other.unwrap_err().to_string();
    assert!(words.contains("walls that turn"), "{words}");
}

/// The place of a piston whose place has a period of 2 and falls by 1/8 in its first half.
fn saw_tooth(time: f64) -> [f64; 2] {
    let phase = time.rem_euclid(2.0);
    if phase < 1.0 {
        [-0.125 * phase, -0.125]
    } else {
        [-0.125 * (2.0 - phase), 0.125]
    }
}

#[test]
fn a_ball_and_a_wall_with_a_table_follow_the_recursion_of_their_contacts() {
    let text = "[[wall]]\nx = 0.125\n[[wall]]\nx = 0.875\n\
        motion = { times = [0.0, 1.0, 2.0], places = [[0.5, 0.0], [0.375, 0.0], [0.5, 0.0]], repeat = true }\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 2.0\nat = [0.5, 0.5]\nvelocity = [0.7, 0.25]";
    let mut simulation = Simulation::new(&scene(text)).unwrap();
    let (mut time, mut place, mut velocity) = (0.0f64, 0.5f64, 0.7f64);
    for contact in 0..24 {
        assert!(simulation.step(1e9, &mut ()).unwrap());
        if velocity < 0.0 {
            time += (place - 0.1875) / -velocity;
            (place, velocity) = (0.1875, -velocity);
        } else {
            // The first piece of the table in which the ball catches up with the piston.
            let (mut start, from) = (time, place);
            loop {
                let end = start.floor() + 1.0;
                let [shift, w] = saw_tooth(start);
                let gap = 0.8125 + shift - (from + velocity * (start - time));
                let after = gap / (velocity - w);
                if after >= 0.0 && start + after <= end {
                    place = from + velocity * (start + after - time);
                    time = start + after;
                    velocity = 2.0 * w - velocity;
                    break;
                }
                start = end;
            }
        }
        let view = simulation.view();
        let motion = view.bodies().next().unwrap().motion;
        let off = (motion.velocity.x - velocity).abs() + (motion.position.x - place).abs();
        let late = (view.time().to_f64() - time).abs();
        assert!(
            off < 1e-10 && late < 1e-10,
            "contact {contact}: {off:e}, {late:e}"
        );
    }
    let (view, ledger) = (simulation.view(), simulation.view().ledger());
    assert!((ledger.booked() - view.energy()).abs() < 1e-13);
}

/// The wall would meet the disc after 3/8, but its table leads it back from 1/4 on.
#[test]
fn the_invariants_hold_where_a_table_prevents_a_contact() {
    let text = "[[wall]]\nx = 0.25\n\
        motion = { times = [0.0, 0.25, 0.5], places = [[0.0, 0.0], [0.125, 0.0], [0.0, 0.0]] }\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 1.0\nat = [0.5, 0.5]";
    let mut simulation = Simulation::new(&scene(text)).unwrap();
    for step in 1..=12 {
        assert_eq!(simulation.check_invariants(0.5), Ok(()));
        simulation.run_until(0.0625 * f64::from(step)).unwrap();
    }
    assert_eq!(simulation.view().counters().collisions, 0);
}

#[test]
fn a_table_ends_at_rest_and_is_resumed_to_the_bit() {
    let text = "[box]\nseed = 4\n[elasticity]\ndefault = 0.9\n[[wall]]\nx = 0.0\n[[wall]]\nx = 0.9\n\
        motion = { times = [0.0, 0.25, 0.5, 1.0], places = [[0.0, 0.0], [-0.125, 0.0], [-0.125, 0.0], [-0.25, 0.0]] }\n\
        [[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 100\nregion.x = [0.0, 0.85]";
    let mut simulation = Simulation::new(&scene(text)).unwrap();
    let place = |simulation: &Simulation| {
        let view = simulation.view();
        let piston = view.bodies().find(|body| body.body.id() == 1).unwrap();
        piston.motion.position.x
    };
    for (time, expected) in [
        (0.125, 0.8375),
        (0.25, 0.775),
        (0.375, 0.775),
        (0.75, 0.7125),
    ] {
        simulation.run_until(time).unwrap();
        assert!((place(&simulation) - expected).abs() < 1e-14, "{time}");
    }
    let mut resumed = Simulation::resume(&simulation.end_epoch_here()).unwrap();
    for one in [&mut simulation, &mut resumed] {
        one.run_until(1.5).unwrap();
        assert!((place(one) - 0.65).abs() < 1e-14);
        let (energy, ledger) = (one.view().energy(), one.view().ledger());
        assert!((ledger.booked() - energy).abs() < 1e-12);
        assert!(ledger.work > 0.0 && ledger.lost > 0.0);
    }
    assert_eq!(simulation.view().ledger(), resumed.view().ledger());
    for (a, b) in simulation.view().bodies().zip(resumed.view().bodies()) {
        assert_eq!(a.motion, b.motion);
    }
}

#[test]
fn tables_out_of_range_are_refused_by_name() {
    for (motion, word) in [
        (
            "times = [0.0, 1.0], places = [[0.0, 0.0]]",
            "as many `places` as `times`",
        ),
        (
            "times = [1.0, 2.0], places = [[0.0, 0.0], [0.1, 0.0]]",
            "begin with 0",
        ),
        (
            "times = [0.0, 0.0], places = [[0.0, 0.0], [0.1, 0.0]]",
            "must ascend",
        ),
        (
            "times = [0.0, 1.0], places = [[0.0, 0.0], [0.1, 0.0]], turn = 1.0",
            "either",
        ),
        ("repeat = true", "at least two"),
    ] {
        let text = format!("[[wall]]\nx = 0.5\nmotion = {{ {motion} }}");
        let words = Simulation::new(&scene(&text)).unwrap_err().to_string();
        assert!(words.contains("wall[0]") && words.contains(word), "{words}");
    }
    let text = "box.drag = 0.1\n[[wall]]\nx = 0.5\n\
        motion = { times = [0.0, 1.0, 2.0], places = [[0.0, 0.0], [0.0, 0.0], [0.1, 0.0]] }";
    let words = Simulation::new(&scene(text)).unwrap_err().to_string();
    assert!(words.contains("drag"), "{words}");
}
