//! Flights of independent discs: hits are counted by direction and by atom and summed in a fixed
//! order.

use anyhow::{Context, Result};
use carom::{DirectionHistogram, EnergyLedger, Observer as _, OverlapCheck};
use carom_methods::AnySimulation;
use carom_runs::{progress::Progress, work_items::WorkItems};
use carom_tables::Totals;
use cpu_time::ThreadTime;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Setup;

/// Sectors of the histogram of directions: one for each degree.
pub const SECTORS: usize = 360;

/// Number of equal blocks of each flight; hits of different blocks are practically independent.
pub const BLOCKS: usize = 16;

/// Hits of all discs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hits {
    /// Number by direction of the impulse on the molecule.
    pub directions: Vec<u64>,
    /// Number by atom.
    pub atoms: Vec<u64>,
    /// Number by block, in the order of the flights.
    pub blocks: Vec<u64>,
    /// Path length of a disc in one block (length).
    pub path: f64,
    /// Totals.
    pub totals: Totals,
}

impl Hits {
    /// Total number of hits.
    pub fn total(&self) -> u64 {
        self.directions.iter().sum()
    }

    /// Mean free path between hits (length), with its standard error.
    ///
    /// The rate of hits is constant along a flight, so the ratio of means is unbiased to first
    /// order. The error is from the scatter of the blocks: single free paths have infinite variance
    /// where straight corridors of infinite length exist, because their distribution falls as the
    /// inverse cube.
    pub fn mean_free_path(&self) -> (f64, f64) {
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

/// Runs all discs on the threads of the current pool; each flight is a work item.
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
    let target = simulation.view().bodies().next().context("the scene has no bodies")?.body.key();
    let mut directions = DirectionHistogram::new(target, SECTORS);
    let (mut energy, mut overlaps) = (EnergyLedger::default(), OverlapCheck::default());
    directions.start(&simulation.view());
    energy.sample(&simulation.view());
    let (mut blocks, mut before) = (Vec::new(), 0);
    let duration = setup.duration();
    let mut seconds = 0.0;
    for block in 1..=BLOCKS {
        let clock = ThreadTime::now();
        simulation.observe_until(duration * block as f64 / BLOCKS as f64, &mut directions)?;
        seconds += clock.elapsed().as_secs_f64();
        energy.sample(&simulation.view());
        overlaps.sample(&simulation.view());
        let hits = directions.hits();
        blocks.push(hits - before);
        progress.advance(duration / BLOCKS as f64, hits - before);
        before = hits;
    }
    let collisions = simulation.view().counters().collisions;
    let mut atoms = directions.atom_counts().to_vec();
    atoms.resize(setup.molecule.atoms().len(), 0);
    Ok(Hits {
        directions: directions.counts().to_vec(),
        atoms,
        blocks,
        path: duration / BLOCKS as f64,
        totals: Totals {
            collisions,
            simulated_time: duration,
            collisions_per_second: collisions as f64 / seconds.max(1e-9),
            energy_drift: energy.drift(),
            overlapping_pairs: overlaps.worst_pairs(),
            max_overlap: overlaps.deepest(),
        },
    })
}
