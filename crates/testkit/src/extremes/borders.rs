//! Borders of cells and of the box, boxes of few cells, and partners that meet through two images.

use anyhow::Result;
use carom::{
    Exact, HeapScheduler, Impact, Scene, Simulation,
    engine::{CellsPerSide, GridError, SceneError},
};
use glam::DVec2;

use super::{
    Effort, Engine, ExtremeCase, ExtremeFinding,
    bodies::{bumper, disc},
    engine::{gas, in_box},
    watch::{Watch, run_collisions, velocity},
};

pub fn cases() -> Vec<ExtremeCase> {
    vec![
        ExtremeCase {
            id: "7.19",
            name: "an object on a border of cells, in the corner of the box, at x = L − ulp, at x = −0.0",
            must: "hit from all four sides at the closed-form time",
            run: places,
        },
        ExtremeCase {
            id: "7.20",
            name: "a disc along a border of cells, one component of its velocity 0 or −0",
            must: "a bounded number of crossings, the target is hit",
            run: along,
        },
        ExtremeCase {
            id: "7.21",
            name: "bodies larger than a cell; boxes of one, two, three cells a side",
            must: "the same collisions as a search of all pairs and images; too small a box is refused",
            run: few_cells,
        },
        ExtremeCase {
            id: "7.22",
            name: "discs of a diameter above L/2 that meet through two images",
            must: "each hit at its closed-form time, alternating images; contact with the own image is refused",
            run: two_images,
        },
        ExtremeCase {
            id: "7.23",
            name: "a bumper at the corner of the box, and in its middle",
            must: "the same first collisions; both mean free paths as predicted",
            run: corner_bumper,
        },
    ]
}

fn places(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut wrong = 0;
    let last = 1.0f64.next_down();
    // Some forty further discs at rest create cells with borders at k/n for many n.
    let borders = (1..=12).flat_map(|n| (0..n).map(move |k| f64::from(k) / f64::from(n)));
    for at in borders.chain([last, -0.0, 1.0]) {
        for place in [[at, at], [at, 0.5], [0.25, at], [at, last]] {
            for step in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
                let from = [place[0] - 0.125 * step[0], place[1] - 0.125 * step[1]];
                let scene = in_box(
                    [1.0, 1.0],
                    vec![
                        disc(0.03125, 1.0, place, [0.0; 2]),
                        disc(0.03125, 1.0, from, step),
                    ],
                );
                let mut run = engine.simulate(&scene)?;
                let mut watch = Watch::default();
                run.observe_until(0.1, &mut watch)?;
                let hit = watch
                    .times
                    .first()
                    .is_some_and(|time| (time - 0.0625).abs() < 1e-14);
                let exchanged = (velocity(&run, 0) - DVec2::from(step)).length() < 1e-12;
                wrong += usize::from(!hit || watch.times.len() != 1 || !exchanged);
            }
        }
    }
    Ok(vec![ExtremeFinding::never(
        "positions without a hit",
        wrong,
    )])
}

fn along(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut wrong = 0;
    let mut crossings = 0;
    for zero in [0.0, -0.0] {
        for at in [0.0, 0.125, 0.25, 1.0 / 3.0, 0.5, 1.0f64.next_down()] {
            for flipped in [false, true] {
                let turn = |v: [f64; 2]| if flipped { [v[1], v[0]] } else { v };
                // A slow target one box ahead, which the fast disc meets after about a thousand
                // boxes.
                let mut list = vec![
                    disc(0.01, 1.0, turn([0.1, at]), turn([1.0, zero])),
                    disc(0.01, 1.0, turn([0.6, at]), turn([0.999, zero])),
                ];
                let others = (0..14)
                    .map(|k| disc(0.01, 1.0, turn([f64::from(k) / 14.0, at + 0.06]), [zero; 2]));
                list.extend(others);
                let mut run = engine.simulate(&in_box([1.0, 1.0], list))?;
                let mut watch = Watch::default();
                run.observe_until(500.0, &mut watch)?;
                let expected = (0.5 - 0.02) / 0.001;
                let hit = watch.times.len() == 1 && (watch.times[0] - expected).abs() < 1e-9;
                wrong += usize::from(!hit);
                crossings = crossings.max(run.view().counters().scheduler.crossings);
            }
        }
    }
    Ok(vec![
        ExtremeFinding::never("targets not hit", wrong),
        ExtremeFinding::new(
            "most crossings of two discs in 500 boxes",
            crossings as f64,
            2.0 * 500.0 * 64.0,
        ),
    ])
}

/// The bodies of the first collisions, from a search of all pairs and images.
fn all_pairs(scene: &Scene, count: usize) -> Result<Vec<[u64; 2]>> {
    let mut run: Simulation<Exact, Impact, HeapScheduler> =
        Simulation::with(scene, Exact::default(), Impact, CellsPerSide::Given(1))?;
    let mut watch = Watch::default();
    for _ in 0..count {
        run.step(1e3, &mut watch)?;
    }
    Ok(watch.bodies)
}

fn few_cells(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut wrong = 0;
    let scene = |big: f64, small: f64, count: usize| {
        let mut scene = in_box([1.0, 1.0], vec![disc(big, 4.0, [0.3, 0.4], [0.2, 0.1])]);
        scene.gas = vec![gas("disc", small, 1.0, count)];
        scene
    };
    for (big, small, count) in [
        (0.05, 0.02, 40),
        (0.15, 0.01, 60),
        (0.2, 0.15, 3),
        (0.24, 0.2, 1),
        (0.33, 0.15, 1),
        (0.4, 0.02, 20),
    ] {
        let scene = scene(big, small, count);
        let expected = all_pairs(&scene, 40)?;
        let mut run = engine.simulate(&scene)?;
        let mut watch = Watch::default();
        for _ in 0..40 {
            run.step(1e3, &mut watch)?;
        }
        let pair = |list: &[[u64; 2]]| -> Vec<[u64; 2]> {
            // The first collisions only: later, chaos amplifies rounding to different trajectories.
            list.iter()
                .take(20)
                .map(|[a, b]| [*a.min(b), *a.max(b)])
                .collect()
        };
        wrong += usize::from(pair(&expected) != pair(&watch.bodies) || expected.is_empty());
    }
    let refused = [(0.5001, 0.0), (0.6, 0.0), (0.45, 0.0)]
        .into_iter()
        .filter(|&(radius, _)| {
            let list = vec![disc(radius, 1.0, [0.5, 0.5], [0.0; 2])];
            let built = engine.simulate(&in_box([1.0, 1.0], list));
            let too_small = matches!(
                built,
                Err(SceneError::Grid {
                    reason: GridError::BoxTooSmall { .. },
                    ..
                })
            );
            too_small != (radius > 0.5)
        });
    Ok(vec![
        ExtremeFinding::never("scenes with other collisions than all pairs", wrong),
        ExtremeFinding::never("boxes wrongly refused or accepted", refused.count()),
    ])
}

fn two_images(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    // Two discs of diameters 0.52 and 0.4 in a row across the border: a free gap of 0.04 on either
    // side.
    let scene = in_box(
        [1.0, 1.0],
        vec![
            disc(0.26, 1.0, [0.25, 0.5], [0.0; 2]),
            disc(0.2, 1.0, [0.75, 0.5], [1.0, 0.0]),
        ],
    );
    let mut run = engine.simulate(&scene)?;
    let mut watch = Watch::default();
    run.observe_until(8.0, &mut watch)?;
    let late = watch
        .times
        .iter()
        .enumerate()
        .map(|(k, time)| (time - (0.04 + 0.08 * k as f64)).abs())
        .fold(0.0, f64::max);
    let own = engine.simulate(&in_box(
        [1.0, 1.0],
        vec![disc(0.52, 1.0, [0.25, 0.5], [1.0, 0.0])],
    ));
    let refused = matches!(
        own,
        Err(SceneError::Grid {
            reason: GridError::BoxTooSmall { .. },
            ..
        })
    );
    Ok(vec![
        ExtremeFinding::new(
            "number of hits minus the expected 100",
            (watch.times.len() as f64 - 100.0).abs(),
            0.0,
        ),
        ExtremeFinding::new("largest error of a time", late, 1e-12),
        ExtremeFinding::never(
            "contacts with the own image that are not refused",
            usize::from(!refused),
        ),
    ])
}

fn corner_bumper(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let sum = 0.25;
    let scene = |at: f64| {
        let place = [(at + 0.4) % 1.0, (at + 0.15) % 1.0];
        let mut scene = in_box([1.0, 1.0], vec![disc(0.05, 1.0, place, [0.6, 0.8])]);
        scene.bumper = vec![bumper(sum - 0.05, [at, at])];
        scene
    };
    let predicted = (1.0 - std::f64::consts::PI * sum * sum) / (2.0 * sum);
    let mut findings = Vec::new();
    let mut first = Vec::new();
    for (name, at) in [("middle", 0.5), ("corner", 0.0)] {
        let mut run = engine.simulate(&scene(at))?;
        let mut watch = Watch::default();
        run_collisions(&mut run, effort.collisions, &mut watch, |_| {})?;
        let free = run.time().to_f64() / run.view().counters().collisions as f64;
        // The standard deviation of free paths is about their mean, and their correlation is small.
        let error = predicted / (effort.collisions as f64).sqrt();
        let off = (free - predicted).abs() / error;
        findings.push(ExtremeFinding::new(
            format!("{name}: deviation of the mean free path (standard errors)"),
            off,
            5.0,
        ));
        first.push(watch.times.into_iter().take(6).collect::<Vec<f64>>());
    }
    let differ = first[0]
        .iter()
        .zip(&first[1])
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    findings.push(ExtremeFinding::new(
        "largest difference of the first six times",
        differ,
        1e-8,
    ));
    Ok(findings)
}
