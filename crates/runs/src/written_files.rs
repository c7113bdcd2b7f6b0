//! The files that this program has written into an output folder: `--force` removes them and no
//! file of the user, and pages list them and no others.
//!
//! The name of each file is appended to [`LIST`], and flushed to disk, before the file is created,
//! so that the list is complete whenever the program is killed or the power is lost. The manifest
//! of a run that has ended holds the names instead.

use std::{
    collections::BTreeSet,
    fs::{self, OpenOptions},
    io::{self, Write as _},
    path::{Component, Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

use anyhow::{Context, Result};
use serde_json::Value;

use crate::{
    checkpoint_file,
    file_names::{CHECKPOINT, GROWTH, KNOWN, MANIFEST},
    folder_lock::LOCK,
    whole_file::part_of,
};

/// The names, one a line as JSON text, while a run has not ended.
pub const LIST: &str = ".carom-files";

/// States from which a run is resumed. They are not listed.
const STATES: [&str; 2] = [CHECKPOINT, GROWTH];

/// The files of one folder, with paths relative to it.
#[derive(Debug)]
pub struct WrittenFiles {
    folder: PathBuf,
    names: Mutex<Names>,
}

#[derive(Debug, Default)]
struct Names {
    /// Those of earlier processes that this one has not written.
    earlier: BTreeSet<String>,
    /// Those of this process.
    own: BTreeSet<String>,
    /// False if an older version of this program has written files and no list.
    is_complete: bool,
}

impl WrittenFiles {
    /// Reads which files earlier processes have written into a folder.
    pub fn read(folder: &Path) -> Self {
        let mut names = Names {
            is_complete: true,
            ..Names::default()
        };
        match (manifest(folder), folder.join(MANIFEST).exists()) {
            (Some(manifest), _) if manifest["files"].is_array() => {
                let files = manifest["files"].as_array().into_iter().flatten();
                names
                    .earlier
                    .extend(files.filter_map(Value::as_str).map(str::to_owned));
            }
            (Some(_), _) => {
                names.is_complete = false;
                names.earlier = names_without_list(folder);
            }
            // Damaged, or of another program.
            (None, is_there) => names.is_complete = !is_there || folder.join(LIST).exists(),
        }
        let list = fs::read_to_string(folder.join(LIST)).unwrap_or_default();
        // A line that was being written when its process was killed is no name.
        names.earlier.extend(
            list.lines()
                .filter_map(|line| serde_json::from_str::<String>(line).ok()),
        );
        Self {
            folder: folder.to_owned(),
            names: Mutex::new(names),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Names> {
        self.names.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a file that this process is about to write.
    ///
    /// # Errors
    /// The list cannot be written.
    pub fn add(&self, name: &str) -> Result<()> {
        let mut names = self.lock();
        if !names.own.insert(name.to_owned()) || names.earlier.remove(name) {
            return Ok(());
        }
        let path = self.folder.join(LIST);
        // The first line end closes a line that a killed process has left.
        let line = format!("\n{}\n", Value::from(name));
        let list = OpenOptions::new().create(true).append(true).open(&path);
        list.and_then(|mut list| {
            list.write_all(line.as_bytes())
                .and_then(|()| list.sync_data())
        })
        .with_context(|| format!("cannot write {}", path.display()))
    }

    /// All names in their order; `None` if an older version of this program has written files and
    /// no list.
    pub fn names(&self) -> Option<Vec<String>> {
        let names = self.lock();
        names
            .is_complete
            .then(|| names.earlier.union(&names.own).cloned().collect())
    }

    /// Removes the list, once the manifest holds its names.
    ///
    /// # Errors
    /// The file cannot be removed.
    pub fn end(&self) -> Result<()> {
        remove(&self.folder.join(LIST))
    }

    /// Removes the files of earlier processes that this one has not written, and folders that are
    /// empty then. The manifest stays until it is replaced.
    ///
    /// # Errors
    /// A file cannot be removed.
    pub fn remove_earlier(&self) -> Result<()> {
        let mut names = self.lock();
        let mut folders = BTreeSet::new();
        for name in names
            .earlier
            .iter()
            .filter(|name| *name != MANIFEST && is_inside(name))
        {
            let path = self.folder.join(name);
            remove(&path)?;
            remove(&part_of(&path))?;
            folders.extend(
                Path::new(name)
                    .parent()
                    .filter(|inner| !inner.as_os_str().is_empty())
                    .map(Path::to_owned),
            );
        }
        // The innermost come last.
        for folder in folders.iter().rev().map(|inner| self.folder.join(inner)) {
            remove_states(&folder)?;
            // One with files of the user stays.
            let _ = fs::remove_dir(folder);
        }
        let manifest = names.earlier.take(MANIFEST);
        (names.earlier, names.is_complete) = (manifest.into_iter().collect(), true);
        Ok(())
    }

    /// Removes the states from which the earlier run would be resumed.
    ///
    /// # Errors
    /// A file cannot be removed.
    pub fn remove_states(&self) -> Result<()> {
        remove_states(&self.folder)
    }

    /// Removes all files of this process, with its list and its lock.
    ///
    /// # Errors
    /// A file cannot be removed.
    pub fn remove_own(&self) -> Result<()> {
        remove_states(&self.folder)?;
        let own = std::mem::take(&mut self.lock().own);
        for name in own
            .iter()
            .map(String::as_str)
            .filter(|name| is_inside(name))
            .chain([LIST, LOCK])
        {
            remove(&self.folder.join(name))?;
            remove(&part_of(&self.folder.join(name)))?;
        }
        Ok(())
    }
}

/// Whether a folder holds nothing but what a process has left that was killed before it wrote a
/// manifest: a run can be started there.
///
/// # Errors
/// The folder cannot be read.
pub fn is_unstarted(folder: &Path) -> Result<bool> {
    let cannot = || format!("cannot read the folder {}", folder.display());
    let written = WrittenFiles::read(folder).names().unwrap_or_default();
    let part = part_of(Path::new(MANIFEST));
    for entry in fs::read_dir(folder).with_context(cannot)? {
        let entry = entry.with_context(cannot)?;
        let (name, path) = (entry.file_name(), entry.path());
        let own = name.to_string_lossy();
        let stem = own.strip_suffix(".part").unwrap_or(&own);
        let is_left = is_bookkeeping(&own)
            || name == part.as_os_str()
            || own != MANIFEST && written.iter().any(|known| known == stem)
            || is_empty_folder(&path);
        if !is_left {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Whether a file of this name in an output folder serves this program alone.
pub fn is_bookkeeping(name: &str) -> bool {
    [LOCK, LIST].contains(&name)
}

fn is_empty_folder(path: &Path) -> bool {
    fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none())
}

/// The manifest of a run of this program in a folder.
fn manifest(folder: &Path) -> Option<Value> {
    let text = fs::read_to_string(folder.join(MANIFEST)).ok()?;
    let manifest: Value = serde_json::from_str(&text).ok()?;
    (manifest["program"] == "carom").then_some(manifest)
}

/// What a version of this program that kept no list has certainly written.
fn names_without_list(folder: &Path) -> BTreeSet<String> {
    let tables = fs::read_to_string(folder.join("tables.json")).unwrap_or_default();
    let tables: Value = serde_json::from_str(&tables).unwrap_or_default();
    let files = tables
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|table| table["file"].as_str());
    files
        .chain(KNOWN.map(|(name, _)| name))
        .map(str::to_owned)
        .collect()
}

/// Whether a relative path stays inside its folder.
fn is_inside(name: &str) -> bool {
    !name.is_empty()
        && Path::new(name)
            .components()
            .all(|part| matches!(part, Component::Normal(_)))
}

fn remove_states(folder: &Path) -> Result<()> {
    for path in STATES.map(|name| folder.join(name)) {
        if checkpoint_file::is_one(&path) {
            remove(&path)?;
        }
    }
    Ok(())
}

/// Removes a file or a link; one that is not there is no error, and a folder stays.
fn remove(path: &Path) -> Result<()> {
    if path.is_dir() && !path.is_symlink() {
        return Ok(());
    }
    match fs::remove_file(path) {
        Err(error)
            if !matches!(
                error.kind(),
                io::ErrorKind::NotFound | io::ErrorKind::NotADirectory
            ) =>
        {
            Err(error).with_context(|| format!("cannot remove {}", path.display()))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_a_killed_process_are_known_and_removed_and_no_others() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        let write = |name: &str| fs::write(at(name), "x").unwrap();
        let first = WrittenFiles::read(root.path());
        fs::create_dir(at("inner")).unwrap();
        for name in ["a.csv", "b.csv", "inner/c.csv"] {
            first.add(name).unwrap();
            write(name);
        }
        first.add("../outside").unwrap();
        write("letter.txt");
        // The line of the next file is cut.
        OpenOptions::new()
            .append(true)
            .open(at(LIST))
            .unwrap()
            .write_all(b"\n\"d.c")
            .unwrap();

        let second = WrittenFiles::read(root.path());
        second.add("b.csv").unwrap();
        second.add("e.csv").unwrap();
        assert_eq!(
            second.names().unwrap(),
            ["../outside", "a.csv", "b.csv", "e.csv", "inner/c.csv"]
        );
        second.remove_earlier().unwrap();
        assert_eq!(second.names().unwrap(), ["b.csv", "e.csv"]);
        let mut left: Vec<_> = fs::read_dir(root.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name())
            .collect();
        left.sort();
        assert_eq!(left, [LIST, "b.csv", "letter.txt"]);
        let third = WrittenFiles::read(root.path());
        assert!(
            third.names().unwrap().contains(&"e.csv".to_owned()),
            "the cut line hides no later one"
        );
    }

    #[test]
    fn what_a_killed_process_leaves_before_its_manifest_counts_as_not_started() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        let is_unstarted = || is_unstarted(root.path()).unwrap();
        assert!(is_unstarted());
        fs::create_dir(at("inner")).unwrap();
        fs::write(at(LOCK), "").unwrap();
        fs::write(at("manifest.json.part"), "{").unwrap();
        WrittenFiles::read(root.path()).add("config.toml").unwrap();
        fs::write(at("config.toml"), "").unwrap();
        assert!(is_unstarted());
        fs::write(at("config.toml.part"), "").unwrap();
        assert!(is_unstarted());
        fs::write(at("scene.toml"), "").unwrap();
        assert!(!is_unstarted(), "a file of the user");
        fs::remove_file(at("scene.toml")).unwrap();
        fs::write(at(MANIFEST), "").unwrap();
        assert!(!is_unstarted(), "a run has begun");
    }

    #[test]
    fn a_folder_of_an_older_version_loses_what_that_has_certainly_written() {
        let root = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(root.path().join(name), text).unwrap();
        write(MANIFEST, r#"{"program":"carom","complete":true}"#);
        write(
            "tables.json",
            r#"[{"file":"energy.csv"},{"file":"/tmp/x"}]"#,
        );
        for name in ["energy.csv", "price.json", "energy-notes.csv"] {
            write(name, "x");
        }
        let written = WrittenFiles::read(root.path());
        assert_eq!(written.names(), None);
        written.remove_earlier().unwrap();
        assert_eq!(written.names().unwrap(), [MANIFEST]);
        let mut left: Vec<_> = fs::read_dir(root.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name())
            .collect();
        left.sort();
        assert_eq!(left, ["energy-notes.csv", MANIFEST]);
    }
}
