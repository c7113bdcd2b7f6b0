//! The runs in the folders of a merge, and what is missing or damaged among them.

use std::{
    io::ErrorKind,
    path::{Path, PathBuf},
};

use anyhow::{Context, Error, Result, bail};

use crate::{
    checkpoint_file::FileError,
    folder_lock::FolderLock,
    left_out::{Damaged, LeftOut, MissingRun, command_of},
    output::MANIFEST,
    progress::Progress,
    record::{Record, SUMS},
};

/// What the folders of a merge hold.
#[derive(Debug)]
pub(super) struct MergedParts<'a> {
    /// All runs.
    pub record: Record,
    /// The folders from which they come.
    pub folders: Vec<&'a Path>,
    /// What the other folders lack.
    pub left_out: LeftOut,
}

/// Reads the runs of all folders. A run that has not ended, and sums that cannot be used, are left
/// out. Each folder is locked while it is read.
///
/// # Errors
/// Another process writes into a folder; a folder is no folder of a run, or the system cannot read
/// its file; the scenes differ; a run is
/// there twice; no run is left.
pub(super) fn read(folders: &[PathBuf]) -> Result<MergedParts<'_>> {
    let mut record: Option<Record> = None;
    let (mut kept, mut left_out) = (Vec::new(), LeftOut::default());
    let progress = Progress::items("runs", folders.len() as u64);
    for folder in folders {
        // A folder that is not there has no sums.
        let _lock = if folder.is_dir() {
            Some(FolderLock::shared(folder)?)
        } else {
            None
        };
        match Record::read(folder) {
            Ok(part) => {
                kept.push(folder.as_path());
                match &mut record {
                    None => record = Some(part),
                    Some(all) => {
                        all.merge(part)
                            .with_context(|| format!("cannot merge {}", folder.display()))?;
                    }
                }
            }
            Err(error) => leave_out(folder, error, &mut left_out)?,
        }
        progress.count(1);
    }
    match record {
        Some(record) => Ok(MergedParts {
            record,
            folders: kept,
            left_out,
        }),
        None if left_out.is_empty() => bail!("there are no folders"),
        None => bail!("there is nothing to merge: {}", left_out.words().join(" ")),
    }
}

/// Counts a folder without usable sums.
///
/// # Errors
/// `error`, if the folder holds no run or the system cannot read it.
fn leave_out(folder: &Path, error: Error, left_out: &mut LeftOut) -> Result<()> {
    let again = command_of(folder);
    if let Some(FileError::Unreadable(cause)) = error.chain().find_map(|cause| cause.downcast_ref())
    {
        if cause.kind() != ErrorKind::NotFound || !folder.join(MANIFEST).is_file() {
            return Err(error);
        }
        left_out.missing.push(MissingRun {
            folder: folder.to_owned(),
            again,
        });
        return Ok(());
    }
    // The first context names the file, which `Damaged` names too.
    let causes: Vec<String> = error.chain().skip(1).map(ToString::to_string).collect();
    left_out.damaged.push(Damaged {
        file: folder.join(SUMS),
        content: format!("The run in {}", folder.display()),
        reason: causes.join(": "),
        again,
    });
    Ok(())
}
