//! The commands under attack, and the undisturbed results of each.

use std::{
    collections::BTreeMap,
    env, fs,
    path::{Path, PathBuf},
    process::Command,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use anyhow::{Context, Result, ensure};
use tempfile::TempDir;

use super::{
    folder::{self, FileContents},
    process::{LIMIT, Process, ProcessEnd, carom},
};

/// The folder of results.
pub const OUT: &str = "out";

/// A command that writes the folder [`OUT`].
#[derive(Debug)]
pub struct Target {
    /// Its name in tables and files.
    pub name: &'static str,
    /// Commands that are run undisturbed before.
    before: &'static [&'static str],
    /// The command.
    pub start: &'static str,
    /// The command that continues or repeats it after a disturbance.
    pub again: &'static str,
    /// Whether its results are the same each time; otherwise it is checked only that files are
    /// whole.
    is_repeatable: bool,
}

impl Target {
    const fn new(name: &'static str, start: &'static str, again: &'static str) -> Self {
        Self {
            name,
            before: &[],
            start,
            again,
            is_repeatable: true,
        }
    }
}

/// All targets.
pub const TARGETS: [Target; 11] = [
    Target::new(
        "run",
        "run scene.toml --out out --checkpoint-every 0.01",
        "run scene.toml --out out --checkpoint-every 0.01 --resume",
    ),
    Target::new(
        "tiles",
        "run tiles.toml --out out --threads 4 --checkpoint-every 0.02",
        "run tiles.toml --out out --threads 4 --checkpoint-every 0.02 --resume",
    ),
    Target::new(
        "growth",
        "run grown.toml --out out --checkpoint-every 0.01",
        "run grown.toml --out out --checkpoint-every 0.01 --resume",
    ),
    Target::new(
        "sweep",
        "sweep study.toml --out out --threads 2 --checkpoint-every 0.01",
        "sweep study.toml --out out --threads 2 --checkpoint-every 0.01",
    ),
    Target::new(
        "shard",
        "sweep study.toml --shard 1/2 --out out --threads 1 --checkpoint-every 0.01",
        "sweep study.toml --shard 1/2 --out out --threads 1 --checkpoint-every 0.01",
    ),
    Target {
        before: &[
            "sweep study.toml --shard 1/2 --out shard-1",
            "sweep study.toml --shard 2/2 --out shard-2",
        ],
        ..Target::new(
            "merge of sweeps",
            "merge shard-1 shard-2 --out out",
            "merge shard-1 shard-2 --out out --force",
        )
    },
    Target {
        before: &[
            "run short.toml --out run-1",
            "run short.toml --seed 9 --out run-2",
        ],
        ..Target::new(
            "merge of runs",
            "merge run-1 run-2 --out out",
            "merge run-1 run-2 --out out --force",
        )
    },
    Target::new(
        "billiard",
        "billiard dumbbell --atom-radius 0.02 --hits 40000 --out out",
        "billiard dumbbell --atom-radius 0.02 --hits 40000 --out out --resume",
    ),
    Target::new(
        "brownian",
        "brownian tee --atom-radius 0.02 --gas-radius 0.04 --side 1 --area-fraction 0.2 --from 0.5 \
         --until 10 --out out --checkpoint-every 0.01",
        "brownian tee --atom-radius 0.02 --gas-radius 0.04 --side 1 --area-fraction 0.2 --from 0.5 \
         --until 10 --out out --checkpoint-every 0.01 --resume",
    ),
    Target::new(
        "page",
        "run short.toml --out out --set run.until=0.2",
        "run short.toml --out out --set run.until=0.2 --resume",
    ),
    Target {
        is_repeatable: false,
        ..Target::new(
            "trade",
            "trade short.toml --minutes 0.01 --out out",
            "trade short.toml --minutes 0.01 --out out --force",
        )
    },
];

/// The target of a name.
///
/// # Errors
/// There is none.
pub fn target(name: &str) -> Result<&'static Target> {
    TARGETS
        .iter()
        .find(|target| target.name == name)
        .with_context(|| format!("there is no target '{name}'"))
}

/// Files from which the targets start.
const INPUTS: [(&str, &str); 5] = [
    ("scene.toml", include_str!("inputs/scene.toml")),
    ("short.toml", include_str!("inputs/short.toml")),
    ("tiles.toml", include_str!("inputs/tiles.toml")),
    ("grown.toml", include_str!("inputs/grown.toml")),
    ("study.toml", include_str!("inputs/study.toml")),
];

/// A folder in which commands are run.
#[derive(Debug)]
pub struct TargetPlace {
    program: PathBuf,
    folder: PathBuf,
    /// Removed at the end, unless the folder is kept.
    _temporary: Option<TempDir>,
}

impl TargetPlace {
    /// A folder with the input files; `kept` is its path if it is kept.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn new(kept: Option<&Path>) -> Result<Self> {
        let program = env::current_exe().context("cannot find this program")?;
        let (folder, temporary) = if let Some(folder) = kept {
            // What an earlier replay has left.
            let _ = fs::remove_dir_all(folder);
            (folder.to_owned(), None)
        } else {
            let temporary = tempfile::Builder::new().prefix("carom-attack-").tempdir();
            let temporary = temporary.context("cannot create a temporary folder")?;
            (temporary.path().to_owned(), Some(temporary))
        };
        fs::create_dir_all(&folder)
            .with_context(|| format!("cannot create {}", folder.display()))?;
        let folder = folder
            .canonicalize()
            .context("the folder of the attack has no path")?;
        let place = Self {
            program,
            folder,
            _temporary: temporary,
        };
        for (name, text) in INPUTS {
            place.write(name, text.as_bytes())?;
        }
        Ok(place)
    }

    /// Path of a file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes a file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<()> {
        let path = self.path(name);
        fs::write(&path, content).with_context(|| format!("cannot write {}", path.display()))
    }

    /// The command `carom` with these words.
    pub fn command(&self, words: &str) -> Command {
        carom(&self.program, &self.folder, words)
    }

    /// Starts `carom`. `said` is the name of the file for its output.
    ///
    /// # Errors
    /// It cannot be started.
    pub fn start(&self, words: &str, said: &str) -> Result<Process> {
        Process::start(self.command(words), self.path(said))
    }

    /// Runs `carom` to its end.
    ///
    /// # Errors
    /// It cannot be started.
    pub fn run(&self, words: &str) -> Result<ProcessEnd> {
        self.start(words, "said")?.end(LIMIT)
    }

    /// Runs `carom` to its end, which must be a success.
    ///
    /// # Errors
    /// It fails.
    pub fn complete(&self, words: &str) -> Result<()> {
        let ended = self.run(words)?;
        ensure!(ended.code == Some(0), "carom {words}: {ended}");
        Ok(())
    }
}

/// The undisturbed run of a target.
#[derive(Debug)]
pub struct Reference {
    /// Its folder, with the results of the commands before.
    template: TargetPlace,
    /// Its results.
    pub contents: FileContents,
    /// Its wall time.
    pub duration: Duration,
}

/// Undisturbed runs, each made when it is first needed.
#[derive(Debug, Default)]
pub struct References {
    known: Mutex<BTreeMap<&'static str, Arc<Reference>>>,
    kept: Option<PathBuf>,
}

impl References {
    /// No undisturbed run has been made. The place of each case is the folder `kept`, if given, and
    /// else a temporary folder.
    pub fn new(kept: Option<PathBuf>) -> Self {
        Self {
            known: Mutex::default(),
            kept,
        }
    }

    /// The undisturbed run of a target.
    ///
    /// # Errors
    /// It fails, or leaves a torn file.
    pub fn reference(&self, target: &Target) -> Result<Arc<Reference>> {
        // Held meanwhile, so that no run is made twice.
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(reference) = known.get(target.name) {
            return Ok(Arc::clone(reference));
        }
        let template = TargetPlace::new(None)?;
        for words in target.before {
            template.complete(words)?;
        }
        let begun = Instant::now();
        template.complete(target.start)?;
        let duration = begun.elapsed();
        let out = template.path(OUT);
        let contents = folder::contents(&out)?;
        if let Some(fault) = folder::damage(&out)? {
            anyhow::bail!("the undisturbed '{}' leaves {fault}", target.name);
        }
        fs::remove_dir_all(&out).with_context(|| format!("cannot remove {}", out.display()))?;
        let reference = Arc::new(Reference {
            template,
            contents,
            duration,
        });
        known.insert(target.name, Arc::clone(&reference));
        Ok(reference)
    }

    /// A place in which a target can be started.
    ///
    /// # Errors
    /// It cannot be written, or the undisturbed run fails.
    pub fn place(&self, target: &Target) -> Result<TargetPlace> {
        let reference = self.reference(target)?;
        let place = TargetPlace::new(self.kept.as_deref())?;
        for words in target.before {
            let name = words.rsplit_once("--out ").map_or(OUT, |(_, name)| name);
            folder::copy(&reference.template.path(name), &place.path(name))?;
        }
        Ok(place)
    }

    /// Continues a disturbed target to its end and compares its folder with that of an undisturbed
    /// run. Returns the difference in words.
    ///
    /// # Errors
    /// The program cannot be started, or a file cannot be read.
    pub fn finish(&self, target: &Target, place: &TargetPlace) -> Result<Option<String>> {
        let mut ended = place.run(target.again)?;
        if ended.code == Some(2) {
            // What was ended before it had written anything is started anew.
            let words = ended.to_string();
            ended = place.run(target.start)?;
            if ended.code != Some(0) {
                return Ok(Some(format!(
                    "it can be neither resumed nor started: {words}; {ended}"
                )));
            }
        }
        if ended.code != Some(0) {
            return Ok(Some(format!("the last process ends with {ended}")));
        }
        self.compare(target, place)
    }

    /// Compares a finished folder with that of an undisturbed run.
    ///
    /// # Errors
    /// A file cannot be read, or the undisturbed run fails.
    pub fn compare(&self, target: &Target, place: &TargetPlace) -> Result<Option<String>> {
        let out = place.path(OUT);
        if let Some(fault) = folder::damage(&out)? {
            return Ok(Some(fault));
        }
        if !target.is_repeatable {
            return Ok(None);
        }
        let expected = &self.reference(target)?.contents;
        Ok(folder::difference(&folder::contents(&out)?, expected))
    }
}
