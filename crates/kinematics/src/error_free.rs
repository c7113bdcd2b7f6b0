//! Sums and products of two floats together with what rounding takes from them.

/// The sum of two floats as its rounded value and the exact rest (Knuth, TAOCP vol. 2, 4.2.2).
#[inline]
pub fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// The product of two floats as its rounded value and the exact rest, unless that is below the smallest float.
///
/// The fused multiply-add is exact by definition here, hence the same on every processor.
#[inline]
pub fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_is_what_rounding_takes() {
        let tiny = f64::EPSILON;
        assert_eq!(two_sum(1.0, 0.25 * tiny), (1.0, 0.25 * tiny));
        assert_eq!(two_sum(0.25 * tiny, 1.0), (1.0, 0.25 * tiny));
        // (1 + ε)² = 1 + 2ε + ε²
        assert_eq!(two_product(1.0 + tiny, 1.0 + tiny), (1.0 + 2.0 * tiny, tiny * tiny));
    }
}
