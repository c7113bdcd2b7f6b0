//! Options of the experiment, and the resulting amount of work.

use carom_runs::output::Resumption;
use clap::Args;

use crate::experiments::common::{Common, Seed, Threads};

/// Options of `cargo xtask experiment encounters`.
#[derive(Debug, Clone, Args)]
#[command(
    mut_arg("quick", |arg| arg.help(
        "A short test run, under two minutes: 150 cases of each class (the default)"
    )),
    mut_arg("paper", |arg| arg.help(
        "The run for publication: 3600 cases of each class, more than 100 000 for the golden-section search"
    ))
)]
pub struct Options {
    /// Seed.
    #[command(flatten)]
    pub random: Seed,
    /// Threads.
    #[command(flatten)]
    pub threads: Threads,
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<Resumption>,
}

/// Amount of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Number of cases of each class.
    pub cases: u64,
    /// Largest number of intervals that the oracle examines in one case.
    pub most_intervals: u64,
    /// A detector searches the cases of a class in order until it has evaluated this many gaps.
    pub most_evaluations: u64,
    /// Rounds of time measurements; the median is reported.
    pub rounds: usize,
    /// Number of cases of each class that parry searches.
    pub parry_cases: usize,
    /// Number of calls of parry without return after which no more are made.
    pub most_hung: usize,
}

impl Options {
    /// Amount of work.
    pub fn plan(&self) -> Plan {
        self.common.select(
            Plan {
                cases: 150,
                most_intervals: 300_000,
                most_evaluations: 1_000_000,
                rounds: 5,
                parry_cases: 8,
                most_hung: 60,
            },
            Plan {
                cases: 3600,
                most_intervals: 3_000_000,
                most_evaluations: 100_000_000,
                rounds: 15,
                parry_cases: 150,
                most_hung: 1000,
            },
        )
    }

    /// Note that is printed and shown first.
    pub fn note(&self) -> String {
        self.common.note(": rates below about 1e-3 are not resolved. The full run is --paper.")
    }

    /// The command with every option that affects the results.
    pub fn command(&self) -> String {
        format!("{} --seed {}", self.common.command("encounters"), self.random.seed)
    }
}
