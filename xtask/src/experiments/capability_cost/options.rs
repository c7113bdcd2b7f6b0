//! Options of the experiment, and the resulting amount of work.

use carom_runs::output::Destination;
use clap::Args;

use crate::experiments::common::Common;

/// Options of `cargo xtask experiment capability-cost`.
#[derive(Debug, Clone, Args)]
#[command(mut_arg("paper", |arg| arg.help("The run for publication: ten times as many collisions")))]
pub struct CapabilityCostOptions {
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<Destination>,
}

/// Amount of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CostPlan {
    /// Sample intervals between the two runs whose instruction counts are subtracted.
    pub counted: u32,
    /// Rounds of time measurements; the median is reported.
    pub rounds: u32,
}

impl CapabilityCostOptions {
    /// Amount of work.
    pub fn plan(&self) -> CostPlan {
        self.common.select(
            CostPlan {
                counted: 3,
                rounds: 11,
            },
            CostPlan {
                counted: 100,
                rounds: 41,
            },
        )
    }

    /// The command with every option that affects the results.
    pub fn command(&self) -> String {
        self.common.command("capability-cost")
    }
}
