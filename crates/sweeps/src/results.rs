//! The results of a sweep: the merged replicas of each point, one point at a time.

use anyhow::{Context, Result};
use carom_report::page::DataChart;
use carom_runs::{
    console::note,
    manifest::Manifest,
    merge::{MergedRuns, calibrations},
    output::Folder,
    progress::Progress,
    record::Record,
    report,
};
use carom_tables::{Calibration, Check, Figure, Summary, Table, Totals};
use rayon::{ThreadPool, prelude::*};
use serde::Serialize;

use crate::{
    expect::ExpectationAnswer,
    layout::SweepFolder,
    point::{Key, StudyPoint, short_label},
    seal::Seal,
    stored::Found,
    study::Study,
};

/// The page of a study of at most so many points has their main charts. More: it would be long, and
/// the figures over the points are its answer.
const FEW_POINTS: usize = 4;

/// The page of a study of at most so many points draws the curves of all of them in one chart.
/// More: no colour is found again in the legend.
const MAX_OVERLAID: usize = 12;

/// The results of one point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PointResults {
    /// The point.
    pub point: Key,
    /// Its values in words.
    pub label: String,
    /// The replicas that have ended, in ascending order.
    pub replicas: Vec<u64>,
    /// Figures over all its replicas.
    pub figures: Vec<Figure>,
    /// Totals over all its replicas.
    pub totals: Totals,
    /// Checks of all its replicas.
    pub checks: Vec<Check>,
    /// What was expected of it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub answers: Vec<ExpectationAnswer>,
    /// Standard errors against the scatter of its replicas; empty with fewer than 30.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<Calibration>,
    /// The charts that carry its answer, of a study of few points.
    #[serde(skip)]
    pub evidence: Vec<DataChart>,
    /// Its tables, of a study of several points whose curves fit into one chart.
    #[serde(skip)]
    pub tables: Vec<Table>,
    /// First note of its runs, such as that the method is not exact.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub note: String,
}

impl PointResults {
    /// A point of which no replica has ended.
    fn without_replicas(point: &StudyPoint) -> Self {
        Self {
            point: point.key,
            label: point.label.clone(),
            replicas: Vec::new(),
            figures: Vec::new(),
            totals: Totals::default(),
            checks: Vec::new(),
            answers: Vec::new(),
            errors: Vec::new(),
            evidence: Vec::new(),
            tables: Vec::new(),
            note: String::new(),
        }
    }

    /// The values in words, with the last part of each path.
    pub fn short_label(&self) -> String {
        short_label(&self.label)
    }
}

/// Merges the replicas of each point, and writes its page with tables unless it is there already.
/// No more than one point for each thread is in memory. Points without replicas have no figures.
///
/// # Errors
/// A file cannot be read or written.
pub fn of_points(
    sweep: &SweepFolder,
    study: &Study,
    (manifest, again): (&Manifest, &str),
    pool: &ThreadPool,
) -> Result<Vec<PointResults>> {
    let progress = Progress::items("points", study.points.len() as u64);
    let of_point = |index: usize| {
        let results = of_point(sweep, study, index, (manifest, again));
        progress.count(1);
        results.with_context(|| format!("point {}", study.points[index].label))
    };
    pool.install(|| {
        (0..study.points.len())
            .into_par_iter()
            .map(of_point)
            .collect()
    })
}

fn of_point(
    sweep: &SweepFolder,
    study: &Study,
    index: usize,
    (manifest, again): (&Manifest, &str),
) -> Result<PointResults> {
    let point = &study.points[index];
    let (record, seconds, replicas) = merge_replicas(sweep, point, study.replicas)?;
    let Some(record) = record else {
        return Ok(PointResults::without_replicas(point));
    };
    let (key, label) = (point.key, point.label.clone());
    let plural = if replicas.len() == 1 { "" } else { "s" };
    let title = format!("{label}: {} replica{plural}", replicas.len());
    let merged = MergedRuns::new(&record, title, seconds);
    let folder = sweep.point(key)?;
    write_unless_there(&folder, &merged, (&record, seconds), (manifest, again))?;
    let answers = study.answers(index, &merged.summary.figures, merged.tables());
    let errors = calibrations(&record);
    let evidence = if study.points.len() <= FEW_POINTS {
        evidence(&folder, &SweepFolder::point_name(key))?
    } else {
        Vec::new()
    };
    let is_overlaid = (2..=MAX_OVERLAID).contains(&study.points.len());
    let tables = if is_overlaid {
        merged.tables().to_vec()
    } else {
        Vec::new()
    };
    let Summary {
        figures,
        totals,
        checks,
        note,
        ..
    } = merged.summary;
    let point = key;
    Ok(PointResults {
        point,
        label,
        replicas,
        figures,
        totals,
        checks,
        answers,
        errors,
        evidence,
        tables,
        note,
    })
}

/// The sums of all replicas of a point that have ended, their processor time (seconds), and which
/// they are.
fn merge_replicas(
    sweep: &SweepFolder,
    point: &StudyPoint,
    count: u64,
) -> Result<(Option<Record>, f64, Vec<u64>)> {
    let (mut record, mut seconds, mut replicas): (Option<Record>, _, _) = (None, 0.0, Vec::new());
    for replica in 1..=count {
        let stored = match sweep.find(point, replica)? {
            Found::Finished(stored) => stored,
            Found::Damaged(reason) | Found::Newer(reason) => {
                note(&damaged(point, replica, &reason));
                continue;
            }
            Found::Nothing => continue,
        };
        seconds += stored.seconds;
        replicas.push(replica);
        match &mut record {
            None => record = Some(stored.record),
            Some(all) => all.merge(stored.record)?,
        }
    }
    Ok((record, seconds, replicas))
}

/// Writes page and tables of a point into its folder, unless those of the same sums are there.
fn write_unless_there(
    folder: &Folder,
    merged: &MergedRuns,
    (record, seconds): (&Record, f64),
    (manifest, again): (&Manifest, &str),
) -> Result<()> {
    let source = Seal::of_source(&merged.summary.title, record)?;
    if !Seal::is_intact(folder, source) {
        // Removed first: what is half written is never taken for current.
        Seal::remove(folder)?;
        let manifest = manifest.write_part(folder, again)?;
        merged.write(record, folder)?;
        manifest.complete(folder, seconds)?;
        Seal::write(folder, source)?;
    }
    Ok(())
}

/// The charts that carry the answer of a point, whose folder has this path on the page of the
/// sweep.
fn evidence(folder: &Folder, path: &str) -> Result<Vec<DataChart>> {
    let charts = report::evidence(folder)?.into_iter();
    Ok(charts
        .map(|chart| DataChart {
            file: format!("{path}/{}", chart.file),
            ..chart
        })
        .collect())
}

/// The message about a damaged file.
pub(crate) fn damaged(point: &StudyPoint, replica: u64, reason: &str) -> String {
    format!(
        "point {}, replica {replica}: the file of its sums is left out: {reason}",
        point.label
    )
}

/// A check of each expectation.
pub fn expected(points: &[PointResults]) -> Vec<Check> {
    let of_point = |point: &PointResults| -> Vec<Check> {
        let judged = point.answers.iter().filter(|answer| !answer.show_only);
        judged.map(|answer| answer.check(&point.label)).collect()
    };
    points.iter().flat_map(of_point).collect()
}

/// Checks of all points: the worst of each name.
pub fn checks(points: &[PointResults]) -> Vec<Check> {
    let mut worst: Vec<Check> = Vec::new();
    for check in points.iter().flat_map(|point| &point.checks) {
        match worst.iter_mut().find(|other| other.name == check.name) {
            Some(other) if check.passed && !other.passed => (),
            Some(other) if !check.passed && other.passed || check.found > other.found => {
                *other = check.clone();
            }
            Some(_) => (),
            None => worst.push(check.clone()),
        }
    }
    worst
}
