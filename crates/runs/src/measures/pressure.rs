//! `pressure`: pressure from the virial of the contacts, in each interval between samples.

use anyhow::Result;
use carom::{
    CollisionReport, Observer, View,
    engine::Body,
    observers::{Pressure, PressurePoint},
};
use carom_tables::{BlockMean, Sums, Table};
use serde::{Deserialize, Serialize};

use super::{
    Context, HardDiscs, Label, MeasureKind, Measured, Of, Results, Span, hard_discs::LIU,
    in_blocks, intervals::IntervalSums, point_bytes, resumed,
};
use crate::{append_file::AppendFiles, series::PRESSURE};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "pressure",
    summary: "pressure from the virial of the contacts in each interval",
    of: Of::System,
    span: Span::Measurement,
    parameters: &[],
    figures: &["pressure", "compressibility factor βpA/N"],
    start: |_| Ok(in_blocks(Virial::default())),
    resume: resumed::<Virial>,
};

/// Unit of a pressure.
const UNIT: &str = "mass/time²";

/// The pressure, and the sums of its mean and of that of an ideal gas.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Virial {
    observer: Pressure,
    means: IntervalSums,
    /// Whether an interval had no temperature, so that there is no factor.
    lacks_temperature: bool,
}

impl Observer for Virial {
    fn watches_any(&self) -> bool {
        self.observer.watches_any()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.observer.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.observer.start(view);
    }

    fn pause(&mut self, view: &View<'_>) {
        self.observer.pause(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.observer.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        let before = self.observer.series().len();
        self.observer.sample(view);
        let new = &self.observer.series()[before..];
        let time = view.time().to_f64();
        match new.first() {
            Some(point) => {
                self.lacks_temperature |= point.ideal == 0.0;
                self.means.end(time, &[point.pressure(), point.ideal]);
            }
            None => self.means.end(time, &[]),
        }
    }
}

impl Measured for Virial {
    const OF_INTERVALS: bool = true;

    /// The pressure, weighted with the lengths of the intervals, and the compressibility factor:
    /// the ratio of the means. The mean of ratios differs from it where the temperature fluctuates.
    fn sums(&self) -> Sums {
        let sums = self.means.sums();
        let [pressure, ideal] = [0, 1].map(|n| sums.get(n).copied().unwrap_or_default());
        let factor = if self.lacks_temperature {
            [0.0; 2]
        } else {
            [pressure[0], ideal[0]]
        };
        vec![pressure, factor]
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.observer.series())
    }

    fn present(&self) -> Vec<(&'static str, Option<f64>)> {
        let last = self.observer.series().last();
        vec![
            ("p", last.map(PressurePoint::pressure)),
            ("Z", last.and_then(PressurePoint::compressibility_factor)),
        ]
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.observer.series();
        let of =
            |part: fn(&PressurePoint) -> f64| -> Vec<f64> { points.iter().map(part).collect() };
        let gas = context.gas();
        let pressures = points.iter().map(|point| Some(point.pressure())).collect();
        let table = Table::new(context.table("pressure"), "Pressure")
            .abscissa("time", "time", of(|point| point.time))
            .value("pressure", UNIT, pressures)
            .level("Liu", gas.map(HardDiscs::pressure), LIU)
            .undrawn("ideal", UNIT, of(|point| point.ideal))
            .undrawn("virial", UNIT, of(|point| point.virial))
            .undrawn("momentum_flux", UNIT, of(PressurePoint::momentum_flux))
            .caption("From the virial of the contacts in each interval between samples.");
        let names = [
            ("pressure", UNIT, gas.map(HardDiscs::pressure)),
            (
                "compressibility factor βpA/N",
                "1",
                gas.map(HardDiscs::compressibility_factor),
            ),
        ];
        let figures = context.figures(names, means, LIU);
        Results {
            tables: vec![table],
            figures,
            ..Results::default()
        }
    }

    fn append(&mut self, files: &mut AppendFiles, label: &Label) -> Result<()> {
        files.append_to(
            &label.file(PRESSURE.name),
            &PRESSURE,
            self.observer.series(),
        )
    }
}
