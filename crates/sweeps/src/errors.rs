//! The standard errors of a sweep against the scatter of its replicas: a file, and a part of the
//! page.

use anyhow::Result;
use carom_report::page::Page;
use carom_runs::output::Folder;
use carom_tables::{Calibration, calibration::Calibrated};

use crate::results::PointResults;

/// Name of the file.
pub const FILE: &str = "errors.csv";

/// Most rows of the table on the page; of more, only the flagged ones are shown. Fewer: three gases
/// with all their measures (300 rows) would not be shown. More: a page of megabytes.
const MAX_ROWS: usize = 400;

/// Columns of the file.
const COLUMNS: [&str; 11] = [
    "point",
    "quantity",
    "replicas",
    "rows",
    "rare_rows",
    "ratio",
    "least",
    "most",
    "band_from",
    "band_to",
    "result",
];

/// All comparisons with their points.
fn all(points: &[PointResults]) -> impl Iterator<Item = (&PointResults, &Calibration)> {
    points
        .iter()
        .flat_map(|point| point.errors.iter().map(move |errors| (point, errors)))
}

/// Whether a point has enough replicas.
pub fn are_compared(points: &[PointResults]) -> bool {
    all(points).next().is_some()
}

/// Writes the file, if a point has enough replicas.
///
/// # Errors
/// It cannot be written.
pub fn write(folder: &Folder, points: &[PointResults]) -> Result<()> {
    if !are_compared(points) {
        return Ok(());
    }
    let row = |(point, errors): (&PointResults, &Calibration)| {
        let Calibration {
            name,
            replicas,
            rows,
            rare,
            ratio,
            least,
            most,
            band,
            result,
        } = errors;
        let counts = [replicas, rows, rare].map(ToString::to_string);
        let numbers = [ratio, least, most, &band[0], &band[1]].map(ToString::to_string);
        let (label, result) = (point.label.clone(), result.word().to_lowercase());
        [
            vec![label, name.clone()],
            counts.to_vec(),
            numbers.to_vec(),
            vec![result],
        ]
        .concat()
    };
    folder.write_lasting_table(FILE, &COLUMNS, all(points).map(row))
}

/// Adds the comparison to the page.
pub fn show(page: &mut Page, points: &[PointResults]) {
    if !are_compared(points) {
        return;
    }
    let is_flagged = |errors: &Calibration| errors.result == Calibrated::Flagged;
    let (count, flagged) = (
        all(points).count(),
        all(points).filter(|(_, errors)| is_flagged(errors)).count(),
    );
    page.heading("Standard errors against the scatter of replicas");
    page.paragraph(&format!(
        "{flagged} of {count} are flagged. The ratio is the root mean square of the standard errors of single \
         replicas over the scatter of their values, of a table the median over its rows: 1 if the errors are \
         right. The median of right errors is outside the band with a probability of 10⁻³ by χ². A table is \
         flagged for an extreme row too, with that probability for all rows together. Rare rows have no error \
         in a replica."
    ));
    let shown = all(points).filter(|(_, errors)| count <= MAX_ROWS || is_flagged(errors));
    let row = |(point, errors): (&PointResults, &Calibration)| {
        let numbers = [errors.ratio, errors.least, errors.most].map(|ratio| format!("{ratio:.2}"));
        let [from, to] = errors.band.map(|ratio| format!("{ratio:.2}"));
        let result = errors.result.word().to_owned();
        let words = vec![result, errors.name.clone(), point.short_label()];
        let counts = vec![errors.rows.to_string(), errors.rare.to_string()];
        [
            words,
            numbers.to_vec(),
            vec![format!("{from} to {to}")],
            counts,
        ]
        .concat()
    };
    let header = [
        "result",
        "quantity",
        "point",
        "ratio",
        "least",
        "largest",
        "band",
        "rows",
        "rare rows",
    ];
    let rows: Vec<Vec<String>> = shown.map(row).collect();
    if !rows.is_empty() {
        page.table(&header, &rows);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::point::Key;
    use carom_tables::Totals;

    /// A point with right errors of this number of quantities, and one with errors of half the
    /// scatter.
    fn point(right: usize) -> PointResults {
        let scatter = (40.0 * 41.0 / 12.0f64).sqrt();
        let compared = |name: &str, error: f64| {
            let row = (0..40).map(|x| (f64::from(x), Some(error))).collect();
            Calibration::new(name, &[row]).expect("40 replicas")
        };
        let mut errors: Vec<Calibration> = (0..right)
            .map(|number| compared(&format!("right {number}"), scatter))
            .collect();
        errors.push(compared("wrong", 0.5 * scatter));
        PointResults {
            point: Key::try_from("0".repeat(16)).expect("16 digits"),
            label: "gas = dense".to_owned(),
            replicas: (1..=40).collect(),
            figures: Vec::new(),
            totals: Totals::default(),
            checks: Vec::new(),
            answers: Vec::new(),
            errors,
            evidence: Vec::new(),
            tables: Vec::new(),
            note: String::new(),
        }
    }

    #[test]
    fn a_page_has_all_comparisons_of_three_gases_and_of_more_the_flagged_ones() {
        let shown = |right: usize| {
            let mut page = Page::new("Sweep", "");
            show(&mut page, &[point(right)]);
            let html = page.html();
            (html.contains("right 1"), html.contains("FLAGGED"))
        };
        assert_eq!(shown(300), (true, true));
        assert_eq!(shown(MAX_ROWS), (false, true));
    }
}
