//! The page: the verdict, the deviations as a chart, and all figures.

use anyhow::Result;
use carom_report::{
    page::{Layout, Page},
    table_chart,
};
use carom_runs::output::Folder;
use carom_tables::{Figure, Summary, Table, Verdict};

use super::results::Measured;

/// Writes the page and the table of deviations.
///
/// # Errors
/// A file cannot be written.
pub fn write(folder: &Folder, all: &[Measured], summary: &Summary, command: &str) -> Result<()> {
    let deviations: Vec<(Figure, f64)> = all.iter().flat_map(Measured::deviations).collect();
    let rows = deviations.iter().map(|(figure, off)| {
        (&figure.name, figure.value, figure.standard_error, figure.prediction, &figure.source, *off)
    });
    let header = ["figure", "value", "standard_error", "prediction", "source", "deviation"];
    folder.write_table("deviations.csv", &header, rows)?;
    folder.write("report.html", page(&deviations, summary, command)?.html())
}

fn page(deviations: &[(Figure, f64)], summary: &Summary, command: &str) -> Result<Page> {
    let failed = summary.checks.iter().filter(|check| !check.passed).count();
    let worst = deviations.iter().map(|(_, off)| *off).fold(0.0, f64::max);
    let lead = match summary.verdict() {
        Verdict::Passed => format!(
            "All {} figures agree with their predictions; the farthest is {worst:.1} standard errors away.",
            deviations.len()
        ),
        Verdict::Failed => format!("{failed} of {} checks failed.", summary.checks.len()),
    };
    let mut page = Page::new(&summary.title, &lead);
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    let table = Table::new("deviations", "Deviations from the predictions, in order of the table")
        .abscissa("figure", "1", (1..=deviations.len()).map(|index| index as f64).collect())
        .value("deviation", "standard errors", deviations.iter().map(|(_, off)| Some(*off)).collect());
    for svg in table_chart::charts(&table)? {
        let caption = "Distance from the prediction in standard errors, the uncertainty of theory included; 4 are allowed.";
        page.pictures(Layout::Full, &[(&svg, caption)]);
    }
    page.heading("Figures");
    page.figures(&summary.figures);
    page.heading("Runs");
    page.totals(&summary.totals);
    page.runs(&summary.runs);
    page.heading("Checks");
    page.checks(&summary.checks);
    page.heading("Reproduction");
    page.code(command);
    page.paragraph("Each scene is a file of this folder that `carom run` accepts.");
    Ok(page)
}
