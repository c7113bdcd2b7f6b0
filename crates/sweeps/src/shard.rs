//! Shards: the parts of a study that separate processes do, by a split that needs no messages.

use std::{cmp::Reverse, collections::BinaryHeap, fmt, str::FromStr};

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

use crate::point::Key;

/// Largest number of shards; more are a mistake.
const MAX_SHARDS: u32 = 1_000_000;

/// Shard I of N, with I from 1 to N.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Shard {
    /// Their number.
    pub of: u32,
    /// The number of this one, from 1.
    pub index: u32,
}

impl Shard {
    /// The only shard.
    pub const WHOLE: Self = Self { of: 1, index: 1 };
}

impl FromStr for Shard {
    type Err = anyhow::Error;

    /// Parses `I/N`.
    fn from_str(text: &str) -> Result<Self> {
        let (index, of) = text
            .split_once('/')
            .with_context(|| format!("'{text}' is not of the form I/N"))?;
        let number = |word: &str| {
            word.trim()
                .parse()
                .ok()
                .with_context(|| format!("'{word}' is not a number"))
        };
        let (index, of): (u32, u32) = (number(index)?, number(of)?);
        ensure!(
            (1..=MAX_SHARDS).contains(&of),
            "the number of shards must be from 1 to {MAX_SHARDS}, but is {of}"
        );
        ensure!(
            (1..=of).contains(&index),
            "the shard must be from 1 to {of}, but is {index}"
        );
        Ok(Self { of, index })
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
            .map_err(|error: anyhow::Error| format!("{error:#}"))
    }
}

/// A replica of a point: the unit of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Work {
    /// The point.
    pub key: Key,
    /// The number of the replica, from 1.
    pub replica: u64,
}

/// Orders work from the longest to the shortest; equal costs are in the order of key and replica.
pub fn longest_first(work: &mut [(Work, u64)]) {
    work.sort_unstable_by_key(|&(work, cost)| (Reverse(cost), work));
}

/// The work of a shard, longest first: each piece goes to the shard with the least work so far, of
/// equal ones to the first (Graham, SIAM J. Appl. Math. 17 (1969) 416: at most 4/3 of the best).
///
/// The split depends on the work and its costs alone.
pub fn split(mut work: Vec<(Work, u64)>, shard: Shard) -> Vec<(Work, u64)> {
    longest_first(&mut work);
    let mut loads: BinaryHeap<Reverse<(u64, u32)>> =
        (1..=shard.of).map(|index| Reverse((0, index))).collect();
    work.retain(|&(_, cost)| {
        let Some(Reverse((load, index))) = loads.pop() else {
            return false;
        };
        loads.push(Reverse((load + cost.max(1), index)));
        index == shard.index
    });
    work
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(number: u64) -> Key {
        Key::try_from(format!("{number:016x}")).unwrap()
    }

    fn work() -> Vec<(Work, u64)> {
        let points = (0..13u64).flat_map(|point| (1..=7).map(move |replica| (point, replica)));
        points
            .map(|(point, replica)| {
                (
                    Work {
                        key: key(point),
                        replica,
                    },
                    1 << (point % 6),
                )
            })
            .collect()
    }

    #[test]
    fn shards_are_parsed_and_refused_by_name() {
        assert_eq!("3/8".parse::<Shard>().unwrap(), Shard { of: 8, index: 3 });
        for (text, expected) in [
            ("0/8", "from 1 to 8"),
            ("9/8", "but is 9"),
            ("1/0", "1000000"),
            ("3", "I/N"),
        ] {
            let error = text.parse::<Shard>().unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn each_piece_of_work_is_in_one_shard_and_the_loads_are_balanced() {
        for of in [1, 2, 5, 16, 200] {
            let shards: Vec<Vec<(Work, u64)>> = (1..=of)
                .map(|index| split(work(), Shard { of, index }))
                .collect();
            let mut all = shards.concat();
            all.sort_unstable();
            let mut expected = work();
            expected.sort_unstable();
            assert_eq!(all, expected);
            let loads: Vec<u64> = shards
                .iter()
                .map(|shard| shard.iter().map(|(_, cost)| cost).sum())
                .collect();
            let (total, most) = (
                loads.iter().sum::<u64>(),
                loads.iter().max().copied().unwrap_or(0),
            );
            // No schedule is better than the mean, and none than the longest piece.
            let bound = (total as f64 / f64::from(of)).max(32.0);
            assert!(most as f64 <= 4.0 / 3.0 * bound, "{of}: {most} {bound}");
        }
        let mut turned = work();
        turned.reverse();
        let shard = Shard { of: 5, index: 2 };
        assert_eq!(
            split(turned, shard),
            split(work(), shard),
            "the order of the list has no effect"
        );
    }
}
