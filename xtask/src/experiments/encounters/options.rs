//! What can be chosen about the experiment, and how much work follows from it.

use carom_runs::output::Resumption;
use clap::Args;

/// Choices of `cargo xtask experiment encounters`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// A short run to look at, under two minutes: 150 cases of each class (the default)
    #[arg(long, conflicts_with = "paper")]
    pub quick: bool,
    /// The run to quote from: 3600 cases of each class; more than 100 000 are asked of the golden-section search, too
    #[arg(long)]
    pub paper: bool,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Threads that search at once; as many as there are processors if not given. Only times of the clock depend on it
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Where to write, over what, and whether to go on
    #[command(flatten)]
    pub resumption: Resumption,
}

/// How much is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Cases of each class.
    pub cases: u64,
    /// Most intervals that the oracle looks at in one case.
    pub most_intervals: u64,
    /// A detector is asked about the cases of a class in order until it has computed so many gaps.
    pub most_evaluations: u64,
    /// Rounds of time measurements, of which the median counts.
    pub rounds: usize,
    /// Cases of each class that parry is asked about.
    pub parry_cases: usize,
    /// After so many calls of parry that do not return, no more are made.
    pub most_hung: usize,
}

impl Options {
    /// How much is done.
    pub fn plan(&self) -> Plan {
        if self.paper {
            Plan {
                cases: 3600,
                most_intervals: 3_000_000,
                most_evaluations: 100_000_000,
                rounds: 15,
                parry_cases: 150,
                most_hung: 1000,
            }
        } else {
            Plan {
                cases: 150,
                most_intervals: 300_000,
                most_evaluations: 1_000_000,
                rounds: 5,
                parry_cases: 8,
                most_hung: 60,
            }
        }
    }

    /// What is to be known of the plan before anything else.
    pub fn note(&self) -> String {
        if self.paper {
            String::new()
        } else {
            "This is a short run, to look at: rates below some 1e-3 cannot be seen. The full run is --paper."
                .to_owned()
        }
    }

    /// The command with every choice written out that the results depend on.
    pub fn command(&self) -> String {
        let size = if self.paper { "--paper" } else { "--quick" };
        format!("cargo xtask experiment encounters {size} --seed {}", self.seed)
    }
}
