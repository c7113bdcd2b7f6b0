//! Pearson's χ² test: the deviation of counts from expected values, and its p-value.

/// Pearson's χ² of counts, with its degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChiSquare {
    /// Σ (count − expected)² / expected.
    pub value: f64,
    /// Number of bins less one, because the total is fixed.
    pub freedom: usize,
}

impl ChiSquare {
    /// Compares counts with the expected share of each bin; bins of share 0 are omitted.
    pub fn new(counts: &[u64], shares: &[f64]) -> Self {
        let total: u64 = counts.iter().sum();
        let bins = || counts.iter().zip(shares).filter(|(_, share)| **share > 0.0);
        let term = |(&count, &share): (&u64, &f64)| {
            let expected = total as f64 * share;
            (count as f64 - expected).powi(2) / expected
        };
        Self {
            value: bins().map(term).sum(),
            freedom: bins().count().saturating_sub(1),
        }
    }

    /// Returns the p-value, the probability of a χ² at least as large by chance: Q(k/2, χ²/2); 1
    /// without a degree of freedom.
    pub fn p_value(&self) -> f64 {
        if self.freedom == 0 {
            1.0
        } else {
            upper_gamma(0.5 * self.freedom as f64, 0.5 * self.value)
        }
    }
}

/// Largest number of terms. Both sums converge within some √a terms near x = a, and faster
/// elsewhere: enough for 10⁸ bins.
const MAX_TERMS: u32 = 100_000;

/// The regularised incomplete gamma function Q(a, x) = Γ(a, x) / Γ(a), for a > 0; NaN for x < 0 or
/// NaN.
///
/// Uses the series of P = 1 − Q for x < a + 1, otherwise its continued fraction (Press et al.,
/// Numerical Recipes, section 6.2), evaluated by Lentz's method.
fn upper_gamma(a: f64, x: f64) -> f64 {
    if x.is_nan() || x < 0.0 {
        return f64::NAN;
    }
    if x == 0.0 {
        return 1.0;
    }
    let scale = (a * x.ln() - x - libm::lgamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for index in 1..MAX_TERMS {
            term *= x / (a + f64::from(index));
            sum += term;
            if term < sum * f64::EPSILON {
                break;
            }
        }
        return (1.0 - scale * sum).clamp(0.0, 1.0);
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (f64::MAX, 1.0 / b);
    let mut fraction = d;
    for index in 1..MAX_TERMS {
        let i = f64::from(index);
        let numerator = -i * (i - a);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        fraction *= c * d;
        if (c * d - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    (scale * fraction).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64) {
        assert!(
            (found - expected).abs() < 1e-12 * expected.max(1e-3),
            "found {found}, expected {expected}"
        );
    }

    /// Two degrees: exp(−χ²/2). Four: that times 1 + χ²/2. One: erfc √(χ²/2).
    #[test]
    fn probabilities_agree_with_closed_forms() {
        for value in [0.1, 1.0, 3.0, 10.0, 40.0] {
            let half = 0.5 * value;
            close(ChiSquare { value, freedom: 2 }.p_value(), f64::exp(-half));
            close(
                ChiSquare { value, freedom: 4 }.p_value(),
                f64::exp(-half) * (1.0 + half),
            );
            close(
                ChiSquare { value, freedom: 1 }.p_value(),
                libm::erfc(f64::sqrt(half)),
            );
        }
        assert_eq!(
            ChiSquare {
                value: 0.0,
                freedom: 3
            }
            .p_value(),
            1.0
        );
        assert!(
            ChiSquare {
                value: f64::NAN,
                freedom: 3
            }
            .p_value()
            .is_nan()
        );
    }

    /// For 359 degrees of freedom the cube root of χ²/k is nearly Gaussian with variance 2/9k
    /// (Wilson and Hilferty, PNAS 17 (1931) 684).
    #[test]
    fn many_degrees_of_freedom_approach_a_gaussian() {
        let k = 359.0f64;
        for sigma in [-3.0, 0.0, 2.0, 4.0f64] {
            let value = k * (1.0 - 2.0 / (9.0 * k) + sigma * (2.0 / (9.0 * k)).sqrt()).powi(3);
            let gaussian = 0.5 * libm::erfc(sigma / 2f64.sqrt());
            let found = ChiSquare {
                value,
                freedom: 359,
            }
            .p_value();
            // The approximation has an error of 1 % at four standard deviations.
            assert!(
                (found / gaussian - 1.0).abs() < 0.02,
                "{sigma}: {found}, {gaussian}"
            );
        }
    }

    #[test]
    fn the_statistic_is_that_of_pearson() {
        let found = ChiSquare::new(&[10, 20, 30, 7], &[0.25, 0.25, 0.5, 0.0]);
        // The total is 67; expected are 16.75, 16.75 and 33.5.
        close(
            found.value,
            (6.75f64.powi(2) + 3.25f64.powi(2)) / 16.75 + 3.5f64.powi(2) / 33.5,
        );
        assert_eq!(found.freedom, 2);
    }
}
