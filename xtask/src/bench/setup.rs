//! `cargo xtask bench setup`: times from a scene to its first contact, of a single step, and of a
//! batch of edits.

use anyhow::{Context, Result};
use carom::{
    Scene,
    engine::{GasSpec, MoleculeSpec},
};
use carom_methods::AnySimulation;
use carom_runs::print_line;
use carom_tables::Verdict;
use clap::Args;
use cpu_time::ThreadTime;

/// Options of `cargo xtask bench setup`.
#[derive(Debug, Args)]
pub struct SetupOptions {
    /// Numbers of discs, at area fraction 0.5
    #[arg(long, value_delimiter = ',', default_value = "1000,10000,100000")]
    count: Vec<usize>,
    /// Number of single steps to time
    #[arg(long, default_value_t = 20_000)]
    steps: usize,
    /// Number of bodies in a batch
    #[arg(long, default_value_t = 1000)]
    batch: usize,
}

/// Times each of the gases.
///
/// # Errors
/// A scene cannot be built or run.
pub fn run(options: &SetupOptions) -> Result<Verdict> {
    for &count in &options.count {
        print_line(&time(count, options)?);
    }
    Ok(Verdict::Passed)
}

fn time(count: usize, options: &SetupOptions) -> Result<String> {
    let text = scene(count).to_toml();
    let clock = ThreadTime::now();
    let mut simulation = AnySimulation::new(&Scene::from_toml(&text)?)?;
    let built = clock.elapsed();
    simulation.step(f64::MAX, &mut ())?;
    let first = clock.elapsed();
    let clock = ThreadTime::now();
    for _ in 0..options.steps {
        simulation.step(f64::MAX, &mut ())?;
    }
    let step = clock.elapsed() / options.steps.max(1) as u32;
    let epochs = simulation.view().counters().epochs;
    let specs = small_discs(count, options.batch);
    let clock = ThreadTime::now();
    let added = simulation.edit(|batch| {
        let added: Vec<_> = specs
            .iter()
            .filter_map(|spec| batch.add(spec).ok())
            .collect();
        for &key in &added {
            batch.tag(key, "added")?;
        }
        Ok(added)
    })?;
    let batch = clock.elapsed();
    let clock = ThreadTime::now();
    simulation.step(f64::MAX, &mut ())?;
    let begun = clock.elapsed();
    let started = simulation.view().counters().epochs - epochs;
    let last = *added.last().context("no disc of the batch found room")?;
    let clock = ThreadTime::now();
    simulation.tag(last, "last")?;
    let single = clock.elapsed();
    Ok(format!(
        "{count:>8} discs: built in {built:.2?}, first contact after {first:.2?}; a step {step:.2?} ({} epochs); \
         {} discs added and tagged in {batch:.2?}, then {started} epoch start, {begun:.2?}; one tag alone {single:.2?}",
        epochs,
        added.len(),
    ))
}

/// A gas of discs at area fraction 0.5.
fn scene(count: usize) -> Scene {
    let gas = GasSpec {
        radius: Some(((0.5 / (std::f64::consts::PI * count as f64)).sqrt()).into()),
        mass: Some(1.0.into()),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    };
    Scene {
        gas: vec![gas],
        ..Scene::default()
    }
}

/// Discs so small that about half of them find room between the others.
fn small_discs(count: usize, batch: usize) -> Vec<MoleculeSpec> {
    let disc = |number: usize| {
        let turns = number as f64 * 0.618_033_988_749_894_9;
        MoleculeSpec {
            shape: Some("disc".to_owned()),
            atom_radius: Some(1e-3 / count as f64),
            atom_mass: Some(1.0),
            at: [turns.fract(), (number as f64 + 0.5) / batch as f64],
            ..MoleculeSpec::default()
        }
    };
    (0..batch).map(disc).collect()
}
