//! A table of a measured curve: columns with units, errors, and predictions with their sources.
//!
//! Writers, charts and pages show tables and know no physics.

use serde::{Deserialize, Serialize};

use crate::{BlockMean, fifteen_digits};

/// A table of equally long columns.
///
/// ```
/// use carom_tables::Table;
///
/// let table = Table::new("fall", "Distance of a falling stone")
///     .abscissa("time", "time", vec![1.0, 2.0])
///     .value("distance", "length", vec![Some(4.9), Some(19.7)])
///     .errors(vec![Some(0.1), Some(0.2)])
///     .prediction("g t²/2", vec![Some(4.905), Some(19.62)], "Galilei (1638)");
/// assert_eq!(table.header(), ["time", "distance", "distance_error", "distance_predicted"]);
/// assert_eq!(table.rows().len(), 2);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// Name of its file, without ending.
    pub name: String,
    /// Heading of its charts.
    pub title: String,
    /// What the reader must know, below the chart.
    pub caption: String,
    /// How the abscissa is drawn.
    pub spacing: Spacing,
    /// Names of columns that are drawn by their logarithms, if all their values are positive.
    pub decades: Vec<String>,
    /// Names of columns that are drawn in units of their value in the first row.
    pub relative: Vec<String>,
    /// Lines beside the curves that show how a power of the abscissa would run.
    pub guides: Vec<Guide>,
    /// Whether the abscissa is drawn as a direction, too: degrees at the middle of equal sectors of
    /// the turn.
    pub is_polar: bool,
    /// A name for each row, which stands on the axis in place of the abscissa; may be empty.
    pub names: Vec<String>,
    /// Place of the first curve's colour in the palette: that of the bodies measured.
    pub colour: usize,
    /// The columns, the abscissa first.
    pub columns: Vec<Column>,
    /// Predictions that do not depend on the abscissa.
    pub levels: Vec<Level>,
}

/// A prediction that does not depend on the abscissa; it is drawn, but is no column of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// Name of the column that it predicts.
    pub column: String,
    /// Name in the legend of a chart.
    pub label: String,
    /// The predicted value, in the unit of the column.
    pub value: f64,
    /// Where it comes from.
    pub source: String,
}

/// The grid of a table that has two abscissae: cells row by row from the lower left corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableGrid {
    /// Columns and rows.
    pub counts: [usize; 2],
    /// Width and height of all cells. A single column or row reaches from 0 to twice its middle.
    pub sides: [f64; 2],
}

/// A power of the abscissa, drawn beside a column whose axes are both logarithmic.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Guide {
    /// Name of the column.
    pub column: String,
    /// The power.
    pub power: f64,
    /// Name in the legend.
    pub label: String,
    /// Whether it goes through the last point of the column instead of the first.
    pub from_end: bool,
}

/// How an abscissa is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Spacing {
    /// In proportion.
    #[default]
    Linear,
    /// By its logarithm; values that are not positive are left out.
    Logarithmic,
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// Name in the header.
    pub name: String,
    /// Name in the legend of a chart.
    pub label: String,
    /// Unit, in the scene's units of mass, length and time; 1 for a pure number.
    pub unit: String,
    /// What the column holds.
    pub role: Role,
    /// Its values; `None` where there is none.
    pub values: Vec<Option<f64>>,
    /// Of a measured quantity: the number of its sums at each row, see [`BlockMean::quantity`];
    /// empty for one that is no mean.
    pub quantities: Vec<Option<usize>>,
}

/// What a column holds.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Role {
    /// The quantity that the others depend on.
    Abscissa,
    /// A number of events, which is not drawn.
    Count,
    /// Another quantity that is not drawn.
    Undrawn,
    /// The width of the bin whose centre is the abscissa; it is not drawn.
    Width,
    /// A measured quantity.
    Value,
    /// A measured quantity that follows from other columns: it is drawn, but is not in the file.
    Derived,
    /// The standard error of the value before it.
    StandardError,
    /// The prediction of the value before it.
    Prediction {
        /// Where it comes from.
        source: String,
    },
}

impl Role {
    /// Whether a column is a curve of its own in a chart.
    pub fn is_curve(&self) -> bool {
        matches!(self, Self::Value | Self::Derived)
    }

    /// The role as a word, and the source of a prediction.
    pub fn words(&self) -> (&'static str, Option<&str>) {
        match self {
            Self::Abscissa => ("abscissa", None),
            Self::Count => ("count", None),
            Self::Undrawn => ("quantity", None),
            Self::Width => ("bin width", None),
            Self::Value => ("value", None),
            Self::Derived => ("derived", None),
            Self::StandardError => ("standard error", None),
            Self::Prediction { source } => ("prediction", Some(source)),
        }
    }
}

impl Table {
    /// An empty table.
    pub fn new(name: impl Into<String>, title: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            title: title.into(),
            caption: String::new(),
            spacing: Spacing::Linear,
            decades: Vec::new(),
            relative: Vec::new(),
            guides: Vec::new(),
            is_polar: false,
            names: Vec::new(),
            colour: 0,
            columns: Vec::new(),
            levels: Vec::new(),
        }
    }

    /// Sets the caption.
    #[must_use]
    pub fn caption(self, caption: impl Into<String>) -> Self {
        Self {
            caption: caption.into(),
            ..self
        }
    }

    /// Draws the abscissa by its logarithm.
    #[must_use]
    pub fn logarithmic(self) -> Self {
        Self {
            spacing: Spacing::Logarithmic,
            ..self
        }
    }

    /// Draws these columns by their logarithms, if all their values are positive.
    #[must_use]
    pub fn in_decades(self, columns: &[&str]) -> Self {
        Self {
            decades: columns.iter().map(|name| (*name).to_owned()).collect(),
            ..self
        }
    }

    /// Draws these columns in units of their value in the first row, and leaves out what its error
    /// exceeds.
    #[must_use]
    pub fn relative_to_first(self, columns: &[&str]) -> Self {
        Self {
            relative: columns.iter().map(|name| (*name).to_owned()).collect(),
            ..self
        }
    }

    /// Draws a power of the abscissa through the first or the last point of a column, if both its
    /// axes are logarithmic.
    #[must_use]
    pub fn guide(mut self, column: &str, power: f64, label: &str, from_end: bool) -> Self {
        self.guides.push(Guide {
            column: column.to_owned(),
            power,
            label: label.to_owned(),
            from_end,
        });
        self
    }

    /// The table as its charts show it: columns that are [relative](Self::relative_to_first) are
    /// divided by their first value; what their errors exceed is left out, and so is what the
    /// errors of columns [in decades](Self::in_decades) exceed.
    #[must_use]
    pub fn as_drawn(&self) -> Self {
        let mut table = self.clone();
        // The place of the last value, what it is divided by, and whether noise is left out.
        let mut of_value: Option<(usize, f64, bool)> = None;
        for place in 0..table.columns.len() {
            let column = &mut table.columns[place];
            if column.role.is_curve() {
                let is_relative = self.relative.contains(&column.name);
                let is_resolved = is_relative || self.decades.contains(&column.name);
                let first = column.values.iter().flatten().copied().next();
                let scale = first.filter(|first| is_relative && *first > 0.0);
                if scale.is_some() {
                    column.label = format!("{} over its first value", column.label);
                    "1".clone_into(&mut column.unit);
                }
                of_value = Some((place, scale.unwrap_or(1.0), is_resolved));
            }
            let Some((value, scale, is_resolved)) = of_value else {
                continue;
            };
            let belongs = matches!(column.role, Role::StandardError | Role::Prediction { .. });
            if place == value || belongs {
                column
                    .values
                    .iter_mut()
                    .flatten()
                    .for_each(|number| *number /= scale);
            }
            if column.role == Role::StandardError && is_resolved {
                let errors = column.values.clone();
                let is_known = errors.iter().any(Option::is_some);
                let values = &mut table.columns[value].values;
                for (number, error) in values.iter_mut().zip(errors) {
                    // What has no error although others have one is not resolved either.
                    let is_noise =
                        |number: &f64| error.map_or(is_known, |error| error > number.abs());
                    *number = number.filter(|number| !is_noise(number));
                }
            }
        }
        table
    }

    /// Names the rows on the axis.
    #[must_use]
    pub fn named(self, names: Vec<String>) -> Self {
        Self { names, ..self }
    }

    /// Draws the abscissa, in degrees at the middle of equal sectors of the turn, as a direction
    /// too.
    #[must_use]
    pub fn polar(self) -> Self {
        Self {
            is_polar: true,
            ..self
        }
    }

    /// Adds the quantity that the others depend on. Times are rounded to 15 digits: those of
    /// samples are products, 3 · 0.1 = 0.30000000000000004.
    #[must_use]
    pub fn abscissa(self, name: &str, unit: &str, values: Vec<f64>) -> Self {
        let is_time = unit == "time";
        let values = values
            .into_iter()
            .map(|value| {
                Some(if is_time {
                    fifteen_digits(value)
                } else {
                    value
                })
            })
            .collect();
        self.column(name, name, unit, Role::Abscissa, values)
    }

    /// Adds the centres of bins as the quantity that the others depend on, and their widths, from
    /// the edges of the bins in ascending order.
    #[must_use]
    pub fn bins(self, name: &str, unit: &str, edges: &[f64]) -> Self {
        let centres = edges
            .windows(2)
            .map(|bin| bin[0] + 0.5 * (bin[1] - bin[0]))
            .collect();
        let widths = edges.windows(2).map(|bin| Some(bin[1] - bin[0])).collect();
        self.abscissa(name, unit, centres).column(
            "bin_width",
            "bin width",
            unit,
            Role::Width,
            widths,
        )
    }

    /// Adds a number of events.
    #[must_use]
    pub fn counts(self, name: &str, values: Vec<u64>) -> Self {
        let values = values.into_iter().map(|count| Some(count as f64)).collect();
        self.column(name, name, "1", Role::Count, values)
    }

    /// Adds a quantity that is in the file, but is not drawn.
    #[must_use]
    pub fn undrawn(self, name: &str, unit: &str, values: Vec<f64>) -> Self {
        let values = values.into_iter().map(Some).collect();
        self.column(name, name, unit, Role::Undrawn, values)
    }

    /// Adds a quantity that follows from other columns and is drawn, but is not in the file.
    #[must_use]
    pub fn derived(self, label: &str, unit: &str, values: Vec<Option<f64>>) -> Self {
        self.column(label, label, unit, Role::Derived, values)
    }

    /// Gives the last column that holds no errors another name in the legend.
    #[must_use]
    pub fn labelled(mut self, label: &str) -> Self {
        let mut columns = self.columns.iter_mut().rev();
        if let Some(column) = columns.find(|column| column.role != Role::StandardError) {
            label.clone_into(&mut column.label);
        }
        self
    }

    /// Adds a prediction of the quantity before that does not depend on the abscissa, with its name
    /// in the legend and its source; `None` adds nothing.
    #[must_use]
    pub fn level(mut self, label: &str, value: Option<f64>, source: &str) -> Self {
        let column = self
            .columns
            .iter()
            .rev()
            .find(|column| column.role.is_curve());
        if let (Some(column), Some(value)) = (column, value) {
            let (column, label, source) =
                (column.name.clone(), label.to_owned(), source.to_owned());
            self.levels.push(Level {
                column,
                label,
                value,
                source,
            });
        }
        self
    }

    /// Adds a measured quantity.
    #[must_use]
    pub fn value(self, name: &str, unit: &str, values: Vec<Option<f64>>) -> Self {
        self.column(name, &name.replace('_', " "), unit, Role::Value, values)
    }

    /// Adds a quantity by its means, with their standard errors.
    #[must_use]
    pub fn means(self, name: &str, unit: &str, means: &[BlockMean]) -> Self {
        let errors = means.iter().map(|mean| mean.standard_error).collect();
        let mut table = self.value(name, unit, means.iter().map(|mean| mean.value).collect());
        if let Some(column) = table.columns.last_mut() {
            column.quantities = means.iter().map(|mean| mean.quantity).collect();
        }
        table.errors(errors)
    }

    /// Adds the standard errors of the quantity before.
    #[must_use]
    pub fn errors(self, values: Vec<Option<f64>>) -> Self {
        let (name, unit) = self.measured("error");
        self.column(&name, &name, &unit, Role::StandardError, values)
    }

    /// Adds the prediction of the quantity before, with its name in the legend and its source.
    #[must_use]
    pub fn prediction(self, label: &str, values: Vec<Option<f64>>, source: &str) -> Self {
        let (name, unit) = self.measured("predicted");
        let role = Role::Prediction {
            source: source.to_owned(),
        };
        self.column(&name, label, &unit, role, values)
    }

    /// The grid of a table with two abscissae, whose values are drawn as maps; `None` if it has one
    /// abscissa, or if its rows are not those of a full grid.
    ///
    /// ```
    /// use carom_tables::Table;
    ///
    /// let table = Table::new("t", "T")
    ///     .abscissa("x", "length", vec![0.5, 1.5, 0.5, 1.5, 0.5, 1.5])
    ///     .abscissa("y", "length", vec![1.0, 1.0, 3.0, 3.0, 5.0, 5.0]);
    /// let grid = table.grid().expect("two abscissae");
    /// assert_eq!((grid.counts, grid.sides), ([2, 3], [2.0, 6.0]));
    /// ```
    pub fn grid(&self) -> Option<TableGrid> {
        let mut abscissae = self
            .columns
            .iter()
            .filter(|column| column.role == Role::Abscissa);
        let places = |column: &Column| column.values.iter().copied().collect::<Option<Vec<f64>>>();
        let (x, y) = (places(abscissae.next()?)?, places(abscissae.next()?)?);
        let columns = y
            .iter()
            .take_while(|&place| Some(place) == y.first())
            .count();
        let is_full = columns > 0 && x.len() == y.len() && x.len().is_multiple_of(columns);
        let counts = [columns, x.len().checked_div(columns)?];
        let side = |places: &[f64], count: usize| {
            let (first, last) = (places.first()?, places.last()?);
            Some(if count > 1 {
                (last - first) * count as f64 / (count - 1) as f64
            } else {
                first + last
            })
        };
        Some(TableGrid {
            counts,
            sides: [side(&x, counts[0])?, side(&y, counts[1])?],
        })
        .filter(|grid| is_full && grid.sides.iter().all(|side| *side > 0.0))
    }

    /// The columns of the file, without the [derived](Role::Derived) ones.
    pub fn in_file(&self) -> impl Iterator<Item = &Column> {
        self.columns
            .iter()
            .filter(|column| column.role != Role::Derived)
    }

    /// Names of the columns of the file.
    pub fn header(&self) -> Vec<&str> {
        self.in_file().map(|column| column.name.as_str()).collect()
    }

    /// The rows of the file.
    pub fn rows(&self) -> Vec<Vec<Option<f64>>> {
        let count = self
            .columns
            .iter()
            .map(|column| column.values.len())
            .max()
            .unwrap_or(0);
        let cell = |column: &Column, row: usize| column.values.get(row).copied().flatten();
        (0..count)
            .map(|row| self.in_file().map(|column| cell(column, row)).collect())
            .collect()
    }

    /// Name and unit of a column that belongs to the last measured quantity.
    fn measured(&self, suffix: &str) -> (String, String) {
        let value = self
            .columns
            .iter()
            .rev()
            .find(|column| column.role == Role::Value);
        value.map_or_else(
            || (suffix.to_owned(), "1".to_owned()),
            |value| (format!("{}_{suffix}", value.name), value.unit.clone()),
        )
    }

    fn column(
        mut self,
        name: &str,
        label: &str,
        unit: &str,
        role: Role,
        values: Vec<Option<f64>>,
    ) -> Self {
        let (name, label, unit) = (name.to_owned(), label.to_owned(), unit.to_owned());
        // A number that is not finite is no result.
        let values = values
            .into_iter()
            .map(|value| value.filter(|value| value.is_finite()))
            .collect();
        self.columns.push(Column {
            name,
            label,
            unit,
            role,
            values,
            quantities: Vec::new(),
        });
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_without_a_finite_number_are_empty() {
        let table = Table::new("t", "T")
            .abscissa("x", "1", vec![0.0, 1.0, 2.0])
            .counts("events", vec![3, 4, 5])
            .value("y", "length", vec![Some(1.0), Some(f64::NAN)]);
        let rows = table.rows();
        assert_eq!(rows[1], [Some(1.0), Some(4.0), None]);
        assert_eq!(rows[2], [Some(2.0), Some(5.0), None]);
        assert_eq!(table.columns[2].unit, "length");
    }

    #[test]
    fn what_is_drawn_is_relative_and_resolved() {
        let some = |values: [f64; 3]| values.map(Some).to_vec();
        let table = Table::new("t", "T")
            .abscissa("lag", "time", vec![0.0, 1.0, 2.0])
            .value(
                "velocity_autocorrelation",
                "length²/time²",
                some([4.0, 2.0, 0.1]),
            )
            .errors(some([0.2, 0.1, 0.3]))
            .prediction("theory", some([4.0, 1.0, 0.4]), "S")
            .value("other", "1", some([0.1, 0.2, 0.3]))
            .errors(some([1.0; 3]))
            .relative_to_first(&["velocity_autocorrelation"]);
        let drawn = table.as_drawn();
        assert_eq!(drawn.columns[1].values, [Some(1.0), Some(0.5), None]);
        assert_eq!(
            drawn.columns[2].values,
            [Some(0.05), Some(0.025), Some(0.075)]
        );
        assert_eq!(drawn.columns[3].values, some([1.0, 0.25, 0.1]));
        assert_eq!(
            (drawn.columns[1].unit.as_str(), &drawn.columns[4]),
            ("1", &table.columns[4])
        );
        assert_eq!(table.columns[1].values, some([4.0, 2.0, 0.1]));
    }

    #[test]
    fn derived_columns_and_levels_are_not_in_the_file() {
        let table = Table::new("t", "T")
            .abscissa("x", "1", vec![0.0])
            .undrawn("total", "1", vec![5.0])
            .value("y", "length", vec![Some(1.0)])
            .labelled("height")
            .level("theory", Some(1.5), "definition")
            .level("no theory", None, "")
            .derived("y over total", "length", vec![Some(0.2)]);
        assert_eq!(table.header(), ["x", "total", "y"]);
        assert_eq!(table.rows(), [[Some(0.0), Some(5.0), Some(1.0)]]);
        assert_eq!(
            (table.levels.len(), table.levels[0].column.as_str()),
            (1, "y")
        );
        assert_eq!(table.columns[2].label, "height");
    }
}
