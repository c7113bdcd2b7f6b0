//! What can be chosen about the experiment, and how much work follows from it.

use carom_runs::output::Destination;
use clap::Args;

/// Choices of `cargo xtask experiment tradeoff`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// A short run to look at, under two minutes (the default)
    #[arg(long, conflicts_with = "paper")]
    pub quick: bool,
    /// The run to quote from: twenty times as many contacts, and the finest fixed steps
    #[arg(long)]
    pub paper: bool,
    /// Compile and run rapier2d-f64 as well, in closed boxes; it has a workspace of its own
    #[arg(long)]
    pub rapier: bool,
    /// Only scenes whose name begins with this; all without
    #[arg(long, default_value = "")]
    pub scene: String,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Where to write, and over what
    #[command(flatten)]
    pub destination: Destination,
}

/// How much is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Rounds of time measurements, of which the median counts.
    pub rounds: u32,
    /// Processor time of one turn in a round (seconds).
    pub turn: f64,
    /// States of the exact run from which contacts are replayed.
    pub states: u32,
    /// Blocks of which means and standard errors are made.
    pub blocks: u32,
    /// A setting is left off in the middle of its replays or blocks after so much processor time (seconds).
    pub most_seconds: f64,
    /// The finest fixed step is ten to the minus this (natural times).
    pub finest_step: i32,
}

impl Plan {
    /// Its numbers, as lines of `config.toml`.
    pub fn configuration(&self) -> String {
        format!(
            "rounds_of_times = {}\nseconds_of_a_turn = {}\nstates_replayed = {}\nblocks = {}\n\
             most_seconds_of_a_setting = {}\nfinest_step = 1e-{}\n",
            self.rounds, self.turn, self.states, self.blocks, self.most_seconds, self.finest_step,
        )
    }
}

impl Options {
    /// How much is done.
    pub fn plan(&self) -> Plan {
        if self.paper {
            Plan { rounds: 11, turn: 0.2, states: 300, blocks: 400, most_seconds: 12.0, finest_step: 5 }
        } else {
            Plan { rounds: 5, turn: 0.02, states: 12, blocks: 20, most_seconds: 0.3, finest_step: 2 }
        }
    }

    /// What is to be known of the plan before anything else.
    pub fn note(&self) -> String {
        if self.paper {
            String::new()
        } else {
            "This is a short run, to look at: rates below some hundred contacts in a million cannot be seen, and the finest \
             fixed steps are left out. The full run is --paper."
                .to_owned()
        }
    }

    /// The command with every choice written out that the results depend on.
    pub fn command(&self) -> String {
        let size = if self.paper { "--paper" } else { "--quick" };
        let scene = if self.scene.is_empty() { String::new() } else { format!(" --scene {}", self.scene) };
        let rapier = if self.rapier { " --rapier" } else { "" };
        format!("cargo xtask experiment tradeoff {size}{rapier}{scene} --seed {}", self.seed)
    }
}
