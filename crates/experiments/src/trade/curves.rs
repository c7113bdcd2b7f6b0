//! Measured curves of a setting beside those of the exact run: by how many standard errors they
//! differ at most.

use carom_tables::{Column, Role, Table};
use serde::Serialize;

/// A measured curve with its standard errors.
#[derive(Debug, Clone, PartialEq)]
pub struct TradeCurve {
    /// Title of its table and name of the quantity.
    pub name: String,
    /// Abscissa, value, and standard error of each point that has all three.
    points: Vec<[f64; 3]>,
}

/// How a curve differs from that of the exact run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Deviation {
    /// Name of the curve.
    pub name: String,
    /// Number of points that both have.
    pub points: usize,
    /// The largest difference of a point, in standard errors of the difference.
    pub largest: f64,
}

/// The curves of a table that have errors.
pub fn of_table(table: &Table) -> Vec<TradeCurve> {
    let Some(abscissa) = table
        .columns
        .iter()
        .find(|column| column.role == Role::Abscissa)
    else {
        return Vec::new();
    };
    let pairs = table.columns.windows(2);
    let pairs =
        pairs.filter(|pair| pair[0].role == Role::Value && pair[1].role == Role::StandardError);
    let curve = |pair: &[Column]| {
        let rows = abscissa
            .values
            .iter()
            .zip(&pair[0].values)
            .zip(&pair[1].values);
        let points = rows.filter_map(|((x, value), error)| Some([(*x)?, (*value)?, (*error)?]));
        TradeCurve {
            name: format!("{}: {}", table.title, pair[0].label),
            points: points.collect(),
        }
    };
    pairs
        .map(curve)
        .filter(|curve| !curve.points.is_empty())
        .collect()
}

/// The deviations of curves from those of the exact run.
pub fn deviations(own: &[TradeCurve], exact: &[TradeCurve]) -> Vec<Deviation> {
    let deviation = |reference: &TradeCurve| {
        let own = own.iter().find(|curve| curve.name == reference.name)?;
        let pairs = own
            .points
            .iter()
            .zip(&reference.points)
            .filter(|(a, b)| a[0] == b[0]);
        let errors = pairs.map(|(a, b)| (a[1] - b[1]).abs() / a[2].hypot(b[2]));
        let errors: Vec<f64> = errors.filter(|error| error.is_finite()).collect();
        let largest = errors.iter().copied().fold(0.0, f64::max);
        (!errors.is_empty()).then(|| Deviation {
            name: reference.name.clone(),
            points: errors.len(),
            largest,
        })
    };
    exact.iter().filter_map(deviation).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_planted_deviation_is_found_at_equal_abscissas() {
        let curves = |values: [f64; 3]| {
            let table = Table::new("g", "g(r)")
                .abscissa("r", "length", vec![0.1, 0.2, 0.3])
                .value("g", "1", values.map(Some).to_vec())
                .errors(vec![Some(0.3), Some(0.3), None]);
            of_table(&table)
        };
        let (own, exact) = (curves([1.0, 2.0, 3.0]), curves([1.0, 1.0, 9.0]));
        let found = &deviations(&own, &exact)[0];
        assert_eq!((found.name.as_str(), found.points), ("g(r): g", 2));
        assert!((found.largest - 1.0 / 0.3f64.hypot(0.3)).abs() < 1e-12);
        assert_eq!(deviations(&exact, &exact)[0].largest, 0.0);
    }
}
