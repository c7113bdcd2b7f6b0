//! Gases: at late times, with very unequal bodies, inelastic, and superelastic.

use anyhow::{Result, bail};
use carom::{
    EpochTime, RunError, Scene,
    engine::{MoleculeSpec, View},
};

use super::{
    Effort, Engine, ExtremeCase, ExtremeFinding,
    bodies::disc,
    engine::{directions, gas, in_box},
    watch::{survey, survey_of},
};
use carom_methods::AnySimulation;

/// The cases of whole gases.
pub fn cases() -> Vec<ExtremeCase> {
    vec![
        ExtremeCase {
            id: "7.5",
            name: "a gas at time 0, 1e3, 1e6, 1e9, 1e12",
            must: "the same collisions and velocities to the bit; overlaps within the bound of time 0",
            run: ages,
        },
        ExtremeCase {
            id: "7.6",
            name: "mass ratios 1:1e8 and 1e8:1, radius ratio 1:1000",
            must: "energy conserved to 1e-12; no overlap",
            run: ratios,
        },
        ExtremeCase {
            id: "7.6 b",
            name: "light and heavy discs, mass ratio 100, all energy in the light ones at the start",
            must: "equipartition: mean energies equal within five standard errors",
            run: equipartition,
        },
        ExtremeCase {
            id: "7.17",
            name: "inelastic: three discs in line at e = 0.05, gases at e = 0.5 and e = 0",
            must: "collapse guarded and counted, energy recorded in the ledger, the end reached",
            run: inelastic,
        },
        ExtremeCase {
            id: "7.18",
            name: "a gas at e = 1.01, on to the blow-up",
            must: "a named error, finite energy and no overlap",
            run: superelastic,
        },
    ]
}

/// A gas at a late time: the empty box runs until `age` (time), then `count` discs are added.
///
/// # Errors
/// The scene cannot be built or run.
pub fn aged(engine: Engine, age: f64, count: usize) -> Result<AnySimulation> {
    let mut run = engine.simulate(&in_box([1.0, 1.0], Vec::new()))?;
    run.run_until(age)?;
    for molecule in scattered(count) {
        run.add(&molecule)?;
    }
    Ok(run)
}

/// Discs on a square grid, with energies of about 1 in all directions.
fn scattered(count: usize) -> Vec<MoleculeSpec> {
    let side = (count as f64).sqrt().ceil() as usize;
    let step = 1.0 / side as f64;
    let at = |k: usize| {
        [
            ((k % side) as f64 + 0.5) * step,
            ((k / side) as f64 + 0.5) * step,
        ]
    };
    (0..count)
        .zip(directions())
        .map(|(k, direction)| disc(0.35 * step, 1.0, at(k), (1.414 * direction).to_array()))
        .collect()
}

/// Light discs and one disc of another mass and radius.
pub fn mixture(light: usize, radius: f64, mass: f64, big_radius: f64, big_mass: f64) -> Scene {
    let speed = (2.0 / big_mass).sqrt();
    let mut scene = in_box(
        [1.0, 1.0],
        vec![disc(
            big_radius,
            big_mass,
            [0.5, 0.5],
            [0.6 * speed, 0.8 * speed],
        )],
    );
    scene.gas = vec![gas("disc", radius, mass, light)];
    scene
}

fn velocities(view: &View<'_>) -> Vec<[f64; 2]> {
    view.bodies()
        .map(|body| body.motion.velocity.to_array())
        .collect()
}

fn ages(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut findings = Vec::new();
    let mut young = None;
    for age in [0.0, 1e3, 1e6, 1e9, 1e12] {
        let mut run = aged(engine, age, 36)?;
        let begun = run.time();
        // After some hundred collisions each, a difference in the last bit has grown to the first.
        let duration = 16.0 * (effort.collisions as f64 / 2e4).clamp(0.25, 4.0);
        run.observe_until_epoch_time(later(begun, duration), &mut ())?;
        let view = run.view();
        findings.push(ExtremeFinding::never(
            format!("overlapping pairs at {age:e}"),
            view.overlaps().pairs,
        ));
        let state = (view.counters().collisions, velocities(&view));
        let first = young.get_or_insert_with(|| state.clone());
        let different = usize::from(*first != state);
        findings.push(ExtremeFinding::never(
            format!("trajectories that differ from those at time 0, at {age:e}"),
            different,
        ));
    }
    Ok(findings)
}

/// The time `instant` + `duration` (time), without rounding.
pub fn later(instant: EpochTime, duration: f64) -> EpochTime {
    instant.new_epoch(0.0).after(duration)
}

fn ratios(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let scenes = [
        ("a heavy disc, 1e8", mixture(50, 0.03, 1.0, 0.1, 1e8)),
        ("a light disc, 1e-8", mixture(50, 0.03, 1.0, 0.1, 1e-8)),
        ("a large disc, 1000 times", mixture(50, 1e-4, 1.0, 0.1, 1.0)),
        (
            "a large and heavy disc, 1000 times and 1e8",
            mixture(50, 1e-4, 1.0, 0.1, 1e8),
        ),
    ];
    let mut findings = Vec::new();
    for (index, (name, scene)) in scenes.into_iter().enumerate() {
        // Such small discs collide once in some hundred box lengths.
        let collisions = if index < 2 {
            effort.collisions
        } else {
            effort.collisions / 10
        };
        findings.extend(survey(engine, &scene, collisions)?.findings(name));
    }
    Ok(findings)
}

fn equipartition(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut scene = in_box([1.0, 1.0], Vec::new());
    scene.gas = vec![gas("disc", 0.02, 1.0, 100), gas("disc", 0.03, 100.0, 40)];
    scene.gas[1].energy = 0.0;
    let mut run = engine.simulate(&scene)?;
    // The heavy discs relax within about M/2m collisions each.
    survey_of(&mut run, 20_000)?;
    let mut shares = Vec::new();
    for _ in 0..20 {
        let mut sums = [0.0; 2];
        for _ in 0..20 {
            let until = run.time().after(0.1);
            run.run_until(until.to_f64())?;
            for body in run.view().bodies() {
                let heavy = body.body.molecule().mass() > 1.0;
                sums[usize::from(heavy)] += body.energy() / if heavy { 40.0 } else { 100.0 };
            }
        }
        shares.push(sums[1] / sums[0] - 1.0);
        if run.view().counters().collisions > 20_000 + 10 * effort.collisions.max(20_000) {
            break;
        }
    }
    let n = shares.len() as f64;
    let mean = shares.iter().sum::<f64>() / n;
    let variance = shares
        .iter()
        .map(|share| (share - mean).powi(2))
        .sum::<f64>()
        / (n - 1.0);
    Ok(vec![ExtremeFinding::new(
        "mean energy of heavy discs relative to light ones, minus 1 (standard errors)",
        mean.abs() / (variance / n).sqrt(),
        5.0,
    )])
}

/// Largest number of contacts of a cooling gas. More: after a hundred contacts of each body at e =
/// 0.5 the remaining motion is collective, and each further such number of contacts takes as long
/// as all before.
const CONTACTS_WHILE_COOLING: u64 = 20_000;

fn inelastic(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut row = in_box(
        [1.0, 1.0],
        vec![
            disc(0.05, 1.0, [0.25, 0.5], [1.0, 0.0]),
            disc(0.05, 1.0, [0.5, 0.5], [0.1, 0.0]),
            disc(0.05, 1.0, [0.75, 0.5], [-1.0, 0.0]),
        ],
    );
    row.elasticity.default = 0.05;
    let mut findings = Vec::new();
    let mut run = engine.simulate(&row)?;
    run.run_until(100.0)?;
    findings.push(ExtremeFinding::never(
        "row: overlapping pairs",
        run.view().overlaps().pairs,
    ));
    findings.push(ExtremeFinding::new(
        "row: collisions",
        run.view().counters().collisions as f64,
        1e5,
    ));
    for e in [0.5, 0.0] {
        for guarded in [true, false] {
            findings.extend(cooling(engine, effort, e, guarded)?);
        }
    }
    Ok(findings)
}

/// A gas that cools at elasticity `e`, with the guard against inelastic collapse or without it.
fn cooling(engine: Engine, effort: Effort, e: f64, guarded: bool) -> Result<Vec<ExtremeFinding>> {
    let mut scene = in_box([1.0, 1.0], Vec::new());
    scene.gas = vec![gas("disc", 0.02, 1.0, 200), gas("dumbbell", 0.015, 1.0, 20)];
    scene.elasticity.default = e;
    if !guarded {
        scene.elasticity.contact_time = 0.0;
    }
    let name = format!("gas at e = {e}{}", if guarded { "" } else { ", no guard" });
    let mut run = engine.simulate(&scene)?;
    let ended = survey_of(&mut run, effort.collisions.min(CONTACTS_WHILE_COOLING));
    let view = run.view();
    let drift = (view.energy() - view.ledger().booked()).abs() / view.ledger().initial;
    let mut findings = vec![
        ExtremeFinding::never(format!("{name}: overlapping pairs"), view.overlaps().pairs),
        ExtremeFinding::new(
            format!("{name}: energy minus ledger, relative"),
            drift,
            1e-12,
        ),
    ];
    let ended_by_name = match ended {
        Ok(survey) => {
            findings.push(ExtremeFinding::never(
                format!("{name}: steps back in time"),
                survey.watch.backwards,
            ));
            guarded || survey.collisions > 0
        }
        Err(error) => !guarded && error.downcast_ref::<RunError>().is_some(),
    };
    findings.push(ExtremeFinding::never(
        format!("{name}: unexpected ends"),
        usize::from(!ended_by_name),
    ));
    if guarded && e == 0.0 {
        let spared = view.counters().guarded_collisions;
        findings.push(ExtremeFinding::never(
            format!("{name}: guard never active"),
            usize::from(spared == 0),
        ));
    }
    Ok(findings)
}

fn superelastic(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut scene = in_box([1.0, 1.0], Vec::new());
    scene.gas = vec![gas("disc", 0.05, 1.0, 12), gas("dumbbell", 0.03, 0.5, 4)];
    scene.elasticity.default = 1.01;
    let mut run = engine.simulate(&scene)?;
    let ended = run.run_until(1e6);
    match &ended {
        Err(RunError::BlowUp { .. } | RunError::TimeStandsStill { .. }) => {}
        Ok(()) => bail!("the run reached its end at e = 1.01"),
        Err(other) => bail!("{other}"),
    }
    let view = run.view();
    Ok(vec![
        ExtremeFinding::never("overlapping pairs at the end", view.overlaps().pairs),
        ExtremeFinding::new(
            "energy relative to the ledger, minus 1",
            (view.energy() / view.ledger().booked() - 1.0).abs(),
            1e-9,
        ),
    ])
}
