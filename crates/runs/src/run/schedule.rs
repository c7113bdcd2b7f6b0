//! The order of all that happens in a run at given times: samples, snapshots, checks, starts of
//! stages, and actions of thermostats.
//!
//! Each time is a product, start + k · interval, not a sum of intervals. Steps whose times differ
//! by less than 1e-9 of the shortest interval of the run happen at one instant: first the sample,
//! then snapshot and check, then a stage starts, then thermostats act in the order of their list.

use carom::engine::{RunSpec, Scene, StageSpec};

use crate::sampling_times::{sampling_count, sampling_time};

/// Times that differ by less than this share of the shortest interval are one instant: they differ
/// by rounding. Larger: steps that a scene sets apart could change places.
const ROUNDING: f64 = 1e-9;

/// One step of a run at a given time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Its time.
    pub time: f64,
    /// What happens.
    pub what: What,
}

/// What happens in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// The observers sample.
    Sample,
    /// A snapshot is written; only in runs with an interval of their own for snapshots.
    Snapshot,
    /// Overlaps are checked; only in runs with an interval of their own for checks.
    Check,
    /// A stage starts with its edits; the first has started before the run.
    Stage(usize),
    /// A thermostat of a stage acts.
    Thermostat {
        /// Index of the stage.
        stage: usize,
        /// Index of the thermostat in the stage.
        index: usize,
    },
}

/// All steps of a run after time 0, in their order.
#[derive(Debug, Clone)]
pub struct Schedule {
    /// In the order of steps at one instant.
    series: Vec<Series>,
    tolerance: f64,
}

/// Steps at regular times.
#[derive(Debug, Clone, Copy)]
struct Series {
    what: What,
    begin: f64,
    end: f64,
    interval: f64,
    /// Index of the next step, from 0 for actions and from 1 for samples.
    next: u64,
    /// Number of samples; actions end one step earlier.
    count: u64,
}

impl Series {
    /// Samples, of which the last is at the end.
    fn samples(what: What, until: f64, interval: f64) -> Self {
        let count = sampling_count(0.0, until, interval);
        Self { what, begin: 0.0, end: until, interval, next: 1, count }
    }

    /// Actions from `begin` on, before `end`.
    fn actions(what: What, begin: f64, end: f64, interval: f64) -> Self {
        Self { what, begin, end, interval, next: 0, count: sampling_count(begin, end, interval) }
    }

    fn time(&self) -> Option<f64> {
        match self.what {
            What::Sample | What::Snapshot | What::Check => (self.next <= self.count)
                .then(|| sampling_time(self.begin, self.end, self.interval, self.next, self.count)),
            What::Stage(_) | What::Thermostat { .. } => {
                (self.next < self.count).then_some(self.begin + self.next as f64 * self.interval)
            }
        }
    }
}

/// Start and end of each stage (time); a run without stages has none.
pub fn spans(stages: &[StageSpec]) -> impl Iterator<Item = (f64, f64)> {
    let starts = std::iter::once(0.0).chain(stages.iter().map(|stage| stage.until));
    starts.zip(stages.iter().map(|stage| stage.until))
}

/// Number of actions of a thermostat in a stage of this span.
pub fn actions((start, end): (f64, f64), every: f64) -> u64 {
    sampling_count(start, end, every)
}

impl Schedule {
    /// The steps of a scene whose times are valid.
    pub fn new(scene: &Scene) -> Self {
        let RunSpec { until, sample_interval, snapshot_interval, check_interval, .. } = scene.run;
        let mut series = vec![Series::samples(What::Sample, until, sample_interval)];
        let apart = [(What::Snapshot, snapshot_interval), (What::Check, check_interval)];
        series.extend(
            apart.iter().filter_map(|&(what, interval)| {
                interval.map(|interval| Series::samples(what, until, interval))
            }),
        );
        for (stage, (spec, (start, end))) in scene.stage.iter().zip(spans(&scene.stage)).enumerate() {
            if stage > 0 {
                // One action, at the start.
                series.push(Series::actions(What::Stage(stage), start, end, end - start));
            }
            series.extend(spec.thermostat.iter().enumerate().map(|(index, thermostat)| {
                Series::actions(What::Thermostat { stage, index }, start, end, thermostat.every)
            }));
        }
        let shortest = series.iter().map(|series| series.interval).fold(until, f64::min);
        Self { series, tolerance: ROUNDING * shortest }
    }
}

impl Iterator for Schedule {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        let earliest = self.series.iter().filter_map(Series::time).reduce(f64::min)?;
        let limit = earliest + self.tolerance;
        let series = self.series.iter_mut().find(|series| series.time().is_some_and(|time| time <= limit))?;
        let time = series.time()?;
        series.next += 1;
        Some(Step { time, what: series.what })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(text: &str) -> Vec<(f64, What)> {
        let scene = Scene::from_toml(text).unwrap();
        Schedule::new(&scene).map(|step| (step.time, step.what)).collect()
    }

    #[test]
    fn a_run_without_stages_has_samples_only() {
        let expected = [0.4, 0.8, 1.0].map(|time| (time, What::Sample));
        assert_eq!(steps("run.until = 1.0\nrun.sample_interval = 0.4"), expected);
    }

    #[test]
    fn at_one_instant_samples_come_before_stages_and_stages_before_thermostats() {
        let found = steps(
            "run.sample_interval = 0.1\n[[stage]]\nuntil = 0.3\n\
             thermostat = [{ tag = \"a\", every = 0.1, energy = 1 }, { tag = \"b\", every = 0.2, energy = 1 }]\n\
             [[stage]]\nuntil = 0.5\nthermostat = [{ tag = \"a\", every = 0.15, energy = 1 }]",
        );
        let action = |stage, index| What::Thermostat { stage, index };
        let names: Vec<What> = found.iter().map(|step| step.1).collect();
        let expected = [
            action(0, 0),
            action(0, 1),
            What::Sample,
            action(0, 0),
            What::Sample,
            action(0, 0),
            action(0, 1),
            // 0.1 · 3 rounds to more than 0.3; the sample comes first all the same.
            What::Sample,
            What::Stage(1),
            action(1, 0),
            What::Sample,
            action(1, 0),
            What::Sample,
        ];
        assert_eq!(names, expected);
        assert_eq!(found[11].0, 0.3 + 0.15);
    }

    #[test]
    fn a_longer_run_begins_with_the_steps_of_a_shorter_one() {
        let text = |until: f64| {
            format!(
                "run.sample_interval = 0.3\nrun.check_interval = 0.7\n[[stage]]\nuntil = 1.1\n[[stage]]\n\
                 until = {until}\nthermostat = [{{ tag = \"a\", every = 0.07, energy = 1 }}]"
            )
        };
        let (short, long) = (steps(&text(3.05)), steps(&text(6.0)));
        // The last steps of the shorter run are those at its end.
        let shared = short.iter().take_while(|step| step.0 < 3.05).count();
        assert_eq!(short[..shared], long[..shared]);
        assert_eq!(short.len() - shared, 2);
    }
}
