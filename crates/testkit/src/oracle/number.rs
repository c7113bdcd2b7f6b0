//! The arithmetic that the oracle needs.

/// Numbers with at least a hundred bits.
pub trait Number: Clone {
    /// True if intervals are first examined in double precision with a bound on rounding.
    const SKETCH_FIRST: bool;

    /// The exact value of a double.
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

    /// Square root of a nonnegative number.
    #[must_use]
    fn root(&self) -> Self;

    /// Cosine and sine of 2π `turns` + `spin` `time`.
    fn cos_sin(turns: f64, spin: f64, time: &Self) -> [Self; 2];
}
