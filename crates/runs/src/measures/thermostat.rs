//! `thermostat`: the energy that edits put in and contacts lose, in each interval between samples.

use carom::ThermostatLedger;
use carom_tables::{BlockMean, Figure, Table};

use super::{Context, Kind, Measured, Of, Results, in_blocks, resumed};

pub(super) const KIND: Kind = Kind {
    name: "thermostat",
    summary: "energy put in by edits and lost in contacts, in each interval between samples",
    of: Of::System,
    begin: |_| Ok(in_blocks(ThermostatLedger::default())),
    resume: resumed::<ThermostatLedger>,
};

impl Measured for ThermostatLedger {
    /// Heat per time of each tag, then energy lost per time.
    fn sums(&self) -> Vec<[f64; 2]> {
        let time = self.duration();
        let heats = self.heats().iter().map(|heat| [heat.total(), time]);
        std::iter::once([self.total_lost(), time]).chain(heats).collect()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let of = |value: fn(&carom::observers::ThermostatPoint) -> f64| -> Vec<Option<f64>> {
            self.series().iter().map(|point| Some(value(point))).collect()
        };
        let unit = "mass·length²/time²";
        let mut table = Table::new("thermostat", "Energy put in, lost, and present")
            .abscissa("time", "time", self.series().iter().map(|point| point.time).collect())
            .abscissa("duration", "time", self.series().iter().map(|point| point.duration).collect())
            .value("put_in", unit, of(|point| point.put_in))
            .value("lost", unit, of(|point| point.lost))
            .value("energy", unit, of(|point| point.energy))
            .caption(
                "Put in by edits and lost in contacts in each interval between samples; energy at its end; heat \
                 given by thermostats to the bodies of each tag, a part of what is put in.",
            );
        for heat in self.heats() {
            let values = heat.series().iter().map(|&value| Some(value)).collect();
            table = table.value(&format!("heat_{}", heat.name()), unit, values);
        }
        let mut names = vec![context.named("energy lost in contacts per time")];
        names.extend(self.heats().iter().map(|heat| format!("heat given per time, {}", heat.name())));
        let figure = |(name, mean): (&String, &BlockMean)| {
            Some(Figure::new(name, mean.value?, "mass·length²/time³").error(mean.standard_error))
        };
        Results { tables: vec![table], figures: names.iter().zip(means).filter_map(figure).collect() }
    }
}
