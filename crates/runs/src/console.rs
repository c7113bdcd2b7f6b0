//! What a program writes to the terminal: results, notes, progress and errors, or one JSON object.
//!
//! The function [`main`] is the common start of `carom` and `cargo xtask`. It gives every command
//! progress, `--quiet` and `--json`; a new command calls [`print_line`], [`note`],
//! [`conclude`](crate::conclude) and [`put`], and shows what takes long by
//! [`Progress`](crate::progress::Progress).
//!
//! | | standard output | standard error |
//! | --- | --- | --- |
//! | by default | results | progress, notes, errors |
//! | `--quiet` | results | errors |
//! | `--json` | one JSON object | progress, notes, errors |
//!
//! Everything on standard output is written by one function. A closed pipe is no error: the files
//! hold all results. Any other failure, such as a full disk, ends the command with an error. Nothing
//! is coloured except by the parser of the command line, which heeds `NO_COLOR`.

use std::{
    env,
    io::{self, ErrorKind, Write as _, stderr, stdout},
    process::ExitCode,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use anyhow::{Error, Result};
use carom_tables::Verdict;
use clap::{ArgMatches, Args, Command, Parser};

pub use crate::json_object::{is_json, put, put_summary};
use crate::{exit, json_object, progress};

/// What a program writes besides its files.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct Console {
    /// Write no progress and no notes; errors stay
    #[arg(long, global = true)]
    pub quiet: bool,
    /// Write one JSON object instead of text: command, folder, verdict, totals, checks, exit code,
    /// or the error
    #[arg(long, global = true)]
    pub json: bool,
}

/// The command line of a program.
pub trait Program: Parser {
    /// What it writes.
    fn console(&self) -> Console;

    /// Whether progress is shown: not where a command is a part of another one, or shows its own.
    fn shows_progress(&self) -> bool {
        true
    }

    /// Runs the command.
    ///
    /// # Errors
    /// Invalid input, or a run that fails.
    fn run(&self) -> Result<Verdict>;
}

/// Whether notes are left out.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// The first failure to write to standard output.
static LOST_OUTPUT: Mutex<Option<io::Error>> = Mutex::new(None);

/// What a failure to write to standard output is called.
const STANDARD_OUTPUT: &str = "cannot write to standard output";

/// Parses the command line, runs the command, and writes what it ends with. Returns the exit code,
/// see [`exit::code`].
pub fn main<P: Program>() -> ExitCode {
    let parsed = with_negative_numbers(P::command()).try_get_matches().and_then(|matches| {
        let name = name(&matches);
        P::from_arg_matches(&matches).map(|program| (program, name))
    });
    let (program, name) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => return refuse(&error),
    };
    let Console { quiet, json } = program.console();
    IS_QUIET.store(quiet, Ordering::Relaxed);
    if json {
        json_object::begin(&name);
    }
    let shown = if quiet || !program.shows_progress() { None } else { progress::show(&name) };
    let end = program.run().and_then(|verdict| lost_output().map(|()| verdict));
    drop(shown);
    if let Err(error) = &end {
        complain(&exit::words(error));
    }
    let code = exit::code(&end);
    let has_failed = end.is_err();
    if let Some(object) = json_object::end(end.map_err(|error| exit::words(&error)), code) {
        write_line(&object);
    }
    match lost_output() {
        Err(error) if !has_failed => {
            complain(&exit::words(&error));
            ExitCode::from(exit::code(&Err(error)))
        }
        _ => ExitCode::from(code),
    }
}

/// Writes a line to standard error; a failure is ignored, since there is no other place for it.
fn complain(text: &str) {
    let _ = writeln!(stderr(), "{text}");
}

/// Lets the values of all options be negative numbers, so that a command refuses them by its own
/// words.
fn with_negative_numbers(command: Command) -> Command {
    let command = command.mut_args(|argument| {
        let has_value = !argument.is_positional() && argument.get_action().takes_values();
        argument.allow_negative_numbers(has_value)
    });
    command.mut_subcommands(with_negative_numbers)
}

/// The command with its subcommands, such as `run`.
fn name(matches: &ArgMatches) -> String {
    let mut names = Vec::new();
    let mut matches = Some(matches);
    while let Some((name, inner)) = matches.and_then(ArgMatches::subcommand) {
        names.push(name);
        matches = Some(inner);
    }
    names.join(" ")
}

/// Ends a program whose command line is invalid, or requests help or the version.
fn refuse(error: &clap::Error) -> ExitCode {
    let printed = error.print().and_then(|()| stdout().flush());
    let mut code = u8::try_from(error.exit_code()).unwrap_or(2);
    if code != 0 && env::args_os().any(|word| word == "--json") {
        json_object::begin("");
        let words = error.to_string().trim_end().to_owned();
        if let Some(object) = json_object::end(Err(words), code) {
            write_line(&object);
        }
    }
    if code == 0 {
        keep_failure(printed);
    }
    if let Err(error) = lost_output() {
        complain(&exit::words(&error));
        code = code.max(exit::code(&Err(error)));
    }
    ExitCode::from(code)
}

/// Writes a line to standard output, and flushes it. The first failure is kept for the end of the
/// program.
pub(crate) fn write_line(text: &str) {
    let mut out = stdout().lock();
    keep_failure(writeln!(out, "{text}").and_then(|()| out.flush()));
}

/// Keeps the first failure to write to standard output; a closed pipe is none.
fn keep_failure(written: io::Result<()>) {
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
    {
        LOST_OUTPUT.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// Takes the first failure to write to standard output.
fn lost_output() -> Result<()> {
    match LOST_OUTPUT.lock().unwrap_or_else(PoisonError::into_inner).take() {
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
