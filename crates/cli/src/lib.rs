//! The command `carom`: runs scenes of rigid molecules, validates scene files, and finds first
//! contacts.

use anyhow::Result;
use carom_runs::{check, convert, detect, measures, merge, reference, run};
use carom_tables::Verdict;
use clap::{Parser, Subcommand};

/// Exact event-driven simulation of two-dimensional gases of rigid molecules.
///
/// Exit codes: 0 success, 1 a check or the run failed, 2 invalid input, 130 or 143 interrupted by a
/// signal.
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
    /// Run a scene and write a folder with its series, snapshots and page
    Run(run::Options),
    /// Validate a scene; print its content and estimate the duration of its run
    Check(check::Options),
    /// Find the first contacts of pairs of molecules, or draw how each detector finds one
    Detect(detect::Options),
    /// Merge the runs of several replicas of a scene
    Merge(merge::Options),
    /// Write a trajectory as GSD (HOOMD) or as a LAMMPS dump
    Convert(convert::Options),
    /// List the quantities that a scene can measure, with their parameters
    Measures,
    /// Print the JSON Schema of scene files, with which editors complete and check keys
    Schema(reference::Options),
}

impl Cli {
    /// Runs the command.
    ///
    /// # Errors
    /// Invalid input, or a run that fails.
    pub fn run(&self) -> Result<Verdict> {
        match &self.command {
            Command::Run(options) => run::run(options),
            Command::Check(options) => check::run(options),
            Command::Detect(options) => detect::run(options),
            Command::Merge(options) => merge::run(options),
            Command::Convert(options) => convert::run(options),
            Command::Measures => Ok(measures::list()),
            Command::Schema(options) => reference::run(options),
        }
    }
}
