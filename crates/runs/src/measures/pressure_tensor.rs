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
    figures: &["p_xx", "p_xy", "p_yx", "p_yy"],
    start: |_| Ok(in_blocks(PressureTensor::default())),
    resume: resumed::<PressureTensor>,
};

/// Unit of a pressure.
const UNIT: &str = "mass/time²";

impl Measured for PressureTensor {
    /// p_xx, p_xy, p_yx, p_yy.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
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
            .caption("Flux of momentum relative to the centre of mass; p_xy = 0 on average without shear.");
        let predictions = [normal, Some(0.0), Some(0.0), normal];
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
        Results {
            tables: vec![table],
            figures: names.zip(means).filter_map(figure).collect(),
            ..Results::default()
        }
    }
}
