//! Scene files with changes from the command line; invalid entries are refused by name.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Error, Result, bail, ensure};
use carom::{
    Scene,
    engine::{RunSpec, StartSpec, did_you_mean, frame_of},
};
use clap::Args;

use super::{impulses, outcome::OBSERVERS};
use crate::{measures, overrides::Override};

/// The only supported format of snapshots.
pub const EXTENDED_XYZ: &str = "extxyz";

/// The name of the frame from which bodies start, in the folder of the run.
pub const START: &str = "start.extxyz";

/// Largest file with a frame to start from (bytes): it is read as a whole.
const LARGEST_START: u64 = 1 << 32;

/// Largest number of samples of a run; more are refused as a mistake.
const MOST_SAMPLES: f64 = 1e7;

/// Options that name a scene file and change entries of it.
#[derive(Debug, Clone, Args)]
pub struct SceneFile {
    /// The scene file
    #[arg(value_name = "SCENE.toml")]
    pub path: PathBuf,
    /// End of the run (time), instead of the scene's run.until
    #[arg(long)]
    pub until: Option<f64>,
    /// Seed of all random numbers, instead of the scene's box.seed
    #[arg(long)]
    pub seed: Option<u64>,
    /// Change an entry, such as gas.0.count=100; may be repeated
    #[arg(long = "set", value_name = "KEY.PATH=VALUE")]
    pub set: Vec<Override>,
}

impl SceneFile {
    /// Reads the scene and applies the changes from the command line.
    ///
    /// # Errors
    /// The file cannot be read or is no scene, or an entry of `[run]` or a rule of elasticity is
    /// invalid.
    pub fn read(&self) -> Result<Scene> {
        let path = self.path.display();
        let text =
            fs::read_to_string(&self.path).with_context(|| format!("cannot read the scene file {path}"))?;
        let mut scene = Scene::from_toml(&text).with_context(|| format!("scene {path}"))?;
        if !self.set.is_empty() {
            let mut table: toml::Table = text.parse().with_context(|| format!("scene {path}"))?;
            for change in &self.set {
                change.apply(&mut table)?;
            }
            scene = Scene::from_toml(&toml::to_string(&table)?)
                .with_context(|| format!("scene {path} after --set"))?;
        }
        scene.run.until = self.until.unwrap_or(scene.run.until);
        scene.bounds.seed = self.seed.unwrap_or(scene.bounds.seed);
        check(&scene.run)?;
        refuse_unknown_tags(&scene)?;
        if let Some(from) = scene.start.from.take() {
            let file = self.path.parent().unwrap_or_else(|| Path::new("")).join(&from);
            read_start(&mut scene.start, &file).with_context(|| format!("start.from: {}", file.display()))?;
        }
        Ok(scene)
    }
}

/// Reads the frame from which bodies start. Afterwards the entries are those of a scene in the
/// folder of its run, which has a copy of this frame under the name [`START`].
fn read_start(start: &mut StartSpec, file: &Path) -> Result<()> {
    let length = fs::metadata(file).context("cannot read the file")?.len();
    ensure!(length <= LARGEST_START, "the file has {length} bytes, more than {LARGEST_START}");
    let text = fs::read_to_string(file).context("cannot read the file")?;
    let frame = frame_of(&text, start.frame.take()).map_err(Error::msg)?;
    let checksum = crc32fast::hash(frame.as_bytes());
    if let Some(expected) = start.checksum {
        ensure!(
            checksum == expected,
            "the checksum of the frame is {checksum}, but `start.checksum` is {expected}"
        );
    }
    start.snapshot = Some(frame.into());
    start.from = Some(START.to_owned());
    start.checksum = Some(checksum);
    Ok(())
}

/// Refuses a rule of elasticity for a tag that no body carries: a misspelt tag would change the
/// physics.
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
                "elasticity.pair[{index}]: no body in the scene carries the tag {name:?}{}",
                did_you_mean(name, carried.iter().map(|tag| tag.as_str()))
            );
        }
    }
    Ok(())
}

/// Validates `[run]`.
pub fn check(run: &RunSpec) -> Result<()> {
    for (entry, time) in [("run.until", run.until), ("run.sample_interval", run.sample_interval)] {
        ensure!(time.is_finite() && time > 0.0, "{entry} must be positive and finite, but is {time}");
    }
    ensure!(
        run.until / run.sample_interval <= MOST_SAMPLES,
        "run.sample_interval = {} gives more than {MOST_SAMPLES:e} samples until {}",
        run.sample_interval,
        run.until
    );
    for (entry, time) in [("run.animation_from", run.animation_from), ("run.measure_from", run.measure_from)]
    {
        ensure!(
            (0.0..run.until).contains(&time),
            "{entry} must be from 0 to before run.until = {}, but is {time}",
            run.until
        );
    }
    ensure!(
        run.measure_from == 0.0 || run.measure_from + run.sample_interval <= run.until,
        "run.measure_from = {} leaves no interval of {} before run.until = {}",
        run.measure_from,
        run.sample_interval,
        run.until
    );
    for (index, name) in run.observe.iter().enumerate() {
        ensure!(!run.observe[..index].contains(name), "run.observe: '{name}' is named twice");

        if OBSERVERS.contains(&name.as_str()) {
            continue;
        }
        if impulses::is_log(name) {
            impulses::check(name)?;
            continue;
        }
        measures::check(name).with_context(|| {
            let kinds: Vec<&str> = measures::KINDS.iter().map(|kind| kind.name).collect();
            format!(
                "run.observe; expected one of {}, {}, {}",
                OBSERVERS.join(", "),
                kinds.join(", "),
                impulses::NAME
            )
        })?;
    }
    match run.snapshots.as_deref() {
        None | Some(EXTENDED_XYZ) => Ok(()),
        Some(other) => bail!("run.snapshots: unknown format '{other}'; expected {EXTENDED_XYZ}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_entries_of_run_are_refused_by_name() {
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
            (RunSpec { measure_from: 2.0 * good.until, ..good.clone() }, "run.measure_from"),
            (RunSpec { measure_from: 0.5, ..good.clone() }, "leaves no interval"),
            (RunSpec { observe: vec!["energy".to_owned(); 2], ..good.clone() }, "named twice"),
        ];
        for (run, expected) in cases {
            let error = format!("{:#}", check(&run).unwrap_err());
            assert!(error.contains(expected), "{error}");
        }
    }
}
