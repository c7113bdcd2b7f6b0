//! The golden-section search for the minimum of a function (Kiefer 1953).

use crate::SearchWindow;

/// 1/φ, φ = (1 + √5)/2.
const INVERSE_GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;

/// The value of a function at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SectionSample {
    pub(crate) time: f64,
    pub(crate) value: f64,
}

impl SectionSample {
    pub(crate) fn lower(self, other: Self) -> Self {
        if other.value < self.value {
            other
        } else {
            self
        }
    }
}

/// The minimum of `f` inside `interval`, to `width` (time); `None` if `most_rounds` do not suffice.
///
/// Algorithm 5 of Montanari (2017) computes both inner points anew in every round. This function
/// keeps one, as in Kiefer's method, with one evaluation per round. `f` must fall and then rise;
/// for another function the result is some low value. A minimum is flat, so its time is accurate to
/// about √(rounding of f / f''), however small `width` is.
pub(crate) fn golden_section(
    mut f: impl FnMut(f64) -> f64,
    interval: SearchWindow,
    width: f64,
    most_rounds: u32,
) -> Option<SectionSample> {
    let SearchWindow {
        begin: mut a,
        end: mut b,
    } = interval;
    let mut at = |time| SectionSample {
        time,
        value: f(time),
    };
    let left = |a: f64, b: f64| b - (b - a) * INVERSE_GOLDEN_RATIO;
    let right = |a: f64, b: f64| a + (b - a) * INVERSE_GOLDEN_RATIO;
    let (mut c, mut d) = (at(left(a, b)), at(right(a, b)));
    for _ in 0..most_rounds {
        if d.time - c.time <= width {
            return Some(c.lower(d));
        }
        if c.value < d.value {
            b = d.time;
            d = c;
            c = at(left(a, b));
        } else {
            a = c.time;
            c = d;
            d = at(right(a, b));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn finds_a_planted_minimum(place in 0.0..1.0f64, curvature in 0.01..100.0f64) {
            let f = |t: f64| curvature * (t - place) * (t - place);
            let found = golden_section(f, SearchWindow { begin: 0.0, end: 1.0 }, 1e-15, 200).unwrap();
            prop_assert!((found.time - place).abs() < 1e-14);
        }
    }

    #[test]
    fn a_minimum_at_an_end_is_approached() {
        let found = golden_section(
            |t| t,
            SearchWindow {
                begin: 1.0,
                end: 2.0,
            },
            1e-15,
            200,
        )
        .unwrap();
        assert!(found.time - 1.0 < 3e-15);
    }

    #[test]
    fn one_evaluation_a_round_and_rounds_are_bounded() {
        let mut evaluations = 0;
        let count = |t: f64| {
            evaluations += 1;
            t * t
        };
        assert_eq!(
            golden_section(
                count,
                SearchWindow {
                    begin: -1.0,
                    end: 2.0
                },
                -1.0,
                30
            ),
            None
        );
        assert_eq!(evaluations, 32);
    }
}
