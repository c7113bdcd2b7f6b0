//! What both tests write: a table beside the thesis's own numbers, a chart on two logarithmic axes, a page.

use anyhow::Result;

use super::{Options, timing::Timing};
use crate::{
    manifest::Manifest,
    output::Folder,
    page::{Layout, Page},
    say,
    scatter::{Mark, Point, Scatter},
    summary::{Figure, Summary, Totals, Verdict},
};

/// What a test is about.
#[derive(Debug, Clone, Copy)]
pub struct Test {
    /// Name of the command.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// What was asked.
    pub lead: &'static str,
    /// What grows.
    pub size: &'static str,
    /// What it costs.
    pub cost: &'static str,
}

/// What came out.
#[derive(Debug)]
pub struct Results {
    /// The cases.
    pub timings: Vec<Timing>,
    /// Points of the chart: which engine, how many, what it costs.
    pub points: Vec<(&'static str, usize, f64)>,
    /// The same from the thesis.
    pub published: Vec<(&'static str, usize, f64)>,
    /// Exponents and counts.
    pub figures: Vec<Figure>,
    /// Header of the table.
    pub header: Vec<&'static str>,
    /// The table.
    pub rows: Vec<Vec<String>>,
}

/// A figure to three digits.
pub fn number(value: f64) -> String {
    if value != 0.0 && !(1e-2..1e5).contains(&value) { format!("{value:.2e}") } else { format!("{value:.2}") }
}

impl Test {
    /// Measures with the budget of each case (seconds), and writes the folder.
    ///
    /// # Errors
    /// A folder that is not empty or cannot be written, a run that cannot go on.
    pub fn run(&self, options: &Options, measure: impl FnOnce(f64) -> Result<Results>) -> Result<Verdict> {
        let folder = Folder::create(&options.folder(self.name), options.existing())?;
        let _alone = folder.lock()?;
        if !options.note().is_empty() {
            say(&options.note());
        }
        let command = options.command(self.name);
        folder.write("config.toml", format!("command = \"{command}\"\n"))?;
        let manifest = Manifest::begin(&folder, &command, &[])?;
        let results = measure(options.budget())?;
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
        let chart = self.chart(&results)?;
        folder.write("cost.svg", &chart)?;
        let rows = results.timings.iter().map(|timing| {
            let Timing { engine, size, queries, seconds, totals } = timing;
            (
                engine,
                size,
                totals.simulated_time,
                totals.collisions,
                queries,
                seconds,
                timing.for_thesis_time(),
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
        ];
        folder.write_table("times.csv", &header, rows)?;
        folder.write("report.html", self.page(&results, &summary, &chart, &command).html())?;
        folder.write_json("summary.json", &summary)?;
        manifest.complete(&folder, results.timings.iter().map(|timing| timing.seconds).sum())?;
        crate::conclude(&folder, &summary);
        Ok(summary.verdict())
    }

    fn chart(&self, results: &Results) -> Result<String> {
        let mut families: Vec<String> = Vec::new();
        let mut points = Vec::new();
        for &(name, size, cost) in results.points.iter().chain(&results.published) {
            let family = families.iter().position(|known| known == name).unwrap_or_else(|| {
                families.push(name.to_owned());
                families.len() - 1
            });
            points.push(Point {
                family,
                label: String::new(),
                x: size as f64,
                y: cost,
                mark: Mark::Measured,
            });
        }
        let title = self.title.to_owned();
        Scatter {
            title,
            x_label: self.size.to_owned(),
            y_label: self.cost.to_owned(),
            families,
            points,
            front: Vec::new(),
        }
        .svg()
    }

    fn page(&self, results: &Results, summary: &Summary, chart: &str, command: &str) -> Page {
        let mut page = Page::new(self.title, self.lead);
        if !summary.note.is_empty() {
            page.note(&summary.note);
        }
        page.checks(&summary.checks);
        page.heading("What it takes");
        page.table(&results.header, &results.rows);
        page.pictures(
            Layout::Full,
            &[(chart, "Both axes are logarithmic: a power of the size is a straight line.")],
        );
        let broken = results.timings.iter().filter(|timing| !timing.is_whole()).count();
        page.paragraph(&format!(
            "Processor time of the thread, without building the scene. {broken} of {} cases were broken off when their \
             time was over; their figures for 100 time units are reckoned from what was done. The thesis's numbers are of an \
             Intel Core i5-7200U.",
            results.timings.len()
        ));
        page.heading("How it grows");
        page.figures(&summary.figures);
        page.heading("How to run it again");
        page.code(command);
        page.links(["times.csv", "summary.json", "manifest.json", "config.toml"]);
        page
    }
}
