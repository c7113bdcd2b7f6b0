//! `viscosity`: shear viscosity from the Helfand moment.

use carom::observers::HelfandMoment;
use carom_tables::{BlockMean, Figure, Table};

use super::{
    Context, Kind, Measured, Of, Results, correlation::LONGEST_LAG, hard_discs::ENSKOG, in_blocks, resumed,
};

/// The viscosity is the slope of the mean square between these lags (mean free times).
const SLOPE_FROM: f64 = 5.0;
const SLOPE_TO: f64 = 20.0;

pub(super) const KIND: Kind = Kind {
    name: "viscosity",
    summary: "shear viscosity of the whole system from the Helfand moment of the stress",
    of: Of::System,
    begin: |selection| {
        let interval = selection.run.sample_interval;
        let longest = (interval * LONGEST_LAG).min(f64::MAX);
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
        let means = &means[..points.len().min(means.len())];
        let error = |(mean, &lag): (&BlockMean, &f64)| mean.standard_error.filter(|_| lag < context.block);
        let table = Table::new("viscosity", "Mean squared Helfand moment of the shear stress")
            .logarithmic()
            .abscissa("lag", "time", lags.clone())
            .counts("origins", points.iter().map(|point| point.origins).collect())
            .value("mean_square", "mass²·length⁴/time²", means.iter().map(|mean| mean.value).collect())
            .errors(means.iter().zip(&lags).map(error).collect())
            .caption(context.theory("Its slope over 2 A kT is the shear viscosity."));
        Results { tables: vec![table], figures: viscosity(&lags, means, context).into_iter().collect() }
    }
}

/// The viscosity from the slope of the mean square.
fn viscosity(lags: &[f64], means: &[BlockMean], context: &Context<'_>) -> Option<Figure> {
    let gas = context.hard_discs.as_ref().ok()?;
    let rate = gas.collision_rate();
    let at = |free_times: f64| {
        let (lag, mean) = lags.iter().zip(means).find(|(lag, _)| **lag * rate >= free_times)?;
        Some((*lag, *mean))
    };
    let ((begin, first), (end, last)) = (at(SLOPE_FROM)?, at(SLOPE_TO)?);
    if end <= begin {
        return None;
    }
    let scale = 1.0 / (2.0 * gas.area * gas.temperature * (end - begin));
    let value = scale * (last.value? - first.value?);
    // Both have the same origins: the later one has nearly all of the error.
    let error = last.standard_error.filter(|_| end < context.block).map(|error| scale * error);
    let name = format!("shear viscosity, from lags {begin:.3} to {end:.3}");
    Some(Figure::new(name, value, "mass/time").error(error).predicted(gas.viscosity(), ENSKOG))
}
