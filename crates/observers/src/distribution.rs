//! The distribution of a quantity over its samples, in bins of a given range or of one that follows
//! the data.

use serde::{Deserialize, Serialize};

use crate::{
    Histogram,
    octaves::{Octaves, ShownOctaves},
};

/// Counts of values in bins.
///
/// In a given range bins have equal widths, and values outside are counted as such. Without a
/// range, no finite value is outside. The widths of the bins are then powers of two: equal widths
/// in a range that holds all values, or, if a few values are far larger than most, the bulk of
/// them; beyond it the width doubles with each octave. Counts depend on the values alone, not on
/// their order, and are exact, whichever bins are shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AdaptiveHistogram {
    /// Smallest number of bins of each sign that are shown.
    least: usize,
    range: Range,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Range {
    Given(Histogram),
    /// Values of both signs.
    Components(Following),
    /// Values that are not negative.
    Magnitudes(Following),
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Following {
    octaves: Octaves,
    /// Number of values that are not finite, or negative if they must not be.
    beyond: u64,
}

/// The bins in which an [`AdaptiveHistogram`] is shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Bins {
    edges: Vec<f64>,
    shown: Option<ShownOctaves>,
}

impl Bins {
    /// Edges of the bins in ascending order (unit of the values), one more than bins; empty before
    /// the first value of a range that follows the data.
    pub fn edges(&self) -> &[f64] {
        &self.edges
    }

    /// Number of bins.
    pub fn count(&self) -> usize {
        self.edges.len().saturating_sub(1)
    }

    /// Means of a density over each bin, from its integral up to each edge.
    pub fn means_of(&self, integral: impl Fn(f64) -> f64) -> Vec<f64> {
        self.edges
            .windows(2)
            .map(|bin| (integral(bin[1]) - integral(bin[0])) / (bin[1] - bin[0]))
            .collect()
    }
}

impl AdaptiveHistogram {
    /// Equal bins from `low` to `high`; `bins` = 0 is taken as 1.
    pub(crate) fn within(low: f64, high: f64, bins: usize) -> Self {
        Self {
            least: bins.max(1),
            range: Range::Given(Histogram::new(low, high, bins)),
        }
    }

    /// A range that follows values of both signs, with at least `bins` bins for each sign; `bins` =
    /// 0 is taken as 1.
    pub fn of_components(bins: usize) -> Self {
        Self {
            least: bins.max(1),
            range: Range::Components(Following::new(bins)),
        }
    }

    /// A range that follows values that are not negative, with at least `bins` bins; `bins` = 0 is
    /// taken as 1.
    pub fn of_magnitudes(bins: usize) -> Self {
        Self {
            least: bins.max(1),
            range: Range::Magnitudes(Following::new(bins)),
        }
    }

    /// Counts a value.
    pub fn add(&mut self, value: f64) {
        match &mut self.range {
            Range::Given(histogram) => histogram.add(value),
            Range::Components(following) => following.add(value, value.is_finite()),
            Range::Magnitudes(following) => following.add(value, value.is_finite() && value >= 0.0),
        }
    }

    /// No counts, in a range of the same kind.
    #[must_use]
    pub fn emptied(&self) -> Self {
        let range = match &self.range {
            Range::Given(histogram) => Range::Given(histogram.emptied()),
            Range::Components(following) => Range::Components(following.emptied()),
            Range::Magnitudes(following) => Range::Magnitudes(following.emptied()),
        };
        Self {
            least: self.least,
            range,
        }
    }

    /// Adds the counts of a distribution with as many bins and a range of the same kind. One of
    /// another kind adds nothing.
    pub fn absorb(&mut self, other: &Self) {
        match (&mut self.range, &other.range) {
            (Range::Given(mine), Range::Given(theirs)) => mine.absorb(theirs),
            (Range::Components(mine), Range::Components(theirs))
            | (Range::Magnitudes(mine), Range::Magnitudes(theirs)) => mine.absorb(theirs),
            _ => debug_assert!(false, "ranges of one kind"),
        }
    }

    /// Whether the range was given, so that values may lie outside.
    pub fn has_given_range(&self) -> bool {
        matches!(self.range, Range::Given(_))
    }

    /// Number of all values, including those outside the range.
    pub fn total(&self) -> u64 {
        match &self.range {
            Range::Given(histogram) => histogram.total(),
            Range::Components(following) | Range::Magnitudes(following) => {
                following.octaves.total() + following.beyond
            }
        }
    }

    /// Number of values outside a given range, or without a finite magnitude.
    pub fn beyond(&self) -> u64 {
        match &self.range {
            Range::Given(histogram) => histogram.beyond(),
            Range::Components(following) | Range::Magnitudes(following) => following.beyond,
        }
    }

    /// The bins for the values so far.
    pub fn bins(&self) -> Bins {
        let of = |octaves: &Octaves| {
            octaves
                .shown(self.least)
                .map(|shown| (shown, octaves.edges(shown)))
        };
        let following = match &self.range {
            Range::Given(histogram) => {
                let edges = (0..=histogram.counts().len())
                    .map(|bin| histogram.edge(bin))
                    .collect();
                return Bins { edges, shown: None };
            }
            Range::Components(following) => of(&following.octaves).map(|(shown, edges)| {
                let negative = edges.iter().skip(1).rev().map(|edge| -edge);
                (shown, negative.chain(edges.iter().copied()).collect())
            }),
            Range::Magnitudes(following) => of(&following.octaves),
        };
        let (shown, edges) = following.unzip();
        Bins {
            edges: edges.unwrap_or_default(),
            shown,
        }
    }

    /// The bins for the values of several distributions, whose ranges must be of one kind.
    pub fn common_bins(distributions: &[&Self]) -> Bins {
        let mut all = distributions
            .iter()
            .map(|&distribution| distribution.clone());
        let Some(mut sum) = all.next() else {
            return Bins {
                edges: Vec::new(),
                shown: None,
            };
        };
        all.for_each(|distribution| sum.absorb(&distribution));
        sum.bins()
    }

    /// Counts in bins: its own, or those of a distribution that has absorbed it.
    pub fn counts_in(&self, bins: &Bins) -> Vec<u64> {
        match (&self.range, bins.shown) {
            (Range::Given(histogram), _) => histogram.counts().to_vec(),
            (Range::Components(_) | Range::Magnitudes(_), None) => Vec::new(),
            (Range::Components(following), Some(shown)) => {
                let [positive, negative] = following.octaves.counts_in(shown);
                negative.into_iter().rev().chain(positive).collect()
            }
            (Range::Magnitudes(following), Some(shown)) => {
                let [positive, _] = following.octaves.counts_in(shown);
                positive
            }
        }
    }

    /// Counts in its own bins.
    pub fn counts(&self) -> Vec<u64> {
        self.counts_in(&self.bins())
    }

    /// [Σx, Σw] of each bin, whose ratio is the mean probability density in the bin (1 / unit of
    /// the values): its count over its width, and the number of all values, also outside a given
    /// range.
    pub fn sums_in(&self, bins: &Bins) -> Vec<[f64; 2]> {
        let total = self.total() as f64;
        let counts = self.counts_in(bins);
        let widths = bins.edges.windows(2).map(|bin| bin[1] - bin[0]);
        counts
            .into_iter()
            .zip(widths)
            .map(|(count, width)| [count as f64 / width, total])
            .collect()
    }
}

impl Following {
    fn new(bins: usize) -> Self {
        Self {
            octaves: Octaves::new(bins),
            beyond: 0,
        }
    }

    fn emptied(&self) -> Self {
        Self {
            octaves: self.octaves.emptied(),
            beyond: 0,
        }
    }

    fn add(&mut self, value: f64, is_valid: bool) {
        if is_valid {
            self.octaves.add(value);
        } else {
            self.beyond += 1;
        }
    }

    fn absorb(&mut self, other: &Self) {
        self.octaves.absorb(&other.octaves);
        self.beyond += other.beyond;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values k / 1000 × scale.
    fn filled(mut distribution: AdaptiveHistogram, scale: f64) -> AdaptiveHistogram {
        (-999..=999).for_each(|k| distribution.add(scale * f64::from(k) / 1000.0));
        distribution
    }

    fn integral(distribution: &AdaptiveHistogram) -> f64 {
        let bins = distribution.bins();
        let widths = bins.edges().windows(2).map(|bin| bin[1] - bin[0]);
        distribution
            .sums_in(&bins)
            .iter()
            .zip(widths)
            .map(|([x, w], width)| x / w * width)
            .sum()
    }

    #[test]
    fn a_range_that_follows_the_data_loses_no_value() {
        for scale in [1e-100, 3e-7, 1.0, 77.0, 1e100] {
            let found = filled(AdaptiveHistogram::of_components(10), scale);
            assert_eq!(
                (found.counts().len(), found.total(), found.beyond()),
                (20, 1999, 0)
            );
            assert!((integral(&found) - 1.0).abs() < 1e-14, "{scale}");
            // The bins are at most twice as wide as needed.
            let bins = found.bins();
            assert!(
                bins.edges()[20] > 0.999 * scale && bins.edges()[20] < 2.0 * scale,
                "{bins:?}"
            );
        }
    }

    #[test]
    fn values_that_shrink_by_a_factor_are_still_resolved() {
        let mut found = filled(AdaptiveHistogram::of_components(60), 1000.0);
        (0..20).for_each(|_| found.absorb(&filled(AdaptiveHistogram::of_components(60), 1.0)));
        let bins = found.bins();
        assert!((integral(&found) - 1.0).abs() < 1e-14);
        assert_eq!(found.counts().iter().sum::<u64>(), 21 * 1999);
        let inside = bins.edges().iter().filter(|edge| edge.abs() < 1.0).count();
        assert!((8..=60).contains(&inside), "{bins:?}");
        assert!(*bins.edges().last().unwrap() >= 999.0);
    }

    #[test]
    fn a_given_range_counts_what_lies_outside() {
        let found = filled(AdaptiveHistogram::within(-0.5, 0.5, 10), 1.0);
        assert_eq!((found.total(), found.beyond()), (1999, 999));
        assert!((integral(&found) - 1000.0 / 1999.0).abs() < 1e-12);
        assert!(found.has_given_range() && found.counts().len() == 10);
    }

    #[test]
    fn values_that_are_no_magnitudes_are_counted_outside() {
        let mut speeds = AdaptiveHistogram::of_magnitudes(4);
        assert!(speeds.bins().edges().is_empty() && speeds.counts().is_empty());
        for value in [0.0, 1.0, -1.0, f64::NAN, f64::INFINITY] {
            speeds.add(value);
        }
        assert_eq!(
            (speeds.total(), speeds.beyond(), speeds.counts()),
            (5, 3, vec![1, 0, 1, 0])
        );
    }
}
