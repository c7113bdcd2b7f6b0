//! Numerical integration along a piece of a boundary.

/// Returns the sum over `pieces` equal intervals of the mean of a function on each, by the
/// three-point Gauss rule. Times `step`, the length of an interval, it is the integral from `from`.
pub(crate) fn sum_of_means(
    from: f64,
    step: f64,
    pieces: usize,
    function: impl Fn(f64) -> f64,
) -> f64 {
    let offset = 0.6f64.sqrt();
    let mean = |index: usize| {
        let middle = from + (index as f64 + 0.5) * step;
        let at = |node: f64| function(middle + 0.5 * step * node);
        (5.0 * (at(-offset) + at(offset)) + 8.0 * at(0.0)) / 18.0
    };
    (0..pieces).map(mean).sum()
}
