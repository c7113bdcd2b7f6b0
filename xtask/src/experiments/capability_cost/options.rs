//! Options of the experiment, and the resulting amount of work.

use carom_runs::output::Destination;
use clap::Args;

/// Options of `cargo xtask experiment capability-cost`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// A short test run, under two minutes (the default)
    #[arg(long, conflicts_with = "paper")]
    pub quick: bool,
    /// The run for publication: ten times as many collisions
    #[arg(long)]
    pub paper: bool,
    /// Output folder and its treatment
    #[command(flatten)]
    pub destination: Destination,
}

/// Amount of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Sample intervals between the two runs whose instruction counts are subtracted.
    pub counted: u32,
    /// Rounds of time measurements; the median is reported.
    pub rounds: u32,
}

impl Options {
    /// Amount of work.
    pub fn plan(&self) -> Plan {
        if self.paper { Plan { counted: 100, rounds: 41 } } else { Plan { counted: 3, rounds: 11 } }
    }

    /// The command with every option that affects the results.
    pub fn command(&self) -> String {
        let size = if self.paper { "--paper" } else { "--quick" };
        format!("cargo xtask experiment capability-cost {size}")
    }
}
