//! Test 2: two rods of ever more atoms that meet again and again (Montanari 2017, section 2.3.2, figure 2.4).

use anyhow::Result;
use carom::{
    CellsPerSide, Exact, GoldenSecant, HeapScheduler, Scene,
    engine::{BoxSpec, MoleculeSpec},
};
use carom_runs::work_items::Pieces;
use carom_tables::{Figure, Verdict, power_law::PowerLaw};

use super::{
    Options,
    fits::{Fit, Form},
    report::{Costs, Results, Test, cell, number},
    timing::{Timing, time},
};

/// Atoms of each rod.
const ATOMS: [usize; 9] = [1, 2, 4, 8, 16, 32, 64, 128, 256];

/// Radius of the atoms (length).
const RADIUS: f64 = 0.001;

const GOLDEN: &str = "GoldenSecant";
const EXACT: &str = "Exact";
const DETECTORS: [&str; 2] = [GOLDEN, EXACT];

/// From so many atoms on the growth is fitted: below, what does not depend on the atoms counts more.
const FIT_FROM: usize = 16;

/// A search looks at all N² pairs of atoms, as the thesis says, but most queries need none: the
/// bounding circles do not meet. The share of those that do grows as the length of the rods, from
/// 1.2 % at 16 atoms to 18 % at 256, where it comes near its limit. So a query grows by nearly one
/// power more than a search.
const GROWTH: &str = "N² pairs of atoms, in a share of the queries that grows as N";

/// Figure 2.4: p₂ N² + p₁ N with p₁ = −0.1 ± 0.2 and p₂ = 0.013 ± 0.001, taken as seconds, as in the first test (the
/// thesis does not say); `None` where that is not positive.
fn figure_2_4(atoms: usize) -> Option<f64> {
    let n = atoms as f64;
    let seconds = 0.013 * n * n - 0.1 * n;
    (seconds > 0.0).then_some(seconds)
}

/// Two rods of mass 1 and energy 1, crosswise and a little aside, on their way towards each other.
fn scene(atoms: usize, seed: u64) -> Scene {
    let rod = |at, turns, velocity| MoleculeSpec {
        shape: Some(format!("rod:{atoms}")),
        atom_radius: Some(RADIUS),
        atom_mass: Some(1.0 / atoms as f64),
        at,
        orientation_turns: Some(turns),
        velocity: [0.0, velocity],
        ..MoleculeSpec::default()
    };
    let speed = 2f64.sqrt();
    // The second stands across the first, one radius above it, half a radius aside: neither head-on nor even.
    let height = 2.0 * RADIUS + 0.5 * RADIUS + RADIUS * (atoms as f64 - 1.0);
    Scene {
        bounds: BoxSpec { seed, ..BoxSpec::default() },
        molecule: vec![rod([0.5, 0.4], 0.0, speed), rod([0.5 + 0.5 * RADIUS, 0.4 + height], 0.25, -speed)],
        ..Scene::default()
    }
}

/// Runs the test and writes its folder.
///
/// # Errors
/// A folder that is not empty, a run that cannot go on.
pub fn run(options: &Options) -> Result<Verdict> {
    let test = Test {
        name: "pair",
        title: "Test 2: two colliding rods",
        lead: "Two rods of ever more atoms of radius 0.001, each of mass 1 and energy 1, for 100 time units: the second \
               performance test of Montanari (2017), section 2.3.2, with the thesis's search for the first contact, \
               repaired, and with the certified one. Without a grid, as in the thesis.",
        size: "atoms of each rod",
    };
    test.run(options, |budget, pieces| {
        let mut timings = Vec::new();
        for atoms in ATOMS {
            for detector in DETECTORS {
                timings.push(case(detector, atoms, options.seed, budget, pieces)?);
            }
        }
        let each = |timing: &Timing| Some((timing.engine.clone(), timing.size, timing.per_query()?.0));
        let times = |timing: &Timing| Some((timing.engine.clone(), timing.size, timing.for_thesis_time()?.0));
        let fit = |atoms| Some(("fit of figure 2.4, as published".to_owned(), atoms, figure_2_4(atoms)?));
        Ok(Results {
            charts: vec![
                Costs {
                    file: "query.svg",
                    what: "time of one query [s]",
                    points: timings.iter().filter_map(each).collect(),
                    published: Vec::new(),
                    fits: Vec::new(),
                },
                Costs {
                    file: "cost.svg",
                    what: "time for 100 time units [s]",
                    points: timings.iter().filter_map(times).collect(),
                    published: ATOMS.into_iter().filter_map(fit).collect(),
                    fits: golden_fit(&timings)
                        .map(|fit| (format!("{GOLDEN}, fit"), fit))
                        .into_iter()
                        .collect(),
                },
            ],
            figures: figures(&timings),
            header: [
                "detector",
                "atoms",
                "collisions",
                "queries",
                "µs per query",
                "time for 100 [s]",
                "thesis, fit of figure 2.4 [s]",
                "time units run",
            ]
            .to_vec(),
            rows: timings.iter().map(row).collect(),
            timings,
        })
    })
}

/// Rods of so many atoms with one detector.
fn case(detector: &str, atoms: usize, seed: u64, budget: f64, pieces: &Pieces) -> Result<Timing> {
    let (scene, no_grid, signals) = (scene(atoms, seed), CellsPerSide::Given(1), pieces.signals());
    pieces.finish(&format!("{detector}, {atoms}"), || {
        if detector == GOLDEN {
            let golden = GoldenSecant::default();
            time::<_, HeapScheduler>(detector, atoms, &scene, (golden, no_grid), budget, signals)
        } else {
            time::<_, HeapScheduler>(detector, atoms, &scene, (Exact::default(), no_grid), budget, signals)
        }
    })
}

fn row(timing: &Timing) -> Vec<String> {
    vec![
        timing.engine.clone(),
        timing.size.to_string(),
        timing.totals.collisions.to_string(),
        timing.whole.queries.to_string(),
        cell(timing.per_query(), 1e-6),
        cell(timing.for_thesis_time(), 1.0),
        figure_2_4(timing.size).map_or_else(|| "–".to_owned(), number),
        number(timing.totals.simulated_time),
    ]
}

/// The thesis's fit, p₂ N² + p₁ N, to the times of its own search for 100 time units.
fn golden_fit(timings: &[Timing]) -> Option<Fit> {
    let of = timings.iter().filter(|timing| timing.engine == GOLDEN);
    let points: Vec<(f64, f64)> =
        of.filter_map(|timing| Some((timing.size as f64, timing.for_thesis_time()?.0))).collect();
    Form::Quadratic.through(&points)
}

fn figures(timings: &[Timing]) -> Vec<Figure> {
    let mut figures = Vec::new();
    figures.extend(golden_fit(timings).into_iter().flat_map(|fit| fit.figures(GOLDEN, None)));
    for detector in DETECTORS {
        let of = timings.iter().filter(|timing| timing.engine == detector && timing.size >= FIT_FROM);
        let points: Vec<(f64, f64)> =
            of.filter_map(|timing| Some((timing.size as f64, timing.per_query()?.0))).collect();
        figures.extend(PowerLaw::through(&points).map(|law| {
            let name =
                format!("{detector}: exponent of the time per query against the atoms, from {FIT_FROM} on");
            let figure = Figure::new(name, law.exponent, "1").error(law.error);
            if detector == GOLDEN { figure.predicted(3.0, GROWTH) } else { figure }
        }));
    }
    let cost = |detector, atoms| {
        let case = timings.iter().find(|timing| timing.engine == detector && timing.size == atoms)?;
        case.per_query()
    };
    figures.extend(ATOMS.into_iter().filter_map(|atoms| {
        let ((golden, error_of_golden), (exact, error_of_exact)) =
            (cost(GOLDEN, atoms)?, cost(EXACT, atoms)?);
        let error = error_of_golden.zip(error_of_exact).map(|(a, b)| (a / golden).hypot(b / exact));
        let ratio = golden / exact;
        let name = format!("{GOLDEN} over {EXACT}, time per query, rods of {atoms}");
        Some(Figure::new(name, ratio, "1").error(error.map(|error| error * ratio)))
    }));
    figures
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rods_of_every_length_begin_apart_and_meet() {
        for atoms in [1, 2, 16] {
            let timing = case(EXACT, atoms, 1, 0.05, &Pieces::default()).unwrap();
            assert!(timing.totals.collisions > 0 && timing.totals.overlapping_pairs == 0, "{timing:?}");
            assert!(timing.totals.energy_drift < 1e-12);
        }
    }
}
