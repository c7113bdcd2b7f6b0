//! Losses of power: the process is killed at a call of the file system, and what was not flushed to
//! disk is taken away; then the run continues to the bytes of an undisturbed one.

use std::{
    collections::BTreeMap,
    fs::{self, OpenOptions},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use super::{
    campaign::{Attack, report},
    faults::calls,
    preload::{CallStep, Journal, Library},
    process::{LIMIT, Process},
    targets::{References, target},
};
use crate::fuzz::{
    random::{FuzzDraw, case_seed},
    subject::{Failure, Report, Subject, read_toml, write_toml},
};

/// The attack.
#[derive(Debug)]
pub struct Power {
    /// Undisturbed runs.
    pub references: References,
    /// The library that records what is flushed.
    pub library: Library,
}

/// A target that loses power some times, and then runs to its end.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PowerCase {
    target: String,
    losses: Vec<Loss>,
}

/// A loss of power.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Loss {
    /// Number of the call before which it happens; after the end, if there are fewer calls.
    call: u64,
    /// What is lost.
    what: Lost,
    /// Seed of what is lost.
    seed: u64,
}

/// What is lost of files that have not been flushed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Lost {
    /// Nothing: the process is killed.
    Nothing,
    /// All bytes after the last flush.
    Bytes,
    /// A random part of these bytes.
    Tails,
    /// All these bytes, and a random part of the new names in folders that were not flushed.
    BytesAndNames,
}

/// Targets that lose power.
const TARGETS: [&str; 8] = [
    "run",
    "page",
    "sweep",
    "shard",
    "merge of sweeps",
    "merge of runs",
    "billiard",
    "growth",
];

/// The disk as it would be found, from the record of a process.
#[derive(Debug, Default, PartialEq, Eq)]
struct Disk {
    /// Files with bytes that are not flushed, and how many are.
    flushed: BTreeMap<PathBuf, u64>,
    /// Renames whose folder is not flushed.
    renames: Vec<(PathBuf, PathBuf, Option<PathBuf>)>,
}

impl Disk {
    fn after(steps: &[CallStep]) -> Self {
        let mut disk = Self::default();
        // Lengths of files at their last flush; others were on disk before.
        let mut lengths: BTreeMap<PathBuf, u64> = BTreeMap::new();
        for step in steps {
            match step {
                CallStep::Open(path) => {
                    lengths.insert(path.clone(), 0);
                    disk.flushed.insert(path.clone(), 0);
                }
                CallStep::Write(path) => {
                    let length = lengths.get(path).copied().unwrap_or(u64::MAX);
                    // Files that the process has found were flushed long ago; see `Truncate`.
                    if length < u64::MAX {
                        disk.flushed.insert(path.clone(), length);
                    }
                }
                CallStep::Truncate(path, bytes) => {
                    let length = lengths.get(path).map_or(*bytes, |known| *known.min(bytes));
                    lengths.insert(path.clone(), length);
                }
                CallStep::Sync(path, bytes) => {
                    lengths.insert(path.clone(), *bytes);
                    disk.flushed.remove(path);
                }
                CallStep::SyncFolder(folder) => {
                    disk.renames
                        .retain(|(_, to, _)| to.parent() != Some(folder));
                }
                CallStep::Rename { from, to, replaced } => {
                    disk.flushed.remove(to);
                    lengths.remove(to);
                    if let Some(length) = disk.flushed.remove(from) {
                        disk.flushed.insert(to.clone(), length);
                    }
                    if let Some(length) = lengths.remove(from) {
                        lengths.insert(to.clone(), length);
                    }
                    disk.renames
                        .push((from.clone(), to.clone(), replaced.clone()));
                }
                CallStep::Remove(path) => {
                    disk.flushed.remove(path);
                    lengths.remove(path);
                }
                CallStep::MakeFolder => {}
            }
        }
        disk
    }

    /// Takes away what is lost.
    fn lose(&self, loss: &Loss) -> Result<()> {
        let draw = &mut FuzzDraw::new(loss.seed);
        if loss.what == Lost::Nothing {
            return Ok(());
        }
        for (path, flushed) in &self.flushed {
            let Ok(file) = OpenOptions::new().write(true).open(path) else {
                continue;
            };
            let cannot = || format!("cannot cut {}", path.display());
            let length = file.metadata().with_context(cannot)?.len();
            let lost = length.saturating_sub(*flushed);
            let kept = if loss.what == Lost::Tails {
                draw.between(0.0, lost as f64) as u64
            } else {
                0
            };
            file.set_len(length.min(flushed + kept))
                .with_context(cannot)?;
        }
        if loss.what == Lost::BytesAndNames {
            for (from, to, replaced) in self.renames.iter().rev() {
                if draw.happens(0.5) {
                    undo(from, to, replaced.as_deref())?;
                }
            }
        }
        Ok(())
    }
}

/// Undoes a rename; one whose file is gone, or has been replaced again, stays.
fn undo(from: &Path, to: &Path, replaced: Option<&Path>) -> Result<()> {
    if !to.exists() || from.exists() {
        return Ok(());
    }
    let cannot = || format!("cannot undo the renaming of {}", to.display());
    fs::rename(to, from).with_context(cannot)?;
    if let Some(replaced) = replaced {
        fs::rename(replaced, to).with_context(cannot)?;
    }
    Ok(())
}

impl PowerCase {
    /// A case of one of several targets, each with its number of calls.
    fn draw(draw: &mut FuzzDraw, targets: &[(&str, u64)]) -> Self {
        let (name, calls) = draw.one_of(targets);
        let loss = |draw: &mut FuzzDraw| Loss {
            // Also after the end, when pages and tables may still be in memory only.
            call: if draw.happens(0.15) {
                calls + 1000
            } else {
                draw.integer(1, calls as i64) as u64
            },
            what: draw.one_of(&[
                Lost::Nothing,
                Lost::Bytes,
                Lost::Bytes,
                Lost::Tails,
                Lost::BytesAndNames,
            ]),
            seed: draw.bits() >> 1,
        };
        let number = if draw.happens(0.7) { 1 } else { 2 };
        let losses = (0..number).map(|_| loss(draw)).collect();
        Self {
            target: name.to_owned(),
            losses,
        }
    }
}

impl Power {
    fn attack(&self, case: &PowerCase) -> Result<Option<Failure>> {
        let target = target(&case.target)?;
        let place = self.references.place(target)?;
        let failure = |words: String| Ok(Some(Failure::new(target.name, words)));
        for (index, loss) in case.losses.iter().enumerate() {
            let mut command = place.command(if index == 0 {
                target.start
            } else {
                target.again
            });
            self.library
                .disturb(&mut command, &place.path(""), loss.call, "KILL");
            let ended = Process::start(command, place.path("said"))?.end(LIMIT)?;
            let journal = Journal::read(&place.path(""))?;
            Disk::after(&journal.steps).lose(loss)?;
            match ended.code {
                Some(0 | 137) => {}
                // What was ended before it had written anything is started anew.
                Some(2) => break,
                _ => return failure(format!("after {index} losses it ends with {ended}")),
            }
        }
        match self.references.finish(target, &place)? {
            Some(words) => failure(words),
            None => Ok(None),
        }
    }
}

impl Subject for Power {
    type Case = PowerCase;
    const COMMAND: &'static str = "attack --kinds";
    const NAME: &'static str = "power";
    const TIME_LIMIT: u64 = 600;

    fn draw(&self, seed: u64) -> PowerCase {
        PowerCase::draw(&mut FuzzDraw::new(seed), &[("page", 100)])
    }

    fn check(&self, case: &PowerCase) -> Report {
        report(self.attack(case))
    }

    fn simpler(&self, case: &PowerCase) -> Vec<PowerCase> {
        let without = |index: usize| {
            let mut less = case.clone();
            less.losses.remove(index);
            less
        };
        if case.losses.len() < 2 {
            vec![]
        } else {
            (0..case.losses.len()).map(without).collect()
        }
    }

    fn write(&self, case: &PowerCase) -> (String, Vec<u8>) {
        write_toml(case)
    }

    fn read(&self, ending: &str, bytes: &[u8]) -> Result<PowerCase> {
        read_toml(ending, bytes)
    }
}

impl Attack for Power {
    const FULL: u64 = 1000;

    fn cases(&self, seed: u64, count: u64) -> Result<Vec<PowerCase>> {
        let mut targets = Vec::new();
        for name in TARGETS {
            targets.push((name, calls(&self.library, &self.references, target(name)?)?));
        }
        let case = |index| PowerCase::draw(&mut FuzzDraw::new(case_seed(seed, index)), &targets);
        Ok((0..count).map(case).collect())
    }

    fn row(&self, case: &PowerCase) -> (String, u64) {
        (case.target.clone(), case.losses.len() as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loss(what: Lost) -> Loss {
        Loss {
            call: 1,
            what,
            seed: 1,
        }
    }

    #[test]
    fn bytes_after_the_last_flush_are_lost() {
        let root = tempfile::tempdir().unwrap();
        let path = |name: &str| root.path().join(name);
        for name in ["flushed", "series", "page"] {
            fs::write(path(name), "0123456789").unwrap();
        }
        let steps = [
            CallStep::Open(path("flushed.part")),
            CallStep::Write(path("flushed.part")),
            CallStep::Sync(path("flushed.part"), 10),
            CallStep::Rename {
                from: path("flushed.part"),
                to: path("flushed"),
                replaced: None,
            },
            CallStep::Open(path("series")),
            CallStep::Write(path("series")),
            CallStep::Sync(path("series"), 4),
            CallStep::Write(path("series")),
            CallStep::Open(path("page.part")),
            CallStep::Write(path("page.part")),
            CallStep::Rename {
                from: path("page.part"),
                to: path("page"),
                replaced: None,
            },
        ];
        Disk::after(&steps).lose(&loss(Lost::Bytes)).unwrap();
        let length = |name: &str| fs::metadata(path(name)).unwrap().len();
        assert_eq!(["flushed", "series", "page"].map(length), [10, 4, 0]);
    }

    #[test]
    fn names_in_folders_that_are_not_flushed_may_be_lost() {
        let root = tempfile::tempdir().unwrap();
        let path = |name: &str| root.path().join(name);
        fs::write(path("a"), "new").unwrap();
        fs::write(path("old"), "old").unwrap();
        undo(&path("a.part"), &path("a"), Some(&path("old"))).unwrap();
        let read = |name: &str| fs::read_to_string(path(name)).unwrap();
        assert_eq!(
            (read("a"), read("a.part")),
            ("old".to_owned(), "new".to_owned())
        );
        let rename = CallStep::Rename {
            from: path("b.part"),
            to: path("b"),
            replaced: None,
        };
        assert_eq!(Disk::after(std::slice::from_ref(&rename)).renames.len(), 1);
        let flush = CallStep::SyncFolder(root.path().to_owned());
        assert!(Disk::after(&[rename, flush]).renames.is_empty());
    }
}
