//! Pistons on springs: they swing between contacts, and are found where they are.

use std::f64::consts::PI;

use carom_engine::{CellsPerSide, HeapScheduler, Simulation};

use crate::{
    pistons::{on_spring, piston, scene},
    support::simulate,
};

/// Without contacts: from rest at 0.5 about 0.3, for which force, gravity or the spring alone give
/// the place of balance, undisturbed or reflected by a stop at 0.2, which it meets after a third of
/// a period.
#[test]
fn a_piston_on_a_spring_swings_about_its_balance_and_is_reflected_by_stops() {
    let disc =
        "[[molecule]]\nshape = \"disc\"\natom_radius = 0.01\natom_mass = 1.0\nat = [0.9, 0.5]";
    for (balance, gravity) in [
        ("relaxed_at = 0.3", ""),
        ("relaxed_at = 0.4\nforce = -1.8", ""),
        (
            "relaxed_at = 0.4",
            "[gravity]\nacceleration = [-0.9, 0.0]\n[[wall]]\nx = 0.0\n",
        ),
        ("force = -3.6", ""),
    ] {
        for low in [0.05, 0.2] {
            let text = format!(
                "{gravity}[[piston]]\nx = 0.5\nmass = 2.0\nspring = 18.0\n{balance}\nstops = [{low}, 0.7]\n{disc}"
            );
            let mut simulation = Simulation::new(&scene(&text)).unwrap();
            // Ω = 3. Half a period, or a third of one, from the turning point to the next
            // reflection.
            let half = if low < 0.1 { PI / 3.0 } else { 2.0 * PI / 9.0 };
            for step in 1..300 {
                let time = 0.037 * f64::from(step);
                if time > 0.9 && !gravity.is_empty() {
                    // The disc has fallen on the piston.
                    break;
                }
                simulation.run_until(time).unwrap();
                let since = (time + half).rem_euclid(2.0 * half) - half;
                let place = 0.3 + 0.2 * (3.0 * since).cos();
                let found = piston(&simulation);
                assert!(
                    (found[0] - place).abs() < 1e-12,
                    "{text}\n{time}: {found:?} {place}"
                );
                let (view, ledger) = (simulation.view(), simulation.view().ledger());
                assert!((view.energy() - ledger.booked()).abs() < 1e-13);
            }
        }
    }
}

/// A ball between a wall and a piston on a spring: two bodies on a line, whose contacts an
/// independent search finds step by step.
#[test]
fn a_ball_beside_a_piston_on_a_spring_follows_the_line() {
    let text = "[[wall]]\nx = 0.0\n[[piston]]\nx = 0.5\nradius = 0.03125\nmass = 3.0\nspring = 30.0\nrelaxed_at = 0.4\n\
                velocity = 0.25\nstops = [0.2, 0.9]\n\
                [[molecule]]\nshape = \"disc\"\natom_radius = 0.0625\natom_mass = 2.0\nat = [0.25, 0.5]\nvelocity = [1.0, 0.0]";
    let scene = scene(text);
    let (mut cells, mut heap) = (
        Simulation::new(&scene).unwrap(),
        simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic),
    );
    let frequency = f64::sqrt(10.0);
    // Time of the last contact; place and velocity of the ball and of the piston then.
    let (mut start, mut ball, mut wall) = (0.0, [0.25, 1.0], [0.5, 0.25]);
    for contact in 0..40 {
        let swung = |t: f64| {
            let (sin, cos) = (frequency * t).sin_cos();
            let away = wall[0] - 0.4;
            [
                0.4 + away * cos + wall[1] / frequency * sin,
                wall[1] * cos - away * frequency * sin,
            ]
        };
        let flown = |t: f64| ball[0] + ball[1] * t;
        let gaps = |t: f64| [flown(t) - 0.0625, swung(t)[0] - flown(t) - 0.09375];
        let closes = |t: f64, side: usize| {
            let speed = [ball[1], swung(t)[1] - ball[1]][side];
            gaps(t)[side] < 0.0 && speed < 0.0
        };
        let mut step = 0;
        let (side, wait) = loop {
            let [from, to] = [step, step + 1].map(|n| 1e-4 * f64::from(n));
            if let Some(side) = (0..2).find(|&side| closes(to, side)) {
                let (mut before, mut after) = (from, to);
                for _ in 0..80 {
                    let middle = 0.5 * (before + after);
                    if gaps(middle)[side] < 0.0 {
                        after = middle;
                    } else {
                        before = middle;
                    }
                }
                break (side, after);
            }
            step += 1;
        };
        let there = [flown(wait), ball[1]];
        let reached = swung(wait);
        start += wait;
        if side == 0 {
            ball = [there[0], -ball[1]];
            wall = reached;
        } else {
            let common = (2.0 * ball[1] + 3.0 * reached[1]) / 5.0;
            ball = [there[0], 2.0 * common - ball[1]];
            wall = [reached[0], 2.0 * common - reached[1]];
        }
        assert!(cells.step(start + 1.0, &mut ()).unwrap());
        assert!(heap.step(start + 1.0, &mut ()).unwrap());
        for found in [cells.time().to_f64(), heap.time().to_f64()] {
            assert!((found - start).abs() < 1e-9, "{contact}: {found} {start}");
        }
        let found = piston(&cells);
        assert!(
            (found[0] - wall[0]).abs() < 1e-9 && (found[1] - wall[1]).abs() < 1e-8,
            "{contact}: {found:?} {wall:?}"
        );
    }
}

#[test]
fn a_run_with_a_spring_runs_back() {
    let scene = scene(&on_spring());
    let mut simulation = Simulation::new(&scene).unwrap();
    let start = piston(&simulation)[0];
    simulation.run_until(0.05).unwrap();
    simulation.reverse();
    simulation.run_until(0.1).unwrap();
    assert!((piston(&simulation)[0] - start).abs() < 1e-9);
}

#[test]
fn springs_that_push_or_are_too_stiff_are_refused() {
    for (text, words) in [
        ("spring = -1.0", "`spring` over `mass`"),
        ("spring = 1e70", "`spring` over `mass`"),
        ("spring = 1.0\nrelaxed_at = 1e70", "a number of a piston"),
        (
            "spring = 1.0\nrelaxed_at = 0.05",
            "at rest on one of its stops",
        ),
    ] {
        let text = format!("[[piston]]\nx = 0.1\nmass = 1.0\nstops = [0.1, 0.9]\n{text}");
        let error = Simulation::new(&scene(&text)).unwrap_err().to_string();
        assert!(error.contains(words), "{text}: {error}");
    }
}
