//! The summary of a sweep, read from its folder: what was measured and expected at each point, and
//! whether it holds.

use std::{fs, path::Path};

use anyhow::{Context, Result};
use serde::Deserialize;

use crate::{expect::ExpectationAnswer, point::short_label};

/// The file of a summary in the folder of a sweep.
pub const SUMMARY: &str = "summary.json";

/// What `summary.json` says of a sweep.
#[derive(Debug, Clone, Deserialize)]
pub struct SweepSummary {
    /// Title of its page.
    pub title: String,
    /// First note to the reader; may be empty.
    #[serde(default)]
    pub note: String,
    /// Number of contacts of all replicas.
    pub collisions: u64,
    /// Contacts per second of processor time; `None` without contacts.
    pub collisions_per_second: Option<f64>,
    /// Number of points of the study, and of those that are complete.
    pub points_wanted: usize,
    /// Number of complete points.
    pub points_complete: usize,
    /// All checks: of the runs, and of what is expected.
    pub checks: Vec<CheckResult>,
    /// The points, in their order.
    pub points: Vec<PointSummary>,
}

/// A check with its result.
#[derive(Debug, Clone, Deserialize)]
pub struct CheckResult {
    /// Its name.
    pub name: String,
    /// Whether it passed.
    pub passed: bool,
}

/// The results of one point.
#[derive(Debug, Clone, Deserialize)]
pub struct PointSummary {
    /// Its values in words.
    pub label: String,
    /// What was expected of it.
    #[serde(default)]
    pub answers: Vec<ExpectationAnswer>,
}

impl PointSummary {
    /// The values in words, with the last part of each path.
    pub fn short_label(&self) -> String {
        short_label(&self.label)
    }
}

impl SweepSummary {
    /// Reads the summary of the sweep in this folder.
    ///
    /// # Errors
    /// The file cannot be read, or is not that of a sweep.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(SUMMARY);
        let context = || format!("cannot read {}", path.display());
        let text = fs::read_to_string(&path).with_context(context)?;
        serde_json::from_str(&text).with_context(context)
    }

    /// Processor time of all replicas (seconds).
    pub fn cpu_seconds(&self) -> f64 {
        let rate = self.collisions_per_second.filter(|rate| *rate > 0.0);
        rate.map_or(0.0, |rate| self.collisions as f64 / rate)
    }

    /// Answers that are judged, each with its point.
    pub fn judged(&self) -> impl Iterator<Item = (&PointSummary, &ExpectationAnswer)> {
        self.points
            .iter()
            .flat_map(PointSummary::answers_of)
            .filter(|(_, answer)| !answer.show_only)
    }

    /// What does not hold: names of failed checks, and points without results.
    pub fn faults(&self) -> Vec<String> {
        let failed = self.checks.iter().filter(|check| !check.passed);
        let mut faults: Vec<String> = failed.map(|check| check.name.clone()).collect();
        if self.points_complete < self.points_wanted {
            faults.push(format!(
                "only {} of {} points are complete",
                self.points_complete, self.points_wanted
            ));
        }
        faults
    }
}

impl PointSummary {
    fn answers_of(point: &Self) -> impl Iterator<Item = (&Self, &ExpectationAnswer)> {
        point.answers.iter().map(move |answer| (point, answer))
    }
}
