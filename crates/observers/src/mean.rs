//! Mean of a series and its standard error s / √n, with s² = Σ (x − x̄)² / (n − 1).

/// Mean and standard error of independent values; `None` with fewer than two.
pub(crate) fn mean_and_standard_error(
    values: impl ExactSizeIterator<Item = f64> + Clone,
) -> Option<(f64, f64)> {
    let count = values.len() as f64;
    if count < 2.0 {
        return None;
    }
    let mean = values.clone().sum::<f64>() / count;
    let squares: f64 = values.map(|value| (value - mean) * (value - mean)).sum();
    Some((mean, (squares / (count - 1.0) / count).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_of_one_to_five() {
        // s² = 10/4, so the standard error is √(2.5/5).
        let (mean, error) = mean_and_standard_error([1.0, 2.0, 3.0, 4.0, 5.0].into_iter()).unwrap();
        assert_eq!((mean, error), (3.0, 0.5f64.sqrt()));
        assert_eq!(mean_and_standard_error([7.0].into_iter()), None);
    }
}
