//! Further charts of the experiment: Δp along the axes, gas density at the boundary, and mean
//! velocity over time.

use anyhow::Result;
use carom::{
    ContactDensity, ProjectionHistogram,
    observers::{Block, ContactPoint, Drift},
};
use carom_report::{
    molecule_picture::name as letter,
    page::{Layout, Page},
    plot::{Axis, Chart, Layer, Shape, colour, staircase},
};
use plotters::style::RGBColor;

use super::{
    charts::band_of_one_run,
    group::Group,
    pooled::{MIN_BLOCKS, Pooled},
    results::{PROJECTION_BINS, projection_range},
};

/// The charts, as SVG.
#[derive(Debug, Clone)]
pub struct Distributions {
    /// Distribution of Δp along x′.
    pub along_x: String,
    /// Distribution of Δp along y′.
    pub along_y: String,
    /// Gas density along the boundary of the excluded region; none in a mixture, where it differs
    /// by size.
    pub contacts: Option<String>,
    /// The running average of the velocity.
    pub velocity: String,
    /// Source of the error bands of the contact density.
    errors_of_contacts: Errors,
    /// Source of the error band of the mean velocity.
    errors_of_velocity: Errors,
}

/// Source of an error band.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Errors {
    /// Scatter of blocks of time.
    Blocks,
    /// Assumption of independent contacts or samples.
    Independence,
}

impl Errors {
    /// [`Errors::Independence`] if there are too few blocks.
    fn of(from_blocks: Option<f64>) -> Self {
        if from_blocks.is_some() { Self::Blocks } else { Self::Independence }
    }

    /// Source of the standard error of `events`, as the end of a sentence.
    fn source(self, events: &str) -> String {
        match self {
            Self::Blocks => "from the scatter of blocks of time".to_owned(),
            Self::Independence => format!(
                "as if {events} were independent of each other, because there are too few blocks of time \
                 (fewer than {MIN_BLOCKS})"
            ),
        }
    }
}

/// Header of the table of Δp along the axes.
pub const PROJECTION_HEADER: [&str; 8] = [
    "from",
    "to",
    "density_x",
    "density_x_standard_error",
    "density_y",
    "density_y_standard_error",
    "gaussian_of_disc",
    "centre",
];

/// Header of the table of the gas along the boundary.
pub const CONTACT_HEADER: [&str; 6] =
    ["atom", "normal_degrees", "arc", "contacts", "density", "density_standard_error"];

impl Distributions {
    /// Draws the charts.
    ///
    /// # Errors
    /// A value is not finite.
    pub fn draw(group: &Group<'_>) -> Result<Self> {
        Ok(Self {
            along_x: projection(group, 0, "x′")?,
            along_y: projection(group, 1, "y′")?,
            contacts: if group.is_mixed() { None } else { Some(contacts(group)?) },
            velocity: velocity(group)?,
            errors_of_contacts: errors_of_contacts(group),
            errors_of_velocity: Errors::of(group.error_of_one_run(Drift::path)),
        })
    }

    /// File names and contents of the charts.
    pub fn files(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let contacts = self.contacts.as_deref().map(|chart| ("contact-density.svg", chart));
        [
            ("kicks-along-x.svg", self.along_x.as_str()),
            ("kicks-along-y.svg", &self.along_y),
            ("mean-velocity.svg", &self.velocity),
        ]
        .into_iter()
        .chain(contacts)
    }

    /// Adds the charts except that of the velocity to a page, with captions.
    pub fn show(&self, page: &mut Page, group: &Group<'_>) {
        let kicks = if group.is_round() && group.is_mixed() {
            "Distribution of Δp of the disc along x′: isotropic, and a sum of Gaussians of variance 4μkT, one \
             for each mass of the gas."
        } else if group.is_round() {
            "Distribution of Δp of the disc along x′. The line is exact at any density: a Rayleigh \
             distribution of magnitudes in isotropic directions is a Gaussian of variance 4μkT along each \
             axis."
        } else {
            "Distribution of Δp along x′. It is not Gaussian: the directions are not isotropic, and if the \
             molecule can rotate, contacts far from its centre have a smaller reduced mass."
        };
        page.pictures(Layout::Full, &[(&self.along_x, kicks), (&self.along_y, "Δp along y′.")]);
        let Some(contacts) = &self.contacts else { return };
        let gas = format!(
            "Σ|J| / (t ds) divided by nkT is the density of gas centres at contact, in units of the mean \
             density, along the boundary that they cannot cross. Each line belongs to the touched atom; an \
             atom without a line cannot be reached. In a dilute gas all values would be 1; here the density \
             is larger in the corners, at the ends of the lines. The bands are standard errors {}.",
            self.errors_of_contacts.source("contacts")
        );
        page.pictures(Layout::Full, &[(contacts, &gas)]);
    }

    /// Caption of the running average of the velocity.
    pub fn velocity_caption(&self) -> String {
        format!(
            "Mean velocity of the molecule along its body axes since the start of the measurement, from its \
             path. At equilibrium it tends to 0; the band is one standard error, {}.",
            self.errors_of_velocity.source("samples")
        )
    }
}

/// Density of Δp along one axis in one bin, with its standard error.
fn density(group: &Group<'_>, axis: usize, bin: usize) -> (f64, f64) {
    let pair = |block: &Block<ProjectionHistogram>| {
        (block.observed.components().counts()[bin] as f64, block.observed.hits() as f64)
    };
    let pooled = Pooled::of(group.runs, |run| &run.projections[axis], pair);
    let width = 2.0 * range(group) / PROJECTION_BINS as f64;
    // With too few blocks: the error for independent kicks.
    let independent = pooled.sum().sqrt() / pooled.weight().max(1.0);
    (pooled.mean() / width, pooled.standard_error().unwrap_or(independent) / width)
}

/// Largest Δp of the histograms (mass × length / time).
fn range(group: &Group<'_>) -> f64 {
    let [mass, gas_mass] = [group.molecule().mass(), group.prediction.gas_mass];
    projection_range(mass, gas_mass, group.runs[0].booked_temperature)
}

/// Gaussian distribution of the impulse components on a disc: variance 4μkT, exact at equilibrium
/// at any density.
fn gaussian(group: &Group<'_>, component: f64) -> f64 {
    let [mass, gas_mass] = [group.molecule().mass(), group.prediction.gas_mass];
    let variance = 4.0 * group.temperature() * mass * gas_mass / (mass + gas_mass);
    (-0.5 * component * component / variance).exp() / (std::f64::consts::TAU * variance).sqrt()
}

/// The table of Δp along the axes.
pub fn projection_rows(group: &Group<'_>) -> Vec<([f64; 6], Option<f64>, f64)> {
    let (bins, largest) = (PROJECTION_BINS, range(group));
    let edge = |bin: usize| largest * (2.0 * bin as f64 / bins as f64 - 1.0);
    let row = |bin: usize| {
        let (from, to, x, y) = (edge(bin), edge(bin + 1), density(group, 0, bin), density(group, 1, bin));
        let centre = 0.5 * (from + to);
        let gaussian = (!group.is_mixed()).then(|| gaussian(group, centre));
        ([from, to, x.0, x.1, y.0, y.1], gaussian, centre)
    };
    (0..bins).map(row).collect()
}

fn projection(group: &Group<'_>, axis: usize, name: &str) -> Result<String> {
    let (bins, largest) = (PROJECTION_BINS, range(group));
    let (values, errors): (Vec<f64>, Vec<f64>) = (0..bins).map(|bin| density(group, axis, bin)).unzip();
    let stairs = |sign: f64| {
        let values: Vec<f64> =
            values.iter().zip(&errors).map(|(value, error)| value + sign * error).collect();
        staircase(-largest, largest, &values)
    };
    let band =
        stairs(-1.0).into_iter().zip(stairs(1.0)).map(|((x, low), (_, high))| (x, low, high)).collect();
    let mut layers = vec![
        Layer { name: "± one standard error".to_owned(), colour: colour::BLUE, shape: Shape::Band(band) },
        Layer { name: "measured".to_owned(), colour: colour::BLUE, shape: Shape::Thin(stairs(0.0)) },
    ];
    let gaussian = |step: i32| {
        let component = largest * f64::from(step) / 200.0;
        (component, gaussian(group, component))
    };
    let curve: Vec<(f64, f64)> = (-200..=200).map(gaussian).collect();
    let highest = values.iter().copied().chain(curve.iter().map(|point| point.1)).fold(0.0, f64::max);
    if group.is_round() && !group.is_mixed() {
        let name = "Gaussian of variance 4μkT".to_owned();
        layers.push(Layer { name, colour: colour::VERMILLION, shape: Shape::Line(curve) });
    }
    Chart {
        title: format!("Impulses along {name}"),
        x: Axis { label: format!("Δp along {name} [mass·length/time]"), range: (-largest, largest) },
        y: Axis {
            label: "probability density (time/(mass·length))".to_owned(), range: (0.0, 1.2 * highest)
        },
        layers,
    }
    .svg()
}

/// Impulse per length of the boundary in one bin, as a rate in time.
fn pooled_contacts(group: &Group<'_>, point: &ContactPoint) -> Pooled {
    let pair = |block: &Block<ContactDensity>| {
        (block.observed.impulse(point.atom, point.bin) / point.arc, block.duration)
    };
    Pooled::of(group.runs, |run| &run.contacts, pair)
}

/// A bin without contacts has no error from blocks, whatever their number.
fn errors_of_contacts(group: &Group<'_>) -> Errors {
    let points = group.runs[0].contacts.total().observed.points();
    Errors::of(points.iter().find_map(|point| pooled_contacts(group, point).standard_error()))
}

/// Gas density along the boundary: means over time and runs, in units of the mean density.
fn contact_points(group: &Group<'_>) -> Vec<ContactPoint> {
    let ideal = group.ideal_pressure();
    let totals: Vec<Vec<ContactPoint>> =
        group.runs.iter().map(|run| run.contacts.total().observed.points()).collect();
    let point = |(index, first): (usize, &ContactPoint)| {
        let pooled = pooled_contacts(group, first);
        let points = || totals.iter().filter_map(|points| points.get(index));
        // With too few blocks: the error for independent contacts.
        let squares: f64 = points().map(|point| point.standard_error.powi(2)).sum();
        let independent = squares.sqrt() / totals.len() as f64;
        ContactPoint {
            contacts: points().map(|point| point.contacts).sum(),
            pressure: pooled.mean() / ideal,
            standard_error: pooled.standard_error().unwrap_or(independent) / ideal,
            ..*first
        }
    };
    totals[0].iter().enumerate().map(point).collect()
}

/// Table of the gas density along the boundary.
pub fn contact_rows(group: &Group<'_>) -> Vec<(usize, f64, f64, u64, f64, f64)> {
    let row = |point: ContactPoint| {
        let angle = point.angle.to_degrees();
        (point.atom, angle, point.arc, point.contacts, point.pressure, point.standard_error)
    };
    contact_points(group).into_iter().map(row).collect()
}

/// Most atoms with names in the legend of a chart; more would cover it.
const MOST_NAMES: usize = 10;

fn contacts(group: &Group<'_>) -> Result<String> {
    let points = contact_points(group);
    let highest = points.iter().map(|point| point.pressure + point.standard_error).fold(1.0, f64::max);
    let mut layers = Vec::new();
    // Room for the legend above the lines.
    let headroom = 1.25 + 0.05 * group.kicks.by_atom.len().min(MOST_NAMES) as f64;
    let atoms = group.kicks.by_atom.len();
    for atom in 0..atoms {
        let colour = atom_colour(atom);
        let mut name = if atoms <= MOST_NAMES { format!("atom {}", letter(atom)) } else { String::new() };
        let of_atom = points.iter().filter(|point| point.atom == atom);
        for piece in pieces(of_atom.copied().collect()) {
            let band = |point: &ContactPoint| {
                let error = point.standard_error;
                (point.angle.to_degrees(), point.pressure - error, point.pressure + error)
            };
            let line = |point: &ContactPoint| (point.angle.to_degrees(), point.pressure);
            let (band, line) = (piece.iter().map(band).collect(), piece.iter().map(line).collect());
            layers.push(Layer { name: String::new(), colour, shape: Shape::Band(band) });
            layers.push(Layer { name: std::mem::take(&mut name), colour, shape: Shape::Line(line) });
        }
    }
    Chart {
        title: "Gas density along the boundary of the excluded region".to_owned(),
        x: Axis {
            label: "direction of the normal in the body frame (degrees from x′)".to_owned(),
            range: (0.0, 360.0),
        },
        y: Axis { label: "density at contact (mean density)".to_owned(), range: (0.0, headroom * highest) },
        layers,
    }
    .svg()
}

/// The colour of an atom's line: five colours, then the same ones darker, so that all atoms with
/// names differ.
fn atom_colour(atom: usize) -> RGBColor {
    const COLOURS: [RGBColor; 5] =
        [colour::BLUE, colour::VERMILLION, colour::GREEN, colour::ORANGE, colour::PURPLE];
    let RGBColor(red, green, blue) = COLOURS[atom % COLOURS.len()];
    let dimmed = atom / COLOURS.len() % 2 == 1;
    if dimmed { RGBColor(red / 2, green / 2, blue / 2) } else { RGBColor(red, green, blue) }
}

/// Groups of adjacent bins.
fn pieces(points: Vec<ContactPoint>) -> Vec<Vec<ContactPoint>> {
    let mut pieces: Vec<Vec<ContactPoint>> = Vec::new();
    for point in points {
        // Bins are three degrees wide; four missing bins are a gap.
        match pieces.last_mut() {
            Some(piece) if piece.last().is_some_and(|last| point.angle - last.angle < 4f64.to_radians()) => {
                piece.push(point);
            }
            _ => pieces.push(vec![point]),
        }
    }
    pieces
}

fn velocity(group: &Group<'_>) -> Result<String> {
    let run = &group.runs[0];
    let duration = run.duration;
    // The scatter of blocks includes all causes of velocity fluctuations, that of the gas as a
    // whole too. With too few blocks: samples are independent, because velocity correlations decay
    // within some hundredths.
    let thermal = (group.temperature() / group.molecule().mass()).sqrt();
    let few = thermal / (run.averages.len() as f64).sqrt();
    let of_one_run = group.error_of_one_run(Drift::path).unwrap_or(few);
    let error_at = |time: f64| of_one_run * (duration / time).sqrt();
    let mut layers = vec![band_of_one_run(duration, error_at)];
    for (axis, name, colour) in [(0, "along x′", colour::BLUE), (1, "along y′", colour::GREEN)] {
        for (index, run) in group.runs.iter().enumerate() {
            let (mut time, mut path) = (0.0, 0.0);
            let blocks = run.drift.complete().iter().map(|block| {
                (time, path) = (time + block.duration, path + block.observed.path()[axis]);
                (time, path / time)
            });
            let name = if index == 0 { name.to_owned() } else { String::new() };
            layers.push(Layer { name, colour, shape: Shape::Line(blocks.collect()) });
        }
    }
    let range = 4.0 * error_at(0.1 * duration);
    Chart {
        title: "Running mean of the molecule's velocity".to_owned(),
        x: Axis {
            label: "time since the start of the measurement (time)".to_owned(),
            range: (0.0, duration),
        },
        y: Axis { label: "mean velocity (length/time)".to_owned(), range: (-range, range) },
        layers,
    }
    .svg()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn a_caption_names_the_source_of_the_errors_that_are_drawn() {
        let of = |blocks: usize| {
            let pooled = Pooled::planted(vec![(0..blocks).map(|block| (block as f64, 1.0)).collect()]);
            Errors::of(pooled.standard_error())
        };
        assert_eq!((of(MIN_BLOCKS - 1), of(MIN_BLOCKS)), (Errors::Independence, Errors::Blocks));
        assert_eq!(Errors::Blocks.source("samples"), "from the scatter of blocks of time");
        assert!(Errors::Independence.source("samples").starts_with("as if samples were independent"));
    }

    #[test]
    fn all_atoms_with_names_have_colours_of_their_own() {
        let colours: BTreeSet<_> =
            (0..MOST_NAMES).map(atom_colour).map(|one| (one.0, one.1, one.2)).collect();
        assert_eq!(colours.len(), MOST_NAMES);
    }

    #[test]
    fn lines_break_at_gaps_of_the_boundary() {
        let point = |degrees: f64| ContactPoint {
            atom: 0,
            angle: degrees.to_radians(),
            arc: 1.0,
            bin: 0,
            contacts: 1,
            pressure: 1.0,
            standard_error: 0.1,
        };
        let pieces = pieces([1.5, 4.5, 7.5, 13.5, 16.5, 358.5].map(point).into());
        assert_eq!(pieces.iter().map(Vec::len).collect::<Vec<_>>(), [3, 2, 1]);
        assert!(super::pieces(Vec::new()).is_empty());
    }
}
