//! `energy`: energy, its expected value and momentum at each sample of the whole run.

use anyhow::Result;
use carom::{EnergyLedger, observers::LedgerPoint};
use carom_tables::{BlockMean, Table, Totals};

use super::{
    Context, Label, MeasureKind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed,
};
use crate::{append_file::AppendFiles, series::ENERGY};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "energy",
    summary: "energy, ledger and momentum at each sample; always checked",
    of: Of::System,
    span: Span::WholeRun,
    parameters: &[],
    figures: &[],
    start: |_| Ok(in_blocks(EnergyLedger::default())),
    resume: resumed::<EnergyLedger>,
};

impl Measured for EnergyLedger {
    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, _: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.series();
        let of = |part: fn(&LedgerPoint) -> f64| -> Vec<f64> { points.iter().map(part).collect() };
        let drift = self.drifts().map(Some);
        let (energy, momentum) = ("mass·length²/time²", "mass·length/time");
        let table = Table::new(context.table("energy"), "Energy")
            .abscissa("time", "time", of(|point| point.time))
            .undrawn("energy", energy, of(|point| point.energy))
            .undrawn("booked_energy", energy, of(|point| point.booked))
            .undrawn("momentum_x", momentum, of(|point| point.momentum.x))
            .undrawn("momentum_y", momentum, of(|point| point.momentum.y))
            .derived("E", energy, points.iter().map(|point| Some(point.energy)).collect())
            .derived("(E − booked E) / E(0)", "1", drift.collect())
            .caption(
                "The difference of energy and ledger is rounding error; it must stay below 10⁻¹², or 3.6·10⁻¹⁵ √n after more than \
                 80 000 contacts n; of few bodies N, whose errors may repeat, below 2.9·10⁻¹⁵ n/N^(3/2). Once \
                 contacts have lost, or edits put in, more than E(0), it is relative to the most so far.",
            );
        let totals = Totals {
            energy_drift: self.drift(),
            ..Totals::default()
        };
        Results {
            tables: vec![table],
            totals,
            ..Results::default()
        }
    }

    fn append(&mut self, files: &mut AppendFiles, label: &Label) -> Result<()> {
        files.append_to(&label.file(ENERGY.name), &ENERGY, self.series())
    }
}
