//! Output of both tests: a table with the published numbers, charts on logarithmic axes, and a
//! page.

use anyhow::Result;
use carom_report::{
    page::{Layout, Page, with_error},
    scatter::{Mark, Point, Scatter},
};
use carom_runs::{
    experiment::{Experiment, Opening, configuration},
    work_items::Pieces,
};
use carom_tables::{Figure, Summary, Totals, Verdict};

use super::{
    Options,
    fits::Fit,
    timing::{Measured, Timing},
};

/// Number of segments of a fitted curve in a chart.
const CURVE: u32 = 100;

/// Description of a test.
#[derive(Debug, Clone, Copy)]
pub struct Test {
    /// Name of the command.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// Question of the test.
    pub lead: &'static str,
    /// Label of the system size.
    pub size: &'static str,
}

/// Results.
#[derive(Debug)]
pub struct Results {
    /// The cases.
    pub timings: Vec<Timing>,
    /// The charts; the most important one is the first.
    pub charts: Vec<Costs>,
    /// Exponents and counts.
    pub figures: Vec<Figure>,
    /// Header of the table.
    pub header: Vec<&'static str>,
    /// The table.
    pub rows: Vec<Vec<String>>,
}

/// Cost as a function of size.
#[derive(Debug)]
pub struct Costs {
    /// Name of the file.
    pub file: &'static str,
    /// Name of the cost, with unit.
    pub what: &'static str,
    /// Engine, size and cost of each point.
    pub points: Vec<(String, usize, f64)>,
    /// Engine, size and cost of the published points.
    pub published: Vec<(String, usize, f64)>,
    /// Fitted curves, by name.
    pub fits: Vec<(String, Fit)>,
}

/// A measured value in units of `unit`; a dash if there is none.
pub fn cell(measured: Option<Measured>, unit: f64) -> String {
    measured.map_or_else(
        || "–".to_owned(),
        |(value, error)| with_error(value / unit, error.map(|error| error / unit)),
    )
}

/// A value to three digits.
pub fn number(value: f64) -> String {
    if value != 0.0 && !(1e-2..1e5).contains(&value) { format!("{value:.2e}") } else { format!("{value:.2}") }
}

impl Test {
    /// Measures with the time limit of each case (seconds) and writes the folder.
    ///
    /// # Errors
    /// The folder is not empty or cannot be written, or a run fails.
    pub fn run(
        &self,
        options: &Options,
        measure: impl FnOnce(f64, &Pieces) -> Result<Results>,
    ) -> Result<Verdict> {
        let command = options.command(self.name);
        let experiment = Experiment::begin_in_pieces(
            &options.common.destination,
            command.clone(),
            &Opening {
                folder: &format!("out/{}", self.name),
                note: &options.note(),
                command: &command,
                configuration: configuration(&command, ""),
                scenes: &[],
            },
        )?;
        let folder = &experiment.folder;
        let results = measure(options.budget(), &experiment.pieces)?;
        let totals: Vec<Totals> = results.timings.iter().map(|timing| timing.totals).collect();
        let totals = Totals::of(&totals);
        let summary = Summary {
            title: self.title.to_owned(),
            note: options.note(),
            totals,
            checks: totals.checks(),
            figures: results.figures.clone(),
            runs: Vec::new(),
        };
        let charts: Vec<String> =
            results.charts.iter().map(|costs| self.chart(costs)).collect::<Result<_>>()?;
        for (costs, chart) in results.charts.iter().zip(&charts) {
            folder.write(costs.file, chart)?;
        }
        let rows = results.timings.iter().map(|timing| {
            let Timing { engine, size, whole, .. } = timing;
            let (reckoned, error) = timing.for_thesis_time().unzip();
            (
                engine,
                size,
                whole.time,
                whole.collisions,
                whole.queries,
                whole.seconds,
                reckoned,
                error.flatten(),
            )
        });
        let header = [
            "engine",
            "size",
            "simulated_time",
            "collisions",
            "queries",
            "cpu_seconds",
            "cpu_seconds_for_100",
            "standard_error",
        ];
        folder.write_table("times.csv", &header, rows)?;
        folder.write("report.html", self.page(&results, &summary, &charts, &command).html())?;
        folder.write_json("summary.json", &summary)?;
        let seconds = results.timings.iter().map(|timing| timing.whole.seconds).sum();
        carom_runs::conclude(&experiment.complete_after(seconds)?, &summary);
        Ok(summary.verdict())
    }

    fn chart(&self, costs: &Costs) -> Result<String> {
        let mut families: Vec<String> = Vec::new();
        let mut points = Vec::new();
        let measured = costs.points.iter().map(|point| (point, Mark::Joined));
        let published = costs.published.iter().map(|point| (point, Mark::Published));
        for ((name, size, cost), mark) in measured.chain(published) {
            let family = families.iter().position(|known| known == name).unwrap_or_else(|| {
                families.push(name.clone());
                families.len() - 1
            });
            points.push(Point { family, label: String::new(), x: *size as f64, y: *cost, mark });
        }
        for (name, fit) in &costs.fits {
            let family = families.len();
            families.push(name.clone());
            let sizes = costs.points.iter().map(|point| point.1 as f64);
            let (least, most) =
                sizes.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), x| (a.min(x), b.max(x)));
            let along = (0..=CURVE).map(|n| least * (most / least).powf(f64::from(n) / f64::from(CURVE)));
            // A quadratic fit may be negative at small sizes, which a logarithmic axis cannot show.
            let smallest = costs.points.iter().map(|point| point.2).fold(f64::INFINITY, f64::min);
            let curve = along.map(|x| (x, fit.value(x))).filter(|&(_, y)| y >= smallest);
            points.extend(curve.map(|(x, y)| Point { family, label: String::new(), x, y, mark: Mark::Line }));
        }
        let title = self.title.to_owned();
        Scatter {
            title,
            x_label: self.size.to_owned(),
            y_label: costs.what.to_owned(),
            families,
            points,
            front: Vec::new(),
        }
        .svg()
    }

    fn page(&self, results: &Results, summary: &Summary, charts: &[String], command: &str) -> Page {
        let mut page = Page::new(self.title, self.lead);
        if !summary.note.is_empty() {
            page.note(&summary.note);
        }
        page.checks(&summary.checks);
        page.heading("Times");
        page.table(&results.header, &results.rows);
        for chart in charts {
            let caption = "Both axes are logarithmic: a power law is a straight line. Dots: measured here; \
                           rings: published in the thesis; lines without symbols: fits of the thesis's functions, least \
                           squares of the seconds.";
            page.pictures(Layout::Full, &[(chart, caption)]);
        }
        let broken = results.timings.iter().filter(|timing| !timing.is_whole()).count();
        page.paragraph(&format!(
            "Processor time of the thread, without the construction of the scene, with standard errors from \
             the scatter of equally long intervals of the run. {broken} of {} cases ended early at their time \
             limit; their figures for 100 time units are extrapolated if there were at least ten collisions. \
             The published numbers were measured on an Intel Core i5-7200U.",
            results.timings.len()
        ));
        page.heading("Growth with size");
        page.figures(&summary.figures);
        page.heading("Reproduction");
        page.code(command);
        page.links(["times.csv", "summary.json", "manifest.json", "config.toml"]);
        page
    }
}
