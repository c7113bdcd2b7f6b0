//! `cargo xtask`: runs experiments and scenes, and checks the repository; see `cargo xtask --help`.

use std::process::ExitCode;

use clap::Parser as _;
use xtask::cli::Cli;

fn main() -> ExitCode {
    carom_runs::exit::code(&Cli::parse().run())
}
