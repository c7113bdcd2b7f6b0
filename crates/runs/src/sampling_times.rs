//! The times at which a run is sampled.

/// Returns the sampling times after `begin`: whole multiples of `interval` from it, and `end`.
///
/// Each is a product, not a sum of intervals, so rounding does not accumulate.
pub fn sampling_times(begin: f64, end: f64, interval: f64) -> impl Iterator<Item = f64> {
    let count = sampling_count(begin, end, interval);
    (1..=count).map(move |index| sampling_time(begin, end, interval, index, count))
}

/// Number of sampling times.
pub fn sampling_count(begin: f64, end: f64, interval: f64) -> u64 {
    // A last interval shorter than this share of a full one is rounding error.
    ((end - begin) / interval - 1e-9).ceil().max(0.0) as u64
}

/// The sampling time `index` of `count`, from 1 on.
pub fn sampling_time(begin: f64, end: f64, interval: f64, index: u64, count: u64) -> f64 {
    if index == count {
        end
    } else {
        begin + index as f64 * interval
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_sample_is_the_end() {
        assert_eq!(
            sampling_times(0.0, 1.0, 0.5).collect::<Vec<_>>(),
            [0.5, 1.0]
        );
        assert_eq!(
            sampling_times(1.0, 2.1, 0.5).collect::<Vec<_>>(),
            [1.5, 2.0, 2.1]
        );
        assert_eq!(
            sampling_times(0.0, 0.3, 0.1).collect::<Vec<_>>(),
            [0.1, 0.2, 0.3]
        );
        assert_eq!(sampling_times(0.0, 0.2, 1.0).collect::<Vec<_>>(), [0.2]);
        assert_eq!(sampling_times(1.0, 1.0, 0.5).count(), 0);
        assert_eq!(sampling_times(0.0, 4900.0, 0.1).count(), 49_000);
    }
}
