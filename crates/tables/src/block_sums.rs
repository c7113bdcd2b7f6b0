//! Means with standard errors from blocks of time, for any number of quantities at once.
//!
//! Each quantity is a ratio R = Σx / Σw of two sums that grow with time: w may be a number of
//! samples, of pairs, or a duration. The sums at the borders of [blocks](crate::blocking) are kept;
//! the errors are those of [`Estimate::of_runs`], with the correlation of blocks.

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
/// // d = −1, 1, 0, 0: Σd² = 2.
/// assert!((rate.standard_error.unwrap() - (2.0f64 * 4.0 / 3.0).sqrt() / 8.0).abs() < 1e-15);
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
    /// The blocks and the sums of one quantity at equal intervals of time, from its values, each
    /// with a weight.
    pub fn of_series(values: impl IntoIterator<Item = [f64; 2]>) -> (Self, [f64; 2]) {
        let (mut blocks, mut sums) = (Self::default(), [0.0; 2]);
        for [value, weight] in values {
            sums = [sums[0] + value * weight, sums[1] + weight];
            blocks.record(|| vec![sums]);
        }
        (blocks, sums)
    }

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

/// Mean and standard error of a series at equal intervals of time; `None` with fewer than two
/// values.
pub fn mean_of_series(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let (blocks, sums) = BlockSums::of_series(values.into_iter().map(|value| [value, 1.0]));
    let mean = blocks.means(&[sums])[0];
    Some((mean.value?, mean.standard_error?))
}

/// The sums of one quantity in each block.
pub fn of_quantity(blocks: &[Sums], quantity: usize) -> Vec<[f64; 2]> {
    blocks
        .iter()
        .map(|block| block.get(quantity).copied().unwrap_or_default())
        .collect()
}

/// Means of sums, with standard errors from the sums of the blocks of each run.
pub fn means(total: &[[f64; 2]], runs: &[Vec<Sums>]) -> Vec<BlockMean> {
    let mean = |(index, &[sum, weight]): (usize, &[f64; 2])| {
        let value = (weight > 0.0).then(|| sum / weight);
        let runs: Vec<Sums> = runs
            .iter()
            .map(|blocks| of_quantity(blocks, index))
            .collect();
        let standard_error = Estimate::of_runs(&runs).map(|estimate| estimate.standard_error);
        BlockMean {
            value,
            standard_error,
            quantity: Some(index),
        }
    };
    total.iter().enumerate().map(mean).collect()
}

/// The sums of each block from those from the start up to its end.
pub fn differences(borders: &[Sums]) -> Vec<Sums> {
    let none = Vec::new();
    let before = std::iter::once(&none).chain(borders);
    before
        .zip(borders)
        .map(|(before, after)| difference(before, after))
        .collect()
}

/// Sums of a block from those at its borders.
fn difference(before: &[[f64; 2]], after: &[[f64; 2]]) -> Sums {
    let start = |index: usize| before.get(index).copied().unwrap_or_default();
    let of = |(index, &[x, w]): (usize, &[f64; 2])| [x - start(index)[0], w - start(index)[1]];
    after.iter().enumerate().map(of).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A generator of uniform numbers (Marsaglia, J. Stat. Soft. 8 (2003) 14: xorshift).
    pub struct Random(pub u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    /// A standard normal number (Box and Muller, Ann. Math. Stat. 29 (1958) 610).
    pub fn normal(random: &mut Random) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - random.next())).sqrt();
        radius * libm::cos(std::f64::consts::TAU * random.next())
    }

    /// The blocks of the sums that `next` gives after each record.
    fn recorded(records: u32, mut next: impl FnMut() -> f64) -> (BlockSums, Sums) {
        let (mut blocks, mut total) = (BlockSums::default(), vec![[0.0, 0.0]]);
        for record in 1..=records {
            total = vec![[next(), f64::from(record)]];
            blocks.record(|| total.clone());
        }
        (blocks, total)
    }

    /// Records of x' = a x + noise, whose mean has the variance σ² (1 + a)/(1 − a)/n.
    fn correlated(memory: f64, records: u32, random: &mut Random) -> (BlockSums, Sums) {
        let (mut x, mut sum) = (normal(random), 0.0);
        recorded(records, || {
            x = memory * x + (1.0 - memory * memory).sqrt() * normal(random);
            sum += x;
            sum
        })
    }

    /// The root mean square of the errors over the scatter of the means, in 400 runs. By χ², the
    /// scatter is right to 11 % with a probability of 0.999.
    fn ratio(mut run: impl FnMut(&mut Random) -> (BlockSums, Sums)) -> f64 {
        let mut random = Random(0x9E37_79B9_7F4A_7C15);
        let means: Vec<BlockMean> = (0..400)
            .map(|_| {
                let (blocks, total) = run(&mut random);
                blocks.means(&total)[0]
            })
            .collect();
        let count = means.len() as f64;
        let mean = means.iter().map(|mean| mean.value.unwrap()).sum::<f64>() / count;
        let variance = means
            .iter()
            .map(|one| (one.value.unwrap() - mean).powi(2))
            .sum::<f64>()
            / (count - 1.0);
        let square = means
            .iter()
            .map(|one| one.standard_error.unwrap().powi(2))
            .sum::<f64>()
            / count;
        (square / variance).sqrt()
    }

    #[test]
    fn errors_of_correlated_records_agree_with_their_scatter() {
        // The longest correlation time is 20 records in blocks of 32, and up to 8 in blocks of one.
        for (memory, records) in [
            (0.0, 2000),
            (0.8, 8192),
            (0.95, 2000),
            (0.0, 48),
            (0.5, 48),
            (0.8, 48),
            (0.88, 60),
        ] {
            let found = ratio(|random| correlated(memory, records, random));
            assert!((0.8..1.25).contains(&found), "{memory}: {found}");
        }
    }

    /// The sum of the records is bounded: the momentum of a body in a gas is the sum of its
    /// impulses. Covariances of neighbours alone give errors four times too large.
    #[test]
    fn errors_of_bounded_sums_agree_with_their_scatter() {
        let found = ratio(|random| {
            let (mut x, start) = (0.0, normal(random));
            x += start;
            recorded(3900, || {
                x = 0.8 * x + 0.6 * normal(random);
                x - start
            })
        });
        assert!((0.8..1.4).contains(&found), "{found}");
    }

    /// Pulses at equal intervals: a block holds three or four.
    #[test]
    fn errors_of_pulses_agree_with_their_scatter() {
        let found = ratio(|random| {
            let (phase, mut time, mut noise) = (random.next(), 0.0, 0.0);
            recorded(3900, || {
                time += 1.0 / 18.7;
                noise += 0.001 * normal(random);
                (phase + time).floor() + noise
            })
        });
        assert!((0.6..1.5).contains(&found), "{found}");
    }

    #[test]
    fn joined_blocks_have_the_sums_of_their_parts() {
        let (blocks, _) = correlated(0.5, 1000, &mut Random(7));
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
        assert_eq!(
            means[1],
            BlockMean {
                quantity: Some(1),
                ..BlockMean::default()
            }
        );
        assert_eq!(means[0].value, Some(4.0));
        assert_eq!(means[0].standard_error, None);
    }
}
