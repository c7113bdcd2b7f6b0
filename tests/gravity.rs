//! Gravity: balls that bounce, molecules that fall on bumpers, and gases over a floor.

use std::f64::consts::TAU;

use carom_detection::FixedStep;
use carom_engine::{
    CellScheduler, CellsPerSide, CollisionReport, HeapScheduler, Instructions, Observer, Scene,
    Simulation,
};
use carom_geometry::{Molecule, gap_between};
use carom_kinematics::{EpochTime, Motion};
use carom_response::Impact;
use glam::DVec2;

use crate::support::simulate;

fn scene(text: &str) -> Scene {
    Scene::from_toml(text).unwrap()
}

/// A ball bounces with one period: its height after n contacts is known.
///
/// Each bounce repeats the rounding of the one before, which adds up in proportion to n: the share
/// of 10⁻¹⁶ n leaves 10⁻¹⁰ of the period for the 10⁶ bounces of the study `gravity/bounces`. With
/// epochs of one contact the orbit repeats to the bit.
#[test]
fn a_ball_bounces_with_one_period() {
    for (gravity, radius, floor) in [(1.0, 0.125, 0.125), (0.7, 0.1, 0.3)] {
        for (contacts_per_epoch, contacts) in [(None, 100_000u32), (Some(1), 20_000)] {
            // From rest at 3/4, to the lowest place of the centre.
            let lowest = radius + floor;
            let text = format!(
                "[gravity]\nacceleration = [0.0, {:?}]\n[[wall]]\ny = {floor:?}\n[[molecule]]\n\
                 shape = \"disc\"\natom_radius = {radius:?}\natom_mass = 3.0\nat = [0.5, 0.75]\n\
                 velocity = [0.3, 0.0]",
                -gravity
            );
            let mut simulation = Simulation::new(&scene(&text)).unwrap();
            if let Some(contacts) = contacts_per_epoch {
                simulation.set_contacts_per_epoch(contacts);
            }
            let speed = f64::sqrt(2.0 * gravity * (0.75 - lowest));
            let period = 2.0 * speed / gravity;
            let mut before = EpochTime::from(-0.5 * period);
            let mut last = 0.0;
            for contact in 0..contacts {
                assert!(simulation.step(1e9, &mut ()).unwrap());
                let view = simulation.view();
                let motion = view.bodies().next().unwrap().motion;
                let late = view.time().since(before) / period - 1.0;
                let off = (motion.velocity - DVec2::new(0.3, speed)).length();
                let allowed = match contacts_per_epoch {
                    None => 1e-14 + 1e-16 * f64::from(contact),
                    Some(_) => 1e-14,
                };
                assert!(
                    late.abs() < allowed && off < allowed,
                    "{gravity}, {contact}: {late:e} {off:e}"
                );
                assert!((motion.position.y - lowest).abs() < 1e-14);
                (before, last) = (view.time(), late);
            }
            eprintln!("{gravity}, {contacts_per_epoch:?}: the last period is off by {last:e}");
            let (view, ledger) = (simulation.view(), simulation.view().ledger());
            assert!((ledger.fallen - (view.energy() - ledger.initial)).abs() < 2e-11);
        }
    }
}

/// A dumbbell above a bumper and a floor: each contact is the first zero of the gap of the two
/// shapes on a parabola, found by sampling and bisection.
#[test]
fn a_dumbbell_falls_on_a_bumper_as_an_independent_reference_has_it() {
    let text = "[gravity]\nacceleration = [0.0, -2.0]\n[[wall]]\ny = 0.05\nradius = 0.01\n\
        [[bumper]]\nradius = 0.15\nat = [0.5, 0.3]\n\
        [[molecule]]\nshape = \"dumbbell\"\natom_radius = 0.05\natom_mass = 1.0\nat = [0.55, 0.75]\n\
        velocity = [0.2, 0.1]\nangular_velocity = 3.0";
    let mut simulation = Simulation::new(&scene(text)).unwrap();
    let dumbbell = simulation
        .view()
        .bodies()
        .next()
        .unwrap()
        .body
        .molecule()
        .clone();
    let bumper = Molecule::disc(0.15, 1.0).unwrap();
    let gravity = DVec2::new(0.0, -2.0);
    let rotation = |motion: &Motion, time: f64| {
        let turned = motion.orientation.turned(motion.angular_velocity, time);
        turned.cos_sin()
    };
    let gap = |motion: &Motion, time: f64| {
        let place = motion.position + time * motion.velocity + 0.5 * time * time * gravity;
        let to_lowest = dumbbell
            .atoms()
            .iter()
            .map(|atom| place.y + rotation(motion, time).rotate(atom.offset()).y - 0.05);
        let over_floor = to_lowest.fold(f64::INFINITY, f64::min) - 0.06;
        let mut least = over_floor;
        for column in -2..=2 {
            let centre = DVec2::new(0.5 + f64::from(column), 0.3);
            let turned = rotation(motion, time);
            least = least.min(gap_between(
                &dumbbell,
                turned,
                &bumper,
                DVec2::X,
                centre - place,
            ));
        }
        least
    };
    let (mut on_bumper, mut before) = (0, 0.0);
    let mut motion = simulation.view().bodies().next().unwrap().motion;
    for contact in 0..300 {
        // The gap is positive just after a contact.
        let (step, mut from) = (2e-5, 1e-7);
        while gap(&motion, from + step) > 0.0 {
            from += step;
        }
        let mut to = from + step;
        for _ in 0..60 {
            let middle = 0.5 * (from + to);
            if gap(&motion, middle) > 0.0 {
                from = middle;
            } else {
                to = middle;
            }
        }
        assert!(simulation.step(1e9, &mut ()).unwrap());
        let view = simulation.view();
        let late = (view.time().to_f64() - before) - to;
        assert!(late.abs() < 1e-11, "contact {contact}: {late:e}");
        before = view.time().to_f64();
        motion = view.bodies().next().unwrap().motion;
        on_bumper += u32::from(motion.position.y > 0.3);
        assert!((view.ledger().booked() - view.energy()).abs() < 1e-12);
    }
    assert!(on_bumper > 20, "{on_bumper}");
}

const WALLS: &str = "[box]\nseed = 7\nsides = [1.0, 2.0]\n[gravity]\nacceleration = [0.0, -3.0]\n[[wall]]\ny = 0.02\n";

const GASES: [&str; 6] = [
    // Discs, few and many with large ones; molecules; bodies with sides; ellipses; over bumpers.
    "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 60\nregion.y = [0.1, 0.9]",
    "[[gas]]\nradius = 0.008\nmass = 1.0\nenergy = 1.0\ncount = 500\nregion.y = [0.1, 0.9]\n\
     [[gas]]\nradius = 0.05\nmass = 9.0\nenergy = 1.0\ncount = 4\nregion.y = [1.0, 1.5]",
    "[[gas]]\nshape = \"tee\"\natom_radius = 0.008\natom_mass = 1.0\nenergy = 1.0\ncount = 120\nregion.y = [0.1, 0.9]",
    "[[gas]]\nshape = \"square\"\nsize = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 120\nregion.y = [0.1, 0.9]",
    "[[gas]]\nshape = \"ellipse:3\"\nsize = 0.04\nmass = 1.0\nenergy = 1.0\ncount = 120\nregion.y = [0.1, 0.9]",
    "[[bumper]]\nradius = 0.1\nat = [0.3, 0.2]\n[[bumper]]\nradius = 0.02\nat = [0.7, 0.5]\n\
     [[wall]]\nfrom = [0.45, 0.3]\nto = [0.6, 0.2]\n\
     [[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 150\nregion.y = [0.6, 1.2]\n\
     [[gas]]\nshape = \"tee\"\natom_radius = 0.01\natom_mass = 1.0\nenergy = 1.0\ncount = 20\nregion.y = [1.2, 1.6]",
];

/// The momentum that walls and other fixed bodies give to the gas.
#[derive(Default)]
struct Given(DVec2);

impl Observer for Given {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        if let Some(fixed) = report.sides.iter().position(|side| side.body.is_fixed()) {
            let side = &report.sides[1 - fixed];
            let mass = side.body.molecule().mass();
            self.0 += mass * (side.after.velocity - side.before.velocity);
        }
    }
}

/// The ledger balances with the work of gravity, and the momentum with that of the fixed bodies and
/// of the weight: the floor carries N m g.
#[test]
fn energy_and_momentum_balance_over_a_floor() {
    for gas in GASES {
        let mut simulation = Simulation::new(&scene(&format!("{WALLS}{gas}"))).unwrap();
        let (mut given, start) = (Given::default(), simulation.view().momentum());
        let bodies = |simulation: &Simulation| -> f64 {
            let view = simulation.view();
            let free = view.bodies().filter(|body| !body.body.is_fixed());
            free.map(|body| body.body.molecule().mass()).sum()
        };
        let mass = bodies(&simulation);
        for step in 1..=8 {
            let until = 0.125 * f64::from(step);
            simulation.observe_until(until, &mut given).unwrap();
            let (view, ledger) = (simulation.view(), simulation.view().ledger());
            let off = ledger.booked() - view.energy();
            assert!(off.abs() < 1e-11 * view.energy(), "{gas}: {off:e}");
            assert_eq!(view.overlaps().pairs, 0, "{gas} at step {step}");
            let weight = DVec2::new(0.0, -3.0 * mass * until);
            let off = (view.momentum() - start - weight - given.0).length();
            assert!(off < 1e-10 * weight.length(), "{gas}: {off:e}");
            for body in view.bodies().filter(|body| !body.body.is_fixed()) {
                assert!(body.unwrapped(&view.bounds()).y > 0.02);
            }
            let mut fixed = view.bodies().filter(|body| body.body.is_fixed());
            assert!(fixed.all(|body| body.motion.is_at_rest()));
        }
        let counters = simulation.view().counters();
        assert!(counters.fixed_collisions > 20, "{counters:?}");
    }
}

#[test]
fn no_contact_of_a_falling_gas_is_missed() {
    for gas in GASES {
        let mut simulation = Simulation::new(&scene(&format!("{WALLS}{gas}"))).unwrap();
        let small = simulation.view().bodies().count() < 200;
        for step in 1..if small { 12 } else { 4 } {
            simulation.run_until(0.05 * f64::from(step)).unwrap();
            simulation.check_invariants(0.02).unwrap();
        }
    }
}

#[test]
fn cells_and_the_heap_agree_on_a_falling_gas() {
    for gas in GASES {
        let scene = scene(&format!("{WALLS}{gas}"));
        let mut cells = simulate::<CellScheduler>(&scene, &Instructions::Widest);
        let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
        let until = if gas.contains("500") { 0.04 } else { 0.1 };
        cells.run_until(until).unwrap();
        heap.run_until(until).unwrap();
        let (one, other) = (cells.view(), heap.view());
        assert_eq!(
            one.counters().collisions,
            other.counters().collisions,
            "{gas}"
        );
        assert!(one.counters().collisions > 5, "{gas}");
        for (a, b) in one.bodies().zip(other.bodies()) {
            let off = (a.motion.velocity - b.motion.velocity).length();
            assert!(off < 1e-6, "{gas}: {off:e}");
        }
    }
}

#[test]
fn a_falling_gas_is_resumed_to_the_bit() {
    for gas in GASES {
        let mut simulation = Simulation::new(&scene(&format!("{WALLS}{gas}"))).unwrap();
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
fn a_falling_gas_returns_when_all_velocities_are_reversed() {
    let mut simulation = Simulation::new(&scene(&format!("{WALLS}{}", GASES[0]))).unwrap();
    let places = |simulation: &Simulation| -> Vec<DVec2> {
        let view = simulation.view();
        let bodies = view.bodies();
        bodies.map(|body| body.unwrapped(&view.bounds())).collect()
    };
    let start = places(&simulation);
    simulation.run_until(0.25).unwrap();
    assert!(simulation.view().ledger().fallen.abs() > 1.0);
    simulation.reverse();
    simulation.run_until(0.5).unwrap();
    assert!(simulation.view().ledger().fallen.abs() < 1e-8);
    for (place, start) in places(&simulation).iter().zip(start) {
        assert!((*place - start).length() < 1e-8);
    }
}

/// Sampling does not change the trajectory: the laboratory is only a way to look at it.
#[test]
fn samples_change_no_bit() {
    let scene = scene(&format!("{WALLS}{}", GASES[2]));
    let mut one = Simulation::new(&scene).unwrap();
    let mut other = one.clone();
    one.run_until(0.5).unwrap();
    for step in 1..=50 {
        other.run_until(0.01 * f64::from(step)).unwrap();
        assert!(other.view().energy() > 0.0);
    }
    for (a, b) in one.view().bodies().zip(other.view().bodies()) {
        assert_eq!(a.motion, b.motion);
    }
}

#[test]
fn gravity_is_switched_on_and_off() {
    let text = "[[wall]]\ny = 0.0\n[[molecule]]\nshape = \"disc\"\natom_radius = 0.05\natom_mass = 1.0\nat = [0.5, 0.75]\n\
        velocity = [1.0, 0.0]";
    let mut simulation = Simulation::new(&scene(text)).unwrap();
    simulation.run_until(0.25).unwrap();
    simulation.set_gravity([0.0, -1.0]).unwrap();
    simulation.run_until(0.75).unwrap();
    simulation.set_gravity([0.0, 0.0]).unwrap();
    simulation.run_until(1.0).unwrap();
    let view = simulation.view();
    let motion = view.bodies().next().unwrap().motion;
    assert!((motion.velocity - DVec2::new(1.0, -0.5)).length() < 1e-15);
    assert!((motion.position.y - (0.75 - 0.125 - 0.125)).abs() < 1e-15);
    assert!((view.ledger().booked() - view.energy()).abs() < 1e-15);
}

/// A shaken floor keeps an inelastic gas awake; the energy balances with its work, the losses and
/// gravity.
#[test]
fn a_shaken_bed_balances_its_energy() {
    let text = "[box]\nseed = 3\nsides = [1.0, 2.0]\n[gravity]\nacceleration = [0.0, -1.0]\n[elasticity]\ndefault = 0.9\n\
        contact_time = 1e-5\n[[wall]]\ny = 0.1\nmotion = { amplitude = [0.0, 0.02], frequency = 30.0 }\n\
        [[gas]]\nradius = 0.02\nmass = 1.0\ntemperature = 0.1\ncount = 60\nregion.y = [0.2, 1.0]";
    let mut simulation = Simulation::new(&scene(text)).unwrap();
    for step in 1..=20 {
        simulation.run_until(0.5 * f64::from(step)).unwrap();
        let (view, ledger) = (simulation.view(), simulation.view().ledger());
        assert!((ledger.booked() - view.energy()).abs() < 1e-10 * ledger.work.abs().max(1.0));
        assert_eq!(view.overlaps().pairs, 0);
    }
    let ledger = simulation.view().ledger();
    assert!(ledger.work > 1.0 && ledger.lost > 1.0, "{ledger:?}");
    let phase = (30.0 * simulation.view().time().to_f64()).rem_euclid(TAU);
    let view = simulation.view();
    let floor = view.bodies().find(|body| body.body.is_wall()).unwrap();
    assert!((floor.motion.position.y - 0.1 - 0.02 * f64::sin(phase)).abs() < 1e-12);
}

#[test]
fn gravities_that_cannot_be_computed_are_refused_by_name() {
    let ball =
        "[[molecule]]\nshape = \"disc\"\natom_radius = 0.05\natom_mass = 1.0\nat = [0.5, 0.75]\n";
    for (text, word) in [
        (
            "[gravity]\nacceleration = [0.0, -1.0]\n",
            "through the periodic box along y",
        ),
        (
            "[gravity]\nacceleration = [0.1, -1.0]\n[[wall]]\ny = 0.0\n",
            "along x",
        ),
        (
            "[gravity]\nacceleration = [0.0, -1e61]\n[[wall]]\ny = 0.0\n",
            "in magnitude",
        ),
        (
            "[gravity]\nacceleration = [0.0, nan]\n[[wall]]\ny = 0.0\n",
            "in magnitude",
        ),
        (
            "box.drag = 0.5\n[gravity]\nacceleration = [0.0, -1.0]\n[[wall]]\ny = 0.0\n",
            "drag",
        ),
        (
            "[gravity]\nacceleration = [0.0, -1.0]\n[[wall]]\ny = 0.0\n[[container]]\ncircle = { at = [0.5, 0.7], radius = 0.2 }\n",
            "curved walls",
        ),
    ] {
        let words = Simulation::new(&scene(&format!("{text}{ball}")))
            .unwrap_err()
            .to_string();
        assert!(words.contains("gravity") && words.contains(word), "{words}");
    }
    let tagged = ball.replace("[[molecule]]", "[[molecule]]\ntags = [\"ball\"]");
    for (rule, word) in [
        (
            "[[transparent]]\nbetween = [\"ball\", \"floor\"]\n",
            "does not see the walls",
        ),
        (
            "[[bumper]]\ntags = [\"ball\"]\nradius = 0.1\nat = [0.2, 0.5]\n\
             [[diameter]]\nbetween = [\"ball\", \"ball\"]\nfactor = 1.5\n",
            "diameters",
        ),
    ] {
        let floor =
            "[gravity]\nacceleration = [0.0, -1.0]\n[[wall]]\ntags = [\"floor\"]\ny = 0.0\n";
        let text = format!("{floor}{rule}{tagged}");
        let words = Simulation::new(&scene(&text)).unwrap_err().to_string();
        assert!(words.contains("gravity") && words.contains(word), "{words}");
    }
    let text = format!("[gravity]\nacceleration = [0.0, -1.0]\n[[wall]]\ny = 0.0\n{ball}");
    let other = Simulation::<FixedStep, Impact, CellScheduler>::with(
        &scene(&text),
        FixedStep::default(),
        Impact,
        Instructions::Widest,
    );
    let words = other.unwrap_err().to_string();
    assert!(words.contains("fall"), "{words}");
}

/// Epochs that end with a contact, and edits in the middle of one, book the work of gravity too.
#[test]
fn short_epochs_and_edits_balance_the_ledger() {
    for gas in [GASES[0], GASES[2], GASES[5]] {
        let mut simulation = Simulation::new(&scene(&format!("{WALLS}{gas}"))).unwrap();
        simulation.set_contacts_per_epoch(1);
        for step in 1..=10 {
            simulation.run_until(0.05 * f64::from(step)).unwrap();
            let balances = |simulation: &Simulation| {
                let (view, ledger) = (simulation.view(), simulation.view().ledger());
                let off = ledger.booked() - view.energy();
                assert!(off.abs() < 1e-10 * view.energy(), "{gas}: {off:e}");
            };
            balances(&simulation);
            match step {
                4 => simulation
                    .edit(|batch| batch.reset_energy_of_all(1.0))
                    .unwrap(),
                6 => {
                    simulation
                        .add(
                            &Scene::from_toml(
                                "[[molecule]]\nshape = \"disc\"\natom_radius = 0.01\natom_mass = 2.0\n\
                                 at = [0.1, 1.9]\nvelocity = [0.1, 0.2]",
                            )
                            .unwrap()
                            .molecule[0],
                        )
                        .unwrap();
                }
                8 => simulation.set_contacts_per_epoch(64),
                _ => {}
            }
            balances(&simulation);
        }
    }
}

/// A gravity that hardly acts in an epoch.
#[test]
fn a_weak_gravity_lists_fixed_bodies_where_they_are() {
    for gravity in ["-1e-6", "-1e-60"] {
        let text = format!(
            "[gravity]\nacceleration = [0.0, {gravity}]\n[[wall]]\ny = 0.0\n[[bumper]]\nradius = 0.1\nat = [0.3, 0.4]\n\
             [[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 4.0\ncount = 50\nregion.y = [0.55, 0.95]"
        );
        let scene = scene(&text);
        let mut cells = Simulation::new(&scene).unwrap();
        let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
        cells.run_until(0.2).unwrap();
        heap.run_until(0.2).unwrap();
        let counts = [cells.view().counters(), heap.view().counters()]
            .map(|counters| [counters.collisions, counters.fixed_collisions]);
        assert_eq!(counts[0], counts[1]);
        assert!(counts[0][1] > 5, "{counts:?}");
        assert_eq!(cells.view().overlaps().pairs, 0);
    }
}

/// A ball at rest on the floor, and one that comes to rest: bounces by rounding, the guard's small
/// bounces, or an error by name; never an overlap.
#[test]
fn balls_at_rest_on_the_floor_neither_sink_nor_hang() {
    for (elasticity, height) in [
        ("default = 1.0", 0.0),
        ("default = 0.5", 0.25),
        ("default = 0.0", 0.25),
        ("default = 0.5\ncontact_time = 1e-3", 0.25),
        ("default = 0.0\ncontact_time = 1e-3", 0.0),
    ] {
        let y = 0.25 + height;
        let text = format!(
            "[gravity]\nacceleration = [0.0, -1.0]\n[elasticity]\n{elasticity}\n[[wall]]\ny = 0.125\n\
             [[molecule]]\nshape = \"disc\"\natom_radius = 0.125\natom_mass = 1.0\nat = [0.5, {y:?}]"
        );
        let mut simulation = Simulation::new(&scene(&text)).unwrap();
        let mut contacts = 0;
        let ended = loop {
            match simulation.step(5.0, &mut ()) {
                Ok(true) if contacts < 20_000 => contacts += 1,
                other => break other,
            }
        };
        let view = simulation.view();
        assert_eq!(view.overlaps().pairs, 0, "{elasticity}: {ended:?}");
        let ball = view.bodies().next().unwrap().motion;
        assert!(ball.position.y > 0.25 - 1e-12, "{elasticity}: {ball:?}");
        if elasticity.contains("contact_time") {
            assert!(
                ended.is_ok() && contacts < 20_000,
                "{elasticity}: {ended:?} {contacts}"
            );
        }
        let off = view.ledger().booked() - view.energy();
        assert!(off.abs() < 1e-12, "{elasticity}: {off:e}");
    }
}
