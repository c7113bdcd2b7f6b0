//! Test 2: two rods of ever more atoms that meet again and again (Montanari 2017, section 2.3.2, figure 2.4).

use anyhow::Result;
use carom::{
    Exact, Fineness, GoldenSecant, Scene, Thesis,
    engine::{BoxSpec, MoleculeSpec},
};

use super::{
    Options,
    report::{self, Test},
    timing::{Timing, time},
};
use crate::{
    power_law::PowerLaw,
    summary::{Figure, Verdict},
};

/// Atoms of each rod.
const ATOMS: [usize; 9] = [1, 2, 4, 8, 16, 32, 64, 128, 256];

/// Radius of the atoms (length).
const RADIUS: f64 = 0.001;

const DETECTORS: [&str; 2] = ["GoldenSecant", "Exact"];

/// From so many atoms on the growth is fitted: below, what does not depend on the atoms counts more.
const FIT_FROM: usize = 16;

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
        cost: "time of one query [s]",
    };
    test.run(options, |budget| {
        let mut timings = Vec::new();
        for atoms in ATOMS {
            let scene = scene(atoms, options.seed);
            let golden = (GoldenSecant::default(), Fineness::Given(1));
            timings.push(time::<_, Thesis>(DETECTORS[0], atoms, &scene, golden, budget)?);
            let exact = (Exact::default(), Fineness::Given(1));
            timings.push(time::<_, Thesis>(DETECTORS[1], atoms, &scene, exact, budget)?);
        }
        let point = |timing: &Timing| Some((timing.engine, timing.size, timing.per_query()?));
        Ok(report::Results {
            points: timings.iter().filter_map(point).collect(),
            published: Vec::new(),
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

fn row(timing: &Timing) -> Vec<String> {
    let dash = || "–".to_owned();
    vec![
        timing.engine.to_owned(),
        timing.size.to_string(),
        timing.totals.collisions.to_string(),
        timing.queries.to_string(),
        timing.per_query().map_or_else(dash, |seconds| report::number(seconds * 1e6)),
        report::number(timing.for_thesis_time()),
        figure_2_4(timing.size).map_or_else(dash, report::number),
        report::number(timing.totals.simulated_time),
    ]
}

fn figures(timings: &[Timing]) -> Vec<Figure> {
    let law = |detector: &'static str| {
        let of = timings.iter().filter(|timing| timing.engine == detector && timing.size >= FIT_FROM);
        let points: Vec<(f64, f64)> =
            of.filter_map(|timing| Some((timing.size as f64, timing.per_query()?))).collect();
        PowerLaw::through(&points).map(|law| {
            let name =
                format!("{detector}: exponent of the time per query against the atoms, from {FIT_FROM} on");
            Figure::new(name, law.exponent, "1").error(law.error)
        })
    };
    DETECTORS.into_iter().filter_map(law).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rods_of_every_length_begin_apart_and_meet() {
        for atoms in [1, 2, 16] {
            let timing = time::<_, Thesis>(
                "Exact",
                atoms,
                &scene(atoms, 1),
                (Exact::default(), Fineness::Given(1)),
                0.05,
            )
            .unwrap();
            assert!(timing.totals.collisions > 0 && timing.totals.overlapping_pairs == 0, "{timing:?}");
            assert!(timing.totals.energy_drift < 1e-12);
        }
    }
}
