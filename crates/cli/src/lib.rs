//! The command `carom`: runs scenes of rigid molecules, validates scene files, and finds first
//! contacts.
//!
//! Internal: a part of the program `carom`. Its public items serve the other crates of it, and
//! change without notice.

mod completions;

use anyhow::Result;
use carom_experiments::{billiard, brownian, trade};
use carom_runs::{
    check,
    console::{Console, Program},
    convert, detect, examples, measures, merge, report, run,
};
use carom_sweeps::{reference, several, sweep};
use carom_tables::Verdict;
use clap::{Parser, Subcommand};

/// Exact event-driven simulation of two-dimensional gases of rigid molecules.
///
/// Exit codes: 0 success, 1 a check or the run failed, 2 invalid input, 3 a sweep or merge has
/// written its results but runs or replicas are missing, 129, 130 or 143 interrupted by a signal.
#[derive(Debug, Parser)]
#[command(name = "carom", version = carom_runs::manifest::BUILD)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
    /// Progress, notes and results on the terminal.
    #[command(flatten)]
    pub console: Console,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a scene and write a folder with its series, snapshots and page
    Run(run::RunOptions),
    /// Turn every knob of detector and scheduler on a scene: time saved, and what goes wrong
    Trade(trade::TradeOptions),
    /// Watch, measure and edit a running scene in the browser
    #[cfg(feature = "live")]
    Live(carom_live::LiveOptions),
    /// Validate a scene; print its content and estimate the duration of its run
    Check(check::CheckOptions),
    /// A molecule in a gas: directions of the impulses on it, and a verdict on every mean that
    /// equilibrium sets to zero
    Brownian(brownian::BrownianOptions),
    /// Test a molecule against integral geometry: mean free path and directions of the hits of a
    /// disc around it, or of the molecule among discs
    Billiard(billiard::BilliardOptions),
    /// Find the first contacts of pairs of molecules, or draw how each detector finds one
    Detect(detect::DetectOptions),
    /// Run a scene at many points of its parameters, with replicas, on all processors
    Sweep(sweep::SweepOptions),
    /// Merge the runs of several replicas of a scene, or the shards of a sweep
    Merge(merge::MergeOptions),
    /// Write the page of a run folder again from its data
    Report(report::ReportOptions),
    /// Write a trajectory for other programs: GSD (HOOMD), LAMMPS dump or data file; a table as
    /// .npy
    Convert(convert::ConvertOptions),
    /// List the quantities that a scene can measure, with their parameters
    Measures,
    /// List scenes and studies to begin with; print one, or write it to a file
    Example(examples::ExamplesOptions),
    /// Print completions of commands and options for a shell, or the manual page
    Completions(completions::CompletionsOptions),
    /// Print the JSON Schema of scene or study files, with which editors complete and check keys
    Schema(reference::StudyReferenceOptions),
}

impl Program for Cli {
    fn console(&self) -> Console {
        self.console
    }

    /// The laboratory has no end, and its page shows the run.
    #[cfg(feature = "live")]
    fn shows_progress(&self) -> bool {
        !matches!(self.command, Command::Live(_))
    }

    fn run(&self) -> Result<Verdict> {
        match &self.command {
            Command::Run(options) => run::run(options),
            Command::Trade(options) => trade::run(options),
            #[cfg(feature = "live")]
            Command::Live(options) => carom_live::run(options),
            Command::Check(options) => check::run(options),
            Command::Brownian(options) => brownian::run(options),
            Command::Billiard(options) => billiard::run(options),
            Command::Detect(options) => detect::run(options),
            Command::Sweep(options) => several::run(options),
            Command::Merge(options) => carom_sweeps::merge::run(options),
            Command::Report(options) => report::run(options),
            Command::Convert(options) => convert::run(options),
            Command::Measures => Ok(measures::list()),
            Command::Example(options) => examples::run(options),
            Command::Completions(options) => completions::run(options),
            Command::Schema(options) => reference::run(options),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_options_of_all_commands_fit_together() {
        Cli::command().debug_assert();
    }

    #[test]
    fn the_version_names_the_compiler_and_in_a_repository_the_revision() {
        let command = Cli::command();
        let version = command.get_version().unwrap();
        assert!(
            version.starts_with(carom::VERSION) && version.contains("rustc "),
            "{version}"
        );
        let is_known = carom_runs::manifest::REVISION.is_some();
        assert_eq!(version.contains("revision "), is_known, "{version}");
    }
}
