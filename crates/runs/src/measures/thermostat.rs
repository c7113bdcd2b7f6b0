//! `thermostat`: the energy that edits put in and contacts lose, in each interval between samples.

use carom::ThermostatLedger;
use carom_tables::{BlockMean, Table};

use super::{Context, Kind, Measured, Of, Results, Span, in_blocks, resumed};

pub(super) const KIND: Kind = Kind {
    name: "thermostat",
    summary: "energy put in by edits and lost in contacts, in each interval between samples",
    of: Of::System,
    span: Span::Measurement,
    parameters: &[],
    begin: |_| Ok(in_blocks(ThermostatLedger::default())),
    resume: resumed::<ThermostatLedger>,
};

impl Measured for ThermostatLedger {
    fn results(&self, _: &[BlockMean], context: &Context<'_>) -> Results {
        let of = |value: fn(&carom::observers::ThermostatPoint) -> f64| -> Vec<Option<f64>> {
            self.series().iter().map(|point| Some(value(point))).collect()
        };
        let unit = "mass·length²/time²";
        let table = Table::new(context.table("thermostat"), "Energy put in, lost, and present")
            .abscissa("time", "time", self.series().iter().map(|point| point.time).collect())
            .undrawn("duration", "time", self.series().iter().map(|point| point.duration).collect())
            .value("put_in", unit, of(|point| point.put_in))
            .value("lost", unit, of(|point| point.lost))
            .value("energy", unit, of(|point| point.energy))
            .caption(
                "Put in by edits and lost in contacts in each interval between samples; energy at its end.",
            );
        Results { tables: vec![table], ..Results::default() }
    }
}
