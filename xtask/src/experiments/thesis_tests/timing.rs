//! Timing of one simulation in intervals, in processor time of its thread.

use anyhow::Result;
use carom::Scene;
use carom_methods::{AnySimulation, Method};
use carom_runs::{interruption::Signals, print_line, run_totals::RunTotals};
use carom_tables::{Estimate, Totals};
use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize};

/// Duration of the runs in the thesis (time).
pub const THESIS_TIME: f64 = 100.0;

/// Above this number, intervals are joined in pairs and later ones are twice as long. Fewer: a less
/// precise error. More: synchronising all bodies at the end of each interval affects the time.
const MAX_STRETCHES: usize = 64;

/// First interval as a share of the thesis's duration; short enough for every detector.
const FIRST_STRETCH: f64 = 1e-6;

/// A case that has reached the thesis's duration continues until its times are known to this
/// relative error, if its time limit allows.
const GOOD_ENOUGH: f64 = 0.01;

/// With fewer intervals their scatter gives no reliable error.
const MIN_STRETCHES: usize = 8;

/// With fewer collisions, rare and expensive events may be missing, so the time for the thesis's
/// duration is not extrapolated.
const MIN_COLLISIONS: u64 = 10;

/// A value with its standard error.
pub type MeasuredTime = (f64, Option<f64>);

/// One case: size, engine, and time spent.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ThesisTiming {
    /// Name of the engine or the detector.
    pub engine: String,
    /// Number of discs, or of atoms of each rod.
    pub size: usize,
    /// The whole run, without the construction of the scene.
    pub whole: Stretch,
    /// Equally long intervals of it.
    pub stretches: Vec<Stretch>,
    /// Totals.
    pub totals: Totals,
}

/// An interval of a run.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct Stretch {
    /// Simulated time.
    pub time: f64,
    /// Processor time (seconds).
    pub seconds: f64,
    /// Queries to the detector. Those inside the loop over small discs of [`carom::CellScheduler`]
    /// are not counted.
    pub queries: u64,
    /// Contacts.
    pub collisions: u64,
}

impl Stretch {
    fn sum(stretches: &[Self]) -> Self {
        stretches.iter().fold(Self::default(), |sum, next| Self {
            time: sum.time + next.time,
            seconds: sum.seconds + next.seconds,
            queries: sum.queries + next.queries,
            collisions: sum.collisions + next.collisions,
        })
    }
}

impl ThesisTiming {
    /// Processor time for the thesis's duration (seconds); `None` if it cannot be extrapolated.
    pub fn for_thesis_time(&self) -> Option<MeasuredTime> {
        let is_known = self.is_whole() || self.totals.collisions >= MIN_COLLISIONS;
        let (value, error) = self.per(|stretch| stretch.time).filter(|_| is_known)?;
        Some((value * THESIS_TIME, error.map(|error| error * THESIS_TIME)))
    }

    /// Processor time for each collision (seconds); `None` if there was none.
    pub fn per_collision(&self) -> Option<MeasuredTime> {
        self.per(|stretch| stretch.collisions as f64)
    }

    /// Processor time for each query (seconds), including all other work; `None` if there was none.
    pub fn per_query(&self) -> Option<MeasuredTime> {
        self.per(|stretch| stretch.queries as f64)
    }

    /// Returns true if the run reached the thesis's duration.
    pub fn is_whole(&self) -> bool {
        self.totals.simulated_time >= THESIS_TIME
    }

    /// Processor time for each unit of `of`, with its error from the scatter of the intervals. It
    /// is not the median: contacts are expensive, and where they are rare a median would omit them.
    fn per(&self, of: impl Fn(&Stretch) -> f64) -> Option<MeasuredTime> {
        let whole = of(&self.whole);
        if whole == 0.0 {
            return None;
        }
        let estimate = Estimate::of_ratio(self.stretches.iter().map(|s| (s.seconds, of(s))));
        let error = estimate.filter(|_| self.stretches.len() >= MIN_STRETCHES);
        Some((
            self.whole.seconds / whole,
            error.map(|estimate| estimate.standard_error),
        ))
    }

    fn is_good_enough(&self) -> bool {
        let is_good = |of: Option<MeasuredTime>| {
            of.is_some_and(|(value, error)| error.is_some_and(|error| error < GOOD_ENOUGH * value))
        };
        is_good(self.for_thesis_time()) && is_good(self.per_query().or(self.per_collision()))
    }
}

/// Runs a scene to the thesis's duration and on until its times are known well enough, for at most
/// `budget` (seconds).
///
/// # Errors
/// The scene cannot be built, the run fails, or a signal has been received.
pub fn time(
    engine: &str,
    size: usize,
    scene: &Scene,
    method: &Method,
    budget: f64,
    signals: &Signals,
) -> Result<ThesisTiming> {
    let mut simulation = AnySimulation::with(scene, method)?;
    let mut totals = RunTotals::new(&simulation.view());
    let mut timing = ThesisTiming {
        engine: engine.to_owned(),
        size,
        whole: Stretch::default(),
        stretches: Vec::new(),
        totals: Totals::default(),
    };
    let mut length = FIRST_STRETCH * THESIS_TIME;
    while timing.whole.seconds < budget && !(timing.is_whole() && timing.is_good_enough()) {
        signals.check()?;
        let before = timing.whole;
        let clock = ThreadTime::now();
        simulation.run_until(before.time + length)?;
        let seconds = clock.elapsed().as_secs_f64();
        let counters = *simulation.view().counters();
        timing.whole = Stretch {
            time: before.time + length,
            seconds: before.seconds + seconds,
            queries: counters.scheduler.pairs,
            collisions: counters.collisions,
        };
        timing.totals.simulated_time = timing.whole.time;
        timing.totals.collisions = timing.whole.collisions;
        timing.stretches.push(Stretch {
            time: length,
            seconds,
            queries: timing.whole.queries - before.queries,
            collisions: timing.whole.collisions - before.collisions,
        });
        if timing.stretches.len() == MAX_STRETCHES {
            timing.stretches = timing.stretches.chunks(2).map(Stretch::sum).collect();
            length *= 2.0;
        }
    }
    totals.sample(&simulation.view());
    timing.totals = totals.totals(&simulation.view(), timing.whole.seconds);
    let Stretch {
        time,
        seconds,
        collisions,
        ..
    } = timing.whole;
    print_line(&format!(
        "{engine:<20} {size:>5}  {collisions:>9} collisions in {time:.4} time units, {seconds:.3} s"
    ));
    Ok(timing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_that_of_a_ratio() {
        let stretch = |seconds, queries| Stretch {
            time: 1.0,
            seconds,
            queries,
            collisions: 0,
        };
        let stretches: Vec<Stretch> = (0..8)
            .map(|n| stretch(if n % 2 == 0 { 1.0 } else { 3.0 }, 4))
            .collect();
        let whole = Stretch {
            time: 8.0,
            ..stretch(16.0, 32)
        };
        let timing = ThesisTiming {
            engine: String::new(),
            size: 1,
            whole,
            stretches,
            totals: Totals {
                simulated_time: THESIS_TIME,
                ..Totals::default()
            },
        };
        // Eight values 1 or 3 about a mean of 2: √(8 / (8 · 7)), for a mean of 4 queries.
        let (value, error) = timing.per_query().unwrap();
        assert!(value == 0.5 && (error.unwrap() - (1.0f64 / 7.0).sqrt() / 4.0).abs() < 1e-15);
        assert_eq!(timing.for_thesis_time().unwrap().0, 200.0);
        assert_eq!(timing.per_collision(), None);
    }
}
