//! Numbers in units that a reader chooses: a length σ, a mass m and an energy ε, and the time
//! τ = σ √(m/ε) that follows from them.

use crate::{Figure, Role, Table};

/// The units of a reader, in those of the scene.
///
/// ```
/// use carom_tables::{Figure, ReportUnits};
///
/// // Discs of diameter 0.01 and mass 1 at kT = 4: the unit of time is 0.005.
/// let units = ReportUnits { length: 0.01, mass: 1.0, energy: 4.0 };
/// let mut pressure = Figure::new("pressure", 80_000.0, "mass/time²").error(400.0);
/// units.apply_to_figure(&mut pressure);
/// assert_eq!((pressure.value, pressure.standard_error), (2.0, Some(0.01)));
/// assert_eq!(pressure.unit, "ε/σ²");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReportUnits {
    /// σ (length).
    pub length: f64,
    /// m (mass).
    pub mass: f64,
    /// ε (mass × length² / time²).
    pub energy: f64,
}

impl ReportUnits {
    /// τ = σ √(m/ε) (time).
    pub fn time(&self) -> f64 {
        self.length * (self.mass / self.energy).sqrt()
    }

    /// How a number with a unit such as `mass·length²/time²` changes, and the name of the unit with
    /// the symbols.
    fn change(&self, unit: &str) -> (Change, String) {
        let logarithm = unit.strip_prefix("ln(");
        if let Some(inner) = logarithm.and_then(|rest| rest.strip_suffix(')')) {
            let (size, name) = self.size(inner);
            return (Change::Less(size.ln()), format!("ln({name})"));
        }
        let (size, name) = self.size(unit);
        // Physicists know kT in ε and a pressure in ε/σ².
        let name = match name.as_str() {
            "m·σ²/τ²" => "ε",
            "m/τ²" => "ε/σ²",
            "m·σ²/τ³" => "ε/τ",
            other => other,
        };
        (Change::Over(size), name.to_owned())
    }

    /// The size of a unit, and its name with the symbols. `radian`, `impulses` and other words for
    /// what is counted are 1 and stay.
    fn size(&self, unit: &str) -> (f64, String) {
        let mut size = 1.0;
        let mut name = String::new();
        // What stands behind a stroke divides, alone or in parentheses.
        let (mut is_below, mut is_inside) = (false, false);
        let mut rest = unit;
        while let Some(first) = rest.chars().next() {
            let length = rest
                .find(|c: char| !c.is_alphabetic())
                .unwrap_or(rest.len());
            let (word, behind) = rest.split_at(length);
            if word.is_empty() {
                match first {
                    '/' => is_below = true,
                    '(' => is_inside = true,
                    ')' => (is_inside, is_below) = (false, false),
                    _ => (),
                }
                name.push(first);
                rest = &rest[first.len_utf8()..];
                continue;
            }
            let (power, marks) = superscript(behind);
            let (factor, symbol) = match word {
                "length" => (self.length, "σ"),
                "mass" => (self.mass, "m"),
                "time" => (self.time(), "τ"),
                "energy" => (self.energy, "ε"),
                other => (1.0, other),
            };
            size *= factor.powi(if is_below { -power } else { power });
            name.push_str(symbol);
            name.push_str(&behind[..marks]);
            is_below &= is_inside;
            rest = &behind[marks..];
        }
        (size, name)
    }

    /// Writes a figure in these units. The times of its [`Stationarity`](crate::Stationarity) stay
    /// in those of the scene, in which `run.measure_from` is given.
    pub fn apply_to_figure(&self, figure: &mut Figure) {
        let (change, name) = self.change(&figure.unit);
        figure.unit = name;
        figure.value = change.of_value(figure.value);
        figure.prediction = figure.prediction.map(|value| change.of_value(value));
        for difference in [&mut figure.standard_error, &mut figure.smallest_difference] {
            *difference = difference.map(|difference| change.of_difference(difference));
        }
        if let Some(found) = &mut figure.stationarity {
            found.change = change.of_difference(found.change);
            found.standard_error = change.of_difference(found.standard_error);
        }
    }

    /// Writes the columns and levels of a table in these units.
    pub fn apply_to_table(&self, table: &mut Table) {
        for level in &mut table.levels {
            let column = table
                .columns
                .iter()
                .find(|column| column.name == level.column);
            if let Some(column) = column {
                level.value = self.change(&column.unit).0.of_value(level.value);
            }
        }
        for column in &mut table.columns {
            let (change, name) = self.change(&column.unit);
            column.unit = name;
            let is_difference = matches!(column.role, Role::StandardError | Role::Width);
            for value in column.values.iter_mut().flatten() {
                *value = if is_difference {
                    change.of_difference(*value)
                } else {
                    change.of_value(*value)
                };
            }
        }
    }
}

/// How a number changes with its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Change {
    /// It is divided by the size of the unit.
    Over(f64),
    /// It is a logarithm, which is less by that of the size of the unit.
    Less(f64),
}

impl Change {
    fn of_value(self, value: f64) -> f64 {
        match self {
            Self::Over(size) => value / size,
            Self::Less(logarithm) => value - logarithm,
        }
    }

    /// The difference of two values.
    fn of_difference(self, difference: f64) -> f64 {
        match self {
            Self::Over(size) => difference / size,
            Self::Less(_) => difference,
        }
    }
}

/// The power at the start of a text, 1 if there is none, and the length of its marks (bytes).
fn superscript(text: &str) -> (i32, usize) {
    const MARKS: [char; 9] = ['¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let first = text.chars().next();
    let mark = first.and_then(|first| MARKS.iter().position(|&mark| mark == first));
    match (mark, first) {
        (Some(index), Some(first)) => (index as i32 + 1, first.len_utf8()),
        _ => (1, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stationarity;

    /// σ = 2, m = 3, ε = 48: τ = 1/2.
    const UNITS: ReportUnits = ReportUnits {
        length: 2.0,
        mass: 3.0,
        energy: 48.0,
    };

    #[test]
    fn sizes_follow_the_dimension_of_a_unit() {
        assert_eq!(UNITS.time(), 0.5);
        for (unit, size, name) in [
            ("1", 1.0, "1"),
            ("", 1.0, ""),
            ("length", 2.0, "σ"),
            ("1/length²", 0.25, "1/σ²"),
            ("energy/length²", 12.0, "ε/σ²"),
            ("mass·length²/time²", 48.0, "ε"),
            ("mass²·length⁶/time⁴", 9.0 * 64.0 * 16.0, "m²·σ⁶/τ⁴"),
            ("time/(mass·length)", 0.5 / 6.0, "τ/(m·σ)"),
            ("radian/time", 2.0, "radian/τ"),
            ("impulses", 1.0, "impulses"),
        ] {
            let expected = (Change::Over(size), name.to_owned());
            assert_eq!(UNITS.change(unit), expected, "{unit}");
        }
        let expected = (Change::Less(0.25f64.ln()), "ln(τ/σ)".to_owned());
        assert_eq!(UNITS.change("ln(time/length)"), expected);
    }

    #[test]
    fn all_numbers_of_a_figure_change_together() {
        let mut figure = Figure::new("D", 8.0, "length²/time")
            .error(0.8)
            .predicted(16.0, "Enskog");
        figure.stationarity = Some(Stationarity {
            is_stationary: false,
            change: 4.0,
            standard_error: 0.8,
            settled_at: Some(3.0),
            independent_blocks: 32.0,
            correlation_time: Some(0.25),
        });
        UNITS.apply_to_figure(&mut figure);
        let found = figure.stationarity.expect("it was judged");
        assert_eq!((figure.value, figure.unit.as_str()), (1.0, "σ²/τ"));
        assert_eq!(
            (figure.standard_error, figure.prediction),
            (Some(0.1), Some(2.0))
        );
        assert_eq!((found.change, found.standard_error), (0.5, 0.1));
        assert_eq!(found.settled_at, Some(3.0), "as run.measure_from");
    }

    #[test]
    fn a_table_keeps_its_shape() {
        let mut table = Table::new("fall", "Fall")
            .abscissa("time", "time", vec![1.0, 2.0])
            .value("distance", "length", vec![Some(4.0), None])
            .errors(vec![Some(0.5), None])
            .level("rest", Some(6.0), "Galilei");
        UNITS.apply_to_table(&mut table);
        let values: Vec<_> = table
            .columns
            .iter()
            .map(|column| column.values.clone())
            .collect();
        assert_eq!(values[0], [Some(2.0), Some(4.0)]);
        assert_eq!(values[1..], [vec![Some(2.0), None], vec![Some(0.25), None]]);
        assert_eq!(table.levels[0].value, 3.0);
        assert_eq!(table.columns[1].unit, "σ");
    }
}
