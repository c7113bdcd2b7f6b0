//! The first zero of a gap: intervals of time are excluded or bisected, the earlier half first.

use super::{Number, sketch::Sketch};

/// Result of the search for one pair of parts.
pub enum SearchEnd<N> {
    /// No contact.
    Nothing,
    /// Time of the contact.
    Zero(N),
    /// The limit on intervals was reached.
    OutOfBudget,
}

/// An interval of time before which the gap is positive.
pub struct TimeInterval<N> {
    /// Its begin.
    pub begin: N,
    /// Its middle.
    pub middle: N,
    /// Half its width (time).
    pub half: f64,
}

/// What the full arithmetic says of an interval.
pub enum IntervalVerdict<N> {
    /// It has no zero.
    Free,
    /// It must be bisected.
    Halve,
    /// Its first zero is here.
    Zero(N),
}

/// A gap whose first zero is searched.
pub trait SearchedGap<N: Number> {
    /// A verdict in double precision on the interval around a time.
    fn sketch(&self, middle: f64, half: f64) -> Sketch;

    /// The verdict of the full arithmetic.
    fn look(&self, interval: &TimeInterval<N>) -> IntervalVerdict<N>;

    /// The end of the search where an interval is too short to be bisected.
    fn at_shortest(&self, begin: N) -> SearchEnd<N>;
}

/// Searches the first zero between two times; intervals of a half width up to `shortest` are not
/// bisected.
pub fn first_zero<N: Number>(
    gap: &impl SearchedGap<N>,
    [begin, end]: [f64; 2],
    shortest: f64,
    budget: &mut u64,
) -> SearchEnd<N> {
    let mut rest = vec![(N::new(begin), end - begin)];
    while let Some((begin, width)) = rest.pop() {
        if *budget == 0 {
            return SearchEnd::OutOfBudget;
        }
        *budget -= 1;
        let half = 0.5 * width;
        let middle = begin.plus(&N::new(half));
        let sketch = if N::SKETCH_FIRST {
            gap.sketch(middle.value(), half)
        } else {
            Sketch::Unclear
        };
        let interval = TimeInterval {
            begin,
            middle,
            half,
        };
        let verdict = match sketch {
            Sketch::Free => IntervalVerdict::Free,
            Sketch::Halve => IntervalVerdict::Halve,
            Sketch::Unclear => gap.look(&interval),
        };
        match verdict {
            IntervalVerdict::Free => {}
            IntervalVerdict::Zero(time) => return SearchEnd::Zero(time),
            IntervalVerdict::Halve if half <= shortest => return gap.at_shortest(interval.begin),
            IntervalVerdict::Halve => {
                rest.push((interval.middle, half));
                rest.push((interval.begin, half));
            }
        }
    }
    SearchEnd::Nothing
}
