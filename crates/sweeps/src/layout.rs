//! The folder of a sweep: its files, and the study to which it belongs.
//!
//! | file | content |
//! | --- | --- |
//! | `study.toml` | the study, with the scene and all values |
//! | `shards.json` | the shards that write here, with their work |
//! | `points/KEY/replica-0001.record` | a finished replica |
//! | `points/KEY/replica-0001.partial/` | the checkpoint of a replica in progress |
//! | `points/KEY/report.html` | the page of a point, with its tables |
//! | `table.csv`, `summary.json`, `report.html` | the results of all points |

use std::{
    collections::BTreeMap,
    fs,
    io::{self, ErrorKind},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail, ensure};
use carom_runs::{
    folder_lock::FolderLock,
    output::{Existing, Folder},
    written_files::is_bookkeeping,
};
use serde::{Deserialize, Serialize};

use crate::{
    point::{Key, StudyPoint},
    shard::{Shard, Work},
    stored::{self, Found},
    study::{Size, Study},
};

/// Names of files.
pub(crate) const STUDY: &str = "study.toml";
const SHARDS: &str = "shards.json";
const POINTS: &str = "points";
const REPLICA: &str = "replica-";
const RECORD: &str = ".record";
const PARTIAL: &str = ".partial";

/// The shards that write into a folder, with the replicas of each by point.
pub type Shards = BTreeMap<Shard, BTreeMap<Key, Vec<u64>>>;

/// `shards.json`, as a list: JSON has no tables with other keys than text.
#[derive(Debug, Serialize, Deserialize)]
struct Entry {
    shard: Shard,
    replicas: BTreeMap<Key, Vec<u64>>,
}

/// A folder with a sweep.
#[derive(Debug)]
pub struct SweepFolder {
    /// The folder.
    pub folder: Folder,
}

/// Whether a folder holds a sweep.
pub fn is_sweep(path: &Path) -> bool {
    path.join(STUDY).is_file()
}

fn replica_name(replica: u64, ending: &str) -> String {
    format!("{REPLICA}{replica:04}{ending}")
}

/// Whether a folder holds nothing but a study that was being written when its process was killed.
fn is_just_begun(path: &Path) -> bool {
    let names = fs::read_dir(path)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.file_name());
    names
        .map(|name| name.to_string_lossy().into_owned())
        .all(|name| name.starts_with(STUDY) || is_bookkeeping(&name))
}

impl SweepFolder {
    /// Opens the folder of a sweep that exists.
    ///
    /// # Errors
    /// There is none.
    pub fn open(path: &Path) -> Result<Self> {
        ensure!(
            is_sweep(path),
            "{} holds no sweep: it has no {STUDY}",
            path.display()
        );
        Ok(Self {
            folder: Folder::create(path, Existing::Replace)?,
        })
    }

    /// Creates and locks the folder of a sweep, or continues a sweep of the same study. With
    /// [`Existing::Replace`] an earlier sweep is removed.
    ///
    /// # Errors
    /// The folder holds another study or other files, cannot be written, or another process uses
    /// it.
    pub fn claim(path: &Path, study: &Study, existing: Existing) -> Result<(Self, FolderLock)> {
        let shown = path.display();
        let (folder, lock) = Folder::claim_if(path, |path| {
            let is_open = is_sweep(path) || existing == Existing::Replace || is_just_begun(path);
            if is_open {
                Ok(())
            } else {
                Existing::Refuse.admit(path)
            }
        })?;
        let sweep = Self { folder };
        let was_sweep = is_sweep(path);
        if existing == Existing::Replace {
            let points = path.join(POINTS);
            if was_sweep && points.is_dir() {
                fs::remove_dir_all(&points)
                    .with_context(|| format!("cannot replace {}", points.display()))?;
            }
            // After the points: as long as there are some, the folder is that of a sweep.
            sweep.folder.remove_earlier()?;
            if was_sweep {
                sweep.folder.write(SHARDS, "[]\n")?;
            }
        } else if was_sweep {
            let there = sweep.study()?;
            study.refuse_other_subject(&there).with_context(|| {
                format!(
                    "{shown} holds the sweep of another study: choose another folder with --out, or --force"
                )
            })?;
        }
        Ok((sweep, lock))
    }

    /// The study of the sweep.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn study(&self) -> Result<Study> {
        Study::read(&self.folder.path().join(STUDY), Size::default())
    }

    /// The study as text; [`Study::text`] of the same study.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn study_text(&self) -> Result<String> {
        self.folder.read(STUDY)
    }

    /// Writes the study, before its first replica.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_study(&self, study: &Study) -> Result<()> {
        self.folder.write_lasting(STUDY, study.text())
    }

    /// The shards that write here.
    ///
    /// # Errors
    /// The file is there and cannot be read.
    pub fn shards(&self) -> Result<Shards> {
        if !self.folder.path().join(SHARDS).is_file() {
            return Ok(Shards::new());
        }
        let entries: Vec<Entry> =
            serde_json::from_str(&self.folder.read(SHARDS)?).context(SHARDS)?;
        Ok(entries
            .into_iter()
            .map(|Entry { shard, replicas }| (shard, replicas))
            .collect())
    }

    /// Writes the shards that write here.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_shards(&self, shards: &Shards) -> Result<()> {
        let entries: Vec<Entry> = shards
            .iter()
            .map(|(&shard, replicas)| Entry {
                shard,
                replicas: replicas.clone(),
            })
            .collect();
        self.folder
            .write_lasting(SHARDS, serde_json::to_string(&entries)?)
    }

    /// Path of the folder of a point, relative to that of the sweep.
    pub fn point_name(key: Key) -> String {
        format!("{POINTS}/{key}")
    }

    /// The folder of a point; it is created if necessary.
    ///
    /// # Errors
    /// It cannot be created.
    pub fn point(&self, key: Key) -> Result<Folder> {
        // Not listed among the files of the sweep: there may be thousands.
        self.folder.unlisted(&Self::point_name(key))
    }

    /// Path of the file of a finished replica.
    pub fn record(&self, work: Work) -> PathBuf {
        self.in_point(work, RECORD)
    }

    /// The replicas of which there are files, in the order of the folder.
    ///
    /// # Errors
    /// The folder cannot be listed.
    pub fn records(&self) -> Result<Vec<Work>> {
        let mut records = Vec::new();
        for (name, path) in names(&self.folder.path().join(POINTS))? {
            let Ok(key) = Key::try_from(name) else {
                continue;
            };
            for (name, _) in names(&path)? {
                let number = name
                    .strip_prefix(REPLICA)
                    .and_then(|rest| rest.strip_suffix(RECORD));
                let replica = number.and_then(|number| number.parse().ok());
                records.extend(replica.map(|replica| Work { key, replica }));
            }
        }
        Ok(records)
    }

    /// Path of the folder of a replica in progress.
    pub fn partial(&self, work: Work) -> PathBuf {
        self.in_point(work, PARTIAL)
    }

    /// The folder of a replica in progress; it is created if necessary.
    ///
    /// # Errors
    /// It cannot be created.
    pub fn partial_folder(&self, work: Work) -> Result<Folder> {
        self.point(work.key)?
            .unlisted(&replica_name(work.replica, PARTIAL))
    }

    fn in_point(&self, Work { key, replica }: Work, ending: &str) -> PathBuf {
        self.folder
            .path()
            .join(Self::point_name(key))
            .join(replica_name(replica, ending))
    }

    /// What is known of a replica.
    ///
    /// # Errors
    /// Its file cannot be read.
    pub fn find(&self, point: &StudyPoint, replica: u64) -> Result<Found> {
        let work = Work {
            key: point.key,
            replica,
        };
        stored::read(
            &self.record(work),
            work,
            &carom_runs::record::description(&point.scene),
        )
    }
}

/// The entries of a folder with their names; none where there is no such folder.
fn names(path: &Path) -> Result<Vec<(String, PathBuf)>> {
    let entries = match fs::read_dir(path) {
        Ok(entries) => entries,
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Ok(Vec::new());
        }
        Err(error) => {
            return Err(error)
                .with_context(|| format!("cannot read the folder {}", path.display()));
        }
    };
    let named = |entry: io::Result<fs::DirEntry>| {
        let entry = entry.with_context(|| format!("cannot read the folder {}", path.display()))?;
        Ok((
            entry.file_name().to_string_lossy().into_owned(),
            entry.path(),
        ))
    };
    entries.map(named).collect()
}

/// The replicas of a list of work by point.
pub fn by_point(work: impl IntoIterator<Item = Work>) -> BTreeMap<Key, Vec<u64>> {
    let mut points: BTreeMap<Key, Vec<u64>> = BTreeMap::new();
    for Work { key, replica } in work {
        points.entry(key).or_default().push(replica);
    }
    for replicas in points.values_mut() {
        replicas.sort_unstable();
    }
    points
}

/// Refuses a study that is not the same in all, with the first line that differs.
///
/// # Errors
/// See there.
pub fn refuse_other_text(first: &str, other: &str) -> Result<()> {
    match carom_runs::other_run::refuse_other(other, first) {
        Ok(()) => Ok(()),
        Err(error) => bail!("it is of another study: {error}"),
    }
}
