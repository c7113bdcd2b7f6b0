//! The command line of `cargo xtask`.

use anyhow::Result;
use carom_runs::console::{Console, Program};
use carom_tables::Verdict;
use clap::{Parser, Subcommand};

use crate::{
    attack, bench, ci,
    experiments::{all, capability_cost, encounters, extremes, studies, thesis_tests},
    fuzz, release, site, surface, tidy, web,
};

/// Commands for experiments and checks with carom. Exit codes: 0 success, 1 a check failed, 2
/// invalid input, 129, 130 or 143 interrupted by a signal.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: XtaskCommand,
    /// Progress, notes and results on the terminal.
    #[command(flatten)]
    pub console: Console,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum XtaskCommand {
    /// Run an experiment and write a page about it
    #[command(subcommand)]
    Experiment(XtaskExperiment),
    /// Time whole simulations
    #[command(subcommand)]
    Bench(bench::Bench),
    /// Test detection, scenes and files with random input
    #[command(subcommand)]
    Fuzz(fuzz::Fuzz),
    /// Disturb the program by signals, failing files, losses of power, second processes and mutated
    /// files, and compare with undisturbed runs
    Attack(attack::AttackOptions),
    /// Run a command of `carom`, with the build of the repository
    #[command(name = attack::process::COMMAND)]
    Carom(Box<carom_cli::Cli>),
    /// Run cases from standard input: a part of `fuzz`
    #[command(hide = true, name = fuzz::worker::COMMAND)]
    FuzzWorker {
        /// Name of the fuzzer
        name: String,
    },
    /// Search pairs from standard input with parry: a part of the experiment `encounters`
    #[command(hide = true, name = encounters::parry::COMMAND)]
    ParryWorker,
    /// Run one variant under callgrind: a part of the experiment `capability-cost`
    #[command(hide = true, name = capability_cost::COMMAND)]
    CapabilityWorker {
        /// Name of the variant
        variant: String,
        /// Number of sample intervals
        intervals: u32,
    },
    /// Check what the compiler does not: crate imports, cycles of files, first sentences, width,
    /// words, commands in Markdown, one glam, test programs, map of the crates
    Tidy,
    /// Compare the public items of the facade and the layers with the committed list
    Surface(surface::SurfaceOptions),
    /// Write the site: a gallery of studies with their results, how they were validated, the book
    /// and the Rust reference
    Site(site::SiteOptions),
    /// Write the laboratory of `carom live` as pages without a server, with the engine in
    /// WebAssembly
    Web(web::WebOptions),
    /// Write all that a release would upload into one folder, with checksums and the commands that
    /// publish it; nothing is uploaded
    Release(release::ReleaseOptions),
    /// Run everything that must hold before a change lands; what `.ci/run` calls
    Ci,
}

/// The experiments.
#[derive(Debug, Subcommand)]
pub enum XtaskExperiment {
    /// A T-shaped molecule in a dense gas: free, locked, or replaced by a disc; and in a dilute gas
    /// (Montanari 2017, chapter 3)
    Brownian(studies::StudiesOptions),
    /// A disc around a fixed molecule: mean free path and directions of hits compared with integral
    /// geometry
    Billiard(studies::StudiesOptions),
    /// A dilute gas of 50 to 2000 discs, with and without a grid (Montanari 2017, test 1: table 2.1
    /// and figure 2.3)
    Spheres(thesis_tests::ThesisTestsOptions),
    /// Two rods of 1 to 256 atoms each (Montanari 2017, test 2: figure 2.4)
    Pair(thesis_tests::ThesisTestsOptions),
    /// All detectors on all kinds of encounters: cost of accuracy and errors of inaccuracy
    #[command(
        mut_arg("quick", |arg| arg.help(
            "A short test run, under two minutes: 150 cases of each class (the default)"
        )),
        mut_arg("paper", |arg| arg.help(
            "The run for publication: 3600 cases of each class, more than 100 000 for the golden-section search"
        ))
    )]
    Encounters(encounters::Options),
    /// Extreme scenes: guarantees that must hold, and their limits
    Extremes(extremes::ExtremesOptions),
    /// Equilibrium of hard discs and of a mixture, against theory and published pressures
    Equilibrium(studies::StudiesOptions),
    /// Boltzmann's H-theorem: how a gas of equal speeds becomes Maxwellian
    Relaxation(studies::StudiesOptions),
    /// Pressure of thin gases of molecules: their second virial coefficients
    Virial(studies::StudiesOptions),
    /// Velocity autocorrelation, a heavy Brownian disc, viscosity and heat conductivity
    Diffusion(studies::StudiesOptions),
    /// The force with which small discs push two big ones together
    Depletion(studies::StudiesOptions),
    /// Haff's law of an inelastic gas
    Cooling(studies::StudiesOptions),
    /// Haff's law of a gas whose contacts gain energy
    Heating(studies::StudiesOptions),
    /// The flow of heat between groups at two temperatures
    Thermostat(studies::StudiesOptions),
    /// The pressure of hard discs between liquid and hexatic
    Freezing(studies::StudiesOptions),
    /// The drift of an asymmetric molecule, in equilibrium and out of it
    Ratchet(studies::StudiesOptions),
    /// Cost of each capability when it is absent, idle, or used
    CapabilityCost(capability_cost::CapabilityCostOptions),
    /// All experiments one after another, and one table of their verdicts
    All(all::AllOptions),
}

/// Parses the words of a command, for the check of those in Markdown.
///
/// # Errors
/// The command is invalid.
pub fn parse(words: &[String]) -> Result<(), clap::Error> {
    Cli::try_parse_from(words).map(|_| ())
}

impl XtaskExperiment {
    fn run(&self) -> Result<Verdict> {
        match self {
            Self::Brownian(options) => studies::run("brownian", options),
            Self::Billiard(options) => studies::run("billiard", options),
            Self::Spheres(options) => thesis_tests::spheres(options),
            Self::Pair(options) => thesis_tests::pair(options),
            Self::Encounters(options) => encounters::run(options),
            Self::Extremes(options) => extremes::run(options),
            Self::Equilibrium(options) => studies::run("equilibrium", options),
            Self::Relaxation(options) => studies::run("relaxation", options),
            Self::Virial(options) => studies::run("virial", options),
            Self::Diffusion(options) => studies::run("diffusion", options),
            Self::Depletion(options) => studies::run("depletion", options),
            Self::Cooling(options) => studies::run("cooling", options),
            Self::Heating(options) => studies::run("heating", options),
            Self::Thermostat(options) => studies::run("thermostat", options),
            Self::Freezing(options) => studies::run("freezing", options),
            Self::Ratchet(options) => studies::run("ratchet", options),
            Self::All(options) => all::run(options),
            Self::CapabilityCost(options) => capability_cost::run(options),
        }
    }
}

impl Program for Cli {
    fn console(&self) -> Console {
        self.console
    }

    /// Chores of the repository print what they do, and workers are parts of other commands.
    fn shows_progress(&self) -> bool {
        match &self.command {
            XtaskCommand::Experiment(_) | XtaskCommand::Site(_) => true,
            XtaskCommand::Carom(carom) => carom.shows_progress(),
            _ => false,
        }
    }

    fn run(&self) -> Result<Verdict> {
        match &self.command {
            XtaskCommand::Experiment(experiment) => experiment.run(),
            XtaskCommand::Bench(bench) => bench::run(bench),
            XtaskCommand::Fuzz(fuzz) => fuzz::run(fuzz),
            XtaskCommand::Attack(options) => attack::run(options),
            XtaskCommand::Carom(carom) => carom.run(),
            XtaskCommand::FuzzWorker { name } => fuzz::work(name).map(|()| Verdict::Passed),
            XtaskCommand::ParryWorker => encounters::parry::work().map(|()| Verdict::Passed),
            XtaskCommand::CapabilityWorker { variant, intervals } => {
                capability_cost::work(variant, *intervals)
            }
            XtaskCommand::Tidy => tidy::run(parse),
            XtaskCommand::Surface(options) => surface::run(options),
            XtaskCommand::Site(options) => site::run(options),
            XtaskCommand::Web(options) => web::run(options),
            XtaskCommand::Release(options) => release::run(options),
            XtaskCommand::Ci => ci::run(),
        }
    }
}
