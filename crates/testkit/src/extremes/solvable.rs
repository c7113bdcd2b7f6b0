//! Impulses and times with closed forms, and the mean free path of a Sinai billiard.

use std::f64::consts::PI;

use anyhow::Result;
use carom::{
    Detection, Molecule, Orientation, Shape,
    detection::Outcome,
    engine::{AtomSpec, MoleculeSpec},
    kinematics::RelativeMotion,
};
use glam::DVec2;

use super::{
    Effort, Engine, ExtremeCase, ExtremeFinding,
    bodies::{bumper, disc, named},
    engine::{gas, in_box},
    watch::{Watch, run_collisions, survey, velocity},
};

pub fn cases() -> Vec<ExtremeCase> {
    vec![
        ExtremeCase {
            id: "6.1",
            name: "the general impulse, in a gas of tees, locked crosses, dumbbells, discs and bumpers",
            must: "each contact multiplies the normal velocity by −e and conserves angular momentum about the contact",
            run: impulses,
        },
        ExtremeCase {
            id: "6.2",
            name: "two discs of unequal mass, head on and oblique, e = 1, 0.5, 0",
            must: "velocities and time of the closed forms",
            run: oblique,
        },
        ExtremeCase {
            id: "6.3",
            name: "a disc on the end of a dumbbell",
            must: "v′ = −1/11, V = 6/11, |Ω| = 8/11",
            run: on_the_end,
        },
        ExtremeCase {
            id: "6.4",
            name: "a turning arm that just touches: d = a + r₁ + r₂",
            must: "a negligible impulse: approach speed below 1e-7 of the tip speed",
            run: tangent,
        },
        ExtremeCase {
            id: "6.8",
            name: "Sinai billiard: one disc, one bumper",
            must: "mean free path (L² − πR²)/2R within five standard errors",
            run: sinai,
        },
    ]
}

fn impulses(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut findings = Vec::new();
    for e in [1.0, 0.9] {
        let mut scene = in_box(
            [1.0, 1.0],
            vec![
                MoleculeSpec {
                    angular_velocity: 3.0,
                    ..named("tee", 0.02, 0.5, [0.25, 0.25])
                },
                MoleculeSpec {
                    rotation: carom::engine::Rotation::Locked,
                    ..named("cross", 0.02, 0.5, [0.75, 0.25])
                },
            ],
        );
        scene.bumper = vec![bumper(0.03, [0.0, 0.0])];
        scene.gas = vec![gas("disc", 0.02, 1.0, 60), gas("dumbbell", 0.015, 0.5, 12)];
        scene.elasticity.default = e;
        let name = format!("e = {e}");
        // A gas that cools without end would finally measure only the rounding of the energy
        // ledger.
        let collisions = if e < 1.0 { 2000 } else { effort.collisions };
        findings.extend(survey(engine, &scene, collisions)?.findings(&name));
    }
    Ok(findings)
}

fn oblique(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let (mut worst, mut late) = (0.0f64, 0.0f64);
    for (mass, target) in [(1.0, 1.0), (1.0, 3.0), (7.0, 1.0), (1.0, 1e6)] {
        for e in [1.0, 0.5, 0.0] {
            // Impact parameter b = 3/5 σ and 0: the line of centres is along (4, 3)/5 and (1, 0).
            for normal in [DVec2::new(0.8, 0.6), DVec2::X] {
                let mut scene = in_box(
                    [32.0, 32.0],
                    vec![
                        disc(0.5, mass, [4.0, 16.0], [1.0, 0.0]),
                        disc(0.5, target, [8.0 + normal.x, 16.0 + normal.y], [0.0; 2]),
                    ],
                );
                scene.elasticity.default = e;
                scene.elasticity.contact_time = 0.0;
                let mut run = engine.simulate(&scene)?;
                let mut watch = Watch::default();
                run.observe_until(5.0, &mut watch)?;
                let impulse = (1.0 + e) * normal.x / (1.0 / mass + 1.0 / target);
                let after = [
                    DVec2::X - impulse / mass * normal,
                    impulse / target * normal,
                ];
                for (k, expected) in after.into_iter().enumerate() {
                    worst = worst.max((velocity(&run, k) - expected).length());
                }
                late = late.max(
                    watch
                        .times
                        .first()
                        .map_or(f64::NAN, |time| (time - 4.0).abs()),
                );
            }
        }
    }
    Ok(vec![
        ExtremeFinding::new("largest error of a velocity", worst, 1e-13),
        ExtremeFinding::new("largest error of the time", late, 1e-13),
    ])
}

fn on_the_end(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    // Unit atoms of radius 1/2 at ±1/2 along x; a unit disc approaches the right one from below.
    let atom = |x: f64| AtomSpec {
        at: [x, 0.0],
        radius: 0.5,
        mass: 1.0,
    };
    let dumbbell = MoleculeSpec {
        atoms: vec![atom(-0.5), atom(0.5)],
        at: [8.0, 8.0],
        ..MoleculeSpec::default()
    };
    let scene = in_box(
        [16.0, 16.0],
        vec![dumbbell, disc(0.25, 1.0, [8.5, 6.0], [0.0, 1.0])],
    );
    let mut run = engine.simulate(&scene)?;
    run.run_until(1.5)?;
    let spin = run
        .view()
        .bodies()
        .next()
        .map_or(f64::NAN, |body| body.motion.angular_velocity);
    let error = (velocity(&run, 1).y + 1.0 / 11.0).abs()
        + (velocity(&run, 0).y - 6.0 / 11.0).abs()
        + (spin.abs() - 8.0 / 11.0).abs();
    Ok(vec![ExtremeFinding::new(
        "error of the three velocities",
        error,
        1e-14,
    )])
}

fn tangent(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0)?;
    let disc = Molecule::disc(0.5, 1.0)?;
    let motion = RelativeMotion {
        orientation: [Orientation::from_turns(-0.2), Orientation::default()],
        angular_velocity: [1.0, 0.0],
        ..RelativeMotion::exactly(DVec2::new(2.5, 0.0), DVec2::ZERO)
    };
    let answer = engine
        .detector()
        .first_contact(dumbbell.outline(), disc.outline(), &motion, 10.0);
    let speed = match answer.outcome {
        // The approach speed of an arm at angle θ is a ω times the sine of the angle to the line of
        // contact.
        Outcome::Contact(contact) => {
            let arm = Orientation::from_turns(-0.2)
                .turned(1.0, contact.time)
                .cos_sin();
            let line = (DVec2::new(2.5, 0.0) - arm * arm.x.signum()).normalize();
            arm.perp_dot(line).abs()
        }
        _ => 0.0,
    };
    Ok(vec![ExtremeFinding::new(
        "approach speed relative to the tip speed",
        speed,
        1e-7,
    )])
}

fn sinai(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let sum: f64 = 0.3;
    let mut scene = in_box([1.0, 1.0], vec![disc(0.1, 1.0, [0.05, 0.15], [0.6, 0.8])]);
    scene.bumper = vec![bumper(0.2, [0.5, 0.5])];
    let mut run = engine.simulate(&scene)?;
    run_collisions(&mut run, effort.collisions, &mut (), |_| {})?;
    let hits = run.view().counters().collisions as f64;
    let path = run.time().to_f64() / hits;
    let predicted = (1.0 - PI * sum * sum) / (2.0 * sum);
    Ok(vec![
        ExtremeFinding::new(
            "deviation of the mean free path (standard errors)",
            (path / predicted - 1.0).abs() * hits.sqrt(),
            5.0,
        ),
        ExtremeFinding::new(
            "speed drift, relative",
            (velocity(&run, 0).length() - 1.0).abs(),
            1e-12,
        ),
        ExtremeFinding::never("overlapping pairs", run.view().overlaps().pairs),
    ])
}
