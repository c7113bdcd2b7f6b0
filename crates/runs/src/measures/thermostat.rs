//! `thermostat`: the energy that edits put in and contacts lose, and the heat that thermostats give
//! to each tag, in each interval between samples.

use carom::{ThermostatLedger, observers::HeatOfTag};
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

/// Heat below this share of the energy, for each interval between samples, is rounding: that of an
/// action that leaves the speeds as they are. Smaller: many actions in an interval exceed it.
/// Larger: a weak thermostat is hidden.
const ROUNDING: f64 = 1e-12;

/// Heat that is given in so many intervals by thermostats that act on bodies of this energy; 0 if
/// it is rounding.
fn heat_given(heat: f64, energy: f64, intervals: usize) -> f64 {
    if heat.abs() > ROUNDING * energy * intervals as f64 {
        heat
    } else {
        0.0
    }
}

/// The heat of a tag in each interval.
fn heat_series(ledger: &ThermostatLedger, of_tag: &HeatOfTag) -> Vec<Option<f64>> {
    let intervals = of_tag.series().iter().zip(ledger.series());
    intervals
        .map(|(&heat, point)| Some(heat_given(heat, point.energy, 1)))
        .collect()
}

impl Measured for ThermostatLedger {
    const OF_INTERVALS: bool = true;

    /// Energy lost per time, then heat per time of each tag: with thermostats, up to their last
    /// action, so that all blocks begin and end in one phase.
    fn sums(&self) -> Vec<[f64; 2]> {
        let energy = self.series().last().map_or(0.0, |point| point.energy);
        let given = |of_tag: &HeatOfTag| {
            let [heat, time] = of_tag.between_actions().unwrap_or_default();
            [heat_given(heat, energy, self.series().len()), time]
        };
        let heats = self.heats().iter().map(given);
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
            .value(
                "put_in",
                unit,
                of(|point| heat_given(point.put_in, point.energy, 1)),
            )
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
                heat = heat.value(of_tag.name(), unit, heat_series(self, of_tag));
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

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{
        Observer,
        engine::{DrawKey, Scene, Simulation, ThermostatRule, ThermostatTarget},
    };

    /// Heat and time of the only tag after some actions of a thermostat.
    fn heat_given_by(rule: ThermostatRule) -> [f64; 2] {
        let text =
            "[[gas]]\ntags = [\"gas\"]\nradius = 0.01\nmass = 0.3\nenergy = 1.1\ncount = 100";
        let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
        let gas = simulation.find_tag("gas").unwrap();
        let mut ledger = ThermostatLedger::default();
        ledger.sample(&simulation.view());
        for action in 0..5 {
            let key = DrawKey {
                seed: 1,
                replica: 0,
                action,
            };
            simulation
                .edit(|batch| batch.thermostat(gas, &rule, key))
                .unwrap();
            ledger.start(&simulation.view());
            let time = 0.1 * (action + 1) as f64;
            simulation.observe_until(time, &mut ledger).unwrap();
            ledger.sample(&simulation.view());
        }
        let heat = heat_series(&ledger, &ledger.heats()[0]);
        assert_eq!(heat.len(), 5);
        Measured::sums(&ledger)[1]
    }

    #[test]
    fn a_thermostat_that_turns_velocities_gives_no_heat() {
        let [heat, time] = heat_given_by(ThermostatRule::Rotate);
        assert_eq!(heat, 0.0);
        assert!((time - 0.4).abs() < 1e-12, "{time}");
        let [heat, _] = heat_given_by(ThermostatRule::Maxwell(ThermostatTarget::Temperature(3.0)));
        assert!(heat != 0.0);
        assert_eq!(
            [1e-12, -3e-9].map(|heat| heat_given(heat, 110.0, 5)),
            [0.0, -3e-9]
        );
    }
}
