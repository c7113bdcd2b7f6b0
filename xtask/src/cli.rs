//! The commands of `cargo xtask`, as the command line gives them.

use anyhow::Result;
use carom_runs::{detect, run};
use carom_tables::Verdict;
use clap::{Parser, Subcommand};

use crate::{
    bench, ci,
    experiments::{billiard, brownian, capability_cost, encounters, extremes, thesis_tests, tradeoff},
    fuzz, tidy,
};

/// Runners on top of carom. Exit codes: 0 done, 1 a check failed, 2 bad input, 130 or 143 interrupted by a
/// signal.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What there is to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run an experiment, and write a page about it
    #[command(subcommand)]
    Experiment(Experiment),
    /// Run any scene, with what its [run] asks for
    Run(run::Options),
    /// Find the first contacts of pairs of molecules
    Detect(detect::Options),
    /// Time whole simulations
    #[command(subcommand)]
    Bench(bench::Bench),
    /// Attack detection, scenes and files with random input
    #[command(subcommand)]
    Fuzz(fuzz::Fuzz),
    /// Run the cases that come on the standard input: a part of `fuzz`
    #[command(hide = true, name = fuzz::worker::COMMAND)]
    FuzzWorker {
        /// Which fuzzer
        name: String,
    },
    /// Answer pairs on the standard input with parry: a part of the experiment `encounters`
    #[command(hide = true, name = encounters::parry::COMMAND)]
    ParryWorker,
    /// Run one variant to be counted: a part of the experiment `capability-cost`
    #[command(hide = true, name = capability_cost::COMMAND)]
    CapabilityWorker {
        /// Which variant
        variant: String,
        /// For how many sample intervals
        intervals: u32,
    },
    /// Check what the compiler does not: layers, first lines, the commands in the README
    Tidy,
    /// Run everything that must hold before a change lands; what `.ci/run` calls
    Ci,
}

/// The experiments.
#[derive(Debug, Subcommand)]
pub enum Experiment {
    /// A T-shaped molecule in a dense gas, and from where it is kicked (Montanari 2017, chapter 3)
    Brownian(brownian::Options),
    /// One disc around one fixed molecule: mean free path and directions of hits against integral geometry
    Billiard(billiard::Options),
    /// A thin gas of 50 to 2000 discs, with and without a grid (Montanari 2017, test 1: table 2.1 and figure 2.3)
    Spheres(thesis_tests::Options),
    /// Two rods of 1 to 256 atoms each (Montanari 2017, test 2: figure 2.4)
    Pair(thesis_tests::Options),
    /// All detectors on all kinds of encounters: what accuracy costs, and inaccuracy misses
    Encounters(encounters::Options),
    /// Scenes at the edge of what floats can do: what must hold there, and where it stops to hold
    Extremes(extremes::Options),
    /// What each capability costs where it is absent, idle, and used
    CapabilityCost(capability_cost::Options),
    /// Whole simulations with each knob turned: what accuracy costs, and what inaccuracy buys
    Tradeoff(tradeoff::Options),
}

impl Cli {
    /// Does it.
    ///
    /// # Errors
    /// Input that makes no sense, or a run that cannot go on.
    pub fn run(&self) -> Result<Verdict> {
        match &self.command {
            Command::Experiment(Experiment::Brownian(options)) => brownian::run(options),
            Command::Experiment(Experiment::Billiard(options)) => billiard::run(options),
            Command::Experiment(Experiment::Spheres(options)) => thesis_tests::spheres(options),
            Command::Experiment(Experiment::Pair(options)) => thesis_tests::pair(options),
            Command::Experiment(Experiment::Encounters(options)) => encounters::run(options),
            Command::Experiment(Experiment::Extremes(options)) => extremes::run(options),
            Command::Experiment(Experiment::CapabilityCost(options)) => capability_cost::run(options),
            Command::Experiment(Experiment::Tradeoff(options)) => tradeoff::run(options),
            Command::Run(options) => run::run(options),
            Command::Detect(options) => detect::run(options),
            Command::Bench(bench) => bench::run(bench),
            Command::Fuzz(fuzz) => fuzz::run(fuzz),
            Command::FuzzWorker { name } => fuzz::work(name).map(|()| Verdict::Passed),
            Command::ParryWorker => encounters::parry::work().map(|()| Verdict::Passed),
            Command::CapabilityWorker { variant, intervals } => capability_cost::work(variant, *intervals),
            Command::Tidy => tidy::run(),
            Command::Ci => ci::run(),
        }
    }
}
