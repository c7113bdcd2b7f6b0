//! One simulation against the clock: as far as it comes, in processor time of its thread.

use anyhow::Result;
use carom::{Detection, EnergyLedger, Impact, Observer as _, OverlapCheck, Scene, Scheduler, Simulation};
use cpu_time::ThreadTime;

use crate::{say, summary::Totals};

/// How long the thesis lets its scenes run (time).
pub const THESIS_TIME: f64 = 100.0;

/// Between two looks at the clock (seconds of processor time), about.
const SHORTEST_BATCH: f64 = 1e-3;

/// One case: how many of something, on which engine, and what it took.
#[derive(Debug, Clone)]
pub struct Timing {
    /// Name of the engine or the detector.
    pub engine: &'static str,
    /// How many discs, or atoms of each rod.
    pub size: usize,
    /// Questions to the detector. Those inside the loop over small discs of [`carom::Cells`] are not counted.
    pub queries: u64,
    /// Processor time, without building the scene (seconds).
    pub seconds: f64,
    /// Totals.
    pub totals: Totals,
}

impl Timing {
    /// Processor time for as long as the thesis lets it run (seconds).
    pub fn for_thesis_time(&self) -> f64 {
        self.seconds * THESIS_TIME / self.totals.simulated_time
    }

    /// Processor time of one collision (seconds); `None` if there was none.
    pub fn per_collision(&self) -> Option<f64> {
        (self.totals.collisions > 0).then(|| self.seconds / self.totals.collisions as f64)
    }

    /// Processor time of one query (seconds), with all that goes with it; `None` if there was none.
    pub fn per_query(&self) -> Option<f64> {
        (self.queries > 0).then(|| self.seconds / self.queries as f64)
    }

    /// Whether it came to the end of the thesis's time.
    pub fn is_whole(&self) -> bool {
        self.totals.simulated_time >= THESIS_TIME
    }
}

/// Runs a scene to the end of the thesis's time, or for as long as `budget` (seconds) lasts.
///
/// # Errors
/// A scene that cannot be built, or a run that cannot go on.
pub fn time<D: Detection, S: Scheduler>(
    engine: &'static str,
    size: usize,
    scene: &Scene,
    (detection, scheduler): (D, S::Options),
    budget: f64,
) -> Result<Timing> {
    let mut simulation: Simulation<D, Impact, S> = Simulation::with(scene, detection, Impact, scheduler)?;
    let (mut energy, mut overlaps) = (EnergyLedger::default(), OverlapCheck::default());
    energy.standby(&simulation.view());
    let clock = ThreadTime::now();
    let (mut seconds, mut batch) = (0.0, 1u32);
    let mut ended = false;
    while !ended && seconds < budget {
        for _ in 0..batch {
            ended = !simulation.step(THESIS_TIME, &mut ())?;
            if ended {
                break;
            }
        }
        let before = seconds;
        seconds = clock.elapsed().as_secs_f64();
        // Looking at the clock must cost nothing beside the contacts, and what is slow must not overstep its time.
        if seconds - before < SHORTEST_BATCH {
            batch = batch.saturating_mul(2);
        }
    }
    let until = simulation.time().to_f64();
    energy.standby(&simulation.view());
    overlaps.standby(&simulation.view());
    let counters = *simulation.view().counters();
    let timing = Timing {
        engine,
        size,
        queries: counters.scheduler.pairs,
        seconds,
        totals: Totals {
            collisions: counters.collisions,
            simulated_time: until,
            collisions_per_second: counters.collisions as f64 / seconds.max(1e-9),
            energy_drift: energy.drift(),
            overlapping_pairs: overlaps.worst_pairs(),
            max_overlap: overlaps.deepest(),
        },
    };
    say(&format!(
        "{engine:<20} {size:>5}  {:>9} collisions in {until:.4} time units, {seconds:.3} s",
        counters.collisions
    ));
    Ok(timing)
}
