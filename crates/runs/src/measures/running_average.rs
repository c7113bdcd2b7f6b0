//! `running-average:TAG`: how the mean force and velocity of one body settle.

use carom::{RunningAverage, observers::RunningPoint};
use carom_tables::{BlockMean, Table};

use super::{Context, MeasureKind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "running-average",
    summary: "mean force and velocity so far of the only body with the tag, in its own frame",
    of: Of::OneBody,
    span: Span::Measurement,
    parameters: &[],
    figures: &[],
    start: |selection| {
        Ok(in_blocks(RunningAverage::new(
            selection.only_body()?.body.key(),
        )))
    },
    resume: resumed::<RunningAverage>,
};

impl Measured for RunningAverage {
    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, _: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.series();
        let of =
            |part: fn(&RunningPoint) -> f64| points.iter().map(|point| Some(part(point))).collect();
        let force = "mass·length/time²";
        let table = Table::new(context.table("running-average"), "Running averages")
            .abscissa(
                "time",
                "time",
                points.iter().map(|point| point.time).collect(),
            )
            .value("force_x", force, of(|point| point.momentum.x))
            .value("force_y", force, of(|point| point.momentum.y))
            .value("velocity_x", "length/time", of(|point| point.velocity.x))
            .value("velocity_y", "length/time", of(|point| point.velocity.y))
            .caption(
                "Means since the start of the measurement, along the body's own axes x′ and y′.",
            );
        Results {
            tables: vec![table],
            ..Results::default()
        }
    }
}
