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
//! hold all results. Any other failure, such as a full disk, ends the command with an error.
//! Nothing
//! is coloured except by the parser of the command line, which heeds `NO_COLOR`.

use std::{
    env,
    io::{Write as _, stdout},
    process::ExitCode,
};

use anyhow::Result;
use carom_tables::{Summary, Verdict, are_stationary};
use clap::{ArgMatches, Args, Command, Parser};

use crate::{
    exit, json_object,
    output::Folder,
    progress,
    terminal::{self, complain, keep_failure, lost_output, write_line},
};
pub use crate::{
    json_object::{is_json, put},
    terminal::{note, print_line},
};

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

/// Parses the command line, runs the command, and writes what it ends with. Returns the exit code,
/// see [`exit::code`].
pub fn main<P: Program>() -> ExitCode {
    let parsed = with_negative_numbers(P::command())
        .try_get_matches()
        .and_then(|matches| {
            let name = name(&matches);
            P::from_arg_matches(&matches).map(|program| (program, name))
        });
    let (program, name) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => return refuse(&error),
    };
    let Console { quiet, json } = program.console();
    terminal::set_quiet(quiet);
    if json {
        json_object::start(&name);
    }
    let shown = if quiet || !program.shows_progress() {
        None
    } else {
        progress::show(&name)
    };
    let end = program
        .run()
        .and_then(|verdict| lost_output().map(|()| verdict));
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
        json_object::start("");
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

/// Adds the folder, page, totals and checks of a run to the object; [`conclude`](crate::conclude)
/// does so.
pub fn put_summary(folder: &Folder, summary: &Summary) {
    put("title", &summary.title);
    put("folder", &folder.path());
    put("page", &folder.path().join("report.html"));
    put("totals", &summary.totals);
    put("checks", &summary.checks);
    put("figures", &summary.figures);
    put("stationary", &are_stationary(&summary.figures));
}
