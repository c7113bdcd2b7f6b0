//! Test 1: a dilute gas of equal discs, with and without a grid (Montanari 2017, section 2.3.1,
//! table 2.1, figure 2.3).

use std::f64::consts::PI;

use anyhow::{Context, Result};
use carom::{
    CellsPerSide, Instructions, Scene,
    engine::{BoxSpec, GasSpec},
};
use carom_methods::{AnySimulation, Method, Order};
use carom_runs::work_items::WorkItems;
use carom_tables::{Figure, Verdict, power_law::PowerLaw};

use super::{
    ThesisTestsOptions,
    fits::{Fit, Form},
    report::{cell, number},
    results::{Costs, Test, ThesisResults},
    run::run_test,
    timing::{THESIS_TIME, ThesisTiming, time},
};
use carom_runs::measures::kicks::mean_speed;

/// Table 2.1: number of discs, seconds without grid (more than two hours for 2000), seconds with
/// grid; Intel Core i5-7200U.
const TABLE_2_1: [(usize, Option<f64>, f64); 5] = [
    (50, Some(2.015), 0.343),
    (100, Some(8.921), 1.0),
    (500, Some(428.391), 10.640),
    (1000, Some(2395.67), 35.437),
    (2000, None, 313.641),
];

/// Radius of the discs (length).
const RADIUS: f64 = 0.001;

const NO_GRID: &str = "thesis, no grid";
const GRID: &str = "thesis, grid";
const ENGINES: [&str; 3] = [NO_GRID, GRID, "cells"];

fn scene(count: usize, seed: u64) -> Scene {
    let gas = GasSpec {
        radius: Some(RADIUS.into()),
        mass: Some(1.0.into()),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    };
    Scene {
        bounds: BoxSpec {
            seed,
            ..BoxSpec::default()
        },
        gas: vec![gas],
        ..Scene::default()
    }
}

/// kT of a gas.
fn temperature(count: usize, seed: u64) -> Result<f64> {
    let simulation = AnySimulation::new(&scene(count, seed))?;
    simulation
        .view()
        .temperature()
        .context("fewer than two discs")
}

/// Collisions of all discs in the duration of the thesis, by Enskog theory: t N (N − 1) σ χ √(π kT
/// / m) with χ = (1 − 7η/16)/(1 − η)² (Henderson 1975), corrected for few discs at fixed energy.
fn collisions(count: usize, temperature: f64) -> f64 {
    let n = count as f64;
    let fraction = n * PI * RADIUS * RADIUS;
    let contact = (1.0 - 7.0 * fraction / 16.0) / (1.0 - fraction).powi(2);
    let speed = (PI * temperature).sqrt() * mean_speed(2.0 * n - 2.0);
    THESIS_TIME * n * (n - 1.0) * 2.0 * RADIUS * contact * speed
}

/// Runs the test and writes its folder.
///
/// # Errors
/// The folder is not empty, or a run fails.
pub fn run(options: &ThesisTestsOptions) -> Result<Verdict> {
    let test = Test {
        name: "spheres",
        title: "Test 1: many colliding discs",
        lead: "A dilute gas of discs of radius 0.001 and energy 1, for 100 time units: the first performance \
               test of Montanari (2017), section 2.3.1, with the corrected event scheduler of the thesis and with \
               that of carom.",
        size: "discs",
    };
    run_test(&test, options, |budget, items| {
        items.expect(TABLE_2_1.len() * ENGINES.len());
        let mut timings = Vec::new();
        for (count, _, _) in TABLE_2_1 {
            for engine in ENGINES {
                timings.push(case(engine, count, options.random.seed, budget, items)?);
            }
        }
        Ok(ThesisResults {
            charts: charts(&timings),
            figures: figures(&timings, options.random.seed)?,
            header: [
                "engine",
                "discs",
                "collisions in 100",
                "by Enskog",
                "time for 100 (s)",
                "thesis, table 2.1 (s)",
                "µs per collision",
                "time units run",
            ]
            .to_vec(),
            rows: timings
                .iter()
                .map(|timing| row(timing, options.random.seed))
                .collect::<Result<_>>()?,
            timings,
        })
    })
}

/// The time for the duration of the thesis, and that of one collision, against the number of discs.
fn charts(timings: &[ThesisTiming]) -> Vec<Costs> {
    let times = |timing: &ThesisTiming| {
        Some((
            timing.engine.clone(),
            timing.size,
            timing.for_thesis_time()?.0,
        ))
    };
    let each = |timing: &ThesisTiming| {
        Some((
            timing.engine.clone(),
            timing.size,
            timing.per_collision()?.0,
        ))
    };
    vec![
        Costs {
            file: "cost.svg",
            what: "time for 100 time units (s)",
            points: timings.iter().filter_map(times).collect(),
            published: published(),
            fits: fits(timings)
                .map(|(name, fit)| (format!("{name}, fit"), fit))
                .collect(),
        },
        Costs {
            file: "collision.svg",
            what: "time of one collision (s)",
            points: timings.iter().filter_map(each).collect(),
            published: published()
                .into_iter()
                .map(|(name, count, seconds)| (name, count, seconds / collisions(count, 1.0)))
                .collect(),
            fits: Vec::new(),
        },
    ]
}

/// One number of discs with one engine.
fn case(
    engine: &str,
    count: usize,
    seed: u64,
    budget: f64,
    items: &WorkItems,
) -> Result<ThesisTiming> {
    let (scene, signals) = (scene(count, seed), items.signals());
    // The thesis uses the integer closest to √N.
    let fine = (count as f64).sqrt().round() as u32;
    let order = match engine {
        NO_GRID => Order::Heap(CellsPerSide::Given(1)),
        GRID => Order::Heap(CellsPerSide::Given(fine)),
        _ => Order::Cells(Instructions::Widest),
    };
    let method = Method {
        order,
        ..Method::default()
    };
    items.finish(&format!("{engine}, {count}"), || {
        time(engine, count, &scene, &method, budget, signals)
    })
}

fn published() -> Vec<(String, usize, f64)> {
    let of = |name: &str, count, seconds| (format!("{name}, as published"), count, seconds);
    let without = TABLE_2_1
        .iter()
        .filter_map(|&(count, seconds, _)| Some(of(NO_GRID, count, seconds?)));
    let with = TABLE_2_1
        .iter()
        .map(|&(count, _, seconds)| of(GRID, count, seconds));
    without.chain(with).collect()
}

/// Fits of the thesis's functions to the times for 100 time units: p₂ N² + p₁ N without a grid,
/// exp(k₀ + k₁ N) with one.
fn fits(timings: &[ThesisTiming]) -> impl Iterator<Item = (&'static str, Fit)> {
    [(NO_GRID, Form::Quadratic), (GRID, Form::Exponential)]
        .into_iter()
        .filter_map(|(engine, form)| {
            let of = timings.iter().filter(|timing| timing.engine == engine);
            let points: Vec<(f64, f64)> = of
                .filter_map(|timing| Some((timing.size as f64, timing.for_thesis_time()?.0)))
                .collect();
            Some((engine, form.through(&points)?))
        })
}

/// The fits in the caption of figure 2.3. It prints k₁ as 223·10⁻⁶, by which 2000 discs would take
/// 5.6 s; table 2.1 has 314 s, which corresponds to 223·10⁻⁵.
const FIGURE_2_3: [[f64; 2]; 2] = [[-0.80, 315e-5], [1.27, 223e-5]];

fn row(timing: &ThesisTiming, seed: u64) -> Result<Vec<String>> {
    let line = TABLE_2_1.iter().find(|line| line.0 == timing.size);
    let thesis = line.map_or_else(String::new, |&(_, without, with)| {
        match timing.engine.as_str() {
            NO_GRID => without.map_or_else(|| "> 7200".to_owned(), |seconds| seconds.to_string()),
            GRID => with.to_string(),
            _ => "–".to_owned(),
        }
    });
    let share = THESIS_TIME / timing.totals.simulated_time;
    Ok(vec![
        timing.engine.clone(),
        timing.size.to_string(),
        format!("{:.0}", timing.totals.collisions as f64 * share),
        format!(
            "{:.0}",
            collisions(timing.size, temperature(timing.size, seed)?)
        ),
        cell(timing.for_thesis_time(), 1.0),
        thesis,
        cell(timing.per_collision(), 1e-6),
        number(timing.totals.simulated_time),
    ])
}

fn figures(timings: &[ThesisTiming], seed: u64) -> Result<Vec<Figure>> {
    let mut figures = Vec::new();
    let of = |engine: &'static str| timings.iter().filter(move |timing| timing.engine == engine);
    for engine in ENGINES {
        let times = of(engine).filter_map(|t| Some((t.size as f64, t.for_thesis_time()?.0)));
        let each = of(engine).filter_map(|t| Some((t.size as f64, t.per_collision()?.0)));
        figures.extend(exponent(
            &format!("{engine}: exponent of the time for 100 time units"),
            times,
        ));
        figures.extend(exponent(
            &format!("{engine}: exponent of the time of one collision"),
            each,
        ));
    }
    let table = || {
        TABLE_2_1
            .iter()
            .map(|&(count, without, with)| (count as f64, without, with))
    };
    let without = table().filter_map(|(count, without, _)| Some((count, without?)));
    figures.extend(exponent(
        "table 2.1 of the thesis, no grid: exponent",
        without,
    ));
    figures.extend(exponent(
        "table 2.1 of the thesis, grid: exponent",
        table().map(|(n, _, with)| (n, with)),
    ));
    for (engine, fit) in fits(timings) {
        figures.extend(fit.figures(engine, None));
    }
    let without: Vec<_> = table()
        .filter_map(|(count, without, _)| Some((count, without?)))
        .collect();
    let with: Vec<_> = table().map(|(count, _, with)| (count, with)).collect();
    let of_table = [
        (Form::Quadratic, without, FIGURE_2_3[0]),
        (Form::Exponential, with, FIGURE_2_3[1]),
    ];
    for (form, points, caption) in of_table {
        let source = Some((caption, "caption of figure 2.3, from more points"));
        figures.extend(
            form.through(&points)
                .into_iter()
                .flat_map(|fit| fit.figures("table 2.1", source)),
        );
    }
    figures.extend(collision_rates(timings, seed)?);
    Ok(figures)
}

/// Measured collision rates, with those of Enskog theory.
fn collision_rates(timings: &[ThesisTiming], seed: u64) -> Result<Vec<Figure>> {
    let mut figures = Vec::new();
    let of = |engine: &'static str| timings.iter().filter(move |timing| timing.engine == engine);
    let collided = ENGINES
        .into_iter()
        .flat_map(of)
        .filter(|timing| timing.totals.collisions > 0);
    for timing in collided {
        let count = timing.totals.collisions as f64;
        let rate = count / timing.totals.simulated_time;
        let predicted = collisions(timing.size, temperature(timing.size, seed)?) / THESIS_TIME;
        let name = format!("{}: collisions of {} discs", timing.engine, timing.size);
        let figure = Figure::new(name, rate, "1/time").error(rate / count.sqrt());
        figures.push(figure.predicted(predicted, "Enskog, few discs at fixed energy"));
    }
    Ok(figures)
}

/// Exponent of the number of discs.
fn exponent(name: &str, points: impl Iterator<Item = (f64, f64)>) -> Option<Figure> {
    let law = PowerLaw::through(&points.collect::<Vec<_>>())?;
    Some(Figure::new(name, law.exponent, "1").error(law.error))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thousand discs, kT = m = 1: each is hit 2 n σ √π times per time, and the number of
    /// collisions is half of that.
    #[test]
    fn collisions_of_a_dilute_gas() {
        let dilute = THESIS_TIME * 0.5 * 1000.0 * (2.0 * 1000.0 * 0.002 * PI.sqrt());
        let found = collisions(1000, 1.0);
        assert!((found / dilute - 1.0).abs() < 0.006 && found > dilute);
    }

    #[test]
    fn all_engines_count_the_collisions_of_the_same_gas() {
        for engine in [GRID, "cells"] {
            let timing = case(engine, 500, 3, 0.2, &WorkItems::default()).unwrap();
            let expected = collisions(500, temperature(500, 3).unwrap())
                * timing.totals.simulated_time
                / THESIS_TIME;
            let found = timing.totals.collisions as f64;
            assert!(
                (found - expected).abs() < 6.0 * expected.sqrt() + 0.02 * expected,
                "{found}, {expected}"
            );
        }
    }
}
