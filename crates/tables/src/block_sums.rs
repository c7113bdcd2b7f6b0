//! Means with standard errors from blocks of time, for any number of quantities at once.
//!
//! Each quantity is a ratio R = Σx / Σw of two sums that grow with time: w may be a number of
//! samples, of pairs, or a duration. The sums at the borders of blocks are kept; when there are 64
//! blocks, neighbours are joined (blocking; Flyvbjerg and Petersen, J. Chem. Phys. 91 (1989) 461).
//! With n blocks and d = x − R w, se² = n/(n − 1) (Σ dᵢ² + 2 Σ dᵢ dᵢ₊₁) / (Σw)²: the ratio
//! estimator (Cochran 1977, "Sampling Techniques", chapter 6) with the covariance of neighbouring
//! blocks. It holds if the correlation time is not longer than a block.

use serde::{Deserialize, Serialize};

/// The number of blocks at which pairs are joined. Smaller: the relative error of the standard
/// error exceeds 1/√(2 · 32) = 1/8. Larger: blocks of long runs are correlated.
const MOST: usize = 64;

/// The correlation of neighbouring blocks changes the square of an error by at least this factor.
/// Smaller: by chance, errors of few blocks are near 0. Larger: the mean error is too large.
const LEAST_FACTOR: f64 = 0.25;

/// Sums of several quantities at the borders of blocks.
///
/// ```
/// use carom_tables::BlockSums;
///
/// let mut blocks = BlockSums::default();
/// // 9, 11, 10 and 10 events in four blocks of two units of time.
/// for sums in [[9.0, 2.0], [20.0, 4.0], [30.0, 6.0], [40.0, 8.0]] {
///     blocks.record(&[sums]);
/// }
/// let rate = blocks.means()[0];
/// assert_eq!(rate.value, Some(5.0));
/// // d = −1, 1, 0, 0: Σd² = 2, and neighbours contribute 2 (−1 + 2/4) = −1.
/// assert!((rate.standard_error.unwrap() - (1.0f64 * 4.0 / 3.0).sqrt() / 8.0).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct BlockSums {
    /// Σx and Σw of each quantity at the end of each complete block.
    borders: Vec<Vec<[f64; 2]>>,
    /// The latest sums.
    last: Vec<[f64; 2]>,
    /// Log₂ of the number of records in a block.
    doublings: u32,
    /// Number of records in the open block.
    open: u64,
}

/// A mean with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BlockMean {
    /// The mean; `None` if it has no weight.
    pub value: Option<f64>,
    /// Its standard error; `None` with fewer than two blocks of weight.
    pub standard_error: Option<f64>,
}

impl BlockSums {
    /// Records the sums of all quantities up to now. Call it at equal intervals of time.
    pub fn record(&mut self, sums: &[[f64; 2]]) {
        self.last = sums.to_vec();
        self.open += 1;
        if self.open < self.records_per_block() {
            return;
        }
        self.open = 0;
        self.borders.push(self.last.clone());
        if self.borders.len() == MOST {
            let mut index = 0;
            self.borders.retain(|_| {
                index += 1;
                index % 2 == 0
            });
            self.doublings += 1;
        }
    }

    /// Number of records in a block.
    pub fn records_per_block(&self) -> u64 {
        1 << self.doublings
    }

    /// The sums of each complete block, in the order of time.
    pub fn blocks(&self) -> Vec<Vec<[f64; 2]>> {
        let none = Vec::new();
        let before = std::iter::once(&none).chain(&self.borders);
        before.zip(&self.borders).map(|(before, after)| difference(before, after)).collect()
    }

    /// Mean and standard error of each quantity. The mean is that of everything recorded.
    pub fn means(&self) -> Vec<BlockMean> {
        means(&self.last, &self.blocks())
    }
}

/// Means of sums, with standard errors from the sums of blocks, which may come from several runs.
pub fn means(total: &[[f64; 2]], blocks: &[Vec<[f64; 2]>]) -> Vec<BlockMean> {
    let mean = |(index, &[sum, weight]): (usize, &[f64; 2])| {
        let value = (weight > 0.0).then(|| sum / weight);
        let of_blocks = || blocks.iter().map(move |block| block.get(index).copied().unwrap_or_default());
        let standard_error = ratio_error(of_blocks());
        BlockMean { value, standard_error }
    };
    total.iter().enumerate().map(mean).collect()
}

/// Standard error of Σx / Σw from the sums (x, w) of blocks.
fn ratio_error(blocks: impl Iterator<Item = [f64; 2]> + Clone) -> Option<f64> {
    let count = blocks.clone().filter(|[_, weight]| *weight > 0.0).count() as f64;
    let [sum, weight] = blocks.clone().fold([0.0; 2], |[x, w], block| [x + block[0], w + block[1]]);
    if count < 2.0 {
        return None;
    }
    let ratio = sum / weight;
    let deviations: Vec<f64> = blocks.map(|[x, w]| x - ratio * w).collect();
    let squares: f64 = deviations.iter().map(|d| d * d).sum();
    let products: f64 = deviations.windows(2).map(|pair| pair[0] * pair[1]).sum();
    // Of independent blocks the products have the mean −Σd²/n, because the deviations sum to 0.
    let correlated = squares + 2.0 * (products + squares / count);
    let squares = correlated.max(LEAST_FACTOR * squares);
    Some((squares * count / (count - 1.0)).sqrt() / weight)
}

/// Sums of a block from those at its borders.
fn difference(before: &[[f64; 2]], after: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let start = |index: usize| before.get(index).copied().unwrap_or_default();
    let of = |(index, &[x, w]): (usize, &[f64; 2])| [x - start(index)[0], w - start(index)[1]];
    after.iter().enumerate().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A generator of uniform numbers (Marsaglia, J. Stat. Soft. 8 (2003) 14: xorshift).
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    /// Records of x' = a x + noise, whose mean has the variance σ² (1 + a)/(1 − a)/n.
    fn correlated(memory: f64, records: u32, seed: u64) -> BlockSums {
        let (mut blocks, mut random) = (BlockSums::default(), Random(seed));
        let (mut x, mut sum) = (0.0, 0.0);
        for record in 1..=records {
            x = memory * x + (1.0 - memory * memory).sqrt() * 12f64.sqrt() * (random.next() - 0.5);
            sum += x;
            blocks.record(&[[sum, f64::from(record)]]);
        }
        blocks
    }

    #[test]
    fn errors_of_correlated_records_agree_with_their_scatter() {
        agree(0.8, 8192);
        // A correlation time of 20 records in blocks of 32.
        agree(0.95, 2000);
    }

    fn agree(memory: f64, records: u32) {
        let expected = ((1.0 + memory) / (1.0 - memory) / f64::from(records)).sqrt();
        let means: Vec<BlockMean> =
            (1..=400).map(|seed| correlated(memory, records, 0x9E37_79B9 * seed).means()[0]).collect();
        let scatter = (means.iter().map(|mean| mean.value.unwrap().powi(2)).sum::<f64>() / 400.0).sqrt();
        // The scatter of 400 means has a standard error of 3.5 %.
        assert!((scatter / expected - 1.0).abs() < 0.11, "{scatter} {expected}");
        let mean_square = means.iter().map(|mean| mean.standard_error.unwrap().powi(2)).sum::<f64>() / 400.0;
        // F of 400 and of many degrees of freedom: 0.87 to 1.14 with a probability of 0.95.
        let ratio = mean_square / (scatter * scatter);
        assert!((0.82..1.2).contains(&ratio), "{ratio}");
    }

    #[test]
    fn joined_blocks_have_the_sums_of_their_parts() {
        let blocks = correlated(0.5, 1000, 7);
        assert_eq!(blocks.records_per_block(), 16);
        let parts = blocks.blocks();
        assert_eq!(parts.len(), 62);
        assert!(parts.iter().all(|block| block[0][1] == 16.0));
    }

    #[test]
    fn a_quantity_without_weight_has_no_mean() {
        let mut blocks = BlockSums::default();
        for time in 1..=4 {
            blocks.record(&[[f64::from(time), 1.0], [0.0, 0.0]]);
        }
        let means = blocks.means();
        assert_eq!(means[1], BlockMean::default());
        assert_eq!(means[0].value, Some(4.0));
        assert_eq!(means[0].standard_error, None);
    }
}
