//! `projections:TAG`: components of the impulses on one body along its own axes.

use carom::{
    CollisionReport, Observer, ProjectionHistogram,
    engine::Body,
    observers::{Axis, Distribution},
};
use carom_tables::{BlockMean, Table};
use serde::{Deserialize, Serialize};

use super::{
    Context, Default, Kind, Measured, Of, Parameter, Results, Selection, Span, in_blocks, range, resumed,
};

pub(super) const KIND: Kind = Kind {
    name: "projections",
    summary: "components of the impulses on the only body with the tag, along its own axes",
    of: Of::OneBody,
    span: Span::Measurement,
    parameters: &[
        Parameter::whole("bins", Default::Number(160.0), "bins of the histogram"),
        Parameter::positive(range::MAX, range::FOLLOWS, "half the range (mass·length/time)"),
    ],
    begin: |selection| Ok(in_blocks(Projections::new(selection)?)),
    resume: resumed::<Projections>,
};

/// The components along x′ and y′.
#[derive(Serialize, Deserialize)]
struct Projections([ProjectionHistogram; 2]);

impl Projections {
    fn new(selection: &Selection<'_>) -> anyhow::Result<Self> {
        let body = selection.only_body()?.body.key();
        let bins = selection.whole("bins");
        let along = |axis| match selection.given(range::MAX) {
            Some(half_width) => ProjectionHistogram::new(body, axis, half_width, bins),
            None => Ok(ProjectionHistogram::adaptive(body, axis, bins)),
        };
        Ok(Self([along(Axis::X)?, along(Axis::Y)?]))
    }
}

impl Observer for Projections {
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.0[0].watches(bodies)
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0.iter_mut().for_each(|histogram| histogram.collision(report));
    }
}

impl Projections {
    fn components(&self) -> [&Distribution; 2] {
        self.0.each_ref().map(ProjectionHistogram::components)
    }
}

impl Measured for Projections {
    /// The share of the components outside the range, along x′ and along y′.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.components().map(range::outside).to_vec()
    }

    /// Along x′ and along y′.
    fn distributions(&self) -> Vec<Vec<&Distribution>> {
        vec![self.components().to_vec()]
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let components = self.components();
        let bins = Distribution::common_bins(&components);
        let (outside, densities) = means.split_at(means.len().min(2));
        let (along_x, along_y) = densities.split_at(densities.len() / 2);
        let unit = "time/(mass·length)";
        let table = Table::new(context.table("projections"), "Components of the impulses on the body")
            .bins("impulse", "mass·length/time", bins.edges())
            .means("density_x", unit, along_x)
            .means("density_y", unit, along_y)
            .caption(format!("Along the body's own axes x′ and y′. {}", range::caption(&components)));
        let what = ["impulses along x′", "impulses along y′"];
        let outside =
            components.into_iter().zip(what).zip(outside).filter_map(|((distribution, what), mean)| {
                range::share_outside(distribution, what, Some(mean), context)
            });
        Results { tables: vec![table], figures: outside.collect(), ..Results::default() }
    }
}
