//! Results in a folder: their content apart from times, and files that are torn or left over.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use carom_runs::checkpoint_file::CheckpointBody;
use carom_sweeps::shard::Work;
use serde_json::Value;

/// Files without results: the manifest describes processes, the checkpoint depends on their times,
/// the seal has the hashes of both.
const WITHOUT_RESULTS: [&str; 3] = ["manifest.json", "checkpoint", ".seal.json"];

/// Beginning of the names of files that processes leave for others, such as locks.
const OF_PROCESSES: &str = ".carom-";

/// Parts of the lines that hold times.
const CLOCKS: [&str; 4] = [
    "collisions_per_second",
    "per processor second",
    "cpu_seconds",
    "class=\"speed\"",
];

/// The content of each file with results in a folder and below, by path; without times.
pub type FileContents = BTreeMap<String, Vec<u8>>;

/// All files in a folder and below, except those of processes.
///
/// # Errors
/// A folder cannot be read.
pub fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        let context = || format!("cannot read the folder {}", next.display());
        for entry in fs::read_dir(&next).with_context(context)? {
            let path = entry.with_context(context)?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if path.is_dir() {
                folders.push(path);
            } else if !name.starts_with(OF_PROCESSES) {
                files.push(path);
            }
        }
    }
    files.sort();
    Ok(files)
}

/// The results in a folder.
///
/// # Errors
/// A file cannot be read.
pub fn contents(folder: &Path) -> Result<FileContents> {
    let mut contents = FileContents::new();
    for path in files(folder)? {
        let name = path
            .strip_prefix(folder)
            .unwrap_or(&path)
            .display()
            .to_string();
        let is_left_out = WITHOUT_RESULTS.iter().any(|other| path.ends_with(other));
        if !is_left_out {
            contents.insert(name, without_times(&path)?);
        }
    }
    Ok(contents)
}

fn without_times(path: &Path) -> Result<Vec<u8>> {
    if ending(path) == "record"
        && let Ok(mut body) = CheckpointBody::read(path)
        && body.take::<(Work, f64)>().is_ok()
    {
        return Ok(body.rest().to_vec());
    }
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let Ok(text) = std::str::from_utf8(&bytes) else {
        return Ok(bytes);
    };
    let lines = text
        .split_inclusive('\n')
        .filter(|line| !CLOCKS.iter().any(|clock| line.contains(clock)));
    Ok(lines.collect::<String>().into_bytes())
}

/// The first difference between two folders, in words.
pub fn difference(found: &FileContents, expected: &FileContents) -> Option<String> {
    let missing = expected.keys().find(|name| !found.contains_key(*name));
    let added = found.keys().find(|name| !expected.contains_key(*name));
    if let Some(name) = missing {
        return Some(format!("{name} is missing"));
    }
    if let Some(name) = added {
        return Some(format!("{name} is there, but not in an undisturbed run"));
    }
    let (name, other) = expected
        .iter()
        .find(|(name, content)| found[*name] != **content)?;
    let content = &found[name];
    let at = content
        .iter()
        .zip(other)
        .position(|(found, expected)| found != expected);
    let at = at.unwrap_or_else(|| content.len().min(other.len()));
    let (lengths, nul) = (
        (content.len(), other.len()),
        content.contains(&0) && !other.contains(&0),
    );
    let nul = if nul { ", and has zero bytes" } else { "" };
    Some(format!(
        "{name} differs from byte {at} of {} (expected: {} bytes){nul}",
        lengths.0, lengths.1
    ))
}

/// The first file of a finished folder that is torn or left over, in words.
///
/// # Errors
/// A file cannot be read.
pub fn damage(folder: &Path) -> Result<Option<String>> {
    for path in files(folder)? {
        let bytes = fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
        if let Some(fault) = fault_of(&path, &bytes) {
            let name = path.strip_prefix(folder).unwrap_or(&path);
            return Ok(Some(format!("{}: {fault}", name.display())));
        }
    }
    Ok(None)
}

fn fault_of(path: &Path, bytes: &[u8]) -> Option<&'static str> {
    if ending(path) == "part" {
        return Some("a partial file is left");
    }
    let text = std::str::from_utf8(bytes);
    let is_text = ["json", "toml", "csv", "svg", "html", "extxyz"].contains(&ending(path));
    if is_text && bytes.contains(&0) {
        return Some("it has zero bytes");
    }
    let text = match text {
        Ok(text) => text,
        Err(_) if is_text => return Some("it is not text"),
        Err(_) => "",
    };
    let is_whole = match ending(path) {
        "json" => serde_json::from_str::<Value>(text).is_ok(),
        "toml" => text.parse::<toml::Table>().is_ok(),
        "csv" | "extxyz" => text.is_empty() || text.ends_with('\n'),
        "svg" => text.trim_end().ends_with("</svg>"),
        "html" => text.trim_end().ends_with("</html>"),
        "record" => CheckpointBody::read(path).is_ok(),
        _ if path.ends_with("checkpoint") || path.ends_with("sums") => {
            CheckpointBody::read(path).is_ok()
        }
        _ => true,
    };
    let is_open = path.ends_with("manifest.json")
        && !serde_json::from_str::<Value>(text).is_ok_and(|manifest| manifest["complete"] == true);
    match (is_whole, is_open) {
        (false, _) => Some("it is torn"),
        (true, true) => Some("it does not say that the run is complete"),
        (true, false) => None,
    }
}

fn ending(path: &Path) -> &str {
    path.extension()
        .and_then(|ending| ending.to_str())
        .unwrap_or_default()
}

/// Copies the files of a folder and below into another, which is created.
///
/// # Errors
/// A file cannot be read or written.
pub fn copy(from: &Path, to: &Path) -> Result<()> {
    let context = || format!("cannot copy {}", from.display());
    fs::create_dir_all(to).with_context(context)?;
    for entry in fs::read_dir(from).with_context(context)? {
        let path = entry.with_context(context)?.path();
        let target = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy(&path, &target)?;
        } else {
            fs::copy(&path, &target).with_context(|| format!("cannot copy {}", path.display()))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_left_out_and_other_differences_found() {
        let root = tempfile::tempdir().unwrap();
        let folders = ["a", "b"].map(|name| root.path().join(name));
        for (folder, speed) in folders.iter().zip([1, 2]) {
            fs::create_dir(folder).unwrap();
            fs::write(
                folder.join("s.json"),
                format!("{{\n\"cpu_seconds\": {speed},\n\"a\": 1\n}}\n"),
            )
            .unwrap();
        }
        let [a, b] = folders.each_ref().map(|folder| contents(folder).unwrap());
        assert_eq!(difference(&a, &b), None);
        fs::write(folders[0].join("s.json"), "{\n\"a\": 2\n}\n").unwrap();
        let changed = contents(&folders[0]).unwrap();
        assert!(
            difference(&changed, &b)
                .unwrap()
                .starts_with("s.json differs")
        );
        fs::write(folders[0].join("x.csv"), "").unwrap();
        assert!(
            difference(&contents(&folders[0]).unwrap(), &b)
                .unwrap()
                .starts_with("x.csv is there")
        );
    }

    #[test]
    fn torn_files_and_left_ones_are_found() {
        for (name, content, is_whole) in [
            ("a.json", "{\"a\": 1}", true),
            ("a.json", "{\"a\": ", false),
            ("manifest.json", "{\"complete\": true}", true),
            ("manifest.json", "{\"complete\": false}", false),
            ("a.csv", "x\n1\n", true),
            ("a.csv", "x\n1", false),
            ("a.csv", "x\n\0\0\n", false),
            ("report.html", "", false),
            ("a.svg", "<svg></svg>\n", true),
            ("b.csv.part", "x\n", false),
            ("sums", "", false),
        ] {
            let root = tempfile::tempdir().unwrap();
            fs::write(root.path().join(name), content).unwrap();
            assert_eq!(
                damage(root.path()).unwrap().is_none(),
                is_whole,
                "{name}: {content}"
            );
        }
    }
}
