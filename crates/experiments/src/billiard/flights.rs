//! Flights of independent discs: hits are counted by direction and by atom and summed in a fixed
//! order.

use anyhow::{Context, Result};
use carom::{DirectionHistogram, Observer as _, engine::Body, observers::Additive as _};
use carom_methods::AnySimulation;
use carom_runs::{progress::Progress, run_totals::RunTotals, work_items::WorkItems};
use carom_tables::Totals;
use cpu_time::ThreadTime;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Mover, Setup};

/// Sectors of the histogram of directions: one for each degree.
pub const SECTORS: usize = 360;

/// Number of equal blocks of each flight; hits of different blocks are practically independent.
pub const BLOCKS: usize = 16;

/// Hits of all flights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hits {
    /// Number by direction of the impulse on the molecule, in its own frame.
    pub directions: Vec<u64>,
    /// Number by atom.
    pub atoms: Vec<u64>,
    /// Number by block, in the order of the flights.
    pub blocks: Vec<u64>,
    /// Duration of one block, and its path without rotation (time or length).
    pub path: f64,
    /// Totals.
    pub totals: Totals,
}

impl Hits {
    /// Total number of hits.
    pub fn total(&self) -> u64 {
        self.directions.iter().sum()
    }

    /// Mean path between hits (length), or mean time of a mover that turns, with its standard
    /// error.
    ///
    /// The rate of hits is constant along a flight, so the ratio of means is unbiased to first
    /// order. The error is from the scatter of the blocks: single free paths have infinite variance
    /// where straight corridors of infinite length exist, because their distribution falls as the
    /// inverse cube.
    pub fn mean_interval(&self) -> (f64, f64) {
        let count = self.blocks.len() as f64;
        let mean = self.blocks.iter().sum::<u64>() as f64 / count;
        let squares: f64 = self.blocks.iter().map(|&hits| (hits as f64 - mean).powi(2)).sum();
        let relative = (squares / (count - 1.0) / count).sqrt() / mean;
        (self.path / mean, self.path / mean * relative)
    }

    fn add(mut self, next: Self) -> Self {
        let add = |sum: &mut Vec<u64>, next: &[u64]| sum.iter_mut().zip(next).for_each(|(a, b)| *a += b);
        add(&mut self.directions, &next.directions);
        add(&mut self.atoms, &next.atoms);
        self.blocks.extend(next.blocks);
        self
    }
}

/// Runs all flights on the threads of the current pool; each flight is a work item.
///
/// # Errors
/// A scene cannot be built, a run fails, or a result cannot be stored.
pub fn fly(setup: &Setup, items: &WorkItems) -> Result<Hits> {
    let progress = Progress::new(setup.duration() * setup.flights() as f64);
    let one = |replica| {
        let name = format!("flight {replica}");
        if items.has(&name) {
            progress.skip(setup.duration());
        }
        items.finish(&name, || flight(setup, replica, &progress).with_context(|| name.clone()))
    };
    // In the order of the replicas, independent of the threads.
    let flights: Vec<Hits> = (0..setup.flights()).into_par_iter().map(one).collect::<Result<_>>()?;
    let totals: Vec<Totals> = flights.iter().map(|flight| flight.totals).collect();
    let all = flights.into_iter().reduce(Hits::add).context("there are no flights")?;
    Ok(Hits { totals: Totals::of(&totals), ..all })
}

fn flight(setup: &Setup, replica: u64, progress: &Progress) -> Result<Hits> {
    let mut simulation = AnySimulation::new(&setup.scene(replica)?)?;
    // Fixed molecules each have a histogram; they have one orientation.
    let is_target = |body: &Body| body.is_fixed() == (setup.mover == Mover::Disc);
    let targets = simulation.view().bodies().map(|body| body.body).filter(|body| is_target(body));
    let mut directions: Vec<_> =
        targets.map(|target| DirectionHistogram::new(target.key(), SECTORS)).collect();
    directions.start(&simulation.view());
    let mut totals = RunTotals::begin(&simulation.view());
    let (mut blocks, mut before) = (Vec::new(), 0);
    let duration = setup.duration();
    let mut seconds = 0.0;
    for block in 1..=BLOCKS {
        let clock = ThreadTime::now();
        simulation.observe_until(duration * block as f64 / BLOCKS as f64, &mut directions)?;
        seconds += clock.elapsed().as_secs_f64();
        totals.sample(&simulation.view());
        let hits = directions.iter().map(DirectionHistogram::hits).sum();
        blocks.push(hits - before);
        progress.advance(duration / BLOCKS as f64, hits - before);
        before = hits;
    }
    let all = directions.into_iter().reduce(|mut all, next| {
        all.absorb(&next);
        all
    });
    let all = all.context("the scene has no molecule")?;
    let mut atoms = all.atom_counts().to_vec();
    atoms.resize(setup.named.molecule.atoms().len(), 0);
    Ok(Hits {
        directions: all.counts().to_vec(),
        atoms,
        blocks,
        path: duration / BLOCKS as f64,
        totals: totals.totals(&simulation.view(), seconds),
    })
}
