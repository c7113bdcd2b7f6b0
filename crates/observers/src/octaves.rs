//! Counts of values of any size in bins whose widths are powers of two.
//!
//! m bins of the width w cover [0, m w); each of the octaves that follow, [m w 2ʲ⁻¹, m w 2ʲ), has
//! m/2 bins of the width w 2ʲ. Such bins are nested: joining the pairs among the first m gives
//! those of the width 2w, and every other bin stays. So counts move to wider bins without error,
//! and the result depends on the values alone, not on their order.

use serde::{Deserialize, Serialize};

/// Octaves × bins are limited by 2^17: about as many counts are kept for one sign at most.
const MAX_LOG_BINS: i32 = 17;

/// Largest number of octaves below the largest value with bins of their own: speeds that differ by
/// a factor of 4096 are resolved equally well.
const MAX_OCTAVES: i32 = 12;

/// The width of a bin is a positive `f64`: 2^−1074 at least.
const MIN_EXPONENT: i32 = -1074;

/// Bins of equal width cover the magnitudes up to this multiple of their median at least, if any
/// are as large: some 5 standard deviations of a Gaussian distribution.
const MEDIANS: u64 = 8;

/// Counts of the magnitudes of positive and negative values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Octaves {
    /// Bins of equal width from 0 on, an even number.
    bins: usize,
    /// Log₂ of their width; `None` before the first value other than 0. It depends on the largest
    /// magnitude only.
    exponent: Option<i32>,
    /// Counts of each sign, up to the last occupied bin. The value 0 counts as positive.
    counts: [Vec<u64>; 2],
}

/// The exponent of the width of equal bins, and the number of bins shown for each sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ShownOctaves {
    pub exponent: i32,
    pub rows: usize,
}

impl Octaves {
    /// No counts; `bins` bins of equal width for each sign, rounded up to an even number.
    pub fn new(bins: usize) -> Self {
        let bins = bins.max(1).next_multiple_of(2);
        Self {
            bins,
            exponent: None,
            counts: [Vec::new(), Vec::new()],
        }
    }

    pub fn emptied(&self) -> Self {
        Self::new(self.bins)
    }

    /// Counts a finite value.
    pub fn add(&mut self, value: f64) {
        let magnitude = value.abs();
        if magnitude > 0.0 {
            self.widen(self.finest(magnitude));
        }
        let exponent = self.exponent.unwrap_or(0);
        let bin = self.bin_of(libm::scalbn(magnitude, -exponent) as usize);
        let counts = &mut self.counts[usize::from(value < 0.0)];
        counts.resize(counts.len().max(bin + 1), 0);
        counts[bin] += 1;
    }

    /// Adds the counts of another with as many bins.
    pub fn absorb(&mut self, other: &Self) {
        debug_assert_eq!(self.bins, other.bins);
        let mut other = other.clone();
        if let Some(exponent) = other.exponent {
            self.widen(exponent);
        }
        if let Some(exponent) = self.exponent {
            other.widen(exponent);
        }
        for (mine, theirs) in self.counts.iter_mut().zip(&other.counts) {
            mine.resize(mine.len().max(theirs.len()), 0);
            mine.iter_mut()
                .zip(theirs)
                .for_each(|(sum, count)| *sum += count);
        }
    }

    pub fn total(&self) -> u64 {
        self.counts.iter().flatten().sum()
    }

    /// The widest bins of equal width that are needed: they cover all values, or at least
    /// [`MEDIANS`] medians of the magnitudes. At least `least` bins of each sign are shown. `None`
    /// before the first value other than 0.
    pub fn shown(&self, least: usize) -> Option<ShownOctaves> {
        let finest = self.exponent?;
        let last = self.counts.iter().map(Vec::len).max()?.checked_sub(1)?;
        let doublings = self.octave(last).min(self.doublings_of_median());
        let exponent = finest + doublings as i32;
        let rows = self.at(exponent).iter().map(Vec::len).max()?;
        Some(ShownOctaves {
            exponent,
            rows: rows.max(least),
        })
    }

    /// Counts of both signs, from 0 outwards, in the bins shown.
    pub fn counts_in(&self, shown: ShownOctaves) -> [Vec<u64>; 2] {
        let mut counts = self.at(shown.exponent);
        for side in &mut counts {
            side.resize(shown.rows, 0);
        }
        counts
    }

    /// The edges of the bins shown, from 0 outwards.
    pub fn edges(&self, shown: ShownOctaves) -> Vec<f64> {
        let edge = |bin: usize| libm::scalbn(self.lower(bin) as f64, shown.exponent);
        (0..=shown.rows).map(edge).collect()
    }

    /// The counts with bins of a width that is no smaller.
    fn at(&self, exponent: i32) -> [Vec<u64>; 2] {
        let mut wider = self.clone();
        wider.widen(exponent);
        wider.counts
    }

    /// Joins bins until their width is at least 2 to this power.
    fn widen(&mut self, exponent: i32) {
        let from = *self.exponent.get_or_insert(exponent);
        for _ in from..exponent {
            for counts in self.counts.iter_mut().filter(|counts| counts.len() > 1) {
                let outer = counts.split_off(counts.len().min(self.bins));
                *counts = counts.chunks(2).map(|pair| pair.iter().sum()).collect();
                counts.extend(outer);
            }
        }
        self.exponent = Some(from.max(exponent));
    }

    /// The exponent of the finest bins if this is the largest magnitude: it lies in the last
    /// octave.
    fn finest(&self, magnitude: f64) -> i32 {
        let octaves = (MAX_LOG_BINS - self.bins.ilog2() as i32).clamp(0, MAX_OCTAVES);
        let (mantissa, exponent) = libm::frexp(magnitude);
        let (mantissa_of_bins, exponent_of_bins) = libm::frexp(self.bins as f64);
        // The smallest power of two whose product with the number of bins exceeds the magnitude.
        let covering = exponent - exponent_of_bins + i32::from(mantissa >= mantissa_of_bins);
        (covering - octaves).max(MIN_EXPONENT)
    }

    /// The bin of a magnitude in units of the width, rounded down.
    fn bin_of(&self, units: usize) -> usize {
        if units < self.bins {
            return units;
        }
        let octave = (units / self.bins).ilog2() as usize + 1;
        self.bins + (octave - 1) * (self.bins / 2) + (units >> octave) - self.bins / 2
    }

    /// The number of the octave of a bin; 0 for one of the first, which have equal widths.
    fn octave(&self, bin: usize) -> usize {
        (bin + 1).saturating_sub(self.bins).div_ceil(self.bins / 2)
    }

    /// The lower edge of a bin in units of the width.
    fn lower(&self, bin: usize) -> usize {
        let octave = self.octave(bin);
        (bin - octave * (self.bins / 2)) << octave
    }

    /// How often the width doubles until the first bins cover [`MEDIANS`] medians. Values in the
    /// very first bin count as 0, which says nothing of the width.
    fn doublings_of_median(&self) -> usize {
        let side = |sign: usize, bin: usize| self.counts[sign].get(bin).copied().unwrap_or(0);
        let last = self.counts.iter().map(Vec::len).max().unwrap_or(0);
        let all: u64 = (1..last).map(|bin| side(0, bin) + side(1, bin)).sum();
        let mut below = 0;
        let median = (1..last).find(|&bin| {
            below += side(0, bin) + side(1, bin);
            2 * below >= all
        });
        let upper = median.map_or(1, |bin| self.lower(bin + 1)) as u64;
        let covered = (MEDIANS * upper).div_ceil(self.bins as u64).max(1);
        covered.next_power_of_two().ilog2() as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_are_contiguous_and_hold_their_values() {
        for bins in [2, 6, 60] {
            let octaves = Octaves::new(bins);
            for units in 0..5000 {
                let bin = octaves.bin_of(units);
                assert!(
                    (octaves.lower(bin)..octaves.lower(bin + 1)).contains(&units),
                    "{bins} {units}"
                );
                let width = octaves.lower(bin + 1) - octaves.lower(bin);
                assert_eq!(width, 1 << octaves.octave(bin), "{bins} {units}");
            }
        }
    }

    #[test]
    fn counts_do_not_depend_on_the_order_of_values_and_blocks() {
        let values: Vec<f64> = (0..3000)
            .map(|k| f64::from(k % 7 - 3) * f64::from(k + 1) * libm::scalbn(1.0, k % 41 - 30))
            .chain([0.0, 1e-300, -1e-310])
            .collect();
        let of = |values: &[f64]| {
            let mut octaves = Octaves::new(10);
            for &value in values {
                octaves.add(value);
            }
            octaves
        };
        let expected = of(&values);
        let reversed: Vec<f64> = values.iter().rev().copied().collect();
        assert_eq!(of(&reversed), expected);
        for size in [1, 17, 900] {
            let mut sum = expected.emptied();
            reversed
                .chunks(size)
                .for_each(|block| sum.absorb(&of(block)));
            assert_eq!(sum, expected);
        }
        assert_eq!(expected.total(), 3003);
        let shown = expected.shown(10).unwrap();
        assert_eq!(
            expected.counts_in(shown).iter().flatten().sum::<u64>(),
            3003
        );
    }

    #[test]
    fn wider_bins_have_the_counts_of_values_counted_in_them() {
        let mut octaves = Octaves::new(4);
        (1..=40).for_each(|k| octaves.add(f64::from(k) + 0.5));
        let shown = ShownOctaves {
            exponent: 3,
            rows: 6,
        };
        assert_eq!(
            octaves.edges(shown),
            [0.0, 8.0, 16.0, 24.0, 32.0, 48.0, 64.0]
        );
        assert_eq!(
            octaves.counts_in(shown),
            [vec![7, 8, 8, 8, 9, 0], vec![0; 6]]
        );
    }
}
