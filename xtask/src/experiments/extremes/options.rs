//! Options of the experiment, and the resulting amount of work.

use std::time::Duration;

use carom_runs::output::Destination;
use clap::Args;

use crate::experiments::common::{Common, Threads};

/// Options of `cargo xtask experiment extremes`.
#[derive(Debug, Clone, Args)]
#[command(mut_arg("paper", |arg| arg.help(
    "The run for publication: 1e6 collisions of each gas, drift over 1e9 collisions (1e8 of a few small \
     discs). Under an hour on two cores"
)))]
pub struct ExtremesOptions {
    /// Run only the scenes whose number begins with this; default: everything
    #[arg(long, default_value = "")]
    pub scene: String,
    /// Threads.
    #[command(flatten)]
    pub threads: Threads,
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<Destination>,
}

/// Amount of work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtremesPlan {
    /// Collisions of each gas in the scenes.
    pub collisions: u64,
    /// Collisions of each trial in the search for a limit.
    pub limit_collisions: u64,
    /// Bisections of the decades that contain a limit.
    pub halvings: u32,
    /// Starts of the reversal test at each density.
    pub reversals: usize,
    /// Collisions of the drift measurements: Sinai billiard, gas of the thesis, few small discs.
    pub drift: [u64; 3],
    /// Processor time after which a scene counts as hanging.
    pub patience: Duration,
    /// Processor time after which a trial in the search for a limit counts as hanging.
    pub limit_patience: Duration,
}

impl ExtremesOptions {
    /// Amount of work.
    pub fn plan(&self) -> ExtremesPlan {
        self.common.select(
            ExtremesPlan {
                collisions: 20_000,
                limit_collisions: 2000,
                halvings: 3,
                reversals: 12,
                // The largest number is for the gas: a single disc and few small discs take more
                // time for each collision.
                drift: [1_000_000, 100_000_000, 1_000_000],
                patience: Duration::from_secs(6),
                limit_patience: Duration::from_secs(10),
            },
            ExtremesPlan {
                collisions: 1_000_000,
                limit_collisions: 20_000,
                halvings: 6,
                reversals: 64,
                drift: [1_000_000_000, 1_000_000_000, 100_000_000],
                patience: Duration::from_mins(10),
                limit_patience: Duration::from_mins(1),
            },
        )
    }

    /// Note that is printed and shown first.
    pub fn note(&self) -> String {
        self.common.note(
            ": gases of 2e4 collisions, drift over 1e6 hits of one disc, 1e8 collisions of a gas, 1e6 of a few \
             small discs. The full run is --paper.",
        )
    }

    /// The command with every option that affects the results.
    pub fn command(&self) -> String {
        let scene = if self.scene.is_empty() {
            String::new()
        } else {
            format!(" --scene {}", self.scene)
        };
        format!("{}{scene}", self.common.command("extremes"))
    }
}
