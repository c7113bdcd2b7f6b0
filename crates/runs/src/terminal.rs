//! Lines on standard output and standard error, and the first failure to write them.

use std::{
    io::{self, ErrorKind, Write as _, stderr, stdout},
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use anyhow::{Error, Result};

use crate::{json_object, progress};

/// Whether notes are left out.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// The first failure to write to standard output.
static LOST_OUTPUT: Mutex<Option<io::Error>> = Mutex::new(None);

/// What a failure to write to standard output is called.
pub(crate) const STANDARD_OUTPUT: &str = "cannot write to standard output";

/// Writes a line to standard output, and flushes it. The first failure is kept for the end of the
/// program.
pub(crate) fn write_line(text: &str) {
    let mut out = stdout().lock();
    keep_failure(writeln!(out, "{text}").and_then(|()| out.flush()));
}

/// Keeps the first failure to write to standard output; a closed pipe is none.
pub(crate) fn keep_failure(written: io::Result<()>) {
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
    {
        LOST_OUTPUT
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .get_or_insert(error);
    }
}

/// Takes the first failure to write to standard output.
pub(crate) fn lost_output() -> Result<()> {
    match LOST_OUTPUT
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .take()
    {
        None => Ok(()),
        Some(error) => Err(Error::new(error).context(STANDARD_OUTPUT)),
    }
}

/// Writes a line of results to standard output; into the array `text` of the JSON object, where one
/// is written.
pub fn print_line(text: &str) {
    if json_object::takes_line(text) {
        return;
    }
    progress::suspend(|| write_line(text));
}

/// Writes a remark for the user to standard error, unless the program is quiet.
pub fn note(text: &str) {
    if !IS_QUIET.load(Ordering::Relaxed) {
        progress::suspend(|| complain(text));
    }
}

/// Writes a line to standard error; a failure is ignored, since there is no other place for it.
pub(crate) fn complain(text: &str) {
    let _ = writeln!(stderr(), "{text}");
}

/// Leaves notes out from now on, or not.
pub(crate) fn set_quiet(is_quiet: bool) {
    IS_QUIET.store(is_quiet, Ordering::Relaxed);
}
