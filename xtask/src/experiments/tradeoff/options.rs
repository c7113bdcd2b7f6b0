//! Options of the experiment, and the resulting amount of work.

use carom_runs::output::Destination;
use clap::Args;

use crate::experiments::common::{Common, Seed};

/// Options of `cargo xtask experiment tradeoff`.
#[derive(Debug, Clone, Args)]
#[command(mut_arg("paper", |arg| arg.help(
    "The run for publication: twenty times as many contacts, and the finest fixed steps"
)))]
pub struct Options {
    /// Compile and run rapier2d-f64 as well, in closed boxes; it has its own workspace
    #[arg(long)]
    pub rapier: bool,
    /// Run only scenes whose name begins with this; default: all
    #[arg(long, default_value = "")]
    pub scene: String,
    /// Seed.
    #[command(flatten)]
    pub random: Seed,
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<Destination>,
}

/// Amount of work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Rounds of time measurements; the median is reported.
    pub rounds: u32,
    /// Processor time of one turn in a round (seconds).
    pub turn: f64,
    /// States of the exact run from which contacts are replayed.
    pub states: u32,
    /// Number of blocks for means and standard errors.
    pub blocks: u32,
    /// Processor time after which the replays or blocks of a setting end early (seconds).
    pub most_seconds: f64,
    /// Negative decimal exponent of the finest fixed step (natural times).
    pub finest_step: i32,
}

impl Plan {
    /// The plan as lines of `config.toml`.
    pub fn configuration(&self) -> String {
        format!(
            "rounds_of_times = {}\nseconds_of_a_turn = {}\nstates_replayed = {}\nblocks = {}\n\
             most_seconds_of_a_setting = {}\nfinest_step = 1e-{}\n",
            self.rounds, self.turn, self.states, self.blocks, self.most_seconds, self.finest_step,
        )
    }
}

impl Options {
    /// Amount of work.
    pub fn plan(&self) -> Plan {
        self.common.select(
            Plan { rounds: 5, turn: 0.02, states: 12, blocks: 20, most_seconds: 0.3, finest_step: 2 },
            Plan { rounds: 11, turn: 0.2, states: 300, blocks: 400, most_seconds: 12.0, finest_step: 5 },
        )
    }

    /// Note that is printed and shown first.
    pub fn note(&self) -> String {
        self.common.note(
            ": rates below some hundred wrong contacts in a million are not resolved, and the finest fixed \
             steps are omitted. The full run is --paper.",
        )
    }

    /// The command with every option that affects the results.
    pub fn command(&self) -> String {
        let scene = if self.scene.is_empty() { String::new() } else { format!(" --scene {}", self.scene) };
        let rapier = if self.rapier { " --rapier" } else { "" };
        format!("{}{rapier}{scene} --seed {}", self.common.command("tradeoff"), self.random.seed)
    }
}
