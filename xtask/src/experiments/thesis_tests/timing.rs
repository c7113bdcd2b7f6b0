//! One simulation against the clock, stretch by stretch, in processor time of its thread.

use anyhow::Result;
use carom::{Detection, EnergyLedger, Impact, Observer as _, OverlapCheck, Scene, Scheduler, Simulation};
use carom_runs::{interruption::Signals, say};
use carom_tables::Totals;
use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize};

/// How long the thesis lets its scenes run (time).
pub const THESIS_TIME: f64 = 100.0;

/// So many stretches are joined two by two, and those that follow are twice as long. Fewer: a coarser error. More: bringing
/// all bodies to one time at the end of each counts.
const MOST_STRETCHES: usize = 64;

/// The first stretch, as a share of the thesis's time: no detector is so slow that this is too much.
const FIRST_STRETCH: f64 = 1e-6;

/// A case of which the thesis's time is over goes on until its times are known to this share, if its budget allows.
const GOOD_ENOUGH: f64 = 0.01;

/// With fewer stretches their scatter gives no error that could be trusted.
const LEAST_STRETCHES: usize = 8;

/// With fewer collisions, what is rare and costs much may be missing: time for the thesis's time is not reckoned from them.
const LEAST_COLLISIONS: u64 = 10;

/// A value with its standard error.
pub type Measured = (f64, Option<f64>);

/// One case: how many of something, on which engine, and what it took.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Timing {
    /// Name of the engine or the detector.
    pub engine: String,
    /// How many discs, or atoms of each rod.
    pub size: usize,
    /// All that was done, without building the scene.
    pub whole: Stretch,
    /// Equally long stretches of it.
    pub stretches: Vec<Stretch>,
    /// Totals.
    pub totals: Totals,
}

/// A stretch of a run.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct Stretch {
    /// Simulated time.
    pub time: f64,
    /// Processor time (seconds).
    pub seconds: f64,
    /// Questions to the detector. Those inside the loop over small discs of [`carom::CellScheduler`] are not counted.
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

impl Timing {
    /// Processor time for as long as the thesis lets it run (seconds); `None` if that cannot be told from what was done.
    pub fn for_thesis_time(&self) -> Option<Measured> {
        let is_known = self.is_whole() || self.totals.collisions >= LEAST_COLLISIONS;
        let (value, error) = self.per(|stretch| stretch.time).filter(|_| is_known)?;
        Some((value * THESIS_TIME, error.map(|error| error * THESIS_TIME)))
    }

    /// Processor time of one collision (seconds); `None` if there was none.
    pub fn per_collision(&self) -> Option<Measured> {
        self.per(|stretch| stretch.collisions as f64)
    }

    /// Processor time of one query (seconds), with all that goes with it; `None` if there was none.
    pub fn per_query(&self) -> Option<Measured> {
        self.per(|stretch| stretch.queries as f64)
    }

    /// Whether it came to the end of the thesis's time.
    pub fn is_whole(&self) -> bool {
        self.totals.simulated_time >= THESIS_TIME
    }

    /// Processor time for each of something: the ratio of sums, with its error from the scatter of equally long stretches,
    /// Σ (sᵢ − r nᵢ)² / (k (k − 1)) of k stretches over the square of the mean of n. Not their median: a contact costs much
    /// more than what is passed over, and where contacts are rare a median would leave them out.
    fn per(&self, of: impl Fn(&Stretch) -> f64) -> Option<Measured> {
        let whole = of(&self.whole);
        if whole == 0.0 {
            return None;
        }
        let ratio = self.whole.seconds / whole;
        let count = self.stretches.len() as f64;
        let squares: f64 = self.stretches.iter().map(|s| (s.seconds - ratio * of(s)).powi(2)).sum();
        let mean = self.stretches.iter().map(of).sum::<f64>() / count;
        let error = (squares / (count * (count - 1.0))).sqrt() / mean;
        Some((ratio, (self.stretches.len() >= LEAST_STRETCHES && mean > 0.0).then_some(error)))
    }

    fn is_good_enough(&self) -> bool {
        let is_good = |of: Option<Measured>| {
            of.is_some_and(|(value, error)| error.is_some_and(|error| error < GOOD_ENOUGH * value))
        };
        is_good(self.for_thesis_time()) && is_good(self.per_query().or(self.per_collision()))
    }
}

/// Runs a scene to the end of the thesis's time and on until its times are known well enough, or for as long as `budget`
/// (seconds) lasts.
///
/// # Errors
/// A scene that cannot be built, a run that cannot go on, or the program has been asked to end.
pub fn time<D: Detection, S: Scheduler>(
    engine: &str,
    size: usize,
    scene: &Scene,
    (detection, scheduler): (D, S::Options),
    budget: f64,
    signals: &Signals,
) -> Result<Timing> {
    let mut simulation: Simulation<D, Impact, S> = Simulation::with(scene, detection, Impact, scheduler)?;
    let (mut energy, mut overlaps) = (EnergyLedger::default(), OverlapCheck::default());
    energy.sample(&simulation.view());
    let mut timing = Timing {
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
        if timing.stretches.len() == MOST_STRETCHES {
            timing.stretches = timing.stretches.chunks(2).map(Stretch::sum).collect();
            length *= 2.0;
        }
    }
    energy.sample(&simulation.view());
    overlaps.sample(&simulation.view());
    timing.totals = Totals {
        collisions_per_second: timing.totals.collisions as f64 / timing.whole.seconds.max(1e-9),
        energy_drift: energy.drift(),
        overlapping_pairs: overlaps.worst_pairs(),
        max_overlap: overlaps.deepest(),
        ..timing.totals
    };
    let Stretch { time, seconds, collisions, .. } = timing.whole;
    say(&format!(
        "{engine:<20} {size:>5}  {collisions:>9} collisions in {time:.4} time units, {seconds:.3} s"
    ));
    Ok(timing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_that_of_a_ratio() {
        let stretch = |seconds, queries| Stretch { time: 1.0, seconds, queries, collisions: 0 };
        let stretches: Vec<Stretch> =
            (0..8).map(|n| stretch(if n % 2 == 0 { 1.0 } else { 3.0 }, 4)).collect();
        let whole = Stretch { time: 8.0, ..stretch(16.0, 32) };
        let timing = Timing {
            engine: String::new(),
            size: 1,
            whole,
            stretches,
            totals: Totals { simulated_time: THESIS_TIME, ..Totals::default() },
        };
        // Eight values 1 or 3 about 2: √(8 / (8 · 7)), of a mean of 4 queries.
        let (value, error) = timing.per_query().unwrap();
        assert!(value == 0.5 && (error.unwrap() - (1.0f64 / 7.0).sqrt() / 4.0).abs() < 1e-15);
        assert_eq!(timing.for_thesis_time().unwrap().0, 200.0);
        assert_eq!(timing.per_collision(), None);
    }
}
