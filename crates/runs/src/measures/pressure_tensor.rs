//! `pressure-tensor`: the flux of momentum along both axes.

use carom::PressureTensor;
use carom_tables::{BlockMean, Table};

use super::{
    Context, MeasureKind, Measured, Of, Results, Span, hard_discs::LIU, in_blocks, point_bytes,
    resumed,
};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "pressure-tensor",
    summary: "pressure tensor of the whole system in each interval between samples",
    of: Of::System,
    span: Span::Measurement,
    parameters: &[],
    figures: &["p_xx", "p_xy", "p_yx", "p_yy", VISCOSITY, DIFFERENCE],
    start: |_| Ok(in_blocks(PressureTensor::default())),
    resume: resumed::<PressureTensor>,
};

/// Name of the viscosity −(p_xy + p_yx)/2γ, under shear.
const VISCOSITY: &str = "shear viscosity";

/// Name of p_xx − p_yy, under shear.
const DIFFERENCE: &str = "first normal-stress difference p_xx − p_yy";

/// Unit of a pressure.
const UNIT: &str = "mass/time²";

impl Measured for PressureTensor {
    /// p_xx, p_xy, p_yx, p_yy, the viscosity and the first normal-stress difference.
    fn sums(&self) -> Vec<[f64; 2]> {
        let mut sums = self.sums();
        let [xx, yy] = [sums[0], sums[3]];
        sums.extend([self.viscosity_sum(), [xx[0] - yy[0], xx[1]]]);
        sums
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.series();
        let of = |part: fn(&carom::observers::TensorPoint) -> f64| -> Vec<Option<f64>> {
            points.iter().map(|point| Some(part(point))).collect()
        };
        // The flux lacks kT / A, because momentum conservation removes two degrees of freedom.
        let normal = context
            .gas()
            .map(|gas| gas.pressure() - gas.temperature / gas.area);
        let table = Table::new(context.table("pressure-tensor"), "Pressure tensor")
            .abscissa("time", "time", points.iter().map(|point| point.time).collect())
            .value("p_xx", UNIT, of(carom::observers::TensorPoint::xx))
            .value("p_xy", UNIT, of(carom::observers::TensorPoint::xy))
            .value("p_yx", UNIT, of(carom::observers::TensorPoint::yx))
            .value("p_yy", UNIT, of(carom::observers::TensorPoint::yy))
            .caption(
                "Flux of momentum relative to the centre of mass, and to the flow under shear; p_xy = 0 on average \
                 without shear.",
            );
        let is_sheared = self.viscosity_sum()[1] > 0.0;
        let isotropic = Some(0.0).filter(|_| !is_sheared);
        let predictions = [normal, isotropic, isotropic, normal];
        let names = ["p_xx", "p_xy", "p_yx", "p_yy"]
            .into_iter()
            .zip(predictions);
        let figure = |((name, prediction), mean): ((&str, Option<f64>), &BlockMean)| {
            let source = if name == "p_xx" || name == "p_yy" {
                LIU
            } else {
                "isotropy"
            };
            Some(
                context
                    .figure(name, UNIT, mean)?
                    .predicted(prediction, source),
            )
        };
        let mut figures: Vec<_> = names.zip(means).filter_map(figure).collect();
        if let [.., viscosity, difference] = means
            && is_sheared
        {
            figures.extend(context.figure(VISCOSITY, "mass/time", viscosity));
            figures.extend(context.figure(DIFFERENCE, UNIT, difference));
        }
        Results {
            tables: vec![table],
            figures,
            ..Results::default()
        }
    }
}
