//! `van-hove-distinct`: where the other bodies of a group, or those of another, are after a lag,
//! G_d(r, t).

use anyhow::Result;
use carom::{DistinctVanHove, observers::DisplacementBins};
use carom_tables::{BlockMean, Sums, Table, significant};

use crate::curves::MIN_PAIRS;

use super::{
    Context, Default, MAX_LAG, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    in_blocks,
    pair_distribution::{DIAMETERS, longest_distance},
    resumed,
};

const DISTANCE: Parameter = Parameter::positive(
    "distance",
    Default::FromScene("5 diameters of the largest bodies"),
    "longest distance, less than half the shorter side (length)",
);

const BINS: Parameter =
    Parameter::up_to("bins", 1e4, Default::Number(100.0), "bins of the distance");

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "van-hove-distinct",
    summary: "distinct part G_d(r, t) of the van Hove function at lags of 0, 1, 3, 10, 30, … samples; with two tags, of \
              the second around the first",
    of: Of::TwoGroups,
    span: Span::Measurement,
    parameters: &[DISTANCE, BINS, MAX_LAG],
    figures: &[],
    start: |selection| Ok(in_blocks(van_hove(selection)?)),
    resume: resumed::<DistinctVanHove>,
};

fn van_hove(selection: &Selection<'_>) -> Result<DistinctVanHove> {
    let bins = DisplacementBins {
        distance: match selection.given(DISTANCE.name) {
            Some(distance) => distance,
            None => longest_distance(selection, DIAMETERS),
        },
        bins: selection.whole(BINS.name),
        spacing: selection.interval(),
        longest: selection.longest_lag(),
    };
    let bounds = selection.view.bounds();
    Ok(DistinctVanHove::new(selection.groups(), &bounds, bins)?)
}

impl Measured for DistinctVanHove {
    /// G_d in each bin at the first lag, then at the next.
    fn sums(&self) -> Sums {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let bins = self.distances().len();
        let edges: Vec<f64> = (0..=bins).map(|bin| bin as f64 * self.width()).collect();
        let mut curves = self.curves();
        curves.retain(|curve| curve.bodies >= MIN_PAIRS);
        let Some(density) = self.density().filter(|_| !curves.is_empty()) else {
            return Results::default();
        };
        // Lags without bodies are the longest.
        let table = curves.iter().zip(means.chunks(bins)).fold(
            Table::new(
                context.table("van-hove-distinct"),
                "Density of the other bodies after a lag, G_d(r, t)",
            )
            .bins("distance", "length", &edges),
            |table, (curve, means)| {
                let lag = significant(curve.lag, 6);
                let means = context.resolved(means, &vec![curve.lag; bins]);
                table
                    .means(&format!("density_at_{lag}"), "1/length²", &means)
                    .labelled(&format!("lag {lag}"))
            },
        );
        let table = table.caption(format!(
            "By area, around the place that a body had; ρ g(r) at lag 0, and ρ = {density:.6} where places are independent, \
             as after a long time."
        ));
        Results {
            tables: vec![table],
            ..Results::default()
        }
    }
}
