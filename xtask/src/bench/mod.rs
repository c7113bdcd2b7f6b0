//! `cargo xtask bench gas`: collisions per second of whole simulations, by scene and by engine.
//!
//! All engines of a scene run in one process, in turn in each round, and are timed by the processor
//! time of the thread; the median over the rounds is reported. On a shared machine ratios are more
//! reliable than nanoseconds: they are taken round by round, with their least and largest value.
//! Cycles, from the clock rate measured in each turn, remove changes of the clock, but not the
//! effect of two threads on one core.

mod clock;
mod growth;
mod scenes;
mod setup;
mod tiles;

use anyhow::Result;
use carom::{CellsPerSide, Instructions, Scene, engine::TilesName};
use carom_methods::{AnySimulation, Method, Order};
use carom_runs::{console::put, print_line};
use carom_tables::Verdict;
use clap::{Args, Subcommand};
use cpu_time::ThreadTime;
use serde::Serialize;

use self::clock::gigahertz;

/// The benchmarks.
#[derive(Debug, Subcommand)]
pub enum Bench {
    /// Gases of many kinds with every engine
    Gas(BenchOptions),
    /// Construction of a gas, single steps, and edits in a batch
    Setup(setup::SetupOptions),
    /// Growth of gases of many shapes to high densities
    Growth(growth::GrowthOptions),
    /// A large gas in order, in tiles and on several threads, and the scaling to many
    Tiles(tiles::TilesOptions),
}

/// Options of `cargo xtask bench gas`.
#[derive(Debug, Args)]
pub struct BenchOptions {
    /// Run only scenes whose name begins with this; default: all
    #[arg(long, default_value = "")]
    scene: String,
    /// Number of rounds; each engine has one turn in a round
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Processor time of a turn (seconds)
    #[arg(long, default_value = "0.2", value_parser = seconds)]
    turn: f64,
}

/// One row of the table.
#[derive(Debug, Serialize)]
struct Timing {
    scene: &'static str,
    engine: &'static str,
    collisions_per_second: f64,
    ns_per_collision: f64,
    cycles_per_collision: f64,
    ratio_to_thesis: Ratio,
    bytes_per_body: f64,
    n: usize,
}

/// The ratio of the times of two variants, taken round by round.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Ratio {
    median: f64,
    least: f64,
    largest: f64,
}

impl Ratio {
    /// Of pairs of times, one for each round: the first over the second.
    fn from_rounds(pairs: impl Iterator<Item = (f64, f64)>) -> Self {
        let mut ratios: Vec<f64> = pairs.map(|(one, other)| one / other).collect();
        ratios.sort_by(f64::total_cmp);
        let at = |place: usize| ratios.get(place).copied().unwrap_or(f64::NAN);
        Self {
            median: at(ratios.len() / 2),
            least: at(0),
            largest: at(ratios.len().saturating_sub(1)),
        }
    }

    /// Whether all rounds say which variant is faster.
    fn is_resolved(&self) -> bool {
        self.least > 1.0 || self.largest < 1.0
    }
}

impl std::fmt::Display for Ratio {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            median,
            least,
            largest,
        } = self;
        write!(f, "{median:.2} x ({least:.2} to {largest:.2}")?;
        let is_itself = *least == 1.0 && *largest == 1.0;
        f.write_str(if self.is_resolved() || is_itself {
            ")"
        } else {
            ", not resolved)"
        })
    }
}

/// Runs the selected benchmark.
///
/// # Errors
/// A scene cannot be built or run.
pub fn run(bench: &Bench) -> Result<Verdict> {
    let options = match bench {
        Bench::Gas(options) => options,
        Bench::Setup(options) => return setup::run(options),
        Bench::Growth(options) => return growth::run(options),
        Bench::Tiles(options) => return tiles::run(options),
    };
    let mut all = Vec::new();
    for (name, scene) in scenes::all()
        .into_iter()
        .filter(|(name, _)| name.starts_with(&options.scene))
    {
        let timings = time_scene(name, &scene(), options)?;
        for timing in &timings {
            print_line(&row(timing));
        }
        all.extend(timings);
    }
    put("timings", &all);
    Ok(Verdict::Passed)
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    let is_fine = seconds > 0.0 && seconds.is_finite();
    if is_fine {
        Ok(seconds)
    } else {
        Err("the time must be positive and finite".to_owned())
    }
}

fn row(timing: &Timing) -> String {
    format!(
        "{:<16} {:<15} {:>9} bodies {:>9.1} ns = {:>6.0} cycles/collision {:>7.3} M/s  {} thesis {:>6.0} B/body",
        timing.scene,
        timing.engine,
        timing.n,
        timing.ns_per_collision,
        timing.cycles_per_collision,
        timing.collisions_per_second / 1e6,
        timing.ratio_to_thesis,
        timing.bytes_per_body,
    )
}

/// Time of a collision in one turn of an engine.
#[derive(Debug, Clone, Copy)]
struct Turn {
    nanoseconds: f64,
    cycles: f64,
}

/// One engine during a scene.
struct Engine {
    name: &'static str,
    simulation: AnySimulation,
    /// Simulated time per processor second in the previous turn.
    pace: f64,
}

impl Engine {
    fn new(name: &'static str, scene: &Scene, order: Order) -> Result<Self> {
        // Turns are shorter than a window: `bench tiles` measures tiles.
        let method = Method {
            order,
            tiles: TilesName::Never,
            ..Method::default()
        };
        Ok(Self {
            name,
            simulation: AnySimulation::with(scene, &method)?,
            pace: 1e-6,
        })
    }

    /// Runs for about `seconds` of processor time.
    fn turn(&mut self, seconds: f64) -> Result<Turn> {
        let clock_before = gigahertz();
        let before = self.simulation.view().counters().collisions;
        let begun = self.simulation.time().to_f64();
        let clock = ThreadTime::now();
        // The pace is only approximate, so a turn consists of several intervals.
        let mut spent = 0.0;
        while spent < seconds {
            let stretch = self.pace * (seconds - spent).max(0.1 * seconds);
            let from = self.simulation.time().to_f64();
            self.simulation.run_until(from + stretch)?;
            let now = clock.elapsed().as_secs_f64();
            self.pace = stretch / (now - spent).max(1e-9);
            spent = now;
        }
        self.pace = (self.simulation.time().to_f64() - begun) / spent;
        let collisions = self.simulation.view().counters().collisions - before;
        let nanoseconds = 1e9 * spent / collisions.max(1) as f64;
        let cycles = clock_before
            .zip(gigahertz())
            .map(|(a, b)| 0.5 * (a + b) * nanoseconds);
        Ok(Turn {
            nanoseconds,
            cycles: cycles.unwrap_or(f64::NAN),
        })
    }

    fn bytes_per_body(&self) -> f64 {
        self.simulation.heap_bytes() as f64 / self.simulation.view().len().max(1) as f64
    }
}

fn time_scene(name: &'static str, scene: &Scene, options: &BenchOptions) -> Result<Vec<Timing>> {
    let mut engines = vec![
        Engine::new("cells", scene, Order::Cells(Instructions::Widest))?,
        Engine::new("cells-avx2", scene, Order::Cells(Instructions::Avx2))?,
        Engine::new(
            "cells-portable",
            scene,
            Order::Cells(Instructions::Portable),
        )?,
        Engine::new("thesis", scene, Order::Heap(CellsPerSide::Automatic))?,
    ];
    let n = engines[0].simulation.view().len();
    // Two warm-up turns: the initial state is a diluted lattice with equal speeds.
    for engine in &mut engines {
        engine.turn(options.turn)?;
        engine.turn(2.0 * options.turn)?;
    }
    let mut rounds = vec![Vec::new(); engines.len()];
    for _ in 0..options.rounds.max(1) {
        for (engine, times) in engines.iter_mut().zip(&mut rounds) {
            times.push(engine.turn(options.turn)?);
        }
    }
    let thesis = rounds.last().cloned().unwrap_or_default();
    let timing = |engine: &Engine, turns: &[Turn]| {
        let turn = median(turns);
        let pairs = thesis.iter().zip(turns);
        Timing {
            scene: name,
            engine: engine.name,
            collisions_per_second: 1e9 / turn.nanoseconds,
            ns_per_collision: turn.nanoseconds,
            cycles_per_collision: turn.cycles,
            ratio_to_thesis: Ratio::from_rounds(
                pairs.map(|(thesis, own)| (thesis.nanoseconds, own.nanoseconds)),
            ),
            bytes_per_body: engine.bytes_per_body(),
            n,
        }
    };
    let engines = engines.iter().zip(&rounds);
    Ok(engines
        .map(|(engine, turns)| timing(engine, turns))
        .collect())
}

/// Medians of nanoseconds and of cycles.
fn median(turns: &[Turn]) -> Turn {
    let of = |number: fn(&Turn) -> f64| {
        let mut numbers: Vec<f64> = turns.iter().map(number).collect();
        numbers.sort_by(f64::total_cmp);
        numbers[numbers.len() / 2]
    };
    Turn {
        nanoseconds: of(|turn| turn.nanoseconds),
        cycles: of(|turn| turn.cycles),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_is_resolved_if_all_rounds_agree() {
        let of = |pairs: [(f64, f64); 3]| Ratio::from_rounds(pairs.into_iter());
        let clear = of([(2.0, 1.0), (3.0, 2.0), (6.0, 2.0)]);
        assert_eq!((clear.least, clear.median, clear.largest), (1.5, 2.0, 3.0));
        assert_eq!(clear.to_string(), "2.00 x (1.50 to 3.00)");
        let unclear = of([(1.0, 1.1), (1.2, 1.0), (1.0, 1.0)]);
        assert!(
            unclear.to_string().ends_with(", not resolved)"),
            "{unclear}"
        );
        assert_eq!(of([(1.0, 1.0); 3]).to_string(), "1.00 x (1.00 to 1.00)");
        assert!(!Ratio::from_rounds(std::iter::empty()).is_resolved());
    }
}
