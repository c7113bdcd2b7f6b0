//! `thermostat`: the energy that edits put in and contacts lose, and the heat that thermostats give
//! to each tag, in each interval between samples.

use carom::ThermostatLedger;
use carom_tables::{BlockMean, Figure, Table};

use super::{Context, MeasureKind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "thermostat",
    summary: "energy put in by edits, lost in contacts and received from walls, between samples",
    of: Of::System,
    span: Span::Measurement,
    parameters: &[],
    figures: &["energy lost in contacts", "heat given per time"],
    start: |_| Ok(in_blocks(ThermostatLedger::default())),
    resume: resumed::<ThermostatLedger>,
};

impl Measured for ThermostatLedger {
    const OF_INTERVALS: bool = true;

    /// Energy lost per time, then heat per time of each tag: with thermostats, up to their last
    /// action, so that all blocks begin and end in one phase.
    fn sums(&self) -> Vec<[f64; 2]> {
        let heats = self
            .heats()
            .iter()
            .map(|heat| heat.between_actions().unwrap_or_default());
        std::iter::once(self.lost_until_action())
            .chain(heats)
            .collect()
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series()) + self.heats().len() * size_of::<f64>()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let of = |value: fn(&carom::observers::ThermostatPoint) -> f64| -> Vec<Option<f64>> {
            self.series()
                .iter()
                .map(|point| Some(value(point)))
                .collect()
        };
        let unit = "mass·length²/time²";
        let begun = |name: &str, title: &str| {
            let times = self.series().iter().map(|point| point.time).collect();
            let durations = self.series().iter().map(|point| point.duration).collect();
            Table::new(context.table(name), title)
                .abscissa("time", "time", times)
                .undrawn("duration", "time", durations)
        };
        let table = begun("thermostat", "Energy put in, lost, and present")
            .value("put_in", unit, of(|point| point.put_in))
            .value("lost", unit, of(|point| point.lost))
            .value("heat", unit, of(|point| point.heat))
            .value("energy", unit, of(|point| point.energy))
            .caption(
                "Put in by edits, lost in contacts and received from walls with a temperature in each interval between \
                 samples; energy at its end.",
            );
        let mut tables = vec![table];
        if !self.heats().is_empty() {
            let mut heat = begun("heat", "Heat given by thermostats, by tag").caption(
                "Energy given to the bodies of each tag in each interval between samples; negative if it is taken \
                 away.",
            );
            for of_tag in self.heats() {
                heat = heat.value(
                    of_tag.name(),
                    unit,
                    of_tag.series().iter().copied().map(Some).collect(),
                );
            }
            tables.push(heat);
        }
        let mut names = vec![context.named("energy lost in contacts per time")];
        names.extend(
            self.heats()
                .iter()
                .map(|heat| format!("heat given per time, {}", heat.name())),
        );
        let figure = |(name, mean): (&String, &BlockMean)| {
            let figure =
                Figure::new(name, mean.value?, "mass·length²/time³").error(mean.standard_error);
            Some(Figure {
                quantity: mean.quantity,
                ..figure
            })
        };
        let figures = names.iter().zip(means).filter_map(figure).collect();
        Results {
            tables,
            figures,
            ..Results::default()
        }
    }
}
