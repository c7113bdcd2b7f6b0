//! The command `carom`: runs scenes of rigid molecules, checks scene files, and finds first contacts.

use anyhow::Result;
use carom_runs::{check, detect, run};
use carom_tables::Verdict;
use clap::{Parser, Subcommand};

/// Exact event-driven simulation of two-dimensional gases of rigid molecules.
///
/// Exit codes: 0 done, 1 a check failed or the run broke off, 2 bad input, 130 or 143 interrupted by a signal.
#[derive(Debug, Parser)]
#[command(name = "carom", version)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a scene, and write a folder with its series, snapshots and page
    Run(run::Options),
    /// Validate a scene; print what it contains and how long its run will take
    Check(check::Options),
    /// Find the first contacts of pairs of molecules
    Detect(detect::Options),
}

impl Cli {
    /// Runs the command.
    ///
    /// # Errors
    /// Bad input, or a run that cannot continue.
    pub fn run(&self) -> Result<Verdict> {
        match &self.command {
            Command::Run(options) => run::run(options),
            Command::Check(options) => check::run(options),
            Command::Detect(options) => detect::run(options),
        }
    }
}
