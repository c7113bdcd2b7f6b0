//! The order of all that happens in a run at given times: samples, snapshots, checks, starts of
//! stages, and actions of thermostats.
//!
//! Each time is a product, start + k · interval, not a sum of intervals. Steps whose times differ
//! only by rounding happen at one instant: first the sample, then snapshot and check, then a stage
//! starts, then thermostats act in the order of their list.
//!
//! Order and times of the steps that change the system in a stage depend on that stage alone, not
//! on what is observed. So a run whose stages are written while it continues makes the same steps
//! as the run of the scene it has written.

pub mod pieces;
pub(crate) mod stage_edits;
pub(crate) mod stages;

use std::vec;

use carom::{
    engine::{RunSpec, Scene, StageSpec},
    geometry::MAX_MAGNITUDE,
};

use crate::sampling_times::{sampling_count, sampling_time};

/// Times that differ by less than this share of the shortest interval of samples, snapshots, checks
/// and thermostats of a stage are one instant: they differ by rounding. Larger: steps that a scene
/// sets apart could change places.
const ROUNDING: f64 = 1e-9;

/// One step of a run at a given time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScheduledStep {
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
    /// Samples, snapshots and checks, in their order at one instant.
    observations: Vec<Series>,
    /// Shortest interval of observations (time).
    shortest: f64,
    /// The stage whose changes come next.
    stage: Changes,
    /// The stages after it.
    later: vec::IntoIter<Changes>,
}

/// The steps of a stage that change the system.
#[derive(Debug, Clone)]
struct Changes {
    /// In their order at one instant.
    series: Vec<Series>,
    /// Shortest interval of thermostats (time).
    shortest: f64,
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
        Self {
            what,
            begin: 0.0,
            end: until,
            interval,
            next: 1,
            count,
        }
    }

    /// Actions from `begin` on, before `end`.
    fn actions(what: What, begin: f64, end: f64, interval: f64) -> Self {
        Self {
            what,
            begin,
            end,
            interval,
            next: 0,
            count: actions((begin, end), interval),
        }
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

    /// Takes the next step, which it has.
    fn step(&mut self) -> Option<ScheduledStep> {
        let time = self.time()?;
        self.next += 1;
        Some(ScheduledStep {
            time,
            what: self.what,
        })
    }
}

impl Changes {
    fn new(stage: usize, spec: &StageSpec, (start, end): (f64, f64)) -> Self {
        // One action, at the start; the first stage has begun.
        let begin =
            (stage > 0).then(|| Series::actions(What::Stage(stage), start, end, end - start));
        let thermostats = spec
            .thermostat
            .iter()
            .enumerate()
            .map(|(index, thermostat)| {
                Series::actions(
                    What::Thermostat { stage, index },
                    start,
                    end,
                    thermostat.every,
                )
            });
        let shortest = spec
            .thermostat
            .iter()
            .map(|thermostat| thermostat.every)
            .fold(MAX_MAGNITUDE, f64::min);
        Self {
            series: begin.into_iter().chain(thermostats).collect(),
            shortest,
        }
    }
}

/// The earliest time of these series.
fn earliest(series: &[Series]) -> Option<f64> {
    series.iter().filter_map(Series::time).reduce(f64::min)
}

/// The first of these series with a step no later than `limit`.
fn first_until(series: &mut [Series], limit: f64) -> Option<&mut Series> {
    series
        .iter_mut()
        .find(|series| series.time().is_some_and(|time| time <= limit))
}

/// Start and end of each stage (time); a run without stages has none.
pub fn spans(stages: &[StageSpec]) -> impl Iterator<Item = (f64, f64)> {
    let starts = std::iter::once(0.0).chain(stages.iter().map(|stage| stage.until));
    starts.zip(stages.iter().map(|stage| stage.until))
}

/// Number of actions of a thermostat in a stage of this span: the first is at its start, however
/// short the stage is.
pub fn actions((start, end): (f64, f64), every: f64) -> u64 {
    sampling_count(start, end, every).max(u64::from(end > start))
}

impl Schedule {
    /// The steps of a scene whose times are valid.
    pub fn new(scene: &Scene) -> Self {
        let RunSpec {
            until,
            sample_interval,
            snapshot_interval,
            check_interval,
            ..
        } = scene.run;
        let apart = [
            (What::Snapshot, snapshot_interval),
            (What::Check, check_interval),
        ];
        let apart = apart
            .into_iter()
            .filter_map(|(what, interval)| Some((what, interval?)));
        let intervals = std::iter::once((What::Sample, sample_interval)).chain(apart);
        let observations: Vec<Series> = intervals
            .map(|(what, interval)| Series::samples(what, until, interval))
            .collect();
        let shortest = observations
            .iter()
            .map(|series| series.interval)
            .fold(MAX_MAGNITUDE, f64::min);
        Self {
            observations,
            shortest,
            ..Self::changes(scene, 0)
        }
    }

    /// The steps that change the system, from the start of a stage on.
    pub fn changes(scene: &Scene, from: usize) -> Self {
        let stages = scene
            .stage
            .iter()
            .zip(spans(&scene.stage))
            .enumerate()
            .skip(from);
        let later: Vec<Changes> = stages
            .map(|(stage, (spec, span))| Changes::new(stage, spec, span))
            .collect();
        Self {
            observations: Vec::new(),
            shortest: MAX_MAGNITUDE,
            stage: Changes {
                series: Vec::new(),
                shortest: MAX_MAGNITUDE,
            },
            later: later.into_iter(),
        }
    }

    /// The time of the next change: that of the present stage, or the start of a later one.
    fn next_change(&mut self) -> Option<f64> {
        loop {
            if let Some(time) = earliest(&self.stage.series) {
                return Some(time);
            }
            self.stage = self.later.next()?;
        }
    }
}

impl Iterator for Schedule {
    type Item = ScheduledStep;

    fn next(&mut self) -> Option<ScheduledStep> {
        let change = self.next_change();
        if let Some(observation) = earliest(&self.observations) {
            let same = ROUNDING * self.shortest.min(self.stage.shortest);
            if change.is_none_or(|change| observation <= change + same) {
                let step = first_until(&mut self.observations, observation + same)?.step()?;
                // Not after the change by rounding: observations must not delay it.
                let time = change.map_or(step.time, |change| step.time.min(change));
                return Some(ScheduledStep { time, ..step });
            }
        }
        let same = ROUNDING * self.stage.shortest;
        first_until(&mut self.stage.series, change? + same)?.step()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(text: &str) -> Vec<(f64, What)> {
        let scene = Scene::from_toml(text).unwrap();
        Schedule::new(&scene)
            .map(|step| (step.time, step.what))
            .collect()
    }

    #[test]
    fn a_run_without_stages_has_samples_only() {
        let expected = [0.4, 0.8, 1.0].map(|time| (time, What::Sample));
        assert_eq!(
            steps("run.until = 1.0\nrun.sample_interval = 0.4"),
            expected
        );
    }

    #[test]
    fn without_stages_a_sample_comes_before_the_snapshot_of_its_instant() {
        let found =
            steps("run.until = 0.4\nrun.sample_interval = 0.1\nrun.snapshot_interval = 0.3");
        let names: Vec<What> = found.iter().map(|step| step.1).collect();
        // 3 · 0.1 rounds to more than 0.3.
        let expected = [
            What::Sample,
            What::Sample,
            What::Sample,
            What::Snapshot,
            What::Sample,
            What::Snapshot,
        ];
        assert_eq!(names, expected);
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
    fn a_short_stage_does_not_change_the_order_in_others() {
        // 3 · 0.1 rounds to more than 0.3.
        let stages = |first: f64| {
            let hold = "thermostat = [{ tag = \"a\", every = 0.1, energy = 1 }, \
                 { tag = \"b\", every = 0.3, energy = 1 }]";
            format!(
                "[[stage]]\nuntil = {first:?}\n{hold}\n[[stage]]\nuntil = {:?}\n[[stage]]\nuntil = 2",
                { first.next_up() }
            )
        };
        let scene = Scene::from_toml(&stages(0.7)).unwrap();
        let first = Schedule::changes(&scene, 0).take_while(|step| step.what != What::Stage(1));
        let indices = first.map(|step| match step.what {
            What::Thermostat { index, .. } => index,
            other => panic!("{other:?} in the first stage"),
        });
        assert_eq!(indices.collect::<Vec<_>>(), [0, 1, 0, 0, 0, 1, 0, 0, 0, 1]);
        let later: Vec<What> = Schedule::changes(&scene, 1).map(|step| step.what).collect();
        assert_eq!(later, [What::Stage(1), What::Stage(2)]);
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
