//! What a run folder holds, read from its files. A missing file is named and not an error: the
//! folder of a run that has not ended has few.

use std::{collections::BTreeSet, fs};

use anyhow::{Context, Result};
use carom::Scene;
use carom_report::page::DataChart;
use carom_tables::{Check, Figure, OneRun, ReportUnits, Summary, Table, Totals};
use serde::Deserialize as _;
use serde_json::Value;

use super::{
    read::{json, text},
    tables_file,
};
use crate::{
    animation::ANIMATION,
    file_names::PICTURES,
    left_out::LeftOut,
    output::{Folder, MANIFEST},
    price::{PRICE, Price},
    units::units,
    whole_box::MAPS,
};

/// The figure of the time at which the measurement started.
pub const MEASURED_FROM: &str = "measured from";

/// How a run has ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FolderState {
    /// At its end.
    Ended,
    /// With an error.
    Failed(String),
    /// Not at all, or not yet.
    Unfinished,
}

/// What wrote a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FolderKind {
    /// `carom run`.
    Run,
    /// `carom merge`.
    Merge,
    /// `carom sweep`, and the commands that write a study and run it.
    Sweep,
    /// Another command.
    Experiment,
}

/// The files of a folder that a page shows.
#[derive(Debug)]
pub(super) struct FolderContents {
    pub kind: FolderKind,
    pub state: FolderState,
    /// The command that repeats the run.
    pub again: String,
    /// `config.toml`.
    pub configuration: String,
    /// The scene in it.
    pub scene: Option<Scene>,
    pub summary: Option<Summary>,
    /// The time from which on the run was measured, if it was found.
    pub measured_from: Option<f64>,
    /// The units in which the page shows figures and tables, if they are not those of the scene.
    pub units: Option<ReportUnits>,
    /// What merged runs lack.
    pub left_out: LeftOut,
    pub tables: Vec<Table>,
    /// Drawings of the measures.
    pub drawings: Vec<DataChart>,
    /// Pictures of the first and the last state.
    pub pictures: [Option<String>; 2],
    /// Maps of the whole box at the end.
    pub maps: [Option<String>; 2],
    pub animation: Option<String>,
    /// What a method other than the default saves and gets wrong.
    pub price: Option<Price>,
    /// Merged runs: header and rows of `runs.csv`.
    pub runs: Vec<Vec<String>>,
    /// The files and the pages of folders inside, in order of their names.
    pub names: Vec<String>,
    /// Files without which the page is incomplete.
    pub missing: Vec<&'static str>,
}

/// Table of the runs in a folder of merged runs.
pub const RUNS: &str = "runs.csv";

impl FolderContents {
    /// Reads a folder. `state` is that of a run that is about to end; otherwise it is read from the
    /// manifest.
    ///
    /// # Errors
    /// A file is there and cannot be read.
    pub fn read(folder: &Folder, state: Option<FolderState>) -> Result<Self> {
        let manifest = json(folder, MANIFEST)?.unwrap_or_default();
        let again = manifest["again"].as_str().unwrap_or_default().to_owned();
        let kind = match kind_of(&again) {
            // A sweep merges the replicas of each point.
            FolderKind::Sweep if folder.path().join(RUNS).is_file() => FolderKind::Merge,
            kind => kind,
        };
        let configuration = text(folder, "config.toml")?.unwrap_or_default();
        let is_scene = matches!(kind, FolderKind::Run | FolderKind::Merge);
        let scene = Scene::from_toml(&configuration).ok().filter(|_| is_scene);
        let summary_file = json(folder, "summary.json")?;
        let summary = summary_file.as_ref().map(summary_of);
        // A sweep has other entries of these names.
        let left_out = summary_file
            .filter(|_| kind == FolderKind::Merge)
            .map(LeftOut::deserialize);
        let animation = match &scene {
            Some(scene) if kind == FolderKind::Run && scene.run.animation => {
                text(folder, ANIMATION)?
            }
            _ => None,
        };
        // A folder that another version has written may ask for units that this one refuses.
        let units = scene.as_ref().and_then(|scene| units(scene).ok().flatten());
        let [start, end] = PICTURES.map(|name| text(folder, name));
        let [density, order] = MAPS.map(|(name, _)| text(folder, name));
        let mut contents = Self {
            kind,
            state: state.unwrap_or_else(|| state_of(&manifest)),
            again,
            configuration,
            scene,
            measured_from: summary.as_ref().and_then(measured_from),
            summary,
            units,
            left_out: left_out.and_then(Result::ok).unwrap_or_default(),
            tables: tables_file::tables(folder)?,
            drawings: tables_file::drawings(folder)?,
            pictures: [start?, end?],
            maps: [density?, order?],
            animation,
            price: json(folder, PRICE)?
                .filter(|_| kind == FolderKind::Run)
                .map(serde_json::from_value)
                .transpose()
                .context(PRICE)?,
            runs: runs_of(&text(folder, RUNS)?.unwrap_or_default()),
            names: names(folder)?,
            missing: Vec::new(),
        };
        contents.missing = contents.find_missing();
        Ok(contents)
    }

    /// The figures and tables in [`Self::units`], for the page of the folder itself.
    pub fn in_own_units(mut self) -> Self {
        let Some(units) = self.units else { return self };
        for figure in self
            .summary
            .iter_mut()
            .flat_map(|summary| &mut summary.figures)
        {
            units.apply_to_figure(figure);
        }
        for table in &mut self.tables {
            units.apply_to_table(table);
        }
        self
    }

    fn find_missing(&self) -> Vec<&'static str> {
        let has = |name: &str| self.names.iter().any(|other| other == name);
        let mut needed = vec!["config.toml", "summary.json", "tables.json"];
        if self.kind == FolderKind::Run {
            needed.extend(PICTURES);
            // A run that fails before the animation starts has none.
            let is_shown = self.scene.as_ref().is_some_and(|scene| scene.run.animation);
            needed.extend(
                (is_shown && !matches!(self.state, FolderState::Failed(_))).then_some(ANIMATION),
            );
        }
        needed.retain(|name| !has(name));
        needed
    }
}

fn measured_from(summary: &Summary) -> Option<f64> {
    let mut figures = summary.figures.iter();
    Some(figures.find(|figure| figure.name == MEASURED_FROM)?.value)
}

/// The command in the words that repeat the run.
fn kind_of(again: &str) -> FolderKind {
    let words: Vec<&str> = again.split(' ').collect();
    let is = |command: &str| match words.as_slice() {
        ["cargo", "xtask", name, ..] | ["carom", name, ..] => *name == command,
        _ => false,
    };
    let sweeps = ["sweep", "brownian", "billiard"].map(|name| (name, FolderKind::Sweep));
    let mut kinds = [("run", FolderKind::Run), ("merge", FolderKind::Merge)]
        .into_iter()
        .chain(sweeps);
    kinds
        .find(|(command, _)| is(command))
        .map_or(FolderKind::Experiment, |(_, kind)| kind)
}

fn state_of(manifest: &Value) -> FolderState {
    match (manifest["complete"].as_bool(), manifest["error"].as_str()) {
        (_, Some(error)) => FolderState::Failed(error.to_owned()),
        (Some(true), None) => FolderState::Ended,
        _ => FolderState::Unfinished,
    }
}

/// The files in a folder that carom has written, where it is known which, and the pages of folders
/// inside.
fn names(folder: &Folder) -> Result<Vec<String>> {
    let context = || format!("cannot read the folder {}", folder.path().display());
    let written = folder.written().map(BTreeSet::from_iter);
    let is_own = |name: &String| {
        written
            .as_ref()
            .is_none_or(|written: &BTreeSet<String>| written.contains(name))
    };
    let mut names = Vec::new();
    for entry in fs::read_dir(folder.path()).with_context(context)? {
        let entry = entry.with_context(context)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if !entry.path().is_dir() {
            names.extend(is_own(&name).then_some(name));
        } else if entry.path().join(super::PAGE).is_file() {
            names.push(format!("{name}/{}", super::PAGE));
        }
    }
    names.sort();
    Ok(names)
}

fn runs_of(text: &str) -> Vec<Vec<String>> {
    text.lines()
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect()
}

/// A number; JSON has null for one that is not finite.
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn string(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

/// The content of `summary.json`; what is not there is empty.
fn summary_of(value: &Value) -> Summary {
    let list = |key: &str| value[key].as_array().cloned().unwrap_or_default();
    let check = |check: &Value| Check {
        name: string(&check["name"]),
        found: number(&check["found"]),
        allowed: number(&check["allowed"]),
        passed: check["passed"] == true,
    };
    let figure = |figure: &Value| Figure {
        name: string(&figure["name"]),
        value: number(&figure["value"]),
        standard_error: figure["standard_error"].as_f64(),
        unit: string(&figure["unit"]),
        prediction: figure["prediction"].as_f64(),
        source: figure["source"].as_str().map(str::to_owned),
        smallest_difference: figure["smallest_difference"].as_f64(),
        stationarity: serde_json::from_value(figure["stationarity"].clone()).ok(),
        quantity: None,
        blocks: None,
        is_test: figure["is_test"] == true,
    };
    let run = |run: &Value| OneRun {
        name: string(&run["name"]),
        collisions: run["collisions"].as_u64().unwrap_or(0),
        cpu_seconds: number(&run["cpu_seconds"]),
    };
    Summary {
        title: string(&value["title"]),
        note: string(&value["note"]),
        totals: Totals {
            collisions: value["collisions"].as_u64().unwrap_or(0),
            simulated_time: number(&value["simulated_time"]),
            collisions_per_second: number(&value["collisions_per_second"]),
            energy_drift: number(&value["energy_drift"]),
            allowed_drift: value["allowed_drift"].as_f64().unwrap_or(0.0),
            overlapping_pairs: value["overlapping_pairs"].as_u64().unwrap_or(0) as usize,
            max_overlap: number(&value["max_overlap"]),
        },
        checks: list("checks").iter().map(check).collect(),
        figures: list("figures").iter().map(figure).collect(),
        runs: list("runs").iter().map(run).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_tells_what_wrote_a_folder() {
        assert_eq!(kind_of("carom run out/a/config.toml"), FolderKind::Run);
        assert_eq!(kind_of("cargo xtask run x --from run"), FolderKind::Run);
        assert_eq!(kind_of("carom merge run out"), FolderKind::Merge);
        assert_eq!(
            kind_of("cargo xtask experiment brownian --out run"),
            FolderKind::Experiment
        );
        assert_eq!(kind_of(""), FolderKind::Experiment);
    }

    #[test]
    fn a_summary_is_read_as_it_was_written() {
        let figure = Figure::new("pressure", 0.1 + 0.2, "energy/length²")
            .error(1e-3)
            .predicted(0.3, "theory");
        let summary = Summary {
            title: "t".to_owned(),
            note: "n".to_owned(),
            totals: Totals {
                collisions: 7,
                simulated_time: 2.5,
                overlapping_pairs: 3,
                ..Totals::default()
            },
            checks: vec![Check::at_most("x", 1.0, 0.0)],
            figures: vec![
                figure,
                Figure {
                    smallest_difference: Some(0.25),
                    is_test: true,
                    ..Figure::new("drift", 0.0, "1")
                },
            ],
            runs: vec![OneRun {
                name: "a".to_owned(),
                collisions: 3,
                cpu_seconds: 0.5,
            }],
        };
        assert_eq!(
            summary_of(&serde_json::to_value(&summary).unwrap()),
            summary
        );
        let check = Check::at_most("x", f64::NAN, 0.0);
        let read = summary_of(&serde_json::json!({ "checks": [check] }));
        assert!(read.checks[0].found.is_nan() && !read.checks[0].passed);
    }
}
