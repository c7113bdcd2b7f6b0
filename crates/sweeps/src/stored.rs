//! The file of a finished replica: its sums, with what identifies it and a checksum.
//!
//! The file is written under another name, flushed to disk and renamed: its presence means that the
//! replica has ended. A file that is damaged all the same is found by its checksum.

use std::{io, path::Path};

use anyhow::{Result, ensure};
use carom_runs::{
    checkpoint_file::{self, CheckpointBody, FileError, encode},
    record::Record,
};
use serde::{Deserialize, Serialize};

use crate::shard::Work;

/// A finished replica.
#[derive(Debug, Clone, PartialEq)]
pub struct Stored {
    /// What it is.
    pub work: Work,
    /// Its sums, tables and figures. Its totals hold the time at which it ended.
    pub record: Record,
    /// Processor time of its run (seconds): the only part that differs between two runs of it.
    pub seconds: f64,
}

/// The first value of a file.
#[derive(Debug, Serialize, Deserialize)]
struct Head {
    work: Work,
    seconds: f64,
}

/// What is in the place of a file.
#[derive(Debug)]
pub enum Found {
    /// No file.
    Nothing,
    /// A file that is no finished replica of this program, with the reason.
    Damaged(String),
    /// A file that a newer program wrote, with the reason. It must not be replaced.
    Newer(String),
    /// A finished replica.
    Finished(Box<Stored>),
}

impl Stored {
    /// Writes the file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let head = Head {
            work: self.work,
            seconds: self.seconds,
        };
        checkpoint_file::write(path, &[&encode(&head)?, &encode(&self.record)?])
    }

    /// Whether two files are of the same run: equal to the bit in all but the time that they took.
    ///
    /// # Errors
    /// A record cannot be encoded.
    pub fn is_same(&self, other: &Self) -> Result<bool> {
        Ok(self.work == other.work && encode(&self.record)? == encode(&other.record)?)
    }
}

/// Reads the file of a replica of the scene `what`, see
/// [`description`](carom_runs::record::description).
///
/// # Errors
/// The file is there, but the system cannot read it.
pub fn read(path: &Path, work: Work, what: &str) -> Result<Found> {
    let mut body = match CheckpointBody::read(path) {
        Ok(body) => body,
        Err(FileError::Unreadable(error)) if error.kind() == io::ErrorKind::NotFound => {
            return Ok(Found::Nothing);
        }
        Err(error @ FileError::Unreadable(_)) => {
            return Err(anyhow::Error::from(error).context(path.display().to_string()));
        }
        Err(error @ FileError::Newer { .. }) => return Ok(Found::Newer(error.to_string())),
        Err(error) => return Ok(Found::Damaged(error.to_string())),
    };
    let mut take = || -> Result<Stored> {
        let Head {
            work: there,
            seconds,
        } = body.take()?;
        let record = Record::take(&mut body)?;
        ensure!(
            seconds.is_finite() && seconds >= 0.0,
            "its processor time is {seconds} s"
        );
        ensure!(
            there == work,
            "it is replica {} of point {}",
            there.replica,
            there.key
        );
        ensure!(
            record.what == what && record.runs.len() == 1,
            "it is of another scene"
        );
        Ok(Stored {
            work,
            record,
            seconds,
        })
    };
    Ok(take().map_or_else(
        |error| Found::Damaged(format!("{error:#}")),
        |stored| Found::Finished(Box::new(stored)),
    ))
}
