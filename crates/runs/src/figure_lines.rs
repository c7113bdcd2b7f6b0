//! The figures of a run as lines of a table for the terminal.

use carom_tables::{Figure, named, with_error};

use crate::report::judged;

/// More figures are counted: the page has them all.
const MAX_LINES: usize = 30;

/// Longer names are cut before their last words, which are the tag and the unit.
const MAX_NAME: usize = 96;

/// Characters that remain at the end of a name that is cut.
const END: usize = 24;

/// A line for each figure: name and unit, the value with its error, and its prediction. What
/// changed during its measurement is marked.
pub fn figure_lines(figures: &[Figure]) -> Vec<String> {
    let names = figures
        .iter()
        .map(|figure| named(&figure.name, &figure.unit));
    let names: Vec<String> = names.map(|name| shortened(&name)).collect();
    let values: Vec<String> = figures
        .iter()
        .map(|figure| with_error(figure.value, figure.standard_error))
        .collect();
    let width = |texts: &[String]| {
        texts
            .iter()
            .take(MAX_LINES)
            .map(|text| text.chars().count())
            .max()
            .unwrap_or(0)
    };
    let (name_width, value_width) = (width(&names), width(&values));
    let line = |((figure, name), value): ((&Figure, &String), &String)| {
        let prediction = match figure.prediction {
            Some(prediction) if figure.is_approximate() => {
                format!("  approximation {}", with_error(prediction, None))
            }
            Some(prediction) => format!("  predicted {}", with_error(prediction, None)),
            None => String::new(),
        };
        let is_changing = judged(figure).is_some_and(|found| !found.is_stationary);
        let mark = if is_changing { "  NOT STATIONARY" } else { "" };
        format!("  {name:<name_width$}  {value:<value_width$}{prediction}{mark}")
            .trim_end()
            .to_owned()
    };
    let lines = figures
        .iter()
        .zip(&names)
        .zip(&values)
        .take(MAX_LINES)
        .map(line);
    let more = figures.len().saturating_sub(MAX_LINES);
    let more = (more > 0).then(|| format!("  {more} more figures are on the page"));
    lines.chain(more).collect()
}

/// A name of at most [`MAX_NAME`] characters.
fn shortened(name: &str) -> String {
    let all: Vec<char> = name.chars().collect();
    if all.len() <= MAX_NAME {
        return name.to_owned();
    }
    let (start, end) = (&all[..MAX_NAME - END - 1], &all[all.len() - END..]);
    start.iter().chain(&['…']).chain(end).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_tables::Stationarity;

    #[test]
    fn figures_are_aligned_and_marked() {
        let found = Stationarity {
            is_stationary: false,
            change: 1.0,
            standard_error: 0.1,
            settled_at: None,
            independent_blocks: 32.0,
            correlation_time: None,
        };
        let changing = Figure {
            stationarity: Some(found),
            ..Figure::new("kT", 2.0, "energy").error(0.128)
        };
        let figures = [
            Figure::new("bodies", 40.0, "1"),
            changing,
            Figure::new("p", 3.0, "1").predicted(3.5, "Liu"),
        ];
        let expected = [
            "  bodies       40",
            "  kT (energy)  2.00 ± 0.13  NOT STATIONARY",
            "  p            3            predicted 3.5",
        ];
        assert_eq!(figure_lines(&figures), expected);
        let many = vec![Figure::new("x".repeat(120), 1.0, "1"); 40];
        let lines = figure_lines(&many);
        assert!(
            lines.len() == MAX_LINES + 1
                && lines[MAX_LINES].contains("10 more")
                && lines[0].chars().count() < MAX_NAME + 8
        );
        let long = format!("{}, tag (length²/time)", "x".repeat(120));
        assert!(
            shortened(&long).ends_with("x, tag (length²/time)")
                && shortened(&long).chars().count() == MAX_NAME
        );
    }
}
