//! The bracketed secant method: the zero of a function between a positive and a negative value.

use crate::golden_section::SectionSample;

/// Two times between which a function falls through zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bracket {
    positive: SectionSample,
    negative: SectionSample,
}

impl Bracket {
    /// Returns `None` unless the signs differ.
    pub(crate) fn new(positive: SectionSample, negative: SectionSample) -> Option<Self> {
        (positive.value > 0.0 && negative.value < 0.0).then_some(Self { positive, negative })
    }

    fn width(&self) -> f64 {
        (self.negative.time - self.positive.time).abs()
    }

    fn nearer_zero(&self) -> f64 {
        if self.positive.value <= -self.negative.value {
            self.positive.time
        } else {
            self.negative.time
        }
    }
}

/// The time at which `f` is zero, to `width` (time); `None` if `most_rounds` do not suffice.
///
/// Secant of the ends of the bracket in the Illinois form (Dowell and Jarratt 1971), which halves
/// the value at an end that is kept, so that both ends converge with order 1.44. The secant of
/// Montanari (2017), equation A.3, keeps the last two points irrespective of their signs, and can
/// converge to another zero. New points keep a distance of half of `width` from the ends, so that
/// the last round closes the bracket. Three rounds that do not halve the bracket are followed by a
/// bisection, so that 250 rounds suffice for every function.
pub(crate) fn bracketed_secant(
    mut f: impl FnMut(f64) -> f64,
    mut bracket: Bracket,
    width: f64,
    most_rounds: u32,
) -> Option<f64> {
    let (mut positive_weight, mut negative_weight) =
        (bracket.positive.value, bracket.negative.value);
    let mut last_sign = 0.0;
    let (mut checked_width, mut rounds_since) = (bracket.width(), 0);
    for _ in 0..most_rounds {
        if bracket.width() <= width {
            return Some(bracket.nearer_zero());
        }
        let (start, span) = (
            bracket.positive.time,
            bracket.negative.time - bracket.positive.time,
        );
        let margin = (0.5 * width / span.abs()).clamp(0.0, 0.5);
        let fraction = if rounds_since == 3 {
            0.5
        } else {
            (positive_weight / (positive_weight - negative_weight)).clamp(margin, 1.0 - margin)
        };
        let time = start + span * fraction;
        let value = f(time);
        if value == 0.0 {
            return Some(time);
        }
        let repeated = value.signum() == last_sign;
        last_sign = value.signum();
        let sample = SectionSample { time, value };
        if value > 0.0 {
            (bracket.positive, positive_weight) = (sample, value);
            negative_weight *= if repeated { 0.5 } else { 1.0 };
        } else {
            (bracket.negative, negative_weight) = (sample, value);
            positive_weight *= if repeated { 0.5 } else { 1.0 };
        }
        rounds_since += 1;
        if bracket.width() <= 0.5 * checked_width || rounds_since > 3 {
            (checked_width, rounds_since) = (bracket.width(), 0);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn zero_between(f: impl Fn(f64) -> f64, ends: (f64, f64), most_rounds: u32) -> Option<f64> {
        let at = |time| SectionSample {
            time,
            value: f(time),
        };
        let bracket = Bracket::new(at(ends.0), at(ends.1)).unwrap();
        bracketed_secant(&f, bracket, 5.0 * f64::EPSILON, most_rounds)
    }

    proptest! {
        #[test]
        fn finds_a_planted_zero(place in 0.001..0.999f64, power in 1..9, either_way in prop::bool::ANY) {
            let f = |t: f64| (place - t) * (1.0 + t).powi(power);
            let mirrored = |t: f64| f(-t);
            let found = if either_way {
                zero_between(f, (0.0, 1.0), 60).unwrap()
            } else {
                -zero_between(mirrored, (0.0, -1.0), 60).unwrap()
            };
            prop_assert!((found - place).abs() < 3e-15);
        }

        #[test]
        fn steps_and_flat_zeros_take_a_bounded_number_of_rounds(place in 0.001..0.999f64, power in 0..12) {
            // power 0: a jump; odd powers: a flat zero; even powers: multiplied by a sign to change
            // it.
            let f = |t: f64| (place - t).signum() * (place - t).abs().powi(power) * 1e-3;
            let found = zero_between(f, (0.0, 1.0), 250).unwrap();
            prop_assert!((found - place).abs() <= 6.0 * f64::EPSILON || f(found) == 0.0);
        }
    }

    #[test]
    fn a_simple_zero_takes_about_ten_rounds() {
        let mut rounds = 0;
        let mut f = |t: f64| {
            rounds += 1;
            0.5 - t.exp_m1()
        };
        let ends = [0.0, 1.0].map(|time| SectionSample {
            time,
            value: f(time),
        });
        let bracket = Bracket::new(ends[0], ends[1]).unwrap();
        let found = bracketed_secant(f, bracket, 5.0 * f64::EPSILON, 250).unwrap();
        assert!((found - 1.5f64.ln()).abs() < 1e-15);
        assert!(rounds <= 12, "{rounds}");
    }

    #[test]
    fn without_a_change_of_sign_there_is_no_bracket() {
        let at = |value| SectionSample { time: 0.0, value };
        assert!(Bracket::new(at(1.0), at(1.0)).is_none());
        assert!(Bracket::new(at(-1.0), at(1.0)).is_none());
        assert!(Bracket::new(at(f64::NAN), at(-1.0)).is_none());
    }
}
