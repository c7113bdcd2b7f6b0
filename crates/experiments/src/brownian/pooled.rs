//! Ratios of two sums over blocks of time of all replicas, with errors from the scatter of the
//! blocks.

use carom::observers::{Additive, Block, Blocks, Estimate};

use super::results::Measurement;

pub use carom_runs::measures::kicks::MIN_BLOCKS;

/// Number of blocks joined to test whether their length matters.
const JOINED: usize = 4;

/// A sum and its weight, such as the duration.
pub type Pair = (f64, f64);

/// A sum and its weight: over everything, and over the complete blocks of each run.
#[derive(Debug, Clone, PartialEq)]
pub struct Pooled {
    whole: Pair,
    runs: Vec<Vec<Pair>>,
}

fn sum(pairs: impl IntoIterator<Item = Pair>) -> Pair {
    pairs.into_iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
}

impl Pooled {
    /// Collects the blocks of one observer of each run.
    pub fn of<O: Additive>(
        runs: &[Measurement],
        blocks: impl Fn(&Measurement) -> &Blocks<O>,
        pair: impl Fn(&Block<O>) -> Pair,
    ) -> Self {
        Self {
            whole: sum(runs.iter().map(|run| pair(&blocks(run).total()))),
            runs: runs.iter().map(|run| blocks(run).complete().iter().map(&pair).collect()).collect(),
        }
    }

    /// Collects the blocks of each run, without data outside them.
    #[cfg(test)]
    pub fn planted(runs: Vec<Vec<Pair>>) -> Self {
        Self { whole: sum(runs.iter().flatten().copied()), runs }
    }

    /// Sum over all data.
    pub fn sum(&self) -> f64 {
        self.whole.0
    }

    /// Weight of all data.
    pub fn weight(&self) -> f64 {
        self.whole.1
    }

    /// The ratio; 0 without data.
    pub fn mean(&self) -> f64 {
        if self.weight() > 0.0 { self.sum() / self.weight() } else { 0.0 }
    }

    /// Standard error of the ratio; `None` with too few blocks.
    pub fn standard_error(&self) -> Option<f64> {
        self.error(1)
    }

    /// Standard error from blocks four times as long; about the same if the blocks are long enough.
    pub fn standard_error_of_longer_blocks(&self) -> Option<f64> {
        self.error(JOINED)
    }

    fn error(&self, joined: usize) -> Option<f64> {
        if self.runs.iter().map(Vec::len).sum::<usize>() < MIN_BLOCKS {
            return None;
        }
        let blocks: Vec<Pair> = self
            .runs
            .iter()
            .flat_map(|run| run.chunks_exact(joined).map(|blocks| sum(blocks.iter().copied())))
            .collect();
        let weight = sum(blocks.iter().copied()).1;
        let estimate = Estimate::of_ratio(blocks)?;
        // Data outside complete blocks improve the mean relative to the blocks alone.
        (estimate.standard_error > 0.0).then(|| estimate.standard_error * (weight / self.weight()).sqrt())
    }
}
