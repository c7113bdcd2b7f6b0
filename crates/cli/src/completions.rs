//! `carom completions`: completions of commands and options for a shell, and the manual page.

use std::io::Write as _;

use anyhow::{Context as _, Result};
use carom_tables::Verdict;
use clap::{Args, CommandFactory as _, ValueEnum};
use clap_complete::{Shell, generate};

use crate::Cli;

/// What is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum For {
    /// Completions for bash
    Bash,
    /// Completions for zsh
    Zsh,
    /// Completions for fish
    Fish,
    /// Completions for PowerShell
    Powershell,
    /// Completions for Elvish
    Elvish,
    /// The manual page, in the format of man
    Man,
}

/// Options of `carom completions`.
#[derive(Debug, Clone, Args)]
pub struct CompletionsOptions {
    /// The shell, or `man` for the manual page
    #[arg(value_enum)]
    of: For,
}

/// Prints the completions or the manual page to standard output.
///
/// # Errors
/// Standard output cannot be written.
pub fn run(options: &CompletionsOptions) -> Result<Verdict> {
    let mut text = Vec::new();
    let shell = match options.of {
        For::Bash => Some(Shell::Bash),
        For::Zsh => Some(Shell::Zsh),
        For::Fish => Some(Shell::Fish),
        For::Powershell => Some(Shell::PowerShell),
        For::Elvish => Some(Shell::Elvish),
        For::Man => None,
    };
    match shell {
        Some(shell) => generate(shell, &mut Cli::command(), "carom", &mut text),
        None => clap_mangen::Man::new(Cli::command()).render(&mut text)?,
    }
    let mut out = std::io::stdout().lock();
    out.write_all(&text)
        .and_then(|()| out.flush())
        .context("cannot write to standard output")?;
    Ok(Verdict::Passed)
}
