//! The page of a test: a table with the published numbers, and charts on logarithmic axes.

use anyhow::Result;
use carom_report::{
    page::{Layout, Page, PagePart},
    scatter::{Mark, Scatter, ScatterPoint},
};
use carom_tables::{Summary, with_error};

use super::{
    results::{Costs, Test, ThesisResults},
    timing::MeasuredTime,
};

/// Number of segments of a fitted curve in a chart.
const CURVE: u32 = 100;

/// A measured value in units of `unit`; a dash if there is none.
pub fn cell(measured: Option<MeasuredTime>, unit: f64) -> String {
    measured.map_or_else(
        || "–".to_owned(),
        |(value, error)| with_error(value / unit, error.map(|error| error / unit)),
    )
}

/// A value to three digits.
pub fn number(value: f64) -> String {
    if value != 0.0 && !(1e-2..1e5).contains(&value) {
        format!("{value:.2e}")
    } else {
        format!("{value:.2}")
    }
}

/// Chart of a cost on logarithmic axes.
///
/// # Errors
/// A value cannot be drawn.
pub fn chart(test: &Test, costs: &Costs) -> Result<String> {
    let mut families: Vec<String> = Vec::new();
    let mut points = Vec::new();
    let measured = costs.points.iter().map(|point| (point, Mark::Joined));
    let published = costs.published.iter().map(|point| (point, Mark::Published));
    for ((name, size, cost), mark) in measured.chain(published) {
        let family = families
            .iter()
            .position(|known| known == name)
            .unwrap_or_else(|| {
                families.push(name.clone());
                families.len() - 1
            });
        points.push(ScatterPoint {
            family,
            label: String::new(),
            x: *size as f64,
            y: *cost,
            mark,
        });
    }
    for (name, fit) in &costs.fits {
        let family = families.len();
        families.push(name.clone());
        let sizes = costs.points.iter().map(|point| point.1 as f64);
        let (least, most) = sizes.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), x| {
            (a.min(x), b.max(x))
        });
        let along =
            (0..=CURVE).map(|n| least * (most / least).powf(f64::from(n) / f64::from(CURVE)));
        // A quadratic fit may be negative at small sizes, which a logarithmic axis cannot show.
        let smallest = costs
            .points
            .iter()
            .map(|point| point.2)
            .fold(f64::INFINITY, f64::min);
        let curve = along
            .map(|x| (x, fit.value(x)))
            .filter(|&(_, y)| y >= smallest);
        points.extend(curve.map(|(x, y)| ScatterPoint {
            family,
            label: String::new(),
            x,
            y,
            mark: Mark::Line,
        }));
    }
    let title = test.title.to_owned();
    Scatter {
        title,
        x_label: test.size.to_owned(),
        y_label: costs.what.to_owned(),
        families,
        points,
        front: Vec::new(),
    }
    .svg()
}

/// The page.
pub fn page(
    test: &Test,
    results: &ThesisResults,
    summary: &Summary,
    charts: &[String],
    command: &str,
) -> Page {
    let mut page = Page::new(test.title, test.lead);
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.checks(&summary.checks);
    page.part(PagePart::Answer);
    page.table(&results.header, &results.rows);
    for chart in charts {
        let caption = "Both axes are logarithmic: a power law is a straight line. Dots: measured here; \
                       rings: published in the thesis; lines without symbols: fits of the thesis's functions, least \
                       squares of the seconds.";
        page.pictures(Layout::Full, &[(chart, caption)]);
    }
    page.part(PagePart::Results);
    let broken = results
        .timings
        .iter()
        .filter(|timing| !timing.is_whole())
        .count();
    page.paragraph(&format!(
        "Processor time of the thread, without the construction of the scene, with standard errors from \
         the scatter of equally long intervals of the run. {broken} of {} cases ended early at their time \
         limit; their figures for 100 time units are extrapolated if there were at least ten collisions. \
         The published numbers were measured on an Intel Core i5-7200U.",
        results.timings.len()
    ));
    page.heading("Growth with size");
    page.figures(&summary.figures);
    page.code(command);
    page.links(["times.csv", "summary.json", "manifest.json", "config.toml"]);
    page
}
