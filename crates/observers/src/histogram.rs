//! A histogram of equal bins, with a count of the values outside.

use serde::{Deserialize, Serialize};

/// Counts in n equal bins of width w: bin k covers [low + k w, low + (k + 1) w).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Histogram {
    low: f64,
    width: f64,
    counts: Vec<u64>,
    beyond: u64,
}

impl Histogram {
    /// Empty, with at least one bin: `bins` = 0 is taken as 1.
    pub(crate) fn new(low: f64, high: f64, bins: usize) -> Self {
        let bins = bins.max(1);
        Self {
            low,
            width: (high - low) / bins as f64,
            counts: vec![0; bins],
            beyond: 0,
        }
    }

    pub(crate) fn add(&mut self, value: f64) {
        match self.bin_of(value) {
            Some(bin) => self.counts[bin] += 1,
            None => self.beyond += 1,
        }
    }

    /// The bin of a value; `None` outside the bins.
    pub(crate) fn bin_of(&self, value: f64) -> Option<usize> {
        let place = (value - self.low) / self.width;
        // A negative index must not be truncated to bin 0.
        let bin = place as usize;
        (place >= 0.0 && bin < self.counts.len()).then_some(bin)
    }

    /// An empty histogram with these bins.
    pub(crate) fn emptied(&self) -> Self {
        Self {
            counts: vec![0; self.counts.len()],
            beyond: 0,
            ..*self
        }
    }

    /// Adds the counts of a histogram with the same bins.
    pub(crate) fn absorb(&mut self, other: &Self) {
        debug_assert!(
            (self.low, self.width, self.counts.len())
                == (other.low, other.width, other.counts.len())
        );
        for (mine, theirs) in self.counts.iter_mut().zip(&other.counts) {
            *mine += theirs;
        }
        self.beyond += other.beyond;
    }

    /// The count of each bin.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// The number of values outside the bins.
    pub fn beyond(&self) -> u64 {
        self.beyond
    }

    /// The number of all values, including those outside the bins.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum::<u64>() + self.beyond
    }

    /// Width of a bin (unit of the values).
    pub fn width(&self) -> f64 {
        self.width
    }

    /// The lower edge of a bin; for the number of bins, the upper edge of the last one (unit of the
    /// values).
    pub fn edge(&self, bin: usize) -> f64 {
        self.low + bin as f64 * self.width
    }

    /// The centre of a bin (unit of the values).
    pub fn centre(&self, bin: usize) -> f64 {
        self.low + (bin as f64 + 0.5) * self.width
    }

    /// Area of the ring of a bin of distances, π (r₂² − r₁²) = 2π r w with the centre r (unit of
    /// the values, squared).
    pub(crate) fn ring_area(&self, bin: usize) -> f64 {
        std::f64::consts::TAU * self.centre(bin) * self.width
    }

    /// Probability density in each bin, counts / (total × width), in 1 / unit of the values; all 0
    /// without values.
    pub fn densities(&self) -> Vec<f64> {
        let norm = self.total().max(1) as f64 * self.width;
        self.counts
            .iter()
            .map(|&count| count as f64 / norm)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_are_half_open_and_count_every_value() {
        let mut histogram = Histogram::new(-1.0, 1.0, 4);
        for value in [
            -1.0,
            -0.5,
            -0.25,
            0.0,
            0.999,
            1.0,
            -1.001,
            f64::NAN,
            f64::INFINITY,
            1e300,
        ] {
            histogram.add(value);
        }
        assert_eq!(
            (histogram.counts(), histogram.beyond()),
            ([1, 2, 1, 1].as_slice(), 5)
        );
        assert_eq!((histogram.total(), histogram.width()), (10, 0.5));
        assert_eq!(
            (histogram.edge(0), histogram.centre(1), histogram.edge(4)),
            (-1.0, -0.25, 1.0)
        );
        assert_eq!(histogram.densities(), [0.2, 0.4, 0.2, 0.2]);
        let mut twice = histogram.clone();
        twice.absorb(&histogram);
        assert_eq!(
            (twice.counts(), twice.beyond()),
            ([2, 4, 2, 2].as_slice(), 10)
        );
        assert_eq!(Histogram::new(0.0, 1.0, 0).densities(), [0.0]);
    }
}
