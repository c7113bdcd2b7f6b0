//! Shear by moving images: free flight through the seam, the same gas in a box twice as high, all
//! pairs in all images, energy, reversal and resuming.

use carom_detection::Exact;
use carom_engine::{
    CellScheduler, CellsPerSide, DrawKey, HeapScheduler, Observer, Scene, Simulation,
    ThermostatRule,
};
use carom_observers::PressureTensor;
use carom_response::Impact;
use glam::DVec2;
use proptest::prelude::*;

use crate::{
    own_scheduler::AllPairs,
    support::{frozen, property::cases, simulate},
};

/// Gases of discs, of discs of two sizes, of molecules, and of rough and inelastic discs.
const GASES: [&str; 5] = [
    "[[gas]]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 100",
    "[[gas]]\nradius = 0.012\nmass = 1.0\nenergy = 1.0\ncount = 60\n\
     [[gas]]\nradius = 0.06\nmass = 7.0\nenergy = 1.0\ncount = 10",
    "[[gas]]\nshape = \"dumbbell\"\natom_radius = 0.02\natom_mass = 1.0\nenergy = 1.0\ncount = 50",
    "[[gas]]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 60\n\
     [elasticity]\ndefault = 0.9\ntangential = 0.5\nfriction = 0.4",
    "[[gas]]\nshape = \"square\"\nsize = 0.06\nmass = 1.0\nenergy = 1.0\ncount = 40\n\
     [elasticity]\ndefault = 0.95",
];

fn sheared(rate: f64, sides: [f64; 2], gas: &str) -> Scene {
    let [x, y] = sides;
    let text = format!("[box]\nsides = [{x:?}, {y:?}]\nseed = 5\nshear_rate = {rate:?}\n{gas}");
    Scene::from_toml(&text).unwrap()
}

#[test]
fn a_disc_flies_on_through_the_seam() {
    let text = "[box]\nsides = [2.0, 1.0]\nshear_rate = 0.5\n\
        [[molecule]]\nshape = \"disc\"\natom_radius = 0.01\natom_mass = 2.0\nat = [0.25, 0.5]\n\
        velocity = [0.375, 1.0]";
    let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    for step in 0..400 {
        let time = 0.1375 * f64::from(step);
        simulation.run_until(time).unwrap();
        let view = simulation.view();
        let body = view.bodies().next().unwrap();
        // In the middle of the box there is no flow. The k-th passage makes it slower by γ Ly.
        let rows = (0.5 + time).floor();
        let velocity = DVec2::new(0.375 - 0.5 * rows, 1.0);
        assert!((body.motion.velocity - velocity).length() < 1e-13, "{time}");
        let path = DVec2::new(0.25 + 0.375 * time, 0.5 + time);
        let off = body.unwrapped(&view.bounds()) - path;
        assert!(off.length() < 1e-12 * (1.0 + time * time), "{time}: {off}");
        assert!(view.bounds().contains(body.motion.position));
        assert!((view.ledger().booked() / view.energy() - 1.0).abs() < 1e-13);
    }
}

/// The seams of a box twice as high lie elsewhere.
#[test]
fn a_gas_and_its_copy_in_a_box_twice_as_high_are_the_same() {
    for (gas, rate) in GASES[..3].iter().zip([0.7, -1.1, 2.3]) {
        let still = Simulation::new(&sheared(0.0, [1.0, 1.25], gas)).unwrap();
        let single = frozen(&still.view());
        let copy = single.molecule.iter().cloned().map(|mut molecule| {
            molecule.at[1] += 1.25;
            molecule
        });
        let mut double = single.clone();
        double.molecule.extend(copy);
        double.bounds.sides[1] = 2.5;
        let [one, two] = [single, double].map(|mut scene| {
            scene.bounds.shear_rate = rate;
            let mut simulation = Simulation::new(&scene).unwrap();
            simulation.run_until(0.25).unwrap();
            simulation
        });
        let (one, two) = (one.view(), two.view());
        let collisions = one.counters().collisions;
        assert!(collisions > 30, "{gas}: {collisions}");
        assert_eq!(two.counters().collisions, 2 * collisions, "{gas}");
        // There is no flow in the middle of either box.
        let between = DVec2::new(-0.5 * rate * 1.25, 0.0);
        let bodies: Vec<_> = one.bodies().collect();
        for (body, other) in two.bodies().zip(bodies.iter().cycle()) {
            let apart = body.motion.position - other.motion.position - between * 0.25;
            let apart = one.bounds().nearest_image(apart).length();
            assert!(apart < 1e-8, "{gas}: {apart:e}");
        }
    }
}

/// Runs of the shipped schedulers and of all pairs from the same start.
#[test]
fn contacts_through_the_seam_are_those_of_all_pairs() {
    for (gas, rate) in GASES.into_iter().zip([0.7, -1.1, 2.3, 0.4, 0.9]) {
        let scene = sheared(rate, [1.0, 1.25], gas);
        let mut cells = Simulation::<Exact, Impact, CellScheduler>::new(&scene).unwrap();
        let mut heap: Simulation<Exact, Impact, HeapScheduler> =
            simulate(&scene, &CellsPerSide::Automatic);
        let mut all: Simulation<Exact, Impact, AllPairs> = simulate(&scene, &());
        let until = 0.15;
        cells.run_until(until).unwrap();
        heap.run_until(until).unwrap();
        all.run_until(until).unwrap();
        let sheared = [cells.view(), heap.view()].map(|view| view.ledger().sheared);
        assert!((sheared[0] - sheared[1]).abs() < 1e-6 && sheared[0] != 0.0);
        let (cells, all) = (cells.view(), all.view());
        assert_eq!(
            cells.counters().collisions,
            all.counters().collisions,
            "{gas}"
        );
        assert!(cells.counters().collisions > 20, "{gas}");
        for (one, other) in cells.bodies().zip(all.bodies()) {
            let off = (one.motion.velocity - other.motion.velocity).length();
            assert!(off < 1e-6, "{gas}: {off:e}");
        }
    }
}

#[test]
fn no_contact_of_a_sheared_gas_is_missed_and_its_energy_is_booked() {
    for (gas, rate) in GASES.into_iter().zip([3.0, -1.1, 0.3, 0.4, 0.9]) {
        for sides in [[1.0, 1.0], [1.75, 1.0], [0.8, 1.6]] {
            let mut simulation = Simulation::new(&sheared(rate, sides, gas)).unwrap();
            for step in 1..8 {
                simulation.run_until(0.31 * f64::from(step)).unwrap();
                simulation.check_invariants(0.02).unwrap();
                let view = simulation.view();
                let (booked, energy) = (view.ledger().booked(), view.energy());
                let scale = energy + view.ledger().sheared.abs();
                assert!((booked - energy).abs() < 1e-12 * scale, "{gas}");
            }
            assert!(simulation.view().ledger().sheared > 0.0);
        }
    }
}

#[test]
fn a_sheared_gas_is_resumed_to_the_bit() {
    for gas in GASES {
        let mut simulation = Simulation::new(&sheared(0.8, [1.0, 1.25], gas)).unwrap();
        simulation.run_until(0.9).unwrap();
        let state = simulation.end_epoch_here();
        let mut resumed = Simulation::resume(&state).unwrap();
        assert_eq!(simulation.view().bounds(), resumed.view().bounds());
        for simulation in [&mut simulation, &mut resumed] {
            simulation.run_until(1.4).unwrap();
        }
        let views = [simulation.view(), resumed.view()];
        assert_eq!(views[0].ledger(), views[1].ledger());
        for (a, b) in views[0].bodies().zip(views[1].bodies()) {
            assert_eq!((a.motion, a.winding), (b.motion, b.winding));
        }
    }
}

#[test]
fn a_sheared_gas_returns_when_velocities_and_shear_are_reversed() {
    for gas in &GASES[..3] {
        let mut simulation = Simulation::new(&sheared(0.9, [1.0, 1.0], gas)).unwrap();
        let places = |simulation: &Simulation| -> Vec<DVec2> {
            let view = simulation.view();
            view.bodies().map(|body| body.motion.position).collect()
        };
        let start = places(&simulation);
        simulation.run_until(0.2).unwrap();
        assert!(simulation.view().ledger().sheared.abs() > 1e-3);
        simulation.reverse();
        simulation.run_until(0.4).unwrap();
        let view = simulation.view();
        assert!(view.bounds().tilt().abs() < 1e-14);
        assert!(view.ledger().sheared.abs() < 1e-7);
        for (now, before) in places(&simulation).into_iter().zip(start) {
            assert!(view.bounds().nearest_image(now - before).length() < 1e-8);
        }
    }
}

/// Without a rate the box above stays where it is: a shift of all images, as in a skewed crystal.
#[test]
fn a_shear_that_ends_leaves_its_tilt() {
    let mut simulation = Simulation::new(&sheared(0.8, [1.0, 1.0], GASES[0])).unwrap();
    simulation.run_until(0.5).unwrap();
    simulation.set_shear_rate(0.0).unwrap();
    let (tilt, energy) = (
        simulation.view().bounds().tilt(),
        simulation.view().energy(),
    );
    assert!((tilt - 0.4).abs() < 1e-14);
    simulation.run_until(1.0).unwrap();
    simulation.check_invariants(0.02).unwrap();
    let view = simulation.view();
    assert_eq!(view.bounds().tilt(), tilt);
    assert!((view.energy() / energy - 1.0).abs() < 1e-13);
}

/// In the mean the work at the seam is −γ A p_xy with the stress of the contacts and velocities
/// anywhere in the box: of inelastic dumbbells, in a stationary state.
#[test]
fn the_work_of_the_shear_is_that_of_the_stress() {
    let gas = "[[gas]]\nshape = \"dumbbell\"\natom_radius = 0.03\natom_mass = 1.0\nenergy = 2.0\n\
        count = 60\n[elasticity]\ndefault = 0.9";
    let rate = 1.5;
    let mut simulation = Simulation::new(&sheared(rate, [1.0, 1.0], gas)).unwrap();
    simulation.run_until(10.0).unwrap();
    let mut tensor = PressureTensor::default();
    tensor.start(&simulation.view());
    let before = simulation.view().ledger();
    for step in 1..=4000 {
        let time = 10.0 + 0.02 * f64::from(step);
        simulation.observe_until(time, &mut tensor).unwrap();
        tensor.sample(&simulation.view());
    }
    let after = simulation.view().ledger();
    let [stress, sheared] = tensor.viscosity_sum();
    assert!((sheared - 80.0 * rate).abs() < 1e-9);
    // Of a box of area 1.
    let (work, by_stress) = (after.sheared - before.sheared, rate * stress);
    let energy = simulation.view().energy();
    assert!(work > 10.0 * energy, "{work} {energy}");
    assert!((work / by_stress - 1.0).abs() < 0.01, "{work} {by_stress}");
    let lost = after.lost - before.lost;
    assert!((lost / work - 1.0).abs() < 0.05, "{lost} {work}");
    let sums = tensor.sums();
    assert!(
        sums[0][0] > sums[3][0],
        "p_xx is larger than p_yy: {sums:?}"
    );
}

#[test]
fn what_stands_still_cannot_be_sheared() {
    for text in [
        "[[wall]]\nx = 0.0",
        "[[bumper]]\nradius = 0.01\nat = [0.5, 0.5]",
    ] {
        let scene = sheared(0.5, [1.0, 1.0], &format!("{}\n{text}", GASES[0]));
        let words = Simulation::new(&scene).unwrap_err().to_string();
        assert!(
            words.contains("its images above and below would move"),
            "{words}"
        );
    }
}

proptest! {
    #![proptest_config(cases(24))]
    /// Any rate, box and gas, with changes of the rate and of the temperature on the way.
    #[test]
    fn any_shear_keeps_all_invariants(
        gas in 0..GASES.len(),
        rates in prop::array::uniform3(-4.0..4.0f64),
        width in 0.8..2.5f64,
        height in 0.8..2.5f64,
        temperature in 0.1..3.0f64,
        times in prop::array::uniform3(0.01..0.4f64),
    ) {
        let tagged = GASES[gas].replace("[[gas]]", "[[gas]]\ntags = [\"gas\"]");
        let scene = sheared(rates[0], [width, height], &tagged);
        let mut simulation = Simulation::new(&scene).unwrap();
        let bodies = simulation.find_tag("gas").unwrap();
        for (action, (rate, time)) in (0..).zip(rates.into_iter().zip(times)) {
            simulation.set_shear_rate(rate).unwrap();
            simulation.run_until(simulation.time().to_f64() + time).unwrap();
            simulation.check_invariants(0.02).unwrap();
            let key = DrawKey { seed: 1, replica: 0, action };
            let rule = ThermostatRule::Rescale(temperature);
            simulation.edit(|batch| batch.thermostat(bodies, &rule, key)).unwrap();
            let now = simulation.view().temperature().unwrap();
            prop_assert!((now / temperature - 1.0).abs() < 1e-12);
            simulation.check_invariants(0.02).unwrap();
        }
    }
}
