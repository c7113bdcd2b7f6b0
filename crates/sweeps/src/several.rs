//! `carom sweep`: one study, or several, each in a folder inside, with one page of their verdicts.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail, ensure};
use carom_report::page::{Page, PagePart};
use carom_runs::{
    console::put,
    folder_lock::FolderLock,
    interruption::Interrupted,
    manifest::Manifest,
    output::{Existing, Folder},
    print_line,
};
use carom_tables::Verdict;
use cpu_time::ProcessTime;
use serde_json::{Value, json};

use crate::sweep::{self, SweepOptions};

/// File with the names of the studies in the folder of all. A folder with it is continued.
const STUDIES: &str = "studies.json";

/// The results of a study, and of all.
const SUMMARY: &str = "summary.json";

/// Runs all replicas of each study that have not ended, or those of a shard, and writes the
/// results.
///
/// # Errors
/// A study is invalid, a folder holds another study, a replica ended with an error, a file cannot
/// be written, or a signal has been received. What has ended is kept.
pub fn run(options: &SweepOptions) -> Result<Verdict> {
    match &files(&options.studies)?[..] {
        [study] => sweep::run(study, options),
        studies => run_all(studies, options),
    }
}

/// The study files that paths name: a folder names the files in it that end with `.toml`, in the
/// order of their names.
///
/// # Errors
/// A folder cannot be read or has no study.
fn files(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let cannot = || format!("cannot read the folder {}", path.display());
        let entries = fs::read_dir(path)
            .with_context(cannot)?
            .collect::<Result<Vec<_>, _>>();
        let inner = entries
            .with_context(cannot)?
            .into_iter()
            .map(|entry| entry.path());
        let mut inner: Vec<_> = inner
            .filter(|inner| inner.extension().is_some_and(|ending| ending == "toml"))
            .collect();
        ensure!(
            !inner.is_empty(),
            "{} holds no study: no file in it ends with .toml",
            path.display()
        );
        inner.sort();
        files.extend(inner);
    }
    Ok(files)
}

/// How a study ended.
#[derive(Debug)]
struct Row {
    /// Name of the study and of its folder.
    name: String,
    ended: Result<Verdict, String>,
    /// Its `summary.json`; null without results.
    summary: Value,
}

/// Runs studies one after another. One that ends with an error does not keep the others from
/// running.
///
/// # Errors
/// A study is invalid, two have one name, a study ended with an error, a file cannot be written, or
/// a signal has been received.
fn run_all(studies: &[PathBuf], options: &SweepOptions) -> Result<Verdict> {
    let names: Vec<String> = studies
        .iter()
        .map(|study| sweep::name(study, options))
        .collect();
    let distinct: BTreeSet<&String> = names.iter().collect();
    refuse_equal_names(&names, &distinct)?;
    // All are validated before the first one runs.
    studies
        .iter()
        .try_for_each(|study| options.read(study).map(drop))?;
    let resumption = &options.how.choices.resumption;
    let path = resumption.folder("out/sweeps");
    let (folder, _lock) = claim(&path, &distinct, resumption.existing())?;
    let again = sweep::command(studies, options, &path);
    let manifest = Manifest::write_new(&folder, &again, &[])?;
    folder.write_json(STUDIES, &names)?;
    let begun = ProcessTime::now();
    let mut rows = Vec::new();
    for (study, name) in studies.iter().zip(names) {
        rows.push(run_one(study, name, options, &path)?);
    }
    if options.how.is_whole() {
        write(&folder, &rows, &again)?;
    }
    manifest.complete(&folder, begun.elapsed().as_secs_f64())?;
    let mut errors = rows
        .iter()
        .filter_map(|row| Some((&row.name, row.ended.as_ref().err()?)));
    if let Some((name, error)) = errors.next() {
        let others = errors.count();
        let more = if others > 0 {
            format!("; and {others} more")
        } else {
            String::new()
        };
        bail!("study {name}: {error}{more}");
    }
    Ok(worst(&rows))
}

/// Refuses two studies of one name.
fn refuse_equal_names(names: &[String], distinct: &BTreeSet<&String>) -> Result<()> {
    if let Some(twice) = distinct
        .iter()
        .find(|name| names.iter().filter(|other| other == *name).count() > 1)
    {
        bail!("two studies are called {twice}, but each needs a folder of its own: rename one");
    }
    Ok(())
}

/// Runs one study in its folder inside the folder of all. Its own error is part of the row.
///
/// # Errors
/// Its results cannot be read, or a signal has been received.
fn run_one(study: &Path, name: String, options: &SweepOptions, folder: &Path) -> Result<Row> {
    print_line(&format!("{name}:"));
    let ended = sweep::run(study, &inside(options, folder.join(&name)));
    let ended = match ended {
        Err(error)
            if error
                .chain()
                .any(<dyn std::error::Error>::is::<Interrupted>) =>
        {
            return Err(error);
        }
        ended => ended.map_err(|error| format!("{error:#}")),
    };
    let has_results = ended.is_ok() && options.how.is_whole();
    let summary = if has_results {
        summary(&folder.join(&name))?
    } else {
        Value::Null
    };
    Ok(Row {
        name,
        ended,
        summary,
    })
}

/// Claims the folder of all studies. One that an earlier command has written is continued.
fn claim(
    path: &Path,
    names: &BTreeSet<&String>,
    existing: Existing,
) -> Result<(Folder, FolderLock)> {
    let there = fs::read_to_string(path.join(STUDIES)).unwrap_or_default();
    let there: Vec<String> = serde_json::from_str(&there).unwrap_or_default();
    if existing == Existing::Replace
        && let Some(other) = there
            .iter()
            .find(|name| !names.contains(name) && path.join(name).is_dir())
    {
        bail!(
            "{} also holds the study {other}: remove its folder, or choose another with --out",
            path.display()
        );
    }
    let existing = if there.is_empty() || existing == Existing::Replace {
        existing
    } else {
        Existing::Resume
    };
    Folder::claim(path, existing)
}

/// The options of one study in its folder.
fn inside(options: &SweepOptions, folder: PathBuf) -> SweepOptions {
    let mut inside = options.clone();
    inside.how.choices.resumption.destination.out = Some(folder);
    inside
}

fn summary(folder: &Path) -> Result<Value> {
    let path = folder.join(SUMMARY);
    let context = || format!("cannot read {}", path.display());
    let text = fs::read_to_string(&path).with_context(context)?;
    serde_json::from_str(&text).with_context(context)
}

/// The worst verdict of all.
fn worst(rows: &[Row]) -> Verdict {
    let is = |verdict: Verdict| rows.iter().any(|row| row.ended == Ok(verdict));
    [Verdict::Failed, Verdict::Incomplete]
        .into_iter()
        .find(|verdict| is(*verdict))
        .unwrap_or(Verdict::Passed)
}

impl Row {
    fn checks(&self) -> &[Value] {
        self.summary["checks"].as_array().map_or(&[], Vec::as_slice)
    }

    /// Names of the checks that failed, or the error.
    fn reasons(&self) -> impl Iterator<Item = &str> {
        let failed = self.checks().iter().filter(|check| check["passed"] != true);
        failed
            .filter_map(|check| check["name"].as_str())
            .chain(self.ended.as_ref().err().map(String::as_str))
    }

    /// Its cells in the table of all studies.
    fn cells(&self) -> Vec<String> {
        let collisions = self.summary["collisions"].as_u64().unwrap_or(0);
        let numbers = [
            self.checks().len() as u64,
            self.reasons().count() as u64,
            collisions,
        ];
        let numbers = numbers.map(|number| number.to_string());
        [self.name.clone(), self.verdict().to_owned()]
            .into_iter()
            .chain(numbers)
            .collect()
    }

    fn verdict(&self) -> &'static str {
        self.ended
            .as_ref()
            .map_or("error", |verdict| verdict.word())
    }
}

/// Page and summary: the verdict of each study, and what differs.
fn write(folder: &Folder, rows: &[Row], again: &str) -> Result<()> {
    let mut page = Page::new(
        "Studies",
        "Each study with its verdict; their pages are linked below.",
    );
    let passed = rows
        .iter()
        .filter(|row| row.ended == Ok(Verdict::Passed))
        .count();
    page.verdict(&match rows.len() - passed {
        0 => format!("All {passed} studies passed."),
        failed => format!("{failed} of {} studies did not pass.", rows.len()),
    });
    for row in rows {
        row.reasons()
            .for_each(|reason| page.error(&format!("{}: {reason}", row.name)));
    }
    page.part(PagePart::Answer);
    let header = ["study", "verdict", "checks", "failed", "collisions"];
    let cells: Vec<_> = rows.iter().map(Row::cells).collect();
    page.table(&header, &cells);
    for cells in std::iter::once(&header.map(str::to_owned).to_vec()).chain(&cells) {
        print_line(&format!(
            "{:<32}{:<11}{:>7}{:>7}{:>14}",
            cells[0], cells[1], cells[2], cells[3], cells[4]
        ));
    }
    page.files(&list_files(rows));
    page.code(again);
    let checks: Vec<&Value> = rows.iter().flat_map(Row::checks).collect();
    // Each study has put its own: the last one's would be taken for those of all.
    put("folder", &folder.path());
    put("page", &folder.path().join("report.html"));
    put("checks", &checks);
    let studies = rows.iter().map(|row| {
        json!({
            "study": row.name, "verdict": row.verdict(), "error": row.ended.as_ref().err(),
            "collisions": row.summary["collisions"], "points": row.summary["points"],
        })
    });
    let studies: Vec<Value> = studies.collect();
    folder.write_json(
        SUMMARY,
        &json!({ "title": "Studies", "checks": checks, "studies": studies }),
    )?;
    folder.write("report.html", page.html())
}

/// The pages of the studies and the summary of all, each with what it holds.
fn list_files(rows: &[Row]) -> Vec<(String, String)> {
    let mut files: Vec<_> = rows
        .iter()
        .filter(|row| row.ended.is_ok())
        .map(|row| {
            (
                format!("{}/report.html", row.name),
                format!("the page of the study {}", row.name),
            )
        })
        .collect();
    files.push((
        SUMMARY.to_owned(),
        "what was expected and found in all studies".to_owned(),
    ));
    files
}
