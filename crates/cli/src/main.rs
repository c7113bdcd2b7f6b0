//! The program `carom`; see `carom --help`.

use std::process::ExitCode;

use carom_cli::Cli;

fn main() -> ExitCode {
    carom_runs::console::main::<Cli>()
}
