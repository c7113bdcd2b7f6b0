//! Files that a run appends to; resuming truncates them to their lengths at the checkpoint.
//!
//! Guarantees:
//! - After a resume each file continues exactly where it was at the checkpoint: rows and frames
//!   written later are removed and written again.
//! - A file that is missing or shorter than at the checkpoint is an error.
//! - File contents are on disk before the checkpoint that records their lengths.
//! - A file that another thread has truncated because the program ends is not written any more.
//! - Each write goes to the end of its file, and a file that has another length than this run has
//!   given it is an error before each checkpoint and at the end: where locks do not reach another
//!   process, no run ends well with files that both have written.

use std::{
    fs::{File, OpenOptions},
    io::{self, BufWriter, Write},
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

use crate::output::Folder;

/// How a series is written: the CSV file, and the row of each point.
#[derive(Debug)]
pub struct SeriesFormat<T> {
    /// Name of the file.
    pub name: &'static str,
    /// Names of the columns.
    pub header: &'static [&'static str],
    /// Writes one point.
    pub row: fn(&mut csv::Writer<&mut Appender>, &T) -> csv::Result<()>,
}

/// Length of one file at a checkpoint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Length {
    name: String,
    bytes: u64,
    /// Number of points in a table, or of frames in a trajectory.
    records: usize,
}

impl Length {
    /// The length of a table with rows that come before the first point of a run.
    pub(crate) fn of_earlier_rows(name: &str, content: &[u8]) -> Self {
        Self {
            name: name.to_owned(),
            bytes: content.len() as u64,
            records: 0,
        }
    }
}

/// Held during each write to a file of a run, and while its files are truncated.
type Writing = Arc<Mutex<()>>;

/// Writes to a file while nothing truncates it.
pub type Appender = BufWriter<SharedFile>;

/// A file that another thread may truncate between two writes.
#[derive(Debug)]
pub struct SharedFile {
    /// Opened for appending.
    file: File,
    /// Length that the file must have.
    bytes: u64,
    writing: Writing,
}

impl SharedFile {
    /// Flushes the file to disk and returns its length.
    ///
    /// # Errors
    /// It cannot be flushed, or it has another length than this run has written.
    fn length(&self) -> Result<u64> {
        self.file.sync_data()?;
        // A thread that has truncated the file holds the guard until the program has ended.
        let _writing = self.writing.lock().unwrap_or_else(PoisonError::into_inner);
        let found = self.file.metadata()?.len();
        ensure!(
            found == self.bytes,
            "it has {found} bytes, but this run has written {}: another process writes there. End one of the two, and \
             start the run again with --force or in another folder",
            self.bytes
        );
        Ok(found)
    }
}

impl Write for SharedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let _writing = self.writing.lock().unwrap_or_else(PoisonError::into_inner);
        let written = self.file.write(bytes)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Lengths of the files of one run at its last checkpoint.
#[derive(Debug)]
pub struct CheckpointLengths {
    folder: Folder,
    writing: Writing,
    /// `None` before the first checkpoint and after the end of the run.
    lengths: Option<Vec<Length>>,
}

impl CheckpointLengths {
    /// State before the first checkpoint of a run with these files.
    pub fn new(files: &AppendFiles) -> Self {
        Self {
            folder: files.folder.clone(),
            writing: Arc::clone(&files.writing),
            lengths: None,
        }
    }

    /// Records the file lengths of a checkpoint; `None` after the end of the run, when files are no
    /// longer truncated.
    pub fn set(&mut self, lengths: Option<Vec<Length>>) {
        self.lengths = lengths;
    }

    /// Truncates the files to their lengths at the checkpoint. A file that cannot be truncated is
    /// left; resuming truncates it. While the returned guard lives, threads that write to the files
    /// wait. `None`, and nothing is truncated, if a file is being written.
    pub fn cut_back(&self) -> Option<MutexGuard<'_, ()>> {
        let guard = self.writing.try_lock().ok()?;
        // What another process has written since is not this one's to cut.
        if self.folder.check_holder().is_err() {
            return Some(guard);
        }
        for length in self.lengths.iter().flatten() {
            let path = self.folder.path().join(&length.name);
            if let Ok(file) = OpenOptions::new().write(true).open(path)
                && file
                    .metadata()
                    .is_ok_and(|found| found.len() > length.bytes)
            {
                let _ = file.set_len(length.bytes);
            }
        }
        Some(guard)
    }
}

/// The files that one run appends to.
#[derive(Debug)]
pub struct AppendFiles {
    folder: Folder,
    files: Vec<AppendFile>,
    writing: Writing,
}

#[derive(Debug)]
struct AppendFile {
    name: String,
    out: Appender,
    records: usize,
}

impl AppendFiles {
    /// An empty set of files.
    pub fn new(folder: &Folder) -> Self {
        Self {
            folder: folder.clone(),
            files: Vec::new(),
            writing: Writing::default(),
        }
    }

    /// Opens the files of a checkpoint and truncates them to their lengths there.
    ///
    /// # Errors
    /// A file is missing or shorter than at the checkpoint; another process writes into the folder.
    pub fn resume(folder: &Folder, lengths: &[Length]) -> Result<Self> {
        let mut resumed = Self::new(folder);
        for length in lengths {
            folder.check_holder()?;
            let file = cut_back(&folder.file(&length.name)?, length)?;
            let (name, out) = (length.name.clone(), resumed.appender(file, length.bytes));
            resumed.files.push(AppendFile {
                name,
                out,
                records: length.records,
            });
        }
        Ok(resumed)
    }

    /// Writes the points of a series that are not yet in its table. The first call creates the
    /// table, even for an empty series.
    ///
    /// # Errors
    /// The table cannot be written.
    pub fn append<T>(&mut self, table: &SeriesFormat<T>, series: &[T]) -> Result<()> {
        self.append_to(table.name, table, series)
    }

    /// Writes the points of a series that are not yet in its table, whose file has another name
    /// than usual. The first call creates the table, even for an empty series. A series with fewer
    /// points than the table has begun anew: all its points follow.
    ///
    /// # Errors
    /// The table cannot be written.
    pub fn append_to<T>(
        &mut self,
        name: &str,
        table: &SeriesFormat<T>,
        series: &[T],
    ) -> Result<()> {
        let written = self
            .files
            .iter()
            .find(|file| file.name == name)
            .map_or(0, |file| file.records);
        let new = series.get(written..).unwrap_or(series);
        if new.len() == series.len()
            && let Some(file) = self.files.iter_mut().find(|file| file.name == name)
        {
            file.records = 0;
        }
        self.append_new_to(name, table, new)
    }

    /// Writes points that are stored nowhere else. The first call creates the table, even without
    /// points.
    ///
    /// # Errors
    /// The table cannot be written.
    pub fn append_new<T>(&mut self, table: &SeriesFormat<T>, points: &[T]) -> Result<()> {
        self.append_new_to(table.name, table, points)
    }

    /// Writes points that are stored nowhere else to a file of another name than usual. The first
    /// call creates the table, even without points.
    ///
    /// # Errors
    /// The table cannot be written.
    pub fn append_new_to<T>(
        &mut self,
        name: &str,
        table: &SeriesFormat<T>,
        points: &[T],
    ) -> Result<()> {
        let file = self.file(name, |out| {
            write_csv(out, |csv| csv.write_record(table.header))
        })?;
        file.records += points.len();
        write_csv(&mut file.out, |csv| {
            points.iter().try_for_each(|point| (table.row)(csv, point))
        })
        .with_context(|| format!("cannot write {name}"))
    }

    /// Whether a file of this name has been begun.
    pub fn holds(&self, name: &str) -> bool {
        self.files.iter().any(|file| file.name == name)
    }

    /// Appends one frame to a trajectory.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn append_frame(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut Appender) -> io::Result<()>,
    ) -> Result<()> {
        let file = self.file(name, |_| Ok(()))?;
        file.records += 1;
        write(&mut file.out)
            .and_then(|()| file.out.flush())
            .with_context(|| format!("cannot write {name}"))
    }

    /// Flushes all files to disk and returns their lengths.
    ///
    /// # Errors
    /// A file cannot be flushed, or has another length than this run has written; another process
    /// writes into the folder.
    pub fn lengths(&mut self) -> Result<Vec<Length>> {
        self.folder.check_holder()?;
        let folder = self.folder.path();
        let length = |file: &mut AppendFile| -> Result<Length> {
            file.out.flush()?;
            let bytes = file.out.get_ref().length()?;
            Ok(Length {
                name: file.name.clone(),
                bytes,
                records: file.records,
            })
        };
        let cannot = |name: &str| format!("cannot write {}", folder.join(name).display());
        self.files
            .iter_mut()
            .map(|file| length(file).with_context(|| cannot(&file.name)))
            .collect()
    }

    /// Returns the file of this name; creates it on first use.
    fn file(
        &mut self,
        name: &str,
        begin: impl FnOnce(&mut Appender) -> io::Result<()>,
    ) -> Result<&mut AppendFile> {
        let place = self.files.iter().position(|file| file.name == name);
        let place = place.unwrap_or(self.files.len());
        if place == self.files.len() {
            self.folder.check_holder()?;
            let path = self.folder.file(name)?;
            // Truncated separately: not every system truncates a file that is opened for appending.
            let made =
                File::create(&path).and_then(|_| OpenOptions::new().append(true).open(&path));
            let made = made.map(|file| self.appender(file, 0)).and_then(|mut out| {
                begin(&mut out)?;
                Ok(out)
            });
            let out = made.with_context(|| format!("cannot write {}", path.display()))?;
            self.files.push(AppendFile {
                name: name.to_owned(),
                out,
                records: 0,
            });
        }
        Ok(&mut self.files[place])
    }

    /// Writes to the end of a file of this length.
    fn appender(&self, file: File, bytes: u64) -> Appender {
        BufWriter::new(SharedFile {
            file,
            bytes,
            writing: Arc::clone(&self.writing),
        })
    }
}

fn write_csv(
    out: &mut Appender,
    write: impl FnOnce(&mut csv::Writer<&mut Appender>) -> csv::Result<()>,
) -> io::Result<()> {
    let mut csv = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(out);
    write(&mut csv)?;
    csv.flush()
}

/// Truncates a file to its length at the checkpoint, and opens it for appending.
fn cut_back(path: &Path, length: &Length) -> Result<File> {
    let cannot = || format!("cannot continue {}", path.display());
    let file = OpenOptions::new()
        .write(true)
        .open(path)
        .with_context(cannot)?;
    let found = file.metadata().with_context(cannot)?.len();
    ensure!(
        found >= length.bytes,
        "cannot continue {}: it has {found} bytes, but had {} at the checkpoint",
        path.display(),
        length.bytes
    );
    file.set_len(length.bytes).with_context(cannot)?;
    OpenOptions::new()
        .append(true)
        .open(path)
        .with_context(cannot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Existing;
    use std::{fs, sync::mpsc, thread, time::Duration};

    const SQUARES: SeriesFormat<f64> = SeriesFormat {
        name: "squares.csv",
        header: &["x", "square"],
        row: |csv, x| csv.serialize((x, x * x)),
    };

    const CUBES: SeriesFormat<f64> = SeriesFormat {
        name: "cubes.csv",
        header: &["x", "cube"],
        row: |csv, x| csv.serialize((x, x * x * x)),
    };

    #[test]
    fn rows_written_after_the_checkpoint_are_truncated_and_written_again() {
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let mut files = AppendFiles::new(&folder);
        files.append(&SQUARES, &[]).unwrap();
        files.append(&SQUARES, &[1.0, 2.0]).unwrap();
        files
            .append_frame("frames", |out| out.write_all(b"one"))
            .unwrap();
        files.append_new(&CUBES, &[2.0]).unwrap();
        let lengths = files.lengths().unwrap();
        files.append(&SQUARES, &[1.0, 2.0, 3.0]).unwrap();
        files
            .append_frame("frames", |out| out.write_all(b"two"))
            .unwrap();
        // Without a checkpoint, or after the end of the run, files keep their full length.
        let mut lengths_kept = CheckpointLengths::new(&files);
        drop(files);
        drop(lengths_kept.cut_back().unwrap());
        let read = |name| fs::read_to_string(root.path().join(name)).unwrap();
        let (table, frames) = (read("squares.csv"), read("frames"));
        assert_eq!(table, "x,square\n1.0,1.0\n2.0,4.0\n3.0,9.0\n");
        lengths_kept.set(Some(lengths.clone()));
        drop(lengths_kept.cut_back().unwrap());
        assert_eq!(
            (read("squares.csv"), read("frames")),
            ("x,square\n1.0,1.0\n2.0,4.0\n".into(), "one".into())
        );

        let mut files = AppendFiles::resume(&folder, &lengths).unwrap();
        assert_eq!(read("squares.csv"), "x,square\n1.0,1.0\n2.0,4.0\n");
        files.append(&SQUARES, &[1.0, 2.0, 3.0]).unwrap();
        files.append_new(&CUBES, &[3.0]).unwrap();
        files
            .append_frame("frames", |out| out.write_all(b"two"))
            .unwrap();
        drop(files);
        assert_eq!(read("cubes.csv"), "x,cube\n2.0,8.0\n3.0,27.0\n");
        assert_eq!((read("squares.csv"), read("frames")), (table, frames));

        fs::write(root.path().join("frames"), "on").unwrap();
        let refused = AppendFiles::resume(&folder, &lengths)
            .unwrap_err()
            .to_string();
        assert!(
            refused.contains("frames") && refused.contains("2 bytes, but had 3"),
            "{refused}"
        );
        fs::remove_file(root.path().join("frames")).unwrap();
        assert!(
            AppendFiles::resume(&folder, &lengths)
                .unwrap_err()
                .to_string()
                .contains("frames")
        );
    }

    /// A second process in the same folder, where locks do not reach it, truncates or extends what
    /// this one has written.
    #[test]
    fn files_that_another_process_writes_are_an_error() {
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let path = root.path().join("squares.csv");
        let spoilt = |files: &mut AppendFiles| {
            let words = format!("{:#}", files.lengths().unwrap_err());
            assert!(
                words.contains("squares.csv") && words.contains("another process writes there"),
                "{words}"
            );
        };
        let mut files = AppendFiles::new(&folder);
        files.append_new(&SQUARES, &[1.0, 2.0]).unwrap();
        let lengths = files.lengths().unwrap();
        OpenOptions::new()
            .write(true)
            .open(&path)
            .unwrap()
            .set_len(3)
            .unwrap();
        spoilt(&mut files);
        // What follows is appended: no gap of zeros.
        files.append_new(&SQUARES, &[3.0]).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "x,s3.0,9.0\n");
        spoilt(&mut files);

        fs::write(&path, "x,square\n1.0,1.0\n2.0,4.0\n").unwrap();
        let mut files = AppendFiles::resume(&folder, &lengths).unwrap();
        files.append_new(&SQUARES, &[3.0]).unwrap();
        assert!(files.lengths().is_ok());
        let mut other = AppendFiles::resume(&folder, &lengths).unwrap();
        other.append_new(&SQUARES, &[3.0, 4.0]).unwrap();
        spoilt(&mut files);
    }

    /// A process that is slow to begin may find that another has come and has written its files.
    #[cfg(unix)]
    #[test]
    fn a_process_that_is_not_the_last_to_come_truncates_nothing() {
        let root = tempfile::tempdir().unwrap();
        let (folder, _lock) = Folder::claim(root.path(), Existing::Refuse).unwrap();
        let mut files = AppendFiles::new(&folder);
        let mut checkpoint = CheckpointLengths::new(&files);
        files.append_new(&SQUARES, &[1.0]).unwrap();
        let lengths = files.lengths().unwrap();
        files.append_new(&SQUARES, &[2.0]).unwrap();
        drop(files);
        checkpoint.set(Some(lengths.clone()));
        let read = || fs::read_to_string(root.path().join("squares.csv")).unwrap();
        let whole = read();
        let name = "writes into\nprocess 1 on moon since ever\n0\n";
        fs::write(root.path().join(crate::folder_lock::LOCK), name).unwrap();
        let refused = AppendFiles::resume(&folder, &lengths).unwrap_err();
        assert!(refused.is::<crate::folder_lock::Ousted>(), "{refused:#}");
        let refused = AppendFiles::new(&folder).append_new(&SQUARES, &[3.0]);
        assert!(refused.unwrap_err().is::<crate::folder_lock::Ousted>());
        drop(checkpoint.cut_back().unwrap());
        assert_eq!(read(), whole);
    }

    /// Without the guard the next row would be written after the last row of the checkpoint.
    #[test]
    fn truncated_files_are_not_written_while_the_guard_lives() {
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let mut files = AppendFiles::new(&folder);
        files.append_new(&SQUARES, &[1.0]).unwrap();
        let mut checkpoint = CheckpointLengths::new(&files);
        checkpoint.set(Some(files.lengths().unwrap()));
        files.append_new(&SQUARES, &[2.0]).unwrap();
        let read = || fs::read_to_string(root.path().join("squares.csv")).unwrap();
        thread::scope(|scope| {
            let guard = checkpoint.cut_back().unwrap();
            let (begun, begins) = mpsc::channel();
            let writer = scope.spawn(move || {
                begun.send(()).unwrap();
                files.append_new(&SQUARES, &[3.0]).unwrap();
            });
            begins.recv().unwrap();
            thread::sleep(Duration::from_millis(50));
            assert!(!writer.is_finished());
            assert_eq!(read(), "x,square\n1.0,1.0\n");
            // The program would have ended here.
            drop(guard);
            writer.join().unwrap();
            assert_ne!(read(), "x,square\n1.0,1.0\n");
        });
    }
}
