//! The lock of an output folder: one process writes into it at a time, also on a shared file
//! system.
//!
//! The lock is taken on the regular file [`LOCK`] in the folder, opened for writing: NFSv4, Lustre
//! and GPFS pass such a lock on to other machines, but keep a lock of a folder to themselves. The
//! file holds the machine, the process and the time, for the message to a process that is refused.
//!
//! The file is removed with the lock. A process that has opened it just before then locks a file
//! that is no longer in the folder; so after locking each process compares its file with that in
//! the folder, and begins again if they differ. A process that is killed leaves the file, which
//! means nothing without a lock.
//!
//! Where locks do not reach another process, the file still tells which process has come last: each
//! writes its name there, and one that finds another name than its own writes nothing more.

use std::{
    fs::{self, File, OpenOptions, TryLockError},
    io::{self, ErrorKind, Seek as _, Write as _},
    path::{Path, PathBuf},
    process,
    time::{SystemTime, UNIX_EPOCH},
};

use anyhow::{Context, Result, bail};
use thiserror::Error;

use crate::terminal::note;

/// Name of the file that is locked.
pub const LOCK: &str = ".carom-lock";

/// A locked folder; unlocked when dropped.
#[derive(Debug)]
pub struct FolderLock {
    /// `None` where there is no lock.
    file: Option<File>,
    holder: Holder,
}

/// The process that writes into a folder, as the file of its lock names it.
#[derive(Debug, Clone)]
pub struct Holder {
    path: PathBuf,
    text: String,
}

/// Another process has begun to write into the folder of this one, which must write nothing more
/// there: neither results nor why it has ended.
#[derive(Debug, Error)]
#[error("another process{holder} has begun to write into {}: end it, and resume this run", folder.display())]
pub struct Ousted {
    holder: String,
    folder: PathBuf,
}

impl Holder {
    /// Looks whether this process is still the last that has come to write into the folder. It is
    /// unless locks do not reach another one.
    ///
    /// # Errors
    /// Another process has come, with its machine and number, or the file of the lock is gone.
    pub fn check(&self) -> Result<(), Ousted> {
        // Elsewhere a locked file cannot be read, and locks reach every process.
        if !cfg!(unix) {
            return Ok(());
        }
        let text = fs::read_to_string(&self.path).unwrap_or_default();
        if text == self.text {
            return Ok(());
        }
        let folder = self.path.parent().unwrap_or(&self.path).to_owned();
        Err(Ousted {
            holder: holder_in(&text),
            folder,
        })
    }
}

/// How a process uses a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    Writes,
    Reads,
}

impl FolderLock {
    /// Locks a folder against all other processes. Where the file system has no locks, a note says
    /// so to the user.
    ///
    /// # Errors
    /// Another process writes into the folder or reads it, with its machine and number; the file of
    /// the lock cannot be written.
    pub fn exclusive(folder: &Path) -> Result<Self> {
        Self::take(folder, Use::Writes)
    }

    /// This process as the holder of the lock.
    pub fn holder(&self) -> &Holder {
        &self.holder
    }

    /// Locks a folder against processes that write, while it is read. A folder that cannot be
    /// written has no lock if no process has left the file of one.
    ///
    /// # Errors
    /// Another process writes into the folder, with its machine and number.
    pub fn shared(folder: &Path) -> Result<Self> {
        Self::take(folder, Use::Reads)
    }

    fn take(folder: &Path, usage: Use) -> Result<Self> {
        let path = folder.join(LOCK);
        let holder = Holder {
            path: path.clone(),
            text: usage.text(),
        };
        loop {
            let Some(file) = open(&path, usage)? else {
                return Ok(Self { file: None, holder });
            };
            let locked = match usage {
                Use::Writes => file.try_lock(),
                Use::Reads => file.try_lock_shared(),
            };
            match locked {
                // The last holder has removed it in the meantime.
                Ok(()) if !is_at(&file, &path) => continue,
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => bail!("{}", refusal(folder, &path)),
                Err(TryLockError::Error(error)) => {
                    note(&format!(
                        "The file system of {} has no locks ({error}): see to it that no other process writes there.",
                        folder.display()
                    ));
                    // The name of a process that writes stays.
                    if usage == Use::Reads {
                        return Ok(Self {
                            file: Some(file),
                            holder,
                        });
                    }
                }
            }
            let named = name_holder(&file, &holder);
            // Of a process that reads, others only learn the name.
            if usage == Use::Reads {
                return Ok(Self {
                    file: Some(file),
                    holder,
                });
            }
            named.with_context(|| format!("cannot write {}", path.display()))?;
            // Without a lock, another process may have removed the file while it was named.
            if is_at(&file, &path) {
                return Ok(Self {
                    file: Some(file),
                    holder,
                });
            }
        }
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // Only the last holder removes the file: others may read the folder too. Without inodes the
        // file cannot be compared with that in the folder, so there it stays.
        if let Some(file) = &self.file
            && cfg!(unix)
            && !matches!(file.try_lock(), Err(TryLockError::WouldBlock))
            && is_at(file, &self.holder.path)
            // One that has come without a lock keeps its name there.
            && self.holder.check().is_ok()
        {
            let _ = fs::remove_file(&self.holder.path);
        }
    }
}

/// Opens the file of a lock, and creates it if there is none; `None` if this process only reads the
/// folder, which cannot be written and has no such file.
fn open(path: &Path, usage: Use) -> Result<Option<File>> {
    let opened = OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(path);
    match opened {
        Err(error) if usage == Use::Reads && is_read_only(&error) => Ok(File::open(path).ok()),
        opened => opened
            .map(Some)
            .with_context(|| format!("cannot write {}", path.display())),
    }
}

fn is_read_only(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem
    )
}

/// Whether the file at `path` is this one.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let place =
        |found: io::Result<fs::Metadata>| found.ok().map(|found| (found.dev(), found.ino()));
    place(file.metadata()).is_some_and(|own| place(fs::metadata(path)) == Some(own))
}

/// Whether the file at `path` is this one: always, since it is never removed.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

impl Use {
    /// What a process writes into the file: no two processes write the same.
    fn text(self) -> String {
        let verb = if self == Self::Writes {
            "writes into"
        } else {
            "reads"
        };
        let (host, id, now) = (host(), process::id(), SystemTime::now());
        let nanoseconds = now
            .duration_since(UNIX_EPOCH)
            .map_or(0, |past| past.as_nanos());
        format!(
            "{verb}\nprocess {id} on {host} since {}\n{nanoseconds}\n",
            utc(now)
        )
    }
}

/// Writes machine, process and time into the file.
fn name_holder(mut file: &File, holder: &Holder) -> io::Result<()> {
    file.set_len(0)?;
    file.rewind()?;
    file.write_all(holder.text.as_bytes())
}

/// The error of a folder that another process has locked.
fn refusal(folder: &Path, path: &Path) -> String {
    // On some systems a locked file cannot be read.
    let text = fs::read_to_string(path).unwrap_or_default();
    let verb = text
        .lines()
        .next()
        .filter(|verb| *verb == "reads")
        .unwrap_or("writes into");
    format!(
        "another process {verb} {}{}: wait until it has ended",
        folder.display(),
        holder_in(&text)
    )
}

/// The process that the text of a lock names, in brackets.
fn holder_in(text: &str) -> String {
    text.lines()
        .nth(1)
        .map(|holder| format!(" ({holder})"))
        .unwrap_or_default()
}

/// Name of this machine.
fn host() -> String {
    let of_system = fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let name = of_system.or_else(|| {
        ["HOSTNAME", "COMPUTERNAME"]
            .iter()
            .find_map(|name| std::env::var(name).ok())
    });
    name.map_or_else(
        || "an unknown machine".to_owned(),
        |name| name.trim().to_owned(),
    )
}

/// A time as text, such as `2000-02-29 23:59:59 UTC`.
fn utc(time: SystemTime) -> String {
    let seconds = time
        .duration_since(UNIX_EPOCH)
        .map_or(0, |past| past.as_secs());
    let (mut days, rest) = (seconds / 86_400, seconds % 86_400);
    let is_leap = |year: u64| {
        year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
    };
    let mut year = 1970;
    while days >= 365 + u64::from(is_leap(year)) {
        days -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let mut month = 1;
    for length in [
        31,
        28 + u64::from(is_leap(year)),
        31,
        30,
        31,
        30,
        31,
        31,
        30,
        31,
        30,
    ] {
        if days < length {
            break;
        }
        days -= length;
        month += 1;
    }
    let (hour, minute, second) = (rest / 3600, rest / 60 % 60, rest % 60);
    format!(
        "{year}-{month:02}-{:02} {hour:02}:{minute:02}:{second:02} UTC",
        days + 1
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn root() -> tempfile::TempDir {
        tempfile::tempdir().unwrap()
    }

    #[test]
    fn one_process_writes_at_a_time_and_is_named_to_others() {
        let root = root();
        let lock = FolderLock::exclusive(root.path()).unwrap();
        for refused in [
            FolderLock::exclusive(root.path()),
            FolderLock::shared(root.path()),
        ] {
            let words = refused.unwrap_err().to_string();
            assert!(words.starts_with("another process writes into"), "{words}");
            assert!(
                words.contains(&format!("process {} on {}", process::id(), host())),
                "{words}"
            );
            assert!(words.contains(" UTC"), "{words}");
        }
        drop(lock);
        assert_eq!(
            fs::read_dir(root.path()).unwrap().count(),
            0,
            "the file is removed"
        );
        drop(FolderLock::exclusive(root.path()).unwrap());
    }

    #[test]
    fn several_processes_read_and_none_writes_meanwhile() {
        let root = root();
        let [first, second] = [(); 2].map(|()| FolderLock::shared(root.path()).unwrap());
        for reader in [first, second] {
            let words = FolderLock::exclusive(root.path()).unwrap_err().to_string();
            assert!(words.starts_with("another process reads"), "{words}");
            drop(reader);
        }
        drop(FolderLock::exclusive(root.path()).unwrap());
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 0);
    }

    #[test]
    fn the_file_of_a_killed_process_locks_nothing() {
        let root = root();
        fs::write(
            root.path().join(LOCK),
            "writes into\nprocess 1 on moon since ever\n",
        )
        .unwrap();
        drop(FolderLock::exclusive(root.path()).unwrap());
    }

    /// The lock of another machine reaches this one as a lock on a regular file: a lock on the
    /// folder does not.
    #[cfg(unix)]
    #[test]
    fn a_regular_file_is_locked_and_a_removed_one_counts_for_nothing() {
        let root = root();
        let lock = FolderLock::exclusive(root.path()).unwrap();
        let other = File::open(root.path().join(LOCK)).unwrap();
        assert!(matches!(other.try_lock(), Err(TryLockError::WouldBlock)));
        assert!(File::open(root.path()).unwrap().try_lock().is_ok());
        drop(lock);
        // The other process locks a file that is no longer in the folder.
        other.try_lock().unwrap();
        assert!(!is_at(&other, &root.path().join(LOCK)));
        drop(FolderLock::exclusive(root.path()).unwrap());
    }

    /// Where every lock is granted, the process that came first finds the name of the second.
    #[cfg(unix)]
    #[test]
    fn a_process_that_comes_without_a_lock_is_found_by_the_first() {
        let root = root();
        let lock = FolderLock::exclusive(root.path()).unwrap();
        lock.holder().check().unwrap();
        fs::write(
            root.path().join(LOCK),
            "writes into\nprocess 1 on moon since ever\n0\n",
        )
        .unwrap();
        let words = lock.holder().check().unwrap_err().to_string();
        assert!(
            words.contains("another process (process 1 on moon since ever) has begun"),
            "{words}"
        );
        // The file of the other stays.
        drop(lock);
        assert!(root.path().join(LOCK).exists());
    }

    #[test]
    fn times_are_dates() {
        let at = |seconds| utc(UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(at(0), "1970-01-01 00:00:00 UTC");
        assert_eq!(at(951_868_799), "2000-02-29 23:59:59 UTC");
        assert_eq!(at(951_868_800), "2000-03-01 00:00:00 UTC");
        assert_eq!(at(1_798_761_599), "2026-12-31 23:59:59 UTC");
    }
}
