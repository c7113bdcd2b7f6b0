//! The page: the verdict, the deviations as a chart, and all figures.

use anyhow::Result;
use carom_report::{
    page::{DataChart, Page, Part, checks_in_words},
    plot::{Axis, Chart, Layer, Shape, colour, staircase},
};
use carom_runs::output::Folder;
use carom_tables::{Figure, Summary, Verdict};

use super::results::{ALLOWED, Measured};

/// Writes the table of deviations and returns the page.
///
/// # Errors
/// A file cannot be written.
pub fn write(folder: &Folder, all: &[Measured], summary: &Summary, command: &str) -> Result<Page> {
    let deviations: Vec<(Figure, f64)> = all.iter().flat_map(Measured::deviations).collect();
    let rows = deviations.iter().map(|(figure, off)| {
        (&figure.name, figure.value, figure.standard_error, figure.prediction, &figure.source, *off)
    });
    let header = ["figure", "value", "standard_error", "prediction", "source", "deviation"];
    folder.write_table("deviations.csv", &header, rows)?;
    page(&deviations, summary, command)
}

fn page(deviations: &[(Figure, f64)], summary: &Summary, command: &str) -> Result<Page> {
    let worst = deviations.iter().map(|(_, off)| *off).fold(0.0, f64::max);
    let verdict = match summary.verdict() {
        Verdict::Passed => format!(
            "All {} figures agree with their predictions; the farthest is {worst:.1} standard errors away.",
            deviations.len()
        ),
        Verdict::Failed => checks_in_words(&summary.checks),
    };
    let mut page = Page::new(
        &summary.title,
        "Hard discs and a mixture of molecules, each figure against theory or published pressures.",
    );
    page.verdict(&verdict);
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.part(Part::Answer);
    let caption = "Distance from the prediction in standard errors, the uncertainty of theory included; 4 are \
                   allowed.";
    let (svg, file) = (chart(deviations)?, "deviations.csv".to_owned());
    page.charts(&[DataChart { svg, caption: caption.to_owned(), file }]);
    page.part(Part::Results);
    page.heading("Figures");
    page.figures(&summary.figures);
    page.heading("Runs");
    page.totals(&summary.totals);
    page.runs(&summary.runs);
    page.checks(&summary.checks);
    page.code(command);
    page.part(Part::Again);
    page.paragraph("Each scene is a file of this folder that carom run accepts.");
    page.links(["deviations.csv", "summary.json", "manifest.json", "config.toml"]);
    Ok(page)
}

/// The deviations in the order of the table, as steps.
fn chart(deviations: &[(Figure, f64)]) -> Result<String> {
    let values: Vec<f64> = deviations.iter().map(|(_, off)| *off).collect();
    let count = values.len().max(1) as f64;
    let (first, last) = (0.5, count + 0.5);
    let layer =
        |name: &str, colour, points| Layer { name: name.to_owned(), colour, shape: Shape::Line(points) };
    let top = values.iter().copied().filter(|value| value.is_finite()).fold(ALLOWED, f64::max);
    Chart {
        title: "Deviations from the predictions".to_owned(),
        x: Axis { label: "figure, in the order of the table".to_owned(), range: (first, last) },
        y: Axis { label: "deviation (standard errors)".to_owned(), range: (0.0, 1.3 * top) },
        layers: vec![
            layer("measured", colour::BLUE, staircase(first, last, &values)),
            layer("allowed", colour::VERMILLION, vec![(first, ALLOWED), (last, ALLOWED)]),
        ],
    }
    .svg()
}
