//! What a sweep lacks: replicas by point, and the shards that should have done them.

use std::{collections::BTreeMap, fmt::Write as _};

use serde::Serialize;

use crate::{layout::Shards, point::Key, results::PointResults, shard::Shard, study::Study};

/// Most points that are listed by their values.
const MAX_LISTED: usize = 12;

/// What has not been done.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Missing {
    /// Replicas that no file holds, by point.
    replicas: BTreeMap<Key, Vec<u64>>,
    /// Shards of which nothing is there.
    absent: Vec<Shard>,
    /// Shards that have not done all of their work.
    unfinished: Vec<Shard>,
}

/// What one point lacks, for programs.
#[derive(Debug, Serialize)]
pub struct MissingOfPoint<'a> {
    point: Key,
    label: &'a str,
    replicas: &'a [u64],
}

impl Missing {
    /// What points lack. `shards` are those that were found.
    pub fn new(study: &Study, points: &[PointResults], shards: &Shards) -> Self {
        let mut replicas = BTreeMap::new();
        for results in points {
            let lacking = (1..=study.replicas)
                .filter(|replica| results.replicas.binary_search(replica).is_err());
            let lacking: Vec<u64> = lacking.collect();
            if !lacking.is_empty() {
                replicas.insert(results.point, lacking);
            }
        }
        let is_lacking = |key: &Key, own: &[u64]| {
            replicas.get(key).is_some_and(|lacking: &Vec<u64>| {
                own.iter().any(|one| lacking.binary_search(one).is_ok())
            })
        };
        let unfinished = shards
            .iter()
            .filter(|(_, work)| work.iter().any(|(key, own)| is_lacking(key, own)));
        let unfinished = unfinished.map(|(&shard, _)| shard).collect();
        let of = shards.keys().map(|shard| shard.of).max().unwrap_or(1);
        let is_absent = |shard: &Shard| !shards.contains_key(shard);
        let all = (1..=of).map(|index| Shard { of, index });
        let absent = if replicas.is_empty() {
            Vec::new()
        } else {
            all.filter(is_absent).collect()
        };
        Self {
            replicas,
            absent,
            unfinished,
        }
    }

    /// Whether nothing is missing.
    pub fn is_empty(&self) -> bool {
        self.replicas.is_empty()
    }

    /// The replicas that are missing, by point.
    pub fn by_point<'a>(&'a self, study: &'a Study) -> Vec<MissingOfPoint<'a>> {
        let of_point = |point: &'a crate::point::StudyPoint| {
            let replicas = self.replicas.get(&point.key)?;
            Some(MissingOfPoint {
                point: point.key,
                label: &point.label,
                replicas,
            })
        };
        study.points.iter().filter_map(of_point).collect()
    }

    /// Number of points that have all their replicas.
    pub fn complete_points(&self, all: usize) -> usize {
        all - self.replicas.len()
    }

    /// What is missing, in words.
    pub fn words(&self, study: &Study) -> String {
        let lacking: usize = self.replicas.values().map(Vec::len).sum();
        let all = study.points.len() as u64 * study.replicas;
        let points = self.replicas.len();
        let plural = if points == 1 { "" } else { "s" };
        let mut words =
            format!("Missing are {lacking} of {all} replicas, in {points} point{plural}: ");
        let points = study.points.iter().filter_map(|point| {
            let replicas = self.replicas.get(&point.key)?;
            let which = if replicas.len() as u64 == study.replicas {
                "all".to_owned()
            } else {
                ranges(replicas.iter().copied())
            };
            Some(format!("{} ({which})", point.label))
        });
        words += &points.take(MAX_LISTED).collect::<Vec<_>>().join("; ");
        if self.replicas.len() > MAX_LISTED {
            let _ = write!(
                words,
                "; and {} more points",
                self.replicas.len() - MAX_LISTED
            );
        }
        words.push('.');
        for (shards, state) in [
            (&self.absent, "are not there"),
            (&self.unfinished, "have not ended"),
        ] {
            if let [first, ..] = shards.as_slice() {
                let indices = ranges(shards.iter().map(|shard| u64::from(shard.index)));
                if first.of > 1 {
                    let _ = write!(words, " Of {} shards these {state}: {indices}.", first.of);
                }
            }
        }
        words
    }
}

/// Ascending numbers in words, such as `1 to 4, 7`.
fn ranges(numbers: impl Iterator<Item = u64>) -> String {
    let mut ranges: Vec<(u64, u64)> = Vec::new();
    for number in numbers {
        match ranges.last_mut() {
            Some((_, last)) if *last + 1 == number => *last = number,
            _ => ranges.push((number, number)),
        }
    }
    let words = ranges.into_iter().map(|(first, last)| match last - first {
        0 => first.to_string(),
        1 => format!("{first}, {last}"),
        _ => format!("{first} to {last}"),
    });
    words.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_joined_to_ranges() {
        assert_eq!(ranges([1, 2, 3, 5, 7, 8].into_iter()), "1 to 3, 5, 7, 8");
        assert_eq!(ranges([].into_iter()), "");
    }
}
