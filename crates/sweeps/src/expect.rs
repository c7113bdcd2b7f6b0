//! `[[expect]]`: what theory or an earlier measurement says of a quantity, and how far a sweep may
//! be from it.

use anyhow::{Context, Result, bail, ensure};
use carom::engine::did_you_mean;
use carom_tables::{
    Check, Column, Figure, MIN_BLOCKS, Role, Table, named, student_quantile, two_digits,
    with_error, without_numbers,
};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use toml::Value;

/// Standard errors by which a quantity may differ if nothing else is given: of 1000 quantities, one
/// in 16 sweeps exceeds it by chance.
const STANDARD_ERRORS: f64 = 4.0;

/// Values of an abscissa that differ by a smaller share are the same row: they differ by rounding.
const SAME_ABSCISSA: f64 = 1e-9;

/// What is expected of one quantity at all points, or at some.
///
/// The quantity is a figure, or a column of a table at a value of its abscissa, such as a
/// correlation at one lag. It equals the expected value if they differ by at most
/// `standard_errors` · (standard error) + `relative` · |expected value| + `absolute`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Expect {
    /// Name of a figure, as in `summary.json`; `…` stands for a number in it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub figure: Option<String>,
    /// Name of a table, such as `correlation-gas`: its file without `.csv`. Excludes `figure`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
    /// Column of the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Value of the abscissa of the table (in its unit); between two rows the column is
    /// interpolated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<f64>,
    /// The expected value, in the unit of the quantity; default: the prediction of the measure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Expected values, one for each point that is tested, in their order. Excludes `value`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<f64>>,
    /// Name of another figure of the same point, to which this one must be equal; its standard
    /// error counts as well, as if the two were independent. Excludes `value`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub same_as: Option<String>,
    /// The quantity must be above this by more than the allowed difference. Excludes `value`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub above: Option<f64>,
    /// The quantity must be below this by more than the allowed difference. Excludes `value`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub below: Option<f64>,
    /// Allowed difference in standard errors, at least 0; default: 4. The error of a figure from
    /// fewer than 30 blocks or runs is widened, so that chance exceeds it as rarely (Student's t).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub standard_errors: Option<f64>,
    /// Allowed difference relative to the expected value, at least 0; default: 0.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0))]
    pub relative: f64,
    /// Allowed difference in the unit of the quantity, at least 0; default: 0.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0))]
    pub absolute: f64,
    /// The points that are tested: for some varied keys, the values at which they are.
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "serde_json::Map<String, serde_json::Value>")]
    pub only: toml::Table,
    /// If true, the chart and the table of the page show the expected value, and a difference is
    /// not a failure: for a theory that is only a rough guide. Default: false.
    #[serde(skip_serializing_if = "is_false")]
    pub show_only: bool,
    /// Where the expected value comes from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes a reference"
)]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes a reference"
)]
fn is_false(value: &bool) -> bool {
    !value
}

/// What is expected.
#[derive(Debug, Clone, PartialEq)]
enum Requested {
    /// This value.
    Equal(f64),
    /// The prediction of the measure.
    Predicted,
    /// The value of another figure, with its standard error.
    SameAs(Measured),
    Above(f64),
    Below(f64),
}

/// Header of a table of [`ExpectationAnswer::cells`].
pub const EXPECTATIONS: [&str; 7] = [
    "result",
    "point",
    "quantity",
    "measured",
    "expected",
    "may differ by",
    "source",
];

/// A measured quantity against what is expected of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExpectationAnswer {
    /// The quantity.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// What was measured; NaN is written as null.
    #[serde(deserialize_with = "number_or_null")]
    pub value: f64,
    /// The standard error, where it is known.
    pub standard_error: Option<f64>,
    /// What is expected, such as `1.5` or `> 0`.
    pub expected: String,
    /// The largest allowed difference.
    #[serde(deserialize_with = "number_or_null")]
    pub allowed: f64,
    /// Difference from what is expected; of bounds, by how much they are missed.
    #[serde(deserialize_with = "number_or_null")]
    pub difference: f64,
    /// Whether it is as expected.
    pub passed: bool,
    /// Whether what is expected is another measurement (see [`Expect::same_as`]).
    #[serde(default, skip_serializing_if = "is_false")]
    pub is_measured: bool,
    /// Whether a difference is no failure (see [`Expect::show_only`]).
    #[serde(default, skip_serializing_if = "is_false")]
    pub show_only: bool,
    /// Where the expected value comes from.
    pub source: String,
}

/// Reads a number, or null, which is NaN.
fn number_or_null<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

impl ExpectationAnswer {
    /// Whether this is a failure of the study.
    pub fn has_failed(&self) -> bool {
        !self.passed && !self.show_only
    }

    /// Its cells in a table with the header [`EXPECTATIONS`].
    pub fn cells(&self, point: String) -> Vec<String> {
        let result = match (self.show_only, self.passed) {
            (true, _) => "only shown",
            (_, true) => "as expected",
            (_, false) => "NOT AS EXPECTED",
        };
        let allowed = if self.is_bound() {
            "–".to_owned()
        } else {
            with_error(two_digits(self.allowed), None)
        };
        // The result stands first: a narrow screen shows the first columns.
        vec![
            result.to_owned(),
            point,
            named(&self.quantity, &self.unit),
            with_error(self.value, self.standard_error),
            self.rounded(),
            allowed,
            self.source.clone(),
        ]
    }

    /// Whether what is expected is a bound and not a value.
    pub fn is_bound(&self) -> bool {
        self.expected.starts_with(['<', '>'])
    }

    /// The answer as a check, named with its point.
    pub fn check(&self, point: &str) -> Check {
        Check {
            name: format!(
                "{}, {point}: difference from {}",
                self.quantity,
                self.rounded()
            ),
            found: self.difference,
            allowed: self.allowed,
            passed: self.passed,
        }
    }

    /// The expected value with as many digits as a reader needs.
    pub fn rounded(&self) -> String {
        self.expected
            .parse::<f64>()
            .map_or_else(|_| self.expected.clone(), |value| with_error(value, None))
    }
}

/// A measured quantity.
#[derive(Debug, Clone, PartialEq)]
struct Measured {
    name: String,
    unit: String,
    value: f64,
    error: Option<f64>,
    /// The number of blocks or runs that the error comes from, if it is known.
    blocks: Option<usize>,
    prediction: Option<f64>,
    source: Option<String>,
}

impl Measured {
    /// The distance from its expectation that chance exceeds as rarely as a Gaussian mean this many
    /// standard errors; 0 without an error.
    fn by_chance(&self, standard_errors: f64) -> f64 {
        let Some(error) = self.error.filter(|error| *error > 0.0) else {
            return 0.0;
        };
        let few = self
            .blocks
            .filter(|blocks| (2..MIN_BLOCKS).contains(blocks));
        few.map_or(standard_errors, |blocks| {
            student_quantile(standard_errors, blocks)
        }) * error
    }
}

impl Expect {
    /// Refuses an entry without a quantity, with contradictory keys, with an invalid tolerance, or
    /// for values that no point has. `points` are the cells of all points.
    ///
    /// # Errors
    /// The key and what it allows.
    pub fn check(&self, keys: &[&str], points: &[Vec<(String, Value)>]) -> Result<()> {
        self.check_quantity()?;
        self.check_values()?;
        self.check_tolerances()?;
        self.check_only(keys, points)
    }

    /// Refuses an entry that names no quantity, or two.
    fn check_quantity(&self) -> Result<()> {
        match (&self.figure, &self.table) {
            (Some(_), Some(_)) => bail!("`figure` and `table` exclude each other"),
            (None, None) => {
                bail!("`figure` is missing: the name of a figure; or `table`, `column` and `at`")
            }
            (Some(_), None) => {
                ensure!(
                    self.column.is_none() && self.at.is_none(),
                    "`column` and `at` need `table`"
                );
            }
            (None, Some(_)) => {
                ensure!(
                    self.column.is_some(),
                    "`column` is missing: a column of the table"
                );
                ensure!(
                    self.at.is_some_and(f64::is_finite),
                    "`at` is missing: a value of the abscissa"
                );
            }
        }
        Ok(())
    }

    /// Refuses expected values that contradict each other or are not finite.
    fn check_values(&self) -> Result<()> {
        let given = [self.value, self.above, self.below]
            .iter()
            .flatten()
            .count();
        ensure!(
            given + usize::from(self.values.is_some()) + usize::from(self.same_as.is_some()) <= 1,
            "`value`, `values`, `same_as`, `above` and `below` exclude each other"
        );
        let numbers = [self.value, self.above, self.below].into_iter().flatten();
        for number in numbers.chain(self.values.iter().flatten().copied()) {
            ensure!(
                number.is_finite(),
                "an expected value must be finite, but is {number}"
            );
        }
        ensure!(
            self.same_as.is_none() || self.same_as != self.figure,
            "`same_as` and `figure` name the same figure"
        );
        Ok(())
    }

    /// Refuses allowed differences that are negative or not finite.
    fn check_tolerances(&self) -> Result<()> {
        let tolerances = [
            (
                "standard_errors",
                self.standard_errors.unwrap_or(STANDARD_ERRORS),
            ),
            ("relative", self.relative),
            ("absolute", self.absolute),
        ];
        for (key, tolerance) in tolerances {
            ensure!(
                tolerance.is_finite() && tolerance >= 0.0,
                "`{key}` must be at least 0 and finite, but is {tolerance}"
            );
        }
        Ok(())
    }

    /// Refuses `only` with keys that do not vary, or values that no point has.
    fn check_only(&self, keys: &[&str], points: &[Vec<(String, Value)>]) -> Result<()> {
        for (key, values) in &self.only {
            ensure!(
                keys.contains(&key.as_str()),
                "`only`: the key `{key}` does not vary{}",
                did_you_mean(key, keys.iter().copied())
            );
            let Value::Array(values) = values else {
                bail!("`only`: give a list of values of `{key}`")
            };
            let cells = || points.iter().flatten().filter(|(name, _)| name == key);
            for requested in values {
                let is_there = cells().any(|(_, value)| is_same(value, requested));
                ensure!(is_there, "`only`: no point has {key} = {requested}");
            }
        }
        Ok(())
    }

    /// Whether a point is tested: its cell for each varied key, or for the common path of named
    /// settings.
    pub fn applies(&self, cells: &[(String, Value)]) -> bool {
        self.only.iter().all(|(key, requested)| {
            let mut of_key = cells.iter().filter(|(name, _)| name == key);
            let requested = requested.as_array().map_or(&[][..], Vec::as_slice);
            of_key.any(|(_, value)| requested.iter().any(|requested| is_same(value, requested)))
        })
    }

    /// Compares what was measured at a point; `number` is the place of the point among those that
    /// are tested.
    pub fn answer(&self, number: usize, figures: &[Figure], tables: &[Table]) -> ExpectationAnswer {
        let compared = self.measured(figures, tables).and_then(|measured| {
            let requested = self.requested(number, figures)?;
            Ok(self.compare(measured, &requested))
        });
        compared.unwrap_or_else(|reason| ExpectationAnswer {
            quantity: format!("{reason:#}"),
            unit: String::new(),
            value: f64::NAN,
            standard_error: None,
            expected: "a value".to_owned(),
            allowed: 0.0,
            difference: f64::NAN,
            passed: false,
            is_measured: false,
            // A quantity that is missing fails in any case.
            show_only: false,
            source: self.source.clone().unwrap_or_default(),
        })
    }

    fn measured(&self, figures: &[Figure], tables: &[Table]) -> Result<Measured> {
        self.figure
            .as_ref()
            .map_or_else(|| self.of_table(tables), |name| of_figure(name, figures))
    }

    /// What is expected at the tested point of this number.
    fn requested(&self, number: usize, figures: &[Figure]) -> Result<Requested> {
        let of_point = self
            .values
            .as_ref()
            .and_then(|values| values.get(number).copied());
        Ok(
            match (
                self.above,
                self.below,
                self.value.or(of_point),
                &self.same_as,
            ) {
                (Some(above), ..) => Requested::Above(above),
                (_, Some(below), ..) => Requested::Below(below),
                (_, _, Some(value), _) => Requested::Equal(value),
                (.., Some(other)) => Requested::SameAs(of_figure(other, figures)?),
                _ => Requested::Predicted,
            },
        )
    }

    fn compare(&self, measured: Measured, requested: &Requested) -> ExpectationAnswer {
        let standard_errors = self.standard_errors.unwrap_or(STANDARD_ERRORS);
        let of_other = match requested {
            Requested::SameAs(other) => other.by_chance(standard_errors),
            _ => 0.0,
        };
        let by_error = measured.by_chance(standard_errors).hypot(of_other);
        let Measured {
            name,
            unit,
            value,
            error,
            prediction,
            source,
            ..
        } = measured;
        let tolerance = |expected: f64| by_error + self.relative * expected.abs() + self.absolute;
        let equal = |expected: f64| {
            (
                expected.to_string(),
                tolerance(expected),
                (value - expected).abs(),
            )
        };
        let (expected, allowed, difference) = match *requested {
            Requested::Equal(expected) => equal(expected),
            Requested::SameAs(ref other) => equal(other.value),
            Requested::Predicted => {
                prediction.map_or(("a prediction".to_owned(), f64::NAN, f64::NAN), equal)
            }
            Requested::Above(least) => {
                (format!("> {least}"), 0.0, least + tolerance(least) - value)
            }
            Requested::Below(most) => (format!("< {most}"), 0.0, value - (most - tolerance(most))),
        };
        let is_strict = matches!(requested, Requested::Above(_) | Requested::Below(_));
        let passed = if is_strict {
            difference < allowed
        } else {
            difference <= allowed
        };
        let given = self.source.clone().or_else(|| self.same_as.clone());
        ExpectationAnswer {
            quantity: name,
            unit,
            value,
            standard_error: error,
            expected,
            allowed,
            difference,
            passed,
            is_measured: matches!(requested, Requested::SameAs(_)),
            show_only: self.show_only,
            source: given.or(source).unwrap_or_default(),
        }
    }

    /// The column of the table at the abscissa, linear between two rows.
    fn of_table(&self, tables: &[Table]) -> Result<Measured> {
        let (name, requested) = (
            self.table.as_deref().unwrap_or(""),
            self.column.as_deref().unwrap_or(""),
        );
        let at = self.at.unwrap_or(f64::NAN);
        let table = find_table(name, tables)?;
        let place = find_column(requested, table)?;
        ensure!(
            table.grid().is_none(),
            "the table {name} is a map: only a table with one abscissa has a value `at` one number"
        );
        let (column, abscissa) = (&table.columns[place], &table.columns[0]);
        let rows = RowsAround::new(column, abscissa, at).with_context(|| {
            format!(
                "the table {name} has no {requested} at {} {at}",
                abscissa.name
            )
        })?;
        let beside = || {
            let after = table.columns[place + 1..].iter();
            after.take_while(|c| matches!(c.role, Role::StandardError | Role::Prediction { .. }))
        };
        let error = beside()
            .find(|c| c.role == Role::StandardError)
            .and_then(|c| rows.value(c));
        let predicted = beside().find(|c| c.role != Role::StandardError);
        Ok(Measured {
            name: format!("{requested} at {} {at}, {name}", abscissa.name),
            unit: column.unit.clone(),
            value: rows.value(column).unwrap_or(f64::NAN),
            error,
            blocks: None,
            prediction: predicted.and_then(|column| rows.value(column)),
            source: predicted.and_then(|column| column.role.words().1.map(str::to_owned)),
        })
    }
}

/// Two neighbouring rows of a table.
struct RowsAround {
    rows: [usize; 2],
    /// The share of the second row in a value between them.
    share: f64,
}

impl RowsAround {
    /// The rows around an abscissa, of those in which the column has a value; `None` if it lies
    /// outside of them.
    fn new(column: &Column, abscissa: &Column, at: f64) -> Option<Self> {
        let rows: Vec<(f64, usize)> = abscissa
            .values
            .iter()
            .enumerate()
            .filter_map(|(row, x)| Some(((*x)?, row)))
            .filter(|&(_, row)| column.values[row].is_some())
            .collect();
        let near = SAME_ABSCISSA * at.abs();
        let after = rows.iter().position(|&(x, _)| x >= at - near)?;
        let (x, row) = rows[after];
        if (x - at).abs() <= near {
            return Some(Self {
                rows: [row; 2],
                share: 1.0,
            });
        }
        let (x_before, before) = rows[after.checked_sub(1)?];
        Some(Self {
            rows: [before, row],
            share: (at - x_before) / (x - x_before),
        })
    }

    /// The value of a column between the rows.
    fn value(&self, column: &Column) -> Option<f64> {
        let [before, after] = self.rows.map(|row| column.values[row]);
        Some(before? * (1.0 - self.share) + after? * self.share)
    }
}

/// The table of this name.
fn find_table<'a>(name: &str, tables: &'a [Table]) -> Result<&'a Table> {
    let found = tables.iter().find(|table| table.name == name);
    let names = tables.iter().map(|table| table.name.as_str());
    found.with_context(|| format!("no table is called {name}{}", did_you_mean(name, names)))
}

/// The place of the column of this name.
fn find_column(name: &str, table: &Table) -> Result<usize> {
    let place = table.columns.iter().position(|column| column.name == name);
    let names = table.columns.iter().map(|column| column.name.as_str());
    place.with_context(|| {
        format!(
            "the table {} has no column {name}{}",
            table.name,
            did_you_mean(name, names)
        )
    })
}

/// The figure of this name, or of this name without its numbers.
fn of_figure(name: &str, figures: &[Figure]) -> Result<Measured> {
    let exact = figures.iter().find(|figure| figure.name == name);
    let found = exact.or_else(|| {
        figures
            .iter()
            .find(|figure| without_numbers(&figure.name) == without_numbers(name))
    });
    let names = || figures.iter().map(|figure| figure.name.as_str());
    let figure = found
        .with_context(|| format!("no figure is called {name}{}", did_you_mean(name, names())))?;
    Ok(Measured {
        name: figure.name.clone(),
        unit: figure.unit.clone(),
        value: figure.value,
        error: figure.standard_error,
        blocks: figure.blocks,
        prediction: figure.prediction,
        source: figure.source.clone(),
    })
}

/// Equality of values, in which 1 and 1.0 are the same.
fn is_same(a: &Value, b: &Value) -> bool {
    let number = |value: &Value| {
        value
            .as_float()
            .or(value.as_integer().map(|whole| whole as f64))
    };
    a == b || number(a).is_some_and(|a| number(b) == Some(a))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expect(text: &str) -> Expect {
        let expect: Expect = toml::from_str(text).unwrap();
        expect.check(&["gas.0.mass"], &points()).unwrap();
        expect
    }

    /// The cells of three points.
    fn points() -> Vec<Vec<(String, Value)>> {
        [1.0, 2.0, 3.0]
            .map(|mass| vec![("gas.0.mass".to_owned(), Value::Float(mass))])
            .to_vec()
    }

    fn figures() -> Vec<Figure> {
        vec![
            Figure::new("pressure", 2.0, "1")
                .error(0.01)
                .predicted(2.02, "theory"),
            Figure::new("diffusion coefficient, from lags 5.000 to 20.000", 0.3, "1"),
        ]
    }

    fn tables() -> Vec<Table> {
        vec![
            Table::new("fall", "Distance")
                .abscissa("time", "time", vec![0.0, 1.0, 2.0])
                .value("distance", "length", vec![Some(0.0), Some(5.0), Some(20.0)])
                .errors(vec![Some(0.1), Some(0.1), Some(0.3)])
                .prediction(
                    "g t²/2",
                    vec![Some(0.0), Some(4.9), Some(19.6)],
                    "Galilei (1638)",
                ),
        ]
    }

    fn passes(text: &str) -> bool {
        let answer = expect(text).answer(0, &figures(), &tables());
        assert_eq!(answer.check("here").passed, answer.passed);
        answer.passed
    }

    #[test]
    fn differences_are_allowed_up_to_the_sum_of_the_tolerances() {
        assert!(passes("figure = \"pressure\""));
        assert!(!passes("figure = \"pressure\"\nstandard_errors = 1.5"));
        assert!(passes(
            "figure = \"pressure\"\nstandard_errors = 1.5\nrelative = 0.005"
        ));
        assert!(passes(
            "figure = \"pressure\"\nvalue = 2.1\nstandard_errors = 0\nabsolute = 0.11"
        ));
        assert!(!passes("figure = \"pressure\"\nvalue = 2.1"));
        assert!(passes("figure = \"pressure\"\nvalues = [1.99, 7.0]"));
        assert!(
            passes("figure = \"pressure\"\nabove = 1.95")
                && !passes("figure = \"pressure\"\nabove = 1.97")
        );
        assert!(
            passes("figure = \"pressure\"\nbelow = 2.05")
                && !passes("figure = \"pressure\"\nbelow = 2.0")
        );
        // Numbers that depend on the data may be left out; without a prediction nothing is equal.
        let lags = "figure = \"diffusion coefficient, from lags … to …\"\n";
        assert!(passes(&format!("{lags}value = 0.3")) && !passes(lags));
    }

    #[test]
    fn figures_of_two_routes_agree_within_both_errors() {
        let routes = [
            Figure::new("by momentum", 2.0, "1").error(0.03),
            Figure::new("by density", 2.2, "1").error(0.04),
        ];
        let agree = |standard_errors: f64| {
            let route = "figure = \"by momentum\"\nsame_as = \"by density\"";
            expect(&format!("{route}\nstandard_errors = {standard_errors}")).answer(0, &routes, &[])
        };
        // They differ by 0.2, four times √(0.03² + 0.04²).
        assert!(agree(4.01).passed && !agree(3.99).passed);
        assert_eq!(
            (&agree(4.0).expected[..], &agree(4.0).source[..]),
            ("2.2", "by density")
        );
        let answer =
            expect("figure = \"by momentum\"\nsame_as = \"by densty\"").answer(0, &routes, &[]);
        assert!(
            !answer.passed && answer.quantity.contains("did you mean `by density`?"),
            "{answer:?}"
        );
    }

    #[test]
    fn errors_from_few_blocks_are_widened() {
        let passes = |blocks: Option<usize>| {
            let figures = [Figure {
                blocks,
                ..Figure::new("pressure", 2.06, "1").error(0.01)
            }];
            let text = "figure = \"pressure\"\nvalue = 2.0";
            expect(text).answer(0, &figures, &[]).passed
        };
        // Six standard errors: chance exceeds 4 of a Gaussian as rarely as 13 of five blocks.
        assert!([2, 3, 5].iter().all(|&blocks| passes(Some(blocks))));
        assert!(![20, MIN_BLOCKS].iter().any(|&blocks| passes(Some(blocks))));
        assert!(!passes(None));
    }

    #[test]
    fn a_difference_from_what_is_only_shown_is_no_failure() {
        let answer =
            expect("figure = \"pressure\"\nvalue = 7\nshow_only = true").answer(0, &figures(), &[]);
        assert!(!answer.passed && !answer.has_failed() && answer.expected == "7");
        // A misspelt name does.
        let answer =
            expect("figure = \"presure\"\nvalue = 7\nshow_only = true").answer(0, &figures(), &[]);
        assert!(answer.has_failed(), "{answer:?}");
    }

    #[test]
    fn a_column_is_interpolated_between_rows() {
        let at = |at: f64| {
            let text = format!("table = \"fall\"\ncolumn = \"distance\"\nat = {at}");
            expect(&text).answer(0, &[], &tables())
        };
        let half = at(1.5);
        assert!(
            (half.value - 12.5).abs() < 1e-12
                && half.expected == "12.25"
                && half.source.contains("Galilei")
        );
        assert!((half.standard_error.unwrap() - 0.2).abs() < 1e-12 && half.passed);
        assert_eq!(
            (at(1.0).value, at(0.0).value, at(2.0).value),
            (5.0, 0.0, 20.0)
        );
        assert!(!at(2.5).passed && at(2.5).quantity.contains("no distance at time 2.5"));
        assert!(!at(-1.0).passed);
        // Below zero too, and in the last row, up to rounding.
        let below = [Table::new("fall", "Height")
            .abscissa("height", "length", vec![-0.3, -0.1])
            .value("distance", "length", vec![Some(1.0), Some(2.0)])];
        let last =
            expect("table = \"fall\"\ncolumn = \"distance\"\nat = -0.10000000000000002\nvalue = 2");
        assert!(last.answer(0, &[], &below).passed);
    }

    #[test]
    fn what_is_not_measured_fails_with_a_hint() {
        let answer = expect("figure = \"presure\"").answer(0, &figures(), &[]);
        assert!(
            !answer.passed && answer.quantity.contains("did you mean `pressure`?"),
            "{answer:?}"
        );
        let answer = expect("table = \"fal\"\ncolumn = \"x\"\nat = 0").answer(0, &[], &tables());
        assert!(
            answer.quantity.contains("did you mean `fall`?"),
            "{answer:?}"
        );
    }

    #[test]
    fn points_are_chosen_by_the_values_of_their_keys() {
        let only = expect("figure = \"pressure\"\n[only]\n\"gas.0.mass\" = [1, 3]");
        assert_eq!(
            points()
                .iter()
                .map(|cells| only.applies(cells))
                .collect::<Vec<_>>(),
            [true, false, true]
        );
    }

    #[test]
    fn contradictory_entries_are_refused() {
        for (text, expected) in [
            ("value = 1", "`figure` is missing"),
            ("figure = \"a\"\ntable = \"b\"", "exclude each other"),
            ("figure = \"a\"\nat = 1", "need `table`"),
            ("table = \"a\"\nat = 1", "`column` is missing"),
            ("table = \"a\"\ncolumn = \"b\"", "`at` is missing"),
            ("figure = \"a\"\nvalue = 1\nabove = 0", "exclude each other"),
            (
                "figure = \"a\"\nvalue = 1\nsame_as = \"b\"",
                "exclude each other",
            ),
            ("figure = \"a\"\nsame_as = \"a\"", "the same figure"),
            ("figure = \"a\"\nvalue = nan", "must be finite"),
            (
                "figure = \"a\"\nrelative = -0.1",
                "`relative` must be at least 0",
            ),
            (
                "figure = \"a\"\n[only]\n\"gas.0.maß\" = [1]",
                "did you mean `gas.0.mass`?",
            ),
            ("figure = \"a\"\n[only]\n\"gas.0.mass\" = 1", "give a list"),
            (
                "figure = \"a\"\n[only]\n\"gas.0.mass\" = [1, 4]",
                "no point has gas.0.mass = 4",
            ),
        ] {
            let entry: Expect = toml::from_str(text).unwrap();
            let error = entry
                .check(&["gas.0.mass"], &points())
                .unwrap_err()
                .to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
