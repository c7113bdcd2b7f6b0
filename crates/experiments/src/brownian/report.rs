//! The pages of the experiment: of one run, and of all runs. Each begins with the verdict and the
//! charts that carry it.

use anyhow::Result;
use carom_report::{
    molecule_picture::name,
    page::{Layout, Page, Part, with_error},
};
use carom_runs::output::Folder;
use carom_tables::Summary;

use super::{analysis::Analysis, campaign::Campaign, charts::Charts, group::Group, plan::Plan, system};

/// The question that the experiment answers.
const QUESTION: &str = "Does a molecule that gas discs cannot touch from every side receive a net force along its \
                        body axes? Every impulse on it is recorded by its direction in the body frame: x′ and y′ are \
                        the axes in which its atoms are given. The control is a disc of the same area and mass. After \
                        Montanari (2017), chapter 3.";

/// The page of one run in its folder.
///
/// # Errors
/// A picture of the run is missing.
pub fn page_of_one_run(
    analysis: &Analysis<'_>,
    summary: &Summary,
    campaign: &Campaign<'_>,
    folder: &Folder,
) -> Result<Page> {
    let mut page = Page::new(&summary.title, QUESTION);
    page.verdict(&analysis.equilibrium.sentence());
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.part(Part::Answer);
    carriers(&mut page, analysis);
    system::moving(&mut page, folder, &campaign.plan)?;
    page.part(Part::Results);
    page.heading("Molecule and gas");
    setting(&mut page, &analysis.group, &campaign.plan);
    system::before_and_after(&mut page, folder, &campaign.plan)?;
    results(&mut page, analysis);
    data(&mut page, analysis.group.kicks.hits(), campaign.impulses);
    page.links(["impulses.csv", "directions.csv", "kicks-along-axes.csv"]);
    if !analysis.group.is_mixed() {
        page.links(["contact-density.csv"]);
    }
    page.links(["exposed-arcs.csv", "running-average.csv", "energy.csv", "collision-rate.csv", "atoms.csv"]);
    page.links([
        "kicks-polar.svg",
        "start.svg",
        "flights.csv",
        "start.extxyz",
        "end.extxyz",
        "summary.json",
        "manifest.json",
        "config.toml",
    ]);
    reproduction(&mut page, &campaign.command);
    totals(&mut page, summary);
    Ok(page)
}

/// The page of all runs; the folder holds those of each run.
///
/// # Errors
/// A picture of a run is missing.
pub fn page_of_all_runs(
    analyses: &[Analysis<'_>],
    summary: &Summary,
    campaign: &Campaign<'_>,
    folder: &Folder,
) -> Result<Page> {
    let mut page = Page::new(&summary.title, QUESTION);
    let [first, others @ ..] = analyses else { return Ok(page) };
    let title = |analysis: &Analysis<'_>| capitalised(&analysis.group.setting.title);
    page.verdict(&format!("{}. {}", title(first), first.equilibrium.sentence()));
    page.part(Part::Answer);
    for other in others {
        page.paragraph(&format!("{}. {}", title(other), other.equilibrium.sentence()));
    }
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    carriers(&mut page, first);
    if let Some(name) = first.run_names().first() {
        system::moving(&mut page, &folder.inner(name)?, &campaign.plan)?;
        page.paragraph(&format!("This is run {name}; each run has a page of its own with an animation."));
    }
    page.part(Part::Results);
    for (index, analysis) in analyses.iter().enumerate() {
        page.heading(&title(analysis));
        let names = analysis.run_names();
        setting(&mut page, &analysis.group, &campaign.plan);
        // The pages of the runs have all pictures.
        if index == 0 {
            system::before_and_after(&mut page, &folder.inner(&names[0])?, &campaign.plan)?;
        } else {
            carriers(&mut page, analysis);
        }
        results(&mut page, analysis);
        page.links([format!("{}-kicks-polar.svg", analysis.group.setting.name).as_str()]);
        let reports: Vec<String> = names.iter().map(|name| format!("{name}/report.html")).collect();
        page.links(reports.iter().map(String::as_str));
    }
    reproduction(&mut page, &campaign.command);
    page.links(["summary.json", "manifest.json", "config.toml"]);
    totals(&mut page, summary);
    Ok(page)
}

/// The molecule, and the charts that carry the verdict.
fn carriers(page: &mut Page, analysis: &Analysis<'_>) {
    let Analysis { group, charts, distributions, .. } = analysis;
    let disc = if group.is_mixed() { "the smallest disc around it" } else { "a gas disc" };
    let molecule = format!(
        "The molecule in its body frame (x′, y′). The line bounds the region that the centre of {disc} (dashed) \
         cannot enter; each arc belongs to the touched atom. An atom with a dashed outline cannot be touched."
    );
    let polar = "Impulse by direction: 0° is x′, 90° is y′. The direction is that of the impulse on the \
                 molecule, away from the point of contact.";
    page.pictures(Layout::Beside, &[(&charts.molecule, &molecule), (&charts.polar, polar)]);
    let force = "Mean force on the molecule, averaged as in the thesis. At equilibrium it tends to 0 along both \
                 axes at any density; the band is one standard error of one run.";
    let velocity = distributions.velocity_caption();
    page.pictures(Layout::Beside, &[(&distributions.velocity, &velocity), (&charts.force, force)]);
}

/// Tests, figures and charts of the runs of one molecule.
fn results(page: &mut Page, analysis: &Analysis<'_>) {
    let Analysis { group, equilibrium, charts: drawn, distributions } = analysis;
    equilibrium.show(page);
    page.subheading("Figures");
    page.figures(&group.overall_figures());
    atoms(page, group);
    page.subheading("Directions and distributions");
    charts(page, group, drawn);
    distributions.show(page, group);
}

/// A row for each atom: how much of it the gas can touch, and how often it does.
fn atoms(page: &mut Page, group: &Group<'_>) {
    let figures = group.atom_figures();
    if figures.is_empty() {
        return;
    }
    page.subheading("Atoms");
    page.paragraph(if group.is_mixed() {
        "The exposed angle is that of all directions from which the smallest disc around the molecule can touch \
         the atom, computed from the atoms."
    } else {
        "The exposed angle is that of all directions from which a gas disc can touch the atom, computed from \
         the atoms. In a dilute gas the share of the kicks follows from it; in a dense gas the density is \
         larger in the corners."
    });
    let row = |(atom, figure): (usize, &carom_tables::Figure)| {
        let degrees = group.prediction.boundary.exposed_angle(atom).to_degrees();
        vec![
            name(atom),
            format!("{degrees:.2}°"),
            figure.prediction.map_or_else(String::new, |share| format!("{share:.4}")),
            with_error(figure.value, figure.standard_error),
        ]
    };
    let predicted = if group.is_mixed() { "share of kicks, predicted" } else { "share of kicks, dilute gas" };
    let header = ["atom", "exposed angle", predicted, "measured"];
    page.table(&header, &figures.iter().enumerate().map(row).collect::<Vec<_>>());
}

/// Totals and checks of all runs.
fn totals(page: &mut Page, summary: &Summary) {
    page.checks(&summary.checks);
    page.totals(&summary.totals);
    page.part(Part::Checks);
    if !summary.runs.is_empty() {
        page.runs(&summary.runs);
    }
}

fn reproduction(page: &mut Page, command: &str) {
    page.part(Part::Again);
    page.paragraph("The same seed gives the same figures to the last bit for any number of threads.");
    page.code(command);
}

/// Description of the data files.
fn data(page: &mut Page, hits: u64, most: u64) {
    page.part(Part::Data);
    let rows = if hits > most { format!("the first {most} of {hits}") } else { format!("all {hits}") };
    page.paragraph(&format!(
        "impulses.csv lists {rows} kicks by the gas, one row each: time, touched atom, number of the disc, \
         unit vector of the impulse, and the impulse in the frame of the box and in the body frame. \
         exposed-arcs.csv has the arcs of the boundary of the excluded region. start.extxyz and end.extxyz can \
         be read by OVITO and ASE; for a trajectory, pass config.toml to carom run with --set \
         run.snapshots=extxyz."
    ));
}

/// What a mixture of bodies lacks.
const NO_PREDICTIONS: &str = "Predictions of rates, of densities at the rim and of shares of kicks, in a thin or a \
                              dense gas, exist for one gas of equal discs only: here there are none, and the gas \
                              density along the boundary is not measured. The excluded region is that of the \
                              smallest disc, or of the smallest atom of all bodies that move. The means that \
                              equilibrium sets to zero, equipartition and mirror symmetry hold in any surroundings, \
                              and so do the isotropic kicks on the control disc.";

/// Description of the runs.
fn setting(page: &mut Page, group: &Group<'_>, plan: &Plan) {
    let first = &group.runs[0];
    let [width, height] = group.setting.scene.bounds.sides;
    let discs = first.density * group.setting.area();
    let gas = if group.is_mixed() {
        format!("{discs:.0} bodies that move: {}", group.surroundings.words())
    } else {
        format!(
            "{discs:.0} discs of radius {}, mass {}: area fraction {}",
            group.prediction.gas_radius,
            group.prediction.gas_mass,
            with_error(group.prediction.area_fraction(first.density), None)
        )
    };
    page.facts(&[
        ("molecule", group.setting.words.clone()),
        ("gas", gas),
        ("box", format!("{width} × {height}")),
        (
            "measured",
            format!("from t = {} to {}, sampled every {}", plan.from, plan.until, plan.sample_interval),
        ),
        ("runs", group.runs.len().to_string()),
        ("kicks by the gas", group.kicks.hits().to_string()),
    ]);
    if group.is_mixed() {
        page.paragraph(NO_PREDICTIONS);
    }
}

/// Charts of a group, with captions.
fn charts(page: &mut Page, group: &Group<'_>, charts: &Charts) {
    let step = "The orange-red line is exact for a dilute gas: the weight of each direction is the number of \
                atoms that a gas disc can touch from the opposite side. In a dense gas the steps remain at the same \
                angles, but the levels tilt, because the density is larger in the corners.";
    let even = "The kicks on a disc are isotropic at any density.";
    let none = "Kicks by the bodies of a mixture: the weights of the directions differ by their sizes, and no \
                prediction is drawn.";
    let caption = match (group.is_round(), group.is_mixed()) {
        (true, _) => even,
        (false, true) => none,
        (false, false) => step,
    };
    let counts = "Number of kicks. The polar chart is kicks-polar.svg.";
    page.pictures(Layout::Full, &[(&charts.impulse, caption), (&charts.counts, counts)]);
}

/// The text with a capital first letter.
fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
