//! Means with standard errors from blocks of time, for any number of quantities at once.
//!
//! Each quantity is a ratio R = Σx / Σw of two sums that grow with time: w may be a number of
//! samples, of pairs, or a duration. The sums at the borders of [blocks](crate::blocking) are kept;
//! the errors are those of [`Estimate::of_runs`], with the covariance of neighbouring blocks.

use serde::{Deserialize, Serialize};

use crate::{Blocking, Estimate};

/// The sums x and w of each quantity.
pub type Sums = Vec<[f64; 2]>;

/// Sums of several quantities at the borders of blocks.
///
/// ```
/// use carom_tables::BlockSums;
///
/// let mut blocks = BlockSums::default();
/// // 9, 11, 10 and 10 events in four blocks of two units of time.
/// let sums = [[9.0, 2.0], [20.0, 4.0], [30.0, 6.0], [40.0, 8.0]];
/// for sums in sums {
///     blocks.record(|| vec![sums]);
/// }
/// let rate = blocks.means(&sums[3..])[0];
/// assert_eq!(rate.value, Some(5.0));
/// // d = −1, 1, 0, 0: Σd² = 2, and neighbours contribute 2 (−1 + 2/4) = −1.
/// assert!((rate.standard_error.unwrap() - (1.0f64 * 4.0 / 3.0).sqrt() / 8.0).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct BlockSums {
    /// Σx and Σw of each quantity from the start to the end of each complete block.
    borders: Blocking<Sums>,
}

/// A mean with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BlockMean {
    /// The mean; `None` if it has no weight.
    pub value: Option<f64>,
    /// Its standard error; `None` with fewer than two blocks of weight.
    pub standard_error: Option<f64>,
    /// The number of the quantity in the sums that the mean comes from; `None` if it was computed
    /// from several.
    pub quantity: Option<usize>,
}

impl BlockSums {
    /// Counts a record. Call it at equal intervals of time. `sums` gives the sums of all quantities
    /// from the start up to now, and is called at the end of a block only.
    pub fn record(&mut self, sums: impl FnOnce() -> Sums) {
        self.borders.record(sums, |earlier, later| *earlier = later);
    }

    /// Number of complete blocks.
    pub fn complete(&self) -> usize {
        self.borders.complete().len()
    }

    /// Whether the last record completed a block.
    pub fn is_whole(&self) -> bool {
        self.borders.is_whole()
    }

    /// Number of records in a block.
    pub fn records_per_block(&self) -> u64 {
        self.borders.records_per_block()
    }

    /// The sums from the start up to the end of each complete block, in the order of time.
    pub fn borders(&self) -> &[Sums] {
        self.borders.complete()
    }

    /// The sums of each complete block, in the order of time.
    pub fn blocks(&self) -> Vec<Sums> {
        differences(self.borders())
    }

    /// Mean and standard error of each quantity. The mean is that of everything recorded, whose
    /// sums are `total`.
    pub fn means(&self, total: &[[f64; 2]]) -> Vec<BlockMean> {
        means(total, &[self.blocks()])
    }
}

/// Means of sums, with standard errors from the sums of the blocks of each run.
pub fn means(total: &[[f64; 2]], runs: &[Vec<Sums>]) -> Vec<BlockMean> {
    let mean = |(index, &[sum, weight]): (usize, &[f64; 2])| {
        let value = (weight > 0.0).then(|| sum / weight);
        let of_block = |block: &Sums| block.get(index).copied().unwrap_or_default();
        let runs: Vec<Sums> = runs.iter().map(|blocks| blocks.iter().map(of_block).collect()).collect();
        let standard_error = Estimate::of_runs(&runs).map(|estimate| estimate.standard_error);
        BlockMean { value, standard_error, quantity: Some(index) }
    };
    total.iter().enumerate().map(mean).collect()
}

/// The sums of each block from those from the start up to its end.
pub fn differences(borders: &[Sums]) -> Vec<Sums> {
    let none = Vec::new();
    let before = std::iter::once(&none).chain(borders);
    before.zip(borders).map(|(before, after)| difference(before, after)).collect()
}

/// Sums of a block from those at its borders.
fn difference(before: &[[f64; 2]], after: &[[f64; 2]]) -> Sums {
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
    fn correlated(memory: f64, records: u32, seed: u64) -> (BlockSums, Sums) {
        let (mut blocks, mut random) = (BlockSums::default(), Random(seed));
        let (mut x, mut sum) = (0.0, 0.0);
        for record in 1..=records {
            x = memory * x + (1.0 - memory * memory).sqrt() * 12f64.sqrt() * (random.next() - 0.5);
            sum += x;
            blocks.record(|| vec![[sum, f64::from(record)]]);
        }
        (blocks, vec![[sum, f64::from(records)]])
    }

    #[test]
    fn errors_of_correlated_records_agree_with_their_scatter() {
        agree(0.8, 8192);
        // A correlation time of 20 records in blocks of 32.
        agree(0.95, 2000);
    }

    fn agree(memory: f64, records: u32) {
        let expected = ((1.0 + memory) / (1.0 - memory) / f64::from(records)).sqrt();
        let mean = |seed: u64| {
            let (blocks, total) = correlated(memory, records, 0x9E37_79B9 * seed);
            blocks.means(&total)[0]
        };
        let means: Vec<BlockMean> = (1..=400).map(mean).collect();
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
        let (blocks, _) = correlated(0.5, 1000, 7);
        assert_eq!(blocks.records_per_block(), 16);
        let parts = blocks.blocks();
        assert_eq!(parts.len(), 62);
        assert!(parts.iter().all(|block| block[0][1] == 16.0));
    }

    #[test]
    fn a_quantity_without_weight_has_no_mean() {
        let mut blocks = BlockSums::default();
        for time in 1..=4 {
            blocks.record(|| vec![[f64::from(time), 1.0], [0.0, 0.0]]);
        }
        let means = blocks.means(&[[4.0, 1.0], [0.0, 0.0]]);
        assert_eq!(means[1], BlockMean { quantity: Some(1), ..BlockMean::default() });
        assert_eq!(means[0].value, Some(4.0));
        assert_eq!(means[0].standard_error, None);
    }
}
