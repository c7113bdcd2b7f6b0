//! Tables and figures of merged runs.
//!
//! Means are those of all sums, with errors from the blocks of all runs. What is no mean of sums is
//! averaged over the runs, with the error of its scatter among them. All sums are added in the
//! order of the runs' keys.

use carom_tables::{
    BlockMean, Column, Figure, MIN_BLOCKS, MergedSums, Replica, Role, RunSums, Stationarity, Table,
    block_sums,
};

use super::rebin::with_common_bins;
use crate::{
    curves::Coefficient,
    measures::Results,
    record::{MeasureRecord, Record, RunRecord},
    run::outcome::is_shown,
};

/// Abscissae of different runs agree if they differ by at most this share: rounding.
const SAME: f64 = 1e-9;

/// Tables and figures of all runs.
pub fn results(record: &Record) -> Results {
    let mut results = Results::default();
    let runs: Vec<_> = record.runs.values().collect();
    let Some(first) = runs.first() else {
        return results;
    };
    let of_system: Vec<Vec<Figure>> = runs.iter().map(|run| run.figures.clone()).collect();
    let of_system = first
        .figures
        .iter()
        .map(|figure| averaged(figure, &of_system));
    results.figures.extend(of_system.filter(is_shown));
    for (replicas, parts) in measures(record) {
        let mut sums = MergedSums::default();
        for (&replica, part) in replicas.iter().zip(&parts) {
            // The keys are those of a map, so none is there twice.
            let _ = sums.merge(MergedSums::new(replica, part.sums.clone()));
        }
        let merged = Merged::new(&sums, parts.iter().collect());
        results.tables.extend(merged.tables());
        results.figures.extend(merged.figures_of_curves(&sums));
        results.figures.extend(merged.figures());
        results.drawings.extend(
            parts
                .first()
                .map_or_else(Vec::new, |part| part.drawings.clone()),
        );
    }
    results
}

/// Each measure of all runs, with common bins where the runs have distributions.
pub(super) fn measures(
    record: &Record,
) -> impl Iterator<Item = (Vec<Replica>, Vec<MeasureRecord>)> {
    let count = record
        .runs
        .values()
        .next()
        .map_or(0, |run| run.measures.len());
    (0..count).map(|index| {
        let of_run = |(&replica, run): (&Replica, &RunRecord)| {
            Some((replica, run.measures.get(index)?.clone()))
        };
        let (replicas, parts): (Vec<Replica>, Vec<MeasureRecord>) =
            record.runs.iter().filter_map(of_run).unzip();
        let common = with_common_bins(&parts.iter().collect::<Vec<_>>());
        (replicas, common.unwrap_or(parts))
    })
}

/// One measure of all runs.
struct Merged<'a> {
    parts: Vec<&'a MeasureRecord>,
    means: Vec<BlockMean>,
    /// Means with errors from the scatter of whole runs, for what a block is too short for.
    by_run: Vec<BlockMean>,
}

impl<'a> Merged<'a> {
    fn new(sums: &MergedSums, parts: Vec<&'a MeasureRecord>) -> Self {
        let whole = |part: &&MeasureRecord| -> Vec<_> {
            let RunSums { total, .. } = &part.sums;
            vec![total.clone()]
        };
        let by_run = block_sums::means(&sums.total(), &parts.iter().map(whole).collect::<Vec<_>>());
        Self {
            parts,
            means: sums.means(),
            by_run,
        }
    }

    /// The mean of a quantity. `has_error` tells whether each run had an error of its own.
    fn mean(&self, quantity: usize, has_error: bool) -> BlockMean {
        let means = if has_error { &self.means } else { &self.by_run };
        means.get(quantity).copied().unwrap_or_default()
    }

    /// The coefficients of the curves of all runs together, read anew.
    fn figures_of_curves(&self, sums: &MergedSums) -> Vec<Figure> {
        let total = sums.total();
        // A run of fewer than two blocks is one block, as for other means.
        let of_run = |part: &&MeasureRecord| match &part.sums.blocks[..] {
            [] | [_] => vec![part.sums.total.clone()],
            blocks => blocks.to_vec(),
        };
        let blocks: Vec<_> = self.parts.iter().map(of_run).collect();
        let all = || self.parts.iter().flat_map(|part| &part.coefficients);
        let mut distinct: Vec<&Coefficient> = Vec::new();
        for one in all() {
            if !distinct.iter().any(|other| other.is_same(one)) {
                distinct.push(one);
            }
        }
        let figure = |one: &Coefficient| {
            let same: Vec<_> = all().filter(|other| other.is_same(one)).collect();
            let figure = Coefficient::merged(&same)?.figure(&total, &blocks)?;
            Some(figure.resolved())
        };
        distinct.into_iter().filter_map(figure).collect()
    }

    fn figures(&self) -> Vec<Figure> {
        let Some(first) = self.parts.first() else {
            return Vec::new();
        };
        let all: Vec<Vec<Figure>> = self
            .parts
            .iter()
            .map(|part| {
                part.figures
                    .iter()
                    .map(|(figure, _)| figure.clone())
                    .collect()
            })
            .collect();
        let runs = self.parts.len();
        let figure = |(figure, quantity): &(Figure, Option<usize>)| {
            let average = averaged(figure, &all);
            let Some(quantity) = *quantity else {
                return if runs > 1 {
                    average.judged_by(runs)
                } else {
                    average.resolved()
                };
            };
            let same = all
                .iter()
                .flatten()
                .filter(|other| other.name == figure.name);
            let has_error = same.into_iter().all(|other| other.standard_error.is_some());
            let BlockMean {
                value,
                standard_error,
                ..
            } = self.mean(quantity, has_error);
            let (value, stationarity) =
                (value.unwrap_or(average.value), self.stationarity(quantity));
            let merged = Figure {
                value,
                standard_error,
                stationarity,
                ..average
            };
            if has_error {
                let blocks = |part: &&MeasureRecord| match &part.sums.blocks[..] {
                    [] | [_] => {
                        block_sums::of_quantity(std::slice::from_ref(&part.sums.total), quantity)
                    }
                    blocks => block_sums::of_quantity(blocks, quantity),
                };
                let all: Vec<_> = self.parts.iter().map(blocks).collect();
                merged.judged_by_blocks(&all)
            } else {
                let blocks = Some(runs);
                Figure { blocks, ..merged }.judged_by(runs)
            }
        };
        first.figures.iter().map(figure).collect()
    }

    /// Whether the mean of a quantity changes in the runs together.
    fn stationarity(&self, quantity: usize) -> Option<Stationarity> {
        let shortest = self
            .parts
            .iter()
            .min_by_key(|part| part.sums.blocks.len())?;
        let of = |part: &&MeasureRecord| block_sums::of_quantity(&part.sums.blocks, quantity);
        let runs: Vec<_> = self.parts.iter().map(of).collect();
        let begins = |part: &&MeasureRecord| part.span[0];
        let mut starts = self.parts.iter().map(begins);
        // Blocks of different times cannot be added: each run may have found its own start.
        if starts.all(|start| start == shortest.span[0]) {
            Stationarity::new(&runs, shortest.span)
        } else {
            Stationarity::of_separate(&runs)
        }
    }

    fn tables(&self) -> Vec<Table> {
        let Some(first) = self.parts.first() else {
            return Vec::new();
        };
        let of_all = |table: &Table| -> Option<Vec<&Table>> {
            let same = |part: &&'a MeasureRecord| {
                part.tables.iter().find(|other| other.name == table.name)
            };
            self.parts.iter().map(same).collect()
        };
        let merged = |table: &Table| {
            let tables = of_all(table).unwrap_or_default();
            if fit(table, &tables) {
                return self.table(table, &tables);
            }
            // Interpolated densities are not normalised.
            let is_distribution = table
                .columns
                .iter()
                .any(|column| column.role == Role::Width);
            match resampled(table, &tables).filter(|_| !is_distribution) {
                Some(parts) => self.table(&parts[0], &parts.iter().collect::<Vec<_>>()),
                None => Table {
                    columns: Vec::new(),
                    levels: Vec::new(),
                    caption: "Not merged: the runs have different columns or bins.".to_owned(),
                    ..table.clone()
                },
            }
        };
        first.tables.iter().map(merged).collect()
    }

    fn table(&self, first: &Table, tables: &[&Table]) -> Table {
        let rows = tables.iter().map(|table| rows(table)).min().unwrap_or(0);
        let mut columns: Vec<Column> = Vec::new();
        for (index, column) in first.columns.iter().enumerate() {
            let same: Vec<&Column> = tables.iter().map(|table| &table.columns[index]).collect();
            let next = first
                .columns
                .get(index + 1)
                .filter(|next| next.role == Role::StandardError);
            match &column.role {
                Role::Value if !column.quantities.is_empty() => {
                    let errors = next.map(|_| {
                        let errors = tables.iter().map(|table| &table.columns[index + 1]);
                        errors.collect::<Vec<_>>()
                    });
                    columns.extend(self.means_of_sums(column, rows, errors.as_deref()));
                }
                Role::Value => {
                    columns.push(with(column, each(rows, |row| average(&same, row))));
                    columns.push(error_column(column, each(rows, |row| scatter(&same, row))));
                }
                Role::Count => columns.push(with(column, each(rows, |row| sum(&same, row)))),
                Role::StandardError => {}
                // All are the same but for rounding, which a mean would add to.
                Role::Abscissa => {
                    let all = column.values.iter().take(rows).copied();
                    columns.push(with(column, all.collect()));
                }
                Role::Width | Role::Undrawn | Role::Derived | Role::Prediction { .. } => {
                    columns.push(with(column, each(rows, |row| average(&same, row))));
                }
            }
        }
        let mut levels = first.levels.clone();
        for (index, level) in levels.iter_mut().enumerate() {
            let values = tables
                .iter()
                .filter_map(|table| table.levels.get(index))
                .map(|level| level.value);
            level.value = mean_of(values.collect()).unwrap_or(level.value);
        }
        Table {
            columns,
            levels,
            ..first.clone()
        }
    }

    /// A column of means of sums, and that of their errors. `errors` are the columns of the errors
    /// of all runs, if they have some.
    fn means_of_sums(
        &self,
        column: &Column,
        rows: usize,
        errors: Option<&[&Column]>,
    ) -> [Column; 2] {
        let has_error = |row: usize| {
            errors.is_some_and(|errors| errors.iter().all(|error| at(error, row).is_some()))
        };
        let mean = |row: usize| {
            let quantity = column.quantities.get(row).copied().flatten();
            quantity.map_or_else(BlockMean::default, |q| self.mean(q, has_error(row)))
        };
        let means: Vec<BlockMean> = (0..rows).map(mean).collect();
        let errors = means.iter().map(|mean| mean.standard_error).collect();
        [
            with(column, means.iter().map(|mean| mean.value).collect()),
            error_column(column, errors),
        ]
    }
}

fn rows(table: &Table) -> usize {
    table
        .columns
        .iter()
        .map(|column| column.values.len())
        .max()
        .unwrap_or(0)
}

/// Whether all tables have the columns and abscissae of the first, as far as they are long.
fn fit(first: &Table, tables: &[&Table]) -> bool {
    let is_same = |one: &Column, other: &Column| {
        let pairs = || one.values.iter().zip(&other.values);
        let near = |(x, y): (&Option<f64>, &Option<f64>)| match (x, y) {
            (Some(x), Some(y)) => (x - y).abs() <= SAME * x.abs().max(y.abs()),
            (x, y) => x == y,
        };
        one.name == other.name && (one.role != Role::Abscissa || pairs().all(near))
    };
    let fits = |table: &&Table| {
        table.columns.len() == first.columns.len()
            && first
                .columns
                .iter()
                .zip(&table.columns)
                .all(|(one, other)| is_same(one, other))
    };
    !tables.is_empty() && tables.iter().all(fits)
}

/// Curves whose abscissae depend on the data, such as distances in diameters of drawn sizes, with
/// the abscissae of the first: their values are interpolated, and their errors then come from the
/// scatter among the runs. The first is at index 0. `None` if columns differ or an abscissa does
/// not increase.
fn resampled(first: &Table, tables: &[&Table]) -> Option<Vec<Table>> {
    let same_columns = |table: &&Table| {
        table.columns.len() == first.columns.len()
            && first
                .columns
                .iter()
                .zip(&table.columns)
                .all(|(one, other)| one.name == other.name)
    };
    if tables.is_empty() || !tables.iter().all(same_columns) {
        return None;
    }
    let place = first
        .columns
        .iter()
        .position(|column| column.role == Role::Abscissa)?;
    let targets = increasing(&first.columns[place])?;
    let caption = format!(
        "{} The runs have different abscissae: their curves are interpolated to those of the first run.",
        first.caption
    );
    let resample = |table: &&Table| {
        let places = increasing(&table.columns[place])?;
        let column = |column: &Column| {
            let value = |&target: &f64| interpolated(&places, &column.values, target);
            let values = match column.role {
                Role::Abscissa => targets.iter().copied().map(Some).collect(),
                _ => targets.iter().map(value).collect(),
            };
            Column {
                values,
                quantities: Vec::new(),
                ..column.clone()
            }
        };
        let columns = table.columns.iter().map(column).collect();
        Some(Table {
            columns,
            caption: caption.trim().to_owned(),
            ..(*table).clone()
        })
    };
    tables.iter().map(resample).collect()
}

/// The abscissae of a column, if there are two or more and they increase.
fn increasing(column: &Column) -> Option<Vec<f64>> {
    let places: Vec<f64> = column.values.iter().copied().collect::<Option<_>>()?;
    (places.len() > 1 && places.windows(2).all(|pair| pair[0] < pair[1])).then_some(places)
}

/// The value at `target` on the line through the neighbouring points; `None` outside of them.
fn interpolated(places: &[f64], values: &[Option<f64>], target: f64) -> Option<f64> {
    let after = places
        .partition_point(|&place| place <= target)
        .clamp(1, places.len() - 1);
    let (from, to) = (places[after - 1], places[after]);
    let share = (target - from) / (to - from);
    let (low, high) = (
        values.get(after - 1).copied()??,
        values.get(after).copied()??,
    );
    (-SAME..=1.0 + SAME)
        .contains(&share)
        .then_some(low + share * (high - low))
}

fn at(column: &Column, row: usize) -> Option<f64> {
    column.values.get(row).copied().flatten()
}

fn each(rows: usize, value: impl Fn(usize) -> Option<f64>) -> Vec<Option<f64>> {
    (0..rows).map(value).collect()
}

fn with(column: &Column, values: Vec<Option<f64>>) -> Column {
    Column {
        values,
        ..column.clone()
    }
}

/// The errors of a column, as [`Table::errors`] names them.
fn error_column(column: &Column, values: Vec<Option<f64>>) -> Column {
    let name = format!("{}_error", column.name);
    let (label, unit) = (name.clone(), column.unit.clone());
    Column {
        name,
        label,
        unit,
        role: Role::StandardError,
        values,
        quantities: Vec::new(),
    }
}

fn sum(columns: &[&Column], row: usize) -> Option<f64> {
    columns
        .iter()
        .filter_map(|column| at(column, row))
        .reduce(|sum, value| sum + value)
}

fn mean_of(values: Vec<f64>) -> Option<f64> {
    let count = values.len() as f64;
    values
        .into_iter()
        .reduce(|sum, value| sum + value)
        .map(|sum| sum / count)
}

/// Standard error of a mean of independent values; `None` with fewer than two.
fn error_of(values: &[f64]) -> Option<f64> {
    let mean = mean_of(values.to_vec())?;
    let count = values.len() as f64;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (count >= 2.0).then(|| (squares / (count - 1.0) / count).sqrt())
}

fn average(columns: &[&Column], row: usize) -> Option<f64> {
    mean_of(
        columns
            .iter()
            .filter_map(|column| at(column, row))
            .collect(),
    )
}

fn scatter(columns: &[&Column], row: usize) -> Option<f64> {
    error_of(
        &columns
            .iter()
            .filter_map(|column| at(column, row))
            .collect::<Vec<_>>(),
    )
}

/// A scatter below this share of the value is rounding.
const ROUNDING: f64 = 1e-12;

/// The error of a mean of runs that have errors of their own; `None` if one has none.
fn error_of_errors(same: &[&Figure]) -> Option<f64> {
    let squares = same
        .iter()
        .map(|figure| figure.standard_error.map(|error| error * error));
    let sum: f64 = squares.collect::<Option<Vec<f64>>>()?.iter().sum();
    Some(sum.sqrt() / same.len() as f64)
}

/// A figure averaged over the runs that have it, with the error of its scatter; of few runs, whose
/// scatter is uncertain, with that from their own errors if they have some.
fn averaged(figure: &Figure, all: &[Vec<Figure>]) -> Figure {
    let same: Vec<&Figure> = all
        .iter()
        .filter_map(|figures| figures.iter().find(|other| other.name == figure.name))
        .collect();
    let values: Vec<f64> = same.iter().map(|figure| figure.value).collect();
    let predictions: Option<Vec<f64>> = same.iter().map(|figure| figure.prediction).collect();
    let value = mean_of(values.clone()).unwrap_or(figure.value);
    let is_scatter = |error: &f64| *error > ROUNDING * value.abs();
    let own = error_of_errors(&same).filter(|_| same.len() < MIN_BLOCKS);
    let scatter = error_of(&values).filter(is_scatter);
    // Errors of the runs' own come from numbers of blocks that are not kept.
    let (standard_error, blocks) = match (own, scatter) {
        (Some(own), _) => (Some(own), None),
        (None, Some(scatter)) => (Some(scatter), Some(values.len())),
        (None, None) => (figure.standard_error, None),
    };
    Figure {
        value,
        standard_error,
        blocks,
        prediction: predictions.and_then(mean_of),
        ..figure.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_runs_with_errors_of_their_own_have_the_error_of_those() {
        let run =
            |value: f64, error: Option<f64>| vec![Figure::new("chi", value, "1").error(error)];
        let error = |runs: &[Vec<Figure>]| averaged(&runs[0][0], runs).standard_error.unwrap();
        // √2 · 0.3 / 2, whatever their scatter.
        let two = [run(1.0, Some(0.3)), run(1.001, Some(0.3))];
        assert!((error(&two) - 0.3 * 0.5f64.sqrt()).abs() < 1e-15);
        let plain = [run(1.0, None), run(1.2, None)];
        assert!((error(&plain) - 0.1).abs() < 1e-15);
        let many: Vec<_> = (0..MIN_BLOCKS).map(|n| run(n as f64, Some(1e-3))).collect();
        assert!(error(&many) > 1.0);
        // The scatter is that of the runs; how many blocks the errors of runs have is not known.
        let blocks = |runs: &[Vec<Figure>]| averaged(&runs[0][0], runs).blocks;
        assert_eq!(
            [blocks(&two), blocks(&plain), blocks(&many)],
            [None, Some(2), Some(MIN_BLOCKS)]
        );
    }

    #[test]
    fn curves_on_different_abscissae_are_interpolated_to_those_of_the_first_run() {
        let line = |places: Vec<f64>, slope: f64| {
            let values = places.iter().map(|x| Some(slope * x)).collect();
            Table::new("t", "T")
                .abscissa("x", "1", places)
                .value("y", "1", values)
        };
        let (one, other) = (
            line(vec![0.0, 1.0, 2.0], 1.0),
            line(vec![-0.3, 0.8, 1.4], 3.0),
        );
        let parts = resampled(&one, &[&one, &other]).unwrap();
        assert_eq!(parts[0].columns[1].values, one.columns[1].values);
        assert_eq!(parts[1].columns[0].values, one.columns[0].values);
        let found = &parts[1].columns[1].values;
        assert!((found[0].unwrap() - 0.0).abs() < 1e-15 && (found[1].unwrap() - 3.0).abs() < 1e-15);
        assert_eq!(found[2], None, "beyond the last point");
        assert!(parts[0].caption.contains("interpolated"));
        assert!(resampled(&one, &[&one, &line(vec![1.0, 0.0], 1.0)]).is_none());
        assert!(resampled(&one, &[]).is_none());
    }
}
