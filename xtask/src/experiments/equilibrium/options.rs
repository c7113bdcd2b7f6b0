//! Options of the experiment, and the resulting amount of work.

use carom_runs::output::Destination;
use clap::Args;

use crate::experiments::common::{Common, Seed, Threads};

/// Options of `cargo xtask experiment equilibrium`.
#[derive(Debug, Clone, Args)]
#[command(mut_arg("paper", |arg| arg.help("The run for publication: thirty times as long")))]
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
    /// Duration of the runs relative to a short one.
    pub fn length(&self) -> f64 {
        self.common.select(1.0, 30.0)
    }

    /// The command with every option that affects the results.
    pub fn command(&self) -> String {
        format!("{} --seed {}", self.common.command("equilibrium"), self.random.seed)
    }

    /// Note that is printed and shown first.
    pub fn note(&self) -> String {
        self.common.note(": deviations of some tenths of a per cent are not resolved.")
    }
}
