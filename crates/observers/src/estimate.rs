//! Mean and standard error from blocks: R = Σx / Σw, and the scatter of the blocks.
//!
//! With n blocks, se² = n/(n − 1) Σ (xᵢ − R wᵢ)² / (Σw)² (ratio estimator; Cochran 1977, "Sampling
//! Techniques", chapter 6). Blocks must be longer than the correlation time of x; the error is then
//! valid for any correlation inside a block.

use serde::{Deserialize, Serialize};

/// A mean with its standard error (unit of x / w).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl Estimate {
    /// The estimate from (x, w) of each block; w is the duration of the block for a rate, its
    /// number of contacts for a share.
    ///
    /// `None` with fewer than two blocks, or if the sum of the weights is not positive and finite.
    ///
    /// ```
    /// use carom_observers::Estimate;
    ///
    /// // 9, 10 and 11 contacts in three blocks of two units of time.
    /// let rate = Estimate::of_ratio([(9.0, 2.0), (10.0, 2.0), (11.0, 2.0)]).expect("three blocks");
    /// assert_eq!(rate.mean, 5.0);
    /// // s = 1 contact, so the mean of three has the error of 1/√3 contacts in two units of time.
    /// assert!((rate.standard_error - 0.5 / 3f64.sqrt()).abs() < 1e-15);
    /// ```
    pub fn of_ratio(blocks: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let blocks: Vec<(f64, f64)> = blocks.into_iter().collect();
        let count = blocks.len() as f64;
        let sum: f64 = blocks.iter().map(|block| block.0).sum();
        let weight: f64 = blocks.iter().map(|block| block.1).sum();
        if blocks.len() < 2 || !(weight > 0.0 && weight.is_finite()) {
            return None;
        }
        let mean = sum / weight;
        let squares: f64 = blocks.iter().map(|(x, w)| (x - mean * w) * (x - mean * w)).sum();
        Some(Self { mean, standard_error: (squares * count / (count - 1.0)).sqrt() / weight })
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
    }
}
