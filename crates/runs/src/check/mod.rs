//! `carom check`: what is in a scene, what its run will cost, and where it stands between the
//! limits of the numbers.

mod actions;
pub(crate) mod aligned;
mod answers;
mod collisions;
mod contents;
mod costs;
pub mod limits;
mod trial;
mod unplaced;

use std::{ops::ControlFlow, path::Path};

use anyhow::{Context, Result};
use carom::{Scene, SceneError, View, engine::Placement as Start};
use carom_methods::{AnySimulation, Method};
use carom_tables::Verdict;
use clap::Args;
use serde::Serialize;

use self::{
    aligned::{bytes, duration, short, table},
    answers::{Answers, mean_speed},
    collisions::ExpectedCollisions,
    contents::CheckedContents,
    costs::Cost,
    limits::Limit,
    trial::{Trial, TrialEstimate},
    unplaced::Unplaced,
};
use crate::{
    console::{is_json, put},
    interruption::Signals,
    measures::Measures,
    print_line,
    remarks::remarks,
    run::{self, SceneFile, continued, parent::Parent, placement::BodyPlacement},
};

/// Options of `carom check`.
#[derive(Debug, Clone, Args)]
pub struct CheckOptions {
    /// The scene file and changes to it
    #[command(flatten)]
    pub file: SceneFile,
    /// Print all: bodies by kind, what is paid for, and the limits of the numbers
    #[arg(long)]
    pub verbose: bool,
}

/// What is known about a scene before its run.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Report {
    scene: String,
    method: String,
    is_exact: bool,
    /// The price of a method that is not exact.
    price: Option<&'static str>,
    /// What is most likely not meant.
    remarks: Vec<String>,
    contents: CheckedContents,
    costs: Vec<Cost>,
    limits: Vec<Limit>,
    /// Tiles that several threads can run, or the reason why there are none.
    tiles: String,
    expected: ExpectedCollisions,
    estimate: TrialEstimate,
    answers: Answers,
}

/// Reads a scene, places its molecules, runs it for about a second, and prints its content, its
/// cost and its limits; of millions of bodies, their number and the memory that they need.
///
/// # Errors
/// The scene is invalid or cannot run, with the words of `carom run`.
pub fn run(options: &CheckOptions) -> Result<Verdict> {
    let file = &options.file;
    let parent = Parent::find(file.from.as_deref(), Path::new(""), false)?;
    let scene = file.read(parent.as_ref())?;
    let method = Method::try_from(&scene.method).context("[method]")?;
    let name = file.path.display().to_string();
    let unplaced = if parent.is_none() {
        Unplaced::new(name, &scene, &method)?
    } else {
        None
    };
    let text = if let Some(unplaced) = unplaced {
        put("check", &unplaced);
        unplaced.text()
    } else {
        let report = report(file, &scene, &method, parent.as_ref())?;
        put("check", &report);
        if options.verbose {
            report.text()
        } else {
            report.short_text()
        }
    };
    if !is_json() {
        print_line(&text);
    }
    Ok(Verdict::Passed)
}

fn report(
    file: &SceneFile,
    scene: &Scene,
    method: &Method,
    parent: Option<&Parent>,
) -> Result<Report> {
    let mut notes = if parent.is_none() {
        remarks(scene)
    } else {
        Vec::new()
    };
    let (begun, before) = if let Some(parent) = parent {
        (continued(parent, scene, method)?, parent.actions)
    } else {
        let (begun, is_stand_in) =
            placed(scene, method).with_context(|| format!("scene {}", file.path.display()))?;
        notes.extend(is_stand_in.then(|| STAND_IN.to_owned()));
        (begun, 0)
    };
    let (mut simulation, measures, _) = run::start(begun, scene, before)?;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let tiling = method.tiling(threads);
    simulation.set_tiling(&tiling);
    let tiles = format!("{}, on {threads} threads", simulation.tile_use());
    let view = simulation.view();
    let contents = CheckedContents::new(scene, &view);
    let costs = costs::costs(scene, &view, &measures, &contents);
    let (limits, expected) = (
        limits::limits(scene, &view),
        ExpectedCollisions::new(scene, &view),
    );
    let speed = mean_speed(&view);
    let mut all_measured = Measures::new(&measured(scene), &view)?;
    let trial = Trial::run(&mut simulation, &mut all_measured, &scene.run, &tiling)?;
    // The measures of the trial may hold contacts that a run writes to files.
    let estimate = trial.estimate(&mut simulation, &measures, scene, &contents, &expected)?;
    let answers = Answers::new(scene, &contents, &estimate, speed);
    Ok(Report {
        scene: file.path.display().to_string(),
        method: method.to_string(),
        is_exact: method.is_exact(),
        price: costs::price(method),
        remarks: notes,
        contents,
        costs,
        limits,
        tiles,
        expected,
        estimate,
        answers,
    })
}

/// What is said of a start on a lattice in the place of a grown or relaxed one.
const STAND_IN: &str = "The run grows or relaxes its gas first, which takes longer than this check: the figures here \
                        are those of a start on a lattice.";

/// The bodies of a scene at its start. A gas that the run grows or relaxes stands on a lattice
/// instead, if that has room for it, and the second value is true. Its rate of collisions is that
/// of the fluid within a factor of 1.5.
fn placed(scene: &Scene, method: &Method) -> Result<(AnySimulation, bool)> {
    let (signals, mut store) = (Signals::default(), |_: &_| Ok(()));
    let mut place =
        |scene: &Scene| BodyPlacement::new(method, &signals, NEVER, &mut store).place(scene);
    let start = &scene.start;
    if start.from.is_some() {
        return Ok((place(scene)?, false));
    }
    // The first step of growth or relaxation comes after all that could be refused.
    let begun = AnySimulation::with_progress(scene, method, &mut |_| ControlFlow::Break(()));
    match begun {
        Ok(begun) => return Ok((begun, false)),
        Err(SceneError::Interrupted) => {}
        Err(error) => return Err(error.into()),
    }
    let mut on_lattice = scene.clone();
    (on_lattice.start.placement, on_lattice.start.relax) = (Some(Start::Lattice), None);
    match place(&on_lattice) {
        Ok(begun) => Ok((begun, true)),
        Err(_) => Ok((place(scene)?, false)),
    }
}

/// The number of collisions until the end of a run that theory expects, from the state at its
/// start; `None` without thermal motion.
pub fn expected_collisions(scene: &Scene, view: &View<'_>) -> Option<f64> {
    ExpectedCollisions::new(scene, view).number
}

/// The scene with all of its run measured, so that a short trial has the cost of the measures.
fn measured(scene: &Scene) -> Scene {
    let mut measured = scene.clone();
    measured.run.measure_from = 0.0.into();
    measured
        .stage
        .iter_mut()
        .for_each(|stage| stage.measure = true);
    measured
}

/// A growth is not stored.
const NEVER: std::time::Duration = std::time::Duration::MAX;

impl Report {
    /// Ten lines, and what is most likely not meant.
    fn short_text(&self) -> String {
        let warning = if self.is_exact { "" } else { " (NOT EXACT)" };
        let method = format!("{}{warning}", self.method);
        let lines = self
            .answers
            .lines(&self.contents, &self.estimate, &method, &self.tiles);
        let head = format!("{}: valid (--verbose prints more)", self.scene);
        let remarks = self.remarks.iter().map(|remark| format!("  {remark}"));
        [head, lines]
            .into_iter()
            .chain(remarks)
            .collect::<Vec<_>>()
            .join("\n")
    }

    fn text(&self) -> String {
        let warning = if self.is_exact { "" } else { ": NOT EXACT" };
        let price = self
            .price
            .map_or_else(String::new, |price| format!("\n  price  {price}"));
        let head = format!("{}: valid\n{}", self.scene, self.contents.text());
        let remarks: Vec<String> = self
            .remarks
            .iter()
            .map(|remark| format!("  {remark}"))
            .collect();
        let sections = [
            ("Remarks", remarks.join("\n")),
            (
                "Method",
                format!("  {}{warning}{price}\n  tiles  {}", self.method, self.tiles),
            ),
            ("Paid for", self.costs(true)),
            ("Not paid for", self.costs(false)),
            ("Limits", self.limits()),
            ("Expected", self.expectations()),
        ];
        let filled = sections.into_iter().filter(|(_, lines)| !lines.is_empty());
        let text = filled.map(|(title, lines)| format!("{title}\n{lines}"));
        std::iter::once(head)
            .chain(text)
            .collect::<Vec<_>>()
            .join("\n\n")
    }

    fn costs(&self, is_paid: bool) -> String {
        let costs = self.costs.iter().filter(|cost| cost.is_paid == is_paid);
        table(costs.map(|cost| [cost.what.to_owned(), cost.words.clone()]))
    }

    fn limits(&self) -> String {
        let head = ["quantity", "value", "tested to", "allowed to", "origin"].map(str::to_owned);
        let number = |limit: Option<f64>| limit.map_or_else(|| "-".to_owned(), short);
        let rows = self.limits.iter().map(|row| {
            let value = format!("{} {}", short(row.value), row.verdict());
            [
                row.quantity.to_owned(),
                value.trim_end().to_owned(),
                number(row.tested),
                number(row.allowed),
                row.origin.to_owned(),
            ]
        });
        table(std::iter::once(head).chain(rows))
    }

    fn expectations(&self) -> String {
        let Self {
            expected, estimate, ..
        } = self;
        let number = |number: Option<f64>| number.map_or_else(|| "unknown".to_owned(), short);
        let at_most = if estimate.is_epoch_measured {
            ""
        } else {
            "at most "
        };
        let trial = if estimate.is_whole_run {
            "counted: the trial is the whole run".to_owned()
        } else {
            let (collisions, time) = (estimate.trial_collisions, estimate.trial_time);
            format!(
                "at the rate of a trial: {collisions} in a time of {}",
                short(time)
            )
        };
        let seconds = match estimate.seconds {
            Some(seconds) => format!("about {} of processor time", duration(seconds)),
            None => "unknown: the trial made no progress in time".to_owned(),
        };
        let rows = [
            ["collisions", &number(expected.number), &expected.source].map(str::to_owned),
            ["", &number(estimate.collisions), &trial].map(str::to_owned),
            [
                "time".to_owned(),
                seconds,
                format!(
                    "{} collisions a second; {} for samples and snapshots",
                    short(estimate.collisions_per_second),
                    duration(estimate.sample_seconds)
                ),
            ],
            [
                "epoch".to_owned(),
                format!("{at_most}{}", duration(estimate.epoch_seconds)),
                "checkpoints are written at its end".to_owned(),
            ],
            [
                "memory".to_owned(),
                bytes(estimate.memory),
                format!(
                    "bodies and their events; at the end {} more for samples",
                    bytes(estimate.series)
                ),
            ],
            [
                "checkpoint".to_owned(),
                bytes(estimate.checkpoint),
                format!("at the end {} more for samples", bytes(estimate.series)),
            ],
        ];
        let optional = [snapshots_row(estimate), thermostats_row(estimate)];
        table(rows.into_iter().chain(optional.into_iter().flatten()))
    }
}

/// The row of the snapshots, if the run writes any.
fn snapshots_row(estimate: &TrialEstimate) -> Option<[String; 3]> {
    (estimate.snapshots > 0).then(|| {
        [
            "snapshots".to_owned(),
            bytes(estimate.snapshots),
            String::new(),
        ]
    })
}

/// The row of the thermostats, if the run has any.
fn thermostats_row(estimate: &TrialEstimate) -> Option<[String; 3]> {
    let actions = estimate.actions.as_ref()?;
    let share = 100.0 * actions.seconds / estimate.seconds.unwrap_or(f64::INFINITY).max(1e-9);
    Some([
        "thermostats".to_owned(),
        duration(actions.seconds),
        format!(
            "{} actions on {} bodies in all, {share:.1} % of the time",
            actions.count, actions.motions
        ),
    ])
}
