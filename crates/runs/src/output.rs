//! The output folder of a run: an earlier run is not overwritten by accident, and every file is
//! complete.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use anyhow::{Context, Error, Result, anyhow, ensure};
use clap::Args;
use serde::Serialize;

pub use crate::{
    file_names::MANIFEST,
    whole_file::{write_lasting, write_streamed, write_whole},
};
use crate::{
    folder_lock::{FolderLock, Holder},
    written_files::{WrittenFiles, is_unstarted},
};

/// Treatment of a folder that already holds files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// An error is returned and nothing is written.
    Refuse,
    /// The files that an earlier run has written are removed; others remain.
    Replace,
    /// The run in the folder is continued; it is an error if there is none.
    Resume,
}

impl Existing {
    /// Refuses a folder whose content does not fit the treatment.
    ///
    /// # Errors
    /// The folder cannot be read, or it holds files that are not allowed.
    pub fn admit(self, path: &Path) -> Result<()> {
        match self {
            Self::Replace => Ok(()),
            Self::Refuse if is_unstarted(path)? => Ok(()),
            Self::Refuse => Err(not_empty(path)),
            Self::Resume => {
                ensure!(
                    path.join(MANIFEST).exists() || is_unstarted(path)?,
                    "{} holds no run to resume: it has no {MANIFEST}. Start the run without --resume in another \
                     folder, or with --force in this one",
                    path.display()
                );
                Ok(())
            }
        }
    }
}

/// Output folder and its treatment.
#[derive(Debug, Clone, Default, Args)]
pub struct Destination {
    /// Output folder; default: a folder in out/ named after the command and its arguments
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Remove the files of an earlier run in that folder; others stay
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
        if self.force {
            Existing::Replace
        } else {
            Existing::Refuse
        }
    }

    /// Refuses a folder that holds files, before a long preparation; creates nothing.
    ///
    /// # Errors
    /// The folder is not empty, and files are not to be replaced.
    pub fn check(&self, usual: &str) -> Result<()> {
        let path = self.folder(usual);
        if path.is_dir() {
            self.existing().admit(&path)
        } else {
            Ok(())
        }
    }
}

/// The error of a folder with files.
fn not_empty(path: &Path) -> Error {
    anyhow!(
        "{} is not empty: choose another folder with --out, replace the run in it with --force, or resume it with \
         --resume",
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
        if self.resume {
            Existing::Resume
        } else {
            self.destination.existing()
        }
    }
}

/// An output folder.
#[derive(Debug, Clone)]
pub struct Folder {
    path: PathBuf,
    /// This process, in a claimed folder and inside it.
    holder: Option<Arc<Holder>>,
    /// List of the written files; absent in folders that were created and not claimed.
    written: Option<Written>,
}

/// The list of files of a claimed folder, as a folder inside it sees it.
#[derive(Debug, Clone)]
struct Written {
    files: Arc<WrittenFiles>,
    /// Path of the inner folder with a slash at its end; empty in the claimed one.
    inner: String,
}

impl Folder {
    /// Creates the folder and its parents, locks it, and removes the files of an earlier run unless
    /// that is to be resumed. The folder is examined with the lock held, so of two processes that
    /// start together one is refused.
    ///
    /// # Errors
    /// It cannot be created, holds files that `existing` does not allow, or another process uses
    /// it.
    pub fn claim(path: &Path, existing: Existing) -> Result<(Self, FolderLock)> {
        let (folder, lock) = Self::claim_if(path, |path| existing.admit(path))?;
        if existing != Existing::Resume {
            folder.remove_earlier()?;
        }
        Ok((folder, lock))
    }

    /// Creates the folder and its parents, and locks it if `admit` allows what it holds, also with
    /// the lock held. Removes nothing.
    ///
    /// # Errors
    /// It cannot be created, the error of `admit`, or another process uses it.
    pub fn claim_if(
        path: &Path,
        admit: impl Fn(&Path) -> Result<()>,
    ) -> Result<(Self, FolderLock)> {
        fs::create_dir_all(path)
            .with_context(|| format!("cannot create the folder {}", path.display()))?;
        admit(path)?;
        let lock = FolderLock::exclusive(path)?;
        // Another process may have written since.
        admit(path)?;
        let (files, inner) = (Arc::new(WrittenFiles::read(path)), String::new());
        let holder = Some(Arc::new(lock.holder().clone()));
        Ok((
            Self {
                path: path.to_owned(),
                holder,
                written: Some(Written { files, inner }),
            },
            lock,
        ))
    }

    /// Creates the folder and its parents, for files that belong to a run of another folder.
    ///
    /// # Errors
    /// It cannot be created, or it holds files and `existing` is [`Existing::Refuse`].
    pub fn create(path: &Path, existing: Existing) -> Result<Self> {
        fs::create_dir_all(path)
            .with_context(|| format!("cannot create the folder {}", path.display()))?;
        existing.admit(path)?;
        Ok(Self {
            path: path.to_owned(),
            holder: None,
            written: None,
        })
    }

    /// Returns a folder inside this one and creates it if necessary.
    ///
    /// # Errors
    /// It cannot be created.
    pub fn inner(&self, name: &str) -> Result<Self> {
        let written = self.written.clone();
        let written = written.map(|outer| Written {
            inner: format!("{}{name}/", outer.inner),
            ..outer
        });
        Ok(Self {
            written,
            ..self.unlisted(name)?
        })
    }

    /// Returns a folder inside this one, whose files are not listed, and creates it if necessary.
    ///
    /// # Errors
    /// It cannot be created.
    pub fn unlisted(&self, name: &str) -> Result<Self> {
        let holder = self.holder.clone();
        Ok(Self {
            holder,
            ..Self::create(&self.path.join(name), Existing::Replace)?
        })
    }

    /// Returns the path of a file that this run is about to write, and lists it.
    ///
    /// # Errors
    /// The list of files cannot be written.
    pub fn file(&self, name: &str) -> Result<PathBuf> {
        if let Some(Written { files, inner }) = &self.written {
            files.add(&format!("{inner}{name}"))?;
        }
        Ok(self.path.join(name))
    }

    /// Looks whether this process is still the last that has come to write into the folder.
    ///
    /// # Errors
    /// Another process has come, where locks do not reach it.
    pub(crate) fn check_holder(&self) -> Result<()> {
        self.holder
            .as_ref()
            .map_or(Ok(()), |holder| Ok(holder.check()?))
    }

    /// Names of the files that this run, or the one that it resumes, has written, relative to this
    /// folder and in their order; `None` if they are not known.
    pub fn written(&self) -> Option<Vec<String>> {
        let Written { files, inner } = self.written.as_ref()?;
        let own = |name: &String| name.strip_prefix(inner).map(str::to_owned);
        files
            .names()
            .map(|names| names.iter().filter_map(own).collect())
    }

    /// Removes the separate list of the written files, once the manifest holds it.
    ///
    /// # Errors
    /// It cannot be removed.
    pub(crate) fn end_list(&self) -> Result<()> {
        match &self.written {
            Some(Written { files, inner }) if inner.is_empty() => files.end(),
            _ => Ok(()),
        }
    }

    /// Removes the files of earlier runs in this folder, with their checkpoints.
    ///
    /// # Errors
    /// A file cannot be removed.
    pub fn remove_earlier(&self) -> Result<()> {
        self.written
            .as_ref()
            .map_or(Ok(()), |written| written.files.remove_states())?;
        self.remove_earlier_results()
    }

    /// Removes the files of earlier runs in this folder that this process has not written, without
    /// the states from which a run can be resumed.
    ///
    /// # Errors
    /// Another process has come, where locks do not reach it, or a file cannot be removed.
    pub(crate) fn remove_earlier_results(&self) -> Result<()> {
        self.check_holder()?;
        self.written
            .as_ref()
            .map_or(Ok(()), |written| written.files.remove_earlier())
    }

    /// Removes all that this process has written into the folder, and the folder if it is empty
    /// then.
    ///
    /// # Errors
    /// Another process has come, where locks do not reach it, or a file cannot be removed.
    pub(crate) fn remove_own(&self) -> Result<()> {
        self.check_holder()?;
        self.written
            .as_ref()
            .map_or(Ok(()), |written| written.files.remove_own())?;
        // It stays if other files are in it.
        let _ = fs::remove_dir(&self.path);
        Ok(())
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
        write_whole(&self.file(name)?, content.as_ref())
    }

    /// Writes a whole file that a resumed run reads.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_lasting(&self, name: &str, content: impl AsRef<[u8]>) -> Result<()> {
        write_lasting(&self.file(name)?, &[content.as_ref()])
    }

    /// Writes a whole file of JSON.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_json(&self, name: &str, content: &impl Serialize) -> Result<()> {
        self.write(name, json(content)?)
    }

    /// Writes a whole file of JSON; it is on disk when this returns.
    ///
    /// # Errors
    /// It cannot be written.
    pub(crate) fn write_lasting_json(&self, name: &str, content: &impl Serialize) -> Result<()> {
        self.write_lasting(name, json(content)?)
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
        self.write(name, csv_table(header, rows)?)
    }

    /// Writes a table as CSV whose rows have named fields, which are the header. Without a row the
    /// file is empty.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_records<R: Serialize>(
        &self,
        name: &str,
        rows: impl IntoIterator<Item = R>,
    ) -> Result<()> {
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
        self.write_lasting(name, csv_table(header, rows)?)
    }
}

/// Encodes a file of JSON.
pub(crate) fn json(content: &impl Serialize) -> Result<String> {
    let text =
        serde_json::to_string_pretty(content).context("the content cannot be encoded as JSON")?;
    Ok(text + "\n")
}

/// The bytes of a table as CSV: a header, then one record a row, numbers in their shortest exact
/// form.
///
/// # Errors
/// A row cannot be encoded.
pub fn csv_table<R: Serialize>(
    header: &[&str],
    rows: impl IntoIterator<Item = R>,
) -> Result<Vec<u8>> {
    let mut table = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(Vec::new());
    table.write_record(header)?;
    rows.into_iter().try_for_each(|row| table.serialize(row))?;
    Ok(table.into_inner()?)
}

/// Whether two paths lead to one folder that exists, also through links.
pub fn is_same_folder(one: &Path, other: &Path) -> bool {
    let real = |path: &Path| fs::canonicalize(path).ok();
    real(one).is_some_and(|one| real(other) == Some(one))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_with_files_is_refused_unless_they_may_be_replaced() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("new/inner");
        let folder = Folder::create(&path, Existing::Refuse).unwrap();
        assert!(
            Folder::create(&path, Existing::Refuse).is_ok(),
            "an empty folder is fine"
        );
        folder.write("a.txt", "first").unwrap();
        let refused = Folder::create(&path, Existing::Refuse)
            .unwrap_err()
            .to_string();
        assert!(
            refused.contains("--force") && refused.contains("--resume"),
            "{refused}"
        );
        let refused = Folder::create(&path, Existing::Resume)
            .unwrap_err()
            .to_string();
        assert!(refused.contains("manifest.json"), "{refused}");
        Folder::create(&path, Existing::Replace)
            .unwrap()
            .write("a.txt", "second")
            .unwrap();
        assert_eq!(fs::read_to_string(path.join("a.txt")).unwrap(), "second");
        assert_eq!(
            fs::read_dir(&path).unwrap().count(),
            1,
            "no temporary file is left"
        );
    }

    #[test]
    fn a_folder_is_examined_again_with_the_lock_held() {
        let root = tempfile::tempdir().unwrap();
        let looks = std::cell::Cell::new(0);
        let claimed = Folder::claim_if(root.path(), |path| {
            looks.set(looks.get() + 1);
            let admitted = Existing::Refuse.admit(path);
            // A second process that is as fast as this one.
            if looks.get() == 1 {
                Folder::create(path, Existing::Refuse)?.write(MANIFEST, "{}")?;
            }
            admitted
        });
        let words = claimed.unwrap_err().to_string();
        assert!(
            looks.get() == 2 && words.contains("is not empty"),
            "{words}"
        );
        let (_folder, lock) = Folder::claim(root.path(), Existing::Resume).unwrap();
        let words = Folder::claim(root.path(), Existing::Replace)
            .unwrap_err()
            .to_string();
        assert!(words.contains("another process writes into"), "{words}");
        drop(lock);
        assert!(Folder::claim(root.path(), Existing::Replace).is_ok());
    }

    #[test]
    fn a_replaced_run_leaves_nothing_and_files_of_the_user_stay() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        let (folder, lock) = Folder::claim(root.path(), Existing::Refuse).unwrap();
        folder.write(MANIFEST, "{}").unwrap();
        folder.write("energy.csv", "old").unwrap();
        let inner = folder.inner("part-1").unwrap();
        inner.write("pressure.csv", "old").unwrap();
        assert_eq!(inner.written().unwrap(), ["pressure.csv"]);
        crate::checkpoint_file::write(&at("part-1/checkpoint"), &[b"state"]).unwrap();
        fs::write(at("letter.txt"), "mine").unwrap();
        drop(lock);
        let (folder, _lock) = Folder::claim(root.path(), Existing::Replace).unwrap();
        folder.write("speeds.csv", "new").unwrap();
        assert!(!at("energy.csv").exists() && !at("part-1").exists());
        assert_eq!(fs::read_to_string(at("letter.txt")).unwrap(), "mine");
        assert_eq!(folder.written().unwrap(), [MANIFEST, "speeds.csv"]);
    }

    #[test]
    fn numbers_in_tables_keep_every_digit() {
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let values = [0.1 + 0.2, 1e-300, -0.0, 1.0 / 3.0];
        folder
            .write_table("t.csv", &["i", "x"], values.iter().enumerate())
            .unwrap();
        let text = fs::read_to_string(root.path().join("t.csv")).unwrap();
        let read: Vec<f64> = text
            .lines()
            .skip(1)
            .map(|line| line.split(',').nth(1).unwrap().parse().unwrap())
            .collect();
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
