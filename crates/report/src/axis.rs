//! An axis of a chart: its range, where its numbers stand, and what they say.

/// An axis: quantity and unit, range, and how values are placed.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// First and last value; of names, indices.
    pub range: (f64, f64),
    /// How values are placed.
    pub scale: Scale,
}

/// How values are placed along an axis.
#[derive(Debug, Clone, PartialEq)]
pub enum Scale {
    /// In proportion.
    Linear,
    /// By their logarithms; they are positive.
    Logarithmic,
    /// Names; a value is the index of one.
    Names(Vec<String>),
}

/// Points farther from the axis than this many of its lengths are drawn at that distance.
const FAR_OFF: f64 = 1000.0;

/// Most decades with a number each. More: the numbers cover each other.
const MAX_DECADES: i32 = 12;

/// On shorter axes 2 and 5 stand between the powers of ten (decades).
const FEW_DECADES: f64 = 2.5;

impl Axis {
    /// A linear axis.
    pub fn new(label: impl Into<String>, range: (f64, f64)) -> Self {
        Self {
            label: label.into(),
            range,
            scale: Scale::Linear,
        }
    }

    /// A logarithmic axis.
    pub fn logarithmic(label: impl Into<String>, range: (f64, f64)) -> Self {
        Self {
            scale: Scale::Logarithmic,
            ..Self::new(label, range)
        }
    }

    /// An axis of names.
    pub fn of_names(label: impl Into<String>, names: Vec<String>) -> Self {
        let range = (-0.5, names.len() as f64 - 0.5);
        Self {
            scale: Scale::Names(names),
            ..Self::new(label, range)
        }
    }

    /// Whether the range is one in which values can be placed.
    pub(crate) fn is_sound(&self) -> bool {
        let (low, high) = self.range;
        low.is_finite()
            && high.is_finite()
            && low < high
            && (self.scale != Scale::Logarithmic || low > 0.0)
    }

    /// The place of a value: 0 at the first one, 1 at the last.
    pub(crate) fn share(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        let share = match self.scale {
            Scale::Logarithmic => (value.max(1e-300) / low).ln() / (high / low).ln(),
            _ => (value - low) / (high - low),
        };
        share.clamp(-FAR_OFF, FAR_OFF)
    }

    /// The value beyond the last one that leaves a share of the axis free.
    pub(crate) fn with_room(&self, share: f64) -> Self {
        let (low, high) = self.range;
        let factor = 1.0 / (1.0 - share);
        let high = match self.scale {
            Scale::Logarithmic => low * (high / low).powf(factor),
            _ => low + (high - low) * factor,
        };
        Self {
            range: (low, high),
            ..self.clone()
        }
    }

    /// The values at which numbers stand, with their text. `most` is the number of characters that
    /// have room along the axis.
    pub(crate) fn marks(&self, most: f64) -> Vec<(f64, String)> {
        match &self.scale {
            Scale::Linear => marks(self.range)
                .into_iter()
                .map(|mark| (mark, tick(mark, self.range)))
                .collect(),
            Scale::Logarithmic => decades(self.range)
                .into_iter()
                .map(|mark| (mark, power(mark)))
                .collect(),
            Scale::Names(names) => {
                let named = names.iter().enumerate().step_by(apart(names, most));
                named
                    .map(|(index, name)| (index as f64, name.clone()))
                    .collect()
            }
        }
    }
}

/// Distance between two names that are written at the axis, so that they do not overlap: 1 if there
/// is room for all.
fn apart(names: &[String], most: f64) -> usize {
    let longest = names
        .iter()
        .map(|name| name.chars().count())
        .max()
        .unwrap_or(0);
    (((longest + 1) * names.len()) as f64 / most)
        .ceil()
        .max(1.0) as usize
}

/// Positions of tick marks: 4 to 12 multiples of a round number; multiples of 30 if the axis is a
/// full circle in degrees.
fn marks((low, high): (f64, f64)) -> Vec<f64> {
    let span = high - low;
    let tenth = 10f64.powf((span / 4.0).log10().floor());
    let round = [5.0, 2.0, 1.0]
        .into_iter()
        .map(|factor| factor * tenth)
        .find(|step| span / step >= 4.0);
    let step = if (low, high) == (0.0, 360.0) {
        30.0
    } else {
        round.unwrap_or(tenth)
    };
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|index| index as f64 * step).collect()
}

/// Numbers of a logarithmic axis: powers of ten, or only some of them on a long axis; on a short
/// one their multiples by 2 and 5, too.
fn decades((low, high): (f64, f64)) -> Vec<f64> {
    // The ends may be powers of ten up to rounding.
    let (low, high) = (low * (1.0 - 1e-9), high * (1.0 + 1e-9));
    let (first, last) = (low.log10().floor() as i32, high.log10().floor() as i32);
    let every = (last - first).div_euclid(MAX_DECADES) + 1;
    let factors: &[f64] = if (high / low).log10() < FEW_DECADES {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0]
    };
    let decades = (first..=last).filter(|decade| decade.rem_euclid(every) == 0);
    let all = decades.flat_map(|decade| {
        factors
            .iter()
            .map(move |factor| factor * 10f64.powi(decade))
    });
    all.filter(|mark| (low..=high).contains(mark)).collect()
}

/// A number of a logarithmic axis: a decimal from 0.001 to 10 000, else with an exponent.
fn power(value: f64) -> String {
    let digits = format!("{value:.0e}");
    if (0.9e-3..2e4).contains(&value) {
        digits.parse().unwrap_or(value).to_string()
    } else {
        digits
    }
}

/// A number at an axis with the digits that the range needs.
pub(crate) fn tick(value: f64, (low, high): (f64, f64)) -> String {
    let span = (high - low).abs();
    let largest = low.abs().max(high.abs());
    if value.abs() < 1e-9 * span {
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&largest) {
        let decimals = (value.abs().log10().floor() + 2.0 - span.log10())
            .ceil()
            .clamp(2.0, 12.0) as usize;
        let text = format!("{value:.decimals$e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let digits = if digits.contains('.') {
            digits.trim_end_matches('0').trim_end_matches('.')
        } else {
            digits
        };
        return format!("{digits}e{exponent}");
    }
    let decimals = (2.0 - span.log10()).ceil().clamp(0.0, 8.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A curve that changes by less than this share of its value is constant: what changes is rounding,
/// and the numbers at its axis would all be the same.
const CONSTANT: f64 = 1e-9;

/// The range of an axis with room around the values: from 0 on where 0 is near.
pub(crate) fn height(low: f64, high: f64) -> (f64, f64) {
    let largest = low.abs().max(high.abs());
    if high - low <= CONSTANT * largest {
        let room = largest.max(1e-15);
        return (low - room, high + room);
    }
    let low = if low > 0.0 && low < 0.5 * high {
        0.0
    } else {
        low
    };
    let room = 0.08 * (high - low);
    (if low == 0.0 { 0.0 } else { low - room }, high + room)
}

/// Least and largest value; `None` without values.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, value| {
        Some(range.map_or((value, value), |(low, high): (f64, f64)| {
            (low.min(value), high.max(value))
        }))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_would_overlap_are_left_out() {
        let names = |count: usize, name: &str| vec![name.to_owned(); count];
        assert_eq!(apart(&names(3, "disc"), 60.0), 1);
        let many = names(11, "224 at 0.702");
        let shown = many.len().div_ceil(apart(&many, 60.0));
        assert!((3..=6).contains(&shown), "{shown}");
        assert_eq!(apart(&[], 60.0), 1);
    }

    #[test]
    fn numbers_of_a_logarithmic_axis_are_powers_of_ten_and_on_a_short_one_their_multiples() {
        let near = |found: Vec<f64>, expected: &[f64]| {
            assert_eq!(found.len(), expected.len(), "{found:?}");
            assert!(
                found
                    .iter()
                    .zip(expected)
                    .all(|(a, b)| (a / b - 1.0).abs() < 1e-12),
                "{found:?}"
            );
        };
        near(decades((0.08, 1.3)), &[0.1, 0.2, 0.5, 1.0]);
        near(decades((0.1, 1000.0)), &[0.1, 1.0, 10.0, 100.0, 1000.0]);
        assert!(decades((1e-30, 1e30)).len() <= 13);
        assert_eq!(
            [1e-3, 0.5, 1e4, 1e-7, 5e9].map(power),
            ["0.001", "0.5", "10000", "1e-7", "5e9"]
        );
    }

    #[test]
    fn places_of_logarithms_are_equidistant_and_far_points_stay_finite() {
        let axis = Axis::logarithmic("x", (1.0, 1e4));
        assert!((axis.share(10.0) - 0.25).abs() < 1e-15 && axis.share(0.0).is_finite());
        assert!((axis.with_room(0.5).range.1 - 1e8).abs() < 1.0);
        assert_eq!(Axis::new("x", (0.0, 1.0)).share(1e300), FAR_OFF);
    }

    #[test]
    fn ticks_have_the_digits_that_the_range_needs() {
        assert_eq!(tick(90.0, (0.0, 360.0)), "90");
        assert_eq!(tick(0.25, (0.0, 1.0)), "0.25");
        assert_eq!(tick(1.5e-5, (0.0, 2e-5)), "1.5e-5");
        assert_eq!(tick(-4e-15, (-5e-15, 0.0)), "-4e-15");
        assert_eq!(tick(1.638e6, (1.63e6, 1.64e6)), "1.638e6");
        assert_eq!(tick(1e-17, (-1.0, 1.0)), "0");
        assert_eq!(marks((0.0, 360.0)).len(), 13);
        for range in [(0.0, 1e-15), (-3e7, 1.0), (0.0, 4.0), (0.0, 35.0)] {
            let marks = marks(range);
            assert!((4..=12).contains(&marks.len()), "{range:?}: {marks:?}");
            assert!(
                marks.iter().all(|mark| (range.0..=range.1).contains(mark)),
                "{range:?}: {marks:?}"
            );
        }
    }
}
