//! The triangular lattice near close packing, in a box that fits it.

use std::f64::consts::PI;

use anyhow::{Context, Result};
use carom::{Observer, Pressure, Scene};

use super::{
    Effort, Engine, ExtremeCase, ExtremeFinding,
    bodies::disc,
    engine::{directions, in_box},
    watch::{Watch, run_collisions},
};

/// The cases of lattices of discs.
pub fn cases() -> Vec<ExtremeCase> {
    vec![ExtremeCase {
        id: "7.16",
        name: "triangular lattice at packing fractions 0.9068 and 0.90689, random velocities",
        must: "overlap below 1e-13 σ; pressure within 2 % of the free-volume law",
        run: dense,
    }]
}

/// Discs in a row, and number of rows.
const GRID: [usize; 2] = [16, 18];

/// Discs of diameter 1 on a triangular lattice in a box that fits it, with free area `dilation` =
/// A/A₀ − 1.
pub fn close_packed(dilation: f64) -> Scene {
    let spacing = (1.0 + dilation).sqrt();
    let [columns, rows] = GRID;
    let step = [spacing, spacing * 0.75f64.sqrt()];
    let mut velocities: Vec<_> = directions().take(columns * rows).collect();
    let drift = velocities.iter().sum::<glam::DVec2>() / velocities.len() as f64;
    for velocity in &mut velocities {
        *velocity -= drift;
    }
    let site = |k: usize| {
        let (column, row) = (k % columns, k / columns);
        [
            step[0] * (column as f64 + 0.25 + 0.5 * (row % 2) as f64),
            step[1] * (row as f64 + 0.25),
        ]
    };
    let discs = velocities
        .iter()
        .enumerate()
        .map(|(k, v)| disc(0.5, 1.0, site(k), v.to_array()))
        .collect();
    in_box([step[0] * columns as f64, step[1] * rows as f64], discs)
}

/// Results of a lattice run.
pub struct Packed {
    /// Deepest overlap, in units of the diameter.
    pub deepest: f64,
    /// Number of overlapping pairs.
    pub overlapping: usize,
    /// Relative error of the pressure.
    pub pressure: f64,
    /// Relative change of the energy.
    pub energy: f64,
    /// Contacts reported earlier than the previous contact.
    pub backwards: usize,
}

/// Runs the lattice for `collisions` contacts and compares the pressure with Z = 2/α + 1.90 (Alder,
/// Hoover and Young, J. Chem. Phys. 49 (1968) 3688). With the centre of mass of N discs at rest the
/// contacts contribute a share of 1 − 1/N.
///
/// # Errors
/// The scene cannot be built or run.
pub fn packed(engine: Engine, dilation: f64, collisions: u64) -> Result<Packed> {
    let scene = close_packed(dilation);
    let mut run = engine.simulate(&scene)?;
    let mut both = (Pressure::default(), Watch::default());
    let (mut deepest, mut overlapping) = (0.0f64, 0);
    // Equilibration.
    run_collisions(&mut run, collisions / 4, &mut (), |_| {})?;
    both.0.start(&run.view());
    run_collisions(&mut run, collisions, &mut both, |run| {
        let overlaps = run.view().overlaps();
        deepest = deepest.max(overlaps.deepest_length);
        overlapping = overlapping.max(overlaps.pairs);
    })?;
    both.0.sample(&run.view());
    let view = run.view();
    let point = both.0.series().last().context("there is one interval")?;
    let area = view.bounds().area();
    // N (1 − 1/N) kT.
    let thermal = view.centre_of_mass_frame().thermal(view.bodies());
    let found = 1.0 + point.virial * area / thermal.translation;
    let law = 2.0 / dilation + 1.90;
    let energy = (view.energy() / view.ledger().initial - 1.0).abs();
    Ok(Packed {
        deepest,
        overlapping,
        pressure: (found / law - 1.0).abs(),
        energy,
        backwards: both.1.backwards,
    })
}

fn dense(engine: Engine, effort: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut findings = Vec::new();
    for fraction in [0.9068, 0.906_89] {
        let dilation = PI / (2.0 * 3f64.sqrt()) / fraction - 1.0;
        let seen = packed(engine, dilation, effort.collisions.max(20_000))?;
        let name = format!("at {fraction}");
        findings.extend([
            ExtremeFinding::new(format!("{name}: deepest overlap (σ)"), seen.deepest, 1e-13),
            ExtremeFinding::never(format!("{name}: overlapping pairs"), seen.overlapping),
            ExtremeFinding::new(
                format!("{name}: relative deviation of the pressure"),
                seen.pressure,
                0.02,
            ),
            ExtremeFinding::new(
                format!("{name}: energy drift, relative"),
                seen.energy,
                1e-12,
            ),
            ExtremeFinding::never(
                format!("{name}: collisions out of time order"),
                seen.backwards,
            ),
        ]);
    }
    Ok(findings)
}
