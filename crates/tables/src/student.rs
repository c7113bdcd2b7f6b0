//! Student's t: how far a mean of few independent values is from its expectation by chance.

/// Intervals of Simpson's rule over the tail. Fewer: the error exceeds 10⁻⁶. More: slower.
const INTERVALS: usize = 512;

/// Newton's steps, each of which doubles the number of digits near the root. Fewer: the quantiles
/// of one degree of freedom have not converged. More: no gain.
const MAX_STEPS: usize = 60;

/// Change of the coordinate at which the root is found. Smaller: below the error of the integral.
const PRECISION: f64 = 1e-9;

/// The distance in standard errors that a mean of `count` independent values exceeds as rarely as a
/// Gaussian one exceeds `gaussian` standard deviations, to a relative error of 10⁻⁵; infinite with
/// fewer than two values, or if the probability is below the smallest number (`gaussian` > 38).
///
/// With ν = `count` − 1 and t = √ν sinh s, the probability of a larger |t| is
/// ∫ₛ cosh⁻ᵛ u du / ∫₀ cosh⁻ᵛ u du, both up to infinity, from the density of t,
/// which is proportional to (1 + t²/ν)^(−(ν + 1)/2) (Student, Biometrika 6 (1908) 1).
///
/// ```
/// use carom_tables::student_quantile;
///
/// // The tables give 2.571 for five degrees of freedom and a probability of 0.05.
/// assert!((student_quantile(1.96, 6) - 2.571).abs() < 0.001);
/// assert!(student_quantile(4.0, 1000) < 4.05);
/// ```
pub fn student_quantile(gaussian: f64, count: usize) -> f64 {
    let probability = libm::erfc(gaussian / 2f64.sqrt());
    if count < 2 || probability == 0.0 {
        return f64::INFINITY;
    }
    let freedom = (count - 1) as f64;
    let requested = libm::log(probability * tail(freedom, 0.0));
    // The logarithm of a tail of this density is concave: Newton's steps from below go beyond the
    // root once, and then approach it from above.
    let mut from = 0.0;
    for _ in 0..MAX_STEPS {
        // Slope −1/∫ of the logarithm, with the integral in units of its integrand at `from`.
        let rest = tail(freedom, from);
        let step = rest * (libm::log(rest) - freedom * log_cosh(from) - requested);
        from += step;
        if step.abs() < PRECISION {
            break;
        }
    }
    freedom.sqrt() * libm::sinh(from)
}

/// ∫ (cosh s / cosh u)ᵛ du from `from` = s to infinity, by Simpson's rule.
fn tail(freedom: f64, from: f64) -> f64 {
    // cosh(s + x) ≥ cosh s cosh x, and the rest begins where coshᵛ x = e³⁷ = 10¹⁶.
    let step = libm::acosh(libm::exp(37.0 / freedom)) / INTERVALS as f64;
    let start = log_cosh(from);
    let weighted = |place: usize| {
        let weight = match place {
            0 | INTERVALS => 1.0,
            odd if odd % 2 == 1 => 4.0,
            _ => 2.0,
        };
        weight * libm::exp(-freedom * (log_cosh(from + step * place as f64) - start))
    };
    (0..=INTERVALS).map(weighted).sum::<f64>() * step / 3.0
}

/// ln cosh x, without overflow.
fn log_cosh(x: f64) -> f64 {
    x.abs() + libm::log1p(libm::exp(-2.0 * x.abs())) - std::f64::consts::LN_2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block_sums::tests::{Random, normal};

    /// The quantiles of one and two degrees of freedom are known in closed form: 1/tan(π p/2) and
    /// (1 − p) √(2/(p (2 − p))).
    #[test]
    fn quantiles_of_one_and_two_degrees_of_freedom_are_exact() {
        for gaussian in [0.1, 1.0, 2.0, 4.0, 6.0] {
            let p = libm::erfc(gaussian / 2f64.sqrt());
            let one = 1.0 / libm::tan(std::f64::consts::FRAC_PI_2 * p);
            let two = (1.0 - p) * (2.0 / (p * (2.0 - p))).sqrt();
            for (count, exact) in [(2, one), (3, two)] {
                let found = student_quantile(gaussian, count);
                assert!((found / exact - 1.0).abs() < 1e-5, "{gaussian}: {found}");
            }
        }
    }

    /// Two-sided quantiles of the tables, for the probabilities 0.05, 0.01 and 0.001.
    #[test]
    fn quantiles_agree_with_the_tables() {
        let gaussian = [1.959_964, 2.575_829, 3.290_527];
        for (freedom, tabled) in [
            (1, [12.706, 63.657, 636.619]),
            (2, [4.303, 9.925, 31.599]),
            (5, [2.571, 4.032, 6.869]),
            (10, [2.228, 3.169, 4.587]),
            (30, [2.042, 2.750, 3.646]),
        ] {
            for (sigma, tabled) in gaussian.into_iter().zip(tabled) {
                let found = student_quantile(sigma, freedom + 1);
                assert!((found / tabled - 1.0).abs() < 3e-4, "{freedom}: {found}");
            }
        }
        assert_eq!(student_quantile(0.0, 6), 0.0);
        assert!((student_quantile(20.0, 1_000_000) / 20.0 - 1.0).abs() < 2e-4);
        assert_eq!(
            [student_quantile(4.0, 1), student_quantile(40.0, 30)],
            [f64::INFINITY; 2]
        );
    }

    #[test]
    fn means_of_few_values_exceed_the_quantile_as_rarely_as_gaussian_ones() {
        let mut random = Random(0x9E37_79B9_7F4A_7C15);
        for count in [3, 6, 12] {
            // Chance exceeds 2.576 standard deviations once in 100.
            let most = student_quantile(2.576, count);
            let [mut beyond, mut beyond_gaussian] = [0; 2];
            for _ in 0..20_000 {
                let values: Vec<f64> = (0..count).map(|_| normal(&mut random)).collect();
                let mean = values.iter().sum::<f64>() / count as f64;
                let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
                let error = (squares / ((count - 1) * count) as f64).sqrt();
                beyond += u32::from(mean.abs() > most * error);
                beyond_gaussian += u32::from(mean.abs() > 2.576 * error);
            }
            // 200 are expected, with a standard deviation of 14.
            assert!((140..260).contains(&beyond), "{count}: {beyond}");
            assert!(beyond_gaussian > 300, "{count}: {beyond_gaussian}");
        }
    }
}
