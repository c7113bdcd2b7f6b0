//! The repository from which this program was built, and the programs that its commands call.

use std::{
    env, fs,
    path::{Path, PathBuf},
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

/// The folder of what cargo builds.
///
/// # Errors
/// The crate has been moved out of the repository.
pub fn target_folder() -> Result<PathBuf> {
    let given = env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    given.map_or_else(|| Ok(root()?.join("target")), Ok)
}

/// Copies a folder with all that it holds into another one.
///
/// # Errors
/// A file cannot be read or written.
pub fn copy_folder(from: &Path, to: &Path) -> Result<()> {
    let unreadable = || format!("cannot read the folder {}", from.display());
    fs::create_dir_all(to).with_context(|| format!("cannot create {}", to.display()))?;
    for entry in fs::read_dir(from).with_context(unreadable)? {
        let path = entry.with_context(unreadable)?.path();
        let Some(name) = path.file_name() else {
            continue;
        };
        if path.is_dir() {
            copy_folder(&path, &to.join(name))?;
        } else {
            fs::copy(&path, to.join(name))
                .with_context(|| format!("cannot copy {}", path.display()))?;
        }
    }
    Ok(())
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
