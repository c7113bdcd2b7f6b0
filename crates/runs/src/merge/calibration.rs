//! The standard errors of replicas against their scatter, for every figure and table.

use std::collections::BTreeMap;

use carom_tables::{
    Role, Table,
    calibration::{Calibration, MIN_REPLICAS, MeasuredMean},
    without_numbers,
};

use super::average::measures;
use crate::record::{MeasureRecord, Record};

/// Compares the standard errors of all figures and tables with the scatter among the runs, in the
/// order of the measures. Empty with fewer than [`MIN_REPLICAS`] runs.
pub fn calibrations(record: &Record) -> Vec<Calibration> {
    if record.runs.len() < MIN_REPLICAS {
        return Vec::new();
    }
    measures(record)
        .flat_map(|(_, parts)| of_measure(&parts))
        .collect()
}

fn of_measure(parts: &[MeasureRecord]) -> Vec<Calibration> {
    let Some(first) = parts.first() else {
        return Vec::new();
    };
    let of_figure = |name: &str| -> Option<Calibration> {
        let found = |part: &MeasureRecord| -> Option<MeasuredMean> {
            let (figure, _) = part
                .figures
                .iter()
                .find(|(figure, _)| figure.name == name)?;
            Some((figure.value, figure.standard_error))
        };
        Calibration::new(name, &[parts.iter().filter_map(found).collect()])
    };
    let figures = first
        .figures
        .iter()
        .filter_map(|(figure, _)| of_figure(&figure.name));
    let tables = first
        .tables
        .iter()
        .flat_map(|table| of_table(&table.name, table, parts));
    of_curves(parts)
        .into_iter()
        .chain(figures)
        .chain(tables)
        .collect()
}

/// The coefficients of curves. At which lags one is read depends on the data of the replica, and
/// the curve differs between lags by more than chance: those at the most frequent lags are
/// compared.
fn of_curves(parts: &[MeasureRecord]) -> Vec<Calibration> {
    let mut by_name: BTreeMap<&str, Vec<MeasuredMean>> = BTreeMap::new();
    let mut names: Vec<String> = Vec::new();
    for figure in parts.iter().flat_map(|part| &part.of_curves) {
        let measured = (figure.value, figure.standard_error);
        by_name.entry(&figure.name).or_default().push(measured);
        let name = without_numbers(&figure.name);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let compared = |name: &String| {
        let same = by_name
            .iter()
            .filter(|(full, _)| without_numbers(full) == *name);
        let (_, most) = same.max_by_key(|(_, measured)| measured.len())?;
        Calibration::new(name, std::slice::from_ref(most))
    };
    names.iter().filter_map(compared).collect()
}

/// The columns with errors of a table.
fn of_table(name: &str, first: &Table, parts: &[MeasureRecord]) -> Vec<Calibration> {
    let tables: Vec<&Table> = parts
        .iter()
        .filter_map(|part| part.tables.iter().find(|table| table.name == name))
        .collect();
    let of_column = |index: usize| -> Option<Calibration> {
        let (value, error) = (first.columns.get(index)?, first.columns.get(index + 1)?);
        if value.role != Role::Value || error.role != Role::StandardError {
            return None;
        }
        let cell = |table: &Table, column: usize, row: usize| {
            table
                .columns
                .get(column)
                .and_then(|column| column.values.get(row).copied().flatten())
        };
        let row = |row: usize| -> Vec<MeasuredMean> {
            let measured =
                |table: &&Table| Some((cell(table, index, row)?, cell(table, index + 1, row)));
            tables.iter().filter_map(measured).collect()
        };
        let rows: Vec<Vec<MeasuredMean>> = (0..value.values.len()).map(row).collect();
        Calibration::new(&format!("{name}: {}", value.label), &rows)
    };
    (0..first.columns.len()).filter_map(of_column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::RunRecord;
    use carom_tables::{Figure, Replica, Totals, calibration::Calibrated};

    /// A record of so many runs, each of one measure.
    fn record(count: u64, measure: impl Fn(u64) -> MeasureRecord) -> Record {
        let run = |number: u64| {
            let run = RunRecord {
                totals: Totals::default(),
                note: String::new(),
                figures: Vec::new(),
                measures: vec![measure(number)],
            };
            (Replica { seed: 1, number }, run)
        };
        Record {
            what: String::new(),
            runs: (0..count).map(run).collect(),
        }
    }

    /// Each of the numbers from 0 to 63 once, in an order without trend.
    fn value(number: u64) -> f64 {
        (number * 37 % 64) as f64
    }

    /// Their standard deviation.
    fn scatter() -> f64 {
        64.0 / 12f64.sqrt()
    }

    #[test]
    fn wrong_errors_of_figures_and_columns_are_found() {
        let measure = |number: u64| {
            let x = value(number);
            let figures = vec![(Figure::new("half", x, "1").error(0.5 * scatter()), None)];
            let table =
                Table::new("t", "T")
                    .abscissa("r", "1", vec![0.0])
                    .value("y", "1", vec![Some(x)]);
            let tables = vec![table.errors(vec![Some(scatter())])];
            MeasureRecord {
                tables,
                figures,
                ..MeasureRecord::default()
            }
        };
        let found = calibrations(&record(64, measure));
        let results: Vec<_> = found
            .iter()
            .map(|one| (one.name.as_str(), one.result))
            .collect();
        assert_eq!(
            results,
            [("half", Calibrated::Flagged), ("t: y", Calibrated::Fine)]
        );
        assert!((found[0].ratio - 0.5).abs() < 0.01);
        assert!(calibrations(&record(29, measure)).is_empty());
    }

    /// Of 64 replicas the first finds no plateau, and 16 read the coefficient at other lags than 47
    /// do, where the curve is steeper.
    #[test]
    fn coefficients_are_compared_at_equal_lags() {
        let measure = |number: u64| {
            let (what, lags, steeper) = match number {
                0 => ("apparent D", "2 to 4, no plateau", 0.0),
                _ if number % 4 == 1 => ("D", "4 to 16", 500.0),
                _ => ("D", "8 to 32", 0.0),
            };
            let name = format!("{what} at long lags, {lags}, gas");
            let figure = Figure::new(name, steeper + value(number), "1").error(scatter());
            MeasureRecord {
                of_curves: vec![figure],
                ..MeasureRecord::default()
            }
        };
        let found = calibrations(&record(64, measure));
        let [one] = &found[..] else {
            panic!("{found:?}")
        };
        assert_eq!(one.name, "D at long lags, … to …, gas");
        assert_eq!((one.replicas, one.result), (47, Calibrated::Fine));
        assert!((one.ratio - 1.0).abs() < 0.1, "{}", one.ratio);
    }
}
