//! `cargo xtask`: runs experiments and scenes, and checks the repository; see `cargo xtask --help`.

use std::process::ExitCode;

use carom::RunError;
use clap::Parser as _;
use xtask::{cli::Cli, interruption::Interrupted, summary::Verdict};

fn main() -> ExitCode {
    match Cli::parse().run() {
        Ok(Verdict::Passed) => ExitCode::SUCCESS,
        Ok(Verdict::Failed) => ExitCode::from(1),
        Err(error) => {
            if let Some(interrupted) = error.chain().find_map(|cause| cause.downcast_ref::<Interrupted>()) {
                eprintln!("{interrupted}");
                return ExitCode::from(interrupted.exit_code());
            }
            eprintln!("error: {error:#}");
            // A run that broke off is a check that failed; all else is input that makes no sense.
            let broke_off = error.chain().any(<dyn std::error::Error>::is::<RunError>);
            ExitCode::from(if broke_off { 1 } else { 2 })
        }
    }
}
