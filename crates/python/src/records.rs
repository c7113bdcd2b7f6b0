//! Results of runs: encoded records, and their tables and figures as plain data.

use std::{path::PathBuf, thread, time::Duration};

use anyhow::{Context as _, ensure};
use carom_report::table_chart;
use carom_runs::{
    checkpoint_file::{self, CheckpointBody},
    interruption::Signals,
    merge,
    record::{MeasureRecord, Record, SUMS},
    run,
};
use carom_tables::{BlockSums, Figure, Spacing, Stationarity, Table, Totals, block_sums};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::{
    prelude::*,
    types::{PyBytes, PyDict, PyList},
};

use crate::{errors, scene};

/// Interval between two looks for Ctrl-C.
const PAUSE: Duration = Duration::from_millis(2);

/// A record for Python.
pub fn encoded<'py>(py: Python<'py>, record: &Record) -> PyResult<Bound<'py, PyBytes>> {
    Ok(PyBytes::new(
        py,
        &checkpoint_file::encode(record).map_err(errors::measure)?,
    ))
}

fn decoded(bytes: &[u8]) -> PyResult<Record> {
    checkpoint_file::decode(bytes)
        .map_err(|error| errors::measure(anyhow::anyhow!("no results: {error}")))
}

/// Runs a scene with its measures and stages in memory, and returns the record. The run ends early
/// by Ctrl-C, or when `stop` returns true.
#[pyfunction]
pub fn run_scene<'py>(
    py: Python<'py>,
    text: &str,
    snapshot: Option<String>,
    stop: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyBytes>> {
    let scene = scene::parsed(text, snapshot)?;
    let signals = Signals::default();
    let of_run = signals.clone();
    let running = thread::spawn(move || run::record(&scene, &of_run));
    let mut interrupted = None;
    while !running.is_finished() {
        py.detach(|| thread::sleep(PAUSE));
        let stops = || -> PyResult<()> {
            py.check_signals()?;
            match &stop {
                Some(stop) if stop.call0()?.is_truthy()? => {
                    Err(errors::RunError::new_err("the run has been stopped"))
                }
                _ => Ok(()),
            }
        };
        if interrupted.is_none()
            && let Err(error) = stops()
        {
            signals.interrupt();
            interrupted = Some(error);
        }
    }
    let ended = running.join();
    if let Some(error) = interrupted {
        return Err(error);
    }
    let record =
        ended.map_err(|_| errors::RunError::new_err("the run has ended by an internal error"))?;
    encoded(py, &record.map_err(errors::run)?)
}

/// The record of a folder of `carom run` or `carom merge`.
#[pyfunction]
pub fn record_of_folder(py: Python<'_>, folder: PathBuf) -> PyResult<Bound<'_, PyBytes>> {
    let path = folder.join(SUMS);
    let read = || -> anyhow::Result<Record> {
        ensure!(
            path.exists(),
            "it has no file '{SUMS}', which `carom run` and `carom merge` write"
        );
        Record::take(&mut CheckpointBody::read(&path)?)
    };
    let record = read().with_context(|| format!("{}: no run that has ended", folder.display()));
    encoded(py, &record.map_err(errors::checkpoint)?)
}

/// The runs of both records.
#[pyfunction]
pub fn merge_records<'py>(
    py: Python<'py>,
    one: &[u8],
    other: &[u8],
) -> PyResult<Bound<'py, PyBytes>> {
    let mut all = decoded(one)?;
    all.merge(decoded(other)?).map_err(errors::measure)?;
    encoded(py, &all)
}

/// Tables and figures: those of the run, or merged ones of several.
fn results(record: &Record) -> (Vec<Table>, Vec<Figure>) {
    if record.runs.len() != 1 {
        let merged = merge::merged(record);
        return (merged.tables, merged.figures);
    }
    let runs = || record.runs.values();
    let measures = || runs().flat_map(|run| &run.measures);
    let of_measures = measures().flat_map(MeasureRecord::all_figures);
    let figures = runs()
        .flat_map(|run| &run.figures)
        .chain(of_measures)
        .cloned()
        .collect();
    (
        measures()
            .flat_map(|measure| measure.tables.iter().cloned())
            .collect(),
        figures,
    )
}

/// Tables, figures, runs, totals and scene of a record.
#[pyfunction]
pub fn record_contents<'py>(py: Python<'py>, bytes: &[u8]) -> PyResult<Bound<'py, PyDict>> {
    let record = decoded(bytes)?;
    let (tables, figures) = results(&record);
    let all = PyDict::new(py);
    let tables: PyResult<Vec<_>> = tables.iter().map(|table| plain_table(py, table)).collect();
    all.set_item("tables", PyList::new(py, tables?)?)?;
    let figures: Vec<_> = figures
        .into_iter()
        .map(|f| {
            let stationary = f.stationarity.map(|found| found.is_stationary);
            (
                f.name,
                f.value,
                f.standard_error,
                f.unit,
                f.prediction,
                f.source,
                stationary,
            )
        })
        .collect();
    all.set_item("figures", figures)?;
    let runs: Vec<_> = record
        .runs
        .iter()
        .map(|(key, run)| {
            let Totals {
                collisions,
                simulated_time,
                energy_drift,
                overlapping_pairs,
                ..
            } = run.totals;
            (
                key.seed,
                key.number,
                collisions,
                simulated_time,
                energy_drift,
                overlapping_pairs,
            )
        })
        .collect();
    all.set_item("runs", runs)?;
    all.set_item("scene", record.what)?;
    Ok(all)
}

fn plain_table<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyDict>> {
    let plain = PyDict::new(py);
    plain.set_item("name", &table.name)?;
    plain.set_item("title", &table.title)?;
    plain.set_item("caption", &table.caption)?;
    plain.set_item("logarithmic", table.spacing == Spacing::Logarithmic)?;
    let columns = PyList::empty(py);
    for column in &table.columns {
        let values: Vec<f64> = column
            .values
            .iter()
            .map(|value| value.unwrap_or(f64::NAN))
            .collect();
        let (role, source) = column.role.words();
        let values = PyArray1::from_vec(py, values);
        columns.append((
            &column.name,
            &column.label,
            &column.unit,
            role,
            source,
            values,
        ))?;
    }
    plain.set_item("columns", columns)?;
    let level = |level: &carom_tables::Level| {
        (
            level.column.clone(),
            level.label.clone(),
            level.value,
            level.source.clone(),
        )
    };
    plain.set_item("levels", table.levels.iter().map(level).collect::<Vec<_>>())?;
    Ok(plain)
}

/// The mean of a series at equal intervals of time, weighted, with its standard error and whether
/// no change of it was found, as far as they are known. All weights are positive.
#[pyfunction]
#[allow(clippy::needless_pass_by_value, reason = "PyO3 gives arrays by value")]
pub fn mean_of_series(
    values: PyReadonlyArray1<'_, f64>,
    weights: PyReadonlyArray1<'_, f64>,
) -> PyResult<(f64, Option<f64>, Option<bool>)> {
    let (values, weights) = (values.as_array(), weights.as_array());
    let series = values.iter().zip(weights);
    let (blocks, sums) = BlockSums::of_series(series.map(|(&value, &weight)| [value, weight]));
    let mean = blocks.means(&[sums])[0];
    let blocks = block_sums::of_quantity(&blocks.blocks(), 0);
    let span = [0.0, blocks.len() as f64];
    let found = Stationarity::new(&[blocks], span).map(|found| found.is_stationary);
    let value = mean
        .value
        .filter(|value| value.is_finite())
        .context("the mean is not finite");
    Ok((value.map_err(errors::measure)?, mean.standard_error, found))
}

/// The charts of a table as SVG.
#[pyfunction]
pub fn table_pictures(bytes: &[u8], name: &str) -> PyResult<Vec<String>> {
    let (tables, _) = results(&decoded(bytes)?);
    match tables.iter().find(|table| table.name == name) {
        Some(table) => table_chart::charts(table).map_err(errors::measure),
        None => Ok(Vec::new()),
    }
}
