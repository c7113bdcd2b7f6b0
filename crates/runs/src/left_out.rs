//! What a merge leaves out: runs that have not ended, and files that it cannot use.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{
    console::{print_line, put},
    output::MANIFEST,
};

/// A run that is not there.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MissingRun {
    /// Its folder.
    pub folder: PathBuf,
    /// The command that made the folder; empty if it is unknown.
    pub again: String,
}

impl MissingRun {
    /// What is missing, with the remedy.
    pub fn words(&self) -> String {
        format!(
            "Missing is the run in {}: it has not ended. {}",
            self.folder.display(),
            remedy("To continue it", &self.again, " --resume")
        )
    }
}

/// A file that is there and cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Damaged {
    /// The file.
    pub file: PathBuf,
    /// What it should hold, such as a replica of a point.
    pub content: String,
    /// Why it cannot be used.
    pub reason: String,
    /// The command that made it; empty if it is unknown.
    pub again: String,
}

impl Damaged {
    /// What is left out and why, with the remedy.
    pub fn words(&self) -> String {
        let Self {
            file,
            content,
            reason,
            again,
        } = self;
        format!(
            "{content} is left out: {}: {reason}. {}",
            file.display(),
            remedy("To run it again", again, "")
        )
    }
}

fn remedy(begin: &str, again: &str, option: &str) -> String {
    match again {
        "" => format!("{begin}, use the command that made its folder."),
        again => format!("{begin}: {again}{option}"),
    }
}

/// What a merge of runs leaves out.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct LeftOut {
    /// Runs that have not ended.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<MissingRun>,
    /// Files that cannot be used.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub damaged: Vec<Damaged>,
}

impl LeftOut {
    /// Whether nothing is left out.
    pub fn is_empty(&self) -> bool {
        self.missing.is_empty() && self.damaged.is_empty()
    }

    /// All that is left out, in words.
    pub fn words(&self) -> Vec<String> {
        let missing = self.missing.iter().map(MissingRun::words);
        missing
            .chain(self.damaged.iter().map(Damaged::words))
            .collect()
    }
}

/// Adds what is missing, damaged and remarkable to the JSON object, or prints it among the results,
/// which `--quiet` keeps.
pub fn announce(missing: &impl Serialize, damaged: &[Damaged], notes: &[String]) {
    put("missing", missing);
    put("damaged", &damaged);
    put("notes", &notes);
    if !crate::console::is_json() {
        for text in notes {
            print_line(text);
        }
    }
}

/// The command that made a folder, from its manifest; empty if it has none.
pub fn command_of(folder: &Path) -> String {
    let text = std::fs::read_to_string(folder.join(MANIFEST)).unwrap_or_default();
    let manifest: Value = serde_json::from_str(&text).unwrap_or_default();
    manifest["again"].as_str().unwrap_or_default().to_owned()
}
