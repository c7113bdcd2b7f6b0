//! Two discs: head-on at any speed, grazing, touching, overlapping, and in a funnel.

use anyhow::Result;
use carom::{
    Detection, Molecule, RunError,
    detection::Outcome,
    engine::{Scene, SceneError},
    kinematics::RelativeMotion,
};
use glam::DVec2;

use super::{
    Effort, Engine, ExtremeCase, ExtremeFinding,
    bodies::{bumper, disc},
    engine::in_box,
    watch::{Watch, place, velocity},
};

pub fn cases() -> Vec<ExtremeCase> {
    vec![
        ExtremeCase {
            id: "7.1",
            name: "two discs head on, speeds 1e-12 to 1e12",
            must: "time of contact to 4 ulp, scaling by powers of two to the bit",
            run: head_on,
        },
        ExtremeCase {
            id: "7.2",
            name: "grazing discs, offset σ(1 ± δ) with δ from 1e-4 to 1e-16, at distance 30 σ",
            must: "hit or miss as in exact arithmetic, except within 8 ulp; no overlap above 1e-14 σ",
            run: grazing,
        },
        ExtremeCase {
            id: "7.3",
            name: "discs in contact, gap 0 or ±1 ulp: approaching, parting, at relative rest",
            must: "one collision if approaching, otherwise none",
            run: touching,
        },
        ExtremeCase {
            id: "7.4",
            name: "discs that overlap at the start by 1e-15, 1e-9, 1e-3 σ",
            must: "the smallest overlap is run, the others are refused by name",
            run: overlapping,
        },
        ExtremeCase {
            id: "7.13",
            name: "a disc in a funnel of two bumpers with a gap of 2r(1 ± 1e-9)",
            must: "wide gap: it passes without contact; narrow gap: it does not pass, or ends in a named error if exactly centred",
            run: funnel,
        },
    ]
}

fn head_on(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let run = |speed: f64| -> Result<(f64, DVec2)> {
        let scene = in_box(
            [1.0, 1.0],
            vec![
                disc(0.1, 1.0, [0.25, 0.5], [speed, 0.0]),
                disc(0.1, 1.0, [0.75, 0.5], [-speed, 0.0]),
            ],
        );
        let mut run = engine.simulate(&scene)?;
        let mut watch = Watch::default();
        run.observe_until(0.25 / speed, &mut watch)?;
        let time = watch.times.first().copied().unwrap_or(f64::NAN);
        Ok((time * speed, place(&run, 0)))
    };
    // The gap in floating point; each disc covers half of it.
    let expected = 0.5 * (0.5 - (0.1 + 0.1));
    let mut worst = 0.0f64;
    for speed in [1e-12, 1.0, 1e12] {
        worst = worst.max((run(speed)?.0 / expected - 1.0).abs());
    }
    let base = run(1.0)?;
    let mut differ = 0;
    for exponent in [-40, 40] {
        differ += usize::from(run(2f64.powi(exponent))? != base);
    }
    Ok(vec![
        ExtremeFinding::new(
            "time of contact, relative error in ulp",
            worst / f64::EPSILON,
            4.0,
        ),
        ExtremeFinding::never("powers of two at which the path differs", differ),
    ])
}

fn grazing(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let half = Molecule::disc(0.5, 1.0)?;
    let detector = engine.detector();
    let (mut wrong, mut deepest) = (0, 0.0f64);
    let ask = |offset: f64| {
        let motion = RelativeMotion::exactly(DVec2::new(30.0, offset), DVec2::new(-1.0, 0.0));
        detector
            .first_contact(half.outline(), half.outline(), &motion, 100.0)
            .outcome
    };
    for exponent in 0..=24 {
        let delta = 10f64.powf(-4.0 - 0.5 * f64::from(exponent));
        for offset in [1.0 - delta, 1.0 + delta] {
            let hit = matches!(ask(offset), Outcome::Contact(_));
            // Within a few ulp of σ either answer is correct.
            wrong +=
                usize::from(hit != (offset < 1.0) && (offset - 1.0).abs() > 8.0 * f64::EPSILON);
        }
    }
    for k in 0..effort.collisions.min(10_000) {
        let depth = 1e-13 * (k as f64 + 0.5) / effort.collisions.min(10_000) as f64;
        let missed = !matches!(ask(1.0 - depth), Outcome::Contact(_));
        deepest = deepest.max(if missed { depth } else { 0.0 });
    }
    let mut overlap = 0.0f64;
    for exponent in 8..=32 {
        let delta = 10f64.powf(-0.5 * f64::from(exponent));
        let scene = in_box(
            [64.0, 4.0],
            vec![
                disc(0.5, 1.0, [1.0, 1.0], [1.0, 0.0]),
                disc(0.5, 1.0, [31.0, 2.0 - delta], [0.0; 2]),
            ],
        );
        let mut run = engine.simulate(&scene)?;
        // The closest approach, or where it would be without a contact.
        run.run_until(30.0)?;
        overlap = overlap.max(run.view().overlaps().deepest_length);
    }
    Ok(vec![
        ExtremeFinding::never("wrong hits or misses", wrong),
        ExtremeFinding::new("deepest graze missed (σ)", deepest, 1e-14),
        ExtremeFinding::new(
            "deepest overlap at closest approach in a box of 64 σ (σ)",
            overlap,
            64.0 * 65.0 * f64::EPSILON,
        ),
    ])
}

fn touching(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut wrong = 0;
    for x in [0.75f64.next_down(), 0.75, 0.75f64.next_up()] {
        for (speed, expected) in [(-1.0, 1), (1.0, 0), (0.0, 0)] {
            let scene = in_box(
                [2.0, 2.0],
                vec![
                    disc(0.125, 1.0, [0.5, 0.5], [0.0; 2]),
                    disc(0.125, 1.0, [x, 0.5], [speed, 0.0]),
                ],
            );
            let mut run = engine.simulate(&scene)?;
            run.run_until(0.5)?;
            wrong += usize::from(run.view().counters().collisions != expected);
        }
    }
    Ok(vec![ExtremeFinding::never(
        "wrong numbers of collisions",
        wrong,
    )])
}

fn overlapping(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let scene = |depth: f64| -> Scene {
        let x = 0.75 - 0.25 * depth;
        in_box(
            [1.0, 1.0],
            vec![
                disc(0.125, 1.0, [0.5, 0.5], [0.3, 0.1]),
                disc(0.125, 1.0, [x, 0.5], [0.0; 2]),
            ],
        )
    };
    let mut run = engine.simulate(&scene(1e-15))?;
    run.run_until(10.0)?;
    let refused = [1e-9, 1e-3].into_iter().filter(|&depth| {
        !matches!(
            engine.simulate(&scene(depth)),
            Err(SceneError::Overlap { .. })
        )
    });
    Ok(vec![
        ExtremeFinding::never(
            "overlapping pairs after the tiny one",
            run.view().overlaps().pairs,
        ),
        ExtremeFinding::never("large overlaps that are not refused", refused.count()),
    ])
}

fn funnel(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let (small, large) = (0.0625, 0.125);
    let run = |widened: f64, aside: f64| -> Result<(Option<RunError>, DVec2, f64, f64)> {
        let mut scene = in_box(
            [2.0, 1.0],
            vec![disc(small, 1.0, [0.5, 0.5 + aside], [1.0, 0.0])],
        );
        let away = large + small * (1.0 + widened);
        scene.bumper = vec![
            bumper(large, [1.0, 0.5 - away]),
            bumper(large, [1.0, 0.5 + away]),
        ];
        let mut run = engine.simulate(&scene)?;
        let ended = run.run_until(1.0).err();
        let (velocity, place) = (velocity(&run, 0), place(&run, 0));
        Ok((
            ended,
            velocity,
            place.x,
            run.view().overlaps().deepest_length,
        ))
    };
    let (wide, narrow, aside) = (run(1e-9, 0.0)?, run(-1e-9, 0.0)?, run(-1e-9, 1e-6)?);
    // On the axis it meets both bumpers at the same time, as at the tip of a wedge of 5e-5 radians:
    // 6e4 contacts without progress in time.
    let by_name = matches!(narrow.0, None | Some(RunError::Stalled { .. }));
    Ok(vec![
        ExtremeFinding::never(
            "contacts in the wide funnel",
            usize::from(wide.1 != DVec2::X || wide.2 != 1.5),
        ),
        ExtremeFinding::never(
            "passages of the narrow funnel",
            usize::from(narrow.2 > 1.0 || aside.2 > 1.0),
        ),
        ExtremeFinding::never(
            "unnamed errors in the narrow funnel",
            usize::from(!by_name || aside.0.is_some()),
        ),
        ExtremeFinding::new(
            "deepest overlap (length)",
            narrow.3.max(aside.3),
            64.0 * 2.2 * f64::EPSILON,
        ),
    ])
}
