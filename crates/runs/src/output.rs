//! The folder that a run writes into: never over an earlier run by accident, and no file half written.

use std::{
    fs::{self, File, TryLockError},
    io::{self, Write as _},
    path::{Path, PathBuf},
    thread,
    time::Duration,
};

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use serde::Serialize;

/// The file that every run writes first.
pub const MANIFEST: &str = "manifest.json";

/// What is done about a folder that has files in it already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// Nothing is written; an error says so.
    Refuse,
    /// Files of the same names are replaced, others stay.
    Replace,
    /// They are gone on with; they must be those of a run.
    Resume,
}

/// Where a run writes, and over what.
#[derive(Debug, Clone, Default, Args)]
pub struct Destination {
    /// Where to write; if not given, a folder in out/ that is named after the command and what it is given
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Replace files of an earlier run in that folder
    #[arg(long)]
    pub force: bool,
}

impl Destination {
    /// Folder to write to: what was asked for, or else `usual`.
    pub fn folder(&self, usual: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| usual.into())
    }

    /// What is done about files that are there already.
    pub fn existing(&self) -> Existing {
        if self.force { Existing::Replace } else { Existing::Refuse }
    }
}

/// Where a run writes that can be interrupted, and whether it goes on there.
#[derive(Debug, Clone, Default, Args)]
pub struct Resumption {
    /// Where to write, and over what.
    #[command(flatten)]
    pub destination: Destination,
    /// Go on with the run in that folder, from its last checkpoint; a later end, or more of something, extends one that has
    /// ended
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
}

impl Resumption {
    /// Folder to write to: what was asked for, or else `usual`.
    pub fn folder(&self, usual: &str) -> PathBuf {
        self.destination.folder(usual)
    }

    /// What is done about files that are there already.
    pub fn existing(&self) -> Existing {
        if self.resume { Existing::Resume } else { self.destination.existing() }
    }
}

/// A process that was killed while it started another (`git`, for the manifest) holds its lock until that one is under way. Fewer:
/// what was killed on a busy machine cannot be resumed at once. More: a refusal takes longer.
const LOCK_TRIES: u32 = 40;
const LOCK_PAUSE: Duration = Duration::from_millis(50);

/// An output folder.
#[derive(Debug, Clone)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Makes the folder, with all folders above it.
    ///
    /// # Errors
    /// There are files in it and `existing` says refuse, or it cannot be made.
    pub fn create(path: &Path, existing: Existing) -> Result<Self> {
        fs::create_dir_all(path).with_context(|| format!("cannot make the folder {}", path.display()))?;
        let look = || format!("cannot look into the folder {}", path.display());
        let names: Vec<_> = fs::read_dir(path)
            .and_then(|entries| entries.map(|entry| entry.map(|file| file.file_name())).collect())
            .with_context(look)?;
        match existing {
            Existing::Replace => {}
            Existing::Refuse => ensure!(
                names.is_empty(),
                "{} is not empty: choose another folder with --out, replace its files with --force, or go on with the \
                 run in it with --resume",
                path.display()
            ),
            // A run that was killed as it began has left no more than folders with nothing in them.
            Existing::Resume => ensure!(
                names.iter().any(|name| name.to_string_lossy().starts_with(MANIFEST))
                    || names.iter().all(|name| is_empty_folder(&path.join(name))),
                "{} holds no run that could be resumed: there is no {MANIFEST}",
                path.display()
            ),
        }
        Ok(Self { path: path.to_owned() })
    }

    /// Keeps other processes from writing into the folder as long as what is given lives; `None` where the system cannot.
    ///
    /// # Errors
    /// Another process writes into it.
    pub fn lock(&self) -> Result<Option<File>> {
        let Ok(folder) = File::open(&self.path) else { return Ok(None) };
        for _ in 0..LOCK_TRIES {
            match folder.try_lock() {
                Ok(()) => return Ok(Some(folder)),
                Err(TryLockError::WouldBlock) => thread::sleep(LOCK_PAUSE),
                Err(TryLockError::Error(_)) => return Ok(None),
            }
        }
        bail!("another process writes into {}: wait until it has ended", self.path.display())
    }

    /// A folder inside this one, new or not.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn inner(&self, name: &str) -> Result<Self> {
        Self::create(&self.path.join(name), Existing::Replace)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads a whole file of text.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn read(&self, name: &str) -> Result<String> {
        let path = self.path.join(name);
        fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))
    }

    /// Writes a whole file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> Result<()> {
        write_whole(&self.path.join(name), content.as_ref())
    }

    /// Writes a whole file that resuming a run relies on.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_lasting(&self, name: &str, content: impl AsRef<[u8]>) -> Result<()> {
        write_lasting(&self.path.join(name), &[content.as_ref()])
    }

    /// Writes a whole file of JSON.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_json(&self, name: &str, content: &impl Serialize) -> Result<()> {
        let mut text = serde_json::to_string_pretty(content).context("the content is no JSON")?;
        text.push('\n');
        self.write(name, text)
    }

    /// Writes a table as CSV: one header, then a record a row, numbers in their shortest exact form.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_table<R: Serialize>(
        &self,
        name: &str,
        header: &[&str],
        rows: impl IntoIterator<Item = R>,
    ) -> Result<()> {
        self.write(name, table(header, rows)?)
    }

    /// The same, where resuming a run relies on it.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_lasting_table<R: Serialize>(
        &self,
        name: &str,
        header: &[&str],
        rows: impl IntoIterator<Item = R>,
    ) -> Result<()> {
        self.write_lasting(name, table(header, rows)?)
    }
}

/// A table as CSV.
fn table<R: Serialize>(header: &[&str], rows: impl IntoIterator<Item = R>) -> Result<Vec<u8>> {
    let mut table = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    table.write_record(header)?;
    rows.into_iter().try_for_each(|row| table.serialize(row))?;
    Ok(table.into_inner()?)
}

fn is_empty_folder(path: &Path) -> bool {
    fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none())
}

/// Writes a file aside and renames it, so that nobody ever sees half of it.
///
/// # Errors
/// It cannot be written.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<()> {
    aside(path, |aside| fs::write(aside, content))
}

/// The same, and the new file is on the disk before it takes the place of an older one: not even a loss of power leaves
/// neither.
///
/// # Errors
/// It cannot be written.
pub fn write_lasting(path: &Path, pieces: &[&[u8]]) -> Result<()> {
    aside(path, |aside| {
        let mut file = File::create(aside)?;
        pieces.iter().try_for_each(|piece| file.write_all(piece))?;
        file.sync_all()
    })?;
    // The name, too, where folders can be opened; elsewhere the system sees to it.
    if let Some(Ok(folder)) = path.parent().map(File::open) {
        folder.sync_all().with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// Writes a file under another name, then renames it.
fn aside(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> Result<()> {
    let mut aside = path.as_os_str().to_owned();
    aside.push(".part");
    let aside = PathBuf::from(aside);
    let written = write(&aside).and_then(|()| fs::rename(&aside, path));
    if written.is_err() {
        // Half a file helps nobody; that it cannot be removed either is no news.
        let _ = fs::remove_file(&aside);
    }
    written.with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_with_files_is_refused_unless_they_may_be_replaced() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("new/inner");
        let folder = Folder::create(&path, Existing::Refuse).unwrap();
        assert!(Folder::create(&path, Existing::Refuse).is_ok(), "an empty folder is fine");
        folder.write("a.txt", "first").unwrap();
        let refused = Folder::create(&path, Existing::Refuse).unwrap_err().to_string();
        assert!(refused.contains("--force") && refused.contains("--resume"), "{refused}");
        let refused = Folder::create(&path, Existing::Resume).unwrap_err().to_string();
        assert!(refused.contains("manifest.json"), "{refused}");
        Folder::create(&path, Existing::Replace).unwrap().write("a.txt", "second").unwrap();
        assert_eq!(fs::read_to_string(path.join("a.txt")).unwrap(), "second");
        assert_eq!(fs::read_dir(&path).unwrap().count(), 1, "nothing is left aside");
    }

    #[test]
    fn one_process_at_a_time_writes_into_a_folder() {
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let first = folder.lock().unwrap();
        if first.is_some() {
            assert!(folder.lock().unwrap_err().to_string().contains("another process"));
        }
        drop(first);
        assert!(folder.lock().is_ok());
    }

    #[test]
    fn numbers_in_tables_keep_every_digit() {
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let values = [0.1 + 0.2, 1e-300, -0.0, 1.0 / 3.0];
        folder.write_table("t.csv", &["i", "x"], values.iter().enumerate()).unwrap();
        let text = fs::read_to_string(root.path().join("t.csv")).unwrap();
        let read: Vec<f64> =
            text.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect();
        assert_eq!(read.map_bits(), values.to_vec().map_bits());
    }

    trait Bits {
        fn map_bits(self) -> Vec<u64>;
    }

    impl Bits for Vec<f64> {
        fn map_bits(self) -> Vec<u64> {
            self.into_iter().map(f64::to_bits).collect()
        }
    }
}
