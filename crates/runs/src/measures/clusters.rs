//! `clusters`: bodies that are connected by gaps shorter than a given one, and percolation.

use anyhow::{Context as _, ensure};
use carom::observers::{ClusterPoint, Clusters};
use carom_tables::{BlockMean, Table};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Selection, Span, in_blocks,
    point_bytes, resumed,
};

/// The default of the gap in diameters of the smallest body.
const DIAMETERS: f64 = 0.1;

/// The figures, in the order of the sums.
const FIGURES: [&str; 7] = [
    "number of clusters",
    "largest cluster",
    "mean cluster size (number average)",
    "mean cluster size (weight average)",
    "share of samples that percolate along x",
    "share of samples that percolate along y",
    "share of samples that percolate",
];

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "clusters",
    summary: "clusters of bodies whose surfaces are nearer than a gap: number, sizes, percolation",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[Parameter::positive(
        "gap",
        Default::FromScene("a tenth of the diameter of the smallest body"),
        "distance of the surfaces below which two bodies are connected (length)",
    )],
    figures: &[
        "number of clusters",
        "largest cluster",
        "mean cluster size",
        "share of samples that percolate",
    ],
    start: |selection| Ok(in_blocks(observer(selection)?)),
    resume: resumed::<Clusters>,
};

fn observer(selection: &Selection<'_>) -> anyhow::Result<Clusters> {
    let radii = || {
        let members = selection
            .view
            .bodies()
            .filter(|body| !body.body.is_wall() && selection.group.contains(body.body));
        members.map(|body| body.body.molecule().bounding_radius())
    };
    let smallest = || Some(DIAMETERS * 2.0 * radii().reduce(f64::min)?);
    let gap = selection.given("gap").or_else(smallest);
    let gap = gap.context(
        "there is no body that is not a wall, whose diameter would give the default of 'gap': \
         give 'gap' (length)",
    )?;
    let half = 0.5 * selection.view.bounds().sides().min_element();
    ensure!(
        gap < half,
        "'gap' must be less than half the shorter side of the box, {half}, but is {gap}"
    );
    Ok(Clusters::new(selection.group, gap)?)
}

impl Measured for Clusters {
    /// The figures, then n_s in each bin of sizes.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        if self.series().is_empty() {
            return Results::default();
        }
        let (means, of_sizes) = means.split_at(means.len().min(FIGURES.len()));
        let figures = context.figures(FIGURES.map(|name| (name, "1", None)), means, "");
        Results {
            tables: vec![series(self, context), sizes(self, of_sizes, context)],
            figures,
            ..Results::default()
        }
    }
}

/// The clusters at each sample.
fn series(clusters: &Clusters, context: &Context<'_>) -> Table {
    let points = clusters.series();
    let of = |part: fn(&ClusterPoint) -> f64| points.iter().map(part).collect::<Vec<f64>>();
    let drawn = |part: fn(&ClusterPoint) -> f64| points.iter().map(|p| Some(part(p))).collect();
    let along = |axis: usize| {
        let wraps = points
            .iter()
            .map(|point| f64::from(u8::from(point.wraps[axis])));
        wraps.collect::<Vec<f64>>()
    };
    Table::new(context.table("clusters"), "Clusters")
        .abscissa("time", "time", of(|point| point.time))
        .counts(
            "clusters",
            points.iter().map(|point| point.clusters).collect(),
        )
        .value("largest", "1", drawn(|point| point.largest as f64))
        .value("number_mean", "1", drawn(ClusterPoint::number_mean))
        .value("weight_mean", "1", drawn(|point| point.weight_mean))
        .undrawn("wraps_x", "1", along(0))
        .undrawn("wraps_y", "1", along(1))
        .caption(format!(
            "Bodies whose surfaces are nearer than {} are connected. The size of the largest cluster, \
             the mean size of the clusters (number average), and that of the cluster of a body (weight \
             average, Σ s² n_s / Σ s n_s; all clusters count), in bodies; whether a cluster wraps \
             around the box along x and y.",
            clusters.gap()
        ))
}

/// The distribution of sizes, up to the largest found.
fn sizes(clusters: &Clusters, means: &[BlockMean], context: &Context<'_>) -> Table {
    let counts = clusters.counts();
    let found = counts.iter().rposition(|&count| count > 0);
    let bins = found.map_or(0, |last| last + 1).min(means.len());
    // Between whole numbers, so that the centre of a bin is the mean of its sizes.
    let edges: Vec<f64> = clusters
        .sizes()
        .take(bins + 1)
        .map(|size| size as f64 - 0.5)
        .collect();
    Table::new(context.table("clusters-sizes"), "Sizes of clusters")
        .bins("size", "1", &edges)
        .counts("clusters", counts[..bins].to_vec())
        .means("n", "1", &means[..bins])
        .in_decades(&["n"])
        .logarithmic()
        .caption(
            "n_s, the number of clusters of s bodies by the number of all bodies, the mean over the \
             sizes of a bin: Σ s n_s = 1. Sizes up to 7 have bins of their own, each octave beyond has \
             four.",
        )
}
