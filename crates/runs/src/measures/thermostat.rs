//! `thermostat`: the energy that edits put in and contacts lose, in each interval between samples.

use carom::ThermostatLedger;
use carom_tables::{BlockMean, Table};

use super::{Context, Kind, Measured, Of, Results, in_blocks, resumed};

pub(super) const KIND: Kind = Kind {
    name: "thermostat",
    summary: "energy put in by edits, lost in contacts and received from walls, between samples",
    of: Of::System,
    begin: |_| Ok(in_blocks(ThermostatLedger::default())),
    resume: resumed::<ThermostatLedger>,
};

impl Measured for ThermostatLedger {
    fn results(&self, _: &[BlockMean], _: &Context<'_>) -> Results {
        let of = |value: fn(&carom::observers::ThermostatPoint) -> f64| -> Vec<Option<f64>> {
            self.series().iter().map(|point| Some(value(point))).collect()
        };
        let unit = "mass·length²/time²";
        let table = Table::new("thermostat", "Energy put in, lost, and present")
            .abscissa("time", "time", self.series().iter().map(|point| point.time).collect())
            .abscissa("duration", "time", self.series().iter().map(|point| point.duration).collect())
            .value("put_in", unit, of(|point| point.put_in))
            .value("lost", unit, of(|point| point.lost))
            .value("heat", unit, of(|point| point.heat))
            .value("energy", unit, of(|point| point.energy))
            .caption(
                "Put in by edits, lost in contacts and received from walls with a temperature in each interval between \
                 samples; energy at its end.",
            );
        Results { tables: vec![table], figures: Vec::new() }
    }
}
