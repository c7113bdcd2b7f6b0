//! Charts of the kicks and of the force on the molecule, and the table of directions.

use anyhow::Result;
use carom::{DirectionHistogram, observers::Block};
use carom_report::{
    molecule_picture,
    plot::{Axis, Chart, Layer, Shape, colour},
    polar::Polar,
};
use glam::DVec2;

use crate::direction_chart::directions;

use super::{
    figures::force_series,
    group::{Group, impulse_error},
    results::SECTORS,
};

/// The charts of a group, as SVG.
#[derive(Debug, Clone)]
pub struct Charts {
    /// Number of kicks by direction.
    pub counts: String,
    /// Impulse by direction.
    pub impulse: String,
    /// Impulse by direction, as a polar chart.
    pub polar: String,
    /// Number of kicks by direction, as a polar chart.
    pub polar_counts: String,
    /// Running average of the force.
    pub force: String,
    /// The molecule and the boundary of the region excluded to gas centres.
    pub molecule: String,
}

/// Sectors of the polar chart; wider than those of the histograms, because noise is less readable
/// in polar form.
const POLAR_SECTORS: usize = 120;

/// One row of the table of directions.
pub type DirectionRow = (f64, f64, u64, f64, Option<f64>, f64, f64, Option<f64>);

/// Header of the table of directions, which are those of the impulse on the molecule in its body
/// frame.
pub const DIRECTION_HEADER: [&str; 8] = [
    "from_degrees",
    "to_degrees",
    "kicks",
    "kicks_standard_error",
    "kicks_dilute_prediction",
    "impulse",
    "impulse_standard_error",
    "impulse_dilute_prediction",
];

/// Table of directions.
pub fn direction_rows(group: &Group<'_>) -> Vec<DirectionRow> {
    let kicks = &group.kicks;
    let (hits, total) = (kicks.hits() as f64, kicks.total_impulse());
    let (counts, impulses) =
        (group.prediction.count_shares(SECTORS), group.prediction.impulse_shares(SECTORS));
    let width = 360.0 / SECTORS as f64;
    let time = group.duration();
    let error = |sum: &dyn Fn(&Block<DirectionHistogram>) -> f64, independent: f64| {
        time * group.kick_error(|block| (sum(block), block.duration), independent / time)
    };
    let row = |sector: usize| {
        let (count, impulse) = (kicks.counts[sector], kicks.impulse[sector]);
        (
            width * sector as f64,
            width * (sector + 1) as f64,
            count,
            error(&|block| block.observed.counts()[sector] as f64, (count as f64).sqrt()),
            group.has_arcs().then(|| hits * counts[sector]),
            impulse,
            error(&|block| block.observed.impulse()[sector], impulse_error(impulse, count)),
            group.has_arcs().then(|| total * impulses[sector]),
        )
    };
    (0..SECTORS).map(row).collect()
}

impl Charts {
    /// Draws the charts.
    ///
    /// # Errors
    /// A value is not finite.
    pub fn draw(group: &Group<'_>) -> Result<Self> {
        let rows = direction_rows(group);
        let per_time =
            |values: Vec<f64>| values.iter().map(|value| value / group.duration()).collect::<Vec<_>>();
        let counts = [
            per_time(rows.iter().map(|row| row.2 as f64).collect()),
            per_time(rows.iter().map(|row| row.3).collect()),
            per_time(rows.iter().filter_map(|row| row.4).collect()),
        ];
        let impulse = [
            per_time(rows.iter().map(|row| row.5).collect()),
            per_time(rows.iter().map(|row| row.6).collect()),
            per_time(rows.iter().filter_map(|row| row.7).collect()),
        ];
        let prediction = prediction_name(group);
        Ok(Self {
            counts: directions(
                "Kicks by direction",
                "kicks per time and degree (1/time)",
                &counts,
                prediction,
            )?,
            impulse: directions(
                "Impulse by direction",
                "impulse per time and degree (mass·length/time²)",
                &impulse,
                prediction,
            )?,
            polar: polar(group, ("Impulse", "[mass·length/time²]"), &impulse, |kicks, sector| {
                kicks.impulse()[sector]
            })?,
            polar_counts: polar(group, ("Kicks", "[1/time]"), &counts, |kicks, sector| {
                kicks.counts()[sector] as f64
            })?,
            force: force(group)?,
            molecule: molecule_picture::svg(
                group.molecule(),
                &group.prediction.boundary,
                group.prediction.gas_radius,
            ),
        })
    }

    /// File names and contents of the charts.
    pub fn files(&self) -> [(&'static str, &str); 6] {
        [
            ("kicks-by-direction.svg", &self.counts),
            ("impulse-by-direction.svg", &self.impulse),
            ("impulse-polar.svg", &self.polar),
            ("kicks-polar.svg", &self.polar_counts),
            ("mean-force.svg", &self.force),
            ("molecule.svg", &self.molecule),
        ]
    }
}

/// Means over groups of adjacent values.
fn means(values: &[f64], groups: usize) -> Vec<f64> {
    values.chunks(values.len() / groups).map(|group| group.iter().sum::<f64>() / group.len() as f64).collect()
}

fn prediction_name(group: &Group<'_>) -> &'static str {
    if group.is_round() { "isotropic" } else { "dilute gas: exposed atoms N(φ)" }
}

/// Polar histogram of directions, measured and predicted, with error band.
fn polar(
    group: &Group<'_>,
    (what, unit): (&str, &str),
    [values, errors, predicted]: &[Vec<f64>; 3],
    sum: impl Fn(&DirectionHistogram, usize) -> f64,
) -> Result<String> {
    let joined = SECTORS / POLAR_SECTORS;
    let error = |index: usize| {
        let sectors = index * joined..(index + 1) * joined;
        let independent = errors[sectors.clone()].iter().map(|error| error * error).sum::<f64>().sqrt();
        let pair = |block: &Block<DirectionHistogram>| {
            (sectors.clone().map(|sector| sum(&block.observed, sector)).sum(), block.duration)
        };
        group.kick_error(pair, independent) / joined as f64
    };
    let mut curves = vec![("measured".to_owned(), colour::BLUE, means(values, POLAR_SECTORS))];
    if group.has_arcs() {
        let name = prediction_name(group).to_owned();
        curves.push((name, colour::VERMILLION, means(predicted, POLAR_SECTORS)));
    }
    Polar {
        title: format!("{what} by direction, polar chart"),
        label: format!("radius: {} per time and degree {unit}, means over 3°", what.to_lowercase()),
        curves,
        errors: (0..POLAR_SECTORS).map(error).collect(),
    }
    .svg()
}

fn line(name: &str, colour: plotters::style::RGBColor, points: Vec<(f64, f64)>) -> Layer {
    Layer { name: name.to_owned(), colour, shape: Shape::Line(points) }
}

/// Running average of the force along x′ and y′, one line for each run, with the expected error of
/// one run.
fn force(group: &Group<'_>) -> Result<String> {
    let duration = group.runs[0].duration;
    let error_at = |time: f64| group.force_errors(time).map_or(0.0, DVec2::max_element);
    // The initial average is mostly noise; the convergence matters.
    let scale = 3.0 * error_at(0.1 * duration);
    let largest = group
        .runs
        .iter()
        .filter_map(|run| run.averages.last())
        .map(|point| point.momentum.abs().max_element())
        .fold(scale, f64::max);
    let range = if largest > 0.0 { 1.1 * largest } else { 1.0 };
    let mut layers = vec![band_of_one_run(duration, error_at)];
    for (axis, name, colour) in [(0, "along x′", colour::BLUE), (1, "along y′", colour::GREEN)] {
        for (index, run) in group.runs.iter().enumerate() {
            let points: Vec<(f64, f64)> = force_series(&run.averages, group.from)
                .iter()
                .map(|(time, force)| (*time, force[axis]))
                .collect();
            layers.push(line(if index == 0 { name } else { "" }, colour, points));
        }
    }
    Chart {
        title: "Running mean of the force on the molecule".to_owned(),
        x: Axis {
            label: "time since the start of the measurement (time)".to_owned(),
            range: (0.0, duration),
        },
        y: Axis { label: "Σ Δp / t (mass·length/time²)".to_owned(), range: (-range, range) },
        layers,
    }
    .svg()
}

/// Standard error of the running average of one run, as a function of time since its start.
pub fn band_of_one_run(duration: f64, error_at: impl Fn(f64) -> f64) -> Layer {
    let band = (1..=200).map(|step| {
        let time = duration * f64::from(step) / 200.0;
        (time, -error_at(time), error_at(time))
    });
    Layer {
        name: "± one standard error of one run".to_owned(),
        colour: colour::ORANGE,
        shape: Shape::Band(band.collect()),
    }
}
