//! Options of the two tests.

use carom_runs::output::Resumption;
use clap::Args;

use crate::experiments::common::{Common, Seed};

/// Options of `cargo xtask experiment spheres` and `pair`.
#[derive(Debug, Clone, Args)]
#[command(
    mut_arg("quick", |arg| arg.help(
        "A short test run, under two minutes: at most a second of processor time for each case (the default)"
    )),
    mut_arg("paper", |arg| arg.help(
        "The run of the thesis: each case to 100 time units and on until its times are known to 1 %, for at \
         most ten minutes of processor time"
    ))
)]
pub struct ThesisTestsOptions {
    /// Largest processor time of each case instead (seconds)
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub seconds: Option<u32>,
    /// Seed.
    #[command(flatten)]
    pub random: Seed,
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<Resumption>,
}

impl ThesisTestsOptions {
    /// Largest processor time of each case (seconds).
    pub fn budget(&self) -> f64 {
        self.seconds
            .map_or(self.common.select(1.0, 600.0), f64::from)
    }

    /// Note that is printed and shown first.
    pub fn note(&self) -> String {
        self.common.note(
            ": slow cases end early, and their times for 100 time units are extrapolated. The run of the \
             thesis is --paper.",
        )
    }

    /// The command with every option that affects the results.
    pub fn command(&self, test: &str) -> String {
        format!(
            "{} --seconds {} --seed {}",
            self.common.command(test),
            self.budget(),
            self.random.seed
        )
    }
}
