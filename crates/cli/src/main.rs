//! The program `carom`; see `carom --help`.

use std::process::ExitCode;

use carom_cli::Cli;
use clap::Parser as _;

fn main() -> ExitCode {
    carom_runs::exit::code(&Cli::parse().run())
}
