//! The repository from which this program was built, and the programs that its commands call.

use std::{
    env,
    path::Path,
    process::{Command, Stdio},
};

use anyhow::{Context, Result, ensure};

/// The folder of the repository.
///
/// # Errors
/// The crate has been moved out of it.
pub fn root() -> Result<&'static Path> {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .context("xtask lies inside the repository")
}

/// Whether a program of this name is in a folder of the variable PATH.
pub fn has_program(name: &str) -> bool {
    let paths = env::var_os("PATH").unwrap_or_default();
    env::split_paths(&paths).any(|folder| folder.join(name).is_file())
}

/// Runs programs in the folder of the repository.
#[derive(Debug, Clone, Copy)]
pub struct Shell<'a> {
    /// The folder in which programs run.
    pub root: &'a Path,
}

impl Shell<'_> {
    fn command(self, program: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(program);
        command.args(arguments).current_dir(self.root);
        command
    }

    /// Runs a program, whose output goes to the terminal.
    ///
    /// # Errors
    /// It cannot be started, or fails.
    pub fn succeed(self, program: &str, arguments: &[&str]) -> Result<()> {
        let shown = format!("{program} {}", arguments.join(" "));
        let mut command = self.command(program, arguments);
        let status = command
            .stdin(Stdio::null())
            .status()
            .with_context(|| format!("cannot start `{shown}`"))?;
        ensure!(status.success(), "`{shown}` failed: {status}");
        Ok(())
    }

    /// What a program writes to its standard output.
    ///
    /// # Errors
    /// It cannot be started, fails, or writes no text; the error has what it complains about.
    pub fn output(self, program: &str, arguments: &[&str]) -> Result<String> {
        let shown = format!("{program} {}", arguments.join(" "));
        let output = self
            .command(program, arguments)
            .stdin(Stdio::null())
            .output()
            .with_context(|| format!("cannot start `{shown}`"))?;
        ensure!(
            output.status.success(),
            "`{shown}` failed: {}: {}",
            output.status,
            String::from_utf8_lossy(&output.stderr).trim()
        );
        String::from_utf8(output.stdout).with_context(|| format!("`{shown}` writes no text"))
    }
}
