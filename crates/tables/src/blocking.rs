//! Blocks of equal length that cover a run of any length, for statistical errors of correlated
//! data.
//!
//! A block is 2ᵏ records long. When there are 64 blocks, neighbours are joined and k increases by
//! one. A run of any length, unknown beforehand, is thus covered by 32 to 63 blocks (blocking;
//! Flyvbjerg and Petersen, J. Chem. Phys. 91 (1989) 461).

use serde::{Deserialize, Serialize};

/// The number of blocks at which pairs are joined. Smaller: the relative error of the standard
/// error exceeds 1/√(2 · 32) = 1/8. Larger: blocks of long runs are correlated.
pub const MAX_BLOCKS: usize = 64;

/// The complete blocks of a run.
///
/// ```
/// use carom_tables::Blocking;
///
/// // Counts of four records; each block holds the sum of its counts.
/// let mut blocks: Blocking<u64> = Blocking::default();
/// for count in [3, 1, 4, 1] {
///     blocks.record(|| count, |earlier, later| *earlier += later);
/// }
/// assert_eq!(blocks.complete(), [3, 1, 4, 1]);
/// assert_eq!(blocks.records_per_block(), 1);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Blocking<T> {
    complete: Vec<T>,
    /// Log₂ of the number of records in a block.
    doublings: u32,
    /// Number of records in the open block.
    open: u64,
}

impl<T> Default for Blocking<T> {
    fn default() -> Self {
        Self {
            complete: Vec::new(),
            doublings: 0,
            open: 0,
        }
    }
}

impl<T> Blocking<T> {
    /// The complete blocks in the order of time, all of the same number of records.
    pub fn complete(&self) -> &[T] {
        &self.complete
    }

    /// Whether the last record completed a block.
    pub fn is_whole(&self) -> bool {
        self.open == 0 && !self.complete.is_empty()
    }

    /// Number of records in a block.
    pub fn records_per_block(&self) -> u64 {
        1 << self.doublings
    }

    /// Counts one record. If it completes the open block, `close` gives that block, and `join` adds
    /// the later of two neighbours to the earlier one when there are [`MAX_BLOCKS`].
    pub fn record(&mut self, close: impl FnOnce() -> T, mut join: impl FnMut(&mut T, T)) {
        self.open += 1;
        if self.open < self.records_per_block() {
            return;
        }
        self.open = 0;
        self.complete.push(close());
        if self.complete.len() < MAX_BLOCKS {
            return;
        }
        let mut joined: Vec<T> = Vec::with_capacity(MAX_BLOCKS);
        for (index, block) in self.complete.drain(..).enumerate() {
            match joined.last_mut() {
                Some(last) if index % 2 == 1 => join(last, block),
                _ => joined.push(block),
            }
        }
        self.complete = joined;
        self.doublings += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_contiguous_and_complete() {
        for (records, blocks, length) in
            [(0, 0, 1), (1, 1, 1), (63, 63, 1), (64, 32, 2), (391, 48, 8)]
        {
            let mut blocking = Blocking::default();
            let mut open = Vec::new();
            for record in 0..records {
                open.push(record);
                blocking.record(
                    || std::mem::take(&mut open),
                    |earlier: &mut Vec<u64>, later| earlier.extend(later),
                );
            }
            assert_eq!(
                (blocking.complete().len(), blocking.records_per_block()),
                (blocks, length)
            );
            let all: Vec<u64> = blocking.complete().concat();
            assert_eq!(all, (0..blocks as u64 * length).collect::<Vec<_>>());
            assert!(
                blocking
                    .complete()
                    .iter()
                    .all(|block| block.len() as u64 == length)
            );
        }
    }
}
