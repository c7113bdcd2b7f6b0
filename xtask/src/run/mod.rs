//! `cargo xtask run`: any scene, with what its `[run]` asks for.

mod gas;
mod outcome;

use std::{fs, path::PathBuf};

use anyhow::{Context, Result, bail, ensure};
use carom::{Scene, Simulation, engine::RunSpec};
use clap::Args;
use outcome::{OBSERVERS, simulate};

use crate::{
    interruption::Signals,
    manifest::Manifest,
    output::Folder,
    overrides::Override,
    resumable::{Choices, Task, without_end},
    sampling_times::sampling_times,
    summary::Verdict,
};

/// Choices of `cargo xtask run`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// The scene file
    #[arg(value_name = "SCENE.toml")]
    pub scene: PathBuf,
    /// When to end (time), instead of the scene's run.until
    #[arg(long)]
    pub until: Option<f64>,
    /// Seed of all random numbers, instead of the scene's box.seed
    #[arg(long)]
    pub seed: Option<u64>,
    /// An entry to change, such as gas.0.count=100; may be given often
    #[arg(long = "set", value_name = "KEY.PATH=VALUE")]
    pub set: Vec<Override>,
    /// Folders that are there already, and checkpoints
    #[command(flatten)]
    pub choices: Choices,
}

/// The only format of snapshots.
const EXTENDED_XYZ: &str = "extxyz";

/// More samples than this are taken for a slip of the pen.
const MOST_SAMPLES: f64 = 1e7;

/// Runs a scene and writes its folder.
///
/// # Errors
/// A scene that makes no sense, a folder that is not empty, a run that cannot go on.
pub fn run(options: &Options) -> Result<Verdict> {
    let scene = scene(options)?;
    check(&scene.run)?;
    refuse_unknown_tags(&scene)?;
    // Built before anything is written: a scene that cannot be leaves no folder.
    let simulation = Simulation::new(&scene).with_context(|| format!("scene {}", options.scene.display()))?;
    let asked = gas::observers(&scene.run, &simulation.view())?;
    let signals = Signals::watch()?;
    let folder = Folder::create(&folder_path(options), options.choices.resumption.existing())?;
    let _alone = folder.lock()?;
    let command = format!("cargo xtask run {}", folder.path().join("config.toml").display());
    let task = Task {
        folder: &folder,
        what: without_end("cargo xtask run", &scene),
        until: scene.run.until,
        samples: sampling_times(0.0, scene.run.until, scene.run.sample_interval).count(),
        choices: &options.choices,
        signals: &signals,
    };
    let found = task.find()?;
    let manifest = Manifest::begin(&folder, &command, &[&scene])?;
    folder.write("config.toml", scene.to_toml())?;
    let outcome = simulate(&task, found, simulation, &scene.run, asked)?;
    let summary = outcome.summary(options);
    folder.write("report.html", outcome.page(&folder, &summary, &scene, &command)?)?;
    folder.write_json("summary.json", &summary)?;
    manifest.complete(&folder, summary.totals.cpu_seconds())?;
    crate::conclude(&folder, &summary);
    Ok(summary.verdict())
}

/// Refuses a rule of elasticity for a tag that nothing in the scene carries: in a file that is run as it stands it is a
/// slip that would change the physics.
fn refuse_unknown_tags(scene: &Scene) -> Result<()> {
    let molecules = scene.molecule.iter().map(|entry| &entry.tags);
    let bumpers = scene.bumper.iter().map(|entry| &entry.tags);
    let walls = scene.wall.iter().map(|entry| &entry.tags);
    let gases = scene.gas.iter().map(|entry| &entry.tags);
    let carried: Vec<&String> = molecules.chain(bumpers).chain(walls).chain(gases).flatten().collect();
    for (index, rule) in scene.elasticity.pair.iter().enumerate() {
        for name in &rule.between {
            ensure!(
                carried.contains(&name),
                "elasticity.pair[{index}]: nothing in the scene carries the tag {name:?}"
            );
        }
    }
    Ok(())
}

/// The scene file with what the command line changes.
fn scene(options: &Options) -> Result<Scene> {
    let path = options.scene.display();
    let text =
        fs::read_to_string(&options.scene).with_context(|| format!("cannot read the scene file {path}"))?;
    let mut scene = Scene::from_toml(&text).with_context(|| format!("scene {path}"))?;
    if !options.set.is_empty() {
        let mut table: toml::Table = text.parse().with_context(|| format!("scene {path}"))?;
        for change in &options.set {
            change.apply(&mut table)?;
        }
        scene = Scene::from_toml(&toml::to_string(&table)?)
            .with_context(|| format!("scene {path} after --set"))?;
    }
    scene.run.until = options.until.unwrap_or(scene.run.until);
    scene.bounds.seed = options.seed.unwrap_or(scene.bounds.seed);
    Ok(scene)
}

/// Refuses what `[run]` cannot mean.
fn check(run: &RunSpec) -> Result<()> {
    for (entry, time) in [("run.until", run.until), ("run.sample_interval", run.sample_interval)] {
        ensure!(time.is_finite() && time > 0.0, "{entry} must be positive and finite, but is {time}");
    }
    ensure!(
        run.until / run.sample_interval <= MOST_SAMPLES,
        "run.sample_interval = {} makes more than {MOST_SAMPLES:e} samples until {}",
        run.sample_interval,
        run.until
    );
    ensure!(
        (0.0..run.until).contains(&run.animation_from),
        "run.animation_from must be from 0 to before run.until = {}, but is {}",
        run.until,
        run.animation_from
    );
    for name in &run.observe {
        if !OBSERVERS.contains(&name.as_str()) {
            gas::check(name).with_context(|| {
                format!("run.observe; known are {}, {}", OBSERVERS.join(", "), gas::OBSERVERS.join(", "))
            })?;
        }
    }
    match run.snapshots.as_deref() {
        None | Some(EXTENDED_XYZ) => Ok(()),
        Some(other) => bail!("run.snapshots: '{other}' is not known; known is {EXTENDED_XYZ}"),
    }
}

fn folder_path(options: &Options) -> PathBuf {
    let name = options.scene.file_stem().unwrap_or_else(|| "scene".as_ref()).to_string_lossy();
    options.choices.resumption.folder(&format!("out/run-{name}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_run_cannot_mean_is_refused_by_name() {
        let good = RunSpec { observe: vec!["energy".to_owned()], ..RunSpec::default() };
        assert!(check(&good).is_ok());
        let cases = [
            (RunSpec { until: 0.0, ..good.clone() }, "run.until"),
            (RunSpec { until: f64::NAN, ..good.clone() }, "run.until"),
            (RunSpec { sample_interval: -1.0, ..good.clone() }, "run.sample_interval"),
            (RunSpec { sample_interval: 1e-9, ..good.clone() }, "samples"),
            (RunSpec { observe: vec!["colour".to_owned()], ..good.clone() }, "collision-rate"),
            (RunSpec { snapshots: Some("gsd".to_owned()), ..good.clone() }, "extxyz"),
            (RunSpec { animation_from: -0.5, ..good.clone() }, "run.animation_from"),
            (RunSpec { animation_from: good.until, ..good.clone() }, "run.animation_from"),
            (RunSpec { animation_from: f64::NAN, ..good.clone() }, "run.animation_from"),
        ];
        for (run, said) in cases {
            let error = format!("{:#}", check(&run).unwrap_err());
            assert!(error.contains(said), "{error}");
        }
    }
}
