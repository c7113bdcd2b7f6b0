//! What can be chosen about the experiment, and how much work follows from it.

use carom_runs::output::Destination;
use clap::Args;

/// Choices of `cargo xtask experiment capability-cost`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// A short run, under two minutes (the default)
    #[arg(long, conflicts_with = "paper")]
    pub quick: bool,
    /// The run to quote from: ten times as many collisions
    #[arg(long)]
    pub paper: bool,
    /// Where to write, and over what
    #[command(flatten)]
    pub destination: Destination,
}

/// How much is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Sample intervals between the two ends whose counts of instructions are subtracted.
    pub counted: u32,
    /// Rounds of time measurements, of which the median counts.
    pub rounds: u32,
}

impl Options {
    /// How much is done.
    pub fn plan(&self) -> Plan {
        if self.paper { Plan { counted: 100, rounds: 41 } } else { Plan { counted: 3, rounds: 11 } }
    }

    /// The command with every choice written out that the results depend on.
    pub fn command(&self) -> String {
        let size = if self.paper { "--paper" } else { "--quick" };
        format!("cargo xtask experiment capability-cost {size}")
    }
}
