//! Charts of a sweep: each figure against the first varied key, one curve for each value of the
//! second, and one chart for each value of the others.

use anyhow::Result;
use carom_report::{
    error_bars::{Abscissa, ErrorBarCurve, ErrorBars, MeasuredValue as Point},
    ink::Ink,
    page::DataChart,
    table_chart::{self, NamedTable},
};
use carom_runs::report::MEASURED_FROM;
use carom_tables::{Figure, Role, named};

use crate::{
    point::{parts, short},
    results::PointResults,
    study::Study,
    table::{TABLE, TableQuantity, figure, quantities},
    vary::{ValueSpacing, Vary},
};

/// Most charts on a page; the table has the figures of the others.
const MAX_CHARTS: usize = 120;

/// A longer name stands in the title alone (characters).
const MAX_LABEL: usize = 32;

/// A logarithmic axis spans at least this factor.
const MIN_SPAN: f64 = 4.0;

/// The charts of all figures that have an error or differ between points, and the number of figures
/// that are left out: the most charts are drawn.
///
/// # Errors
/// A chart cannot be drawn.
pub fn charts(study: &Study, points: &[PointResults]) -> Result<(Vec<DataChart>, usize)> {
    let axes: Vec<usize> = (0..study.vary.len())
        .filter(|&axis| study.vary[axis].settings.len() > 1)
        .collect();
    let Some((&first, rest)) = axes.split_first() else {
        return Ok((Vec::new(), 0));
    };
    let (second, others) = match rest {
        [] => (None, &[][..]),
        [second, others @ ..] => (Some(*second), others),
    };
    let mut shown: Vec<TableQuantity> = quantities(points)
        .into_iter()
        .filter(|quantity| quantity.has_error || quantity.varies)
        .filter(|quantity| quantity.name != MEASURED_FROM)
        .collect();
    // Figures that are tested, and then those with a prediction, carry the answer.
    shown.sort_by_key(|quantity| {
        let tested = study.place_of_expectation(&quantity.name);
        // What every run measures comes after what the scene asks for.
        let is_rate = quantity.name.starts_with("collisions per");
        let is_z = quantity.name.starts_with("compressibility factor");
        (
            tested.unwrap_or(usize::MAX),
            std::cmp::Reverse(quantity.predicted),
            !quantity.has_error,
            !is_z,
            is_rate,
        )
    });
    let panels = panels(study, others);
    let most = (MAX_CHARTS / panels.len()).max(1);
    let left_out = shown.len().saturating_sub(most);
    let mut charts = Vec::new();
    for quantity in shown.iter().take(most) {
        for panel in &panels {
            charts.extend(chart(
                &Choice {
                    study,
                    points,
                    first,
                    second,
                    panel,
                },
                quantity,
            )?);
        }
    }
    Ok((charts, left_out))
}

/// The curves of all points in one chart for each table that has a measured curve: those that are
/// no series in time, which each run has for itself.
///
/// # Errors
/// A chart cannot be drawn.
pub fn overlaid(points: &[PointResults]) -> Result<Vec<DataChart>> {
    let mut names: Vec<&str> = Vec::new();
    for table in points.iter().flat_map(|point| &point.tables) {
        let is_series = table
            .columns
            .first()
            .is_some_and(|column| column.name == "time");
        if !is_series && table.names.is_empty() && !names.contains(&table.name.as_str()) {
            names.push(&table.name);
        }
    }
    let mut charts = Vec::new();
    let labels: Vec<String> = points.iter().enumerate().map(legend).collect();
    let inks = (0..points.len()).map(|index| Ink::of_curve(index, points.len()));
    let names = names.into_iter().take(MAX_CHARTS);
    for name in names {
        let of_points = points.iter().zip(labels.iter().zip(inks.clone()));
        let tables: Vec<NamedTable<'_>> = of_points
            .filter_map(|(point, (label, ink))| {
                let table = point.tables.iter().find(|table| table.name == name)?;
                Some(NamedTable {
                    name: label,
                    ink,
                    table,
                })
            })
            .collect();
        let mut values: Vec<&str> = Vec::new();
        for column in tables.iter().flat_map(|of_point| &of_point.table.columns) {
            if column.role == Role::Value && !values.contains(&column.name.as_str()) {
                values.push(&column.name);
            }
        }
        for value in values {
            let svg = table_chart::overlay(&tables, value)?;
            charts.extend(svg.map(|svg| DataChart {
                svg,
                caption: String::new(),
                file: String::new(),
            }));
        }
    }
    Ok(charts)
}

/// The name of a point in a legend: its values in words, or the values alone where these are long.
fn legend((index, point): (usize, &PointResults)) -> String {
    let words = point.short_label();
    let values = || {
        parts(&words)
            .into_iter()
            .map(|part| part.rsplit(" = ").next().unwrap_or(part))
            .collect::<Vec<_>>()
    };
    let fits = |label: &String| label.chars().count() <= MAX_LABEL;
    [words.clone(), values().join(", ")]
        .into_iter()
        .find(fits)
        .unwrap_or_else(|| format!("point {}", index + 1))
}

/// What one chart shows.
struct Choice<'a> {
    study: &'a Study,
    points: &'a [PointResults],
    /// The entry along the horizontal axis.
    first: usize,
    /// The entry that distinguishes the curves.
    second: Option<usize>,
    /// The settings of the other entries.
    panel: &'a [(usize, usize)],
}

/// All settings of some entries, as pairs of entry and setting.
fn panels(study: &Study, others: &[usize]) -> Vec<Vec<(usize, usize)>> {
    let mut panels: Vec<Vec<(usize, usize)>> = vec![Vec::new()];
    for &axis in others {
        let count = study.vary[axis].settings.len();
        let with = |before: &Vec<(usize, usize)>| {
            let before = before.clone();
            (0..count).map(move |setting| [before.clone(), vec![(axis, setting)]].concat())
        };
        panels = panels.iter().flat_map(with).collect();
    }
    panels
}

fn chart(choice: &Choice<'_>, quantity: &TableQuantity) -> Result<Option<DataChart>> {
    let Choice { study, panel, .. } = *choice;
    let axis = Axis::new(&study.vary[choice.first]);
    let curves = curves(choice, quantity, &axis.places);
    // A single value is in the table; a chart of it says nothing.
    if curves.iter().map(|curve| curve.values.len()).sum::<usize>() < 2 {
        return Ok(None);
    }
    // The title has a long name already.
    let is_long = quantity.name.chars().count() > MAX_LABEL;
    let y_label = if is_long {
        quantity.unit.clone()
    } else {
        named(&quantity.name, &quantity.unit)
    };
    let places = panel
        .iter()
        .map(|&(axis, requested)| setting_names(&study.vary[axis])[requested].clone());
    let title = std::iter::once(quantity.name.clone())
        .chain(places)
        .collect::<Vec<_>>()
        .join(", ");
    let chart = ErrorBars {
        title,
        x_label: axis.label,
        y_label,
        abscissa: axis.abscissa,
        curves,
    };
    Ok(Some(DataChart {
        svg: chart.svg()?,
        caption: String::new(),
        file: TABLE.to_owned(),
    }))
}

/// The values of a figure at the points of a chart, one curve for each setting of the second entry;
/// `places` are those of the settings of the first.
fn curves(choice: &Choice<'_>, quantity: &TableQuantity, places: &[f64]) -> Vec<ErrorBarCurve> {
    let Choice {
        study,
        points,
        first,
        second,
        panel,
    } = *choice;
    let names = second.map_or_else(
        || vec![String::new()],
        |second| setting_names(&study.vary[second]),
    );
    let mut curves: Vec<ErrorBarCurve> = names
        .into_iter()
        .map(|name| ErrorBarCurve {
            name,
            values: Vec::new(),
        })
        .collect();
    for (index, results) in points.iter().enumerate() {
        let is_here = panel
            .iter()
            .all(|&(axis, requested)| study.setting(index, axis) == requested);
        let Some(figure) =
            figure(results, quantity).filter(|figure| is_here && figure.value.is_finite())
        else {
            continue;
        };
        let curve = second.map_or(0, |second| study.setting(index, second));
        let x = places[study.setting(index, first)];
        curves[curve]
            .values
            .push(measured_value(x, figure, results));
    }
    for curve in &mut curves {
        curve.values.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    curves
}

/// A figure of a point at the place `x` of a chart, with what is expected of it.
fn measured_value(x: f64, figure: &Figure, results: &PointResults) -> Point {
    // The first that is a number, no bound, and no other measurement.
    let expected = |show_only: bool| {
        let answers = results
            .answers
            .iter()
            .filter(|answer| answer.quantity == figure.name);
        let mut answers =
            answers.filter(|answer| answer.show_only == show_only && !answer.is_measured);
        answers.find_map(|answer| answer.expected.parse().ok())
    };
    Point {
        x,
        y: figure.value,
        error: figure.standard_error,
        prediction: expected(false).or(figure.prediction),
        guide: expected(true),
    }
}

/// The horizontal axis of an entry.
struct Axis {
    label: String,
    abscissa: Abscissa,
    /// The place of each setting.
    places: Vec<f64>,
}

impl Axis {
    /// The first key, or the label, whose values are different numbers, or else names.
    fn new(vary: &Vary) -> Self {
        let keys = if vary.names.is_none() {
            vary.keys.as_slice()
        } else {
            &[]
        };
        let of_key = |(index, key): (usize, &String)| {
            let number = |setting: &Vec<toml::Value>| match &setting[index] {
                toml::Value::Integer(whole) => Some(*whole as f64),
                toml::Value::Float(number) => Some(*number),
                _ => None,
            };
            let places = vary
                .settings
                .iter()
                .map(number)
                .collect::<Option<Vec<f64>>>()?;
            Some((vary.label.clone().unwrap_or_else(|| key.clone()), places))
        };
        let named = vary.label.clone().zip(vary.values_of_names());
        let are_different = |(_, places): &(String, Vec<f64>)| {
            places
                .iter()
                .enumerate()
                .all(|(i, place)| !places[..i].contains(place))
        };
        let mut numbers = named
            .into_iter()
            .chain(keys.iter().enumerate().filter_map(of_key));
        if let Some((key, places)) = numbers.find(are_different) {
            let low = places.iter().copied().fold(f64::INFINITY, f64::min);
            let high = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let is_logarithmic =
                vary.spacing == ValueSpacing::Logarithmic && low > 0.0 && high >= MIN_SPAN * low;
            let abscissa = if is_logarithmic {
                Abscissa::Logarithmic
            } else {
                Abscissa::Linear
            };
            return Self {
                label: short(&key).replace('_', " "),
                abscissa,
                places,
            };
        }
        let columns = vary.columns();
        let keys: Vec<&str> = columns.iter().map(|key| short(key)).collect();
        let names = (0..vary.settings.len()).map(|setting| vary.cells(setting).join(", "));
        Self {
            label: keys.join(", ").replace('_', " "),
            abscissa: Abscissa::Names(names.collect()),
            places: (0..vary.settings.len()).map(|index| index as f64).collect(),
        }
    }
}

/// The settings of an entry in words.
fn setting_names(vary: &Vary) -> Vec<String> {
    let words = |setting: usize| {
        let parts = vary.columns().into_iter().zip(vary.cells(setting));
        let parts =
            parts.map(|(key, value)| format!("{} = {value}", short(&key).replace('_', " ")));
        parts.collect::<Vec<_>>().join(", ")
    };
    (0..vary.settings.len()).map(words).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_tables::{Figure, Totals};
    use std::path::Path;

    const STUDY: &str = "[[vary]]\nkey = \"gas.0.count\"\nvalues = [4, 5]\n[[vary]]\nkey = \"gas.0.mass\"\n\
                         values = [1.0, 2.0, 3.0]\n[[vary]]\nkey = \"gas.0.tags\"\nvalues = [[\"a\"], [\"b\"]]\n\
                         [[scene.gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\n";

    #[test]
    fn the_second_key_gives_curves_and_the_third_charts() {
        let study = Study::parse(STUDY, Path::new(""), crate::Size::default()).unwrap();
        let result = |(index, point): (usize, &crate::point::StudyPoint)| PointResults {
            point: point.key,
            label: point.label.clone(),
            replicas: vec![1],
            figures: vec![
                Figure::new("pressure", index as f64, "1").error(0.1),
                Figure::new("constant", 3.0, "1"),
                Figure::new("rate", index as f64, "1/time").predicted(1.0, "theory"),
            ],
            totals: Totals::default(),
            checks: Vec::new(),
            answers: Vec::new(),
            errors: Vec::new(),
            evidence: Vec::new(),
            tables: Vec::new(),
            note: String::new(),
        };
        let points: Vec<PointResults> = study.points.iter().enumerate().map(result).collect();
        let (charts, left_out) = charts(&study, &points).unwrap();
        assert_eq!(
            (charts.len(), left_out),
            (4, 0),
            "two figures, two settings of the third key"
        );
        assert!(charts[0].svg.contains("rate") && charts[2].svg.contains("pressure"));
        for (chart, tag) in charts.iter().zip(["a", "b", "a", "b"]) {
            assert!(chart.svg.contains("mass = 2.0") && chart.svg.contains("count"));
            assert!(
                chart.svg.contains(&format!("tags = [&quot;{tag}&quot;]")),
                "{}",
                chart.svg
            );
        }
        for (index, point) in study.points.iter().enumerate() {
            let mass = study.setting(index, 1);
            assert_eq!(point.scene.gas[0].mass, Some((1.0 + mass as f64).into()));
        }
    }
}
