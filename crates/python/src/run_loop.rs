//! The run of a simulation with its measures, in pieces short enough for Ctrl-C and progress.

use std::time::{Duration, Instant};

use carom::{CollisionReport, EpochTime, Observer, RunError, Scene, View, engine::Body};
use carom_methods::AnySimulation;
use carom_runs::{measures::Tracked, schedule::pieces::Pieces};

use crate::collisions::Rows;

/// Wall time of a piece, and its growth for each body: a piece copies all motions once, which must
/// stay below a hundredth of it.
const PIECE: Duration = Duration::from_millis(100);
const PIECE_OF_BODY: Duration = Duration::from_micros(2);

/// All that observes a run.
#[derive(Default)]
pub struct Watching {
    /// The measures, in the order of the calls that added them.
    pub measures: Vec<Tracked>,
    /// Collisions for Python.
    pub rows: Rows,
}

impl Observer for Watching {
    fn watches_any(&self) -> bool {
        self.rows.watches_any() || self.active().any(|tracked| tracked.measure.watches_any())
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.rows.watches(bodies) || self.active().any(|tracked| tracked.measure.watches(bodies))
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        for tracked in self.measures.iter_mut().filter(|tracked| tracked.is_active) {
            tracked.measure.collision(report);
        }
        if self.rows.watches_any() {
            self.rows.collision(report);
        }
    }
}

impl Watching {
    fn active(&self) -> impl Iterator<Item = &Tracked> {
        self.measures.iter().filter(|tracked| tracked.is_active)
    }

    /// Takes the samples that are due at `time`.
    fn sample(&mut self, time: EpochTime, view: &View<'_>) {
        for tracked in self
            .measures
            .iter_mut()
            .filter(|tracked| tracked.is_due(time))
        {
            tracked.sample(view);
        }
    }
}

/// A simulation and what observes it.
pub struct State {
    /// The simulation.
    pub simulation: AnySimulation,
    /// Its scene, with the elasticity in force.
    pub scene: Scene,
    /// Measures and collisions.
    pub watching: Watching,
    /// `None` before the first piece, and after an edit.
    pieces: Option<Pieces>,
}

/// Where a piece of a run has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// At the end of the run.
    AtEnd,
    /// After a collision that was requested.
    AtCollision,
    /// Earlier: the run continues.
    Early,
}

impl State {
    /// A state without measures.
    pub fn new(simulation: AnySimulation, scene: Scene) -> Self {
        Self {
            simulation,
            scene,
            watching: Watching::default(),
            pieces: None,
        }
    }

    /// The time of the next sample, but not after `until`.
    fn target(&self, until: EpochTime) -> EpochTime {
        let times = self.watching.active().map(Tracked::time);
        times.fold(
            until,
            |earliest, time| if time < earliest { time } else { earliest },
        )
    }

    /// The pieces that this state of the run allows.
    fn pieces(&mut self) -> &mut Pieces {
        self.pieces.get_or_insert_with(|| {
            let view = self.simulation.view();
            Pieces::new(&view, PIECE + PIECE_OF_BODY * view.len() as u32)
        })
    }

    /// The end of the next piece, and whether the next sample or `until` is there.
    fn next_end(&mut self, until: EpochTime) -> (EpochTime, bool) {
        let (now, target) = (self.simulation.time(), self.target(until));
        let end = self.pieces().end(now, target);
        (end, end == target)
    }

    /// Learns from the duration of a piece, and takes the samples that are due at its end; returns
    /// `is_whole`.
    fn end_piece(&mut self, (end, is_whole): (EpochTime, bool), wall: Duration) -> bool {
        self.pieces().has_taken(wall);
        if is_whole {
            self.watching.sample(end, &self.simulation.view());
        }
        is_whole
    }

    /// Runs towards `until` for a short wall time.
    ///
    /// # Errors
    /// The run cannot continue.
    pub fn run_piece(&mut self, until: EpochTime) -> Result<Ended, RunError> {
        let limit = PIECE + PIECE_OF_BODY * self.simulation.view().len() as u32;
        let begun = Instant::now();
        while begun.elapsed() < limit {
            let (end, is_whole) = self.next_end(until);
            let before = begun.elapsed();
            self.simulation
                .observe_until_epoch_time(end, &mut self.watching)?;
            let wall = begun.elapsed() - before;
            if self.end_piece((end, is_whole), wall) && end >= until {
                return Ok(Ended::AtEnd);
            }
        }
        Ok(Ended::Early)
    }

    /// Runs towards `until` to the next collision that `rows` keeps, for a short wall time.
    ///
    /// # Errors
    /// The run cannot continue.
    pub fn step_piece(&mut self, until: EpochTime) -> Result<Ended, RunError> {
        let begun = Instant::now();
        while begun.elapsed() < PIECE {
            let (end, is_whole) = self.next_end(until);
            let (before, kept) = (begun.elapsed(), self.watching.rows.len());
            let has_hit = self.simulation.step(end.to_f64(), &mut self.watching)?;
            if self.watching.rows.len() > kept {
                return Ok(Ended::AtCollision);
            }
            let wall = begun.elapsed() - before;
            if !has_hit && self.end_piece((end, is_whole), wall) && end >= until {
                return Ok(Ended::AtEnd);
            }
        }
        Ok(Ended::Early)
    }

    /// Ends the present part of the intervals of all measures, before an edit.
    pub fn pause(&mut self) {
        let view = self.simulation.view();
        for tracked in &mut self.watching.measures {
            tracked.measure.pause(&view);
        }
    }

    /// Continues all measures after an edit.
    pub fn edited(&mut self) {
        let view = self.simulation.view();
        for tracked in &mut self.watching.measures {
            tracked.measure.start(&view);
            tracked.is_disturbed = true;
        }
        self.pieces = None;
    }
}
