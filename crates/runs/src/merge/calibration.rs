//! The standard errors of replicas against their scatter, for every figure and table.

use carom_tables::{
    Figure, Role, Table,
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
    let of_curve = |figure: &Figure| {
        let name = without_numbers(&figure.name);
        let found = |part: &MeasureRecord| -> Option<MeasuredMean> {
            let mut figures = part.of_curves.iter();
            let same = figures.find(|figure| without_numbers(&figure.name) == name)?;
            Some((same.value, same.standard_error))
        };
        Calibration::new(&name, &[parts.iter().filter_map(found).collect()])
    };
    let of_curves = first.of_curves.iter().filter_map(of_curve);
    let tables = first
        .tables
        .iter()
        .flat_map(|table| of_table(&table.name, table, parts));
    of_curves.chain(figures).chain(tables).collect()
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

    #[test]
    fn wrong_errors_of_figures_and_columns_are_found() {
        let run = |number: u64| {
            let x = (number * 37 % 64) as f64;
            let scatter = 64.0 / 12f64.sqrt();
            let figures = vec![(Figure::new("half", x, "1").error(0.5 * scatter), None)];
            let table =
                Table::new("t", "T")
                    .abscissa("r", "1", vec![0.0])
                    .value("y", "1", vec![Some(x)]);
            let tables = vec![table.errors(vec![Some(scatter)])];
            let measures = vec![MeasureRecord {
                tables,
                figures,
                ..MeasureRecord::default()
            }];
            let totals = Totals::default();
            (
                Replica { seed: 1, number },
                RunRecord {
                    totals,
                    note: String::new(),
                    figures: Vec::new(),
                    measures,
                },
            )
        };
        let record = |count: u64| Record {
            what: String::new(),
            runs: (0..count).map(run).collect(),
        };
        let found = calibrations(&record(64));
        let results: Vec<_> = found
            .iter()
            .map(|one| (one.name.as_str(), one.result))
            .collect();
        assert_eq!(
            results,
            [("half", Calibrated::Flagged), ("t: y", Calibrated::Fine)]
        );
        assert!((found[0].ratio - 0.5).abs() < 0.01);
        assert!(calibrations(&record(29)).is_empty());
    }
}
