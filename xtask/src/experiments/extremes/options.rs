//! What can be chosen about the experiment, and how much work follows from it.

use std::time::Duration;

use carom_runs::output::Destination;
use clap::Args;

/// Choices of `cargo xtask experiment extremes`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// A short run to look at, under two minutes (the default)
    #[arg(long, conflicts_with = "paper")]
    pub quick: bool,
    /// The run to quote from: 1e6 collisions of each gas, drift over 1e9 collisions (1e8 of a few small discs). Under an hour on two cores
    #[arg(long)]
    pub paper: bool,
    /// Only scenes whose number begins with this, and nothing but scenes; all there is without
    #[arg(long, default_value = "")]
    pub scene: String,
    /// Threads; as many as there are processors if not given. Only times of the clock depend on it
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Where to write, and over what
    #[command(flatten)]
    pub destination: Destination,
}

/// How much is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Collisions of each gas in the scenes.
    pub collisions: u64,
    /// Collisions of each trial in the search for an edge.
    pub edge_collisions: u64,
    /// Halvings of the decades in which an edge lies.
    pub halvings: u32,
    /// Starts of the reversal test at each density.
    pub reversals: usize,
    /// Collisions of the drift measurements: Sinai billiard, gas of the thesis, few small discs.
    pub drift: [u64; 3],
    /// How much processor time a scene may take before it counts as hanging.
    pub patience: Duration,
    /// The same for a trial in the search for an edge.
    pub edge_patience: Duration,
}

impl Options {
    /// How much is done.
    pub fn plan(&self) -> Plan {
        if self.paper {
            Plan {
                collisions: 1_000_000,
                edge_collisions: 20_000,
                halvings: 6,
                reversals: 64,
                drift: [1_000_000_000, 1_000_000_000, 100_000_000],
                patience: Duration::from_mins(10),
                edge_patience: Duration::from_mins(1),
            }
        } else {
            Plan {
                collisions: 20_000,
                edge_collisions: 2000,
                halvings: 3,
                reversals: 12,
                // A single disc keeps no others busy at once, and small ones seldom meet: their collisions take longest.
                drift: [1_000_000, 100_000_000, 1_000_000],
                patience: Duration::from_secs(6),
                edge_patience: Duration::from_secs(10),
            }
        }
    }

    /// What is to be known of the plan before anything else.
    pub fn note(&self) -> String {
        if self.paper {
            String::new()
        } else {
            "This is a short run, to look at: gases of 2e4 collisions, drift over 1e6 hits of one disc, 1e8 \
             collisions of a gas, 1e6 of a few small discs. The full run is --paper."
                .to_owned()
        }
    }

    /// The command with every choice written out that the results depend on.
    pub fn command(&self) -> String {
        let size = if self.paper { "--paper" } else { "--quick" };
        let scene = if self.scene.is_empty() { String::new() } else { format!(" --scene {}", self.scene) };
        format!("cargo xtask experiment extremes {size}{scene}")
    }
}
