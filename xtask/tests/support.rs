//! Running the program under test, and other programs that read what it writes.

use std::{
    path::Path,
    process::{Command, Output},
};

/// Runs the program.
pub fn xtask(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// Runs the program in a folder; it must succeed.
pub fn xtask_in(folder: &Path, arguments: &[&str]) {
    succeeding(
        Command::new(env!("CARGO_BIN_EXE_xtask"))
            .current_dir(folder)
            .args(arguments),
    );
}

/// Runs a command that must succeed.
pub fn succeeding(command: &mut Command) -> Output {
    let output = command.output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    output
}
