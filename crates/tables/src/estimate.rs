//! Means with standard errors from sums over blocks: R = Σx / Σw, and the scatter of the blocks.
//!
//! With n blocks and d = x − R w, se² = n/(n − 1) Σ dᵢ² / (Σw)² (ratio estimator; Cochran 1977,
//! "Sampling Techniques", chapter 6). It holds for independent blocks. With the covariance of
//! neighbouring blocks, Σ dᵢ² + 2 Σ dᵢ dᵢ₊₁ takes the place of Σ dᵢ²; it then holds if the
//! correlation time is not longer than a block.

use serde::{Deserialize, Serialize};

/// The correlation of neighbouring blocks changes the square of an error by at least this factor.
/// Smaller: by chance, errors of few blocks are near 0. Larger: the mean error is too large.
const LEAST_FACTOR: f64 = 0.25;

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
    fn of(blocks: &[[f64; 2]]) -> Option<Self> {
        let sum: f64 = blocks.iter().map(|block| block[0]).sum();
        let weight: f64 = blocks.iter().map(|block| block[1]).sum();
        (weight > 0.0 && weight.is_finite()).then_some(())?;
        let ratio = sum / weight;
        let values: Vec<f64> = blocks.iter().map(|[x, w]| x - ratio * w).collect();
        let squares = values.iter().map(|d| d * d).sum();
        Some(Self { ratio, weight, squares, values })
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
        let Deviations { ratio, weight, squares, .. } = Deviations::of(&blocks)?;
        Some(Self { mean: ratio, standard_error: (squares * count / (count - 1.0)).sqrt() / weight })
    }

    /// The estimate from [x, w] of the blocks of each run, in the order of time. Neighbouring
    /// blocks of a run may be correlated; runs are independent. Blocks without weight do not count
    /// as such.
    ///
    /// `None` with fewer than two blocks of weight.
    ///
    /// ```
    /// use carom_tables::Estimate;
    ///
    /// let run = vec![[9.0, 2.0], [11.0, 2.0], [10.0, 2.0], [10.0, 2.0]];
    /// let rate = Estimate::of_runs(&[run]).expect("four blocks");
    /// // d = −1, 1, 0, 0: Σd² = 2, and neighbours contribute 2 (−1 + 2/4) = −1.
    /// assert!((rate.standard_error - (1.0f64 * 4.0 / 3.0).sqrt() / 8.0).abs() < 1e-15);
    /// ```
    pub fn of_runs(runs: &[Vec<[f64; 2]>]) -> Option<Self> {
        let blocks: Vec<[f64; 2]> = runs.concat();
        let count = blocks.iter().filter(|[_, weight]| *weight > 0.0).count() as f64;
        if count < 2.0 {
            return None;
        }
        let Deviations { ratio, weight, squares, values } = Deviations::of(&blocks)?;
        let (mut products, mut begin) = (0.0, 0);
        for run in runs {
            let of_run = &values[begin..begin + run.len()];
            products += of_run.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
            begin += run.len();
        }
        let with_weight = |run: &&Vec<[f64; 2]>| run.iter().any(|[_, weight]| *weight > 0.0);
        let pairs = count - runs.iter().filter(with_weight).count() as f64;
        // The deviations sum to 0, so that the product of two of n independent blocks has the mean
        // −Σd²/n (n − 1).
        let bias = squares * (pairs / (count - 1.0)) / count;
        let correlated = squares + 2.0 * (products + bias);
        let squares = correlated.max(LEAST_FACTOR * squares);
        Some(Self { mean: ratio, standard_error: (squares * count / (count - 1.0)).sqrt() / weight })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_proportional_to_their_weights_have_no_error() {
        let estimate = Estimate::of_ratio([(3.0, 1.0), (6.0, 2.0), (1.5, 0.5)]).unwrap();
        assert_eq!(estimate, Estimate { mean: 3.0, standard_error: 0.0 });
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
    fn blocks_of_different_runs_are_independent() {
        // One block a run: no neighbours, and the estimate is that of independent blocks.
        let runs: Vec<Vec<[f64; 2]>> = [9.0, 10.0, 12.0].map(|x| vec![[x, 2.0]]).to_vec();
        let plain = Estimate::of_ratio([(9.0, 2.0), (10.0, 2.0), (12.0, 2.0)]).unwrap();
        let found = Estimate::of_runs(&runs).unwrap();
        assert!((found.standard_error - plain.standard_error).abs() < 1e-15);
    }
}
