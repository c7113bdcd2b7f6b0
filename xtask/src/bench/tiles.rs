//! `cargo xtask bench tiles`: a large gas in order, in tiles, and on several threads; and
//! the time on many cores that follows from the times of single tiles.
//!
//! The variants run the same stretch in turn, in one process. Processor time is that of all
//! threads. All variants must end in the same state, to the bit.

use std::time::Instant;

use anyhow::{Result, bail, ensure};
use carom::engine::{TileWork, Tiling};
use carom_methods::AnySimulation;
use carom_runs::{console::put, print_line};
use carom_tables::Verdict;
use clap::Args;
use cpu_time::ProcessTime;
use serde::Serialize;

use super::{Ratio, scenes::LargeGas};

/// Numbers of cores of the scaling, with the side of tiles in cells. Smaller tiles for many cores:
/// each should have a few.
const SCALING: [(usize, u32); 4] = [(1, 200), (8, 200), (64, 62), (512, 40)];

/// Windows of the scaling, of which the last that is whole is reported. The first melts the initial
/// lattice.
const WINDOWS: u32 = 6;

/// Times that the stretch in which the mean free time is measured is doubled.
const MAX_TRIAL: u32 = 30;

/// Options of `cargo xtask bench tiles`.
#[derive(Debug, Args)]
pub struct TilesOptions {
    /// Number of bodies that move
    #[arg(long, default_value_t = 1_000_000)]
    bodies: usize,
    /// Kind of gas
    #[arg(long, value_enum, default_value_t = LargeGas::Discs)]
    gas: LargeGas,
    /// Area fraction
    #[arg(long, default_value_t = 0.5)]
    area_fraction: f64,
    /// Elasticity of all contacts; below 1 the gas cools
    #[arg(long, default_value_t = 1.0)]
    elasticity: f64,
    /// Contacts of each body in a turn
    #[arg(long, default_value_t = 8.0)]
    contacts: f64,
    /// Stops in each mean free time, at which samples could be taken
    #[arg(long, default_value_t = 0)]
    stops: u32,
    /// Number of rounds; each variant has one turn in a round
    #[arg(long, default_value_t = 3)]
    rounds: usize,
    /// Largest number of threads; default: one for each processor
    #[arg(long)]
    threads: Option<usize>,
    /// Cells along a side of a tile
    #[arg(long, default_value_t = Tiling::NONE.side)]
    side: u32,
    /// Length of a window (mean free times)
    #[arg(long, default_value_t = Tiling::NONE.window)]
    window: f64,
    /// Cells by which a border is wider than an influence travels in a window
    #[arg(long, default_value_t = Tiling::NONE.margin)]
    margin: u32,
    /// Cells that an influence travels in a mean free time
    #[arg(long, default_value_t = Tiling::NONE.front)]
    front: f64,
    /// Do not estimate the time on many cores
    #[arg(long)]
    no_scaling: bool,
}

/// One variant and its turns.
struct Variant {
    name: String,
    simulation: AnySimulation,
    /// Nanoseconds of a contact: of wall time and of processor time.
    turns: Vec<[f64; 2]>,
}

/// One row of the table.
#[derive(Debug, Serialize)]
struct Row {
    bodies: usize,
    variant: String,
    wall_ns: f64,
    cpu_ns: f64,
    /// Processor time of the run in order, divided by that of this variant.
    cpu_ratio: Ratio,
    /// Wall time of tiles on one thread, divided by that of this variant.
    wall_ratio: Ratio,
    /// Contacts computed for each contact.
    work: f64,
    tiles_repeated: f64,
    bytes_per_body: f64,
}

/// The expected time on a number of cores.
#[derive(Debug, Serialize)]
struct Scaling {
    cores: usize,
    tiles: usize,
    ns: f64,
    /// Of these, what one thread does between the tiles' runs.
    between_ns: f64,
    speedup: f64,
    megabytes_exchanged: f64,
}

/// Runs the benchmark.
///
/// # Errors
/// The gas cannot be built or run, or two variants differ.
pub fn run(options: &TilesOptions) -> Result<Verdict> {
    ensure!(
        options.bodies > 0 && options.contacts > 0.0,
        "the bodies and their contacts must be positive"
    );
    let mut scene = options.gas.scene(options.bodies, options.area_fraction);
    scene.elasticity.default = options.elasticity;
    let base = AnySimulation::new(&scene)?;
    let free_time = free_time(options, &base)?;
    let mut variants = variants(options, &base);
    let unit = options.contacts * free_time;
    let pieces = ((options.contacts * f64::from(options.stops)).ceil() as u32).max(1);
    // The first turn melts the initial lattice.
    for round in 0..=options.rounds {
        for variant in &mut variants {
            let turn = turn(&mut variant.simulation, round as f64 * unit, unit, pieces)?;
            if round > 0 {
                variant.turns.push(turn);
            }
        }
        ensure!(
            variants.iter().all(|variant| same(&variants[0], variant)),
            "two variants differ"
        );
    }
    let rows = rows(options, &variants);
    rows.iter().for_each(print);
    put("timings", &rows);
    if !options.no_scaling {
        scaling(&base, free_time, rows[0].cpu_ns)?;
    }
    Ok(Verdict::Passed)
}

/// In order, in tiles on one thread, and on all.
fn variants(options: &TilesOptions, base: &AnySimulation) -> Vec<Variant> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let variant = |name: String, tiling: Tiling| {
        let mut simulation = base.clone();
        simulation.set_tiling(&tiling);
        Variant {
            name,
            simulation,
            turns: Vec::new(),
        }
    };
    let in_tiles = |threads| {
        let TilesOptions {
            side,
            window,
            margin,
            front,
            ..
        } = *options;
        let (least_bodies, least_molecules) = (1, 1);
        let tiling = Tiling {
            threads,
            least_bodies,
            least_molecules,
            side,
            window,
            margin,
            front,
        };
        variant(format!("tiles, {threads} threads"), tiling)
    };
    let mut variants = vec![variant("in order".to_owned(), Tiling::NONE), in_tiles(1)];
    let most = options.threads.unwrap_or(processors);
    variants.extend((most > 1).then(|| in_tiles(most)));
    variants
}

/// The mean time between two contacts of a body, measured on a copy (time).
fn free_time(options: &TilesOptions, base: &AnySimulation) -> Result<f64> {
    let bodies = options.bodies as f64;
    let mut copy = base.clone();
    // Bodies of unit speed pass their mean distance in this time.
    let (mut from, mut until) = ((0.0, 0), 0.1 / bodies.sqrt());
    for _ in 0..MAX_TRIAL {
        copy.run_until(until)?;
        let collisions = copy.view().counters().collisions;
        if collisions > options.bodies as u64 {
            return Ok(0.5 * bodies * (until - from.0) / (collisions - from.1) as f64);
        }
        (from, until) = ((until, collisions), 2.0 * until);
    }
    bail!("the bodies have hardly any contacts")
}

/// Runs from a time on for a duration, with stops at the end of equal pieces; returns the
/// nanoseconds of a contact, of wall and of processor time.
fn turn(simulation: &mut AnySimulation, from: f64, duration: f64, pieces: u32) -> Result<[f64; 2]> {
    let before = simulation.view().counters().collisions;
    let (wall, cpu) = (Instant::now(), ProcessTime::now());
    for piece in 1..=pieces {
        simulation.run_until(from + duration * f64::from(piece) / f64::from(pieces))?;
    }
    let (wall, cpu) = (wall.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    let contacts = (simulation.view().counters().collisions - before).max(1) as f64;
    Ok([wall, cpu].map(|seconds| 1e9 * seconds / contacts))
}

/// Whether two variants are in the same state, to the bit.
fn same(one: &Variant, other: &Variant) -> bool {
    let (one, other) = (one.simulation.view(), other.simulation.view());
    let motions = one.bodies().zip(other.bodies());
    let bits = |vector: glam::DVec2| vector.to_array().map(f64::to_bits);
    motions.into_iter().all(|(one, other)| {
        bits(one.motion.position) == bits(other.motion.position)
            && bits(one.motion.velocity) == bits(other.motion.velocity)
            && one.motion.orientation.turns().to_bits()
                == other.motion.orientation.turns().to_bits()
    })
}

fn rows(options: &TilesOptions, variants: &[Variant]) -> Vec<Row> {
    let median = |variant: &Variant, of: usize| {
        let mut turns: Vec<f64> = variant.turns.iter().map(|turn| turn[of]).collect();
        turns.sort_by(f64::total_cmp);
        turns.get(turns.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let ratio = |one: &Variant, other: &Variant, of: usize| {
        let rounds = one.turns.iter().zip(&other.turns);
        Ratio::from_rounds(rounds.map(|(one, other)| (one[of], other[of])))
    };
    let row = |variant: &Variant| {
        let counters = variant.simulation.tile_counters();
        let (wall_ns, cpu_ns) = (median(variant, 0), median(variant, 1));
        Row {
            bodies: options.bodies,
            variant: variant.name.clone(),
            wall_ns,
            cpu_ns,
            cpu_ratio: ratio(&variants[0], variant, 1),
            wall_ratio: ratio(&variants[1], variant, 0),
            work: counters.computed as f64 / counters.contacts.max(1) as f64,
            tiles_repeated: counters.repeated as f64 / counters.tiles.max(1) as f64,
            bytes_per_body: variant.simulation.heap_bytes() as f64 / options.bodies as f64,
        }
    };
    variants.iter().map(row).collect()
}

fn print(row: &Row) {
    let Row {
        bodies,
        variant,
        wall_ns,
        cpu_ns,
        cpu_ratio,
        wall_ratio,
        work,
        tiles_repeated,
        bytes_per_body,
    } = row;
    print_line(&format!(
        "{bodies:>9} bodies  {variant:<18} {wall_ns:>7.1} ns wall {cpu_ns:>7.1} ns cpu  \
         {cpu_ratio} in order (cpu)  {wall_ratio} one thread (wall)  \
         work {work:.2}  repeated {:.2} %  {bytes_per_body:.0} B/body",
        1e2 * tiles_repeated,
    ));
}

/// One window: the work of its tiles, and the time between their runs (seconds).
struct Measured {
    work: Vec<TileWork>,
    between: f64,
}

/// Runs windows of a division one by one; none if the box has no room for its tiles.
fn measure(base: &AnySimulation, tiling: &Tiling, length: f64) -> Result<Option<Measured>> {
    let mut simulation = base.clone();
    simulation.set_tiling(tiling);
    let mut last = None;
    for window in 1..=WINDOWS {
        let until = f64::from(window) * length;
        let before = simulation.tile_counters().windows;
        let seconds = timed(&mut simulation, until)?;
        if simulation.tile_counters().windows != before + 1 {
            // The end of an epoch divides this one.
            continue;
        }
        // The same time again: nothing but the copy of all motions, which a window does not need.
        let copy = timed(&mut simulation, until)?;
        let work = simulation.tile_work();
        let in_tiles: f64 = work.iter().map(|tile| tile.seconds).sum();
        last = Some(Measured {
            work,
            between: (seconds - copy - in_tiles).max(0.0),
        });
    }
    Ok(last)
}

/// The wall time of a run to a time (seconds).
fn timed(simulation: &mut AnySimulation, until: f64) -> Result<f64> {
    let clock = Instant::now();
    simulation.run_until(until)?;
    Ok(clock.elapsed().as_secs_f64())
}

/// Prints the time of a contact on many cores, from the times of the tiles of one window.
///
/// Each core takes the next tile as soon as it is free, so borders and imbalance are included. All
/// that happens between the tiles' runs is measured on one thread and added. That cores share
/// memory is not included.
fn scaling(base: &AnySimulation, free_time: f64, order_ns: f64) -> Result<()> {
    let mut table = Vec::new();
    for (cores, side) in SCALING {
        let tiling = Tiling {
            least_bodies: 1,
            least_molecules: 1,
            side,
            ..Tiling::NONE
        };
        let Some(Measured { work, between }) = measure(base, &tiling, tiling.window * free_time)?
        else {
            print_line(&format!(
                "{cores} cores: the box has no room for tiles of {side} cells"
            ));
            continue;
        };
        let contacts: u64 = work.iter().map(|tile| tile.contacts).sum();
        let nanoseconds = |seconds: f64| 1e9 * seconds / contacts.max(1) as f64;
        let ns = nanoseconds(longest(&work, cores) + between);
        let bytes: usize = work
            .iter()
            .map(|tile| tile.copied_bytes + tile.log_bytes)
            .sum();
        let row = Scaling {
            cores,
            tiles: work.len(),
            ns,
            between_ns: nanoseconds(between),
            speedup: order_ns / ns,
            megabytes_exchanged: 1e-6 * bytes as f64,
        };
        print_line(&format!(
            "{:>4} cores  {:>5} tiles of {side} cells  {:>7.2} ns, {:.2} of them between tiles  {:>6.1} x in order  \
             {:.1} MB between tiles in a window of {} mean free times",
            row.cores,
            row.tiles,
            row.ns,
            row.between_ns,
            row.speedup,
            row.megabytes_exchanged,
            tiling.window,
        ));
        table.push(row);
    }
    put("scaling", &table);
    Ok(())
}

/// The time until the last of some cores has run its tiles, which are taken in order (seconds).
fn longest(work: &[TileWork], cores: usize) -> f64 {
    let mut busy_until = vec![0.0_f64; cores];
    for tile in work {
        if let Some(free) = busy_until.iter_mut().min_by(|a, b| a.total_cmp(b)) {
            *free += tile.seconds;
        }
    }
    busy_until.into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_go_to_the_core_that_is_free_first() {
        let work = [3.0, 1.0, 1.0, 1.0, 2.0].map(|seconds| {
            let mut work = TileWork::default();
            work.seconds = seconds;
            work
        });
        assert_eq!(longest(&work, 1), 8.0);
        assert_eq!(longest(&work, 2), 5.0);
        assert_eq!(longest(&work, 8), 3.0);
    }
}
