//! Files that grow while a run goes on, and are cut back to their checkpoint when it is resumed.

use std::{
    fs::{File, OpenOptions},
    io::{self, BufWriter, Seek as _, SeekFrom, Write as _},
    path::Path,
};

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

use crate::output::Folder;

/// A table of numbers, one row for each point of a series.
#[derive(Debug)]
pub struct Table<T> {
    /// Name of the file.
    pub name: &'static str,
    /// Names of the columns.
    pub header: &'static [&'static str],
    /// Writes one point.
    pub row: fn(&mut csv::Writer<&mut BufWriter<File>>, &T) -> csv::Result<()>,
}

/// How far a file has been written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Length {
    name: String,
    bytes: u64,
    /// Points in a table, frames in a trajectory.
    records: usize,
}

/// How long the files of one run were at its last checkpoint.
#[derive(Debug)]
pub struct Kept {
    folder: Folder,
    /// `None` as long as there is no checkpoint, and when the run has ended.
    lengths: Option<Vec<Length>>,
}

impl Kept {
    /// Before the first checkpoint of a run in this folder.
    pub fn nothing(folder: &Folder) -> Self {
        Self { folder: folder.clone(), lengths: None }
    }

    /// Notes a checkpoint with files of these lengths; `None` for a run that has ended, whose files
    /// stay as they are.
    pub fn set(&mut self, lengths: Option<Vec<Length>>) {
        self.lengths = lengths;
    }

    /// Cuts off what the files have more than at the checkpoint. A file that cannot be cut is left
    /// as it is: resuming cuts it.
    pub fn cut_back(&self) {
        for length in self.lengths.iter().flatten() {
            let path = self.folder.path().join(&length.name);
            if let Ok(file) = OpenOptions::new().write(true).open(path)
                && file.metadata().is_ok_and(|found| found.len() > length.bytes)
            {
                let _ = file.set_len(length.bytes);
            }
        }
    }
}

/// The growing files of one run.
#[derive(Debug)]
pub struct Growing {
    folder: Folder,
    files: Vec<GrowingFile>,
}

#[derive(Debug)]
struct GrowingFile {
    name: String,
    out: BufWriter<File>,
    records: usize,
}

impl Growing {
    /// None yet.
    pub fn begin(folder: &Folder) -> Self {
        Self { folder: folder.clone(), files: Vec::new() }
    }

    /// Those that there were at a checkpoint, and as long as they were then.
    ///
    /// # Errors
    /// One is missing, or shorter than it was.
    pub fn resume(folder: &Folder, lengths: &[Length]) -> Result<Self> {
        let files = lengths.iter().map(|length| cut_back(&folder.path().join(&length.name), length));
        Ok(Self { folder: folder.clone(), files: files.collect::<Result<_>>()? })
    }

    /// Writes what a series has more than its table. The table is made with the first call, even of an empty series.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn append<T>(&mut self, table: &Table<T>, series: &[T]) -> Result<()> {
        let written = self.files.iter().find(|file| file.name == table.name).map_or(0, |file| file.records);
        self.append_new(table, &series[written.min(series.len())..])
    }

    /// Writes points that are kept nowhere else. The table is made with the first call, even of none.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn append_new<T>(&mut self, table: &Table<T>, points: &[T]) -> Result<()> {
        let file = self.file(table.name, |out| write_csv(out, |csv| csv.write_record(table.header)))?;
        file.records += points.len();
        write_csv(&mut file.out, |csv| points.iter().try_for_each(|point| (table.row)(csv, point)))
            .with_context(|| format!("cannot write {}", table.name))
    }

    /// Writes one more frame of a trajectory.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn append_frame(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<()> {
        let file = self.file(name, |_| Ok(()))?;
        file.records += 1;
        write(&mut file.out).and_then(|()| file.out.flush()).with_context(|| format!("cannot write {name}"))
    }

    /// Brings all files to the disk, and tells how long they are.
    ///
    /// # Errors
    /// The disk does not take them.
    pub fn lengths(&mut self) -> Result<Vec<Length>> {
        let length = |file: &mut GrowingFile| -> io::Result<Length> {
            file.out.flush()?;
            file.out.get_ref().sync_data()?;
            let bytes = file.out.stream_position()?;
            Ok(Length { name: file.name.clone(), bytes, records: file.records })
        };
        self.files
            .iter_mut()
            .map(|file| length(file).with_context(|| format!("cannot write {}", file.name)))
            .collect()
    }

    /// The file of this name, made if there is none yet.
    fn file(
        &mut self,
        name: &str,
        begin: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<&mut GrowingFile> {
        let place = self.files.iter().position(|file| file.name == name);
        let place = place.unwrap_or(self.files.len());
        if place == self.files.len() {
            let path = self.folder.path().join(name);
            let made = File::create(&path).map(BufWriter::new).and_then(|mut out| {
                begin(&mut out)?;
                Ok(out)
            });
            let out = made.with_context(|| format!("cannot write {}", path.display()))?;
            self.files.push(GrowingFile { name: name.to_owned(), out, records: 0 });
        }
        Ok(&mut self.files[place])
    }
}

fn write_csv(
    out: &mut BufWriter<File>,
    write: impl FnOnce(&mut csv::Writer<&mut BufWriter<File>>) -> csv::Result<()>,
) -> io::Result<()> {
    let mut csv = csv::WriterBuilder::new().has_headers(false).from_writer(out);
    write(&mut csv)?;
    csv.flush()
}

/// Opens a file, drops what came after the checkpoint, and stands at its end.
fn cut_back(path: &Path, length: &Length) -> Result<GrowingFile> {
    let cannot = || format!("cannot go on with {}", path.display());
    let mut file = OpenOptions::new().read(true).write(true).open(path).with_context(cannot)?;
    let found = file.metadata().with_context(cannot)?.len();
    ensure!(
        found >= length.bytes,
        "cannot go on with {}: it has {found} bytes, and had {} at the checkpoint",
        path.display(),
        length.bytes
    );
    file.set_len(length.bytes).and_then(|()| file.seek(SeekFrom::End(0))).with_context(cannot)?;
    Ok(GrowingFile { name: length.name.clone(), out: BufWriter::new(file), records: length.records })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Existing;
    use std::fs;

    const SQUARES: Table<f64> =
        Table { name: "squares.csv", header: &["x", "square"], row: |csv, x| csv.serialize((x, x * x)) };

    const CUBES: Table<f64> =
        Table { name: "cubes.csv", header: &["x", "cube"], row: |csv, x| csv.serialize((x, x * x * x)) };

    #[test]
    fn what_came_after_the_checkpoint_is_cut_off_and_written_again() {
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let mut growing = Growing::begin(&folder);
        growing.append(&SQUARES, &[]).unwrap();
        growing.append(&SQUARES, &[1.0, 2.0]).unwrap();
        growing.append_frame("frames", |out| out.write_all(b"one")).unwrap();
        growing.append_new(&CUBES, &[2.0]).unwrap();
        let lengths = growing.lengths().unwrap();
        growing.append(&SQUARES, &[1.0, 2.0, 3.0]).unwrap();
        growing.append_frame("frames", |out| out.write_all(b"two")).unwrap();
        drop(growing);
        // A run that has no checkpoint, or has ended, keeps all.
        let mut kept = Kept::nothing(&folder);
        kept.cut_back();
        let read = |name| fs::read_to_string(root.path().join(name)).unwrap();
        let (table, frames) = (read("squares.csv"), read("frames"));
        assert_eq!(table, "x,square\n1.0,1.0\n2.0,4.0\n3.0,9.0\n");
        kept.set(Some(lengths.clone()));
        kept.cut_back();
        assert_eq!(
            (read("squares.csv"), read("frames")),
            ("x,square\n1.0,1.0\n2.0,4.0\n".into(), "one".into())
        );

        let mut growing = Growing::resume(&folder, &lengths).unwrap();
        assert_eq!(read("squares.csv"), "x,square\n1.0,1.0\n2.0,4.0\n");
        growing.append(&SQUARES, &[1.0, 2.0, 3.0]).unwrap();
        growing.append_new(&CUBES, &[3.0]).unwrap();
        growing.append_frame("frames", |out| out.write_all(b"two")).unwrap();
        drop(growing);
        assert_eq!(read("cubes.csv"), "x,cube\n2.0,8.0\n3.0,27.0\n");
        assert_eq!((read("squares.csv"), read("frames")), (table, frames));

        fs::write(root.path().join("frames"), "on").unwrap();
        let refused = Growing::resume(&folder, &lengths).unwrap_err().to_string();
        assert!(refused.contains("frames") && refused.contains("2 bytes, and had 3"), "{refused}");
        fs::remove_file(root.path().join("frames")).unwrap();
        assert!(Growing::resume(&folder, &lengths).unwrap_err().to_string().contains("frames"));
    }
}
