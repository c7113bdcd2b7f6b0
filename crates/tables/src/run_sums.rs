//! Sums of one run, and of many runs that are merged: in any order, with the same digits.
//!
//! Sums are kept by replica and block, and are added in the order of these keys. The result thus
//! does not depend on the order in which parts are merged, and merging is associative: (A + B) + C
//! and A + (B + C) have the same bits.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{BlockMean, Sums, block_sums::means};

/// The sums of a measure in one run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RunSums {
    /// Σx and Σw of each quantity over the whole run.
    pub total: Sums,
    /// The sums of each complete block, in the order of time.
    pub blocks: Vec<Sums>,
}

impl RunSums {
    /// Verifies that all sums are finite, that no weight is negative, and that no block has more
    /// quantities than the whole.
    ///
    /// # Errors
    /// The first sum that is invalid.
    pub fn check(&self) -> Result<(), SumsError> {
        check(&self.total)?;
        let all = self.total.len();
        for (index, block) in self.blocks.iter().enumerate() {
            if block.len() > all {
                return Err(SumsError::Quantities {
                    block: index + 1,
                    found: block.len(),
                    all,
                });
            }
            check(block)?;
        }
        Ok(())
    }

    /// Means with errors from the scatter of the blocks.
    pub fn means(&self) -> Vec<BlockMean> {
        means(&self.total, std::slice::from_ref(&self.blocks))
    }
}

fn check(sums: &[[f64; 2]]) -> Result<(), SumsError> {
    for (quantity, &[sum, weight]) in sums.iter().enumerate() {
        if !sum.is_finite() {
            return Err(SumsError::Sum { quantity, sum });
        }
        if !(weight >= 0.0 && weight.is_finite()) {
            return Err(SumsError::Weight { quantity, weight });
        }
    }
    Ok(())
}

/// Why sums are invalid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SumsError {
    /// A sum is not finite.
    Sum {
        /// The number of its quantity.
        quantity: usize,
        /// The sum.
        sum: f64,
    },
    /// A weight is negative or not finite.
    Weight {
        /// The number of its quantity.
        quantity: usize,
        /// The weight.
        weight: f64,
    },
    /// A block has more quantities than the whole run.
    Quantities {
        /// The number of the block, from 1.
        block: usize,
        /// Its quantities.
        found: usize,
        /// The quantities of the whole run.
        all: usize,
    },
}

impl std::fmt::Display for SumsError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Sum { quantity, sum } => {
                write!(
                    f,
                    "the sum of quantity {quantity} must be finite, but is {sum}"
                )
            }
            Self::Weight { quantity, weight } => {
                write!(
                    f,
                    "the weight of quantity {quantity} must be finite and at least 0, but is {weight}"
                )
            }
            Self::Quantities { block, found, all } => {
                write!(
                    f,
                    "block {block} has {found} quantities, but the run has {all}"
                )
            }
        }
    }
}

impl std::error::Error for SumsError {}

/// What distinguishes the runs of one scene: the seed and the number of the replica.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Replica {
    /// The seed of its random numbers.
    pub seed: u64,
    /// Its number among the runs of that seed.
    pub number: u64,
}

/// The sums of a measure by replica and block.
///
/// ```
/// use carom_tables::{MergedSums, Replica, RunSums};
///
/// let run = |x: f64| RunSums { total: vec![[x, 2.0]], blocks: vec![vec![[x, 2.0]]] };
/// let replica = |number| Replica { seed: 1, number };
/// let mut all = MergedSums::new(replica(0), run(9.0));
/// all.merge(MergedSums::new(replica(1), run(11.0)))?;
/// assert_eq!(all.means()[0].value, Some(5.0));
/// // A run cannot count twice.
/// assert!(all.merge(MergedSums::new(replica(1), run(11.0))).is_err());
/// # Ok::<(), carom_tables::MergeError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MergedSums {
    runs: BTreeMap<Replica, RunSums>,
}

/// Why sums cannot be merged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MergeError {
    /// Both parts hold this replica.
    Twice(Replica),
    /// The parts have different numbers of quantities.
    Quantities([usize; 2]),
}

impl std::fmt::Display for MergeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Twice(Replica { seed, number }) => {
                write!(
                    f,
                    "the run with seed {seed} and replica {number} is there twice"
                )
            }
            Self::Quantities([one, other]) => {
                write!(f, "one part has {one} quantities, the other {other}")
            }
        }
    }
}

impl std::error::Error for MergeError {}

impl MergedSums {
    /// The sums of one run.
    pub fn new(replica: Replica, sums: RunSums) -> Self {
        Self {
            runs: BTreeMap::from([(replica, sums)]),
        }
    }

    /// Adds the runs of another part.
    ///
    /// # Errors
    /// A replica is in both parts, or the parts have different numbers of quantities; nothing is
    /// then merged.
    pub fn merge(&mut self, other: Self) -> Result<(), MergeError> {
        let quantities = |part: &Self| part.runs.values().next().map(|run| run.total.len());
        if let (Some(one), Some(two)) = (quantities(self), quantities(&other))
            && one != two
        {
            return Err(MergeError::Quantities([one, two]));
        }
        if let Some(replica) = other
            .runs
            .keys()
            .find(|replica| self.runs.contains_key(replica))
        {
            return Err(MergeError::Twice(*replica));
        }
        self.runs.extend(other.runs);
        Ok(())
    }

    /// The replicas, in ascending order.
    pub fn replicas(&self) -> impl Iterator<Item = Replica> {
        self.runs.keys().copied()
    }

    /// Sums over all runs, added in the order of the replicas.
    pub fn total(&self) -> Sums {
        let mut total = Sums::new();
        for run in self.runs.values() {
            total.resize(run.total.len().max(total.len()), [0.0; 2]);
            for (sum, part) in total.iter_mut().zip(&run.total) {
                *sum = [sum[0] + part[0], sum[1] + part[1]];
            }
        }
        total
    }

    /// Means with errors from the scatter of the blocks of all runs. Runs without two complete
    /// blocks count as one block each.
    pub fn means(&self) -> Vec<BlockMean> {
        let blocks = |run: &RunSums| match run.blocks.len() {
            0 | 1 => vec![run.total.clone()],
            _ => run.blocks.clone(),
        };
        let runs: Vec<Vec<Sums>> = self.runs.values().map(blocks).collect();
        means(&self.total(), &runs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums whose addition in floating point depends on the order.
    fn part(number: u64) -> MergedSums {
        let x = 0.1 * (number as f64 + 1.0).powi(7) + 1e-9 / (number as f64 + 1.0);
        let blocks = vec![
            vec![[0.4 * x, 1.0], [x, 2.0]],
            vec![[0.6 * x, 1.1], [-x, 3.0]],
        ];
        let total = vec![[x, 2.1], [1e-16 * x, 5.0]];
        MergedSums::new(
            Replica {
                seed: 7 - number % 3,
                number,
            },
            RunSums { total, blocks },
        )
    }

    fn merged(mut parts: Vec<MergedSums>) -> MergedSums {
        let mut all = MergedSums::default();
        parts.drain(..).for_each(|part| all.merge(part).unwrap());
        all
    }

    #[test]
    fn any_order_and_any_tree_give_the_same_digits() {
        let expected = merged((0..6).map(part).collect());
        let (sums, means) = (expected.total(), expected.means());
        // All 720 orders.
        let mut order: Vec<u64> = (0..6).collect();
        let mut stack = [0usize; 6];
        let mut index = 0;
        while index < 6 {
            if stack[index] < index {
                order.swap(if index % 2 == 0 { 0 } else { stack[index] }, index);
                let found = merged(order.iter().map(|&number| part(number)).collect());
                assert_eq!(
                    (found.total(), found.means()),
                    (sums.clone(), means.clone())
                );
                stack[index] += 1;
                index = 0;
            } else {
                stack[index] = 0;
                index += 1;
            }
        }
        // Trees: every way to cut the list in two, recursively by the same rule.
        for cut in 1..6 {
            let tree = |numbers: std::ops::Range<u64>| merged(numbers.map(part).collect());
            let mut right = tree(cut..6);
            right.merge(tree(0..cut)).unwrap();
            assert_eq!(
                (right.total(), right.means()),
                (sums.clone(), means.clone())
            );
        }
        let pairs = [[4, 1], [0, 5], [3, 2]].map(|pair| merged(pair.map(part).to_vec()));
        assert_eq!(merged(pairs.to_vec()).means(), means);
    }

    #[test]
    fn sums_that_are_no_sums_are_refused() {
        let sums = |total: Sums, block: Sums| {
            RunSums {
                total,
                blocks: vec![block],
            }
            .check()
        };
        assert_eq!(
            sums(vec![[-1.0, 0.0], [2.0, 3.0]], vec![[1.0, 1.0]]),
            Ok(())
        );
        assert_eq!(
            sums(vec![[1.0, -0.5]], Vec::new()),
            Err(SumsError::Weight {
                quantity: 0,
                weight: -0.5
            })
        );
        let infinite = sums(vec![[1.0, 1.0]], vec![[f64::INFINITY, 1.0]]);
        assert_eq!(
            infinite,
            Err(SumsError::Sum {
                quantity: 0,
                sum: f64::INFINITY
            })
        );
        assert!(sums(vec![[1.0, f64::NAN]], Vec::new()).is_err());
        let longer = sums(vec![[1.0, 1.0]], vec![[1.0, 1.0]; 2]);
        assert_eq!(
            longer,
            Err(SumsError::Quantities {
                block: 1,
                found: 2,
                all: 1
            })
        );
    }

    #[test]
    fn parts_that_do_not_fit_are_refused_as_a_whole() {
        let mut all = merged((0..3).map(part).collect());
        let before = all.clone();
        let other = merged(vec![part(4), part(2)]);
        assert_eq!(
            all.merge(other),
            Err(MergeError::Twice(Replica { seed: 5, number: 2 }))
        );
        let one = RunSums {
            total: vec![[1.0, 1.0]],
            blocks: Vec::new(),
        };
        let one = MergedSums::new(Replica { seed: 9, number: 9 }, one);
        assert_eq!(all.merge(one), Err(MergeError::Quantities([2, 1])));
        assert_eq!(all, before);
    }
}
