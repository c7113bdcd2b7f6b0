//! Pistons: walls with a mass, which contacts, a force and their stops move.

use carom_detection::Exact;
use carom_engine::{
    CellScheduler, CellsPerSide, HeapScheduler, Instructions, Scene, SceneError, Simulation,
};
use carom_response::Impact;

use crate::support::simulate;

pub fn scene(text: &str) -> Scene {
    Scene::from_toml(text).unwrap()
}

/// The place and velocity of the piston, which is the last wall of the scene.
pub fn piston<S: carom_engine::scheduler::Scheduler>(
    simulation: &Simulation<Exact, Impact, S>,
) -> [f64; 2] {
    let view = simulation.view();
    let piston = view.bodies().find(|body| body.body.is_piston()).unwrap();
    [piston.motion.position.x, piston.motion.velocity.x]
}

/// Two balls on both sides of a piston between two walls: a system of three bodies on a line, whose
/// events follow from their places and velocities alone.
#[test]
fn two_balls_beside_a_piston_follow_the_collisions_on_a_line() {
    let text = "[[wall]]\nx = 0.0\n[[piston]]\nx = 0.5\nradius = 0.03125\nmass = 7.0\nvelocity = 0.25\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 2.0\nat = [0.25, 0.5]\nvelocity = [1.0, 0.0]\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.125\natom_mass = 3.0\nat = [0.75, 0.25]\nvelocity = [-0.5, 0.0]";
    let scene = scene(text);
    let mut cells = simulate::<CellScheduler>(&scene, &Instructions::Widest);
    let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
    let masses = [2.0, 7.0, 3.0];
    let (mut places, mut velocities) = ([0.25_f64, 0.5, 0.75], [1.0_f64, 0.25, -0.5]);
    let mut time = 0.0;
    for contact in 0..300 {
        // Rooms between left wall, ball, piston, ball, right wall.
        let rooms = [
            places[0] - 0.0625,
            places[1] - places[0] - 0.09375,
            places[2] - places[1] - 0.15625,
            1.0 - 0.125 - places[2],
        ];
        let closing = [
            -velocities[0],
            velocities[0] - velocities[1],
            velocities[1] - velocities[2],
            velocities[2],
        ];
        let (next, wait) = (0..4)
            .filter(|&room| closing[room] > 0.0)
            .map(|room| (room, rooms[room] / closing[room]))
            .min_by(|one, other| one.1.total_cmp(&other.1))
            .unwrap();
        time += wait;
        for body in 0..3 {
            places[body] += velocities[body] * wait;
        }
        match next {
            0 => velocities[0] = -velocities[0],
            3 => velocities[2] = -velocities[2],
            room => {
                let (a, b) = (room - 1, room);
                let (m, n): (f64, f64) = (masses[a], masses[b]);
                let common = (m * velocities[a] + n * velocities[b]) / (m + n);
                velocities[a] = 2.0 * common - velocities[a];
                velocities[b] = 2.0 * common - velocities[b];
            }
        }
        assert!(cells.step(1e9, &mut ()).unwrap() && heap.step(1e9, &mut ()).unwrap());
        for found in [
            (cells.time().to_f64(), piston(&cells)),
            (heap.time().to_f64(), piston(&heap)),
        ] {
            let off = [
                found.0 - time,
                found.1[0] - places[1],
                found.1[1] - velocities[1],
            ];
            assert!(
                off.iter().all(|difference| difference.abs() < 1e-10),
                "{contact}: {off:?}"
            );
        }
    }
    let (energy, ledger) = (cells.view().energy(), cells.view().ledger());
    assert!((energy - ledger.booked()).abs() < 1e-13 * energy);
}

/// A piston without a gas goes to and fro between its stops, and with a force it bounces.
#[test]
fn stops_reflect_a_piston_at_the_known_times() {
    let free = "[[piston]]\nx = 0.3\nmass = 2.0\nvelocity = 0.5\nstops = [0.2, 0.7]\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.01\natom_mass = 1.0\nat = [0.9, 0.5]";
    let mut simulation = Simulation::new(&scene(free)).unwrap();
    for step in 1..400 {
        let time = 0.0175 * f64::from(step);
        simulation.run_until(time).unwrap();
        // A way of 1/2 upwards from 0.2, then back.
        let phase = (0.1 + 0.5 * time) % 1.0;
        let (place, velocity) = if phase < 0.5 {
            (0.2 + phase, 0.5)
        } else {
            (1.2 - phase, -0.5)
        };
        let found = piston(&simulation);
        assert!(
            (found[0] - place).abs() < 1e-12 && found[1] == velocity,
            "{time}: {found:?} {place} {velocity}"
        );
    }
    // From rest at 0.3 with the acceleration −1, it reaches the stop at 0.1 after √0.4.
    let pushed = "[[piston]]\nx = 0.3\nmass = 2.0\nforce = -2.0\nstops = [0.1, 0.7]\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.01\natom_mass = 1.0\nat = [0.9, 0.5]";
    let mut simulation = Simulation::new(&scene(pushed)).unwrap();
    let fall = f64::sqrt(0.4);
    for step in 1..400 {
        let time = 0.0925 * f64::from(step);
        simulation.run_until(time).unwrap();
        let since = (time + fall) % (2.0 * fall) - fall;
        let found = piston(&simulation);
        let place = 0.3 - 0.5 * since * since;
        assert!(
            (found[0] - place).abs() < 1e-11,
            "{time}: {found:?} {place}"
        );
        let (view, ledger) = (simulation.view(), simulation.view().ledger());
        assert!((ledger.fallen - 2.0 * (0.3 - found[0])).abs() < 1e-11);
        assert!((view.energy() - ledger.booked()).abs() < 1e-13);
    }
}

/// A way of 1/2 after 0.8, each later one in 4/3 of the time of the one before.
#[test]
fn a_piston_keeps_the_share_of_its_stops_between_them() {
    let text = "[[piston]]\nx = 0.3\nmass = 2.0\nvelocity = 0.5\nstops = [0.2, 0.7]\nstop_elasticity = 0.75\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.01\natom_mass = 1.0\nat = [0.9, 0.5]";
    let mut simulation = Simulation::new(&scene(text)).unwrap();
    let initial = 0.25;
    let (mut time, mut speed) = (0.8, 0.5);
    for reflections in 1..=20 {
        speed *= 0.75;
        let duration = 0.5 / speed;
        simulation.run_until(time + 0.25 * duration).unwrap();
        let (place, velocity) = if reflections % 2 == 1 {
            (0.575, -speed)
        } else {
            (0.325, speed)
        };
        let found = piston(&simulation);
        assert!(
            (found[0] - place).abs() < 1e-12 && (found[1] - velocity).abs() < 1e-15 * speed,
            "{reflections}: {found:?} {place} {velocity}"
        );
        let kept = f64::powi(0.75, 2 * reflections);
        let (energy, ledger) = (simulation.view().energy(), simulation.view().ledger());
        assert!((energy - initial * kept).abs() < 1e-14 * energy);
        assert!((ledger.lost - initial * (1.0 - kept)).abs() < 1e-14 * initial);
        assert!((energy - ledger.booked()).abs() < 1e-14 * initial);
        time += duration;
    }
}

/// A disc of twice the mass of a piston at rest on its stop, with e = 0: the piston has 4/3 of the
/// speed of the disc for an instant, and then none; the disc, with 1/3, meets it again. The stops
/// that follow in the same instant are elastic, and the collisions on a line end by 4.
#[test]
fn a_piston_rests_on_its_stop_and_a_heavy_disc_is_reflected_by_finitely_many_contacts() {
    let text = "[[piston]]\nx = 0.6\nmass = 1.0\nvelocity = 0.5\nstops = [0.2, 0.7]\nstop_elasticity = 0.0\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 2.0\nat = [0.4, 0.5]\n\
        velocity = [1.0, 0.0]";
    let scene = scene(text);
    let mut cells = Simulation::new(&scene).unwrap();
    let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
    cells.run_until(0.22).unwrap();
    heap.run_until(0.22).unwrap();
    for [place, velocity] in [piston(&cells), piston(&heap)] {
        assert!((place - 0.7).abs() < 1e-15 && velocity == 0.0, "{place}");
    }
    assert!((cells.view().ledger().lost - 0.125).abs() < 1e-15);
    cells.run_until(0.3).unwrap();
    heap.run_until(0.3).unwrap();
    let disc = cells.view().bodies().find(|body| body.body.is_free());
    let velocity = disc.unwrap().motion.velocity.x;
    assert!((velocity + 23.0 / 81.0).abs() < 1e-14, "{velocity}");
    for [_, velocity] in [piston(&cells), piston(&heap)] {
        assert!((velocity + 20.0 / 81.0).abs() < 1e-14, "{velocity}");
    }
    let (view, ledger) = (cells.view(), cells.view().ledger());
    assert_eq!(view.counters().collisions, 4);
    assert!((ledger.lost - (0.125 + 8.0 / 9.0)).abs() < 1e-14);
    assert!((view.energy() - ledger.booked()).abs() < 1e-14);
}

/// Pressed against its stop, a piston comes to rest there but for the bounces of the guard: with
/// c = 10⁻⁴ and the way 0.6 between its stops they are 1.5·10⁻⁵ high. At the contact time 0 the
/// default is taken.
#[test]
fn a_piston_pressed_against_a_stop_that_takes_energy_comes_to_rest_there() {
    let pressed = "[[piston]]\nx = 0.3\nmass = 2.0\nforce = -2.0\nstops = [0.1, 0.7]\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.01\natom_mass = 1.0\nat = [0.9, 0.5]\n";
    let on_spring = pressed.replace("force = -2.0", "spring = 2.0\nrelaxed_at = -0.9");
    let at_stop = pressed.replace("x = 0.3", "x = 0.1");
    for (text, height) in [
        (pressed, 0.2),
        (&on_spring, 0.2),
        (&at_stop, 0.0),
        (&format!("{pressed}[elasticity]\ncontact_time = 0.0"), 0.2),
    ] {
        for elasticity in ["0.0", "0.5", "0.9"] {
            let with = format!("stops = [0.1, 0.7]\nstop_elasticity = {elasticity}");
            let text = text.replace("stops = [0.1, 0.7]", &with);
            let mut simulation = Simulation::new(&scene(&text)).unwrap();
            // The bounces of e = 0.9 take √0.4 (1 + 2 e/(1 − e)) = 12.
            simulation.run_until(14.0).unwrap();
            for step in 1..50 {
                simulation.run_until(14.0 + 0.03 * f64::from(step)).unwrap();
                let above = piston(&simulation)[0] - 0.1;
                assert!(above > -1e-12 && above < 1.51e-5, "{text}: {above}");
            }
            let (view, ledger) = (simulation.view(), simulation.view().ledger());
            assert!((view.energy() - ledger.booked()).abs() < 1e-13);
            // The potential energy is gone, but for that of the bounces.
            let stiffness = if text.contains("spring") { 2.0 } else { 0.0 };
            let fallen = 2.0 * height + 0.5 * stiffness * height * height;
            assert!((ledger.lost - fallen).abs() < 4e-5, "{text}: {ledger:?}");
        }
    }
}

/// The piston would meet the disc beyond its stop, but is reflected there before.
#[test]
fn the_invariants_hold_where_a_stop_prevents_a_contact() {
    let scene = scene(
        "[[piston]]\nx = 0.5\nmass = 1.0\nvelocity = 1.0\nstops = [0.25, 0.625]\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 1.0\nat = [0.75, 0.5]",
    );
    let mut simulation = Simulation::new(&scene).unwrap();
    for step in 1..=20 {
        assert_eq!(simulation.check_invariants(0.5), Ok(()));
        simulation.run_until(0.0625 * f64::from(step)).unwrap();
    }
    assert_eq!(simulation.view().counters().collisions, 0);
}

/// A dumbbell over the border touches the piston with the atom that is beyond it.
#[test]
fn both_schedulers_find_the_contact_of_a_molecule_over_the_border() {
    let scene = scene(
        "[[piston]]\nx = 0.25\nmass = 4.0\nstops = [0.125, 0.75]\n\
        [[molecule]]\nshape = \"dumbbell\"\natom_radius = 0.0625\natom_mass = 1.0\nat = [0.5, 0.0078125]\n\
        orientation_turns = 0.1875\nvelocity = [-1.0, 0.0]\nrotation = \"locked\"",
    );
    let mut cells = Simulation::new(&scene).unwrap();
    let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
    cells.run_until(0.5).unwrap();
    heap.run_until(0.5).unwrap();
    assert_eq!(cells.view().counters().collisions, 1);
    assert_eq!(heap.view().counters().collisions, 1);
    assert!((piston(&cells)[1] - piston(&heap)[1]).abs() < 1e-15);
}

/// Under a gravity along the piston a disc meets the image of the piston beyond the border: the
/// places of the search are those of a frame that falls.
#[test]
fn both_schedulers_find_the_contact_of_a_disc_that_falls_over_the_border() {
    let scene = scene(
        "[gravity]\nacceleration = [0.0, 5.0]\n[[wall]]\ny = 0.5\n\
        [[piston]]\nx = 0.25\nmass = 4.0\nstops = [0.125, 0.75]\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 1.0\nat = [0.5, 0.9921875]\n\
        velocity = [-1.0, 0.0]",
    );
    let mut cells = Simulation::new(&scene).unwrap();
    let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
    cells.run_until(0.25).unwrap();
    heap.run_until(0.25).unwrap();
    assert_eq!(cells.view().counters().collisions, 1);
    assert_eq!(heap.view().counters().collisions, 1);
    assert!((piston(&cells)[1] - piston(&heap)[1]).abs() < 1e-15);
}

/// A piston passes through a bumper that it does not see, and is resumed within it.
#[test]
fn a_piston_within_a_body_that_it_does_not_see_is_resumed() {
    let scene = scene(
        "[[piston]]\nx = 0.3\nmass = 1.0\nvelocity = 1.0\nstops = [0.1, 0.9]\ntags = [\"piston\"]\n\
        [[bumper]]\nradius = 0.1\nat = [0.5, 0.5]\ntags = [\"post\"]\n\
        [[transparent]]\nbetween = [\"piston\", \"post\"]",
    );
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.run_until(0.25).unwrap();
    let checkpoint = simulation.end_epoch_here();
    let mut resumed: Simulation = Simulation::resume(&checkpoint).unwrap();
    resumed.run_until(0.75).unwrap();
    // Reflected at 0.9 after a time of 0.6.
    let [place, velocity] = piston(&resumed);
    assert!((place - 0.75).abs() < 1e-14, "{place}");
    assert_eq!(velocity, -1.0);
}

/// A gas of discs and dumbbells on both sides of a piston with a force.
const TWO_GASES: &str = "[box]\nsides = [2.0, 1.0]\n[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n\
    [[piston]]\nx = 0.75\nradius = 0.01\nmass = 5.0\nforce = -1.5\ntags = [\"piston\"]\n\
    [[gas]]\nradius = 0.02\nmass = 1.0\ntemperature = 1.0\ncount = 60\n\
    [[gas]]\nshape = \"dumbbell\"\nradius = 0.015\nmass = 0.5\ntemperature = 0.5\ncount = 40";

/// The same gases with a spring in place of the force.
pub fn on_spring() -> String {
    TWO_GASES.replace("force = -1.5", "spring = 400.0\nrelaxed_at = 0.9")
}

/// The same gases with a piston that its force presses on a stop, which takes energy.
fn pressed_on_stop() -> String {
    let stops = "force = -150.0\nstops = [0.5, 1.0]\nstop_elasticity = 0.5";
    TWO_GASES.replace("force = -1.5", stops)
}

#[test]
fn gases_beside_a_piston_conserve_their_energy_and_do_not_overlap() {
    for text in [
        TWO_GASES.to_owned(),
        TWO_GASES.replace("force = -1.5", ""),
        on_spring(),
        pressed_on_stop(),
    ] {
        for gravity in ["", "[gravity]\nacceleration = [0.5, -0.25]\n"] {
            let scene = scene(&format!("{gravity}{text}"));
            let mut simulation = Simulation::new(&scene).unwrap();
            let mut moved = [f64::INFINITY, 0.0];
            for stop in 1..=40 {
                simulation.run_until(0.1 * f64::from(stop)).unwrap();
                simulation.check_invariants(0.02).unwrap();
                let place = piston(&simulation)[0];
                moved = [moved[0].min(place), f64::max(moved[1], place)];
            }
            assert!(moved[1] - moved[0] > 0.05, "{moved:?}");
            let (view, ledger) = (simulation.view(), simulation.view().ledger());
            assert!(view.counters().collisions > 2000);
            assert_eq!(ledger.lost > 1.0, text.contains("stop_elasticity"));
            assert!((view.energy() - ledger.booked()).abs() < 1e-11 * view.energy());
            let of_piston = view.bodies().find(|body| body.body.is_piston()).unwrap();
            assert_eq!(of_piston.motion.velocity.y, 0.0);
        }
    }
}

#[test]
fn both_schedulers_find_the_same_contacts_beside_a_piston() {
    for text in [TWO_GASES.to_owned(), on_spring()] {
        let scene = scene(&text);
        let (mut cells, mut heap) = (
            Simulation::new(&scene).unwrap(),
            simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic),
        );
        for contact in 0..300 {
            assert!(cells.step(10.0, &mut ()).unwrap() && heap.step(10.0, &mut ()).unwrap());
            let [one, other] = [cells.time().to_f64(), heap.time().to_f64()];
            assert!((one - other).abs() < 1e-9, "{contact}: {one} {other}");
        }
        assert_eq!(
            cells.view().counters().collisions,
            heap.view().counters().collisions
        );
    }
}

#[test]
fn a_run_with_a_piston_is_resumed_to_the_bit() {
    for text in [TWO_GASES.to_owned(), on_spring(), pressed_on_stop()] {
        let mut simulation = Simulation::new(&scene(&text)).unwrap();
        simulation.run_until(0.5).unwrap();
        let checkpoint = simulation.end_epoch_here();
        let mut resumed: Simulation = Simulation::resume(&checkpoint).unwrap();
        simulation.run_until(1.5).unwrap();
        resumed.run_until(1.5).unwrap();
        assert_eq!(piston(&simulation), piston(&resumed));
        assert_eq!(
            simulation.view().ledger().lost,
            resumed.view().ledger().lost
        );
        assert_eq!(
            simulation.view().counters().collisions,
            resumed.view().counters().collisions
        );
    }
}

#[test]
fn pistons_that_might_meet_walls_are_refused_by_name() {
    for (text, words) in [
        ("x = 0.5\nmass = 1.0", "needs `stops`"),
        ("x = 0.5\ny = 0.5\nmass = 1.0", "`x` or `y`"),
        ("x = 0.5\nmass = 0.0\nstops = [0.1, 0.9]", "`mass`"),
        (
            "x = 0.5\nmass = 1.0\nstops = [0.6, 0.9]",
            "must begin between its stops",
        ),
        (
            "x = 0.25\nmass = 1.0\nforce = -2.0\nstops = [0.25, 0.75]",
            "at rest on one of its stops",
        ),
        (
            "x = 0.5\nmass = 1.0\nstops = [0.1, 1.0]",
            "`stops` must ascend",
        ),
        (
            "x = 0.5\nmass = 1.0\nstops = [0.1, 0.9]\nstop_elasticity = 1.5",
            "`stop_elasticity` must be from 0 to 1, but is 1.5",
        ),
        (
            "x = 0.5\nmass = 1.0\nstops = [0.1, 0.9]\nstop_elasticity = nan",
            "`stop_elasticity` must be from 0 to 1, but is NaN",
        ),
        (
            "x = 0.5\nmass = 1.0\nstops = [0.1, 0.9]\n[[wall]]\nx = 0.75",
            "may meet a wall",
        ),
        (
            "x = 0.5\nmass = 1.0\nstops = [0.1, 0.9]\n[[wall]]\nfrom = [0.7, 0.2]\nto = [0.75, 0.3]",
            "may meet a wall",
        ),
        (
            "x = 0.25\nmass = 1.0\nstops = [0.1, 0.6]\n[[piston]]\nx = 0.75\nmass = 1.0\nstops = [0.5, 0.9]",
            "another piston",
        ),
        (
            "x = 0.25\nmass = 1.0\nstops = [0.1, 0.6]\n[[piston]]\ny = 0.75\nmass = 1.0\nstops = [0.5, 0.9]",
            "along the same axis",
        ),
        (
            "x = 0.5\nmass = 1.0\nstops = [0.1, 0.9]\n[[wall]]\nx = 0.0\nmotion = { velocity = [0.1, 0.0] }",
            "wall that moves",
        ),
        (
            "x = 0.5\nmass = 1.0\nstops = [0.1, 0.9]\n[[bumper]]\nradius = 0.1\nat = [0.45, 0.9]",
            "overlaps fixed body",
        ),
        (
            "x = 0.5\nmass = 1.0\nstops = [0.1, 0.9]\n[box]\ndrag = 0.1",
            "drag",
        ),
        // Over the mass it would be 0.
        (
            "x = 0.5\nmass = 1e15\nstops = [0.1, 0.9]\nspring = 1e-312",
            "`spring` over `mass`",
        ),
        (
            "x = 0.5\nmass = 1e15\nstops = [0.1, 0.9]\nforce = 1e-312",
            "force",
        ),
    ] {
        let error = Simulation::new(&scene(&format!("[[piston]]\n{text}"))).unwrap_err();
        assert!(matches!(error, SceneError::Entry { .. }), "{error}");
        assert!(error.to_string().contains(words), "{text}: {error}");
    }
}

/// A rod that turns in place overlaps the line of a piston with its bounding circle. Its tip must
/// reach the piston, which has come to rest at a stop since the rod was predicted.
#[test]
fn a_rod_that_turns_in_place_reaches_a_piston_at_rest() {
    let rod = "[[molecule]]\nat = [0.5, 0.5]\nangular_velocity = 5.0\n\
        atoms = [{ at = [0.0, 0.05], radius = 0.01, mass = 1.0 }, { at = [0.0, -0.05], radius = 0.01, mass = 1.0 }]\n";
    let wall = "[[piston]]\nx = 0.52\nmass = 1.0\nvelocity = 0.3\nstops = [0.3, 0.55]\nstop_elasticity = 0.0";
    let disc = "[[molecule]]\nshape = \"disc\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.15, ";
    let others = format!("{disc}0.2]\n{disc}0.4]\n{disc}0.6]\n");
    let scene = scene(&format!("{others}{rod}{wall}"));
    let mut cells = simulate::<CellScheduler>(&scene, &Instructions::Widest);
    let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
    // The tip is 0.05 sin(5 t) + 0.01 from the axis, and the piston 0.05: at t = 0.1855.
    cells.run_until(0.185).unwrap();
    assert_eq!(cells.view().counters().collisions, 0);
    assert_eq!(piston(&cells), [0.55, 0.0]);
    cells.run_until(0.186).unwrap();
    heap.run_until(0.186).unwrap();
    // The stop behind the piston takes its energy, so that the tip pushes it more than once.
    assert!(cells.view().counters().collisions > 0);
    assert!(heap.view().counters().collisions > 0);
    assert_eq!(cells.view().overlaps().pairs, 0);
}
