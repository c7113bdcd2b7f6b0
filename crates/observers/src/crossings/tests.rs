//! Tests of the crossings: known times, the net count of the displacements, kinetic theory.

use super::*;
use carom_engine::{Scene, Simulation};

/// Observes a scene in samples and returns the crossings.
fn observed(text: &str, points: [[f64; 2]; 2], until: f64) -> (Crossings, Vec<SegmentCrossing>) {
    let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    let mut crossings = Crossings::new(Group::All, points).unwrap().logged();
    crossings.start(&simulation.view());
    for sample in 1..=50 {
        let time = until * f64::from(sample) / 50.0;
        simulation.observe_until(time, &mut crossings).unwrap();
        crossings.sample(&simulation.view());
    }
    let log = crossings.take();
    (crossings, log)
}

const WALLS: &str = "[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n";

/// A disc of radius 0.1 moves from 0.1 to 0.9 and back with speed 2.
#[test]
fn a_disc_between_two_walls_crosses_at_the_known_times() {
    let disc = "[[molecule]]\nshape = \"disc\"\natom_radius = 0.1\natom_mass = 3.0\nat = [0.1, 0.3]\n\
                velocity = [2.0, 0.0]\n";
    let (crossings, log) = observed(
        &format!("[[wall]]\nx = 0.0\n{disc}"),
        [[0.3, 0.2], [0.3, 0.6]],
        1.6,
    );
    // To the right at 0.1 and 0.9, to the left at 0.7 and 1.5.
    let times: Vec<f64> = log.iter().map(|crossing| crossing.time).collect();
    let expected = [0.1, 0.7, 0.9, 1.5];
    assert!(
        times
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-15)
            && log.len() == 4
    );
    assert_eq!(crossings.counts(), [2, 2]);
    assert!(
        log.iter()
            .all(|crossing| (crossing.place - 0.1).abs() < 1e-15)
    );
    let [_, _, net, energy, first] = crossings.sums();
    assert_eq!((net[0], energy[0]), (0.0, 0.0));
    assert!(first[0] == 1.0 && (first[1] - 0.1).abs() < 1e-15);
    // Of the four crossings one is the first.
    assert_eq!(crossings.first_passages(), 1);
    // A segment that ends below the path is not crossed.
    let (crossings, _) = observed(
        &format!("[[wall]]\nx = 0.0\n{disc}"),
        [[0.3, 0.0], [0.3, 0.29]],
        1.6,
    );
    assert_eq!(crossings.counts(), [0, 0]);
    assert_eq!(crossings.sums()[4], [0.0, 1.6]);
    assert_eq!(crossings.first_passages(), 0);
}

/// A ball thrown up with speed 1 under the gravity 2 rises by 1/4, and is 3/16 above its start
/// after 1/4 and 3/4.
#[test]
fn a_ball_that_turns_back_crosses_twice() {
    let ball = "[gravity]\nacceleration = [0.0, -2.0]\n[[molecule]]\nshape = \"disc\"\natom_radius = 0.125\n\
                atom_mass = 1.0\nat = [0.5, 0.25]\nvelocity = [0.25, 1.0]\n[[wall]]\ny = 0.125\n";
    let scene = Scene::from_toml(ball).unwrap();
    for samples in [1, 7] {
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut crossings = Crossings::new(Group::All, [[0.0, 0.4375], [1.0, 0.4375]])
            .unwrap()
            .logged();
        crossings.start(&simulation.view());
        for sample in 1..=samples {
            let time = 0.9 * f64::from(sample) / f64::from(samples);
            simulation.observe_until(time, &mut crossings).unwrap();
            crossings.sample(&simulation.view());
        }
        let log = crossings.take();
        assert_eq!(crossings.counts(), [1, 1]);
        for (crossing, time, speed) in [(log[0], 0.25, 0.5), (log[1], 0.75, -0.5)] {
            assert!((crossing.time - time).abs() < 1e-14, "{crossing:?}");
            assert!((crossing.place - (0.5 + 0.25 * time)).abs() < 1e-14);
            assert!(
                (crossing.across - speed).abs() < 1e-14 && (crossing.along - 0.25).abs() < 1e-15
            );
        }
    }
}

/// With drag the path is the same, only later: x = 1/4 + (1 − e^(−t)).
#[test]
fn drag_delays_a_crossing() {
    let disc = "[box]\ndrag = 1.0\n[[molecule]]\nshape = \"disc\"\natom_radius = 0.1\natom_mass = 1.0\n\
                at = [0.25, 0.5]\nvelocity = [1.0, 0.0]\n";
    let (_, log) = observed(disc, [[0.75, 0.0], [0.75, 1.0]], 2.0);
    assert!((log[0].time - 2.0_f64.ln()).abs() < 1e-14 && (log[0].across + 0.5).abs() < 1e-14);
}

/// Through a line across the periodic box goes what the displacements say.
#[test]
fn the_net_count_is_that_of_the_boxes_that_the_bodies_have_changed() {
    let text = "[box]\nsides = [1.0, 1.5]\nseed = 5\n[[gas]]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 60";
    let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    let mut crossings = Crossings::new(Group::All, [[0.4, 1.5], [0.4, 0.0]]).unwrap();
    crossings.start(&simulation.view());
    let boxes = |simulation: &Simulation| -> f64 {
        let view = simulation.view();
        let bodies = view.bodies();
        bodies
            .map(|body| (body.unwrapped(&view.bounds()).x - 0.4).floor())
            .sum()
    };
    let before = boxes(&simulation);
    for sample in 1..=40 {
        simulation
            .observe_until(0.25 * f64::from(sample), &mut crossings)
            .unwrap();
        crossings.sample(&simulation.view());
    }
    let [left, right] = crossings.counts();
    assert!(left > 100 && right > 100);
    assert_eq!(left as f64 - right as f64, boxes(&simulation) - before);
}

/// n √(kT/2πm) for each unit of length, with velocities relative to the centre of mass.
#[test]
fn a_gas_at_equilibrium_crosses_at_the_rate_of_kinetic_theory() {
    let count = 200.0;
    let text = format!(
        "[box]\nseed = 2\n[[gas]]\nradius = 0.02\nmass = 1.0\ntemperature = 1.0\nvelocities = \"maxwell\"\n\
         count = {count}"
    );
    let (crossings, _) = observed(&text, [[0.2, 0.3], [0.7, 0.6]], 100.0);
    let speed = ((1.0 - 1.0 / count) / std::f64::consts::TAU).sqrt();
    let expected = count * speed * crossings.length() * 100.0;
    for found in crossings.counts() {
        let deviation = (found as f64 - expected) / expected.sqrt();
        assert!(deviation.abs() < 4.0, "{found} {expected}");
    }
    assert_eq!(crossings.left_out(), 0);
}

#[test]
fn edits_lose_no_crossing() {
    let text = format!("{WALLS}[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 20");
    let mut simulation = Simulation::new(&Scene::from_toml(&text).unwrap()).unwrap();
    let mut plain = Crossings::new(Group::All, [[0.5, 0.0], [0.5, 1.0]]).unwrap();
    let mut edited = plain.clone();
    plain.start(&simulation.view());
    edited.start(&simulation.view());
    for sample in 1..=20 {
        simulation
            .observe_until(0.1 * f64::from(sample), &mut (&mut plain, &mut edited))
            .unwrap();
        edited.pause(&simulation.view());
        edited.start(&simulation.view());
        plain.sample(&simulation.view());
        edited.sample(&simulation.view());
    }
    assert_eq!(plain.counts(), edited.counts());
}

/// No disc reaches the segment behind the wall. One is removed at t = 2 and waits no longer.
#[test]
fn what_is_removed_waits_until_then() {
    let text = format!("{WALLS}[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 20");
    let mut simulation = Simulation::new(&Scene::from_toml(&text).unwrap()).unwrap();
    let mut crossings = Crossings::new(Group::All, [[0.01, 0.0], [0.01, 1.0]]).unwrap();
    crossings.start(&simulation.view());
    simulation.observe_until(2.0, &mut crossings).unwrap();
    crossings.sample(&simulation.view());
    crossings.pause(&simulation.view());
    let is_free = |body: &BodyView<'_>| body.body.is_free();
    let free = simulation.view().bodies().find(is_free).unwrap().body.key();
    simulation.remove(free).unwrap();
    crossings.start(&simulation.view());
    simulation.observe_until(3.0, &mut crossings).unwrap();
    crossings.sample(&simulation.view());
    assert_eq!(crossings.series()[1].waiting, 19);
    let [passages, waited] = crossings.sums()[4];
    assert!(
        passages == 0.0 && (waited - (19.0 * 3.0 + 2.0)).abs() < 1e-12,
        "{waited}"
    );
}

/// Far along a diagonal, one flight passes many images: one in each box.
#[test]
fn a_long_flight_crosses_one_image_in_each_box() {
    let disc = "[[molecule]]\nshape = \"disc\"\natom_radius = 0.05\natom_mass = 1.0\nat = [0.25, 0.5]\n\
                velocity = [1000.0, 437.3]\n";
    let mut simulation = Simulation::new(&Scene::from_toml(disc).unwrap()).unwrap();
    let mut crossings = Crossings::new(Group::All, [[0.5, 0.0], [0.5, 1.0]]).unwrap();
    crossings.start(&simulation.view());
    simulation.observe_until(2.0, &mut crossings).unwrap();
    crossings.sample(&simulation.view());
    assert_eq!((crossings.counts(), crossings.left_out()), ([0, 2000], 0));
}

#[test]
fn a_segment_needs_two_points() {
    assert!(Crossings::new(Group::All, [[0.5, 0.1], [0.5, 0.1]]).is_err());
    assert!(Crossings::new(Group::All, [[-1e308, 0.0], [1e308, 0.0]]).is_err());
}
