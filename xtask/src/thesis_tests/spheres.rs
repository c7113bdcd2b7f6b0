//! Test 1: a thin gas of equal discs, with and without a grid (Montanari 2017, section 2.3.1, table 2.1, figure 2.3).

use std::f64::consts::PI;

use anyhow::Result;
use carom::{
    Cells, Exact, Fineness, Instructions, Scene, Thesis,
    engine::{BoxSpec, GasSpec},
};

use super::{
    Options,
    report::{self, Test},
    timing::{THESIS_TIME, Timing, time},
};
use crate::{
    power_law::PowerLaw,
    summary::{Figure, Verdict},
};

/// Table 2.1: discs, seconds without grid (more than two hours for 2000), seconds with grid; Intel Core i5-7200U.
const TABLE_2_1: [(usize, Option<f64>, f64); 5] = [
    (50, Some(2.015), 0.343),
    (100, Some(8.921), 1.0),
    (500, Some(428.391), 10.640),
    (1000, Some(2395.67), 35.437),
    (2000, None, 313.641),
];

/// Radius of the discs (length).
const RADIUS: f64 = 0.001;

const ENGINES: [&str; 3] = ["Thesis, no grid", "Thesis, grid", "Cells"];

fn scene(count: usize, seed: u64) -> Scene {
    let gas = GasSpec {
        radius: Some(RADIUS),
        mass: Some(1.0),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    };
    Scene { bounds: BoxSpec { seed, ..BoxSpec::default() }, gas: vec![gas], ..Scene::default() }
}

/// Collisions of all discs in the thesis's time, by Enskog: t N n σ χ √(π kT / m) with kT the energy of a disc and
/// χ = (1 − 7η/16)/(1 − η)² (Henderson 1975).
fn collisions(count: usize) -> f64 {
    let n = count as f64;
    let fraction = n * PI * RADIUS * RADIUS;
    let contact = (1.0 - 7.0 * fraction / 16.0) / (1.0 - fraction).powi(2);
    THESIS_TIME * n * n * 2.0 * RADIUS * contact * PI.sqrt()
}

/// Runs the test and writes its folder.
///
/// # Errors
/// A folder that is not empty, a run that cannot go on.
pub fn run(options: &Options) -> Result<Verdict> {
    let test = Test {
        name: "spheres",
        title: "Test 1: many colliding discs",
        lead: "A thin gas of discs of radius 0.001 and energy 1, for 100 time units: the first performance test of \
               Montanari (2017), section 2.3.1, with the thesis's scheme of events, repaired, and with the one that carom \
               uses.",
        size: "discs",
        cost: "time for 100 time units [s]",
    };
    test.run(options, |budget| {
        let mut timings = Vec::new();
        for (count, _, _) in TABLE_2_1 {
            let scene = scene(count, options.seed);
            // The thesis takes the integer closest to √N.
            let fine = Fineness::Given((count as f64).sqrt().round() as u32);
            let exact = Exact::default;
            timings.push(time::<_, Thesis>(
                ENGINES[0],
                count,
                &scene,
                (exact(), Fineness::Given(1)),
                budget,
            )?);
            timings.push(time::<_, Thesis>(ENGINES[1], count, &scene, (exact(), fine), budget)?);
            timings.push(time::<_, Cells>(
                ENGINES[2],
                count,
                &scene,
                (exact(), Instructions::Widest),
                budget,
            )?);
        }
        Ok(report::Results {
            points: timings
                .iter()
                .map(|timing| (timing.engine, timing.size, timing.for_thesis_time()))
                .collect(),
            published: published(),
            figures: figures(&timings),
            header: [
                "engine",
                "discs",
                "collisions in 100",
                "by Enskog",
                "time for 100 [s]",
                "thesis, table 2.1 [s]",
                "ns per collision",
                "time units run",
            ]
            .to_vec(),
            rows: timings.iter().map(row).collect(),
            timings,
        })
    })
}

fn published() -> Vec<(&'static str, usize, f64)> {
    let without =
        TABLE_2_1.iter().filter_map(|&(count, seconds, _)| Some(("thesis, no grid", count, seconds?)));
    let with = TABLE_2_1.iter().map(|&(count, _, seconds)| ("thesis, grid", count, seconds));
    without.chain(with).collect()
}

fn row(timing: &Timing) -> Vec<String> {
    let line = TABLE_2_1.iter().find(|line| line.0 == timing.size);
    let thesis = line.map_or_else(String::new, |&(_, without, with)| match (timing.engine, without) {
        (engine, Some(seconds)) if engine == ENGINES[0] => seconds.to_string(),
        (engine, None) if engine == ENGINES[0] => "> 7200".to_owned(),
        (engine, _) if engine == ENGINES[1] => with.to_string(),
        _ => "–".to_owned(),
    });
    let share = THESIS_TIME / timing.totals.simulated_time;
    vec![
        timing.engine.to_owned(),
        timing.size.to_string(),
        format!("{:.0}", timing.totals.collisions as f64 * share),
        format!("{:.0}", collisions(timing.size)),
        report::number(timing.for_thesis_time()),
        thesis,
        timing.per_collision().map_or_else(|| "–".to_owned(), |seconds| format!("{:.0}", seconds * 1e9)),
        report::number(timing.totals.simulated_time),
    ]
}

fn figures(timings: &[Timing]) -> Vec<Figure> {
    let mut figures = Vec::new();
    for engine in ENGINES {
        let of = || timings.iter().filter(move |timing| timing.engine == engine);
        let all: Vec<(f64, f64)> = of().map(|t| (t.size as f64, t.for_thesis_time())).collect();
        let each: Vec<(f64, f64)> = of().filter_map(|t| Some((t.size as f64, t.per_collision()?))).collect();
        for (what, points) in [("time for 100 time units", all), ("time per collision", each)] {
            figures.extend(PowerLaw::through(&points).map(|law| {
                Figure::new(format!("{engine}: exponent of the {what} against N"), law.exponent, "1")
                    .error(law.error)
            }));
        }
        figures.extend(of().filter(|timing| timing.totals.collisions > 0).map(|timing| {
            let count = timing.totals.collisions as f64;
            let rate = count / timing.totals.simulated_time;
            Figure::new(format!("{engine}: collisions of {} discs", timing.size), rate, "1/time")
                .error(rate / count.sqrt())
                .predicted(collisions(timing.size) / THESIS_TIME, "Enskog")
        }));
    }
    for (name, with) in [("without", false), ("with", true)] {
        let points: Vec<(f64, f64)> = TABLE_2_1
            .iter()
            .filter_map(|&(count, without, grid)| Some((count as f64, if with { grid } else { without? })))
            .collect();
        figures.extend(PowerLaw::through(&points).map(|law| {
            Figure::new(format!("the thesis's own table 2.1, {name} grid: exponent"), law.exponent, "1")
                .error(law.error)
        }));
    }
    figures
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thousand discs, kT = m = 1: each is hit 2 n σ √π times per time, and there are half as many collisions.
    #[test]
    fn collisions_of_a_thin_gas() {
        let dilute = THESIS_TIME * 0.5 * 1000.0 * (2.0 * 1000.0 * 0.002 * PI.sqrt());
        assert!((collisions(1000) / dilute - 1.0).abs() < 0.006 && collisions(1000) > dilute);
    }

    #[test]
    fn all_engines_count_the_collisions_of_the_same_gas() {
        let scene = scene(500, 3);
        let budget = 0.2;
        let exact = Exact::default;
        let thesis = time::<_, Thesis>("a", 500, &scene, (exact(), Fineness::Given(22)), budget).unwrap();
        let cells = time::<_, Cells>("b", 500, &scene, (exact(), Instructions::Widest), budget).unwrap();
        for timing in [thesis, cells] {
            let expected = collisions(500) * timing.totals.simulated_time / THESIS_TIME;
            let found = timing.totals.collisions as f64;
            assert!(
                (found - expected).abs() < 6.0 * expected.sqrt() + 0.02 * expected,
                "{found}, {expected}"
            );
        }
    }
}
