//! `cage-displacement`: mean squared displacement of a group relative to the neighbours.

use anyhow::Result;
use carom::observers::{Cage, CageDisplacement, CagePoint};
use carom_tables::{BlockMean, Table};

use crate::curves::MIN_PAIRS;

use super::{
    Context, Default, MAX_LAG, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    in_blocks, resumed,
};

/// The figure.
const NEIGHBOURS: &str = "mean number of neighbours in the cage";

const CUTOFF: Parameter = Parameter::positive(
    "cutoff",
    Default::FromScene("neighbours are bodies whose Voronoi cells share an edge"),
    "distance of the centres below which two bodies are neighbours (length)",
);

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "cage-displacement",
    summary: "mean squared displacement relative to the neighbours at the start of the lag",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[CUTOFF, MAX_LAG],
    figures: &[NEIGHBOURS],
    start: |selection| Ok(in_blocks(observer(selection)?)),
    resume: resumed::<CageDisplacement>,
};

fn observer(selection: &Selection<'_>) -> Result<CageDisplacement> {
    let cutoff = selection.given(CUTOFF.name);
    let cage = cutoff.map_or(Cage::Delaunay, Cage::Within);
    let times = [selection.interval(), selection.longest_lag()];
    let bounds = selection.view.bounds();
    Ok(CageDisplacement::new(
        selection.group,
        &bounds,
        cage,
        times,
    )?)
}

impl Measured for CageDisplacement {
    /// The mean square relative to the cage at each lag, then ⟨|Δ|²⟩, then the number of
    /// neighbours.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let mut points = self.points();
        points.retain(|point| point.pairs >= MIN_PAIRS);
        if points.is_empty() {
            return Results::default();
        }
        let of = |part: fn(&CagePoint) -> f64| -> Vec<f64> { points.iter().map(part).collect() };
        let (lags, all) = (of(|point| point.lag), self.lags().len());
        let relative = context.at_lags(means, 0, all, &lags);
        let squares = context.at_lags(means, 1, all, &lags);
        let table = Table::new(
            context.table("cage-displacement"),
            "Displacement relative to the cage",
        )
        .abscissa("lag", "time", lags)
        .counts("pairs", points.iter().map(|point| point.pairs).collect())
        .means("cage_relative", "length²", &relative)
        .means("mean_square_displacement", "length²", &squares)
        .logarithmic()
        .in_decades(&["cage_relative", "mean_square_displacement"])
        .caption(format!(
            "⟨|Δ − Σ Δⱼ/z|²⟩ with the displacements Δⱼ of the z neighbours that a body had at the start \
             of the lag, {}, and ⟨|Δ|²⟩ of the same bodies, from lags with at least {MIN_PAIRS} pairs.",
            in_words(self.cage())
        ));
        let neighbours = means.get(2 * all);
        let figure = neighbours.and_then(|mean| context.figure(NEIGHBOURS, "1", mean));
        Results {
            tables: vec![table],
            figures: figure.into_iter().collect(),
            ..Results::default()
        }
    }
}

fn in_words(cage: Cage) -> String {
    match cage {
        Cage::Within(distance) => format!("the bodies nearer than {distance}"),
        _ => "the bodies whose Voronoi cells share an edge with its own".to_owned(),
    }
}
