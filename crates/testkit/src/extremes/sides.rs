//! Bodies with sides: squares and capsules of extreme sizes, masses, spins and speeds.

use anyhow::{Result, ensure};
use carom::{
    Scene,
    engine::{GasSpec, MoleculeSpec},
};
use glam::DVec2;

use super::{
    Effort, Engine, ExtremeCase, ExtremeFinding,
    bodies::disc,
    engine::{gas, in_box},
    watch::{Watch, place, survey},
};

pub fn cases() -> Vec<ExtremeCase> {
    vec![
        ExtremeCase {
            id: "8.1",
            name: "a square and a capsule 1000 times as large as the others, and a capsule 1e4 times as long as wide",
            must: "energy conserved to 1e-12; no overlap",
            run: sizes,
        },
        ExtremeCase {
            id: "8.2",
            name: "a square and a capsule among discs and squares, mass ratios 1:1e8 and 1e8:1",
            must: "energy conserved to 1e-12; no overlap",
            run: masses,
        },
        ExtremeCase {
            id: "8.3",
            name: "a square and a capsule with ω = 1e-12 and 1e6 among discs and triangles",
            must: "no missed hit: no overlap at any sample",
            run: spins,
        },
        ExtremeCase {
            id: "8.4",
            name: "a square and a capsule head on to a disc, speeds 1e-12 to 1e12",
            must: "time of contact to 16 ulp, scaling by powers of two to the bit",
            run: head_on,
        },
    ]
}

/// A molecule at rest with sides, by name: its size (length) and its mass.
fn sided(shape: &str, size: f64, mass: f64, at: [f64; 2]) -> MoleculeSpec {
    MoleculeSpec {
        shape: Some(shape.to_owned()),
        size: Some(size),
        mass: Some(mass),
        at,
        ..MoleculeSpec::default()
    }
}

/// A gas of bodies with sides, with energy 1 for each.
fn gas_of(shape: &str, size: f64, count: usize) -> GasSpec {
    GasSpec {
        shape: Some(shape.to_owned()),
        size: Some(size.into()),
        mass: Some(1.0.into()),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    }
}

/// One body of energy 1 in the middle of gases.
fn among(mut body: MoleculeSpec, gases: Vec<GasSpec>) -> Scene {
    let speed = (2.0 / body.mass.unwrap_or(1.0)).sqrt();
    body.velocity = [0.6 * speed, 0.8 * speed];
    Scene {
        gas: gases,
        ..in_box([1.0, 1.0], vec![body])
    }
}

/// Shapes with the size at which they are about as large as a square of side 1.
const SHAPES: [(&str, f64); 2] = [("square", 1.0), ("capsule:2", 0.5)];

fn sizes(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    ensure!(
        engine == Engine::Default,
        "not run: small bodies make millions of turns between contacts, and the golden-section search divides each"
    );
    let middle = [0.5, 0.5];
    let mut findings = Vec::new();
    for (shape, size) in SHAPES {
        let scene = among(
            sided(shape, 0.2 * size, 1.0, middle),
            vec![gas_of(shape, 2e-4 * size, 50)],
        );
        let name = format!("a {shape} 1000 times as large");
        // Such small bodies collide once in some hundred box lengths.
        findings.extend(survey(engine, &scene, effort.collisions / 10)?.findings(&name));
    }
    let thin = among(
        sided("capsule:10000", 3e-5, 1.0, middle),
        vec![gas("disc", 0.03, 1.0, 30), gas_of("square", 0.05, 20)],
    );
    findings.extend(survey(engine, &thin, effort.collisions)?.findings("a thin capsule"));
    Ok(findings)
}

fn masses(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut findings = Vec::new();
    for (shape, size) in SHAPES {
        for mass in [1e8, 1e-8] {
            let scene = among(
                sided(shape, 0.2 * size, mass, [0.5, 0.5]),
                vec![gas("disc", 0.03, 1.0, 25), gas_of("square", 0.05, 25)],
            );
            let name = format!("a {shape} of mass {mass:e}");
            // A heavy body hardly turns, so that its spin is small beside the roundings of its
            // motion.
            let found = survey(engine, &scene, effort.collisions)?;
            findings.extend(found.findings_to(&name, 1e-11));
        }
    }
    Ok(findings)
}

fn spins(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut findings = Vec::new();
    for (shape, size) in SHAPES {
        for spin in [1e-12, 1e6] {
            let body = MoleculeSpec {
                angular_velocity: spin,
                ..sided(shape, 0.06 * size, 1.0, [0.5, 0.5])
            };
            let scene = Scene {
                gas: vec![gas("disc", 0.02, 1.0, 50), gas_of("triangle", 0.04, 50)],
                ..in_box([1.0, 1.0], vec![body])
            };
            let name = format!("a {shape} with ω = {spin:e}");
            findings.extend(survey(engine, &scene, effort.collisions / 5)?.findings(&name));
        }
    }
    Ok(findings)
}

fn head_on(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let run = |shape: &str, size: f64, speed: f64| -> Result<(f64, DVec2)> {
        let body = MoleculeSpec {
            velocity: [speed, 0.0],
            ..sided(shape, 0.25 * size, 1.0, [0.25, 0.5])
        };
        let other = disc(0.1, 1.0, [0.75, 0.5], [-speed, 0.0]);
        let mut run = engine.simulate(&in_box([1.0, 1.0], vec![body, other]))?;
        let mut watch = Watch::default();
        run.observe_until(0.25 / speed, &mut watch)?;
        let time = watch.times.first().copied().unwrap_or(f64::NAN);
        Ok((time * speed, place(&run, 0)))
    };
    let (mut worst, mut differ) = (0.0f64, 0);
    // From the centre to the side of the square, whose corners have a radius of 10⁻⁶ sizes, and to
    // the tip of the capsule.
    for ((shape, size), reach) in SHAPES.into_iter().zip([0.125 + 0.25e-6, 0.125 + 0.0625]) {
        // The gap in floating point; each body covers half of it.
        let expected = 0.5 * (0.5 - (reach + 0.1));
        for speed in [1e-12, 1.0, 1e12] {
            worst = worst.max((run(shape, size, speed)?.0 / expected - 1.0).abs());
        }
        let base = run(shape, size, 1.0)?;
        for exponent in [-40, 40] {
            differ += usize::from(run(shape, size, 2f64.powi(exponent))? != base);
        }
    }
    Ok(vec![
        ExtremeFinding::new(
            "time of contact, relative error in ulp",
            worst / f64::EPSILON,
            16.0,
        ),
        ExtremeFinding::never("powers of two at which the path differs", differ),
    ])
}
