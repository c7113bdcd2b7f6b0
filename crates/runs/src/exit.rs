//! Exit codes: 0 passed, 1 a check or the run failed, 2 invalid input, 3 parts of the data are
//! missing, 129, 130 or 143 a signal.

use std::fmt::Write as _;

use anyhow::{Error, Result};
use carom::RunError;
use carom_tables::Verdict;

use crate::interruption::Interrupted;

/// The error that ended a command, and errors after it, which it may have caused: on a full disk
/// the record of the failure cannot be written either.
#[derive(Debug, thiserror::Error)]
#[error("{cause:#}")]
pub struct Followed {
    cause: Error,
    later: Vec<Error>,
}

impl Followed {
    /// The error with those that followed, without repetitions of it.
    pub fn by(cause: Error, later: impl IntoIterator<Item = Error>) -> Error {
        let words = format!("{cause:#}");
        let later: Vec<Error> = later
            .into_iter()
            .filter(|error| format!("{error:#}") != words)
            .collect();
        if later.is_empty() {
            cause
        } else {
            Self { cause, later }.into()
        }
    }
}

/// The first cause of an error.
fn cause(error: &Error) -> &Error {
    error
        .downcast_ref()
        .map_or(error, |followed: &Followed| &followed.cause)
}

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
            None if cause(error)
                .chain()
                .any(<dyn std::error::Error>::is::<RunError>) =>
            {
                1
            }
            None => 2,
        },
    }
}

/// Returns the words of an error for the user: an interruption by itself, any other error with its
/// causes, then the errors that followed, one a line.
#[must_use]
pub fn words(error: &Error) -> String {
    let mut words =
        interruption(error).map_or_else(|| format!("error: {error:#}"), ToString::to_string);
    for later in error
        .downcast_ref()
        .iter()
        .flat_map(|followed: &&Followed| &followed.later)
    {
        let _ = write!(words, "\nnote: then {later:#}");
    }
    words
}

fn interruption(error: &Error) -> Option<&Interrupted> {
    cause(error).chain().find_map(|cause| cause.downcast_ref())
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::anyhow;

    #[test]
    fn the_first_cause_comes_first_and_determines_the_exit_code() {
        let full = || anyhow!("No space left").context("cannot write report.html");
        let cause = anyhow!("No space left").context("cannot write energy.csv");
        let error = Followed::by(cause, [full()]);
        assert_eq!(
            words(&error),
            "error: cannot write energy.csv: No space left\nnote: then cannot write report.html: No space left"
        );
        assert_eq!(code(&Err(error)), 2);
        let of_run = Followed::by(RunError::Time(f64::NAN).into(), [full()]);
        assert_eq!(code(&Err(of_run)), 1);
        assert_eq!(
            words(&Followed::by(full(), [full()])),
            "error: cannot write report.html: No space left"
        );
    }
}
