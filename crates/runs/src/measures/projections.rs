//! `projections:TAG`: components of the impulses on one body along its own axes.

use carom::{CollisionReport, Observer, ProjectionHistogram, engine::Body, observers::Axis};
use carom_tables::{BlockMean, Table};
use serde::{Deserialize, Serialize};

use super::{Context, Default, Kind, Measured, Of, Parameter, Results, Selection, Span, in_blocks, resumed};

/// Half of the range in thermal momenta √(2 m kT) of the lightest other body: beyond it lies a
/// share of about 10⁻⁷ of the impulses of a heavy body.
const THERMAL_MOMENTA: f64 = 8.0;

pub(super) const KIND: Kind = Kind {
    name: "projections",
    summary: "components of the impulses on the only body with the tag, along its own axes",
    of: Of::OneBody,
    span: Span::Measurement,
    parameters: &[
        Parameter::whole("bins", Default::Number(160.0), "bins of the histogram"),
        Parameter::positive(
            "max",
            Default::FromScene("8 thermal momenta"),
            "half the range (mass·length/time)",
        ),
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
        let others =
            selection.view.bodies().filter(|other| !other.body.is_fixed() && other.body.key() != body);
        let lightest = others.map(|other| other.body.molecule().mass()).fold(f64::INFINITY, f64::min);
        let own = selection.only_body()?.body.molecule().mass();
        let mass = if lightest.is_finite() { lightest } else { own };
        let kt = selection.view.temperature().filter(|kt| *kt > 0.0).unwrap_or(selection.view.energy());
        let thermal = THERMAL_MOMENTA * (2.0 * mass * kt).sqrt();
        let half_width = selection.given("max").unwrap_or(thermal);
        let along = |axis| ProjectionHistogram::new(body, axis, half_width, selection.whole("bins"));
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

impl Measured for Projections {
    /// The density in each bin along x′, then along y′.
    fn sums(&self) -> Vec<[f64; 2]> {
        let of = |histogram: &ProjectionHistogram| {
            let (width, total) = (histogram.components().width(), histogram.hits() as f64);
            let counts = histogram.components().counts().iter();
            counts.map(|&count| [count as f64 / width, total]).collect::<Vec<_>>()
        };
        self.0.iter().flat_map(of).collect()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let bins = self.0[0].components();
        let (along_x, along_y) = means.split_at(means.len() / 2);
        let unit = "time/(mass·length)";
        let table = Table::new(context.table("projections"), "Components of the impulses on the body")
            .abscissa("impulse", "mass·length/time", (0..along_x.len()).map(|bin| bins.centre(bin)).collect())
            .means("density_x", unit, along_x)
            .means("density_y", unit, along_y)
            .caption("Along the body's own axes x′ and y′.");
        Results { tables: vec![table], ..Results::default() }
    }
}
