//! The pages of the experiment: of one run, and of all runs.

use anyhow::Result;
use carom_report::page::{Layout, Page};
use carom_runs::output::Folder;
use carom_tables::Summary;

use super::{Options, Plan, analysis::Analysis, charts::Charts, group::Group, results::title, system};
use crate::experiments::thesis_scene::{Case, Size};

/// The page of one run in its folder.
///
/// # Errors
/// A picture of the run is missing.
pub fn page_of_one_run(
    analysis: &Analysis<'_>,
    summary: &Summary,
    plan: &Plan,
    options: &Options,
    folder: &Folder,
) -> Result<Page> {
    let Analysis { group, size, equilibrium, charts: drawn, distributions } = analysis;
    let mut page = Page::new(&summary.title, group.case.words());
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    question(&mut page, options.area_fraction);
    page.heading("Runs");
    setting(&mut page, group, *size, plan);
    totals(&mut page, summary);
    system::of_one_run(&mut page, group, drawn, folder, plan)?;
    page.heading("Results");
    equilibrium.show(&mut page);
    page.subheading("Figures");
    page.figures(&summary.figures);
    charts(&mut page, group, drawn);
    distributions.show(&mut page, group.case);
    reproduction(&mut page, &options.command(plan));
    data(&mut page, group.kicks.hits(), options.impulses);
    page.links(["impulses.csv", "directions.csv", "kicks-along-axes.csv", "contact-density.csv"]);
    page.links(["running-average.csv", "energy.csv", "collision-rate.csv", "atoms.csv", "flights.csv"]);
    page.links(["start.extxyz", "end.extxyz", "summary.json", "manifest.json", "config.toml"]);
    Ok(page)
}

/// The page of all runs; the folder holds those of each run.
///
/// # Errors
/// A picture of a run is missing.
pub fn page_of_all_runs(
    analyses: &[Analysis<'_>],
    summary: &Summary,
    plan: &Plan,
    options: &Options,
    folder: &Folder,
) -> Result<Page> {
    let mut page = Page::new(&summary.title, "A T of five discs, and a disc, in a gas of discs.");
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    question(&mut page, options.area_fraction);
    page.heading("Runs");
    totals(&mut page, summary);
    page.heading("System");
    if let Some(first) = analyses.iter().flat_map(Analysis::run_names).next() {
        page.paragraph(&format!("Run {first}; each run has its own page and animation."));
        let first = folder.inner(&first)?;
        system::moving(&mut page, &first, plan)?;
        system::before_and_after(&mut page, &first, plan)?;
    }
    for analysis in analyses {
        section(&mut page, analysis, plan, folder)?;
    }
    reproduction(&mut page, &options.command(plan));
    page.links(["summary.json", "manifest.json", "config.toml"]);
    Ok(page)
}

/// Results of one case and size on the page of all runs.
fn section(page: &mut Page, analysis: &Analysis<'_>, plan: &Plan, folder: &Folder) -> Result<()> {
    let Analysis { group, size, equilibrium, charts: drawn, distributions } = analysis;
    page.heading(&title(group.case, *size));
    setting(page, group, *size, plan);
    let names = analysis.run_names();
    system::of_molecule(page, group, drawn, &folder.inner(&names[0])?)?;
    equilibrium.show(page);
    page.subheading("Figures");
    page.figures(&group.figures());
    charts(page, group, drawn);
    distributions.show(page, group.case);
    let reports: Vec<String> = names.iter().map(|name| format!("{name}/report.html")).collect();
    page.links(reports.iter().map(String::as_str));
    Ok(())
}

/// Totals and checks of all runs.
fn totals(page: &mut Page, summary: &Summary) {
    page.totals(&summary.totals);
    if !summary.runs.is_empty() {
        page.runs(&summary.runs);
    }
    page.subheading("Checks");
    page.checks(&summary.checks);
}

fn reproduction(page: &mut Page, command: &str) {
    page.heading("Reproduction");
    page.paragraph("The same seed gives the same figures to the last bit for any number of threads.");
    page.code(command);
}

/// Description of the data files.
fn data(page: &mut Page, hits: u64, most: u64) {
    page.heading("Data");
    let rows = if hits > most { format!("the first {most} of {hits}") } else { format!("all {hits}") };
    page.paragraph(&format!(
        "impulses.csv lists {rows} kicks by the gas, one row each: time, touched atom, number of the disc, \
         unit vector of the impulse, and the impulse in the frame of the box and in the body frame. \
         start.extxyz and end.extxyz can be read by OVITO and ASE; for a trajectory, pass config.toml to \
         cargo xtask run with --set run.snapshots=extxyz."
    ));
}

/// Description of the question.
fn question(page: &mut Page, area_fraction: f64) {
    page.heading("Question");
    page.paragraph(&format!(
        "Does a molecule that gas discs cannot touch from every side receive a net force along its body \
         axes? A T of five discs is placed in a gas of area fraction {area_fraction} in a periodic unit \
         square. Every impulse on it is recorded by its direction in the body frame: x′ along the bar of the \
         T, y′ from the stem to the bar. The control is a disc of the same area and mass. After Montanari \
         (2017), chapter 3."
    ));
}

/// Description of the runs.
fn setting(page: &mut Page, group: &Group<'_>, size: Size, plan: &Plan) {
    let first = &group.runs[0];
    page.facts(&[
        ("molecule", group.case.words().to_owned()),
        ("relative size of its atoms", size.name()),
        ("gas", format!("{:.0} discs of radius 0.01, mass 1, energy 1 each at the start", first.density)),
        (
            "measured",
            format!("from t = {} to {}, sampled every {}", plan.from, plan.until, plan.sample_interval),
        ),
        ("runs", group.runs.len().to_string()),
        ("kicks by the gas", group.kicks.hits().to_string()),
    ]);
}

/// Charts of a group, with captions.
fn charts(page: &mut Page, group: &Group<'_>, charts: &Charts) {
    let step = "The orange-red line is exact for a dilute gas: the weight of each direction is the number of \
                atoms that a gas disc can touch from the opposite side. In a dense gas the steps remain at the same \
                angles, but the levels tilt, because the density is larger in the corners.";
    let even = "The kicks on a disc are isotropic at any density.";
    let caption = if group.case == Case::Control { even } else { step };
    page.pictures(Layout::Full, &[(&charts.impulse, caption), (&charts.counts, "Number of kicks.")]);
    let polar = "0° is x′, 90° is y′. The direction is that of the impulse on the molecule, away from the point of contact.";
    page.pictures(Layout::Beside, &[(&charts.polar, polar), (&charts.polar_counts, "Number of kicks.")]);
    let force = "Running average as in the thesis. At equilibrium it tends to 0 along both axes at any \
                 density; the band is one standard error of one run.";
    page.pictures(Layout::Full, &[(&charts.force, force)]);
}
