//! Test 2: two rods with an increasing number of atoms that collide repeatedly (Montanari 2017,
//! section 2.3.2, figure 2.4).

use std::{
    collections::BTreeMap,
    sync::atomic::{AtomicU64, Ordering::Relaxed},
};

use anyhow::Result;
use carom::{
    CellsPerSide, Detection, Exact, GoldenSecant, HeapScheduler, Impact, Scene, Simulation,
    detection::Answer,
    engine::{BoxSpec, MoleculeSpec},
    geometry::Outline,
    kinematics::RelativeMotion,
};
use carom_methods::{AnyDetector, Method, Order};
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

/// Atoms of each rod.
const ATOMS: [usize; 9] = [1, 2, 4, 8, 16, 32, 64, 128, 256];

/// Radius of the atoms (length).
const RADIUS: f64 = 0.001;

const GOLDEN: &str = "GoldenSecant";
const EXACT: &str = "Exact";
const DETECTORS: [&str; 2] = [GOLDEN, EXACT];

/// Smallest number of atoms in the fits: below, costs that do not depend on the atoms dominate.
const FIT_FROM: usize = 16;

/// A search examines all N² pairs of atoms, as in the thesis, but most queries need none because
/// the bounding circles do not meet. The exponent of the time per query is therefore 2 plus that of
/// the share of the queries whose bounding circles meet, which is measured ([`searched_share`]).
const GROWTH: &str = "2, for N² pairs of atoms, plus the exponent of the share of the queries whose bounding circles meet";

/// Least number of queries from which the share is measured.
const MIN_QUERIES: u64 = 50_000;

/// Largest duration of that measurement, for rods so short that they seldom meet (time).
const MAX_TIME: f64 = 1e4 * THESIS_TIME;

/// Header of the table.
const HEADER: [&str; 9] = [
    "detector",
    "atoms",
    "collisions",
    "queries",
    "share with bounding circles that meet",
    "µs per query",
    "time for 100 (s)",
    "thesis, fit of figure 2.4 (s)",
    "time units run",
];

/// Figure 2.4: p₂ N² + p₁ N with p₁ = −0.1 ± 0.2 and p₂ = 0.013 ± 0.001, taken as seconds, as in
/// the first test (the thesis does not give the unit); `None` where it is not positive.
fn figure_2_4(atoms: usize) -> Option<f64> {
    let n = atoms as f64;
    let seconds = 0.013 * n * n - 0.1 * n;
    (seconds > 0.0).then_some(seconds)
}

/// Two crossed rods of mass 1 and energy 1 with a small lateral offset, moving towards each other.
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
    // The second rod is perpendicular to the first, one radius above it and half a radius aside, so
    // that the collision is not symmetric.
    let height = 2.0 * RADIUS + 0.5 * RADIUS + RADIUS * (atoms as f64 - 1.0);
    Scene {
        bounds: BoxSpec {
            seed,
            ..BoxSpec::default()
        },
        molecule: vec![
            rod([0.5, 0.4], 0.0, speed),
            rod([0.5 + 0.5 * RADIUS, 0.4 + height], 0.25, -speed),
        ],
        ..Scene::default()
    }
}

/// Runs the test and writes its folder.
///
/// # Errors
/// The folder is not empty, or a run fails.
pub fn run(options: &ThesisTestsOptions) -> Result<Verdict> {
    let test = Test {
        name: "pair",
        title: "Test 2: two colliding rods",
        lead: "Two rods with an increasing number of atoms of radius 0.001, each of mass 1 and energy 1, for \
               100 time units: the second performance test of Montanari (2017), section 2.3.2, with the corrected \
               contact search of the thesis and with the certified one. Without a grid, as in the thesis.",
        size: "atoms of each rod",
    };
    run_test(&test, options, |budget, items| {
        items.expect(ATOMS.len() * (1 + DETECTORS.len()));
        let (mut timings, mut shares) = (Vec::new(), BTreeMap::new());
        for atoms in ATOMS {
            let share = items.finish(&format!("share of searches, {atoms}"), || {
                searched_share(&scene(atoms, options.random.seed))
            })?;
            shares.insert(atoms, share);
            for detector in DETECTORS {
                timings.push(case(detector, atoms, options.random.seed, budget, items)?);
            }
        }
        Ok(ThesisResults {
            charts: charts(&timings),
            figures: figures(&timings, &shares),
            header: HEADER.to_vec(),
            rows: timings
                .iter()
                .map(|timing| row(timing, shares[&timing.size]))
                .collect(),
            timings,
        })
    })
}

/// The time of one query, and that for the duration of the thesis, against the number of atoms.
fn charts(timings: &[ThesisTiming]) -> Vec<Costs> {
    let each =
        |timing: &ThesisTiming| Some((timing.engine.clone(), timing.size, timing.per_query()?.0));
    let times = |timing: &ThesisTiming| {
        Some((
            timing.engine.clone(),
            timing.size,
            timing.for_thesis_time()?.0,
        ))
    };
    let fit = |atoms| {
        Some((
            "fit of figure 2.4, as published".to_owned(),
            atoms,
            figure_2_4(atoms)?,
        ))
    };
    vec![
        Costs {
            file: "query.svg",
            what: "time of one query (s)",
            points: timings.iter().filter_map(each).collect(),
            published: Vec::new(),
            fits: Vec::new(),
        },
        Costs {
            file: "cost.svg",
            what: "time for 100 time units (s)",
            points: timings.iter().filter_map(times).collect(),
            published: ATOMS.into_iter().filter_map(fit).collect(),
            fits: golden_fit(timings)
                .map(|fit| (format!("{GOLDEN}, fit"), fit))
                .into_iter()
                .collect(),
        },
    ]
}

/// Rods of a number of atoms with one detector.
fn case(
    detector: &str,
    atoms: usize,
    seed: u64,
    budget: f64,
    items: &WorkItems,
) -> Result<ThesisTiming> {
    let (scene, signals) = (scene(atoms, seed), items.signals());
    items.finish(&format!("{detector}, {atoms}"), || {
        let search = if detector == GOLDEN {
            AnyDetector::GoldenSecant(GoldenSecant::default())
        } else {
            AnyDetector::default()
        };
        let method = Method {
            detector: search,
            order: Order::Heap(CellsPerSide::Given(1)),
            ..Method::default()
        };
        time(detector, atoms, &scene, &method, budget, signals)
    })
}

/// Counts the queries of a detector, and those that the bounding circles alone do not decide.
#[derive(Default)]
struct Counting {
    queries: AtomicU64,
    searched: AtomicU64,
}

impl Detection for &Counting {
    fn first_contact(
        &self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        let answer = Exact::default().first_contact(a, b, motion, horizon);
        self.queries.fetch_add(1, Relaxed);
        self.searched
            .fetch_add(u64::from(answer.evaluations > 0), Relaxed);
        answer
    }
}

/// The share of the queries in which the bounding circles meet before the horizon, so that atoms
/// are searched. It depends on the motion alone: all detectors restrict the search to the time in
/// which the circles overlap.
fn searched_share(scene: &Scene) -> Result<f64> {
    let counting = Counting::default();
    let mut simulation: Simulation<&Counting, Impact, HeapScheduler> =
        Simulation::with(scene, &counting, Impact, CellsPerSide::Given(1))?;
    let mut time = 0.0;
    while counting.queries.load(Relaxed) < MIN_QUERIES && time < MAX_TIME {
        time += THESIS_TIME;
        simulation.run_until(time)?;
    }
    Ok(counting.searched.load(Relaxed) as f64 / counting.queries.load(Relaxed).max(1) as f64)
}

fn row(timing: &ThesisTiming, share: f64) -> Vec<String> {
    vec![
        timing.engine.clone(),
        timing.size.to_string(),
        timing.totals.collisions.to_string(),
        timing.whole.queries.to_string(),
        number(share),
        cell(timing.per_query(), 1e-6),
        cell(timing.for_thesis_time(), 1.0),
        figure_2_4(timing.size).map_or_else(|| "–".to_owned(), number),
        number(timing.totals.simulated_time),
    ]
}

/// The thesis's fit, p₂ N² + p₁ N, to the times of its own search for 100 time units.
fn golden_fit(timings: &[ThesisTiming]) -> Option<Fit> {
    let of = timings.iter().filter(|timing| timing.engine == GOLDEN);
    let points: Vec<(f64, f64)> = of
        .filter_map(|timing| Some((timing.size as f64, timing.for_thesis_time()?.0)))
        .collect();
    Form::Quadratic.through(&points)
}

/// Exponent of the share of the queries in which atoms are searched, from [`FIT_FROM`] on.
fn growth_of_share(shares: &BTreeMap<usize, f64>) -> Option<PowerLaw> {
    let points: Vec<(f64, f64)> = shares
        .range(FIT_FROM..)
        .map(|(&atoms, &share)| (atoms as f64, share))
        .collect();
    PowerLaw::through(&points)
}

fn figures(timings: &[ThesisTiming], shares: &BTreeMap<usize, f64>) -> Vec<Figure> {
    let mut figures = Vec::new();
    let growth = growth_of_share(shares);
    figures.extend(growth.map(|law| {
        let name =
            "exponent of the share of the queries whose bounding circles meet, against the atoms";
        Figure::new(name, law.exponent, "1").error(law.error)
    }));
    figures.extend(
        golden_fit(timings)
            .into_iter()
            .flat_map(|fit| fit.figures(GOLDEN, None)),
    );
    for detector in DETECTORS {
        let of = timings
            .iter()
            .filter(|timing| timing.engine == detector && timing.size >= FIT_FROM);
        let points: Vec<(f64, f64)> = of
            .filter_map(|timing| Some((timing.size as f64, timing.per_query()?.0)))
            .collect();
        figures.extend(PowerLaw::through(&points).map(|law| {
            let name = format!(
                "{detector}: exponent of the time per query against the atoms, from {FIT_FROM} on"
            );
            let figure = Figure::new(name, law.exponent, "1").error(law.error);
            match growth.filter(|_| detector == GOLDEN) {
                Some(share) => figure.predicted(2.0 + share.exponent, GROWTH),
                None => figure,
            }
        }));
    }
    let cost = |detector, atoms| {
        let case = timings
            .iter()
            .find(|timing| timing.engine == detector && timing.size == atoms)?;
        case.per_query()
    };
    figures.extend(ATOMS.into_iter().filter_map(|atoms| {
        let ((golden, error_of_golden), (exact, error_of_exact)) =
            (cost(GOLDEN, atoms)?, cost(EXACT, atoms)?);
        let error = error_of_golden
            .zip(error_of_exact)
            .map(|(a, b)| (a / golden).hypot(b / exact));
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
            let timing = case(EXACT, atoms, 1, 0.05, &WorkItems::default()).unwrap();
            assert!(
                timing.totals.collisions > 0 && timing.totals.overlapping_pairs == 0,
                "{timing:?}"
            );
            assert!(timing.totals.energy_drift < 1e-12);
        }
    }
    #[test]
    fn longer_rods_need_more_searches() {
        let shares: BTreeMap<usize, f64> = [16, 64, 256]
            .map(|atoms| (atoms, searched_share(&scene(atoms, 1)).unwrap()))
            .into();
        assert!(
            shares.values().all(|share| (0.001..0.5).contains(share)),
            "{shares:?}"
        );
        // The cross section is proportional to the length of the rods: an exponent near 1, less
        // where the share approaches 1.
        let growth = growth_of_share(&shares).unwrap().exponent;
        assert!((0.8..1.2).contains(&growth), "{growth} of {shares:?}");
    }

    #[test]
    fn the_table_has_a_column_for_each_title() {
        let timing = case(EXACT, 2, 1, 0.05, &WorkItems::default()).unwrap();
        let row = row(&timing, 0.125);
        assert_eq!(row.len(), HEADER.len());
        let column = HEADER
            .iter()
            .position(|title| title.starts_with("share"))
            .unwrap();
        assert_eq!(row[column], number(0.125));
    }
}
