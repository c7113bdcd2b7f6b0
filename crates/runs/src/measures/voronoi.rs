//! `voronoi`: areas of the Voronoi cells and their numbers of neighbours.

use carom::observers::{AdaptiveHistogram, VoronoiCells, VoronoiPoint};
use carom_tables::{BlockMean, Table};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Selection, Span, in_blocks,
    point_bytes, range, resumed,
};

/// Quantities after the shares of the numbers of neighbours.
const FIGURES: [&str; 2] = [
    "relative variance of the cell areas",
    "mean free share of the cells",
];

/// Numbers of neighbours whose shares are figures.
const COMMON: [usize; 3] = [5, 6, 7];

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "voronoi",
    summary: "Voronoi cells: distribution of their areas, numbers of neighbours, free share of discs",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        Parameter::whole("bins", Default::Number(60.0), "bins of the histogram"),
        Parameter::positive(
            range::MAX,
            range::FOLLOWS,
            "largest area in the bins (mean areas)",
        ),
    ],
    figures: &[
        "relative variance of the cell areas",
        "mean free share of the cells",
        "share of cells with ",
        "share of the cell areas",
    ],
    start: |selection| Ok(in_blocks(observer(selection)?)),
    resume: resumed::<VoronoiCells>,
};

fn observer(selection: &Selection<'_>) -> anyhow::Result<VoronoiCells> {
    let (group, bins) = (selection.group, selection.whole("bins"));
    Ok(match selection.given(range::MAX) {
        Some(largest) => VoronoiCells::new(group, largest, bins)?,
        None => VoronoiCells::adaptive(group, bins),
    })
}

impl Measured for VoronoiCells {
    /// The share of cells with each number of neighbours, the variance of the areas, the free
    /// share, and the share of the areas outside the range.
    fn sums(&self) -> Vec<[f64; 2]> {
        let outside = range::outside(self.areas());
        self.sums().into_iter().chain([outside]).collect()
    }

    fn distributions(&self) -> Vec<Vec<&AdaptiveHistogram>> {
        vec![vec![self.areas()]]
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        if self.series().is_empty() {
            return Results::default();
        }
        let numbers: Vec<usize> = Self::neighbours().collect();
        let (shares, rest) = means.split_at(means.len().min(numbers.len()));
        let (figures, rest) = rest.split_at(rest.len().min(FIGURES.len()));
        let (outside, densities) = rest.split_at(rest.len().min(1));
        let mut figures = context.figures(FIGURES.map(|name| (name, "1", None)), figures, "");
        let common = numbers
            .iter()
            .zip(shares)
            .filter(|(number, _)| COMMON.contains(number));
        figures.extend(common.filter_map(|(number, mean)| {
            context.figure(
                &format!("share of cells with {number} neighbours"),
                "1",
                mean,
            )
        }));
        figures.extend(range::share_outside(
            self.areas(),
            "cell areas",
            outside.first(),
            context,
        ));
        Results {
            tables: vec![
                series(self.series(), context),
                areas(self.areas(), densities, context),
                neighbours(&numbers, shares, context),
            ],
            figures,
            ..Results::default()
        }
    }
}

/// The cells at each sample.
fn series(points: &[VoronoiPoint], context: &Context<'_>) -> Table {
    let of = |part: fn(&VoronoiPoint) -> f64| points.iter().map(part).collect::<Vec<f64>>();
    let drawn = |part: fn(&VoronoiPoint) -> f64| points.iter().map(|p| Some(part(p))).collect();
    Table::new(context.table("voronoi"), "Voronoi cells")
        .abscissa("time", "time", of(|point| point.time))
        .counts("cells", points.iter().map(|point| point.cells).collect())
        .undrawn("mean_area", "length²", of(|point| point.mean_area))
        .value("variance", "1", drawn(|point| point.variance))
        .value("smallest", "1", drawn(|point| point.smallest))
        .value("largest", "1", drawn(|point| point.largest))
        .value("free", "1", points.iter().map(|point| point.free).collect())
        .caption(
            "Variance of the areas, the smallest and the largest, relative to the mean area: the \
             variance is 0 in a lattice and 0.2802 for independent positions (Gilbert 1962). The free \
             share is the mean of 1 − πr²/a over the cells of discs of one radius r. Cells next to \
             walls do not count.",
        )
}

/// The distribution of the areas.
fn areas(areas: &AdaptiveHistogram, densities: &[BlockMean], context: &Context<'_>) -> Table {
    Table::new(context.table("voronoi-areas"), "Areas of the Voronoi cells")
        .bins("area", "1", areas.bins().edges())
        .means("density", "1", densities)
        .caption(format!(
            "Areas by the mean area of the same sample. {}",
            range::caption(&[areas])
        ))
}

/// The share of cells with each number of neighbours.
fn neighbours(numbers: &[usize], shares: &[BlockMean], context: &Context<'_>) -> Table {
    let numbers = numbers.iter().map(|&number| number as f64).collect();
    Table::new(
        context.table("voronoi-neighbours"),
        "Numbers of neighbours of the Voronoi cells",
    )
    .abscissa("neighbours", "1", numbers)
    .means("share", "1", shares)
    .caption(
        "Share of the cells with so many neighbours; the first and the last hold those beyond.",
    )
}
