//! Charts of a table: measured columns with error bands, and predictions.

use anyhow::Result;
use carom_tables::{Column, Guide, Level, Role, Spacing, Table, TableGrid, named};

use crate::{
    axis::{Axis, height, range},
    chart::{Chart, Layer, LayerShape},
    error_bars::{Abscissa, ErrorBarCurve, ErrorBars, MeasuredValue},
    ink::Ink,
    map::{ColourBar, Map, NARROW, NO_VALUE},
    polar::Polar,
};

/// Most points of a line; of longer columns every second, third, … value is drawn. More: pages of
/// long runs grow to many megabytes.
const MAX_POINTS: usize = 4000;

/// Half width of an error band, in standard errors.
const BAND: f64 = 2.0;

/// Longest title (characters) that names the quantities of a chart; longer ones are in small print.
const MAX_TITLE: usize = 52;

/// Most quantities that the title of a chart names.
const MAX_LABELS: usize = 2;

/// Draws the charts of a table: one for all neighbouring quantities of the same unit, or, over a
/// [grid](Table::grid), a map of each quantity. A table with fewer than two points has none.
///
/// # Errors
/// A chart cannot be drawn.
pub fn charts(table: &Table) -> Result<Vec<String>> {
    let table = &table.as_drawn();
    let Some(abscissa) = table
        .columns
        .iter()
        .find(|column| column.role == Role::Abscissa)
    else {
        return Ok(Vec::new());
    };
    let mut groups: Vec<Vec<&Column>> = Vec::new();
    for column in &table.columns {
        let begins = column.role.is_curve()
            && groups
                .last()
                .is_none_or(|group| group[0].unit != column.unit);
        match groups.last_mut() {
            _ if matches!(
                column.role,
                Role::Abscissa | Role::Count | Role::Undrawn | Role::Width
            ) => {}
            Some(group) if !begins => group.push(column),
            _ => groups.push(vec![column]),
        }
    }
    if let Some(grid) = table.grid() {
        let has_values = |column: &&Column| column.values.iter().any(Option::is_some);
        let curves = table.columns.iter().filter(|column| column.role.is_curve());
        return Ok(curves
            .filter(has_values)
            .map(|column| map(table, grid, column))
            .collect());
    }
    let places = Places::new(abscissa, table.spacing);
    let mut charts = Vec::new();
    for group in &groups {
        let titled = (groups.len() > 1).then(|| titled(table, group));
        let table = titled.as_ref().unwrap_or(table);
        if table.is_polar {
            charts.extend(polar(table, group)?);
        }
        charts.extend(if table.names.is_empty() {
            chart(table, abscissa, &places, group)?
        } else {
            Some(points(table, abscissa, group)?)
        });
    }
    Ok(charts)
}

/// The table with a title for the chart of one group of its columns: the quantities of the group,
/// unless that is too long.
fn titled(table: &Table, group: &[&Column]) -> Table {
    let mut table = table.clone();
    let curves = group.iter().filter(|column| column.role.is_curve());
    let mut labels: Vec<String> = curves
        .map(|column| column.label.replace('_', " "))
        .collect();
    if labels.len() > MAX_LABELS {
        labels.truncate(MAX_LABELS);
        labels.push("…".to_owned());
    }
    let title = format!("{}: {}", table.title, labels.join(", "));
    if !labels.is_empty() && title.chars().count() <= MAX_TITLE {
        table.title = title;
    }
    table
}

/// A quantity over a grid as a map with a colour bar.
fn map(table: &Table, grid: TableGrid, column: &Column) -> String {
    let (bar, [low, high]) = ColourBar::of_values(column.values.iter().flatten().copied());
    let colour = |value: &Option<f64>| {
        value.map_or(NO_VALUE, |value| bar.colour((value - low) / (high - low)))
    };
    let colours = column.values.iter().map(colour).collect();
    Map {
        title: format!("{}: {}", table.title, named(&column.label, &column.unit)),
        sides: grid.sides,
        longer: NARROW,
        counts: grid.counts,
        colours,
        bar,
    }
    .svg()
}

/// One of the tables of an overlay.
#[derive(Debug, Clone, Copy)]
pub struct NamedTable<'a> {
    /// The name of its curve.
    pub name: &'a str,
    /// The colour of its curve.
    pub ink: Ink,
    /// The table.
    pub table: &'a Table,
}

/// Draws one quantity of tables of one kind, such as g(r) at several densities, each curve under
/// the name of its table. Without a second curve nothing is drawn.
///
/// # Errors
/// The chart cannot be drawn.
pub fn overlay(tables: &[NamedTable<'_>], column: &str) -> Result<Option<String>> {
    let (mut bands, mut lines, mut points, mut found) = (Vec::new(), Vec::new(), Vec::new(), None);
    let mut count = 0;
    for &NamedTable { name, ink, table } in tables {
        let table = table.as_drawn();
        let mut abscissae = table.columns.iter();
        let abscissa = abscissae.find(|column| column.role == Role::Abscissa);
        // A map is no curve.
        let Some(abscissa) = abscissa.filter(|_| table.grid().is_none()) else {
            continue;
        };
        let Some(place) = table.columns.iter().position(|other| other.name == column) else {
            continue;
        };
        let places = Places::new(abscissa, table.spacing);
        let value = &table.columns[place];
        if let Some(errors) = table
            .columns
            .get(place + 1)
            .filter(|next| next.role == Role::StandardError)
        {
            let band = |points| Layer {
                name: String::new(),
                ink,
                shape: LayerShape::Band(points),
            };
            bands.extend(places.band(value, errors).into_iter().map(band));
        }
        points.extend(places.points(value));
        let pieces = places.curve(value);
        count += usize::from(!pieces.is_empty());
        lines.extend(curve(name, ink, pieces));
        found.get_or_insert((table.clone(), abscissa.clone(), value.clone()));
    }
    let Some((table, abscissa, value)) = found.filter(|_| count > 1) else {
        return Ok(None);
    };
    let x = range(points.iter().map(|point| point.0)).filter(|(first, last)| first != last);
    let (Some(x), Some((low, high))) = (x, range(points.iter().map(|point| point.1))) else {
        return Ok(None);
    };
    let along = horizontal(&table, &abscissa, x);
    let (label, mut layers) = (named(&value.label, &value.unit), [bands, lines].concat());
    let least =
        range(points.iter().map(|point| point.1).filter(|y| *y > 0.0)).map_or(1.0, |range| range.0);
    let is_logarithmic = table.decades.contains(&value.name) && low >= 0.0 && high > least;
    let up = if is_logarithmic {
        for layer in &mut layers {
            layer.shape.leave_out_below(least);
        }
        Axis::logarithmic(label, (0.7 * least, 1.4 * high))
    } else {
        Axis::new(label, height(low, high))
    };
    Chart::new(&table.title, along, up, layers).svg().map(Some)
}

/// The axis of an abscissa over a range of it.
fn horizontal(table: &Table, abscissa: &Column, range: (f64, f64)) -> Axis {
    let label = named(&abscissa.label.replace('_', " "), &abscissa.unit);
    match table.spacing {
        Spacing::Linear => Axis::new(label, range),
        Spacing::Logarithmic => Axis::logarithmic(label, range),
    }
}

/// The measured quantities of a group as points over the names of the rows.
fn points(table: &Table, abscissa: &Column, group: &[&Column]) -> Result<String> {
    let mut curves: Vec<ErrorBarCurve> = Vec::new();
    let cell = |column: &Column, row: usize| column.values.get(row).copied().flatten();
    for column in group {
        match (&column.role, curves.last_mut()) {
            (Role::Value | Role::Derived, _) => {
                let value = |row: usize| {
                    let (x, y) = (row as f64, cell(column, row)?);
                    Some(MeasuredValue {
                        x,
                        y,
                        error: None,
                        prediction: None,
                        guide: None,
                    })
                };
                let values = (0..table.names.len()).filter_map(value).collect();
                curves.push(ErrorBarCurve {
                    name: column.label.clone(),
                    values,
                });
            }
            (Role::StandardError, Some(curve)) => {
                curve
                    .values
                    .iter_mut()
                    .for_each(|value| value.error = cell(column, value.x as usize));
            }
            (Role::Prediction { .. }, Some(curve)) => {
                curve
                    .values
                    .iter_mut()
                    .for_each(|value| value.prediction = cell(column, value.x as usize));
            }
            _ => {}
        }
    }
    let label = curves
        .iter()
        .map(|curve| curve.name.clone())
        .collect::<Vec<_>>()
        .join(", ");
    if let [only] = &mut curves[..] {
        only.name.clear();
    }
    let chart = ErrorBars {
        title: table.title.clone(),
        x_label: abscissa.label.replace('_', " "),
        y_label: named(&label, &group[0].unit),
        abscissa: Abscissa::Names(table.names.clone()),
        curves,
    };
    chart.svg()
}

/// The last measured quantity of a group as a polar chart; none if a sector lacks a value or has a
/// negative one.
fn polar(table: &Table, group: &[&Column]) -> Result<Option<String>> {
    let Some(place) = group.iter().rposition(|column| column.role == Role::Value) else {
        return Ok(None);
    };
    let full = |column: &Column| column.values.iter().copied().collect::<Option<Vec<f64>>>();
    let is_positive = |values: &Vec<f64>| values.iter().all(|value| *value >= 0.0);
    let Some(measured) = full(group[place]).filter(is_positive) else {
        return Ok(None);
    };
    let mut curves = vec![(group[place].label.clone(), Ink::Blue, measured)];
    let mut errors = Vec::new();
    for column in &group[place + 1..] {
        match &column.role {
            Role::StandardError => {
                errors = full(column)
                    .unwrap_or_default()
                    .into_iter()
                    .map(|error| BAND * error)
                    .collect();
            }
            Role::Prediction { .. } => {
                curves.extend(
                    full(column).map(|values| (column.label.clone(), Ink::Vermillion, values)),
                );
            }
            _ => {}
        }
    }
    let title = format!("{}, polar chart", table.title);
    let label = format!("radius: {}", named(&group[place].label, &group[place].unit));
    Polar {
        title,
        label,
        curves,
        errors,
    }
    .svg()
    .map(Some)
}

/// The abscissae of a chart: as drawn, `None` where there is no place.
struct Places(Vec<Option<f64>>);

impl Places {
    fn new(abscissa: &Column, spacing: Spacing) -> Self {
        let is_placed = |x: &f64| spacing == Spacing::Linear || *x > 0.0;
        Self(
            abscissa
                .values
                .iter()
                .map(|x| x.filter(is_placed))
                .collect(),
        )
    }

    /// At most [`MAX_POINTS`] of the rows of a column, at equal distances.
    fn thinned<T>(&self, rows: Vec<T>) -> Vec<T> {
        rows.into_iter()
            .step_by(self.0.len().div_ceil(MAX_POINTS).max(1))
            .collect()
    }

    fn points(&self, column: &Column) -> Vec<(f64, f64)> {
        self.0
            .iter()
            .zip(&column.values)
            .filter_map(|(x, y)| Some(((*x)?, (*y)?)))
            .collect()
    }

    /// The pieces of a curve between rows without a value.
    fn curve(&self, column: &Column) -> Vec<Vec<(f64, f64)>> {
        let rows = self
            .0
            .iter()
            .zip(&column.values)
            .map(|(x, y)| Some(((*x)?, (*y)?)));
        pieces(rows)
            .into_iter()
            .map(|piece| self.thinned(piece))
            .collect()
    }

    /// The pieces of the band around a column, from its errors.
    fn band(&self, column: &Column, errors: &Column) -> Vec<Vec<(f64, f64, f64)>> {
        let rows = self.0.iter().zip(column.values.iter().zip(&errors.values));
        let rows = rows.map(|(x, (y, error))| {
            let (x, y, error) = ((*x)?, (*y)?, (*error)?);
            Some((x, y - BAND * error, y + BAND * error))
        });
        pieces(rows)
            .into_iter()
            .map(|piece| self.thinned(piece))
            .collect()
    }
}

/// Splits rows where there is no value. A curve of which most points would stand alone is not
/// split: it has a value in every second row, say.
fn pieces<T>(rows: impl Iterator<Item = Option<T>>) -> Vec<Vec<T>> {
    let mut pieces: Vec<Vec<T>> = vec![Vec::new()];
    for row in rows {
        match (row, pieces.last_mut()) {
            (Some(value), Some(last)) => last.push(value),
            (None, Some(last)) if !last.is_empty() => pieces.push(Vec::new()),
            _ => (),
        }
    }
    pieces.retain(|piece| !piece.is_empty());
    let alone = pieces.iter().filter(|piece| piece.len() == 1).count();
    if 2 * alone > pieces.len() {
        vec![pieces.into_iter().flatten().collect()]
    } else {
        pieces
    }
}

fn chart(
    table: &Table,
    abscissa: &Column,
    places: &Places,
    group: &[&Column],
) -> Result<Option<String>> {
    let levels: Vec<&Level> = table
        .levels
        .iter()
        .filter(|level| group.iter().any(|column| column.name == level.column))
        .collect();
    let curves: Vec<(f64, f64)> = group
        .iter()
        .filter(|column| column.role != Role::StandardError)
        .flat_map(|column| places.points(column))
        .collect();
    let Some(x) = range(curves.iter().map(|point| point.0)).filter(|(first, last)| first != last)
    else {
        return Ok(None);
    };
    let heights = curves
        .iter()
        .map(|point| point.1)
        .chain(levels.iter().map(|level| level.value));
    let Some((low, high)) = range(heights) else {
        return Ok(None);
    };
    let is_steep = table.decades.contains(&group[0].name);
    // The displacement at lag 0 has no logarithm, and is left out.
    let least =
        range(curves.iter().map(|point| point.1).filter(|y| *y > 0.0)).map_or(1.0, |range| range.0);
    let is_logarithmic = is_steep && low >= 0.0 && high > least;
    let along = horizontal(table, abscissa, x);
    let label = named(&quantity(group), &group[0].unit);
    let (up, mut layers) = (
        height(low, high),
        layers(places, group, &levels, x, table.colour),
    );
    if is_logarithmic && table.spacing == Spacing::Logarithmic {
        layers.extend(guides(table, places, group, x, [least, high]));
    }
    let up = if is_logarithmic {
        for layer in &mut layers {
            layer.shape.leave_out_below(least);
        }
        Axis::logarithmic(label, (0.7 * least, 1.4 * high))
    } else {
        Axis::new(label, up)
    };
    Chart::new(&table.title, along, up, layers).svg().map(Some)
}

/// The names of the curves of a group, for the vertical axis.
fn quantity(group: &[&Column]) -> String {
    let names: Vec<&str> = group
        .iter()
        .filter(|column| column.role.is_curve() && column.values.iter().any(Option::is_some))
        .map(|column| column.label.as_str())
        .collect();
    match names.as_slice() {
        // The legend names them all.
        [first, .., last] if names.len() > 2 => format!("{first} … {last}"),
        _ => names.join(", "),
    }
}

/// Error bands, measured curves and predictions, from back to front.
fn layers(
    places: &Places,
    group: &[&Column],
    levels: &[&Level],
    x: (f64, f64),
    colour: usize,
) -> Vec<Layer> {
    let (mut bands, mut lines, mut predictions) = (Vec::new(), Vec::new(), Vec::new());
    let mut last: Option<(&Column, Ink)> = None;
    let mut count = 0;
    for &column in group {
        match &column.role {
            Role::Value | Role::Derived => {
                let ink = Ink::CURVES[(colour + count) % Ink::CURVES.len()];
                count += 1;
                last = Some((column, ink));
                lines.extend(curve(&column.label, ink, places.curve(column)));
            }
            Role::StandardError => {
                let Some((value, ink)) = last else { continue };
                let band = |points| Layer {
                    name: String::new(),
                    ink,
                    shape: LayerShape::Band(points),
                };
                bands.extend(places.band(value, column).into_iter().map(band));
            }
            Role::Prediction { .. } => {
                predictions.extend(curve(&column.label, Ink::Vermillion, places.curve(column)));
            }
            Role::Abscissa | Role::Count | Role::Undrawn | Role::Width => {}
        }
    }
    let level = |level: &&Level| {
        let points = vec![(x.0, level.value), (x.1, level.value)];
        Layer {
            name: level.label.clone(),
            ink: Ink::Vermillion,
            shape: LayerShape::Line(points),
        }
    };
    predictions.extend(levels.iter().map(level));
    if count == 1 && predictions.is_empty() {
        // The axis names a single curve.
        for line in &mut lines {
            line.name.clear();
        }
    }
    bands.into_iter().chain(lines).chain(predictions).collect()
}

/// The powers of the abscissa beside a column, within the range of the chart.
fn guides(
    table: &Table,
    places: &Places,
    group: &[&Column],
    (first, last): (f64, f64),
    [low, high]: [f64; 2],
) -> Vec<Layer> {
    let of = |guide: &Guide| {
        let column = group.iter().find(|column| column.name == guide.column)?;
        let points: Vec<(f64, f64)> = places
            .points(column)
            .into_iter()
            .filter(|point| point.1 > 0.0)
            .collect();
        let &(x, y) = if guide.from_end {
            points.last()?
        } else {
            points.first()?
        };
        let at = |abscissa: f64| (abscissa, y * (abscissa / x).powf(guide.power));
        let reaches = |height: f64| x * (height / y).powf(1.0 / guide.power);
        // Two points are a straight line where both axes are logarithmic.
        let [left, right] = if guide.power > 0.0 {
            [low, high]
        } else {
            [high, low]
        }
        .map(reaches);
        let ends = [first.max(left), last.min(right)].map(at);
        let shape = LayerShape::Thin(ends.to_vec());
        (ends[0].0 < ends[1].0).then(|| Layer {
            name: guide.label.clone(),
            ink: Ink::Quiet,
            shape,
        })
    };
    table.guides.iter().filter_map(of).collect()
}

/// A curve in pieces, of which the first carries the name.
fn curve(name: &str, ink: Ink, pieces: Vec<Vec<(f64, f64)>>) -> Vec<Layer> {
    let layer = |(index, points)| {
        let name = if index == 0 {
            name.to_owned()
        } else {
            String::new()
        };
        Layer {
            name,
            ink,
            shape: LayerShape::Line(points),
        }
    };
    pieces.into_iter().enumerate().map(layer).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_over_a_grid_has_a_map_of_each_quantity_that_has_values() {
        let table = Table::new("fields", "Fields")
            .abscissa("x", "length", vec![0.5, 1.5, 0.5, 1.5])
            .abscissa("y", "length", vec![0.5, 0.5, 1.5, 1.5])
            .counts("bodies", vec![1, 2, 3, 4])
            .value("spin", "1/time", vec![None; 4])
            .value("kT", "energy", vec![Some(1.0), Some(2.0), None, Some(3.0)])
            .errors(vec![Some(0.1); 4]);
        let charts = charts(&table).unwrap();
        let [map] = &charts[..] else {
            panic!("{} charts", charts.len())
        };
        assert!(
            map.contains("Fields: kT (energy)") && map.contains(">2.5</text>"),
            "{map}"
        );
        let named = NamedTable {
            name: "a",
            ink: Ink::Blue,
            table: &table,
        };
        assert_eq!(overlay(&[named, named], "kT").unwrap(), None);
    }

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
        assert!(
            charts[0].contains("near, far (length)") && charts[1].contains("speed (length/time)")
        );
    }

    #[test]
    fn the_curves_of_several_tables_share_a_chart_under_their_names() {
        let table = |factor: f64, count: usize| {
            let x: Vec<f64> = (0..count).map(|index| index as f64).collect();
            let y = x.iter().map(|x| Some(factor * x)).collect();
            Table::new("g", "g(r)")
                .abscissa("r", "length", x)
                .value("g", "1", y)
                .errors(vec![Some(0.1); count])
        };
        let tables = [table(1.0, 4), table(2.0, 7), table(3.0, 4)];
        let names = ["thin", "dense", "solid"].into_iter().enumerate();
        let named: Vec<NamedTable<'_>> = names
            .zip(&tables)
            .map(|((index, name), table)| NamedTable {
                name,
                ink: Ink::of_curve(index, 3),
                table,
            })
            .collect();
        let chart = overlay(&named, "g").unwrap().unwrap();
        assert!(
            ["thin", "dense", "solid", "r (length)"]
                .iter()
                .all(|name| chart.contains(name)),
            "{chart}"
        );
        assert_eq!(chart, overlay(&named, "g").unwrap().unwrap());
        assert_eq!(overlay(&named[..1], "g").unwrap(), None);
        assert_eq!(overlay(&named, "h").unwrap(), None);
    }

    #[test]
    fn a_quantity_that_does_not_change_can_be_drawn() {
        for value in [0.0, 2.5] {
            let table = Table::new("t", "T")
                .abscissa("time", "time", vec![0.0, 1.0])
                .value("x", "1", vec![Some(value); 2]);
            assert_eq!(charts(&table).unwrap().len(), 1);
        }
    }

    #[test]
    fn a_level_is_drawn_over_the_whole_width_and_within_the_range() {
        let table = Table::new("t", "T")
            .abscissa("time", "time", vec![0.0, 1.0])
            .value("pressure", "1", vec![Some(1.0), Some(1.1)])
            .level("theory", Some(2.0), "definition")
            .undrawn("other", "1", vec![100.0, 200.0]);
        let charts = charts(&table).unwrap();
        assert_eq!(charts.len(), 1);
        assert!(charts[0].contains("theory") && !charts[0].contains("other"));
    }

    /// A long series with errors stays a small picture.
    #[test]
    fn long_columns_are_thinned() {
        let count = 300_000;
        let wave = |scale: f64| {
            (0..count)
                .map(|i| Some(scale * f64::from(i).sin()))
                .collect::<Vec<_>>()
        };
        let table = Table::new("t", "T")
            .abscissa("time", "time", (0..count).map(f64::from).collect())
            .value("x", "1", wave(1.0))
            .errors(wave(0.1))
            .prediction("theory", wave(0.9), "definition");
        let bytes = charts(&table).unwrap()[0].len();
        assert!(bytes < 400_000, "{bytes}");
    }

    #[test]
    fn a_curve_has_gaps_where_there_are_no_values() {
        let of = |values: [Option<f64>; 6]| pieces(values.into_iter());
        let gap = of([None, Some(1.0), Some(2.0), None, Some(3.0), Some(4.0)]);
        assert_eq!(gap, [vec![1.0, 2.0], vec![3.0, 4.0]]);
        let alternating = of([Some(1.0), None, Some(2.0), None, Some(3.0), None]);
        assert_eq!(alternating, [vec![1.0, 2.0, 3.0]]);
        assert_eq!(of([None; 6]), Vec::<Vec<f64>>::new());
    }

    #[test]
    fn named_rows_are_points_over_their_names() {
        let table = Table::new("t", "Kicks by atom")
            .abscissa("atom", "1", vec![0.0, 1.0])
            .value("share", "1", vec![Some(0.7), Some(0.3)])
            .errors(vec![Some(0.1), None])
            .prediction("arcs", vec![Some(0.6), None], "geometry")
            .named(vec!["A".to_owned(), "B".to_owned()]);
        let [chart] = &charts(&table).unwrap()[..] else {
            panic!("one chart")
        };
        assert!(
            chart.contains("predicted")
                && chart.contains("share")
                && chart.matches("<circle").count() >= 3
        );
    }

    #[test]
    fn powers_are_drawn_where_both_axes_are_logarithmic() {
        let table = Table::new("t", "Displacement")
            .abscissa("lag", "time", vec![0.0, 1.0, 10.0])
            .value("square", "length²", vec![Some(0.0), Some(1.0), Some(30.0)])
            .guide("square", 2.0, "∝ t²", false)
            .guide("square", 1.0, "∝ t", true);
        let steep = table.clone().logarithmic().in_decades(&["square"]);
        let drawn = charts(&steep).unwrap();
        assert!(drawn[0].contains("∝ t²") && drawn[0].contains("∝ t<"));
        assert!(!charts(&table).unwrap()[0].contains('∝'));
    }

    #[test]
    fn directions_are_drawn_as_such_too() {
        let table = Table::new("t", "Directions")
            .abscissa("direction", "°", vec![45.0, 135.0, 225.0, 315.0])
            .value(
                "share",
                "1",
                vec![Some(0.2), Some(0.3), Some(0.4), Some(0.1)],
            )
            .errors(vec![Some(0.01); 4])
            .prediction("isotropic", vec![Some(0.25); 4], "symmetry");
        let [alone] = &charts(&table).unwrap()[..] else {
            panic!("one chart")
        };
        let drawn = charts(&table.clone().polar()).unwrap();
        assert!(drawn.len() == 2 && drawn[0].contains("polar chart") && drawn[1] == *alone);
        let lacking = table.value("share", "1", vec![None; 4]).polar();
        assert_eq!(
            charts(&lacking)
                .unwrap()
                .iter()
                .filter(|svg| svg.contains("polar"))
                .count(),
            0
        );
    }

    #[test]
    fn a_table_without_two_points_has_no_chart() {
        let table = Table::new("t", "T")
            .abscissa("time", "time", vec![1.0])
            .value("x", "1", vec![Some(2.0)]);
        assert!(charts(&table).unwrap().is_empty());
        let empty = Table::new("t", "T")
            .abscissa("time", "time", vec![])
            .value("x", "1", vec![]);
        assert!(charts(&empty).unwrap().is_empty());
    }
}
