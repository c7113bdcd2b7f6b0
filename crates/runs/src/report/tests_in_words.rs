//! The verdict on the means that test their predictions, in words: as predicted, not, or not yet
//! known.

use carom_tables::{Figure, THRESHOLD, two_digits, with_error};

use crate::measures::kicks::NEEDED;

/// The verdict on all tests among some figures, each with a word for where it belongs, which may be
/// empty. `None` without a test.
pub fn tests_in_words(figures: &[(&str, &Figure)]) -> Option<String> {
    let tests = || figures.iter().copied().filter(|(_, figure)| figure.is_test);
    let judged = || tests().filter_map(|test| Some((test, test.1.deviation()?)));
    let unknown = tests()
        .filter(|(_, figure)| figure.standard_error.is_none())
        .count();
    let lacking = (unknown > 0).then(|| lack_in_words(unknown, figures));
    let found = judged()
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|((place, worst), deviation)| {
            let missed: Vec<String> = judged()
                .filter(|(_, deviation)| *deviation > THRESHOLD)
                .map(|(test, deviation)| miss_in_words(test, deviation))
                .collect();
            if !missed.is_empty() {
                return format!("Not as predicted: {}.", missed.join("; "));
            }
            let count = judged().count();
            let means = if count == 1 {
                "The tested mean is".to_owned()
            } else {
                format!("All {count} tested means are")
            };
            let deviation = format!(
                "the largest deviation is {deviation:.1} standard errors, of {}",
                with_place(worst, place)
            );
            format!(
                "{means} as predicted: {deviation}.{}",
                would_have_been_found(judged().map(|(test, _)| test.1))
            )
        });
    let sentences: Vec<String> = found.into_iter().chain(lacking).collect();
    (!sentences.is_empty()).then(|| sentences.join(" "))
}

/// That some number of tests have no verdict, and the duration that they need, if it is known.
fn lack_in_words(unknown: usize, figures: &[(&str, &Figure)]) -> String {
    let needed = figures
        .iter()
        .filter(|(_, figure)| figure.name.starts_with(NEEDED));
    let needed = needed.map(|(_, figure)| figure.value).fold(0.0, f64::max);
    let needs = if needed > 0.0 {
        format!(
            ": it needs about {} time units",
            with_error(two_digits(needed), None)
        )
    } else {
        String::new()
    };
    let means = if unknown == 1 {
        "a mean".to_owned()
    } else {
        format!("{unknown} means")
    };
    format!("No verdict on {means}, since the measurement is too short{needs}.")
}

/// A mean that is not as predicted, with its deviation in standard errors.
fn miss_in_words((place, figure): (&str, &Figure), deviation: f64) -> String {
    let Figure {
        value,
        standard_error,
        unit,
        prediction,
        ..
    } = figure;
    let predicted = with_error(prediction.unwrap_or(0.0), None);
    let value = with_error(*value, *standard_error);
    format!(
        "{} = {value} {unit}, {deviation:.1} standard errors from {predicted}",
        with_place(figure, place)
    )
}

/// The name of a figure with the word for where it belongs, which may be empty.
pub(super) fn with_place(figure: &Figure, place: &str) -> String {
    if place.is_empty() {
        figure.name.clone()
    } else {
        format!("{} ({place})", figure.name)
    }
}

/// The smallest difference that would have been found in all tests of the first one's name.
fn would_have_been_found<'a>(tests: impl Iterator<Item = &'a Figure> + Clone) -> String {
    let Some(first) = tests.clone().next() else {
        return String::new();
    };
    let same = tests.filter(|test| test.name == first.name);
    let least = same
        .filter_map(|test| test.smallest_difference)
        .fold(0.0, f64::max);
    let unit = if first.unit == "1" {
        String::new()
    } else {
        format!(" {}", first.unit)
    };
    format!(
        " A difference of {}{unit} in the {} would have been found.",
        with_error(two_digits(least), None),
        first.name
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(name: &str, value: f64, error: Option<f64>) -> Figure {
        Figure::new(name, value, "length/time")
            .error(error)
            .predicted(0.0, "equilibrium")
            .test()
    }

    fn words(figures: &[Figure]) -> Option<String> {
        tests_in_words(
            &figures
                .iter()
                .map(|figure| ("tee", figure))
                .collect::<Vec<_>>(),
        )
    }

    #[test]
    fn the_verdict_names_the_worst_test_the_bias_or_what_is_lacking() {
        let plain = Figure::new("pressure", 1.0, "1")
            .error(0.1)
            .predicted(2.0, "Liu");
        assert_eq!(words(std::slice::from_ref(&plain)), None);
        let [x, y] = [test("vx", 0.01, Some(0.01)), test("vy", 0.02, Some(0.01))];
        assert_eq!(
            words(&[plain, x.clone(), y]).unwrap(),
            "All 2 tested means are as predicted: the largest deviation is 2.0 standard errors, of vy (tee). A difference \
             of 0.056 length/time in the vx would have been found."
        );
        let biased = words(&[x.clone(), test("vy", 0.05, Some(0.01))]).unwrap();
        assert!(
            biased.starts_with("Not as predicted: vy (tee) = 0.050"),
            "{biased}"
        );
        assert!(
            biased.ends_with("length/time, 5.0 standard errors from 0."),
            "{biased}"
        );
        let needed = Figure::new(format!("{NEEDED}, tee"), 240.0, "time");
        assert_eq!(
            words(&[test("vx", 0.3, None), test("vy", 0.3, None), needed]).unwrap(),
            "No verdict on 2 means, since the measurement is too short: it needs about 240 time units."
        );
        let both = words(&[x, test("vy", 0.3, None)]).unwrap();
        assert!(
            both.starts_with("The tested mean is") && both.contains("No verdict on a mean, since"),
            "{both}"
        );
    }
}
