//! Scene files with changes from the command line; invalid entries are refused by name.

use std::{
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
};

use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use carom::{
    Scene,
    engine::{MAX_TIME, RunSpec, SceneError, StartSpec},
};
use clap::Args;

use super::{before_placement, parent::Parent, stop};
use crate::schedule::stages;
use crate::{
    foreign_frames::extended_xyz,
    invalid_entries::{InvalidEntries, refuse_all},
    measures,
    overrides::Override,
    units::units,
};

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
            let error = if is_study {
                error
            } else {
                with_unknown_keys(error, &text)
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
        let Some(parent) = parent else {
            validate(&scene)?;
            before_placement::refuse(&scene)?;
            return self.with_start(scene);
        };
        refuse_all(faults_of_rules(&scene))?;
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
/// The invalid entries in one message.
pub(crate) fn validate(scene: &Scene) -> Result<()> {
    let of_tags = stages::refuse_unknown_tags(scene, tags(scene)).err();
    refuse_all(faults_of_rules(scene).into_iter().chain(of_tags))
}

/// The faults of `[run]`, and the first of the units, of the measures and of the stages.
fn faults_of_rules(scene: &Scene) -> Vec<Error> {
    let mut faults = faults_of(&scene.run);
    faults.extend(units(scene).err());
    // The intervals of measures are compared with that of the run.
    if scene.run.sample_interval > 0.0 {
        faults.extend(measures::requests(scene).err());
    }
    faults.extend(stages::check(scene).err());
    faults
}

/// Validates `[run]`.
///
/// # Errors
/// All invalid entries in one message.
#[cfg(test)]
pub fn check(run: &RunSpec) -> Result<()> {
    refuse_all(faults_of(run))
}

/// The invalid entries of `[run]`. Those that depend on an invalid one are left out.
fn faults_of(run: &RunSpec) -> Vec<Error> {
    let intervals = [
        ("run.sample_interval", Some(run.sample_interval)),
        ("run.snapshot_interval", run.snapshot_interval),
        ("run.check_interval", run.check_interval),
    ];
    let is_positive = |time: f64| time.is_finite() && time > 0.0;
    let mut faults = Vec::new();
    for (entry, time) in [("run.until", Some(run.until))].iter().chain(&intervals) {
        let time = time.unwrap_or(1.0);
        if !is_positive(time) {
            faults.push(anyhow!(
                "{entry} must be positive and finite, but is {time:?}"
            ));
        }
    }
    if run.snapshot_interval.is_some() && run.snapshots.is_none() {
        faults.push(anyhow!(
            "run.snapshot_interval is given, but run.snapshots is not"
        ));
    }
    if is_positive(run.until) {
        faults.extend(faults_of_times(run, intervals));
    }
    faults.extend(run.stop.as_ref().and_then(|stop| stop::check(stop).err()));
    if let Some(other) = run
        .snapshots
        .as_deref()
        .filter(|&name| name != EXTENDED_XYZ)
    {
        faults.push(anyhow!(
            "run.snapshots: unknown format '{other}'; expected {EXTENDED_XYZ}"
        ));
    }
    faults
}

/// The times and intervals that do not fit the end of the run, which is positive and finite.
fn faults_of_times(run: &RunSpec, intervals: [(&str, Option<f64>); 3]) -> Vec<Error> {
    if run.until > MAX_TIME {
        return vec![anyhow!(
            "run.until must be at most {MAX_TIME:e}, but is {:?}",
            run.until
        )];
    }
    let mut faults = Vec::new();
    let is_too_short = |&interval: &f64| interval > 0.0 && run.until / interval > MAX_SAMPLES;
    for (entry, interval) in intervals {
        if let Some(interval) = interval.filter(is_too_short) {
            faults.push(anyhow!(
                "{entry} = {interval} gives more than {MAX_SAMPLES:e} samples until {}",
                run.until
            ));
        }
    }
    let measure_from = run.measure_from.time().unwrap_or(0.0);
    let is_within = |time: f64| (0.0..run.until).contains(&time);
    for (entry, time) in [
        ("run.animation_from", run.animation_from),
        ("run.measure_from", measure_from),
    ] {
        if !is_within(time) {
            faults.push(anyhow!(
                "{entry} must be from 0 to before run.until = {:?}, but is {time:?}",
                run.until
            ));
        }
    }
    let leaves_none = measure_from != 0.0 && measure_from + run.sample_interval > run.until;
    if is_within(measure_from) && leaves_none {
        faults.push(anyhow!(
            "run.measure_from = {} leaves no interval of {} before run.until = {}",
            run.measure_from,
            run.sample_interval,
            run.until
        ));
    }
    faults
}

/// The error of a text that is no scene, together with those of its other lines that have unknown
/// keys: each such line is left out, and the rest read again.
fn with_unknown_keys(first: SceneError, text: &str) -> SceneError {
    let mut lines: Vec<&str> = text.lines().collect();
    let mut faults = Vec::new();
    let mut last = first.clone();
    while let SceneError::Syntax(words) = &last {
        let Some(number) = line_of_unknown_key(words) else {
            break;
        };
        faults.push(words.trim_end().to_owned());
        // An entry over several lines cannot be left out by its first one, and the keys below a
        // header belong to it.
        let is_entry = |line: &&mut &str| {
            let is_whole = line
                .parse::<toml::Table>()
                .is_ok_and(|table| !table.is_empty());
            is_whole && !line.trim_start().starts_with('[')
        };
        let Some(line) = lines.get_mut(number - 1).filter(is_entry) else {
            break;
        };
        *line = "";
        match Scene::from_toml(&lines.join("\n")) {
            Err(error) => last = error,
            Ok(_) => break,
        }
    }
    match faults.len() {
        0 | 1 => first,
        _ => SceneError::Syntax(InvalidEntries::new(faults).to_string()),
    }
}

/// The number of the line, from 1, that an error of an unknown key names.
fn line_of_unknown_key(words: &str) -> Option<usize> {
    if !words.contains("\nunknown field `") {
        return None;
    }
    let rest = words.strip_prefix("TOML parse error at line ")?;
    rest.split(',')
        .next()?
        .parse()
        .ok()
        .filter(|&line| line > 0)
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

    #[test]
    fn several_faults_are_named_at_once() {
        let run = RunSpec {
            until: 1.0,
            sample_interval: -1.0,
            animation_from: 2.0,
            snapshots: Some("gsd".to_owned()),
            ..RunSpec::default()
        };
        let error = check(&run).unwrap_err().to_string();
        assert!(error.starts_with("3 entries are invalid:\n"), "{error}");
        for words in ["run.sample_interval", "run.animation_from", "run.snapshots"] {
            assert!(error.contains(words), "{error}");
        }
        let scene = Scene {
            run: RunSpec {
                observe: ["presure", "energy", "temprature:gas"]
                    .map(str::to_owned)
                    .into(),
                until: -1.0,
                ..RunSpec::default()
            },
            ..Scene::default()
        };
        let error = validate(&scene).unwrap_err().to_string();
        // A list without a list in it.
        assert!(
            error.starts_with("3 entries are invalid:\n- run.until"),
            "{error}"
        );
        assert_eq!(error.lines().count(), 4, "{error}");
        assert!(error.contains("`pressure`") && error.contains("`temperature`"));
    }

    #[test]
    fn all_lines_with_unknown_keys_are_named() {
        let words = |text: &str| {
            let first = Scene::from_toml(text).unwrap_err();
            with_unknown_keys(first, text).to_string()
        };
        let text = "[box]\nseeds = 3\n[[gas]]\nradius = 0.01\nmas = 1.0\nenergy = 1.0\ncount = 2\n";
        let said = words(text);
        assert!(said.contains("2 entries are invalid:"), "{said}");
        for part in [
            "line 2, column 1",
            "did you mean `seed`?",
            "line 5, column 1",
            "`mass`?",
        ] {
            assert!(said.contains(part), "{part}: {said}");
        }
        // The keys below an unknown header are none of another table.
        let said = words("[boxx]\nseed = 3\n[run]\nuntill = 1.0\n");
        assert!(
            said.contains("`boxx`") && !said.contains("seed = 3"),
            "{said}"
        );
        // An entry over two lines.
        let said = words("[box]\nside = [1.0,\n1.0]\nsed = 1\n");
        assert!(
            said.contains("`sides`?") && said.contains("`seed`?"),
            "{said}"
        );
        // One fault alone.
        let text = "[box]\nsed = 1\n";
        assert_eq!(words(text), Scene::from_toml(text).unwrap_err().to_string());
    }
}
