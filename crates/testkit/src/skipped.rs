//! Reports tests that are skipped because the machine lacks a feature, so that they can be counted.

use std::{env, fmt::Display, fs::OpenOptions, io::Write as _};

/// Reports that a test is skipped: on standard error, and as a line of the file that the
/// environment variable `CAROM_SKIPPED` names, if it is set.
///
/// # Panics
/// If either cannot be written.
pub fn skipped(test: &str, reason: impl Display) {
    let line = format!("skipped: {test}: {reason}\n");
    // Not `eprintln!`: the test harness captures its output for passing tests.
    std::io::stderr().write_all(line.as_bytes()).unwrap();
    if let Some(list) = env::var_os("CAROM_SKIPPED") {
        let mut list = OpenOptions::new()
            .append(true)
            .create(true)
            .open(list)
            .unwrap();
        list.write_all(line.as_bytes()).unwrap();
    }
}
