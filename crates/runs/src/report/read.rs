//! Reads files of a folder that may be missing.

use std::{fs, io};

use anyhow::{Context, Result};
use serde_json::Value;

use crate::output::Folder;

/// The text of a file; `None` if it is missing.
pub(super) fn text(folder: &Folder, name: &str) -> Result<Option<String>> {
    let path = folder.path().join(name);
    match fs::read_to_string(&path) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error).with_context(|| format!("cannot read {}", path.display())),
    }
}

/// The JSON of a file; `None` if it is missing.
pub(super) fn json(folder: &Folder, name: &str) -> Result<Option<Value>> {
    let Some(text) = text(folder, name)? else {
        return Ok(None);
    };
    let read = serde_json::from_str(&text);
    read.with_context(|| format!("cannot read {}", folder.path().join(name).display()))
        .map(Some)
}
