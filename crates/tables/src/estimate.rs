//! Means with standard errors from sums over blocks: R = Σx / Σw, and the scatter of the blocks.
//!
//! With n independent blocks and d = x − R w, se² = n/(n − 1) Σ dᵢ² / (Σw)² (ratio estimator;
//! Cochran 1977, "Sampling Techniques", chapter 6). The error of the blocks of runs uses the
//! [spectral density](crate::spectrum) of d at frequency 0 instead of the variance, and so counts
//! correlations of blocks, of either sign.

use serde::{Deserialize, Serialize};

use crate::spectrum::Spectrum;

/// Deviations of all blocks below this share of Σ|x| are rounding: the quantity is conserved, and
/// its error is 0. Smaller: the rounding of sums of 10⁷ samples looks like a measured scatter.
const ROUNDING: f64 = 1e-14;

/// A mean with its standard error (unit of x / w).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// Sums over blocks of their deviations from the mean ratio.
struct Deviations {
    ratio: f64,
    weight: f64,
    squares: f64,
    values: Vec<f64>,
}

impl Deviations {
    /// `None` if the sum of the weights is not positive and finite.
    fn new(blocks: &[[f64; 2]]) -> Option<Self> {
        let sum: f64 = blocks.iter().map(|block| block[0]).sum();
        let weight: f64 = blocks.iter().map(|block| block[1]).sum();
        (weight > 0.0 && weight.is_finite()).then_some(())?;
        let ratio = sum / weight;
        let values: Vec<f64> = blocks.iter().map(|[x, w]| x - ratio * w).collect();
        let squares = values.iter().map(|d| d * d).sum();
        Some(Self {
            ratio,
            weight,
            squares,
            values,
        })
    }
}

impl Estimate {
    /// The estimate from (x, w) of each block; w is the duration of the block for a rate, its
    /// number of contacts for a share. Blocks count as independent.
    ///
    /// `None` with fewer than two blocks, or if the sum of the weights is not positive and finite.
    ///
    /// ```
    /// use carom_tables::Estimate;
    ///
    /// // 9, 10 and 11 contacts in three blocks of two units of time.
    /// let rate = Estimate::of_ratio([(9.0, 2.0), (10.0, 2.0), (11.0, 2.0)]).expect("three blocks");
    /// assert_eq!(rate.mean, 5.0);
    /// // s = 1 contact, so the mean of three has the error of 1/√3 contacts in two units of time.
    /// assert!((rate.standard_error - 0.5 / 3f64.sqrt()).abs() < 1e-15);
    /// ```
    pub fn of_ratio(blocks: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let blocks: Vec<[f64; 2]> = blocks.into_iter().map(|(x, w)| [x, w]).collect();
        let count = blocks.len() as f64;
        if blocks.len() < 2 {
            return None;
        }
        let Deviations {
            ratio,
            weight,
            squares,
            ..
        } = Deviations::new(&blocks)?;
        Some(Self {
            mean: ratio,
            standard_error: (squares * count / (count - 1.0)).sqrt() / weight,
        })
    }

    /// The estimate from [x, w] of the blocks of each run, in the order of time. Blocks of a run
    /// may be correlated, from 16 blocks on; runs are independent. Blocks without weight are left
    /// out. The error is exactly 0 if the blocks differ by rounding only.
    ///
    /// `None` with fewer than two blocks of weight.
    ///
    /// ```
    /// use carom_tables::Estimate;
    ///
    /// let run = vec![[9.0, 2.0], [11.0, 2.0], [10.0, 2.0], [10.0, 2.0]];
    /// let rate = Estimate::of_runs(&[run]).expect("four blocks");
    /// // So few blocks count as independent: Σd² = 2.
    /// assert!((rate.standard_error - (2.0f64 * 4.0 / 3.0).sqrt() / 8.0).abs() < 1e-15);
    /// ```
    pub fn of_runs(runs: &[Vec<[f64; 2]>]) -> Option<Self> {
        let has_weight = |block: &&[f64; 2]| block[1] > 0.0;
        let runs: Vec<Vec<[f64; 2]>> = runs
            .iter()
            .map(|run| run.iter().filter(has_weight).copied().collect())
            .collect();
        let blocks: Vec<[f64; 2]> = runs.concat();
        if blocks.len() < 2 {
            return None;
        }
        let Deviations {
            ratio,
            weight,
            values,
            ..
        } = Deviations::new(&blocks)?;
        let total: f64 = blocks.iter().map(|[x, _]| x.abs()).sum();
        if values
            .iter()
            .all(|deviation| deviation.abs() <= ROUNDING * total)
        {
            return Some(Self {
                mean: ratio,
                standard_error: 0.0,
            });
        }
        let with_blocks = runs.iter().filter(|run| !run.is_empty()).count() as f64;
        let (mut spectrum, mut begin) = (Spectrum::default(), 0);
        for run in runs.iter().filter(|run| !run.is_empty()) {
            let of_run = &values[begin..begin + run.len()];
            spectrum.add(
                of_run,
                run.iter().map(|[_, weight]| weight).sum(),
                with_blocks,
            );
            begin += run.len();
        }
        let standard_error = (spectrum.at_zero() / weight).sqrt();
        // Sums near the largest number overflow when they are squared.
        standard_error.is_finite().then_some(Self {
            mean: ratio,
            standard_error,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_proportional_to_their_weights_have_no_error() {
        let estimate = Estimate::of_ratio([(3.0, 1.0), (6.0, 2.0), (1.5, 0.5)]).unwrap();
        assert_eq!(
            estimate,
            Estimate {
                mean: 3.0,
                standard_error: 0.0
            }
        );
    }

    #[test]
    fn too_few_blocks_give_none() {
        assert_eq!(Estimate::of_ratio([(3.0, 1.0)]), None);
        assert_eq!(Estimate::of_ratio([(0.0, 0.0), (0.0, 0.0)]), None);
        assert_eq!(Estimate::of_ratio([(1.0, f64::INFINITY), (1.0, 1.0)]), None);
        assert_eq!(Estimate::of_runs(&[vec![[3.0, 1.0]]]), None);
        assert_eq!(Estimate::of_runs(&[vec![[3.0, 1.0], [0.0, 0.0]]]), None);
    }

    #[test]
    fn sums_that_overflow_have_no_error() {
        let run: Vec<[f64; 2]> = (0..40)
            .map(|block| [1e300 * f64::from(block % 3), 1.5])
            .collect();
        assert_eq!(Estimate::of_runs(&[run]), None);
    }

    #[test]
    fn a_conserved_quantity_has_no_error() {
        let run: Vec<[f64; 2]> = (0..40)
            .map(|block| [3.0 + 1e-15 * f64::from(block % 3), 1.5])
            .collect();
        assert_eq!(Estimate::of_runs(&[run]).unwrap().standard_error, 0.0);
        let run: Vec<[f64; 2]> = (0..40)
            .map(|block| [3.0 + 1e-9 * f64::from(block % 3), 1.5])
            .collect();
        assert!(Estimate::of_runs(&[run]).unwrap().standard_error > 0.0);
    }

    #[test]
    fn blocks_of_different_runs_are_independent() {
        // One block a run: no neighbours, and the estimate is that of independent blocks.
        let runs: Vec<Vec<[f64; 2]>> = [9.0, 10.0, 12.0].map(|x| vec![[x, 2.0]]).to_vec();
        let plain = Estimate::of_ratio([(9.0, 2.0), (10.0, 2.0), (12.0, 2.0)]).unwrap();
        let found = Estimate::of_runs(&runs).unwrap();
        assert!((found.standard_error - plain.standard_error).abs() < 1e-15);
    }
}
