//! Empty scenes, which must run, and invalid scenes, which must be refused by name.

use anyhow::Result;
use carom::{
    RunError, Scene, SceneError,
    engine::{AtomSpec, MoleculeSpec},
};

use super::{
    Effort, Engine, ExtremeCase, ExtremeFinding,
    bodies::{bumper, disc, named},
    engine::in_box,
};

pub fn cases() -> Vec<ExtremeCase> {
    vec![
        ExtremeCase {
            id: "7.24",
            name: "one object, none, only bumpers; a run to a time that has passed",
            must: "the run returns without events",
            run: nothing_to_do,
        },
        ExtremeCase {
            id: "7.25",
            name: "NaN, infinite, negative, zero: radii, masses, places, speeds, boxes; no atoms, coincident atoms",
            must: "a typed error at construction, each time",
            run: refused,
        },
    ]
}

fn nothing_to_do(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let one = in_box([1.0, 1.0], vec![disc(0.1, 1.0, [0.5, 0.5], [0.3, 0.1])]);
    let bumpers = Scene {
        bumper: vec![bumper(0.1, [0.2, 0.2]), bumper(0.1, [0.7, 0.2])],
        ..Scene::default()
    };
    let resting = in_box(
        [1.0, 1.0],
        vec![
            named("tee", 0.01, 1.0, [0.3, 0.3]),
            named("disc", 0.1, 1.0, [0.7, 0.7]),
        ],
    );
    let (mut events, mut moved, mut wrong) = (0, 0, 0);
    for scene in [one, bumpers, resting, Scene::default()] {
        let mut run = engine.simulate(&scene)?;
        for time in [0.0, 1e3, 1e3] {
            run.run_until(time)?;
            moved += usize::from(run.time().to_f64() != time);
        }
        for time in [-1.0, 1.0, -1e300] {
            wrong += usize::from(!matches!(run.run_until(time), Err(RunError::Past { .. })));
        }
        events += run.view().counters().collisions;
        for time in [f64::NAN, f64::INFINITY] {
            wrong += usize::from(!matches!(run.run_until(time), Err(RunError::Time(_))));
        }
    }
    Ok(vec![
        ExtremeFinding::new("collisions", events as f64, 0.0),
        ExtremeFinding::never("runs that end at another time than requested", moved),
        ExtremeFinding::never("times that are past or not finite, and not refused", wrong),
    ])
}

#[allow(clippy::unnecessary_wraps, reason = "all cases have one signature")]
fn refused(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let atom = |at: [f64; 2], radius: f64, mass: f64| AtomSpec { at, radius, mass };
    let of = |atoms: Vec<AtomSpec>| {
        in_box(
            [1.0, 1.0],
            vec![MoleculeSpec {
                atoms,
                ..MoleculeSpec::default()
            }],
        )
    };
    let mut scenes = vec![
        of(Vec::new()),
        of(vec![atom([0.0; 2], 0.1, 1.0), atom([0.0; 2], 0.05, 1.0)]),
    ];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, 1e300] {
        scenes.push(of(vec![atom([0.0; 2], bad, 1.0)]));
        scenes.push(of(vec![atom([0.0; 2], 0.1, bad)]));
        scenes.push(in_box([bad, 1.0], Vec::new()));
        scenes.push(in_box([1.0, bad], Vec::new()));
        scenes.push(Scene {
            bumper: vec![bumper(bad, [0.5, 0.5])],
            ..Scene::default()
        });
        if !bad.is_finite() || bad > 1.0 {
            scenes.push(of(vec![atom([bad, 0.0], 0.1, 1.0)]));
            scenes.push(in_box(
                [1.0, 1.0],
                vec![disc(0.1, 1.0, [bad, 0.5], [0.0; 2])],
            ));
            scenes.push(in_box(
                [1.0, 1.0],
                vec![disc(0.1, 1.0, [0.5, 0.5], [0.0, bad])],
            ));
            let turning = MoleculeSpec {
                angular_velocity: bad,
                ..named("tee", 0.01, 1.0, [0.5, 0.5])
            };
            scenes.push(in_box([1.0, 1.0], vec![turning]));
        }
        if bad != 0.0 {
            let mut scene = Scene::default();
            scene.elasticity.default = bad;
            // A value above 1 is superelastic and allowed.
            if !(bad > 1.0 && bad.is_finite()) {
                scenes.push(scene);
            }
        }
    }
    let accepted = scenes.iter().filter(|scene| {
        let built: Result<_, SceneError> = engine.simulate(scene);
        built.is_ok()
    });
    Ok(vec![
        ExtremeFinding::never("invalid scenes that are accepted", accepted.count()),
        ExtremeFinding::never("too few invalid scenes", usize::from(scenes.len() < 40)),
    ])
}
