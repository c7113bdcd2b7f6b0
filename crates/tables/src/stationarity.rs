//! Whether a mean changes during its measurement: the state of a run may still relax, or be driven.
//!
//! The mean over an earlier part is compared with that over the rest, for several divisions. Their
//! scatter is that of the second half of the blocks without its linear trend, so that a transient
//! at the start does not hide itself in the error. This is the comparison of parts of Geweke (in
//! "Bayesian Statistics 4", 1992), with the spectral density at frequency 0 as there.

use serde::{Deserialize, Serialize};

use crate::Estimate;

/// Fewer blocks of a measurement are not judged. Smaller: false alarms, since the scatter of few
/// blocks is uncertain. Larger: short runs are never judged.
pub const MIN_JUDGED: usize = 32;

/// Fewest blocks after a transient from which it is judged that the mean has settled.
const MIN_SETTLED: usize = 16;

/// A change of more standard errors is one. Smaller: of some forty figures of a run, one would be
/// called changing by chance more often than in one run of a hundred.
const CHANGED: f64 = 5.0;

/// A mean has settled if what is left changes by no more standard errors.
const SETTLED: f64 = 3.0;

/// Blocks whose mean scatters by this factor more than that of independent ones are correlated.
/// Smaller: 64 independent blocks are called correlated by chance. Larger: a correlation time of
/// less than a block is not found.
const CORRELATED: f64 = 1.5;

/// Earlier parts that are compared with the rest, as shares of all blocks.
const EARLIER: [f64; 3] = [0.125, 0.25, 0.5];

/// Divisions of the measurement from which the end of a transient is sought, in its first half.
const DIVISIONS: usize = 16;

/// Whether a mean changes during its measurement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stationarity {
    /// Whether no change was found.
    pub is_stationary: bool,
    /// The mean of the later part less that of the earlier one, at the division with the clearest
    /// difference (unit of the mean).
    pub change: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// The time from which no change is found; `None` if there is none in the first half, or if the
    /// mean is stationary.
    pub settled_at: Option<f64>,
    /// Effective number of independent blocks, at most that of all blocks.
    pub independent_blocks: f64,
    /// Integrated correlation time; `None` if it is not resolved, since it is shorter than half a
    /// block.
    pub correlation_time: Option<f64>,
}

impl Stationarity {
    /// Judges Σx / Σw from [x, w] of the blocks of runs, each measured from the first to the second
    /// time of `span`. The blocks of several runs are added one by one.
    ///
    /// `None` with fewer than 32 blocks, or if a block has no weight or the blocks do not scatter.
    ///
    /// ```
    /// use carom_tables::Stationarity;
    ///
    /// // 64 blocks of a mean that relaxes within about six of them.
    /// let block = |n: u32| {
    ///     let noise = [0.3, -0.2, 0.1, -0.2][n as usize % 4];
    ///     [10.0 + 8.0 * (-f64::from(n) / 2.0).exp() + noise, 1.0]
    /// };
    /// let run: Vec<[f64; 2]> = (0..64).map(block).collect();
    /// let found = Stationarity::new(&[run], [0.0, 64.0]).expect("64 blocks");
    /// assert!(!found.is_stationary && found.change < 0.0);
    /// assert!((4.0..20.0).contains(&found.settled_at.expect("it settles")));
    /// ```
    pub fn new(runs: &[Vec<[f64; 2]>], span: [f64; 2]) -> Option<Self> {
        let count = runs
            .iter()
            .map(Vec::len)
            .min()
            .filter(|count| *count >= MIN_JUDGED)?;
        let sum = |block: usize| {
            runs.iter().fold([0.0; 2], |[x, w], run| {
                [x + run[block][0], w + run[block][1]]
            })
        };
        let blocks: Vec<[f64; 2]> = (0..count).map(sum).collect();
        let [deviation, change, standard_error] = clearest(changes(&blocks)?)?;
        let is_stationary = deviation <= CHANGED;
        let settled_at = (1..=DIVISIONS / 2)
            .map(|part| part * count / DIVISIONS)
            .filter(|begin| count - begin >= MIN_SETTLED)
            .find(|&begin| {
                let rest = changes(&blocks[begin..]).and_then(clearest);
                rest.is_some_and(|[rest, ..]| rest <= SETTLED)
            })
            .map(|begin| span[0] + (span[1] - span[0]) * begin as f64 / count as f64)
            .filter(|_| !is_stationary);
        let inefficiency = statistical_inefficiency(runs)?;
        let all: usize = runs.iter().map(Vec::len).sum();
        let half_a_block = 0.5 * (span[1] - span[0]) / count as f64;
        Some(Self {
            is_stationary,
            change,
            standard_error,
            settled_at,
            independent_blocks: all as f64 / inefficiency.max(1.0),
            correlation_time: (inefficiency > CORRELATED).then_some(inefficiency * half_a_block),
        })
    }

    /// Judges Σx / Σw from the blocks of runs that were not measured over the same times: the
    /// change is the mean of those in the runs, each from the same share of its blocks on. From
    /// which time on there is none is not known.
    ///
    /// `None` if one of them cannot be judged; see [`new`](Self::new).
    pub fn of_separate(runs: &[Vec<[f64; 2]>]) -> Option<Self> {
        if runs.iter().any(|run| run.len() < MIN_JUDGED) {
            return None;
        }
        let of_runs: Vec<_> = runs.iter().map(|run| changes(run)).collect::<Option<_>>()?;
        let count = runs.len() as f64;
        let mean = |place: usize| -> [f64; 2] {
            let change: f64 = of_runs.iter().map(|changes| changes[place][0]).sum();
            let squares: f64 = of_runs
                .iter()
                .map(|changes| changes[place][1].powi(2))
                .sum();
            [change / count, squares.sqrt() / count]
        };
        let [deviation, change, standard_error] = clearest([0, 1, 2].map(mean))?;
        let inefficiency = statistical_inefficiency(runs)?;
        let all: usize = runs.iter().map(Vec::len).sum();
        Some(Self {
            is_stationary: deviation <= CHANGED,
            change,
            standard_error,
            settled_at: None,
            independent_blocks: all as f64 / inefficiency.max(1.0),
            correlation_time: None,
        })
    }
}

/// The variance of the mean over that of independent blocks: twice the correlation time in blocks,
/// if blocks are shorter than that.
fn statistical_inefficiency(runs: &[Vec<[f64; 2]>]) -> Option<f64> {
    let blocks = runs.iter().flatten().map(|&[x, w]| (x, w));
    let independent = Estimate::of_ratio(blocks)?.standard_error;
    let correlated = Estimate::of_runs(runs)?.standard_error;
    Some((correlated / independent).powi(2)).filter(|ratio| ratio.is_finite())
}

/// The clearest of some changes: in standard errors, in the unit of the mean, and its error.
fn clearest(changes: [[f64; 2]; EARLIER.len()]) -> Option<[f64; 3]> {
    let in_errors = |[change, error]: [f64; 2]| [change.abs() / error, change, error];
    let clearest = changes
        .into_iter()
        .map(in_errors)
        .max_by(|a, b| a[0].total_cmp(&b[0]))?;
    clearest
        .iter()
        .all(|number| number.is_finite())
        .then_some(clearest)
}

/// The mean of a later part less that of the earlier one, for each division, with its standard
/// error (unit of the mean).
fn changes(blocks: &[[f64; 2]]) -> Option<[[f64; 2]; EARLIER.len()]> {
    if blocks.iter().any(|[_, weight]| *weight <= 0.0) {
        return None;
    }
    let count = blocks.len();
    let later = without_trend(&blocks[count / 2..]);
    let error = Estimate::of_runs(&[later])?.standard_error;
    let of_block = error * ((count - count / 2) as f64).sqrt();
    if of_block <= 0.0 {
        return None;
    }
    Some(EARLIER.map(|share| {
        let first = (share * count as f64) as usize;
        let [earlier, rest] = [&blocks[..first.max(1)], &blocks[first.max(1)..]];
        let change = mean(rest) - mean(earlier);
        let error = of_block * (1.0 / earlier.len() as f64 + 1.0 / rest.len() as f64).sqrt();
        [change, error]
    }))
}

fn mean(blocks: &[[f64; 2]]) -> f64 {
    let [x, w] = blocks
        .iter()
        .fold([0.0; 2], |[x, w], block| [x + block[0], w + block[1]]);
    x / w
}

/// The blocks without the linear trend of x/w over their number.
fn without_trend(blocks: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let middle = 0.5 * (blocks.len() as f64 - 1.0);
    let places = || (0..blocks.len()).map(|place| place as f64 - middle);
    let squares: f64 = places().map(|place| place * place).sum();
    let slope = places()
        .zip(blocks)
        .map(|(place, [x, w])| place * x / w)
        .sum::<f64>()
        / squares;
    places()
        .zip(blocks)
        .map(|(place, [x, w])| [x - slope * place * w, *w])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block_sums::tests::{Random, normal};

    /// Blocks of a noise of this memory around a mean.
    fn run(random: &mut Random, memory: f64, mean: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        let mut x = normal(random);
        (0..64)
            .map(|block| {
                x = memory * x + (1.0 - memory * memory).sqrt() * normal(random);
                [mean(f64::from(block) / 64.0) + x, 1.0]
            })
            .collect()
    }

    #[test]
    fn runs_that_begin_at_different_times_are_judged_together() {
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        // A change that no run shows alone.
        let mut drifting = || run(&mut random, 0.0, |share| 1.0 * share);
        let runs: Vec<_> = (0..16).map(|_| drifting()).collect();
        let alone = Stationarity::of_separate(&runs[..1]).unwrap();
        let together = Stationarity::of_separate(&runs).unwrap();
        assert!(
            alone.is_stationary && !together.is_stationary,
            "{alone:?} {together:?}"
        );
        assert!((together.change - 0.5).abs() < 4.0 * together.standard_error);
        // Of equal durations the changes are those of the sums.
        let of_sums = Stationarity::new(&runs, [0.0, 1.0]).unwrap();
        assert!((together.change / of_sums.change - 1.0).abs() < 1e-9);
        let mut constant = || run(&mut random, 0.0, |_| 3.0);
        let runs: Vec<_> = (0..16).map(|_| constant()).collect();
        assert!(Stationarity::of_separate(&runs).unwrap().is_stationary);
    }

    /// The shares of 400 measurements that are called changing, and that have settled.
    fn shares(memory: f64, mean: impl Fn(f64) -> f64 + Copy) -> [f64; 2] {
        let mut random = Random(0x9E37_79B9_7F4A_7C15);
        let (mut changing, mut settled) = (0, 0);
        for _ in 0..400 {
            let found = Stationarity::new(&[run(&mut random, memory, mean)], [0.0, 1.0]).unwrap();
            changing += u32::from(!found.is_stationary);
            settled += u32::from(found.settled_at.is_some_and(|at| (0.05..0.5).contains(&at)));
        }
        [changing, settled].map(|count| f64::from(count) / 400.0)
    }

    #[test]
    fn noise_is_seldom_called_a_change_and_drifts_and_transients_are() {
        assert!(shares(0.0, |_| 100.0)[0] <= 0.01);
        assert!(shares(0.5, |_| 100.0)[0] <= 0.03);
        // A drift over four standard deviations of a block never settles.
        let [changing, settled] = shares(0.0, |t| 100.0 - 4.0 * t);
        assert!(changing > 0.9 && settled < 0.5, "{changing} {settled}");
        // A transient of eight standard deviations that is over after a tenth.
        let [changing, settled] = shares(0.0, |t| 100.0 + 8.0 * (-t / 0.04).exp());
        assert!(changing > 0.9 && settled > 0.85, "{changing} {settled}");
    }

    #[test]
    fn correlation_times_are_those_of_the_noise() {
        let mut random = Random(11);
        let of = |memory: f64, random: &mut Random| {
            let found: Vec<Stationarity> = (0..100)
                .map(|_| Stationarity::new(&[run(random, memory, |_| 100.0)], [0.0, 64.0]).unwrap())
                .collect();
            let times = found.iter().filter_map(|one| one.correlation_time);
            let independent = found.iter().map(|one| one.independent_blocks).sum::<f64>() / 100.0;
            (
                times.clone().count(),
                times.clone().sum::<f64>() / times.count().max(1) as f64,
                independent,
            )
        };
        // (1 + a)/(1 − a) is the inefficiency: τ = 1/2 (1 + a)/(1 − a) blocks.
        let (count, _, independent) = of(0.0, &mut random);
        assert!(count <= 10 && independent > 55.0, "{count} {independent}");
        let (count, time, independent) = of(0.7, &mut random);
        assert!(count > 80 && (1.8..4.0).contains(&time), "{count} {time}");
        assert!((8.0..22.0).contains(&independent), "{independent}");
    }

    #[test]
    fn replicas_show_a_change_that_one_does_not() {
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        let runs: Vec<_> = (0..40)
            .map(|_| run(&mut random, 0.0, |t| 100.0 - 0.8 * t))
            .collect();
        assert!(
            Stationarity::new(&runs[..1], [0.0, 1.0])
                .unwrap()
                .is_stationary
        );
        let found = Stationarity::new(&runs, [0.0, 1.0]).unwrap();
        assert!(!found.is_stationary && found.change < 0.0);
    }

    #[test]
    fn few_blocks_and_constants_are_not_judged() {
        let constant = |count: usize| vec![[1.0, 1.0]; count];
        assert_eq!(Stationarity::new(&[constant(31)], [0.0, 1.0]), None);
        assert_eq!(Stationarity::new(&[constant(64)], [0.0, 1.0]), None);
        assert_eq!(Stationarity::new(&[vec![[1.0, 0.0]; 64]], [0.0, 1.0]), None);
        assert_eq!(Stationarity::new(&[], [0.0, 1.0]), None);
    }
}
