//! `collision-rate`: collisions per body and time, in each interval between samples.

use anyhow::Result;
use carom::{CollisionRate, Observer, View, observers::RatePoint};
use carom_tables::{BlockMean, Sums, Table};
use serde::{Deserialize, Serialize};

use super::{
    Context, HardDiscs, Label, MeasureKind, Measured, Of, Results, Span, hard_discs::ENSKOG,
    in_blocks, intervals::IntervalSums, point_bytes, resumed,
};
use crate::{append_file::AppendFiles, series::RATES};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "collision-rate",
    summary: "collisions per body in each interval between samples",
    of: Of::System,
    span: Span::Measurement,
    parameters: &[],
    figures: &["collisions per body that moves"],
    start: |_| Ok(in_blocks(Rate::default())),
    resume: resumed::<Rate>,
};

/// Name of its figure.
pub(crate) const FIGURE: &str = "collisions per body that moves";

/// The rate and the sums of its mean.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Rate {
    observer: CollisionRate,
    sums: IntervalSums,
}

impl Observer for Rate {
    fn watches_any(&self) -> bool {
        false
    }

    fn start(&mut self, view: &View<'_>) {
        self.observer.start(view);
    }

    fn pause(&mut self, view: &View<'_>) {
        self.observer.pause(view);
    }

    fn sample(&mut self, view: &View<'_>) {
        let before = self.observer.series().len();
        self.observer.sample(view);
        let rates: Vec<f64> = self.observer.series()[before..]
            .iter()
            .map(|point| point.rate)
            .collect();
        self.sums.end(view.time().to_f64(), &rates);
    }
}

impl Measured for Rate {
    const OF_INTERVALS: bool = true;

    /// The rate, weighted with the lengths of the intervals.
    fn sums(&self) -> Sums {
        self.sums.sums()
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.observer.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.observer.series();
        let of = |part: fn(&RatePoint) -> f64| -> Vec<f64> { points.iter().map(part).collect() };
        let rates = points.iter().map(|point| Some(point.rate)).collect();
        let prediction = context.gas().map(HardDiscs::collision_rate);
        let table = Table::new(context.table("collision-rate"), "Collisions")
            .abscissa("time", "time", of(|point| point.time))
            .counts(
                "collisions",
                points.iter().map(|point| point.collisions).collect(),
            )
            .value("rate_per_body", "1/time", rates)
            .labelled("collisions per body")
            .level("Enskog", prediction, ENSKOG)
            .caption("Mean over the moving bodies in each interval between samples.");
        let figures = context.figures([(FIGURE, "1/time", prediction)], means, ENSKOG);
        Results {
            tables: vec![table],
            figures,
            ..Results::default()
        }
    }

    fn append(&mut self, files: &mut AppendFiles, label: &Label) -> Result<()> {
        files.append_to(&label.file(RATES.name), &RATES, self.observer.series())
    }
}
