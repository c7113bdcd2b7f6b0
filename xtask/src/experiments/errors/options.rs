//! Options of the experiment, and the resulting amount of work.

use carom_runs::output::Destination;
use clap::Args;

use crate::experiments::common::{Common, Seed, Threads};

/// Options of `cargo xtask experiment errors`.
#[derive(Debug, Clone, Args)]
#[command(mut_arg("paper", |arg| arg.help("The run for publication: 400 replicas")))]
pub struct Options {
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<Destination>,
    /// The seed.
    #[command(flatten)]
    pub random: Seed,
    /// The threads.
    #[command(flatten)]
    pub threads: Threads,
}

impl Options {
    /// Number of replicas.
    pub fn replicas(&self) -> u64 {
        self.common.select(60, 400)
    }

    /// The command with every option that affects the results.
    pub fn command(&self) -> String {
        format!("{} --seed {}", self.common.command("errors"), self.random.seed)
    }

    /// Note that is printed and shown first.
    pub fn note(&self) -> String {
        self.common.note(": the band is wide.")
    }
}
