//! Error-free transformations: sums and products of two floats with their rounding errors.

/// The sum of two floats as its rounded value and the exact remainder (Knuth, TAOCP vol. 2, 4.2.2).
#[inline]
pub fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// The product of two floats as its rounded value and the exact remainder, unless that underflows.
///
/// The fused multiply-add is exact by definition and hence the same on every processor.
#[inline]
pub fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_remainder_is_the_rounding_error() {
        let tiny = f64::EPSILON;
        assert_eq!(two_sum(1.0, 0.25 * tiny), (1.0, 0.25 * tiny));
        assert_eq!(two_sum(0.25 * tiny, 1.0), (1.0, 0.25 * tiny));
        // (1 + ε)² = 1 + 2ε + ε²
        assert_eq!(
            two_product(1.0 + tiny, 1.0 + tiny),
            (1.0 + 2.0 * tiny, tiny * tiny)
        );
    }
}
