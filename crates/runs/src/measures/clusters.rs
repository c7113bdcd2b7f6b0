//! `clusters`: bodies that are connected by gaps or distances shorter than a given one, and
//! percolation; `bonded-clusters`: bodies that are connected by bonds and wells.

use anyhow::{Context as _, ensure};
use carom::observers::{Bonding, ClusterPoint, Clusters};
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

/// The figures of bonded clusters, in the order of the sums.
const BONDED_FIGURES: [&str; 7] = [
    "number of bonded clusters",
    "largest bonded cluster",
    "mean bonded cluster size (number average)",
    "mean bonded cluster size (weight average)",
    "share of samples whose bonds percolate along x",
    "share of samples whose bonds percolate along y",
    "share of samples whose bonds percolate",
];

const GAP: Parameter = Parameter::positive(
    "gap",
    Default::FromScene("a tenth of the diameter of the smallest body"),
    "distance of the surfaces below which two bodies are connected (length)",
);

const DISTANCE: Parameter = Parameter::positive(
    "distance",
    Default::FromScene("'gap'"),
    "distance of the centres below which two bodies are connected, instead of 'gap' (length)",
);

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "clusters",
    summary: "clusters of bodies whose surfaces are nearer than a gap, or whose centres are nearer than a distance: \
              number, sizes, percolation",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[GAP, DISTANCE],
    figures: &[
        "number of clusters",
        "largest cluster",
        "mean cluster size",
        "share of samples that percolate",
    ],
    start: |selection| Ok(in_blocks(observer(selection)?)),
    resume: resumed::<Clusters>,
};

/// The words of `by`.
const BONDINGS: [&str; 3] = ["bonds", "wells", "both"];

pub(super) const BONDED: MeasureKind = MeasureKind {
    name: "bonded-clusters",
    summary: "clusters of bodies that bonds connect, and discs within wells whose energy is below 0: number, sizes, \
              percolation",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[Parameter::word(
        "by",
        &BONDINGS,
        Default::FromScene("both"),
        "what connects two bodies: bonds, wells or both",
    )],
    figures: &[
        "number of bonded clusters",
        "largest bonded cluster",
        "mean bonded cluster size",
        "share of samples whose bonds percolate",
    ],
    start: |selection| {
        Ok(in_blocks(Clusters::bonded(
            selection.group,
            bonding(selection),
        )))
    },
    resume: resumed::<Clusters>,
};

fn bonding(selection: &Selection<'_>) -> Bonding {
    match selection.given_word("by") {
        Some("bonds") => Bonding::Bonds,
        Some("wells") => Bonding::Wells,
        _ => Bonding::BondsOrWells,
    }
}

fn observer(selection: &Selection<'_>) -> anyhow::Result<Clusters> {
    let Some(distance) = selection.given(DISTANCE.name) else {
        return by_gap(selection);
    };
    ensure!(
        selection.given(GAP.name).is_none(),
        "'gap' and 'distance' exclude each other: give the distance of the surfaces, or that of the centres"
    );
    Ok(Clusters::by_distance(
        selection.group,
        below_half(DISTANCE.name, distance, selection)?,
    )?)
}

fn by_gap(selection: &Selection<'_>) -> anyhow::Result<Clusters> {
    let radii = || {
        let members = selection
            .view
            .bodies()
            .filter(|body| !body.body.is_wall() && selection.group.contains(body.body));
        members.map(|body| body.body.molecule().bounding_radius())
    };
    let smallest = || Some(DIAMETERS * 2.0 * radii().reduce(f64::min)?);
    let gap = selection.given(GAP.name).or_else(smallest);
    let gap = gap.context(
        "there is no body that is not a wall, whose diameter would give the default of 'gap': \
         give 'gap' (length)",
    )?;
    Ok(Clusters::new(
        selection.group,
        below_half(GAP.name, gap, selection)?,
    )?)
}

/// A parameter, if it is less than half the shorter side of the box (length).
fn below_half(name: &str, length: f64, selection: &Selection<'_>) -> anyhow::Result<f64> {
    let half = 0.5 * selection.view.bounds().sides().min_element();
    ensure!(
        length < half,
        "'{name}' must be less than half the shorter side of the box, {half}, but is {length}"
    );
    Ok(length)
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
        let (name, figures) = match self.gap().or(self.distance()) {
            Some(_) => ("clusters", FIGURES),
            None => ("bonded-clusters", BONDED_FIGURES),
        };
        let figures = context.figures(figures.map(|name| (name, "1", None)), means, "");
        let of_sizes = sizes(self, of_sizes, context.table(&format!("{name}-sizes")));
        Results {
            tables: vec![series(self, context.table(name)), of_sizes],
            figures,
            ..Results::default()
        }
    }
}

/// The clusters at each sample.
fn series(clusters: &Clusters, name: String) -> Table {
    let points = clusters.series();
    let of = |part: fn(&ClusterPoint) -> f64| points.iter().map(part).collect::<Vec<f64>>();
    let drawn = |part: fn(&ClusterPoint) -> f64| points.iter().map(|p| Some(part(p))).collect();
    let along = |axis: usize| {
        let wraps = points
            .iter()
            .map(|point| f64::from(u8::from(point.wraps[axis])));
        wraps.collect::<Vec<f64>>()
    };
    let connected = match (clusters.gap(), clusters.distance()) {
        (Some(gap), _) => format!("Bodies whose surfaces are nearer than {gap} are connected."),
        (None, Some(distance)) => {
            format!("Bodies whose centres are nearer than {distance} are connected.")
        }
        (None, None) => "Bodies that are bonded are connected.".to_owned(),
    };
    Table::new(name, "Clusters")
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
            "{connected} The size of the largest cluster, the mean size of the clusters (number average), and that of the cluster of a body (weight \
             average, Σ s² n_s / Σ s n_s; all clusters count), in bodies; whether a cluster wraps \
             around the box along x and y."
        ))
}

/// The distribution of sizes, up to the largest found.
fn sizes(clusters: &Clusters, means: &[BlockMean], name: String) -> Table {
    let counts = clusters.counts();
    let found = counts.iter().rposition(|&count| count > 0);
    let bins = found.map_or(0, |last| last + 1).min(means.len());
    // Between whole numbers, so that the centre of a bin is the mean of its sizes.
    let edges: Vec<f64> = clusters
        .sizes()
        .take(bins + 1)
        .map(|size| size as f64 - 0.5)
        .collect();
    Table::new(name, "Sizes of clusters")
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
