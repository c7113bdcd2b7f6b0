//! `projections:TAG`: components of the impulses on one body along its own axes.

use carom::{
    CollisionReport, Observer, ProjectionHistogram,
    engine::Body,
    observers::{AdaptiveHistogram, BodyAxis},
};
use carom_tables::{BlockMean, Table};
use serde::{Deserialize, Serialize};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Selection, Span, in_blocks,
    range, resumed,
};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "projections",
    summary: "components of the impulses on the only body with the tag, along its own axes",
    of: Of::OneBody,
    span: Span::Measurement,
    parameters: &[
        Parameter::whole("bins", Default::Number(160.0), "bins of the histogram"),
        Parameter::positive(
            range::MAX,
            range::FOLLOWS,
            "half the range (mass·length/time)",
        ),
    ],
    figures: &["share of the"],
    start: |selection| Ok(in_blocks(Projections::new(selection)?)),
    resume: resumed::<Projections>,
};

/// The components along x′ and y′.
#[derive(Serialize, Deserialize)]
pub(super) struct Projections([ProjectionHistogram; 2]);

impl Projections {
    /// Those of the only body of the selection.
    pub(super) fn new(selection: &Selection<'_>) -> anyhow::Result<Self> {
        let body = selection.only_body()?.body.key();
        let bins = selection.whole("bins");
        let along = |axis| match selection.given(range::MAX) {
            Some(half_width) => ProjectionHistogram::new(body, axis, half_width, bins),
            None => Ok(ProjectionHistogram::adaptive(body, axis, bins)),
        };
        Ok(Self([along(BodyAxis::X)?, along(BodyAxis::Y)?]))
    }
}

/// Source of the prediction for a round body.
const GAUSSIAN: &str =
    "isotropic impulses with a Rayleigh distribution of magnitudes: exact at any density";

/// Mean of the density of a Gaussian of mean 0 over a bin.
fn mean_of_gaussian(bin: [f64; 2], variance: f64) -> f64 {
    let [below, above] = bin.map(|end| libm::erf(end / (2.0 * variance).sqrt()));
    0.5 * (above - below) / (bin[1] - bin[0])
}

impl Observer for Projections {
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.0[0].watches(bodies)
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0
            .iter_mut()
            .for_each(|histogram| histogram.collision(report));
    }
}

impl Projections {
    fn components(&self) -> [&AdaptiveHistogram; 2] {
        self.0.each_ref().map(ProjectionHistogram::components)
    }

    /// The table of the densities along x′ and then along y′, with a Gaussian of this variance if
    /// theory predicts one.
    pub(super) fn table(
        &self,
        densities: &[BlockMean],
        context: &Context<'_>,
        variance: Option<f64>,
    ) -> Table {
        let components = self.components();
        let bins = AdaptiveHistogram::common_bins(&components);
        let edges = bins.edges();
        let mut table = Table::new(
            context.table("projections"),
            "Components of the impulses on the body",
        )
        .bins("impulse", "mass·length/time", edges)
        .caption(format!(
            "Along the body's own axes x′ and y′. {}",
            range::caption(&components)
        ));
        let (along_x, along_y) = densities.split_at(densities.len() / 2);
        for (name, densities) in [("density_x", along_x), ("density_y", along_y)] {
            table = table.means(name, "time/(mass·length)", densities);
            if let Some(variance) = variance {
                let means = edges
                    .windows(2)
                    .map(|bin| Some(mean_of_gaussian([bin[0], bin[1]], variance)));
                table = table.prediction("Gaussian of variance 4μkT", means.collect(), GAUSSIAN);
            }
        }
        table
    }
}

impl Measured for Projections {
    /// The share of the components outside the range, along x′ and along y′.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.components().map(range::outside).to_vec()
    }

    /// Along x′ and along y′.
    fn distributions(&self) -> Vec<Vec<&AdaptiveHistogram>> {
        vec![self.components().to_vec()]
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let (outside, densities) = means.split_at(means.len().min(2));
        let table = self.table(densities, context, None);
        let components = self.components();
        let what = ["impulses along x′", "impulses along y′"];
        let outside = components.into_iter().zip(what).zip(outside).filter_map(
            |((distribution, what), mean)| {
                range::share_outside(distribution, what, Some(mean), context)
            },
        );
        Results {
            tables: vec![table],
            figures: outside.collect(),
            ..Results::default()
        }
    }
}
