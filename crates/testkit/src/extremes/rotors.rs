//! Rotating molecules: slow, very fast, equal and opposite spins, and narrow misses.

use std::f64::consts::{PI, TAU};

use anyhow::Result;
use carom::{
    Atom, Detection, Molecule, Orientation, Scene, Shape,
    detection::{Outcome, Touch},
    engine::MoleculeSpec,
    kinematics::RelativeMotion,
};
use glam::DVec2;

use super::{
    Effort, Engine, ExtremeCase, ExtremeFinding,
    bodies::named,
    engine::{gas, in_box},
    watch::{Watch, survey},
};

pub fn cases() -> Vec<ExtremeCase> {
    vec![
        ExtremeCase {
            id: "7.7",
            name: "tees with ω = 0, 1e-12, 1e6, and ω_a = ±ω_b, in a gas",
            must: "no missed hit: no overlap at any sample",
            run: spins,
        },
        ExtremeCase {
            id: "7.8",
            name: "two equal dumbbells that turn alike and do not move",
            must: "out of reach: no contact in 1e4 turns; in reach: the first contact at the exact time",
            run: alike,
        },
        ExtremeCase {
            id: "7.9",
            name: "a turning dumbbell sweeps a disc, depth 1e-3 to 1e-12 of its reach",
            must: "hit found at the closed-form time; no hit where it is out of reach by the same distance",
            run: sweep,
        },
        ExtremeCase {
            id: "7.10",
            name: "two shallow dips in one half turn: a rod with one end shorter by a hair",
            must: "the first of the two is reported",
            run: two_dips,
        },
        ExtremeCase {
            id: "7.11",
            name: "a propeller, tip speed 1e3 times that of its centre, through a dense gas",
            must: "no overlap, energy conserved",
            run: propeller,
        },
    ]
}

fn spins(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let tee = |at, spin| MoleculeSpec {
        angular_velocity: spin,
        ..named("tee", 0.02, 1.0, at)
    };
    let mut findings = Vec::new();
    for (name, spins) in [
        ("ω = 0, 0", [0.0, 0.0]),
        ("ω = 1e-12, 0", [1e-12, 0.0]),
        ("ω = 1e6, 0", [1e6, 0.0]),
        ("ω = 7, 7", [7.0, 7.0]),
        ("ω = 7, −7", [7.0, -7.0]),
    ] {
        let mut scene = in_box(
            [1.0, 1.0],
            vec![tee([0.3, 0.5], spins[0]), tee([0.6, 0.5], spins[1])],
        );
        scene.gas = vec![gas("disc", 0.02, 1.0, 100)];
        findings.extend(survey(engine, &scene, effort.collisions / 5)?.findings(name));
    }
    Ok(findings)
}

/// Angle between arm and disc at contact, in a form that keeps the digits of a graze (6.4).
pub fn touching_angle(arm: f64, distance: f64, contact_distance: f64) -> f64 {
    let depth = arm + contact_distance - distance;
    2.0 * (depth * (2.0 * contact_distance - depth) / (4.0 * arm * distance))
        .sqrt()
        .asin()
}

fn alike(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let pair = |distance: f64| -> Scene {
        let dumbbell = |x: f64| MoleculeSpec {
            angular_velocity: 2.0,
            orientation_turns: Some(-0.125),
            ..named("dumbbell", 1.0, 1.0, [x, 5.0])
        };
        in_box([20.0, 10.0], vec![dumbbell(5.0), dumbbell(5.0 + distance)])
    };
    let mut out_of_reach = engine.simulate(&pair(4.0 + 1e-9))?;
    out_of_reach.run_until(1e4 * PI)?;
    let mut worst = 0.0f64;
    for distance in [3.0, 3.5, 4.0 - 1e-3, 4.0 - 1e-6] {
        let mut run = engine.simulate(&pair(distance))?;
        let mut watch = Watch::default();
        run.step(10.0, &mut watch)?;
        let psi = touching_angle(2.0, distance, 2.0);
        let time = watch.times.first().copied().unwrap_or(f64::NAN);
        // A gap error of some roundings of the box shifts the angle by that error divided by the
        // slope 2 sin ψ of the gap.
        let slack = 64.0 * 24.0 * f64::EPSILON / psi.sin();
        worst = worst.max((time - (0.25 * PI - psi) / 2.0).abs() / slack);
    }
    Ok(vec![
        ExtremeFinding::new(
            "contacts out of reach",
            out_of_reach.view().counters().collisions as f64,
            0.0,
        ),
        ExtremeFinding::new(
            "error of the first contact, relative to the rounding bound",
            worst,
            1.0,
        ),
    ])
}

/// A body that rotates in place, and a disc at rest.
fn turning(distance: f64, start: f64, spin: f64) -> RelativeMotion {
    RelativeMotion {
        orientation: [Orientation::from_turns(start), Orientation::default()],
        angular_velocity: [spin, 0.0],
        ..RelativeMotion::exactly(DVec2::new(distance, 0.0), DVec2::ZERO)
    }
}

fn sweep(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0)?;
    let disc = Molecule::disc(0.5, 1.0)?;
    let detector = engine.detector();
    let (mut missed, mut invented, mut worst) = (0, 0, 0.0f64);
    for exponent in 6..=24 {
        let depth = 10f64.powf(-0.5 * f64::from(exponent));
        for start in [-0.3, -0.26, -0.4999, -0.01] {
            for spin in [1.0, 1e6, 1e-6] {
                let ask = |distance: f64| {
                    let motion = turning(distance, start, spin);
                    detector
                        .first_contact(dumbbell.outline(), disc.outline(), &motion, 10.0 / spin)
                        .outcome
                };
                let distance = 2.5 * (1.0 - depth);
                let psi = touching_angle(1.0, distance, 1.5);
                // Either end may be first; the end at −x is half a turn behind.
                let to_go =
                    [0.5, 0.0].map(|behind: f64| (-start - behind).rem_euclid(1.0) * TAU - psi);
                // An arm that overlaps at the start is outside this test.
                if to_go[0].min(to_go[1]) <= 0.0 {
                    continue;
                }
                let expected = to_go[0].min(to_go[1]);
                match ask(distance) {
                    Outcome::Contact(contact) => {
                        let slack = 32.0 * f64::EPSILON * 4.0 / psi.sin() + 8.0 * f64::EPSILON;
                        worst = worst.max((contact.time * spin - expected).abs() / slack);
                    }
                    _ => missed += 1,
                }
                invented += usize::from(matches!(ask(2.5 * (1.0 + depth)), Outcome::Contact(_)));
            }
        }
    }
    Ok(vec![
        ExtremeFinding::never("hits missed", missed),
        ExtremeFinding::never("hits invented", invented),
        ExtremeFinding::new(
            "error of the time, relative to the rounding bound",
            worst,
            1.0,
        ),
    ])
}

fn two_dips(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let disc = Molecule::disc(0.5, 1.0)?;
    let detector = engine.detector();
    let mut wrong = 0;
    for depth in [1e-4, 1e-6, 1e-8, 1e-10] {
        for shorter in [0.0, 0.5] {
            // Equal masses at 1 − s and −1; the rod turns about their midpoint.
            let ends =
                [1.0 - shorter * depth, -1.0].map(|x| Atom::new(DVec2::new(x, 0.0), 0.25, 1.0));
            let [first, second] = ends;
            let rod = Molecule::new([first?, second?])?;
            let reach = rod.bounding_radius() + 0.5;
            // At the start the end at −1 points to −x, or the other end does: each is first in one
            // case.
            for (start, expected) in [(-0.25, 0), (0.25, 1)] {
                let motion = turning(reach - 2.0 * depth, start, 1e4);
                let answer = detector.first_contact(rod.outline(), disc.outline(), &motion, 1.0);
                let first = match answer.outcome {
                    Outcome::Contact(contact) => contact.touch == Touch::Atoms(expected, 0),
                    _ => false,
                };
                wrong += usize::from(!first);
            }
        }
    }
    Ok(vec![ExtremeFinding::never(
        "reports of another than the first dip",
        wrong,
    )])
}

fn propeller(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let rod = MoleculeSpec {
        angular_velocity: 1e4,
        velocity: [1.0, 0.3],
        ..named("rod:6", 0.02, 100.0, [0.5, 0.5])
    };
    let mut scene = in_box([1.0, 1.0], vec![rod]);
    scene.gas = vec![gas("disc", 0.02, 1.0, 330)];
    let survey = survey(engine, &scene, effort.collisions)?;
    Ok(survey.findings(""))
}
