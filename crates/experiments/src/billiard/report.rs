//! Tables, charts and page of the experiment.

use anyhow::Result;
use carom_report::{
    molecule_picture,
    page::{Layout, Page, Part, checks_in_words, with_error},
    plot::{Axis, Chart, Layer, Shape, colour, staircase},
    polar::Polar,
};
use carom_runs::output::Folder;
use carom_tables::Summary;

use crate::direction_chart::directions;

use super::{
    Mover, Setup,
    flights::{BLOCKS, Hits, SECTORS},
    results::Comparison,
};

/// Writes all tables and pictures, and returns the page.
///
/// # Errors
/// A file cannot be written, or a value is not finite.
pub fn write(
    folder: &Folder,
    setup: &Setup,
    hits: &Hits,
    comparison: &Comparison,
    summary: &Summary,
    command: &str,
) -> Result<Page> {
    let total = hits.total() as f64;
    let width = 360.0 / SECTORS as f64;
    let directions = hits.directions.iter().zip(&comparison.directions).enumerate();
    let rows = directions.map(|(sector, (&count, &share))| {
        let expected = total * share;
        let from = width * sector as f64;
        (from, from + width, count, expected, (count as f64 - expected) / expected.sqrt())
    });
    let header = ["from_degrees", "to_degrees", "hits", "predicted", "deviation_in_standard_errors"];
    folder.write_table("directions.csv", &header, rows)?;
    let atoms = hits.atoms.iter().zip(&comparison.atoms).enumerate();
    let rows = atoms.map(|(atom, (&count, &share))| (atom, count, total * share));
    folder.write_table("atoms.csv", &["atom", "hits", "predicted"], rows)?;
    let rows = hits
        .blocks
        .iter()
        .enumerate()
        .map(|(index, &count)| (index / BLOCKS, index % BLOCKS, hits.path, count));
    folder.write_table("blocks.csv", &["flight", "block", "path", "hits"], rows)?;
    let [chart, polar] = by_direction(setup, hits, comparison)?;
    let deviations = deviations(hits, comparison)?;
    folder.write("directions.svg", &chart)?;
    folder.write("polar.svg", &polar)?;
    folder.write("deviations.svg", &deviations)?;
    let molecule = molecule_picture::svg(&setup.named.molecule, &setup.region, setup.disc_radius);
    folder.write("molecule.svg", &molecule)?;
    Ok(page(setup, hits, comparison, summary, command, [&chart, &molecule, &polar, &deviations]))
}

/// Inverse of the share of hits in a sector to which one atom is exposed, or, where levels are not
/// integers, in a mean sector; and the unit in words.
fn unit(setup: &Setup) -> (f64, &'static str) {
    if setup.has_integer_levels() {
        let width = (360.0 / SECTORS as f64).to_radians();
        let level = (setup.named.molecule.atoms()[0].radius() + setup.disc_radius) * width;
        (setup.region.perimeter() / level, "hits, in units of one exposed atom")
    } else {
        (SECTORS as f64, "hits, by the mean of all directions")
    }
}

/// Histogram and polar chart of the hits by direction.
fn by_direction(setup: &Setup, hits: &Hits, comparison: &Comparison) -> Result<[String; 2]> {
    let (unit, label) = unit(setup);
    let unit_of_hits = unit / hits.total() as f64;
    let counts = || hits.directions.iter().map(|&count| count as f64);
    let measured: Vec<f64> = counts().map(|count| unit_of_hits * count).collect();
    let errors: Vec<f64> = counts().map(|count| unit_of_hits * count.sqrt()).collect();
    let predicted: Vec<f64> = comparison.directions.iter().map(|share| unit * share).collect();
    let name = if setup.turns() { "prediction" } else { "exposed atoms N(φ)" };
    let curves = [measured, errors, predicted];
    let chart = directions("Hits by direction", label, &curves, name)?;
    let [measured, errors, predicted] = curves;
    let polar = Polar {
        title: "Hits by direction, polar chart".to_owned(),
        label: format!("radius: {label}"),
        curves: vec![
            ("measured".to_owned(), colour::BLUE, measured),
            (name.to_owned(), colour::VERMILLION, predicted),
        ],
        errors,
    };
    Ok([chart, polar.svg()?])
}

/// Deviation of each sector from its prediction, in standard errors.
fn deviations(hits: &Hits, comparison: &Comparison) -> Result<String> {
    let total = hits.total() as f64;
    let sectors = hits.directions.iter().zip(&comparison.directions);
    let values: Vec<f64> = sectors
        .filter(|(_, share)| **share > 0.0)
        .map(|(&count, share)| (count as f64 - total * share) / (total * share).sqrt())
        .collect();
    // Density of the deviations compared with a Gaussian, in bins of a quarter of a standard error.
    let (most, bins) = (5.0, 40);
    let width = 2.0 * most / f64::from(bins);
    let mut found = vec![0.0; bins as usize];
    for value in &values {
        let bin = ((value + most) / width).clamp(0.0, f64::from(bins) - 1.0) as usize;
        found[bin] += 1.0 / (values.len() as f64 * width);
    }
    let gauss = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let curve = (0..=200).map(|step| most * (0.01 * f64::from(step) - 1.0)).map(|x| (x, gauss(x))).collect();
    let top = found.iter().copied().fold(gauss(0.0), f64::max);
    let layer = |name: &str, colour, shape| Layer { name: name.to_owned(), colour, shape };
    Chart {
        title: "Deviations from the prediction".to_owned(),
        x: Axis { label: "measured minus predicted (standard errors)".to_owned(), range: (-most, most) },
        y: Axis { label: "share of sectors per standard error".to_owned(), range: (0.0, 1.4 * top) },
        layers: vec![
            layer("sectors", colour::BLUE, Shape::Line(staircase(-most, most, &found))),
            layer("Gaussian distribution", colour::VERMILLION, Shape::Line(curve)),
        ],
    }
    .svg()
}

fn page(
    setup: &Setup,
    hits: &Hits,
    comparison: &Comparison,
    summary: &Summary,
    command: &str,
    charts: [&str; 4],
) -> Page {
    let mut page = Page::new(
        &summary.title,
        &format!(
            "{} The mean {} between hits, and the distributions of directions and atoms that are hit, follow \
             from the boundary of the region around the molecule that the centre of a disc cannot enter.",
            match setup.mover {
                Mover::Disc => "A disc moves around a fixed molecule in a periodic box.",
                Mover::Molecule => "A molecule moves among fixed discs in a periodic box.",
                Mover::LockedMolecule =>
                    "A molecule moves among fixed discs in a periodic box and never turns.",
            },
            if setup.turns() { "time" } else { "path" },
        ),
    );
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.verdict(&verdict(hits, comparison, summary));
    let sides = setup.obstacles.sides();
    page.part(Part::Answer);
    show_evidence(&mut page, charts);
    page.part(Part::Results);
    page.heading("The scene");
    page.facts(&[
        ("molecule", molecule_in_words(setup)),
        ("radius of a disc", setup.disc_radius.to_string()),
        ("fixed obstacles", setup.obstacles.count.to_string()),
        ("sides of the box", format!("{:.6} × {:.6}", sides.x, sides.y)),
        ("flights", (hits.blocks.len() / BLOCKS).to_string()),
        ("hits", hits.total().to_string()),
    ]);
    page.totals(&summary.totals);
    page.checks(&summary.checks);
    page.heading("Figures");
    page.figures(&summary.figures);
    show_charts(&mut page, charts);
    page.paragraph(
        "The error of the mean is from the scatter of blocks: where the box has straight corridors of infinite \
         length, single free paths have infinite variance. Each flight starts at a random free position with a \
         random velocity, which is the stationary state.",
    );
    page.part(Part::Again);
    page.paragraph("The same seed gives the same figures to the last bit for any number of threads.");
    page.code(command);
    page.links(["directions.csv", "atoms.csv", "blocks.csv", "summary.json", "manifest.json", "config.toml"]);
    page
}

/// The mean and the p-values in a sentence, then the checks.
fn verdict(hits: &Hits, comparison: &Comparison, summary: &Summary) -> String {
    let [of_directions, of_atoms] =
        [comparison.of_directions, comparison.of_atoms].map(|chi| format!("{:.2}", chi.p_value()));
    let mean = summary.figures.first().map_or_else(String::new, |mean| {
        let predicted = with_error(mean.prediction.unwrap_or(f64::NAN), None);
        let measured = with_error(mean.value, mean.standard_error);
        format!(
            "The {} of {} hits is {measured}; integral geometry gives {predicted}. ",
            mean.name,
            hits.total()
        )
    });
    format!(
        "{mean}Directions and atoms are hit as predicted with p = {of_directions} and {of_atoms}. {}",
        checks_in_words(&summary.checks)
    )
}

fn molecule_in_words(setup: &Setup) -> String {
    let atoms = setup.named.molecule.atoms();
    let radii = || atoms.iter().map(carom::Atom::radius);
    let (least, most) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
    let range = if least == most { format!("{most}") } else { format!("{least} to {most}") };
    format!("{}, {} atoms of radius {range}", setup.named.name, atoms.len())
}

/// The directions of the hits, and their deviations from the prediction.
fn show_evidence(page: &mut Page, [chart, _, _, deviations]: [&str; 4]) {
    let of_directions = "Directions of the impulse on the molecule in its own frame, opposite to the normal, one bin \
                         for each degree. Where all atoms are equal and nothing turns, each atom exposed to a \
                         direction adds one level.";
    let of_deviations = "Deviations of the sectors from their predictions. Statistical errors alone follow the \
                         curve; values beyond the axis are counted in the last bars.";
    page.pictures(Layout::Beside, &[(chart, of_directions), (deviations, of_deviations)]);
}

/// Pictures of the molecule and of the directions, with captions.
fn show_charts(page: &mut Page, [_, molecule, polar, _]: [&str; 4]) {
    page.pictures(
        Layout::Beside,
        &[
            (
                molecule,
                "The molecule, and the boundary of the region that the disc's centre cannot enter. An atom \
                 with a dashed outline cannot be touched.",
            ),
            (polar, "0° is x′, 90° is y′. The direction is that of the impulse on the molecule."),
        ],
    );
}
