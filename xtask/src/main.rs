//! `cargo xtask`: runs experiments and scenes, and checks the repository; see `cargo xtask --help`.

use std::process::ExitCode;

use xtask::cli::Cli;

fn main() -> ExitCode {
    carom_runs::console::main::<Cli>()
}
