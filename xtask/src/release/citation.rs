//! The files by which the program is cited: `CITATION.cff` and `codemeta.json` name its version.

use std::{fs, path::Path};

use anyhow::{Context, Result, ensure};
use serde_json::Value;

/// Keys without which a citation file is not read.
const CFF_KEYS: [&str; 6] = [
    "cff-version: 1.2.0",
    "message: ",
    "title: ",
    "authors:",
    "type: software",
    "license",
];

/// Keys of `codemeta.json`.
const CODEMETA_KEYS: [&str; 9] = [
    "@context",
    "@type",
    "name",
    "description",
    "license",
    "author",
    "programmingLanguage",
    "referencePublication",
    "version",
];

/// Verifies that both files have what readers need, and name this version.
///
/// # Errors
/// A file cannot be read, lacks a key, or names another version.
pub fn check(root: &Path, version: &str) -> Result<()> {
    let read = |name: &str| {
        fs::read_to_string(root.join(name)).with_context(|| format!("cannot read {name}"))
    };
    let cff = read("CITATION.cff")?;
    let has_line = |beginning: &str| cff.lines().any(|line| line.starts_with(beginning));
    for key in CFF_KEYS {
        ensure!(
            has_line(key),
            "CITATION.cff has no line that begins '{key}'"
        );
    }
    ensure!(
        has_line(&format!("version: {version}")),
        "CITATION.cff names another version than {version}"
    );
    let codemeta: Value = serde_json::from_str(&read("codemeta.json")?).context("codemeta.json")?;
    for key in CODEMETA_KEYS {
        ensure!(!codemeta[key].is_null(), "codemeta.json has no \"{key}\"");
    }
    ensure!(
        codemeta["version"] == version,
        "codemeta.json names the version {}, not {version}",
        codemeta["version"]
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repository;

    #[test]
    fn the_citation_files_are_complete_and_name_the_version() {
        let root = repository::root().unwrap();
        check(root, carom::VERSION).unwrap();
        let other = check(root, "99.0.0").unwrap_err().to_string();
        assert!(other.contains("another version"), "{other}");
    }
}
