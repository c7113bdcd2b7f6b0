//! Mutated files in the folders of runs and sweeps, and mutated inputs: every command refuses them,
//! or ends with an answer without NaN; none panics, is killed by the system, or runs without end.
//!
//! `cargo xtask fuzz files` mutates scenes, encounters and checkpoints for the readers themselves;
//! here whole commands read them, with all other files around.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use anyhow::{Context, Result, ensure};
use carom_runs::checkpoint_file::{self, CheckpointBody};
use serde::{Deserialize, Serialize};

use super::{
    campaign::{Attack, report},
    folder,
    process::{LIMIT, Process, ProcessEnd},
    targets::{OUT, TargetPlace},
};
use crate::fuzz::{
    files::mutate,
    random::{FuzzDraw, case_seed},
    subject::{Failure, Report, Subject, read_toml, write_toml},
};

/// Processor time of a command that runs no scene; more is a hang.
const MAX_PROCESSOR_TIME: Duration = Duration::from_secs(10);

/// Time after which a scene that runs is ended by SIGTERM: a mutated scene may be long.
const LONG_RUN: Duration = Duration::from_millis(700);

/// Time for a command to end after SIGTERM. It promises a second; the machine may be busy.
const LAST_WORDS: Duration = Duration::from_secs(20);

/// The attack.
#[derive(Debug, Default)]
pub struct Files {
    /// Folder of the place of a case, if it is kept.
    kept: Option<PathBuf>,
    templates: Mutex<BTreeMap<World, Arc<TargetPlace>>>,
}

/// The files around the mutated one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum World {
    /// Two finished runs, and inputs of all kinds.
    Runs,
    /// A finished sweep, and its two shards.
    Sweeps,
}

/// A mutated file and the command that reads it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MutatedFile {
    world: World,
    /// The command.
    words: String,
    /// Path of the mutated file.
    file: String,
    /// Whether the file gets a header with a correct checksum.
    has_checksum: bool,
    /// Its content if it is text.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    text: Option<String>,
    /// Its content if it is not, in hexadecimal digits.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    bytes: Option<String>,
}

/// Files, and the commands that read them. A `*` in the path stands for any characters, and `POINT`
/// in a command for the folder of a point.
const READERS: [(World, &str, &[&str]); 16] = [
    (
        World::Runs,
        "scene.toml",
        &["check scene.toml", "run scene.toml --out new"],
    ),
    (
        World::Runs,
        "sides.toml",
        &["check sides.toml", "run sides.toml --out new"],
    ),
    (
        World::Runs,
        "study.toml",
        &[
            "sweep study.toml --slurm --out new",
            "sweep study.toml --out new",
        ],
    ),
    (
        World::Runs,
        "from.extxyz",
        &[
            "run from.toml --out new",
            "check from.toml",
            "convert from.extxyz a.gsd",
        ],
    ),
    (
        World::Runs,
        "out/trajectory.extxyz",
        &[
            "convert out/trajectory.extxyz a.gsd",
            "convert out/trajectory.extxyz a.lammpstrj",
        ],
    ),
    (
        World::Runs,
        "encounters.csv",
        &[
            "detect encounters.csv --out answers.csv",
            "detect encounters.csv --explain generic/0 --out a.svg",
        ],
    ),
    (
        World::Runs,
        "out/checkpoint",
        &[
            "run scene.toml --out out --resume",
            "run start.toml --from out --out new",
            "report out",
        ],
    ),
    (
        World::Runs,
        "out/sums",
        &["merge out out-2 --out new", "report out"],
    ),
    (World::Runs, "out-2/sums", &["merge out out-2 --out new"]),
    (
        World::Runs,
        "out/*",
        &[
            "report out",
            "run scene.toml --out out --resume",
            "merge out out-2 --out new",
            "run start.toml --from out --out new",
        ],
    ),
    (
        World::Runs,
        "molecule.toml",
        &["billiard molecule.toml --hits 10000 --out new"],
    ),
    (
        World::Sweeps,
        "out/points/*.record",
        &["sweep study.toml --out out", "merge out --out new"],
    ),
    (
        World::Sweeps,
        "out/points/*",
        &[
            "sweep study.toml --out out",
            "report POINT",
            "merge out --out new",
        ],
    ),
    (
        World::Sweeps,
        "out/*",
        &[
            "sweep study.toml --out out",
            "report out",
            "merge out --out new",
        ],
    ),
    (
        World::Sweeps,
        "shard-1/*",
        &["merge shard-1 shard-2 --out new"],
    ),
    (
        World::Sweeps,
        "shard-1/*.json",
        &["merge shard-1 shard-2 --out new"],
    ),
];

/// Further inputs.
const MOLECULE: &str = "atoms = [\n  { at = [0.0, 0.0], radius = 0.01, mass = 1.0 },\n  \
                        { at = [0.02, 0.0], radius = 0.012, mass = 2.0 },\n]\n";
const FROM: &str = "[start]\nfrom = \"from.extxyz\"\n[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\n\
                    energy = 1.0\ncount = 30\n[run]\nuntil = 0.2\nsample_interval = 0.1\nobserve = [\"energy\"]\n";
const START: &str =
    "[run]\nuntil = 0.2\nsample_interval = 0.1\nobserve = [\"energy\", \"pressure\"]\n";
const STUDY: &str = include_str!("inputs/study.toml");
const SIDES: &str = include_str!("inputs/sides.toml");

impl World {
    /// Runs the commands that make the files.
    fn build(self) -> Result<TargetPlace> {
        let place = TargetPlace::new(None)?;
        match self {
            Self::Runs => {
                place.write("molecule.toml", MOLECULE.as_bytes())?;
                place.write("start.toml", START.as_bytes())?;
                place.write("sides.toml", SIDES.as_bytes())?;
                let snapshots = FROM.replace("[start]\nfrom = \"from.extxyz\"\n", "")
                    + "snapshots = \"extxyz\"\n";
                place.write("from.toml", snapshots.as_bytes())?;
                place.complete("run from.toml --out first --no-price")?;
                fs::copy(
                    place.path("first/trajectory.extxyz"),
                    place.path("from.extxyz"),
                )
                .context("the first run has no trajectory")?;
                place.write("from.toml", FROM.as_bytes())?;
                let scene = fs::read_to_string(place.path("scene.toml"))
                    .context("cannot read the scene")?;
                place.write(
                    "scene.toml",
                    scene.replace("until = 10.0", "until = 1.0").as_bytes(),
                )?;
                place.complete("run scene.toml --out out")?;
                place.complete("run scene.toml --out out-2 --seed 9")?;
                let root =
                    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/encounters.csv");
                let encounters = fs::read_to_string(&root).context("cannot read the encounters")?;
                let few: Vec<&str> = encounters
                    .lines()
                    .enumerate()
                    .filter(|(index, line)| index % 40 == 0 || line.starts_with("generic,0,"))
                    .map(|(_, line)| line)
                    .collect();
                place.write("encounters.csv", (few.join("\n") + "\n").as_bytes())?;
            }
            Self::Sweeps => {
                place.write(
                    "study.toml",
                    STUDY.replace("until = 20.0", "until = 0.5").as_bytes(),
                )?;
                for words in [
                    "--out out",
                    "--shard 1/2 --out shard-1",
                    "--shard 2/2 --out shard-2",
                ] {
                    place.complete(&format!("sweep study.toml {words}"))?;
                }
            }
        }
        Ok(place)
    }
}

impl MutatedFile {
    fn content(&self) -> Result<Vec<u8>> {
        let Some(digits) = &self.bytes else {
            return Ok(self.text.clone().unwrap_or_default().into_bytes());
        };
        ensure!(
            digits.is_ascii() && digits.len() % 2 == 0,
            "bytes have two hexadecimal digits each"
        );
        let byte = |at| u8::from_str_radix(&digits[at..at + 2], 16).context("no hexadecimal digit");
        (0..digits.len()).step_by(2).map(byte).collect()
    }

    fn with_content(mut self, content: Vec<u8>) -> Self {
        use std::fmt::Write as _;
        let hexadecimal = |bytes: &[u8]| {
            bytes.iter().fold(String::new(), |mut digits, byte| {
                // Writing to a string cannot fail.
                let _ = write!(digits, "{byte:02x}");
                digits
            })
        };
        (self.text, self.bytes) = match String::from_utf8(content) {
            Ok(text) if !self.has_checksum => (Some(text), None),
            Ok(text) => (None, Some(hexadecimal(text.as_bytes()))),
            Err(error) => (None, Some(hexadecimal(error.as_bytes()))),
        };
        self
    }

    /// Whether the command may run a scene, which may be long.
    fn runs_scene(&self) -> bool {
        let words = &self.words;
        let is_script = words.contains("--slurm");
        words.starts_with("run")
            || words.starts_with("sweep") && !is_script
            || words.starts_with("billiard")
    }
}

impl Files {
    /// The place of each case is the folder `kept`, if given, and else a temporary folder.
    pub fn new(kept: Option<PathBuf>) -> Self {
        Self {
            kept,
            templates: Mutex::default(),
        }
    }

    fn template(&self, world: World) -> Result<Arc<TargetPlace>> {
        let mut templates = self
            .templates
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(place) = templates.get(&world) {
            return Ok(Arc::clone(place));
        }
        let place = Arc::new(world.build()?);
        templates.insert(world, Arc::clone(&place));
        Ok(place)
    }

    fn draw_case(&self, draw: &mut FuzzDraw) -> Result<MutatedFile> {
        let (world, pattern, commands) = draw.one_of(&READERS);
        let template = self.template(world)?;
        let root = template.path("");
        let name = |path: &Path| {
            path.strip_prefix(&root)
                .unwrap_or(path)
                .display()
                .to_string()
        };
        let matching = |file: &String| match pattern.split_once('*') {
            Some((begin, end)) => file.starts_with(begin) && file.ends_with(end),
            None => file == pattern,
        };
        let files: Vec<String> = folder::files(&root)?
            .iter()
            .map(|path| name(path))
            .filter(matching)
            .collect();
        ensure!(!files.is_empty(), "no file is called {pattern}");
        let file = files[draw.index(files.len())].clone();
        let point = Path::new(&file)
            .parent()
            .map(|folder| folder.display().to_string())
            .unwrap_or_default();
        let words = draw.one_of(commands).replace("POINT", &point);
        let path = template.path(&file);
        let framed = CheckpointBody::read(&path)
            .ok()
            .filter(|_| draw.happens(0.8));
        let has_checksum = framed.is_some();
        let sound = match framed {
            Some(body) => body.rest().to_vec(),
            None => fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?,
        };
        let case = MutatedFile {
            world,
            words,
            file,
            has_checksum,
            text: None,
            bytes: None,
        };
        Ok(case.with_content(mutated(draw, &sound)))
    }

    fn attack(&self, case: &MutatedFile) -> Result<Option<Failure>> {
        let template = self.template(case.world)?;
        let place = TargetPlace::new(self.kept.as_deref())?;
        folder::copy(&template.path(""), &place.path(""))?;
        let content = case.content()?;
        if case.has_checksum {
            checkpoint_file::write(&place.path(&case.file), &[&content])?;
        } else {
            place.write(&case.file, &content)?;
        }
        let before = tables(&place)?;
        let ended = run(&place, case)?;
        if !ended.is_orderly() {
            let kind = if ended.code.is_none() { "hang" } else { "end" };
            return Ok(Some(Failure::new(kind, format!("{case}: {ended}"))));
        }
        if ended.code != Some(0) {
            return Ok(None);
        }
        let after = tables(&place)?;
        let spoilt = after
            .iter()
            .find(|(name, table)| before.get(*name) != Some(table) && has_nan(table));
        Ok(spoilt.map(|(name, _)| Failure::new("NaN", format!("{case}: NaN in {name}"))))
    }
}

/// A mutated content: text by its structure, anything else by bytes and numbers.
fn mutated(draw: &mut FuzzDraw, sound: &[u8]) -> Vec<u8> {
    match std::str::from_utf8(sound) {
        _ if draw.happens(0.03) => vec![],
        Ok(text) if !text.is_empty() => mutate::text(draw, text),
        _ if draw.happens(0.5) => with_forged_number(draw, sound),
        _ => (0..draw.integer(1, 3)).fold(sound.to_vec(), |bytes, _| mutate::bytes(draw, &bytes)),
    }
}

/// The next ordinary number from a random place on becomes an extraordinary one.
fn with_forged_number(draw: &mut FuzzDraw, sound: &[u8]) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    let begin = draw.index(bytes.len().max(1));
    let number = |bytes: &[u8]| <[u8; 8]>::try_from(bytes).map_or(0.0, f64::from_le_bytes);
    let ordinary = |bytes: &[u8]| (1e-9..1e9).contains(&number(bytes).abs());
    if let Some(place) = bytes[begin..].windows(8).position(ordinary) {
        let forged = draw.one_of(&[f64::NAN, f64::INFINITY, -1.0, 0.0, 1e-300, 1e300]);
        bytes[begin + place..begin + place + 8].copy_from_slice(&forged.to_le_bytes());
    }
    bytes
}

/// Runs the command. `None` as its exit code is a hang.
fn run(place: &TargetPlace, case: &MutatedFile) -> Result<ProcessEnd> {
    let mut process = place.start(&case.words, "said")?;
    if case.runs_scene() {
        if process.wait_for(LONG_RUN)?.is_none() {
            process.signal("TERM");
        }
        return process.end(LAST_WORDS);
    }
    end_within_processor_time(process)
}

fn end_within_processor_time(mut process: Process) -> Result<ProcessEnd> {
    let begun = Instant::now();
    while process.wait_for(Duration::from_millis(200))?.is_none() {
        let used = process.processor_time().unwrap_or_else(|| begun.elapsed());
        if used > MAX_PROCESSOR_TIME || begun.elapsed() > LIMIT {
            return process.end(Duration::ZERO);
        }
    }
    process.end(LIMIT)
}

/// The tables in the folders of results.
fn tables(place: &TargetPlace) -> Result<BTreeMap<String, Vec<u8>>> {
    let mut tables = BTreeMap::new();
    for name in [OUT, "new"] {
        let folder = place.path(name);
        if folder.is_dir() {
            for path in folder::files(&folder)? {
                if path.extension().is_some_and(|ending| ending == "csv") {
                    let table = fs::read(&path)
                        .with_context(|| format!("cannot read {}", path.display()))?;
                    tables.insert(
                        path.strip_prefix(place.path(""))
                            .unwrap_or(&path)
                            .display()
                            .to_string(),
                        table,
                    );
                }
            }
        }
    }
    Ok(tables)
}

fn has_nan(table: &[u8]) -> bool {
    let text = String::from_utf8_lossy(table);
    text.split([',', '\n'])
        .any(|field| field.parse::<f64>().is_ok_and(f64::is_nan))
}

impl std::fmt::Display for MutatedFile {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            formatter,
            "carom {} with a mutated {}",
            self.words, self.file
        )
    }
}

impl Subject for Files {
    type Case = MutatedFile;
    const COMMAND: &'static str = "attack --kinds";
    const NAME: &'static str = "files";
    const TIME_LIMIT: u64 = 600;

    fn draw(&self, seed: u64) -> MutatedFile {
        self.draw_case(&mut FuzzDraw::new(seed))
            .expect("the files are made by undisturbed commands")
    }

    fn check(&self, case: &MutatedFile) -> Report {
        report(self.attack(case))
    }

    fn simpler(&self, case: &MutatedFile) -> Vec<MutatedFile> {
        let Some(text) = &case.text else {
            return vec![];
        };
        let smaller = mutate::with_less_text(text.as_bytes()).into_iter();
        smaller
            .map(|content| case.clone().with_content(content))
            .collect()
    }

    fn write(&self, case: &MutatedFile) -> (String, Vec<u8>) {
        write_toml(case)
    }

    fn read(&self, ending: &str, bytes: &[u8]) -> Result<MutatedFile> {
        read_toml(ending, bytes)
    }
}

impl Attack for Files {
    const FULL: u64 = 26_000;

    fn cases(&self, seed: u64, count: u64) -> Result<Vec<MutatedFile>> {
        (0..count)
            .map(|index| self.draw_case(&mut FuzzDraw::new(case_seed(seed, index))))
            .collect()
    }

    fn row(&self, case: &MutatedFile) -> (String, u64) {
        let command: Vec<&str> = case.words.split_whitespace().take(1).collect();
        (command.concat(), 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_of_all_kinds_are_written_and_read() {
        for (has_checksum, content) in [
            (false, &b"a = 1\n"[..]),
            (false, &[0xff, 0x00]),
            (true, b"text"),
        ] {
            let case = MutatedFile {
                world: World::Runs,
                words: "report out".to_owned(),
                file: "out/sums".to_owned(),
                has_checksum,
                text: None,
                bytes: None,
            };
            let case = case.with_content(content.to_vec());
            let files = Files::default();
            let (ending, bytes) = files.write(&case);
            let read = files.read(&ending, &bytes).unwrap();
            assert_eq!(read, case);
            assert_eq!(read.content().unwrap(), content);
        }
    }

    #[test]
    fn a_number_among_bytes_is_forged() {
        let sound = [&[0; 5][..], &0.1f64.to_le_bytes(), &[0; 3]].concat();
        let is_forged = |seed| with_forged_number(&mut FuzzDraw::new(seed), &sound) != sound;
        assert!((0..20).any(is_forged));
        assert_eq!(
            with_forged_number(&mut FuzzDraw::new(1), &[]),
            Vec::<u8>::new()
        );
    }

    #[test]
    fn a_table_with_nan_is_found() {
        assert!(has_nan(b"time,x\n1,NaN\n") && !has_nan(b"time,nano\n1,2\n"));
    }
}
