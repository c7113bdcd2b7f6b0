//! `cargo xtask attack`: attacks the program as a process and compares what is left with an
//! undisturbed run.
//!
//! | kind | attack |
//! | --- | --- |
//! | [`kills`] | signals at random moments, then `--resume` until the end |
//! | [`faults`] | each call of the file system fails once, then a repeat |
//! | [`power`] | losses of power: what is not flushed to disk is taken away, then a resume |
//! | [`machines`] | two processes in one folder, with and without locks |
//! | [`files`] | mutated files in front of every command |
//!
//! A run has a seed, from which all cases follow. A case that fails is reduced and written to a
//! file with the command that replays it.

pub mod campaign;
pub mod faults;
pub mod files;
pub mod folder;
pub mod kills;
pub mod machines;
pub mod power;
pub mod preload;
pub mod process;
pub mod targets;

use std::{
    path::{Path, PathBuf},
    thread,
};

use anyhow::{Context as _, Result, ensure};
use carom_runs::print_line;
use carom_tables::Verdict;
use carom_testkit::skipped::skipped;
use clap::{Args, ValueEnum};

use self::{
    campaign::{Attack, Rows},
    faults::Faults,
    files::Files,
    kills::Kills,
    machines::Machines,
    power::Power,
    preload::Library,
    targets::References,
};

/// Kinds of attacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AttackKind {
    /// Signals at random moments
    Kills,
    /// Calls of the file system that fail
    Faults,
    /// Losses of power
    Power,
    /// Two processes in one folder
    Machines,
    /// Mutated files
    Files,
}

/// Options of the attacks.
#[derive(Debug, Clone, Args)]
pub struct AttackOptions {
    /// Kinds of attacks
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_values_t = [AttackKind::Kills, AttackKind::Faults, AttackKind::Power, AttackKind::Machines, AttackKind::Files]
    )]
    pub kinds: Vec<AttackKind>,
    /// Seed of the run
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Number of cases, as a factor of the whole attack
    #[arg(long, default_value_t = 1.0)]
    pub times: f64,
    /// Number of cases run at once; default: one for each processor
    #[arg(long)]
    pub threads: Option<usize>,
    /// Run the case in this file, written after a failure; its folder is kept beside the file
    #[arg(long, value_name = "FILE")]
    pub replay: Option<PathBuf>,
    /// Folder for failing cases
    #[arg(long, default_value = "out/attack")]
    pub out: PathBuf,
}

/// Largest factor.
const MAX_TIMES: f64 = 1000.0;

/// Runs the attacks and prints a table of what held.
///
/// # Errors
/// An option is out of range, an undisturbed run fails, or a file cannot be written.
pub fn run(options: &AttackOptions) -> Result<Verdict> {
    ensure!(
        options.times > 0.0 && options.times <= MAX_TIMES,
        "--times must be positive and at most {MAX_TIMES}, but is {}",
        options.times
    );
    ensure!(
        options.replay.is_none() || options.kinds.len() == 1,
        "--replay runs a case of one kind: name it with --kinds"
    );
    let mut rows = Rows::new();
    for kind in &options.kinds {
        rows.extend(attack(*kind, options)?);
    }
    print_line("| attack | tried | held | failed |");
    print_line("| --- | --- | --- | --- |");
    for (name, row) in &rows {
        print_line(&format!(
            "| {name} | {} | {} | {} |",
            row.tried,
            row.tried - row.failed,
            row.failed
        ));
    }
    let tried: u64 = rows.values().map(|row| row.tried).sum();
    let failed: u64 = rows.values().map(|row| row.failed).sum();
    print_line(&format!(
        "| all | {tried} | {} | {failed} |",
        tried - failed
    ));
    Ok(if failed == 0 {
        Verdict::Passed
    } else {
        Verdict::Failed
    })
}

fn attack(kind: AttackKind, options: &AttackOptions) -> Result<Rows> {
    let kept = options.replay.as_deref().map(kept);
    let references = References::new(kept.clone());
    if !cfg!(unix) {
        skipped(&format!("attack {kind:?}"), "signals are those of Unix");
        return Ok(Rows::new());
    }
    let with_library = |kind: AttackKind| match Library::build() {
        Ok(library) => Some(library),
        Err(error) => {
            skipped(&format!("attack {kind:?}"), format!("{error:#}"));
            None
        }
    };
    match kind {
        AttackKind::Kills => rows_of(&Kills { references }, options),
        AttackKind::Files => rows_of(&Files::new(kept), options),
        AttackKind::Faults | AttackKind::Power | AttackKind::Machines => {
            match (kind, with_library(kind)) {
                (_, None) => Ok(Rows::new()),
                (AttackKind::Faults, Some(library)) => rows_of(
                    &Faults {
                        references,
                        library,
                    },
                    options,
                ),
                (AttackKind::Power, Some(library)) => rows_of(
                    &Power {
                        references,
                        library,
                    },
                    options,
                ),
                (_, Some(library)) => rows_of(
                    &Machines {
                        references,
                        library,
                    },
                    options,
                ),
            }
        }
    }
}

/// The folder in which a case is replayed: beside its file.
fn kept(file: &Path) -> PathBuf {
    file.with_extension("replayed")
}

fn rows_of<A: Attack>(attack: &A, options: &AttackOptions) -> Result<Rows> {
    if let Some(file) = &options.replay {
        return campaign::replay(attack, file);
    }
    let count = (options.times * A::FULL as f64).ceil() as u64;
    let cases = attack
        .cases(options.seed, count)
        .with_context(|| format!("attack {}", A::NAME))?;
    let threads = options
        .threads
        .unwrap_or_else(|| thread::available_parallelism().map_or(1, usize::from));
    campaign::run(attack, &cases, threads, &options.out)
}
