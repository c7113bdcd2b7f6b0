//! What a program has measured of a run until it saves the run, and the series that continue.
//!
//! | in the folder of the saved run | content |
//! | --- | --- |
//! | `measured-before/*.csv`, `*.svg` | tables and drawings of all measures of the program |
//! | `measured-before/series` | the series in time that the saved run measures too |
//! | `energy.csv`, `pressure.csv`, … | the rows so far of a file that the saved run appends to |
//!
//! A resumed run puts the earlier rows of a series before its own, in the file and in the charts.
//! Means, errors, distributions and correlations are those of the resumed run alone: the time
//! between the last sample before and the first one after has another length than the interval,
//! which blocks and lags exclude.

use std::{collections::HashSet, fs, io, path::Path};

use anyhow::{Context, Result};
use carom_tables::{Column, Role, Table, with_error};
use serde::Serialize;

use crate::{
    checkpoint_file::{CheckpointBody, bytes_of, encode},
    measures::{Label, Request, Results, file_name},
    output::csv_table,
    series::GROWING,
};

/// Folder, in that of a saved run, of what was measured before. No run writes there.
pub const MEASURED: &str = "measured-before";

/// File of the series that continue, in [`MEASURED`].
const SERIES: &str = "series";

/// Kinds of measures whose values count from their start: their rows before and after a save belong
/// to two curves.
const COUNTED_FROM_START: [&str; 2] = ["crossings", "running-average"];

/// The name and the content of a file.
pub type NamedFile = (String, Vec<u8>);

/// What a program has measured of a run until it saves it.
#[derive(Debug, Default)]
pub struct MeasuredBefore {
    /// The results of each measure of
    /// [`InteractiveRun::set_watched`](super::interactive::InteractiveRun::set_watched), in that
    /// order.
    pub results: Vec<Results>,
    /// Further files by name.
    pub files: Vec<NamedFile>,
}

/// A measure of a program that the saved run has too.
#[derive(Debug, Clone)]
pub(super) struct ContinuedMeasure {
    kind: &'static str,
    /// What distinguishes it from others of its kind: in the program, and in the saved scene.
    labels: [Label; 2],
}

/// The files of a saved run with what was measured before.
#[derive(Debug, Default)]
pub(super) struct EarlierFiles {
    /// In the folder [`MEASURED`].
    pub inner: Vec<NamedFile>,
    /// In the folder of the run: it appends its own rows.
    pub growing: Vec<NamedFile>,
}

/// A number in a file that a run appends to.
#[derive(Serialize)]
#[serde(untagged)]
enum Cell {
    Count(u64),
    Number(Option<f64>),
}

/// Collects the files of a saved run.
struct FileCollector {
    names: HashSet<String>,
    files: EarlierFiles,
    series: Vec<Table>,
}

impl FileCollector {
    /// Begins with further files, whose names are taken.
    fn new(files: &[NamedFile]) -> Self {
        let names = files.iter().map(|(name, _)| name.clone());
        Self {
            names: names.chain([SERIES.to_owned()]).collect(),
            files: EarlierFiles {
                inner: files.to_vec(),
                growing: Vec::new(),
            },
            series: Vec::new(),
        }
    }

    /// Adds a file in [`MEASURED`], with the number of its measure in the name if that is taken;
    /// returns whether it was free.
    fn add(&mut self, number: usize, name: String, content: Vec<u8>) -> bool {
        let is_free = self.names.insert(name.clone());
        let name = if is_free {
            name
        } else {
            format!("{number}-{name}")
        };
        self.names.insert(name.clone());
        self.files.inner.push((name, content));
        is_free
    }

    /// Adds a table of a measure, which is continued if the saved run measures it too.
    fn add_table(
        &mut self,
        number: usize,
        table: &Table,
        measure: Option<&ContinuedMeasure>,
    ) -> Result<()> {
        let mut table = table.clone();
        if let Some(measure) = measure {
            table.name = measure.name_of(&table.name);
        }
        let content = csv_table(&table.header(), table.rows())?;
        let is_free = self.add(number, file_name(&table), content);
        // Of two measures that are one in the saved run the first has more rows.
        let Some(measure) = measure.filter(|measure| is_free && measure.continues(&table)) else {
            return Ok(());
        };
        if let Some(columns) = measure.columns_of_growing(&table) {
            // Merged results have columns of errors too.
            table.columns.retain(|column| {
                column.role == Role::Derived || columns.contains(&column.name.as_str())
            });
            // Rows of other columns cannot be continued.
            if table.header() != columns {
                return Ok(());
            }
            let rows = (file_name(&table), rows_of(&table)?);
            self.files.growing.push(rows);
        }
        self.series.push(table);
        Ok(())
    }

    fn finish(mut self) -> Result<EarlierFiles> {
        if !self.series.is_empty() {
            let content = bytes_of(&[&encode(&self.series)?]);
            self.files.inner.push((SERIES.to_owned(), content));
        }
        Ok(self.files)
    }
}

impl ContinuedMeasure {
    /// `added` is the measure of the program, which had the name `name` there; `saved` is the one
    /// that stands for it in the saved scene.
    pub fn new(name: Option<String>, added: &Request, saved: &Request) -> Self {
        let label = |request: &Request, name: Option<String>| Label {
            tag: request.tag(),
            name,
        };
        Self {
            kind: saved.kind.name,
            labels: [label(added, name), label(saved, saved.name.clone())],
        }
    }

    /// Whether it is among the measures of a scene.
    pub fn is_among(&self, requests: &[Request]) -> bool {
        requests.iter().any(|request| {
            let label = Label {
                tag: request.tag(),
                name: request.name.clone(),
            };
            request.kind.name == self.kind && label == self.labels[1]
        })
    }

    /// The name that a table of the program has in the saved run.
    fn name_of(&self, table: &str) -> String {
        let [before, saved] = &self.labels;
        let ending = before.word().map(|word| format!("-{word}"));
        let base = ending.and_then(|ending| table.strip_suffix(&ending));
        saved.file(base.unwrap_or(table))
    }

    /// Whether the saved run continues a table: a series in time whose values do not count from
    /// its start.
    fn continues(&self, table: &Table) -> bool {
        let is_series = table
            .columns
            .first()
            .is_some_and(|column| column.role == Role::Abscissa && column.name == "time");
        is_series && !COUNTED_FROM_START.contains(&self.kind)
    }

    /// The columns of the file of a table, if the saved run appends to it.
    fn columns_of_growing(&self, table: &Table) -> Option<&'static [&'static str]> {
        let file = file_name(table);
        GROWING
            .into_iter()
            .find(|(name, _)| self.labels[1].file(name) == file)
            .map(|(_, columns)| columns)
    }
}

impl MeasuredBefore {
    /// Whether nothing has been measured.
    pub fn is_empty(&self) -> bool {
        self.results.is_empty() && self.files.is_empty()
    }

    /// The files of the saved run. `continued` has the measure of the saved run for each of the
    /// results, if there is one.
    ///
    /// # Errors
    /// A table cannot be encoded.
    pub(super) fn saved_files(
        &self,
        continued: &[Option<ContinuedMeasure>],
    ) -> Result<EarlierFiles> {
        let mut collector = FileCollector::new(&self.files);
        for (place, results) in self.results.iter().enumerate() {
            let (number, measure) = (place + 1, continued.get(place).and_then(Option::as_ref));
            for table in &results.tables {
                collector.add_table(number, table, measure)?;
            }
            for drawing in &results.drawings {
                let content = drawing.svg.clone().into_bytes();
                collector.add(number, drawing.file.clone(), content);
            }
        }
        collector.finish()
    }
}

/// The content of a file that a run appends to, as [`crate::series`] writes it: counts are whole
/// numbers.
fn rows_of(table: &Table) -> Result<Vec<u8>> {
    let is_count: Vec<bool> = table
        .in_file()
        .map(|column| column.role == Role::Count)
        .collect();
    let cell = |(value, is_count): (Option<f64>, &bool)| match value {
        Some(count) if *is_count => Cell::Count(count as u64),
        value => Cell::Number(value),
    };
    let rows = table.rows().into_iter();
    let rows = rows.map(|row| row.into_iter().zip(&is_count).map(cell).collect::<Vec<_>>());
    csv_table(&table.header(), rows)
}

/// The series that were measured before the run in this folder was saved; none if no program has
/// saved it.
///
/// # Errors
/// Their file is damaged or cannot be read.
pub(super) fn earlier_series(folder: &Path) -> Result<Vec<Table>> {
    let path = folder.join(MEASURED).join(SERIES);
    if !path.exists() {
        return Ok(Vec::new());
    }
    CheckpointBody::read(&path)
        .and_then(|mut body| body.take())
        .with_context(|| format!("cannot read {}", path.display()))
}

/// Removes the series that were measured before: a run that starts from its beginning in this
/// folder does not continue them.
///
/// # Errors
/// Their file cannot be removed.
pub(super) fn remove_earlier_series(folder: &Path) -> Result<()> {
    let path = folder.join(MEASURED).join(SERIES);
    match fs::remove_file(&path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("cannot remove {}", path.display()))
        }
        _ => Ok(()),
    }
}

/// Puts the rows of earlier series before those of the tables of the same names.
pub(super) fn put_before(earlier: &[Table], tables: &mut [Table]) {
    for table in tables {
        if let Some(earlier) = earlier.iter().find(|other| other.name == table.name) {
            put_rows_before(earlier, table);
        }
    }
}

fn put_rows_before(earlier: &Table, table: &mut Table) {
    let times = earlier.columns.first().map_or(&[][..], |time| &time.values);
    let Some(last) = times.last().copied().flatten() else {
        return;
    };
    for column in &mut table.columns {
        let is_same = |other: &&Column| {
            other.name == column.name
                && other.unit == column.unit
                && other.role.words().0 == column.role.words().0
        };
        let found = earlier.columns.iter().find(is_same);
        let value = |row: usize| found.and_then(|found| found.values.get(row).copied().flatten());
        let values: Vec<Option<f64>> = (0..times.len()).map(value).collect();
        column.values.splice(0..0, values);
        if !column.quantities.is_empty() {
            let none = std::iter::repeat_n(None, times.len());
            column.quantities.splice(0..0, none);
        }
    }
    let until = with_error(last, None);
    let words = format!(
        "Rows up to t = {until} were measured before the run was saved; means and errors are those of \
         what follows."
    );
    let caption = format!("{} {words}", table.caption);
    caption.trim_start().clone_into(&mut table.caption);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(name: &str, times: &[f64]) -> Table {
        let squares = || times.iter().map(|time| Some(time * time)).collect();
        Table::new(name, "Squares")
            .abscissa("time", "time", times.to_vec())
            .value("square", "1", squares())
            .derived("twice", "1", squares())
    }

    #[test]
    fn earlier_rows_come_first_in_all_columns_of_the_same_name() {
        let earlier = series("squares", &[0.5, 1.0]);
        let mut tables = [
            series("squares", &[2.0, 3.0]).prediction("theory", vec![Some(4.0), Some(9.0)], "S"),
            series("others", &[2.0]),
        ];
        let other = tables[1].clone();
        put_before(&[earlier], &mut tables);
        let values = |column: usize| tables[0].columns[column].values.clone();
        assert_eq!(values(0), [0.5, 1.0, 2.0, 3.0].map(Some));
        assert_eq!(values(1), [0.25, 1.0, 4.0, 9.0].map(Some));
        assert_eq!(values(2), values(1), "a derived column has all rows too");
        assert_eq!(values(3), [None, None, Some(4.0), Some(9.0)]);
        assert!(tables[0].caption.contains("up to t = 1 were measured"));
        assert_eq!(tables[1], other);
    }

    #[test]
    fn a_table_of_the_program_gets_the_name_of_the_saved_run() {
        let label = |tag: Option<&str>, name: Option<&str>| Label {
            tag: tag.map(str::to_owned),
            name: name.map(str::to_owned),
        };
        let renamed = |before: Label, saved: Label, table: &str| {
            let measure = ContinuedMeasure {
                kind: "temperature",
                labels: [before, saved],
            };
            measure.name_of(table)
        };
        let hot = || label(Some("hot"), None);
        assert_eq!(renamed(hot(), hot(), "temperature-hot"), "temperature-hot");
        let saved = label(Some("hot"), Some("hot-live-1"));
        assert_eq!(
            renamed(hot(), saved, "temperature-hot"),
            "temperature-hot-live-1"
        );
        let (before, saved) = (label(None, None), label(None, Some("live-1")));
        assert_eq!(renamed(before, saved, "pressure"), "pressure-live-1");
    }

    #[test]
    fn curves_that_count_from_their_start_begin_anew() {
        let measure = |kind: &'static str| ContinuedMeasure {
            kind,
            labels: [Label::default(), Label::default()],
        };
        let table = series("t", &[0.0, 1.0]);
        assert!(measure("temperature").continues(&table));
        assert!(!measure("running-average").continues(&table));
        let lags = Table::new("lags", "Lags").abscissa("lag", "time", vec![0.0, 1.0]);
        assert!(!measure("correlation").continues(&lags));
    }
}
