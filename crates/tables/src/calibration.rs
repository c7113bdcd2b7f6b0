//! Are standard errors as large as the scatter of replicas?
//!
//! Of n replicas with values xᵢ and standard errors eᵢ, r = √(⟨e²⟩ / s²) with s² = Σ (x − ⟨x⟩)² /
//! (n − 1). If the errors are right and the values Gaussian, (n − 1) / r² is distributed as χ² with
//! n − 1 degrees of freedom; the scatter of the errors themselves is neglected.

use serde::Serialize;

use crate::{averages::median, chi_square::ChiSquare};

/// Least number of replicas. Fewer: errors wrong by a factor 1.5 pass.
pub const MIN_REPLICAS: usize = 30;

/// Probability with which right errors are flagged.
pub const FLAGGED: f64 = 1e-3;

/// A row is tested if this share of the replicas gives it an error above 0. Less: the quantity is a
/// rare event, such as a count in the tail of a histogram, and not Gaussian.
const TESTED_SHARE: f64 = 0.99;

/// A scatter below this share of the value is rounding.
const ROUNDING: f64 = 1e-12;

/// Value and standard error of one quantity in one replica.
pub type MeasuredMean = (f64, Option<f64>);

/// Whether standard errors agree with the scatter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Calibrated {
    /// They agree.
    Fine,
    /// They do not.
    Flagged,
    /// All errors are 0, and the values are equal to rounding.
    Exact,
}

impl Calibrated {
    /// The word for a table.
    pub fn word(self) -> &'static str {
        match self {
            Self::Fine => "fine",
            Self::Flagged => "FLAGGED",
            Self::Exact => "exact",
        }
    }
}

/// The ratio of standard errors to the scatter of replicas, over the rows of a table; a figure has
/// one row.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Calibration {
    /// Name of the figure, or of the table and its column.
    pub name: String,
    /// Number of replicas.
    pub replicas: usize,
    /// Number of rows that are tested.
    pub rows: usize,
    /// Number of rows that are too rare to be tested.
    pub rare: usize,
    /// Median of the ratio over the rows; 1 if all rows are exact.
    pub ratio: f64,
    /// Least ratio of a row.
    pub least: f64,
    /// Largest ratio of a row.
    pub most: f64,
    /// The band of the median: outside with a probability of [`FLAGGED`] by chance.
    pub band: [f64; 2],
    /// Whether the errors agree.
    pub result: Calibrated,
}

impl Calibration {
    /// Compares errors with the scatter. Each row has its values in all replicas. It is flagged if
    /// the median lies outside its band, or an extreme outside the band of as many independent
    /// rows. `None` if no row can be tested.
    ///
    /// ```
    /// use carom_tables::calibration::{Calibrated, Calibration};
    ///
    /// // Values 0, 1, …, 39 have the scatter √(40 · 41 / 12) = 11.7.
    /// let row = |error: f64| (0..40).map(|x| (f64::from(x), Some(error))).collect();
    /// let of = |error: f64| Calibration::new("x", &[row(error)]).expect("40 replicas").result;
    /// assert_eq!((of(11.0), of(5.0), of(20.0)), (Calibrated::Fine, Calibrated::Flagged, Calibrated::Flagged));
    /// ```
    pub fn new(name: &str, rows: &[Vec<MeasuredMean>]) -> Option<Self> {
        let replicas = rows.iter().map(Vec::len).max()?;
        let tested = rows
            .iter()
            .filter(|row| row.len() == replicas && replicas >= MIN_REPLICAS);
        let found: Vec<Option<Ratio>> = tested.map(|row| ratio(row)).collect();
        let rare = found.iter().filter(|ratio| ratio.is_none()).count();
        let mut ratios: Vec<f64> = found
            .iter()
            .filter_map(|found| found.and_then(Ratio::measured))
            .collect();
        let exact = found
            .iter()
            .filter(|found| matches!(found, Some(Ratio::Exact)))
            .count();
        let count = ratios.len();
        if count == 0 {
            let (rows, band, result) = (exact, band(replicas, FLAGGED), Calibrated::Exact);
            let (name, ratio, least, most) = (name.to_owned(), 1.0, 1.0, 1.0);
            return (exact > 0).then_some(Self {
                name,
                replicas,
                rows,
                rare,
                ratio,
                least,
                most,
                band,
                result,
            });
        }
        let ratio = median(&mut ratios)?;
        let (least, most) = (ratios[0], ratios[count - 1]);
        let (of_one, of_all) = (
            band(replicas, FLAGGED),
            band(replicas, FLAGGED / count as f64),
        );
        let is_in = |ratio: f64, [from, to]: [f64; 2]| from <= ratio && ratio <= to;
        let is_fine = is_in(ratio, of_one) && is_in(least, of_all) && is_in(most, of_all);
        let result = if is_fine {
            Calibrated::Fine
        } else {
            Calibrated::Flagged
        };
        let (name, rows) = (name.to_owned(), count + exact);
        Some(Self {
            name,
            replicas,
            rows,
            rare,
            ratio,
            least,
            most,
            band: of_one,
            result,
        })
    }
}

/// What the replicas tell about a row.
#[derive(Debug, Clone, Copy)]
enum Ratio {
    Measured(f64),
    Exact,
}

impl Ratio {
    fn measured(self) -> Option<f64> {
        match self {
            Self::Measured(ratio) => Some(ratio),
            Self::Exact => None,
        }
    }
}

/// The ratio of one row; `None` if too few replicas have an error.
fn ratio(row: &[MeasuredMean]) -> Option<Ratio> {
    let with_error: Vec<(f64, f64)> = row
        .iter()
        .filter_map(|&(x, error)| Some((x, error?)))
        .collect();
    let count = with_error.len() as f64;
    let requested = TESTED_SHARE * row.len() as f64;
    if count < requested {
        return None;
    }
    let mean = with_error.iter().map(|(x, _)| x).sum::<f64>() / count;
    let variance = with_error
        .iter()
        .map(|(x, _)| (x - mean).powi(2))
        .sum::<f64>()
        / (count - 1.0);
    let square = with_error
        .iter()
        .map(|(_, error)| error * error)
        .sum::<f64>()
        / count;
    if square == 0.0 && variance.sqrt() <= ROUNDING * mean.abs() {
        // A bin that is always empty says nothing.
        return (mean != 0.0).then_some(Ratio::Exact);
    }
    let positive = with_error.iter().filter(|(_, error)| *error > 0.0).count() as f64;
    (positive >= requested && variance > 0.0).then(|| Ratio::Measured((square / variance).sqrt()))
}

/// The band in which the ratio of right errors lies, except with this probability: by χ², half of
/// it on each side.
pub fn band(replicas: usize, probability: f64) -> [f64; 2] {
    let freedom = replicas.saturating_sub(1).max(1);
    let above = |ratio: f64| {
        let value = freedom as f64 / (ratio * ratio);
        ChiSquare { value, freedom }.p_value()
    };
    // The probability of a larger χ² grows with the ratio: bisection of its logarithm.
    let at = |requested: f64| {
        let (mut low, mut high) = (1e-3f64.ln(), 1e3f64.ln());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if above(middle.exp()) < requested {
                low = middle;
            } else {
                high = middle;
            }
        }
        low.exp()
    };
    [at(0.5 * probability), at(1.0 - 0.5 * probability)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_is_that_of_chi_square() {
        // χ² of 47 degrees of freedom has the quantiles 20.18 and 84.13 at 0.0002 and 0.99935
        // (Wilson and Hilferty); the band of the ratio is √(47/χ²).
        let k = 47.0f64;
        let quantile = |z: f64| k * (1.0 - 2.0 / (9.0 * k) + z * (2.0 / (9.0 * k)).sqrt()).powi(3);
        // 3.2905 standard deviations: a probability of 5·10⁻⁴ on each side.
        let [from, to] = band(48, 1e-3);
        assert!(
            (from / (k / quantile(3.2905)).sqrt() - 1.0).abs() < 2e-3,
            "{from}"
        );
        assert!(
            (to / (k / quantile(-3.2905)).sqrt() - 1.0).abs() < 2e-3,
            "{to}"
        );
    }

    #[test]
    fn rows_are_summarised_and_rare_or_exact_ones_are_counted() {
        let value = |replica: usize, row: usize| ((replica * 7919 + row * 31) % 101) as f64;
        let scatter = 101.0 / 12f64.sqrt();
        let row = |index: usize, error: f64| -> Vec<MeasuredMean> {
            (0..101)
                .map(|replica| (value(replica, index), Some(error)))
                .collect()
        };
        let mut rows: Vec<Vec<MeasuredMean>> = (0..5).map(|index| row(index, scatter)).collect();
        rows.push(
            (0..101)
                .map(|replica| (value(replica, 0), (replica > 50).then_some(1.0)))
                .collect(),
        );
        rows.push(vec![(2.0, Some(0.0)); 101]);
        let found = Calibration::new("x", &rows).unwrap();
        assert_eq!(
            (found.rows, found.rare, found.result),
            (6, 1, Calibrated::Fine)
        );
        assert!((found.ratio - 1.0).abs() < 0.02);
        // One row with errors three times too large is found.
        rows[2] = row(2, 3.0 * scatter);
        assert_eq!(
            Calibration::new("x", &rows).unwrap().result,
            Calibrated::Flagged
        );
        assert_eq!(
            Calibration::new("x", &[vec![(2.0, Some(0.0)); 50]])
                .unwrap()
                .result,
            Calibrated::Exact
        );
        assert_eq!(
            Calibration::new("x", &[row(0, scatter)[..29].to_vec()]),
            None
        );
    }
}
