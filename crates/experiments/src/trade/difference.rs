//! A measured figure with another setting beside that of the exact run.

use serde::Serialize;

/// A measure of a setting beside that of the exact run, in `summary.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// Name of the figure.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its value with this setting.
    pub value: f64,
    /// Its value in the exact run.
    pub exact: f64,
    /// The difference.
    pub difference: f64,
    /// Standard error of the difference; `None` if one of the two has none.
    pub standard_error: Option<f64>,
}

impl Difference {
    /// The difference in standard errors; `None` without an error.
    pub fn in_errors(&self) -> Option<f64> {
        let error = self.standard_error.filter(|error| *error > 0.0)?;
        Some(self.difference.abs() / error)
    }

    /// The difference and its error relative to the exact value, in per cent; `None` where that is
    /// 0 or less than two of its errors.
    pub fn percent(&self) -> Option<[f64; 2]> {
        let scale = self.exact.abs();
        let error = self.standard_error.unwrap_or(0.0);
        (scale > 2.0 * error && scale > 0.0)
            .then(|| [100.0 * self.difference / scale, 100.0 * error / scale])
    }
}
