//! Ten lines about a run before it starts: mean free time and path, collisions of each body,
//! whether samples and the start of the measurement are sensible, and the cost.

use carom::{Scene, View, engine::MeasureFrom};
use carom_tables::with_error;
use serde::Serialize;

use crate::{
    measures::{self, COLLISIONS_TO_FORGET, FREE_TIMES_FOR_TRANSPORT},
    schedule::stages,
};

use super::{
    aligned::{bytes, duration, short, table},
    contents::CheckedContents,
    trial::TrialEstimate,
};
/// Samples that are farther apart than this many mean free times miss what happens between
/// collisions; that only matters for correlations in time.
const MAX_FREE_TIMES_APART: f64 = 100.0;

/// The rate of collisions changes during a run if that of the start differs by more than this
/// share.
/// Smaller: the scatter of the first contacts counts as a change. Larger: a gas that cools is
/// described by its mean.
const CHANGES: f64 = 0.25;

/// The row of the transport coefficients, after that of the measurement.
const TRANSPORT_ROW: usize = 5;

/// The answers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Answers {
    /// Mean time between two collisions of a body that moves (time); `None` if it is not known.
    mean_free_time: Option<f64>,
    /// Mean path between two collisions of a body that moves (length).
    mean_free_path: Option<f64>,
    /// Whether both are those of the start, from which the run departs.
    is_of_start: bool,
    /// Whether the numbers of collisions are those of a trial of the start, while the run drives
    /// the bodies or takes their energy, so that their rate changes.
    is_extrapolated: bool,
    /// Collisions of each body that moves until the end of the run.
    collisions_per_body: Option<f64>,
    /// Interval of samples in mean free times, and in words whether it is sensible.
    sample_interval_in_free_times: Option<f64>,
    sampling: String,
    /// The start of the measurement, and in words whether it is sensible.
    measured: String,
    /// In words whether the measurement is long enough for the viscosity and the heat
    /// conductivity, if they are asked for.
    transport: Option<String>,
    /// Relative error of a mean over all collisions, at least.
    least_relative_error: Option<f64>,
}

impl Answers {
    /// `speed` is the mean speed of the bodies that move (length / time).
    pub(super) fn new(
        scene: &Scene,
        contents: &CheckedContents,
        estimate: &TrialEstimate,
        speed: Option<f64>,
    ) -> Self {
        let run = &scene.run;
        let collisions = estimate.collisions.filter(|number| *number >= 1.0);
        let of_moving = estimate
            .collisions_of_moving
            .filter(|_| collisions.is_some());
        let per_body = of_moving.map(|number| number / contents.moving.max(1) as f64);
        let mean = per_body.map(|number| run.until / number);
        let early = estimate
            .early_rate_of_moving
            .map(|rate| contents.moving as f64 / rate);
        // Of a gas that cools, or is heated, the mean over the run is that of no state.
        let changes = |(early, mean): (f64, f64)| (early / mean - 1.0).abs() > CHANGES;
        let is_early = !stages::is_equilibrium(scene) && early.zip(mean).is_some_and(changes);
        let free_time = if is_early { early } else { mean };
        let interval = free_time.map(|time| run.sample_interval / time);
        let from = stages::window(scene).0;
        let measured_collisions =
            collisions.map(|number| number * (1.0 - from / run.until).clamp(0.0, 1.0));
        Self {
            mean_free_time: free_time,
            mean_free_path: free_time.zip(speed).map(|(time, speed)| time * speed),
            is_of_start: is_early,
            is_extrapolated: collisions.is_some() && !stages::is_equilibrium(scene),
            collisions_per_body: per_body,
            sample_interval_in_free_times: interval,
            sampling: sampling(interval),
            measured: measured(run.measure_from, scene, per_body, from),
            transport: free_time.and_then(|time| transport(scene, (run.until - from) / time)),
            least_relative_error: measured_collisions
                .filter(|number| *number >= 1.0)
                .map(|number| 1.0 / number.sqrt()),
        }
    }

    /// The lines for a terminal, without the head.
    pub(super) fn lines(
        &self,
        contents: &CheckedContents,
        estimate: &TrialEstimate,
        method: &str,
        tiles: &str,
    ) -> String {
        let row = |name: &str, words: String| [name.to_owned(), words];
        let mut rows = vec![
            row("system", contents.sentence()),
            row("run", self.run(contents, estimate)),
            row("flights", self.flights()),
            row(
                "samples",
                format!("{}, {}", contents.samples, self.sampling),
            ),
            row("measured", self.measured.clone()),
            row("error", self.least_error()),
            row("time", time(estimate)),
            row("memory", memory(estimate)),
            row("method", format!("{method}; tiles {tiles}")),
        ];
        if let Some(words) = &self.transport {
            rows.insert(TRANSPORT_ROW, row("transport", words.clone()));
        }
        table(rows)
    }

    /// The length of the run in words.
    fn run(&self, contents: &CheckedContents, estimate: &TrialEstimate) -> String {
        format!(
            "to t = {}: {} collisions, {} of each body{}",
            contents.until,
            known(estimate.collisions),
            known(self.collisions_per_body),
            if self.is_extrapolated {
                "; extrapolated from a trial of the start, and the run is driven or loses energy"
            } else {
                ""
            }
        )
    }

    /// The mean flight in words.
    fn flights(&self) -> String {
        format!(
            "mean free time {}, mean free path {}{}",
            known(self.mean_free_time),
            known(self.mean_free_path),
            if self.is_of_start {
                ", at the start"
            } else {
                ""
            }
        )
    }

    /// The least relative error in words.
    fn least_error(&self) -> String {
        self.least_relative_error.map_or_else(
            || "unknown".to_owned(),
            |share| {
                let percent = with_error(100.0 * share, Some(0.1 * 100.0 * share));
                let percent = percent.split(' ').next().unwrap_or_default().to_owned();
                format!("at least {percent} % for a mean over all collisions, 1/√number")
            },
        )
    }
}

/// A number, if it is known.
fn known(number: Option<f64>) -> String {
    number.map_or_else(|| "unknown".to_owned(), short)
}

/// The processor time of the run, in words.
fn time(estimate: &TrialEstimate) -> String {
    let Some(seconds) = estimate.seconds else {
        return "unknown: the trial made no progress in time".to_owned();
    };
    let of_samples = if estimate.sample_seconds > 0.1 * seconds {
        format!(", {} of it for samples", duration(estimate.sample_seconds))
    } else {
        String::new()
    };
    format!(
        "about {} of processor time at {} collisions a second{of_samples}",
        duration(seconds),
        short(estimate.collisions_per_second)
    )
}

/// The memory of the run and the size of a checkpoint, in words.
fn memory(estimate: &TrialEstimate) -> String {
    let series = estimate.series;
    let more = if series > 0 {
        format!(", {} more for samples", bytes(series))
    } else {
        String::new()
    };
    format!(
        "{}, checkpoint {}{more}",
        bytes(estimate.memory),
        bytes(estimate.checkpoint)
    )
}

/// Whether the interval of samples is sensible, in mean free times.
fn sampling(interval: Option<f64>) -> String {
    let Some(interval) = interval else {
        return "the mean free time is unknown".to_owned();
    };
    let words = match interval {
        _ if interval < 1.0 => {
            ": correlated with their neighbours, which correlations in time need"
        }
        _ if interval > MAX_FREE_TIMES_APART => ": too coarse for correlations in time",
        _ => "",
    };
    format!("one in {} mean free times{words}", short(interval))
}

/// Whether the start of the measurement is sensible.
fn measured(measure_from: MeasureFrom, scene: &Scene, per_body: Option<f64>, from: f64) -> String {
    if measure_from == MeasureFrom::Auto {
        return "from the time at which no mean changes any more".to_owned();
    }
    if !from.is_finite() {
        return "not at all: no stage is measured".to_owned();
    }
    let before = per_body.map(|number| number * from / scene.run.until);
    let words = match before {
        None => String::new(),
        Some(before)
            if before < COLLISIONS_TO_FORGET
                && scene.start.from.is_none()
                && !scene.elasticity.loses_energy() =>
        {
            let remedy = if scene.stage.is_empty() {
                "measure_from = \"auto\""
            } else {
                "a first stage with measure = false"
            };
            format!(
                ", after {} collisions of each body: means may hold the approach to equilibrium; {remedy} leaves it out",
                short(before)
            )
        }
        Some(before) => format!(", after {} collisions of each body", short(before)),
    };
    format!("from t = {} on{words}", short(from))
}

/// Whether a measurement of this length (mean free times) is long enough for the coefficients that
/// need long lags; `None` if the scene asks for none.
fn transport(scene: &Scene, measured: f64) -> Option<String> {
    let requests = measures::requests(scene).ok()?;
    let names = requests.iter().map(|request| request.kind.name);
    let names: Vec<&str> = names.filter(|name| measures::is_transport(name)).collect();
    let least = FREE_TIMES_FOR_TRANSPORT;
    let words = if measured >= least {
        "long enough for an error"
    } else {
        "too short for an error"
    };
    (!names.is_empty()).then(|| {
        format!(
            "{}: {} mean free times are measured, {words} (from {} on)",
            names.join(", "),
            short(measured.max(0.0)),
            short(least)
        )
    })
}

/// Mean speed of the bodies that move (length / time); `None` if nothing moves.
pub(super) fn mean_speed(view: &View<'_>) -> Option<f64> {
    let speeds = view
        .bodies()
        .filter(|body| body.body.is_free())
        .map(|body| body.motion.velocity.length());
    let (sum, count) = speeds.fold((0.0, 0.0), |(sum, count), speed| (sum + speed, count + 1.0));
    (sum > 0.0).then(|| sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measurement_may_be_too_short_for_transport_coefficients() {
        let text = "[run]\nuntil = 10.0\nobserve = [\"pressure\", \"viscosity\"]\n";
        let scene = Scene::from_toml(text).unwrap();
        let words = |measured| transport(&scene, measured).unwrap();
        assert!(words(100.0).starts_with("viscosity: 100 mean free times are measured, too short"));
        assert!(words(400.0).contains("long enough"));
        let without = Scene::from_toml("[run]\nobserve = [\"pressure\"]\n").unwrap();
        assert_eq!(transport(&without, 100.0), None);
    }

    #[test]
    fn intervals_and_starts_are_judged() {
        assert!(sampling(Some(0.2)).contains("one in 0.2 mean free times: correlated"));
        assert_eq!(sampling(Some(5.0)), "one in 5 mean free times");
        assert!(sampling(Some(1e4)).contains("too coarse"));
        let scene = Scene::from_toml("[run]\nuntil = 10.0\n").unwrap();
        let of = |from: f64, per_body: f64| measured(from.into(), &scene, Some(per_body), from);
        assert!(of(0.0, 1000.0).contains("measure_from = \"auto\""));
        // A run in stages has no `measure_from`.
        let text = "[[stage]]\nuntil = 4.0\n[[stage]]\nuntil = 10.0\n";
        let staged = measured(
            0.0.into(),
            &Scene::from_toml(text).unwrap(),
            Some(10.0),
            0.0,
        );
        assert!(
            staged.contains("a first stage with measure = false") && !staged.contains("auto"),
            "{staged}"
        );
        assert_eq!(
            of(5.0, 1000.0),
            "from t = 5 on, after 500 collisions of each body"
        );
        assert!(
            measured(MeasureFrom::Auto, &scene, None, 0.0).contains("no mean changes any more")
        );
        assert!(measured(0.0.into(), &scene, None, f64::INFINITY).contains("no stage is measured"));
    }
}
