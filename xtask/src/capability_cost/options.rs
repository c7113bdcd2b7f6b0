//! What can be chosen about the experiment, and how much work follows from it.

use std::path::PathBuf;

use clap::Args;

use crate::output::Existing;

/// Choices of `cargo xtask experiment capability-cost`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// A short run, under two minutes (the default)
    #[arg(long, conflicts_with = "paper")]
    pub quick: bool,
    /// The run to quote from: ten times as many collisions
    #[arg(long)]
    pub paper: bool,
    /// Where to write; out/capability-cost if not given
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Replace files of an earlier run in that folder
    #[arg(long)]
    pub force: bool,
}

/// How much is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Standby intervals between the two ends whose counts of instructions are subtracted.
    pub counted: u32,
    /// Rounds of time measurements, of which the median counts.
    pub rounds: u32,
}

impl Options {
    /// How much is done.
    pub fn plan(&self) -> Plan {
        if self.paper { Plan { counted: 100, rounds: 41 } } else { Plan { counted: 3, rounds: 11 } }
    }

    /// Folder to write to.
    pub fn folder(&self) -> PathBuf {
        self.out.clone().unwrap_or_else(|| "out/capability-cost".into())
    }

    /// What is done about files that are there already.
    pub fn existing(&self) -> Existing {
        if self.force { Existing::Replace } else { Existing::Refuse }
    }

    /// The command with every choice written out that the results depend on.
    pub fn command(&self) -> String {
        let size = if self.paper { "--paper" } else { "--quick" };
        format!("cargo xtask experiment capability-cost {size}")
    }
}
