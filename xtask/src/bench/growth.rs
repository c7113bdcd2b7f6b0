//! `cargo xtask bench growth`: processor time to grow gases of many shapes to high densities.

use std::f64::consts::PI;

use anyhow::{Result, ensure};
use carom::{
    Scene,
    engine::{AtomSpec, GasSpec, Growth, Quantity, StartSpec},
};
use carom_runs::print_line;
use carom_tables::Verdict;
use clap::Args;
use cpu_time::ThreadTime;

/// Options of `cargo xtask bench growth`.
#[derive(Debug, Args)]
pub struct GrowthOptions {
    /// Run only gases whose name begins with this; default: all
    #[arg(long, default_value = "")]
    gas: String,
    /// Number of molecules
    #[arg(long, default_value_t = 1000)]
    count: usize,
    /// Number of seeds
    #[arg(long, default_value_t = 5)]
    seeds: u64,
    /// Area fraction, instead of that of each gas
    #[arg(long)]
    area_fraction: Option<f64>,
    /// Relaxation after growth (collisions a molecule)
    #[arg(long, default_value_t = 0.0)]
    relax: f64,
}

/// A gas to be grown, with the time that it may take at 1000 molecules (seconds).
struct Goal {
    name: &'static str,
    shapes: &'static [&'static str],
    area_fraction: f64,
    seconds: f64,
}

const GOALS: [Goal; 9] = [
    Goal {
        name: "dumbbell",
        shapes: &["dumbbell"],
        area_fraction: 0.84,
        seconds: 5.0,
    },
    Goal {
        name: "tee",
        shapes: &["tee"],
        area_fraction: 0.67,
        seconds: 5.0,
    },
    Goal {
        name: "cross",
        shapes: &["cross"],
        area_fraction: 0.68,
        seconds: 5.0,
    },
    Goal {
        name: "corner",
        shapes: &["corner"],
        area_fraction: 0.75,
        seconds: 5.0,
    },
    Goal {
        name: "ring:8",
        shapes: &["ring:8"],
        area_fraction: 0.57,
        seconds: 5.0,
    },
    Goal {
        name: "rod:4",
        shapes: &["rod:4"],
        area_fraction: 0.78,
        seconds: 15.0,
    },
    Goal {
        name: "rod:8",
        shapes: &["rod:8"],
        area_fraction: 0.70,
        seconds: 20.0,
    },
    Goal {
        name: "discs",
        shapes: &["discs"],
        area_fraction: 0.84,
        seconds: 2.0,
    },
    Goal {
        name: "mixture",
        shapes: &["disc", "dumbbell", "tee", "rod:8", "ring:8"],
        area_fraction: 0.62,
        seconds: 10.0,
    },
];

/// Grows each of the gases with each seed.
///
/// # Errors
/// A gas jams, or its molecules overlap.
pub fn run(options: &GrowthOptions) -> Result<Verdict> {
    let mut verdict = Verdict::Passed;
    for goal in GOALS
        .iter()
        .filter(|goal| goal.name.starts_with(&options.gas))
    {
        let mut times = Vec::new();
        let mut rows = Vec::new();
        for seed in 1..=options.seeds {
            let scene = scene(goal, options, seed);
            let clock = ThreadTime::now();
            let mut growth = Growth::new(&scene)?;
            let mut steps = 0;
            while !growth.is_done() {
                growth.step()?;
                steps += 1;
            }
            let progress = growth.progress();
            let simulation = growth.finish()?;
            times.push(clock.elapsed().as_secs_f64());
            let overlaps = simulation.view().overlaps();
            ensure!(overlaps.pairs == 0, "{}: {overlaps:?}", goal.name);
            rows.push((steps, progress));
        }
        let [least, most] =
            [f64::min, f64::max].map(|of| times.iter().copied().reduce(of).unwrap_or(0.0));
        // Ten times the molecules may take twelve times the time.
        let allowed = goal.seconds * (options.count as f64 / 1000.0).powf(12f64.log10());
        let (steps, progress) = rows[0];
        print_line(&format!(
            "{:<9} {:>6} molecules at {:.4}: {least:>6.2} to {most:>6.2} s of {allowed:>5.1} s; first seed: {steps:>5} \
             steps, {:>5.0} collisions a molecule",
            goal.name,
            molecules(options, goal),
            progress.area_fraction,
            2.0 * progress.collisions as f64 / molecules(options, goal) as f64,
        ));
        if most > allowed && options.relax == 0.0 && options.area_fraction.is_none() {
            verdict = Verdict::Failed;
        }
    }
    Ok(verdict)
}

/// Number of molecules: a multiple of the number of kinds.
fn molecules(options: &GrowthOptions, goal: &Goal) -> usize {
    options.count / gases(goal).len() * gases(goal).len()
}

/// The gases of a goal, with atoms of radius 1.
fn gases(goal: &Goal) -> Vec<GasSpec> {
    let named = |shape: &str, radius: f64| GasSpec {
        shape: Some(shape.to_owned()),
        atom_radius: Some(radius.into()),
        atom_mass: Some(1.0.into()),
        energy: 1.0,
        ..GasSpec::default()
    };
    let of = |&shape: &&str| match shape {
        // Ten sizes from 0.7 to 1.3.
        "discs" => (0..10)
            .map(|size| named("disc", 0.73 + 0.06 * f64::from(size)))
            .collect(),
        // Three touching discs around a right angle.
        "corner" => {
            let atom = |x, y| AtomSpec {
                at: [x, y],
                radius: 1.0,
                mass: 1.0,
            };
            let atoms = vec![atom(0.0, 0.0), atom(2.0, 0.0), atom(0.0, 2.0)];
            vec![GasSpec {
                atoms,
                energy: 1.0,
                ..GasSpec::default()
            }]
        }
        shape => vec![named(shape, 1.0)],
    };
    goal.shapes.iter().flat_map(of).collect()
}

/// Equal numbers of molecules of each kind in a square box.
fn scene(goal: &Goal, options: &GrowthOptions, seed: u64) -> Scene {
    let mut gas = gases(goal);
    let each = options.count / gas.len();
    for gas in &mut gas {
        gas.count = Some(each);
    }
    let atoms = |gas: &GasSpec| -> f64 {
        let name = gas.shape.as_deref().unwrap_or("rod:3");
        let shape = name
            .parse::<carom::geometry::Shape>()
            .map(|shape| shape.atoms(1.0, 1.0));
        let count = shape
            .ok()
            .and_then(Result::ok)
            .map_or(0, |atoms| atoms.len());
        count as f64
            * gas
                .atom_radius
                .as_ref()
                .and_then(Quantity::number)
                .unwrap_or(1.0)
                .powi(2)
    };
    let area = PI * each as f64 * gas.iter().map(atoms).sum::<f64>();
    let side = (area / options.area_fraction.unwrap_or(goal.area_fraction)).sqrt();
    let start = StartSpec {
        relax: Some(options.relax),
        ..StartSpec::default()
    };
    let mut scene = Scene {
        gas,
        start,
        ..Scene::default()
    };
    (scene.bounds.sides, scene.bounds.seed) = ([side; 2], seed);
    scene
}
