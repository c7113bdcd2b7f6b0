//! Averages of repeated measurements, such as times of rounds.

/// Median, of an even number the upper one; sorts the values. `None` if there are none.
pub fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Geometric mean of positive values; `None` if there are none.
pub fn geometric_mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values
        .into_iter()
        .fold((0u32, 0.0), |(count, sum), value: f64| {
            (count + 1, sum + value.ln())
        });
    (count > 0).then(|| (sum / f64::from(count)).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averages_of_a_few_values() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), Some(3.0));
        assert!((geometric_mean([1.0, 4.0]).unwrap() - 2.0).abs() < 1e-15);
        assert_eq!((median(&mut []), geometric_mean([])), (None, None));
    }
}
