//! Exit codes: 0 passed, 1 a check or the run failed, 2 invalid input, 3 parts of the data are
//! missing, 129, 130 or 143 a signal.

use anyhow::{Error, Result};
use carom::RunError;
use carom_tables::Verdict;

use crate::interruption::Interrupted;

/// Returns the exit code for the end of a command.
#[must_use]
pub fn code(end: &Result<Verdict>) -> u8 {
    match end {
        Ok(Verdict::Passed) => 0,
        Ok(Verdict::Failed) => 1,
        Ok(Verdict::Incomplete) => 3,
        Err(error) => match interruption(error) {
            Some(interrupted) => interrupted.exit_code(),
            // A run that fails is a failed check; every other error is invalid input.
            None if error.chain().any(<dyn std::error::Error>::is::<RunError>) => 1,
            None => 2,
        },
    }
}

/// Returns the words of an error for the user: an interruption by itself, any other error with its
/// causes.
#[must_use]
pub fn words(error: &Error) -> String {
    interruption(error).map_or_else(|| format!("error: {error:#}"), ToString::to_string)
}

fn interruption(error: &Error) -> Option<&Interrupted> {
    error.chain().find_map(|cause| cause.downcast_ref())
}
