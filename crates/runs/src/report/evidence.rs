//! The charts of a run's tables, and those that carry its answer.

use anyhow::Result;
use carom_report::{page::DataChart, table_chart};
use carom_tables::{Role, Table};

use crate::{measures, series::ENERGY};

/// All charts of a run.
#[derive(Debug, Default)]
pub(super) struct Charts {
    /// Those beside the verdict: first that of the main figure, then those with a prediction and
    /// errors.
    pub evidence: Vec<DataChart>,
    /// The others, with the name of their table.
    pub others: Vec<DataChart>,
    /// Files of tables without a chart.
    pub undrawn: Vec<String>,
}

impl Charts {
    /// Draws all tables. `main` is the name of the main figure; `count` charts carry the answer.
    ///
    /// # Errors
    /// A table cannot be drawn.
    pub fn new(tables: &[Table], main: &str, count: usize) -> Result<Self> {
        let mut drawn: Vec<(u8, Vec<DataChart>)> = Vec::new();
        let mut undrawn = Vec::new();
        for table in tables {
            let file = measures::file_name(table);
            let svgs = table_chart::charts(table)?;
            if svgs.is_empty() {
                undrawn.push(file.clone());
            }
            let last = svgs.len().saturating_sub(1);
            let chart = |(index, svg)| {
                let caption = if index == last {
                    table.caption.clone()
                } else {
                    String::new()
                };
                DataChart {
                    svg,
                    caption,
                    file: file.clone(),
                }
            };
            let weight = weight(table)
                + if shows(table, main) {
                    OF_MAIN_FIGURE
                } else {
                    0
                };
            drawn.push((weight, svgs.into_iter().enumerate().map(chart).collect()));
        }
        let mut order: Vec<usize> = (0..drawn.len())
            .filter(|&index| !drawn[index].1.is_empty())
            .collect();
        // The order of the scene among equals.
        order.sort_by_key(|&index| std::cmp::Reverse(drawn[index].0));
        order.truncate(count);
        let evidence = order
            .iter()
            .map(|&index| drawn[index].1.remove(0))
            .collect();
        // The energy is a check: it comes after what the scene asks for.
        let (checks, asked): (Vec<DataChart>, Vec<DataChart>) = drawn
            .into_iter()
            .flat_map(|(_, charts)| charts)
            .partition(|chart| chart.file == ENERGY.name);
        Ok(Self {
            evidence,
            others: [asked, checks].concat(),
            undrawn,
        })
    }
}

/// More than any other weight.
const OF_MAIN_FIGURE: u8 = 16;

/// Whether a figure is the mean of a curve of the table: it begins with the same words.
fn shows(table: &Table, main: &str) -> bool {
    let name = main.split(',').next().unwrap_or_default();
    table
        .columns
        .iter()
        .any(|column| column.role == Role::Value && column.label == name)
}

/// How much a table tells: 8 for a prediction, 4 for errors, 2 for a measured curve, 1 for one that
/// is no series in time; a curve that is derived, such as the energy drift, is a check.
fn weight(table: &Table) -> u8 {
    let has = |is: fn(&Role) -> bool| table.columns.iter().any(|column| is(&column.role));
    let is_predicted =
        has(|role| matches!(role, Role::Prediction { .. })) || !table.levels.is_empty();
    let is_series = table
        .columns
        .first()
        .is_some_and(|column| column.name == "time");
    8 * u8::from(is_predicted)
        + 4 * u8::from(has(|role| *role == Role::StandardError))
        + 2 * u8::from(has(|role| *role == Role::Value))
        + u8::from(!is_series)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_with_predictions_carry_the_answer() {
        let table = |name: &str| {
            Table::new(name, name)
                .abscissa("x", "1", vec![0.0, 1.0])
                .value("y", "1", vec![Some(1.0), Some(2.0)])
        };
        let tables = [
            Table::new("empty", "empty"),
            table("plain"),
            table("errors").errors(vec![Some(0.1); 2]),
            table("both")
                .errors(vec![Some(0.1); 2])
                .level("theory", Some(1.5), "source"),
            table("more").value("z", "length", vec![Some(0.0), Some(1.0)]),
        ];
        let charts = Charts::new(&tables, "no figure", 2).unwrap();
        let files = |charts: &[DataChart]| {
            charts
                .iter()
                .map(|chart| chart.file.clone())
                .collect::<Vec<_>>()
        };
        assert_eq!(files(&charts.evidence), ["both.csv", "errors.csv"]);
        assert_eq!(files(&charts.others), ["plain.csv", "more.csv", "more.csv"]);
        assert_eq!(charts.undrawn, ["empty.csv"]);
        let charts = Charts::new(&tables, "z, tag", 2).unwrap();
        assert_eq!(files(&charts.evidence), ["more.csv", "both.csv"]);
    }
}
