//! `viscosity`: shear viscosity from the Helfand moment.

use carom::observers::HelfandMoment;
use carom_tables::{BlockMean, Figure, Table};

use super::{
    Context, MAX_LAG, MeasureKind, Measured, Of, Results, Span, hard_discs::SONINE, in_blocks,
    resumed, slope::Slope,
};

/// The viscosity is the slope of the mean square between these lags (mean free times).
const SLOPE_FROM: f64 = 5.0;
const SLOPE_TO: f64 = 20.0;

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "viscosity",
    summary: "shear viscosity of the whole system from the Helfand moment of the stress",
    of: Of::System,
    span: Span::Measurement,
    parameters: &[MAX_LAG],
    figures: &["shear viscosity"],
    start: |selection| {
        let (interval, longest) = (selection.interval(), selection.longest_lag());
        Ok(in_blocks(HelfandMoment::new(interval, longest)?))
    },
    resume: resumed::<HelfandMoment>,
};

impl Measured for HelfandMoment {
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.points();
        let lags: Vec<f64> = points.iter().map(|point| point.lag).collect();
        let means = context.resolved(means, &lags);
        let table = Table::new(
            context.table("viscosity"),
            "Mean squared Helfand moment of the shear stress",
        )
        .logarithmic()
        .abscissa("lag", "time", lags.clone())
        .counts(
            "origins",
            points.iter().map(|point| point.origins).collect(),
        )
        .means("mean_square", "mass²·length⁴/time²", &means)
        .caption(context.theory("Its slope over 2 A kT is the shear viscosity."));
        Results {
            tables: vec![table],
            figures: viscosity(&lags, &means, context).into_iter().collect(),
            ..Results::default()
        }
    }
}

/// The viscosity from the slope of the mean square.
fn viscosity(lags: &[f64], means: &[BlockMean], context: &Context<'_>) -> Option<Figure> {
    let gas = context.gas()?;
    let slope = Slope::between([SLOPE_FROM, SLOPE_TO], lags, means, gas)?;
    let scale = 1.0 / (2.0 * gas.area * gas.temperature);
    let error = slope.standard_error.map(|error| scale * error);
    let name = context.named(&format!("shear viscosity, from lags {}", slope.lags()));
    Some(
        Figure::new(name, scale * slope.value, "mass/time")
            .error(error)
            .predicted(gas.viscosity(), SONINE),
    )
}
