//! Many contacts at one time or in sequence: corners, chains, cradles, break shots, symmetric
//! meetings.

use anyhow::Result;
use carom::{
    RunError,
    engine::{MoleculeSpec, Rotation},
};
use glam::DVec2;

use super::{
    Effort, Engine, ExtremeCase, ExtremeFinding,
    bodies::{bumper, disc, named},
    engine::{directions, in_box},
    watch::{Watch, velocity},
};
use carom_methods::AnySimulation;

pub fn cases() -> Vec<ExtremeCase> {
    vec![
        ExtremeCase {
            id: "7.12",
            name: "a disc rattles in the concave corner of a fixed T, elastic and at e = 0.5, 0.05, 0",
            must: "a bounded number of collisions at one time, no overlap",
            run: corner,
        },
        ExtremeCase {
            id: "7.14",
            name: "a chain of 100 touching discs is hit at one end",
            must: "100 collisions at one time, only the last disc leaves",
            run: chain,
        },
        ExtremeCase {
            id: "7.15",
            name: "four discs meet in a point; a lattice with mirrored velocities",
            must: "energy and momentum conserved, the same order in each run",
            run: meetings,
        },
        ExtremeCase {
            id: "6.5 a",
            name: "a dumbbell along the line between two bumpers, e = 1",
            must: "constant period 2 gap/v, spin exactly 0",
            run: shuttle,
        },
        ExtremeCase {
            id: "6.5 b",
            name: "Newton's cradle of 6 discs, gaps 1e-3 to 1e-12 σ and 0",
            must: "5 collisions from left to right, only the last leaves, energy to the ulp",
            run: cradle,
        },
        ExtremeCase {
            id: "6.5 c",
            name: "break shot: a disc hits two touching ones symmetrically",
            must: "energy and momentum conserved, in each run the result of the sequential rule",
            run: break_shot,
        },
        ExtremeCase {
            id: "6.5 d",
            name: "three equal discs in the plane; N in a row",
            must: "at most 4 collisions; exactly the number of inversions of their velocities",
            run: few_discs,
        },
    ]
}

fn corner(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let (mut overlapping, mut unnamed, mut most) = (0, 0, 0);
    for e in [1.0, 0.5, 0.05, 0.0] {
        for direction in directions().take((effort.collisions / 500).clamp(8, 64) as usize) {
            let tee = MoleculeSpec {
                fixed: true,
                rotation: Rotation::Free,
                ..named("tee", 0.0625, 1.0, [0.5, 0.5])
            };
            // Two bumpers in front of the corner reflect it back repeatedly.
            let mut scene = in_box(
                [1.0, 1.0],
                vec![tee, disc(0.03, 1.0, [0.605, 0.47], direction.to_array())],
            );
            scene.bumper = vec![bumper(0.05, [0.7, 0.45]), bumper(0.05, [0.62, 0.36])];
            scene.elasticity.default = e;
            let mut run = engine.simulate(&scene)?;
            let mut watch = Watch::default();
            match run.observe_until(50.0, &mut watch) {
                Ok(()) => {}
                Err(error) => {
                    unnamed += usize::from(!matches!(error, RunError::Stalled { .. }) || e > 0.0);
                }
            }
            overlapping = overlapping.max(run.view().overlaps().pairs);
            most = most.max(watch.at_once);
        }
    }
    Ok(vec![
        ExtremeFinding::never("overlapping pairs", overlapping),
        ExtremeFinding::never("runs that do not reach their end", unnamed),
        ExtremeFinding::new(
            "largest number of collisions at one time",
            most as f64,
            100.0,
        ),
    ])
}

/// Discs in a row; the first approaches at speed 1.
fn row(engine: Engine, count: usize, gap: f64) -> Result<(AnySimulation, Watch)> {
    let mut list = vec![disc(0.5, 1.0, [1.0, 2.0], [1.0, 0.0])];
    list.extend((0..count).map(|i| disc(0.5, 1.0, [3.0 + i as f64 * (1.0 + gap), 2.0], [0.0; 2])));
    let mut run = engine.simulate(&in_box([count as f64 + 28.0, 4.0], list))?;
    let mut watch = Watch::default();
    run.observe_until(2.0 + count as f64 * gap, &mut watch)?;
    Ok((run, watch))
}

fn chain(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let (run, watch) = row(engine, 100, 0.0)?;
    let late = watch
        .times
        .iter()
        .map(|time| (time - 1.0).abs())
        .fold(0.0, f64::max);
    Ok(vec![
        ExtremeFinding::new(
            "number of collisions minus 100",
            (watch.times.len() as f64 - 100.0).abs(),
            0.0,
        ),
        ExtremeFinding::new("largest time after the first collision", late, 1e-13),
        ExtremeFinding::new(
            "velocity of the last disc minus 1",
            (velocity(&run, 100) - DVec2::X).length(),
            1e-13,
        ),
        ExtremeFinding::new(
            "energy drift, relative",
            (run.view().energy() / 0.5 - 1.0).abs(),
            1e-13,
        ),
    ])
}

fn cradle(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let (mut order, mut error) = (0, 0.0f64);
    for gap in [1e-3, 1e-6, 1e-9, 1e-12, 0.0] {
        let (run, watch) = row(engine, 5, gap)?;
        let expected: Vec<[u64; 2]> = (0..5).map(|k| [k, k + 1]).collect();
        let found: Vec<[u64; 2]> = watch
            .bodies
            .iter()
            .map(|[a, b]| [*a.min(b), *a.max(b)])
            .collect();
        order += usize::from(found != expected);
        for k in 0..6 {
            let requested = if k == 5 { DVec2::X } else { DVec2::ZERO };
            error = error.max((velocity(&run, k) - requested).length());
        }
        error = error.max((run.view().energy() / 0.5 - 1.0).abs());
    }
    Ok(vec![
        ExtremeFinding::never("cradles with another order of collisions", order),
        ExtremeFinding::new(
            "largest error of a velocity, or of the energy",
            error,
            2.0 * f64::EPSILON,
        ),
    ])
}

fn shuttle(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut scene = in_box(
        [16.0, 8.0],
        vec![MoleculeSpec {
            velocity: [1.0, 0.0],
            ..named("dumbbell", 0.5, 1.0, [4.0, 4.0])
        }],
    );
    scene.bumper = vec![bumper(1.0, [1.0, 4.0]), bumper(1.0, [7.0, 4.0])];
    // The free gap is 4 − 2: hits at times 1, 3, 5, …
    let hits = effort.collisions.clamp(1000, 100_000);
    let mut run = engine.simulate(&scene)?;
    let mut watch = Watch::default();
    run.observe_until(2.0 * hits as f64, &mut watch)?;
    let late = watch
        .times
        .iter()
        .enumerate()
        .map(|(k, time)| (time - (2 * k + 1) as f64).abs())
        .fold(0.0, f64::max);
    let body = run
        .view()
        .bodies()
        .next()
        .map_or(f64::NAN, |body| body.motion.angular_velocity.abs());
    Ok(vec![
        ExtremeFinding::new(
            "number of hits minus the expected one",
            (run.view().counters().collisions as f64 - hits as f64).abs(),
            0.0,
        ),
        ExtremeFinding::new("largest error of a time", late, 1e-10),
        ExtremeFinding::new("spin", body, 0.0),
        ExtremeFinding::new(
            "error of the speed",
            (velocity(&run, 0).length() - 1.0).abs(),
            0.0,
        ),
    ])
}

fn break_shot(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let run = || -> Result<[DVec2; 3]> {
        let (s, c) = (0.5, 0.75f64.sqrt());
        let scene = in_box(
            [8.0, 8.0],
            vec![
                disc(0.5, 1.0, [1.0, 4.0], [1.0, 0.0]),
                disc(0.5, 1.0, [3.0 + c, 4.0 + s], [0.0; 2]),
                disc(0.5, 1.0, [3.0 + c, 4.0 - s], [0.0; 2]),
            ],
        );
        let mut run = engine.simulate(&scene)?;
        run.run_until(2.5)?;
        Ok([0, 1, 2].map(|k| velocity(&run, k)))
    };
    let (first, again) = (run()?, run()?);
    let energy: f64 = first.iter().map(|v| v.length_squared()).sum();
    let momentum: DVec2 = first.iter().sum();
    // The sequential rule gives 0.8660 along ±30°, 0.4330 along ∓30°, and (−0.125, ∓0.2165).
    let speeds = [1, 2].map(|k: usize| first[k].length());
    let expected = [0.75f64.sqrt(), 0.75f64.sqrt() / 2.0];
    let sequential = (speeds[0].max(speeds[1]) - expected[0]).abs()
        + (speeds[0].min(speeds[1]) - expected[1]).abs();
    Ok(vec![
        ExtremeFinding::new("energy minus initial energy", (energy - 1.0).abs(), 1e-14),
        ExtremeFinding::new(
            "momentum minus initial momentum",
            (momentum - DVec2::X).length(),
            1e-14,
        ),
        ExtremeFinding::never(
            "different results on repetition",
            usize::from(first != again),
        ),
        ExtremeFinding::new(
            "speeds minus those of the sequential rule",
            sequential,
            1e-13,
        ),
    ])
}

fn few_discs(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let trials = (effort.collisions / 20).clamp(200, 20_000) as usize;
    let most = most_collisions_of_three(engine, trials)?;
    let mut wrong = 0;
    for count in 2..12 {
        wrong += usize::from(differs_from_inversions(engine, count)?);
    }
    Ok(vec![
        ExtremeFinding::new(
            "largest number of collisions of three discs",
            most as f64,
            4.0,
        ),
        ExtremeFinding::never(
            "fewer than two collisions of any three discs",
            usize::from(most < 2),
        ),
        ExtremeFinding::never(
            "rows whose number of collisions differs from the inversions",
            wrong,
        ),
    ])
}

/// The largest number of collisions of three discs that meet in the plane.
fn most_collisions_of_three(engine: Engine, trials: usize) -> Result<u64> {
    let mut most = 0;
    let angles: Vec<DVec2> = directions().take(9 * trials).collect();
    for k in 0..trials {
        let list = (0..3)
            .map(|i| {
                // They start on a circle and move inwards, so that they meet near the centre, far
                // from the box borders.
                let out = angles[9 * k + 3 * i];
                let aim = 1.5 * angles[9 * k + 3 * i + 1];
                let from = DVec2::splat(50.0) + (4.0 + 2.0 * i as f64) * out;
                let to = DVec2::splat(50.0) + aim;
                let speed = 1.0 + 0.8 * angles[9 * k + 3 * i + 2].x;
                disc(
                    0.5,
                    1.0,
                    from.to_array(),
                    ((to - from).normalize() * speed).to_array(),
                )
            })
            .collect();
        let Ok(mut run) = engine.simulate(&in_box([100.0, 100.0], list)) else {
            continue;
        };
        run.run_until(20.0)?;
        most = most.max(run.view().counters().collisions);
    }
    Ok(most)
}

/// Whether the discs of a row have all met, in another number of collisions than their velocities
/// have inversions.
fn differs_from_inversions(engine: Engine, count: usize) -> Result<bool> {
    let speeds: Vec<f64> = directions()
        .skip(17 * count)
        .take(count)
        .map(|d| 0.5 * d.x)
        .collect();
    let list = speeds
        .iter()
        .enumerate()
        .map(|(k, &v)| disc(0.01, 1.0, [40.0 + 0.05 * k as f64, 50.0], [v, 0.0]));
    let inversions = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
    let inversions = inversions.filter(|&(i, j)| speeds[i] > speeds[j]).count() as u64;
    let mut run = engine.simulate(&in_box([100.0, 100.0], list.collect()))?;
    run.run_until(80.0)?;
    // Discs of nearly equal speed may meet later: the number is checked only after all have met.
    let met = speeds.iter().enumerate().all(|(i, v)| {
        speeds[i + 1..]
            .iter()
            .all(|w| v <= w || 0.05 * count as f64 / (v - w) < 80.0)
    });
    Ok(met && run.view().counters().collisions != inversions)
}

fn meetings(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let four = [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]]
        .map(|[x, y]| disc(0.0625, 1.0, [0.5 + 0.25 * x, 0.5 + 0.25 * y], [-x, -y]));
    let mut findings = Vec::new();
    for (name, list) in [("four", four.to_vec()), ("lattice", mirrored_lattice())] {
        let scene = in_box([1.0, 1.0], list);
        let run = || -> Result<(AnySimulation, Watch)> {
            let mut run = engine.simulate(&scene)?;
            let mut watch = Watch::default();
            run.observe_until(0.5, &mut watch)?;
            Ok((run, watch))
        };
        let ((first, watch), (again, other)) = (run()?, run()?);
        let energy = scene.molecule.len() as f64
            * 0.5
            * DVec2::from(scene.molecule[0].velocity).length_squared();
        let bits = |run: &AnySimulation| {
            run.view()
                .bodies()
                .map(|body| body.motion)
                .collect::<Vec<_>>()
        };
        let same = bits(&first) == bits(&again) && watch.bodies == other.bodies;
        findings.extend([
            ExtremeFinding::new(
                format!("{name}: energy drift"),
                (first.view().energy() / energy - 1.0).abs(),
                1e-14,
            ),
            ExtremeFinding::new(
                format!("{name}: momentum"),
                first.view().momentum().length(),
                1e-13,
            ),
            ExtremeFinding::never(
                format!("{name}: different order on repetition"),
                usize::from(!same),
            ),
            ExtremeFinding::never(
                format!("{name}: overlapping pairs"),
                first.view().overlaps().pairs,
            ),
            ExtremeFinding::never(
                format!("{name}: no collision"),
                usize::from(watch.times.is_empty()),
            ),
        ]);
    }
    Ok(findings)
}

/// A square lattice of discs, each with the mirrored velocity of its neighbours.
fn mirrored_lattice() -> Vec<MoleculeSpec> {
    let place = |k: usize| [(k % 8) as f64 / 8.0, (k / 8) as f64 / 8.0];
    let mirrored = |odd: bool| if odd { -1.0 } else { 1.0 };
    (0..64)
        .map(|k| {
            disc(
                0.03125,
                1.0,
                place(k),
                [mirrored(k % 2 == 1), mirrored(k / 8 % 2 == 1)],
            )
        })
        .collect()
}
