//! `heat-conductivity`: heat conductivity from the Helfand moment of the energy.

use carom::{CollisionReport, Observer, View, engine::Body, observers::HelfandMoment};
use carom_tables::{BlockMean, Figure, Sums, Table};
use serde::{Deserialize, Serialize};

use super::{
    Context, MAX_LAG, MeasureKind, Measured, Of, Results, Span, hard_discs::SONINE, in_blocks,
    resumed, slope::Slope,
};

/// The conductivity is the slope of the mean square between these lags (mean free times).
const SLOPE_FROM: f64 = 5.0;
const SLOPE_TO: f64 = 20.0;

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "heat-conductivity",
    summary: "heat conductivity of the whole system from the Helfand moment of the energy",
    of: Of::System,
    span: Span::Measurement,
    parameters: &[MAX_LAG],
    figures: &["heat conductivity"],
    start: |selection| {
        let (interval, longest) = (selection.interval(), selection.longest_lag());
        Ok(in_blocks(Heat(HelfandMoment::of_energy(
            interval, longest,
        )?)))
    },
    resume: resumed::<Heat>,
};

/// The Helfand moment of the energy.
#[derive(Serialize, Deserialize)]
struct Heat(HelfandMoment);

impl Observer for Heat {
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.0.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.0.start(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.0.sample(view);
    }
}

impl Measured for Heat {
    fn sums(&self) -> Sums {
        self.0.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.0.points();
        let lags: Vec<f64> = points.iter().map(|point| point.lag).collect();
        let means = context.resolved(means, &lags);
        let name = context.table("heat-conductivity");
        let table = Table::new(name, "Mean squared Helfand moment of the energy")
            .logarithmic()
            .abscissa("lag", "time", lags.clone())
            .counts(
                "origins",
                points.iter().map(|point| point.origins).collect(),
            )
            .means("mean_square", "mass²·length⁶/time⁴", &means)
            .caption(context.theory(
                "Its slope over 2 A (kT)² is the heat conductivity by k, for bodies of one kind.",
            ));
        let figures = conductivity(&lags, &means, context).into_iter().collect();
        Results {
            tables: vec![table],
            figures,
            ..Results::default()
        }
    }
}

/// The heat conductivity by Boltzmann's constant from the slope of the mean square.
fn conductivity(lags: &[f64], means: &[BlockMean], context: &Context<'_>) -> Option<Figure> {
    let gas = context.gas()?;
    let slope = Slope::between([SLOPE_FROM, SLOPE_TO], lags, means, gas)?;
    let scale = 1.0 / (2.0 * gas.area * gas.temperature * gas.temperature);
    let error = slope.standard_error.map(|error| scale * error);
    let name = context.named(&format!(
        "heat conductivity λ/k, from lags {}",
        slope.lags()
    ));
    let figure = Figure::new(name, scale * slope.value, "1/time").error(error);
    Some(figure.predicted(gas.heat_conductivity(), SONINE))
}
