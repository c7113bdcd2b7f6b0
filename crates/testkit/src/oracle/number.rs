//! What the oracle asks of an arithmetic.

/// Numbers with at least a hundred bits.
pub trait Number: Clone {
    /// Whether intervals are first looked at in doubles, whose rounding is then allowed for.
    const SKETCH_FIRST: bool;

    /// The number that a double is.
    fn new(value: f64) -> Self;

    /// The nearest double.
    fn value(&self) -> f64;

    /// Sum.
    #[must_use]
    fn plus(&self, other: &Self) -> Self;

    /// Difference.
    #[must_use]
    fn minus(&self, other: &Self) -> Self;

    /// Product.
    #[must_use]
    fn times(&self, other: &Self) -> Self;

    /// Quotient.
    #[must_use]
    fn over(&self, other: &Self) -> Self;

    /// Square root of a number that is not negative.
    #[must_use]
    fn root(&self) -> Self;

    /// Cosine and sine of 2π `turns` + `spin` `time`.
    fn cos_sin(turns: f64, spin: f64, time: &Self) -> [Self; 2];
}
