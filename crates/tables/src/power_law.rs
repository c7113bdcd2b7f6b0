//! Power-law fits: the exponent through given points, by least squares of the logarithms.

/// y = factor · x^exponent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerLaw {
    /// The exponent.
    pub exponent: f64,
    /// Its standard error from the scatter about the line; `None` with two points.
    pub error: Option<f64>,
    /// The factor.
    pub factor: f64,
}

impl PowerLaw {
    /// Fits points with positive coordinates; `None` with fewer than two different x.
    pub fn through(points: &[(f64, f64)]) -> Option<Self> {
        let logs: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (x.ln(), y.ln())).collect();
        let count = logs.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
        let (x, y) = (mean(|log| log.0), mean(|log| log.1));
        let spread: f64 = logs.iter().map(|log| (log.0 - x).powi(2)).sum();
        let exponent = logs
            .iter()
            .map(|log| (log.0 - x) * (log.1 - y))
            .sum::<f64>()
            / spread;
        let residual: f64 = logs
            .iter()
            .map(|log| (log.1 - y - exponent * (log.0 - x)).powi(2))
            .sum();
        let error = (logs.len() > 2).then(|| (residual / (count - 2.0) / spread).sqrt());
        exponent.is_finite().then(|| Self {
            exponent,
            error,
            factor: (y - exponent * x).exp(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exact_power_law_is_recovered_without_error() {
        let points: Vec<(f64, f64)> = [1.0, 2.0, 5.0, 40.0]
            .map(|x: f64| (x, 3.0 * x.powf(1.7)))
            .to_vec();
        let found = PowerLaw::through(&points).unwrap();
        assert!((found.exponent - 1.7).abs() < 1e-12 && (found.factor - 3.0).abs() < 1e-12);
        assert!(found.error.unwrap() < 1e-12);
        assert_eq!(PowerLaw::through(&points[..1]), None);
        assert_eq!(PowerLaw::through(&points[..2]).unwrap().error, None);
    }

    /// Logarithms 0, 1, 0 at 0, 1, 2: no slope, residual 2/3 over one degree of freedom, spread 2.
    #[test]
    fn the_error_is_that_of_linear_regression() {
        let e = std::f64::consts::E;
        let found = PowerLaw::through(&[(1.0, 1.0), (e, e), (e * e, 1.0)]).unwrap();
        assert!(found.exponent.abs() < 1e-15);
        assert!((found.error.unwrap() - (1.0f64 / 3.0).sqrt()).abs() < 1e-12);
    }
}
