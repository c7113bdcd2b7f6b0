//! Charts of a table: measured columns with error bands, and predictions.

use anyhow::Result;
use carom_tables::{Column, Role, Spacing, Table};
use plotters::style::RGBColor;

use crate::plot::{Axis, Chart, Layer, Shape, colour};

/// Colours of measured quantities in one chart, in order.
const COLOURS: [RGBColor; 4] = [colour::BLUE, colour::GREEN, colour::ORANGE, colour::PURPLE];

/// Most points of a line; of longer columns every second, third, … value is drawn. More: pages of
/// long runs grow to many megabytes.
const MOST_POINTS: usize = 4000;

/// Half width of an error band, in standard errors.
const BAND: f64 = 2.0;

/// Draws the charts of a table: one for all neighbouring quantities of the same unit. A table with
/// fewer than two points has none.
///
/// # Errors
/// A chart cannot be drawn.
pub fn charts(table: &Table) -> Result<Vec<String>> {
    let Some(abscissa) = table.columns.iter().find(|column| column.role == Role::Abscissa) else {
        return Ok(Vec::new());
    };
    let mut groups: Vec<Vec<&Column>> = Vec::new();
    for column in &table.columns {
        let begins =
            column.role == Role::Value && groups.last().is_none_or(|group| group[0].unit != column.unit);
        match groups.last_mut() {
            _ if matches!(column.role, Role::Abscissa | Role::Count) => {}
            Some(group) if !begins => group.push(column),
            _ => groups.push(vec![column]),
        }
    }
    groups.iter().filter_map(|group| chart(table, abscissa, group).transpose()).collect()
}

fn chart(table: &Table, abscissa: &Column, group: &[&Column]) -> Result<Option<String>> {
    let abscissae: Vec<Option<f64>> = match table.spacing {
        Spacing::Linear => abscissa.values.clone(),
        Spacing::Logarithmic => {
            let logarithm = |x: &Option<f64>| x.filter(|x| *x > 0.0).map(f64::log10);
            abscissa.values.iter().map(logarithm).collect()
        }
    };
    let points = |column: &Column| points(&abscissae, column);
    let values = || group.iter().filter(|column| column.role != Role::StandardError).flat_map(|c| points(c));
    let Some(x) = range(values().map(|point| point.0)) else { return Ok(None) };
    let Some((low, high)) = range(values().map(|point| point.1)) else { return Ok(None) };
    // From 0 on where 0 is near.
    let low = if low > 0.0 && low < 0.5 * high { 0.0 } else { low };
    let room = if high > low { 0.08 * (high - low) } else { high.abs().max(1e-15) };
    let low = if low == 0.0 { 0.0 } else { low - room };
    if x.0 == x.1 {
        return Ok(None);
    }
    let names = group.iter().filter(|column| column.role == Role::Value).map(|column| column.label.as_str());
    let quantity = names.collect::<Vec<_>>().join(", ");
    let label =
        |name: &str, unit: &str| if unit == "1" { name.to_owned() } else { format!("{name} [{unit}]") };
    let chart = Chart {
        title: table.title.clone(),
        x: Axis { label: label(&abscissa.label, &abscissa.unit), range: x },
        y: Axis { label: label(&quantity, &group[0].unit), range: (low, high + room) },
        layers: layers(&abscissae, group),
    };
    match table.spacing {
        Spacing::Linear => chart.svg().map(Some),
        Spacing::Logarithmic => chart.svg_in_decades_of_x().map(Some),
    }
}

/// The points of a column that are drawn.
fn points(abscissae: &[Option<f64>], column: &Column) -> Vec<(f64, f64)> {
    let points = abscissae.iter().zip(&column.values).filter_map(|(x, y)| Some(((*x)?, (*y)?)));
    points.step_by(abscissae.len().div_ceil(MOST_POINTS).max(1)).collect()
}

/// Error bands, then the lines of measured values, then those of predictions.
fn layers(abscissae: &[Option<f64>], group: &[&Column]) -> Vec<Layer> {
    let (mut bands, mut lines, mut predictions) = (Vec::new(), Vec::new(), Vec::new());
    let mut value: Option<&Column> = None;
    let mut quantities = 0;
    for &column in group {
        let measured = COLOURS[quantities.max(1).min(COLOURS.len()) - 1];
        match &column.role {
            Role::Value => {
                let colour = COLOURS[quantities.min(COLOURS.len() - 1)];
                (value, quantities) = (Some(column), quantities + 1);
                lines.push(Layer {
                    name: column.label.clone(),
                    colour,
                    shape: Shape::Line(points(abscissae, column)),
                });
            }
            Role::StandardError => {
                let Some(value) = value else { continue };
                let band = abscissae.iter().zip(value.values.iter().zip(&column.values));
                let band = band.filter_map(|(x, (y, error))| {
                    let (x, y, error) = ((*x)?, (*y)?, (*error)?);
                    Some((x, y - BAND * error, y + BAND * error))
                });
                let shape = Shape::Band(band.collect());
                bands.push(Layer { name: String::new(), colour: measured, shape });
            }
            Role::Prediction { .. } => {
                let (name, colour) = (column.label.clone(), colour::VERMILLION);
                predictions.push(Layer { name, colour, shape: Shape::Line(points(abscissae, column)) });
            }
            Role::Abscissa | Role::Count => {}
        }
    }
    bands.into_iter().chain(lines).chain(predictions).collect()
}

/// Least and largest value; `None` without values.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, value| {
        Some(range.map_or((value, value), |(low, high): (f64, f64)| (low.min(value), high.max(value))))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_of_one_unit_share_a_chart() {
        let some = |values: [f64; 3]| values.map(Some).to_vec();
        let table = Table::new("t", "Two lengths and a speed")
            .abscissa("time", "time", vec![0.0, 1.0, 2.0])
            .counts("events", vec![1, 2, 3])
            .value("near", "length", some([1.0, 2.0, 3.0]))
            .errors(some([0.1, 0.1, 0.1]))
            .value("far", "length", some([3.0, 4.0, 5.0]))
            .value("speed", "length/time", some([1.0, 1.0, 1.0]))
            .prediction("1", some([1.0, 1.0, 1.0]), "definition");
        let charts = charts(&table).unwrap();
        assert_eq!(charts.len(), 2);
        assert!(charts[0].contains("near, far [length]") && charts[1].contains("speed [length/time]"));
    }

    #[test]
    fn a_quantity_that_does_not_change_can_be_drawn() {
        for value in [0.0, 2.5] {
            let table = Table::new("t", "T").abscissa("time", "time", vec![0.0, 1.0]).value(
                "x",
                "1",
                vec![Some(value); 2],
            );
            assert_eq!(charts(&table).unwrap().len(), 1);
        }
    }

    #[test]
    fn a_table_without_two_points_has_no_chart() {
        let table = Table::new("t", "T").abscissa("time", "time", vec![1.0]).value("x", "1", vec![Some(2.0)]);
        assert!(charts(&table).unwrap().is_empty());
        let empty = Table::new("t", "T").abscissa("time", "time", vec![]).value("x", "1", vec![]);
        assert!(charts(&empty).unwrap().is_empty());
    }
}
