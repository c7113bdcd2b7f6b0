//! Numbers as a reader sees them: as many digits as the error justifies, in groups of three.

use crate::Figure;

/// Between groups of digits: a narrow space at which no line breaks.
const SPACE: char = '\u{202f}';

/// Integers with fewer digits stay in one piece (ISO 80000-1 leaves four digits together).
const MIN_DIGITS: usize = 5;

/// Longer integers stay in one piece: spaces would make them wider still.
const MAX_DIGITS: usize = 21;

/// Smaller powers of ten are written as an exponent.
const MIN_EXPONENT: f64 = -4.0;

/// Formats a value to the digits that its standard error justifies, or to six; below 1e-4 with a
/// common exponent.
///
/// ```
/// use carom_tables::with_error;
///
/// assert_eq!(with_error(0.123456, Some(0.0021)), "0.1235 ± 0.0021");
/// assert_eq!(with_error(1.23456e-7, Some(2.1e-9)), "(1.235 ± 0.021)e-7");
/// ```
pub fn with_error(value: f64, standard_error: Option<f64>) -> String {
    match standard_error {
        // A smaller error is that of rounding.
        Some(error) if error > 1e-12 * value.abs() && error.is_finite() => {
            let exponent = value.abs().max(error).log10().floor();
            let unit = if exponent < MIN_EXPONENT {
                10f64.powi(exponent as i32)
            } else {
                1.0
            };
            let (value, error) = (value / unit, error / unit);
            let decimals = (1.0 - error.log10().floor()).clamp(0.0, 12.0) as usize;
            let text = format!("{value:.decimals$} ± {error:.decimals$}");
            if unit == 1.0 {
                text
            } else {
                format!("({text})e{exponent}")
            }
        }
        _ if value.fract() == 0.0 && value.abs() < 1e15 => format!("{value:.0}"),
        _ => significant(value, 6),
    }
}

/// Formats a number with at most this many digits, without zeros at its end; below 1e-4, and above
/// the larger of 1e6 and 10^`digits`, with an exponent.
///
/// ```
/// use carom_tables::significant;
///
/// assert_eq!([significant(0.12345, 3), significant(8.796e12, 4)], ["0.123", "8.796e12"]);
/// ```
pub fn significant(value: f64, digits: u8) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 {
            "0".to_owned()
        } else {
            value.to_string()
        };
    }
    let most = 10f64.powi(i32::from(digits.max(6)));
    let is_plain = (1e-4..most).contains(&value.abs());
    let trimmed = |text: &str| {
        let is_decimal = text.contains('.');
        if is_decimal {
            text.trim_end_matches('0').trim_end_matches('.')
        } else {
            text
        }
        .to_owned()
    };
    if is_plain {
        let decimals = (f64::from(digits) - 1.0 - value.abs().log10().floor()).max(0.0) as usize;
        return trimmed(&format!("{value:.decimals$}"));
    }
    let text = format!("{value:.*e}", usize::from(digits.max(1)) - 1);
    match text.split_once('e') {
        Some((mantissa, exponent)) => format!("{}e{exponent}", trimmed(mantissa)),
        None => text,
    }
}

/// A number rounded to 15 significant digits, which a rounding error of the last bit does not
/// change.
///
/// ```
/// use carom_tables::fifteen_digits;
///
/// assert_eq!(fifteen_digits(3.0 * 0.1), 0.3);
/// ```
pub fn fifteen_digits(number: f64) -> f64 {
    format!("{number:.14e}").parse().unwrap_or(number)
}

/// A value with two digits, such as a tolerance.
pub fn two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// Formats a prediction with one digit more than the measured value.
pub fn predicted(value: f64, figure: &Figure) -> String {
    match figure.standard_error {
        Some(error) if value.abs() >= 1e-4 && error > 0.0 && error.is_finite() => {
            format!(
                "{value:.0$}",
                (2.0 - error.log10().floor()).clamp(0.0, 12.0) as usize
            )
        }
        _ => with_error(value, None),
    }
}

/// Groups the digits of integers in a text by three, with narrow spaces at which no line breaks:
/// 13 979 096. Digits after a decimal point, in a word or in an exponent stay as they are.
///
/// ```
/// use carom_tables::grouped;
///
/// assert_eq!(grouped("13979096 of 4000"), "13\u{202f}979\u{202f}096 of 4000");
/// assert_eq!(grouped("0.0012345 ± 1e10000"), "0.0012345 ± 1e10000");
/// assert_eq!(grouped("3.71981e-15"), "3.71981e-15");
/// assert_eq!(grouped("J. Chem. Phys. 157 (2022) 234111"), "J. Chem. Phys. 157 (2022) 234111");
/// ```
pub fn grouped(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    let mut rest = text;
    let mut before = None;
    while let Some(first) = rest.chars().next() {
        let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        let is_part = |character: char| character.is_alphanumeric() || "._/".contains(character);
        if digits == 0 {
            result.push(first);
            before = Some(first);
            rest = &rest[first.len_utf8()..];
            continue;
        }
        let (number, after) = rest.split_at(digits);
        let joins_word =
            before.is_some_and(is_part) || after.starts_with(|next: char| next.is_alphabetic());
        // 12345e-7 is a number, too; 1.2345e-7 has digits after its point.
        let has_exponent = after.starts_with('e') && !before.is_some_and(is_part);
        let is_exponent = result.ends_with("e-") || result.ends_with("e+");
        if !(MIN_DIGITS..=MAX_DIGITS).contains(&digits)
            || (joins_word && !has_exponent)
            || is_exponent
            || follows_year(&result)
        {
            result.push_str(number);
        } else {
            for (index, digit) in number.chars().enumerate() {
                if index > 0 && (digits - index).is_multiple_of(3) {
                    result.push(SPACE);
                }
                result.push(digit);
            }
        }
        before = number.chars().last();
        rest = after;
    }
    result
}

/// Whether a text ends with a year in parentheses: what follows is the number of an article.
fn follows_year(text: &str) -> bool {
    let year = text
        .strip_suffix(") ")
        .and_then(|rest| rest.rsplit_once('('))
        .map(|(_, year)| year);
    year.is_some_and(|year| year.len() == 4 && year.bytes().all(|byte| byte.is_ascii_digit()))
}

/// The name of a quantity with its unit in parentheses; a pure number (unit 1) has none, and what
/// is called by its unit, such as time, is not named twice.
///
/// ```
/// use carom_tables::named;
///
/// assert_eq!(named("pressure", "energy/length²"), "pressure (energy/length²)");
/// assert_eq!(named("kurtosis", "1"), "kurtosis");
/// assert_eq!(named("time", "time"), "time");
/// ```
pub fn named(name: &str, unit: &str) -> String {
    if unit.is_empty() || unit == "1" || unit == name {
        name.to_owned()
    } else {
        format!("{name} ({unit})")
    }
}

/// A label whose unit stands in brackets at its end, with parentheses instead: units look the same
/// in tables and charts.
pub fn in_parentheses(label: &str) -> String {
    let parts = label
        .strip_suffix(']')
        .and_then(|rest| rest.rsplit_once(" ["));
    parts.map_or_else(|| label.to_owned(), |(name, unit)| named(name, unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_follow_the_error() {
        assert_eq!(with_error(350.6183, Some(0.123)), "350.62 ± 0.12");
        assert_eq!(with_error(0.029_12, Some(0.0017)), "0.0291 ± 0.0017");
        assert_eq!(with_error(1234.5, Some(30.0)), "1234 ± 30");
        assert_eq!(with_error(0.25, None), "0.25");
        assert_eq!(with_error(3e-16, None), "3e-16");
        assert_eq!(with_error(12_345_678.0, None), "12345678");
        assert_eq!(with_error(f64::NAN, None), "NaN");
    }

    #[test]
    fn a_number_has_the_digits_that_are_asked_for() {
        for (number, digits, text) in [
            (0.0, 4, "0"),
            (0.5, 4, "0.5"),
            (-2.0, 4, "-2"),
            (1234.56, 4, "1235"),
            (1234.56, 6, "1234.56"),
            (100.0, 4, "100"),
            (0.012_345, 2, "0.012"),
            (0.17, 2, "0.17"),
            (8.9e-6, 2, "8.9e-6"),
            (1e12, 4, "1e12"),
            (-1e-13, 4, "-1e-13"),
            (f64::INFINITY, 4, "inf"),
        ] {
            assert_eq!(significant(number, digits), text);
        }
    }

    #[test]
    fn units_stand_in_parentheses() {
        assert_eq!(in_parentheses("step [τ]"), "step (τ)");
        assert_eq!(
            in_parentheses("interval [a, b] of x"),
            "interval [a, b] of x"
        );
        assert_eq!(in_parentheses("pressure"), "pressure");
    }

    #[test]
    fn integers_are_grouped_and_words_are_not() {
        let plain = |text: &str| grouped(text).replace(SPACE, " ");
        assert_eq!(plain("13979096"), "13 979 096");
        assert_eq!(plain("-123456.789012 ± 12345"), "-123 456.789012 ± 12 345");
        assert_eq!(
            plain("the first 100000 of 2500000"),
            "the first 100 000 of 2 500 000"
        );
        for same in [
            "1234",
            "0.000012345",
            "1.5e-12345",
            "run-a12345",
            "out/12345",
            "v12345678x",
        ] {
            assert_eq!(plain(same), same);
        }
    }
}
