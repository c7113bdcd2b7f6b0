//! Errors of each quantity over the scatter of the replicas.

use carom_runs::measures::Results;
use carom_tables::{Check, Figure, Role};

/// Columns whose errors are tested, with their tables and names in the results.
const CURVES: [(&str, &str, &str); 4] = [
    ("correlation", "mean_square_displacement", "mean squared displacement"),
    ("correlation", "velocity_autocorrelation", "velocity autocorrelation"),
    ("pair-distribution", "g", "g(r)"),
    ("directions-tracer", "share_of_contacts", "directions of impulses"),
];

/// Figures whose errors are tested.
const FIGURES: [&str; 2] = ["pressure", "collisions per body that moves"];

/// A row of a curve is tested if at least this share of the replicas gives it an error.
const SHARE: f64 = 0.99;

/// Fisher's F has a probability of 99 % within this many standard deviations of its logarithm.
const BAND: f64 = 2.576;

/// Blocks in which a run is divided, at least: the degrees of freedom of one error. The covariance
/// of neighbours makes its relative variance about three times as large.
const BLOCKS: f64 = 32.0 / 3.0;

/// The errors of one quantity in all replicas.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// Its name.
    pub name: String,
    /// Number of rows: of lags, distances or sectors.
    pub rows: usize,
    /// ⟨error²⟩ over the variance among the replicas, the mean over the rows.
    pub ratio: f64,
    /// The 99 % band of the ratio if the errors are right.
    pub band: [f64; 2],
}

/// Value and error of one quantity in one replica.
type Measured = (f64, Option<f64>);

/// Compares all quantities.
pub fn compare(replicas: &[Results]) -> Vec<Compared> {
    let figures = FIGURES.iter().map(|name| {
        let found = |results: &Results| {
            let figure = results.figures.iter().find(|figure| figure.name == *name)?;
            Some((figure.value, figure.standard_error))
        };
        (*name, vec![replicas.iter().filter_map(found).collect()])
    });
    let curves = CURVES.iter().map(|(table, column, name)| (*name, rows(replicas, table, column)));
    figures.chain(curves).filter_map(|(name, rows)| compared(name, &rows)).collect()
}

/// The values of each row of a column in all replicas.
fn rows(replicas: &[Results], table: &str, name: &str) -> Vec<Vec<Measured>> {
    let mut rows: Vec<Vec<Measured>> = Vec::new();
    for results in replicas {
        let Some(table) = results.tables.iter().find(|found| found.name == table) else { continue };
        let mut columns = table.columns.iter().skip_while(|column| column.name != name);
        let (Some(values), Some(errors)) = (columns.next(), columns.next()) else { continue };
        debug_assert_eq!(errors.role, Role::StandardError);
        rows.resize(values.values.len().max(rows.len()), Vec::new());
        for (row, (value, error)) in rows.iter_mut().zip(values.values.iter().zip(&errors.values)) {
            row.extend(value.map(|value| (value, *error)));
        }
    }
    rows
}

/// The mean ratio over the rows with enough errors.
fn compared(name: &str, rows: &[Vec<Measured>]) -> Option<Compared> {
    let ratio = |row: &Vec<Measured>| -> Option<(f64, f64)> {
        let with_error: Vec<(f64, f64)> = row.iter().filter_map(|(x, error)| Some((*x, (*error)?))).collect();
        let count = with_error.len() as f64;
        if count < 3.0 || count < SHARE * row.len() as f64 {
            return None;
        }
        let mean = with_error.iter().map(|(x, _)| x).sum::<f64>() / count;
        let variance = with_error.iter().map(|(x, _)| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let square = with_error.iter().map(|(_, error)| error * error).sum::<f64>() / count;
        // A quantity that conservation fixes, or a bin that is always empty, has no scatter.
        (variance > 1e-20 * mean * mean && variance > 0.0).then_some((square / variance, count))
    };
    let ratios: Vec<(f64, f64)> = rows.iter().filter_map(ratio).collect();
    let count = ratios.first()?.1;
    let mean = ratios.iter().map(|(ratio, _)| ratio).sum::<f64>() / ratios.len() as f64;
    // ln F of (n BLOCKS, n − 1) degrees of freedom has the variance 2/ν₁ + 2/ν₂. Rows of a curve
    // are correlated, and count as one.
    let width = BAND * (2.0 / (count * BLOCKS) + 2.0 / (count - 1.0)).sqrt();
    let band = [(-width).exp(), width.exp()];
    Some(Compared { name: name.to_owned(), rows: ratios.len(), ratio: mean, band })
}

impl Compared {
    /// The ratio as a figure.
    pub fn figure(&self) -> Figure {
        let name = format!("⟨error²⟩ over the variance of replicas: {}", self.name);
        Figure::new(name, self.ratio, "1").predicted(1.0, "errors that are right")
    }

    /// Checks that the ratio lies in its band: |ln ratio| over half the width.
    pub fn check(&self) -> Check {
        let name = format!("{} (share of the 99 % band)", self.name);
        Check::at_most(&name, self.ratio.ln().abs() / self.band[1].ln(), 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors that are right have a ratio in the band, errors half as large have not.
    #[test]
    fn wrong_errors_are_found() {
        let mut state = 0x9E37_79B9_u64;
        let mut uniform = || {
            // Marsaglia, J. Stat. Soft. 8 (2003) 14: xorshift.
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let values: Vec<f64> = (0..400).map(|_| uniform()).collect();
        let with = |error: f64| {
            let row: Vec<Measured> = values.iter().map(|&x| (5.0 + x, Some(error))).collect();
            compared("x", &[row]).unwrap()
        };
        let right = (1.0f64 / 12.0).sqrt();
        assert!(with(right).check().passed, "{:?}", with(right));
        assert!(!with(0.5 * right).check().passed);
        assert!(!with(1.3 * right).check().passed);
        let none = vec![(1.0, None); 400];
        assert_eq!(compared("x", &[none]), None);
    }
}
