//! Exit codes: 0 passed, 1 a check or the run failed, 2 invalid input, 130 or 143 a signal.

use std::process::ExitCode;

use anyhow::Result;
use carom::RunError;
use carom_tables::Verdict;

use crate::interruption::Interrupted;

/// Returns the exit code for the end of a program; an error is written to standard error.
#[must_use]
pub fn code(end: &Result<Verdict>) -> ExitCode {
    match end {
        Ok(Verdict::Passed) => ExitCode::SUCCESS,
        Ok(Verdict::Failed) => ExitCode::from(1),
        Err(error) => {
            if let Some(interrupted) = error.chain().find_map(|cause| cause.downcast_ref::<Interrupted>()) {
                eprintln!("{interrupted}");
                return ExitCode::from(interrupted.exit_code());
            }
            eprintln!("error: {error:#}");
            // A run that fails is a failed check; every other error is invalid input.
            let broke_off = error.chain().any(<dyn std::error::Error>::is::<RunError>);
            ExitCode::from(if broke_off { 1 } else { 2 })
        }
    }
}
