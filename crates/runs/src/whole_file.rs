//! Files that are written aside and renamed, so that a reader never sees a part of one.

use std::{
    fs::{self, File},
    io::{self, BufWriter, Write as _},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};

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
        folder
            .sync_all()
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// Writes a file piece by piece under another name and renames it, so that readers never see a
/// partial file.
///
/// # Errors
/// The error of `write`, or the file cannot be written; no file is left then.
pub fn write_streamed(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<()>,
) -> Result<()> {
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
    let aside = part_of(path);
    let written = write(&aside).and_then(|()| fs::rename(&aside, path));
    if written.is_err() {
        // A partial file is useless; a failure to remove it is ignored.
        let _ = fs::remove_file(&aside);
    }
    written.with_context(|| format!("cannot write {}", path.display()))
}

/// The name under which a file is written before it is renamed.
pub(crate) fn part_of(path: &Path) -> PathBuf {
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    part.into()
}
