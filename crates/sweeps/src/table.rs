//! The table of a sweep: one row a point, with the varied values and all figures.

use std::collections::BTreeMap;

use anyhow::Result;
use carom_runs::output::Folder;
use carom_tables::{Figure, named, two_digits, with_error, without_numbers};

use crate::{point::short, results::PointResults, study::Study, vary::Vary};

/// Name of the file.
pub const TABLE: &str = "table.csv";

/// Values that differ by a smaller share are equal: they differ by rounding.
const ROUNDING: f64 = 1e-9;

/// What a figure has to do with a prediction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Predicted {
    /// There is none.
    Not,
    /// It has one.
    Known,
    /// It tests one.
    Tested,
}

impl Predicted {
    fn new(figure: &Figure) -> Self {
        match figure.prediction {
            _ if figure.is_test => Self::Tested,
            Some(_) => Self::Known,
            None => Self::Not,
        }
    }
}

/// A figure that points have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableQuantity {
    /// Its name; numbers that differ between points are left out.
    pub name: String,
    /// What the names of its figures have in common.
    pattern: String,
    /// Its unit.
    pub unit: String,
    /// Whether a point has its standard error.
    pub has_error: bool,
    /// What its figures have to do with predictions, at most.
    pub predicted: Predicted,
    /// Whether its value differs between points.
    pub varies: bool,
}

/// All figures that points have, in the order of the first point with each.
pub fn quantities(points: &[PointResults]) -> Vec<TableQuantity> {
    let mut all: Vec<(TableQuantity, f64)> = Vec::new();
    for (results, figure) in points
        .iter()
        .flat_map(|point| point.figures.iter().map(move |f| (point, f)))
    {
        let pattern = pattern(results, figure);
        let known = all
            .iter()
            .position(|(quantity, _)| quantity.pattern == pattern);
        let place = known.unwrap_or_else(|| {
            let (name, unit) = (figure.name.clone(), figure.unit.clone());
            let (has_error, predicted, varies) = (false, Predicted::Not, false);
            let pattern = pattern.clone();
            let quantity = TableQuantity {
                name,
                pattern,
                unit,
                has_error,
                predicted,
                varies,
            };
            all.push((quantity, figure.value));
            all.len() - 1
        });
        let (quantity, first) = &mut all[place];
        if quantity.name != figure.name {
            quantity.name = pattern;
        }
        quantity.has_error |= figure.standard_error.is_some();
        quantity.predicted = quantity.predicted.max(Predicted::new(figure));
        quantity.varies |= (figure.value - *first).abs() > ROUNDING * first.abs();
    }
    all.into_iter().map(|(quantity, _)| quantity).collect()
}

/// The figure of a point.
pub fn figure<'a>(point: &'a PointResults, quantity: &TableQuantity) -> Option<&'a Figure> {
    point
        .figures
        .iter()
        .find(|figure| pattern(point, figure) == quantity.pattern)
}

/// The name of a figure without its numbers, such as the lags of a fit, which depend on the data;
/// with them if the point has another figure of that name.
fn pattern(point: &PointResults, figure: &Figure) -> String {
    let pattern = without_numbers(&figure.name);
    let same = point
        .figures
        .iter()
        .filter(|other| without_numbers(&other.name) == pattern);
    if same.count() > 1 {
        figure.name.clone()
    } else {
        pattern
    }
}

/// Writes `table.csv`: the varied keys, the number of replicas, and each figure with its standard
/// error and its prediction, where a point has them.
///
/// # Errors
/// The file cannot be written.
pub fn write(folder: &Folder, study: &Study, points: &[PointResults]) -> Result<()> {
    let quantities = quantities(points);
    let is_test = |quantity: &TableQuantity| is_test(quantity, points);
    let mut header: Vec<String> = study.vary.iter().flat_map(Vary::columns).collect();
    header.push("replicas".to_owned());
    header.extend(
        quantities
            .iter()
            .flat_map(|quantity| columns(quantity, points)),
    );
    header.push("point".to_owned());
    let row = |(index, results): (usize, &PointResults)| {
        let mut row = cells(study, index);
        row.push(results.replicas.len().to_string());
        for quantity in &quantities {
            let figure = figure(results, quantity);
            let number =
                |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
            row.push(number(figure.map(|figure| figure.value)));
            let error = || number(figure.and_then(|figure| figure.standard_error));
            row.extend(quantity.has_error.then(error));
            row.extend(
                (quantity.predicted > Predicted::Not)
                    .then(|| number(figure.and_then(|figure| figure.prediction))),
            );
            let least = || number(figure.and_then(|figure| figure.smallest_difference));
            row.extend(is_test(quantity).then(least));
        }
        row.push(results.point.to_string());
        row
    };
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    folder.write_lasting_table(TABLE, &header, points.iter().enumerate().map(row))
}

/// The settings of a point, by its index.
fn cells(study: &Study, point: usize) -> Vec<String> {
    let entries = study.vary.iter().enumerate();
    entries
        .flat_map(|(entry, vary)| vary.cells(study.setting(point, entry)))
        .collect()
}

/// Whether a point has the smallest difference that a test of the quantity would have found.
fn is_test(quantity: &TableQuantity, points: &[PointResults]) -> bool {
    points
        .iter()
        .filter_map(|of| figure(of, quantity))
        .any(|of| of.smallest_difference.is_some())
}

/// The columns of a quantity: its value, and its error, its prediction and the smallest difference
/// where a point has them.
fn columns(quantity: &TableQuantity, points: &[PointResults]) -> Vec<String> {
    let name = column(&quantity.name);
    let more = [
        (quantity.has_error, "error"),
        (quantity.predicted > Predicted::Not, "prediction"),
        (is_test(quantity, points), "smallest_difference"),
    ];
    let more = more.iter().filter(|(is_there, _)| *is_there);
    let more: Vec<String> = more.map(|(_, word)| format!("{name}_{word}")).collect();
    [vec![name], more].concat()
}

/// The unit of each column of `table.csv` that belongs to a figure, by its name.
pub fn units(points: &[PointResults]) -> BTreeMap<String, String> {
    let all = quantities(points);
    let of_quantity = |quantity: &TableQuantity| {
        let unit = quantity.unit.clone();
        let names = columns(quantity, points).into_iter();
        names
            .map(move |name| (name, unit.clone()))
            .collect::<Vec<_>>()
    };
    all.iter().flat_map(of_quantity).collect()
}

/// The name of a column: letters, digits and underscores.
fn column(name: &str) -> String {
    let words = name
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("_")
}

/// Header and rows of the table on the page: figures that have an error or differ between points.
pub fn on_page(study: &Study, points: &[PointResults]) -> (Vec<String>, Vec<Vec<String>>) {
    let shown: Vec<TableQuantity> = quantities(points)
        .into_iter()
        .filter(|quantity| quantity.has_error || quantity.varies)
        .collect();
    let columns = study.vary.iter().flat_map(Vary::columns);
    let mut header: Vec<String> = columns.map(|key| short(&key).replace('_', " ")).collect();
    if header.is_empty() {
        header.push("point".to_owned());
    }
    header.push("replicas".to_owned());
    header.extend(
        shown
            .iter()
            .map(|quantity| named(&quantity.name, &quantity.unit)),
    );
    let row = |(index, results): (usize, &PointResults)| {
        let point = &study.points[index];
        let mut row = cells(study, index);
        if row.is_empty() {
            row.push(point.label.clone());
        }
        row.push(format!("{} of {}", results.replicas.len(), study.replicas));
        row.extend(shown.iter().map(|quantity| {
            let figure = figure(results, quantity);
            figure.map_or_else(
                || "–".to_owned(),
                |figure| with_error(figure.value, figure.standard_error),
            )
        }));
        row
    };
    (header, points.iter().enumerate().map(row).collect())
}

/// Header and rows of the figures that test their predictions, with the smallest differences that
/// would have been found.
pub fn tests_on_page(study: &Study, points: &[PointResults]) -> (Vec<String>, Vec<Vec<String>>) {
    let columns = study.vary.iter().flat_map(Vary::columns);
    let mut header: Vec<String> = columns.map(|key| short(&key).replace('_', " ")).collect();
    header.extend(["figure", "measured", "predicted", "smallest difference"].map(str::to_owned));
    let row = |(index, figure): (usize, &Figure)| {
        let (least, prediction) = (figure.smallest_difference?, figure.prediction?);
        let mut row = cells(study, index);
        row.push(named(&figure.name, &figure.unit));
        row.push(with_error(figure.value, figure.standard_error));
        row.extend([prediction, two_digits(least)].map(|value| with_error(value, None)));
        Some(row)
    };
    let of_point = |(index, point): (usize, &'_ PointResults)| {
        let figures = point.figures.iter().map(move |figure| (index, figure));
        figures.filter_map(row).collect::<Vec<_>>()
    };
    (
        header,
        points.iter().enumerate().flat_map(of_point).collect(),
    )
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::{Size, point::Key};
    use carom_tables::Totals;

    #[test]
    fn figures_whose_names_differ_by_numbers_are_one_quantity() {
        let point = |names: [&str; 2], value: f64| PointResults {
            point: Key::try_from("0".repeat(16)).unwrap(),
            label: String::new(),
            replicas: vec![1],
            figures: names
                .map(|name| Figure::new(name, value, "1").error(0.1))
                .to_vec(),
            totals: Totals::default(),
            checks: Vec::new(),
            answers: Vec::new(),
            errors: Vec::new(),
            evidence: Vec::new(),
            tables: Vec::new(),
            note: String::new(),
        };
        let points = [
            point(["slope from 0.2 to 1, gas", "k"], 1.0),
            point(["slope from 0.3 to 2, gas", "k"], 2.0),
        ];
        let found = quantities(&points);
        assert_eq!(
            found.iter().map(|q| q.name.as_str()).collect::<Vec<_>>(),
            ["slope from … to …, gas", "k"]
        );
        assert_eq!(figure(&points[1], &found[0]).unwrap().value, 2.0);
        // Two of a point remain apart.
        let points = [
            point(["mode 1", "mode 2"], 1.0),
            point(["mode 1", "mode 2"], 2.0),
        ];
        assert_eq!(
            quantities(&points)
                .iter()
                .map(|q| q.name.clone())
                .collect::<Vec<_>>(),
            ["mode 1", "mode 2"]
        );
    }

    #[test]
    fn only_figures_that_test_their_predictions_show_what_they_would_have_found() {
        let text =
            "replicas = 1\n[[scene.gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 2\n";
        let study = Study::parse(text, Path::new(""), Size::default()).unwrap();
        let velocity = Figure::new("velocity", 0.1, "length/time")
            .error(0.2)
            .predicted(0.0, "equilibrium");
        let point = PointResults {
            point: Key::try_from("0".repeat(16)).unwrap(),
            label: String::new(),
            replicas: vec![1],
            figures: vec![velocity.clone().test(), velocity],
            totals: Totals::default(),
            checks: Vec::new(),
            answers: Vec::new(),
            errors: Vec::new(),
            evidence: Vec::new(),
            tables: Vec::new(),
            note: String::new(),
        };
        let points = [point];
        // Of two figures of one name the table has the first.
        let units = units(&points);
        let columns = ["", "_error", "_prediction", "_smallest_difference"];
        assert_eq!(units.len(), columns.len());
        for column in columns.map(|word| format!("velocity{word}")) {
            assert_eq!(units[&column], "length/time");
        }
        let (header, rows) = tests_on_page(&study, &points);
        assert_eq!(
            header.last().map(String::as_str),
            Some("smallest difference")
        );
        assert_eq!((rows.len(), rows[0].len()), (1, header.len()));
        // 5.645 standard errors.
        assert_eq!(rows[0][1..], ["0.10 ± 0.20", "0", "1.1"]);
    }

    #[test]
    fn columns_have_names_that_programs_read() {
        assert_eq!(column("g(r) at contact, gas"), "g_r_at_contact_gas");
        assert_eq!(column("kurtosis ⟨v⁴⟩/⟨v²⟩²"), "kurtosis_v⁴_v²_²");
    }
}
