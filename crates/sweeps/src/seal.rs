//! The seal of a folder of results: a file with the hashes of all others and of the sums from which
//! they come.
//!
//! Results are trusted only if their seal fits. It is written last and flushed to disk; the other
//! files are not, so a loss of power may leave them empty, and they are then written again from the
//! sums.

use std::{collections::BTreeMap, fs, io};

use anyhow::{Context, Result};
use carom_runs::{checkpoint_file::encode, output::Folder, record::Record};
use serde::{Deserialize, Serialize};

use crate::hash::fnv1a;

/// Name of the file. Pages do not list hidden files.
const SEAL: &str = ".seal.json";

/// Files of replicas, which have checksums of their own.
const OF_REPLICAS: &str = "replica-";

/// The content of the file.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seal {
    /// The hash of what the results come from.
    source: u64,
    /// The hash of each file.
    files: BTreeMap<String, u64>,
}

impl Seal {
    /// The hash of the sums of a point and of the title of its page, for this version of the
    /// program.
    ///
    /// # Errors
    /// The sums cannot be encoded.
    pub fn of_source(title: &str, record: &Record) -> Result<u64> {
        let parts: [&[u8]; 4] = [
            carom::VERSION.as_bytes(),
            title.as_bytes(),
            record.what.as_bytes(),
            &encode(&record.runs)?,
        ];
        let hashes: Vec<u8> = parts
            .iter()
            .flat_map(|part| fnv1a(part).to_le_bytes())
            .collect();
        Ok(fnv1a(&hashes))
    }

    /// Whether the folder has a seal of this source, and exactly the files that it names.
    pub fn is_intact(folder: &Folder, source: u64) -> bool {
        let written = folder
            .read(SEAL)
            .ok()
            .and_then(|text| serde_json::from_str::<Self>(&text).ok());
        written.is_some_and(|written| {
            files(folder).is_ok_and(|files| Self { source, files } == written)
        })
    }

    /// Writes the seal of the files as they are; it is on disk when this returns.
    ///
    /// # Errors
    /// A file cannot be read or written.
    pub fn write(folder: &Folder, source: u64) -> Result<()> {
        let seal = Self {
            source,
            files: files(folder)?,
        };
        folder.write_lasting(SEAL, serde_json::to_string(&seal)?)
    }

    /// Removes the seal, before a file changes.
    ///
    /// # Errors
    /// It is there and cannot be removed.
    pub fn remove(folder: &Folder) -> Result<()> {
        let path = folder.path().join(SEAL);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(error).with_context(|| format!("cannot replace {}", path.display()))
            }
            _ => Ok(()),
        }
    }
}

/// The hashes of all results in a folder.
fn files(folder: &Folder) -> Result<BTreeMap<String, u64>> {
    let context = || format!("cannot read the folder {}", folder.path().display());
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder.path()).with_context(context)? {
        let entry = entry.with_context(context)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with(OF_REPLICAS) || name.starts_with('.') || !entry.path().is_file() {
            continue;
        }
        let bytes = fs::read(entry.path())
            .with_context(|| format!("cannot read {}", entry.path().display()))?;
        files.insert(name, fnv1a(&bytes));
    }
    Ok(files)
}
