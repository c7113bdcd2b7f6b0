//! Sums over pairs of samples at logarithmic lags, the machinery of all time correlations.
//!
//! Lags are 1, 2, …, 9, 10, 20, …, 90, 100, … spacings: level k keeps the last nine samples taken
//! every 10ᵏ samples (after Frenkel & Smit 2002, section 4.4.2), so that memory grows with the
//! logarithm of the longest lag.

use std::collections::VecDeque;

use carom_geometry::{GeometryError, check_positive};
use carom_kinematics::EpochTime;
use serde::{Deserialize, Serialize};

/// The ratio of the sampling intervals of successive levels.
const RATIO: u64 = 10;

/// A limit on the number of spacings, larger than in any run: 10¹⁸.
const MAX_SPACINGS: u64 = RATIO.pow(18);

/// The largest relative deviation of an interval from the spacing, and so the accuracy of the lags.
const EVENNESS: f64 = 1e-6;

/// The sums at one lag over the pairs of one body at t₀ and at t₀ + t.
pub(crate) trait PairSums<S>: Clone {
    /// Adds the pair of what was sampled of one body at two times.
    fn add(&mut self, before: &S, now: &S);

    /// Ends the pairs of one origin t₀: the next pair has another. Default: nothing.
    fn end_origin(&mut self) {}

    /// Whether pairs at this lag count. Default: at each.
    fn is_counted(&self) -> bool {
        true
    }
}

/// The time of the last sample, from which the next one is due after one spacing.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Clock {
    spacing: f64,
    /// The time of the last sample taken.
    last: Option<EpochTime>,
}

/// Sums over the pairs of samples, by lag. `S` is sampled of each body, `T` are the sums.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Lags<S, T> {
    /// The number of samples taken since the last gap.
    taken: u64,
    uneven: u64,
    at_zero: LagSum<T>,
    levels: Vec<Level<S, T>>,
}

/// One body at one time.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct LaggedSample<S> {
    /// Number of the body.
    pub(crate) id: u64,
    /// What is sampled of it.
    pub(crate) state: S,
}

/// The sums at one lag.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct LagSum<T> {
    /// The number of pairs.
    pub(crate) pairs: u64,
    /// The sums over the pairs.
    pub(crate) sums: T,
}

/// The samples taken every `stride` samples, the latest first, and the sums for the lags of 1, 2, …
/// strides.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Level<S, T> {
    stride: u64,
    past: VecDeque<Vec<LaggedSample<S>>>,
    sums: Vec<LagSum<T>>,
}

impl<S: Clone, T: PairSums<S>> Lags<S, T> {
    /// Lags up to `longest` (time) of samples that are `spacing` (time) apart; a `longest` below
    /// one spacing is taken as one spacing.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `spacing` or `longest` is not positive and finite.
    pub(crate) fn new(spacing: f64, longest: f64) -> Result<(Clock, Self), GeometryError>
    where
        T: Default,
    {
        Self::with_sums(spacing, longest, &T::default())
    }

    /// Lags as of [`new`](Self::new), with the sums of no pairs at each lag.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `spacing` or `longest` is not positive and finite.
    pub(crate) fn with_sums(
        spacing: f64,
        longest: f64,
        empty: &T,
    ) -> Result<(Clock, Self), GeometryError> {
        Self::with_sums_by(spacing, longest, |_| empty.clone())
    }

    /// Lags as of [`new`](Self::new), with the sums of no pairs at each lag (spacings).
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `spacing` or `longest` is not positive and finite.
    pub(crate) fn with_sums_by(
        spacing: f64,
        longest: f64,
        empty: impl Fn(u64) -> T,
    ) -> Result<(Clock, Self), GeometryError> {
        let spacing = check_positive("the spacing of samples", spacing)?;
        let longest = check_positive("the longest lag", longest)?;
        let spacings = ((longest / spacing * (1.0 + EVENNESS)) as u64).clamp(1, MAX_SPACINGS);
        let strides = (0..)
            .map(|level| RATIO.pow(level))
            .take_while(|&stride| stride <= spacings);
        let sum = |spacings: u64| LagSum {
            pairs: 0,
            sums: empty(spacings),
        };
        let level = |stride: u64| {
            let lags = (spacings / stride).min(RATIO - 1);
            Level {
                stride,
                past: VecDeque::new(),
                sums: (1..=lags).map(|count| sum(count * stride)).collect(),
            }
        };
        let levels = strides.map(level).collect();
        Ok((
            Clock {
                spacing,
                last: None,
            },
            Self {
                taken: 0,
                uneven: 0,
                at_zero: sum(0),
                levels,
            },
        ))
    }

    /// Each lag (time) and its sums, in ascending order from lag 0 on, also without pairs.
    pub(crate) fn each(&self, clock: &Clock) -> impl Iterator<Item = (f64, &LagSum<T>)> {
        let spacing = clock.spacing;
        self.sums()
            .map(move |(spacings, sum)| (spacings as f64 * spacing, sum))
    }

    /// Each lag (spacings) and its sums.
    fn sums(&self) -> impl Iterator<Item = (u64, &LagSum<T>)> {
        let lags = self.levels.iter().flat_map(|level| {
            let strides = 1..;
            strides
                .zip(&level.sums)
                .map(|(count, sum): (u64, _)| (count * level.stride, sum))
        });
        std::iter::once((0, &self.at_zero)).chain(lags)
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without pairs.
    pub(crate) fn times(&self, clock: &Clock) -> Vec<f64> {
        self.each(clock).map(|(lag, _)| lag).collect()
    }

    /// [Σx, number of pairs] over all samples so far: the first term of the sums at each lag, then
    /// the next at each.
    pub(crate) fn terms<const N: usize>(&self, terms: [fn(&T) -> f64; N]) -> Vec<[f64; 2]> {
        let of_term = |term: fn(&T) -> f64| {
            self.sums()
                .map(move |(_, sum)| [term(&sum.sums), sum.pairs as f64])
        };
        terms.into_iter().flat_map(of_term).collect()
    }

    /// The number of samples that were not one spacing after the previous sample.
    pub(crate) fn uneven(&self) -> u64 {
        self.uneven
    }

    /// Whether to take a sample now; clears the samples before a gap.
    pub(crate) fn is_due(&mut self, clock: &Clock, time: EpochTime) -> bool {
        let Some(last) = clock.last else { return true };
        let late = time.since(last) - clock.spacing;
        if late.abs() <= EVENNESS * clock.spacing {
            return true;
        }
        self.uneven += 1;
        if late > 0.0 {
            self.taken = 0;
            self.levels.iter_mut().for_each(|level| level.past.clear());
        }
        late > 0.0
    }

    /// Takes a sample that [is due](Self::is_due), of bodies in ascending order of number.
    pub(crate) fn take(&mut self, clock: &mut Clock, time: EpochTime, now: &[LaggedSample<S>]) {
        self.at_zero.add(now, now);
        for level in self
            .levels
            .iter_mut()
            .take_while(|level| self.taken.is_multiple_of(level.stride))
        {
            level.take(now);
        }
        clock.last = Some(time);
        self.taken += 1;
    }
}

impl<S: Clone, T: PairSums<S>> Level<S, T> {
    fn take(&mut self, now: &[LaggedSample<S>]) {
        for (sum, past) in self.sums.iter_mut().zip(&self.past) {
            sum.add(past, now);
        }
        // No more than the longest lag that counts.
        let counted = self.sums.iter().rposition(|sum| sum.sums.is_counted());
        let Some(longest) = counted else {
            return;
        };
        // Reuses the memory of the oldest sample.
        let mut sample = if self.past.len() == longest + 1 {
            self.past.pop_back()
        } else {
            None
        }
        .unwrap_or_default();
        sample.clear();
        sample.extend_from_slice(now);
        self.past.push_front(sample);
    }
}

impl<T> LagSum<T> {
    /// Adds the bodies that are in both samples; each sample is in ascending order of number.
    fn add<S>(&mut self, past: &[LaggedSample<S>], now: &[LaggedSample<S>])
    where
        T: PairSums<S>,
    {
        let mut rest = past.iter().peekable();
        for sample in now {
            while rest.next_if(|before| before.id < sample.id).is_some() {}
            if let Some(before) = rest.next_if(|before| before.id == sample.id) {
                self.pairs += 1;
                self.sums.add(&before.state, &sample.state);
            }
        }
        self.sums.end_origin();
    }
}
