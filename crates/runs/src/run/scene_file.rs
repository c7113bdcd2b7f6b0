//! Scene files with changes from the command line; invalid entries are refused by name.

use std::{
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
};

use anyhow::{Context, Error, Result, bail, ensure};
use carom::{
    Scene,
    engine::{MAX_TIME, RunSpec, StartSpec},
};
use clap::Args;

use super::{before_placement, parent::Parent, stop};
use crate::schedule::stages;
use crate::{foreign_frames::extended_xyz, measures, overrides::Override, units::units};

/// The only supported format of snapshots.
pub const EXTENDED_XYZ: &str = "extxyz";

/// The name of the frame from which bodies start, in the folder of the run.
pub const START: &str = "start.extxyz";

/// Largest file with a frame to start from (bytes): it is read as a whole.
const MAX_START: u64 = 1 << 32;

/// Largest number of samples of a run; more are refused as a mistake.
pub(super) const MAX_SAMPLES: f64 = 1e7;

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
    /// Start from the end, or the last checkpoint, of the run in that folder, under the rules of
    /// this scene; its contents of the box are those of that run
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// Change an entry, such as gas.0.count=100; may be repeated
    #[arg(long = "set", value_name = "KEY.PATH=VALUE")]
    pub set: Vec<Override>,
}

impl SceneFile {
    /// Reads the scene and applies the changes from the command line. The contents of the box come
    /// from `parent`, if there is one.
    ///
    /// # Errors
    /// The file cannot be read or is no scene, or an entry of `[run]` or a rule of elasticity is
    /// invalid.
    pub fn read(&self, parent: Option<&Parent>) -> Result<Scene> {
        let path = self.path.display();
        let text = match fs::read_to_string(&self.path) {
            Err(error) if error.kind() == ErrorKind::InvalidData => {
                bail!("cannot read the scene file {path}: it is not a text file")
            }
            Err(_) if self.path.is_dir() => bail!(
                "{path} is a folder, and no scene file: the scene of a run is config.toml in its folder"
            ),
            text => text.with_context(|| format!("cannot read the scene file {path}"))?,
        };
        let mut scene = Scene::from_toml(&text).map_err(|error| {
            let is_study = text
                .parse::<toml::Table>()
                .is_ok_and(|table| ["scene", "vary"].iter().any(|key| table.contains_key(*key)));
            let hint = if is_study {
                " (this is a study of many scenes: `carom sweep` runs it)"
            } else {
                ""
            };
            Error::new(error).context(format!("scene {path}{hint}"))
        })?;
        if !self.set.is_empty() || parent.is_some() {
            let mut table: toml::Table = text.parse().with_context(|| format!("scene {path}"))?;
            for change in &self.set {
                change.apply(&mut table).context("--set")?;
            }
            if let Some(parent) = parent {
                parent.complete(&mut table)?;
            }
            scene = Scene::from_toml(&toml::to_string(&table)?)
                .with_context(|| format!("scene {path} after --set or --from"))?;
        }
        if let Some(until) = self.until {
            scene.run.until = until;
            // A new end of the run is the end of its last stage.
            if let Some(last) = scene.stage.last_mut() {
                last.until = until;
            }
        }
        scene.bounds.seed = self.seed.unwrap_or(scene.bounds.seed);
        check(&scene.run)?;
        units(&scene)?;
        measures::requests(&scene)?;
        stages::check(&scene)?;
        let Some(parent) = parent else {
            stages::refuse_unknown_tags(&scene, tags(&scene))?;
            before_placement::refuse(&scene)?;
            return self.with_start(scene);
        };
        // The bodies come from that run, not from the file from which it may have started.
        parent.refuse_other_contents(&scene)?;
        Ok(scene)
    }

    /// Reads the frame from which the bodies of a scene start, if it names one.
    fn with_start(&self, mut scene: Scene) -> Result<Scene> {
        if let Some(from) = scene.start.from.take() {
            let file = self
                .path
                .parent()
                .unwrap_or_else(|| Path::new(""))
                .join(&from);
            read_start(&mut scene.start, &file)
                .with_context(|| format!("start.from: {}", file.display()))?;
        }
        Ok(scene)
    }
}

/// Reads the frame from which bodies start. Afterwards the entries are those of a scene in the
/// folder of its run, which has a copy of this frame under the name [`START`].
fn read_start(start: &mut StartSpec, file: &Path) -> Result<()> {
    let length = fs::metadata(file).context("cannot read the file")?.len();
    ensure!(
        length <= MAX_START,
        "the file has {length} bytes, more than {MAX_START}"
    );
    let bytes = fs::read(file).context("cannot read the file")?;
    let frame = extended_xyz(&bytes, start.frame.take())?;
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

/// The tags that bodies carry at the start.
pub(super) fn tags(scene: &Scene) -> impl Iterator<Item = String> {
    let molecules = scene.molecule.iter().map(|entry| &entry.tags);
    let bumpers = scene.bumper.iter().map(|entry| &entry.tags);
    let walls = scene.wall_tags();
    let gases = scene.gas.iter().map(|entry| &entry.tags);
    molecules
        .chain(bumpers)
        .chain(walls)
        .chain(gases)
        .flatten()
        .cloned()
}

/// Validates `[run]`, the measures and the stages of a scene that starts from its own bodies.
///
/// # Errors
/// The first invalid entry.
pub(crate) fn validate(scene: &Scene) -> Result<()> {
    check(&scene.run)?;
    units(scene)?;
    measures::requests(scene)?;
    stages::check(scene)?;
    stages::refuse_unknown_tags(scene, tags(scene))
}

/// Validates `[run]`.
pub fn check(run: &RunSpec) -> Result<()> {
    let intervals = [
        ("run.sample_interval", Some(run.sample_interval)),
        ("run.snapshot_interval", run.snapshot_interval),
        ("run.check_interval", run.check_interval),
    ];
    for (entry, time) in [("run.until", Some(run.until))].iter().chain(&intervals) {
        let time = time.unwrap_or(1.0);
        ensure!(
            time.is_finite() && time > 0.0,
            "{entry} must be positive and finite, but is {time:?}"
        );
    }
    ensure!(
        run.until <= MAX_TIME,
        "run.until must be at most {MAX_TIME:e}, but is {:?}",
        run.until
    );
    for (entry, interval) in intervals {
        let interval = interval.unwrap_or(run.sample_interval);
        ensure!(
            run.until / interval <= MAX_SAMPLES,
            "{entry} = {interval} gives more than {MAX_SAMPLES:e} samples until {}",
            run.until
        );
    }
    ensure!(
        run.snapshot_interval.is_none() || run.snapshots.is_some(),
        "run.snapshot_interval is given, but run.snapshots is not"
    );
    let measure_from = run.measure_from.time().unwrap_or(0.0);
    for (entry, time) in [
        ("run.animation_from", run.animation_from),
        ("run.measure_from", measure_from),
    ] {
        ensure!(
            (0.0..run.until).contains(&time),
            "{entry} must be from 0 to before run.until = {:?}, but is {time:?}",
            run.until
        );
    }
    ensure!(
        measure_from == 0.0 || measure_from + run.sample_interval <= run.until,
        "run.measure_from = {} leaves no interval of {} before run.until = {}",
        run.measure_from,
        run.sample_interval,
        run.until
    );
    run.stop.as_ref().map_or(Ok(()), stop::check)?;
    match run.snapshots.as_deref() {
        None | Some(EXTENDED_XYZ) => Ok(()),
        Some(other) => bail!("run.snapshots: unknown format '{other}'; expected {EXTENDED_XYZ}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::too_many_lines, reason = "one table of refusals")]
    fn invalid_entries_of_run_are_refused_by_name() {
        let good = RunSpec {
            observe: vec!["energy".to_owned()],
            ..RunSpec::default()
        };
        assert!(check(&good).is_ok());
        let cases = [
            (
                RunSpec {
                    until: 0.0,
                    ..good.clone()
                },
                "run.until",
            ),
            (
                RunSpec {
                    until: f64::NAN,
                    ..good.clone()
                },
                "run.until",
            ),
            (
                RunSpec {
                    until: f64::INFINITY,
                    ..good.clone()
                },
                "run.until must be positive and finite",
            ),
            (
                RunSpec {
                    until: -1.0,
                    ..good.clone()
                },
                "run.until must be positive",
            ),
            (
                RunSpec {
                    until: 1e308,
                    sample_interval: 1e307,
                    ..good.clone()
                },
                "run.until must be at most 1e300, but is 1e308",
            ),
            (
                RunSpec {
                    sample_interval: -1.0,
                    ..good.clone()
                },
                "run.sample_interval",
            ),
            (
                RunSpec {
                    sample_interval: 1e-9,
                    ..good.clone()
                },
                "samples",
            ),
            (
                RunSpec {
                    snapshots: Some("gsd".to_owned()),
                    ..good.clone()
                },
                "extxyz",
            ),
            (
                RunSpec {
                    animation_from: -0.5,
                    ..good.clone()
                },
                "run.animation_from",
            ),
            (
                RunSpec {
                    animation_from: good.until,
                    ..good.clone()
                },
                "run.animation_from",
            ),
            (
                RunSpec {
                    animation_from: f64::NAN,
                    ..good.clone()
                },
                "run.animation_from",
            ),
            (
                RunSpec {
                    measure_from: (2.0 * good.until).into(),
                    ..good.clone()
                },
                "run.measure_from",
            ),
            (
                RunSpec {
                    measure_from: 0.5.into(),
                    ..good.clone()
                },
                "leaves no interval",
            ),
        ];
        for (run, expected) in cases {
            let error = format!("{:#}", check(&run).unwrap_err());
            assert!(error.contains(expected), "{error}");
        }
    }
}
