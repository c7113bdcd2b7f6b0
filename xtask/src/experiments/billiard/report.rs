//! Tables, charts and page of the experiment.

use anyhow::Result;
use carom_report::{
    molecule_picture,
    page::{Layout, Page},
    plot::{Axis, Chart, Layer, Shape, colour, staircase},
    polar::Polar,
};
use carom_runs::output::Folder;
use carom_tables::Summary;

use super::{
    Setup,
    flights::{BLOCKS, Hits, SECTORS},
    results::Comparison,
};

/// Writes all files except the summary.
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
) -> Result<()> {
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
    let chart = chart(setup, hits, comparison)?;
    folder.write("directions.svg", &chart)?;
    let [polar, deviations] = [polar(setup, hits, comparison)?, deviations(hits, comparison)?];
    folder.write("polar.svg", &polar)?;
    folder.write("deviations.svg", &deviations)?;
    let molecule = molecule_picture::svg(&setup.molecule, &setup.region, setup.gas_radius);
    folder.write("molecule.svg", &molecule)?;
    folder.write(
        "report.html",
        page(setup, hits, summary, command, [&chart, &molecule, &polar, &deviations]).html(),
    )
}

/// Inverse of the share of hits in a sector to which one atom is exposed.
fn unit(setup: &Setup) -> f64 {
    let level = (setup.atom_radius + setup.gas_radius) * (360.0 / SECTORS as f64).to_radians();
    setup.region.perimeter() / level
}

/// Histogram in units of the share of one atom: its levels are integers.
fn chart(setup: &Setup, hits: &Hits, comparison: &Comparison) -> Result<String> {
    let (unit, total) = (unit(setup), hits.total() as f64);
    let measured: Vec<f64> = hits.directions.iter().map(|&count| unit * count as f64 / total).collect();
    let errors: Vec<f64> =
        hits.directions.iter().map(|&count| unit * (count as f64).sqrt() / total).collect();
    let predicted: Vec<f64> = comparison.directions.iter().map(|share| unit * share).collect();
    let edge = |sign: f64| -> Vec<f64> {
        measured.iter().zip(&errors).map(|(value, error)| value + sign * error).collect()
    };
    let band = staircase(0.0, 360.0, &edge(-1.0)).into_iter().zip(staircase(0.0, 360.0, &edge(1.0)));
    let band = band.map(|((x, low), (_, high))| (x, low, high)).collect();
    let top = predicted.iter().copied().fold(1.0, f64::max);
    let layer = |name: &str, colour, shape| Layer { name: name.to_owned(), colour, shape };
    Chart {
        title: "Hits by direction".to_owned(),
        x: Axis { label: "direction of the impulse on the molecule [°]".to_owned(), range: (0.0, 360.0) },
        y: Axis { label: "hits, in units of one exposed atom".to_owned(), range: (0.0, 1.3 * top) },
        layers: vec![
            layer("one standard error", colour::BLUE, Shape::Band(band)),
            layer("measured", colour::BLUE, Shape::Thin(staircase(0.0, 360.0, &measured))),
            layer("exposed atoms N(φ)", colour::VERMILLION, Shape::Line(staircase(0.0, 360.0, &predicted))),
        ],
    }
    .svg()
}

/// Polar chart of the hits by direction.
fn polar(setup: &Setup, hits: &Hits, comparison: &Comparison) -> Result<String> {
    let (unit, total) = (unit(setup), hits.total() as f64);
    let measured = hits.directions.iter().map(|&count| unit * count as f64 / total).collect();
    let predicted = comparison.directions.iter().map(|share| unit * share).collect();
    Polar {
        title: "Hits by direction, polar chart".to_owned(),
        label: "radius: hits, in units of one exposed atom".to_owned(),
        curves: vec![
            ("measured".to_owned(), colour::BLUE, measured),
            ("exposed atoms N(φ)".to_owned(), colour::VERMILLION, predicted),
        ],
        errors: hits.directions.iter().map(|&count| unit * (count as f64).sqrt() / total).collect(),
    }
    .svg()
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
        x: Axis { label: "measured minus predicted [standard errors]".to_owned(), range: (-most, most) },
        y: Axis { label: "share of sectors per standard error".to_owned(), range: (0.0, 1.4 * top) },
        layers: vec![
            layer("sectors", colour::BLUE, Shape::Line(staircase(-most, most, &found))),
            layer("Gaussian distribution", colour::VERMILLION, Shape::Line(curve)),
        ],
    }
    .svg()
}

fn page(setup: &Setup, hits: &Hits, summary: &Summary, command: &str, charts: [&str; 4]) -> Page {
    let mut page = Page::new(
        &summary.title,
        "A disc moves around a fixed molecule in a periodic box. Its mean free path, and the distributions \
         of directions and atoms that it hits, follow from the boundary of the region that its centre cannot \
         enter.",
    );
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.heading("Runs");
    page.facts(&[
        (
            "molecule",
            format!(
                "{}, {} atoms of radius {}",
                setup.shape,
                setup.molecule.atoms().len(),
                setup.atom_radius
            ),
        ),
        ("radius of the disc", setup.gas_radius.to_string()),
        ("side of the box", format!("{:.6}", setup.side)),
        ("flights", (hits.blocks.len() / BLOCKS).to_string()),
        ("hits", hits.total().to_string()),
    ]);
    page.totals(&summary.totals);
    page.subheading("Checks");
    page.checks(&summary.checks);
    page.heading("Results");
    page.figures(&summary.figures);
    show_charts(&mut page, charts);
    page.paragraph(
        "The error of the mean free path is from the scatter of blocks: the box has straight corridors of \
         infinite length, along which single free paths have infinite variance. The disc starts at a random \
         free position with a random direction, which is the stationary state.",
    );
    page.heading("Reproduction");
    page.paragraph("The same seed gives the same figures to the last bit for any number of threads.");
    page.code(command);
    page.links(["directions.csv", "atoms.csv", "blocks.csv", "summary.json", "manifest.json", "config.toml"]);
    page
}

/// Charts of the directions, pictures of the molecule, and the deviations, with captions.
fn show_charts(page: &mut Page, [chart, molecule, polar, deviations]: [&str; 4]) {
    page.pictures(
        Layout::Full,
        &[(
            chart,
            "Directions of the impulse, opposite to the normal. Each atom exposed to a direction adds one \
             level; there are no others. One bin for each degree.",
        )],
    );
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
    page.pictures(
        Layout::Full,
        &[(
            deviations,
            "Deviations of the sectors from their predictions. Statistical errors alone follow the curve; \
             values beyond the axis are counted in the last bars.",
        )],
    );
}
