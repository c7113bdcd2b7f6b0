//! The output folder of a run: an earlier run is not overwritten by accident, and every file is
//! complete.

use std::{
    fs::{self, File, TryLockError},
    io::{self, BufWriter, Write as _},
    path::{Path, PathBuf},
    thread,
    time::Duration,
};

use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use clap::Args;
use serde::Serialize;

/// The file that every run writes first.
pub const MANIFEST: &str = "manifest.json";

/// Treatment of a folder that already holds files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// An error is returned and nothing is written.
    Refuse,
    /// Files of the same names are replaced; others remain.
    Replace,
    /// The run in the folder is continued; it is an error if there is none.
    Resume,
}

/// Output folder and its treatment.
#[derive(Debug, Clone, Default, Args)]
pub struct Destination {
    /// Output folder; default: a folder in out/ named after the command and its arguments
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Replace files of an earlier run in that folder
    #[arg(long)]
    pub force: bool,
}

impl Destination {
    /// Returns the output folder: the option `--out`, or else `usual`.
    pub fn folder(&self, usual: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| usual.into())
    }

    /// Treatment of existing files.
    pub fn existing(&self) -> Existing {
        if self.force { Existing::Replace } else { Existing::Refuse }
    }

    /// Refuses a folder that holds files, before a long preparation; creates nothing.
    ///
    /// # Errors
    /// The folder is not empty, and files are not to be replaced.
    pub fn check(&self, usual: &str) -> Result<()> {
        let path = self.folder(usual);
        let has_files = fs::read_dir(&path).is_ok_and(|mut entries| entries.next().is_some());
        if has_files && !self.force { Err(not_empty(&path)) } else { Ok(()) }
    }
}

/// The error of a folder with files.
fn not_empty(path: &Path) -> Error {
    anyhow!(
        "{} is not empty: choose another folder with --out, replace its files with --force, or resume the run in it \
         with --resume",
        path.display()
    )
}

/// Output folder of a run that can be resumed.
#[derive(Debug, Clone, Default, Args)]
pub struct Resumption {
    /// Output folder and its treatment.
    #[command(flatten)]
    pub destination: Destination,
    /// Resume the run in that folder from its last checkpoint; a later end, or more work, extends a
    /// run that has ended
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
}

impl Resumption {
    /// Returns the output folder: the option `--out`, or else `usual`.
    pub fn folder(&self, usual: &str) -> PathBuf {
        self.destination.folder(usual)
    }

    /// Treatment of existing files.
    pub fn existing(&self) -> Existing {
        if self.resume { Existing::Resume } else { self.destination.existing() }
    }
}

/// Attempts to lock the folder. A killed process may have started a child (`git`, for the manifest)
/// that holds the lock until it has executed. Fewer: on a busy machine a run cannot be resumed
/// immediately after a kill. More: a refusal takes longer.
const LOCK_TRIES: u32 = 40;
const LOCK_PAUSE: Duration = Duration::from_millis(50);

/// An output folder.
#[derive(Debug, Clone)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Creates the folder and its parents.
    ///
    /// # Errors
    /// It cannot be created, or it holds files and `existing` is [`Existing::Refuse`].
    pub fn create(path: &Path, existing: Existing) -> Result<Self> {
        fs::create_dir_all(path).with_context(|| format!("cannot create the folder {}", path.display()))?;
        let context = || format!("cannot read the folder {}", path.display());
        let names: Vec<_> = fs::read_dir(path)
            .and_then(|entries| entries.map(|entry| entry.map(|file| file.file_name())).collect())
            .with_context(context)?;
        match existing {
            Existing::Replace => {}
            Existing::Refuse if names.is_empty() => {}
            Existing::Refuse => return Err(not_empty(path)),
            // A run killed at its beginning leaves only empty folders.
            Existing::Resume => ensure!(
                names.iter().any(|name| name.to_string_lossy().starts_with(MANIFEST))
                    || names.iter().all(|name| is_empty_folder(&path.join(name))),
                "{} holds no run to resume: it has no {MANIFEST}",
                path.display()
            ),
        }
        Ok(Self { path: path.to_owned() })
    }

    /// Locks the folder against other processes until the returned file is dropped; `None` where
    /// the system has no locks.
    ///
    /// # Errors
    /// Another process holds the lock.
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

    /// Returns a folder inside this one and creates it if necessary.
    ///
    /// # Errors
    /// It cannot be created.
    pub fn inner(&self, name: &str) -> Result<Self> {
        Self::create(&self.path.join(name), Existing::Replace)
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads a whole text file.
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

    /// Writes a whole file that a resumed run reads.
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
        let mut text =
            serde_json::to_string_pretty(content).context("the content cannot be encoded as JSON")?;
        text.push('\n');
        self.write(name, text)
    }

    /// Writes a table as CSV: a header, then one record a row, numbers in their shortest exact
    /// form.
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

    /// Writes a table as CSV whose rows have named fields, which are the header. Without a row the
    /// file is empty.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_records<R: Serialize>(&self, name: &str, rows: impl IntoIterator<Item = R>) -> Result<()> {
        let mut table = csv::Writer::from_writer(Vec::new());
        rows.into_iter().try_for_each(|row| table.serialize(row))?;
        self.write(name, table.into_inner()?)
    }

    /// Writes a CSV table that a resumed run reads; it is on disk when this returns.
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

/// Encodes a table as CSV.
fn table<R: Serialize>(header: &[&str], rows: impl IntoIterator<Item = R>) -> Result<Vec<u8>> {
    let mut table = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    table.write_record(header)?;
    rows.into_iter().try_for_each(|row| table.serialize(row))?;
    Ok(table.into_inner()?)
}

fn is_empty_folder(path: &Path) -> bool {
    fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none())
}

/// Writes a file under another name and renames it, so that readers never see a partial file.
///
/// # Errors
/// It cannot be written.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<()> {
    aside(path, |aside| fs::write(aside, content))
}

/// Writes a file under another name, flushes it to disk, and renames it: after a loss of power
/// either the old or the new file is complete.
///
/// # Errors
/// It cannot be written.
pub fn write_lasting(path: &Path, pieces: &[&[u8]]) -> Result<()> {
    aside(path, |aside| {
        let mut file = File::create(aside)?;
        pieces.iter().try_for_each(|piece| file.write_all(piece))?;
        file.sync_all()
    })?;
    // Flushes the folder entry too, where folders can be opened.
    if let Some(Ok(folder)) = path.parent().map(File::open) {
        folder.sync_all().with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// Writes a file piece by piece under another name and renames it, so that readers never see a
/// partial file.
///
/// # Errors
/// The error of `write`, or the file cannot be written; no file is left then.
pub fn write_streamed(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let mut failed = None;
    let written = aside(path, |aside| {
        let mut out = BufWriter::new(File::create(aside)?);
        if let Err(error) = write(&mut out) {
            let interrupted = io::Error::other("the content is incomplete");
            failed = Some(error);
            return Err(interrupted);
        }
        out.flush()
    });
    failed.map_or(written, Err)
}

/// Writes a file under another name, then renames it.
fn aside(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> Result<()> {
    let mut aside = path.as_os_str().to_owned();
    aside.push(".part");
    let aside = PathBuf::from(aside);
    let written = write(&aside).and_then(|()| fs::rename(&aside, path));
    if written.is_err() {
        // A partial file is useless; a failure to remove it is ignored.
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
        assert_eq!(fs::read_dir(&path).unwrap().count(), 1, "no temporary file is left");
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
