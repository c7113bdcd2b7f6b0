//! Interruption by SIGINT (Ctrl-C) and SIGTERM: the program ends within a second and loses as
//! little work as possible.
//!
//! Guarantees:
//! - After the first signal each run has 0.8 s to reach the end of its epoch, where it writes a
//!   checkpoint and ends.
//! - The length of an epoch depends on the scene. After 0.8 s a separate thread truncates the files
//!   to the last checkpoint and ends the program.
//! - A second signal ends the program at once.

use std::{
    env, process,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use signal_hook::{
    consts::{SIGINT, SIGTERM},
    flag,
};
use thiserror::Error;

use crate::{append_file::CheckpointLengths, manifest::program};

/// Time that runs have to reach a checkpoint after a signal. Longer: the program does not end
/// within a second. Shorter: more work is repeated.
const GRACE: Duration = Duration::from_millis(800);

/// Further time until files can be truncated, while they are still written.
const LAST_WRITES: Duration = Duration::from_millis(100);

/// Interval between two checks for a signal or for a free lock.
const PAUSE: Duration = Duration::from_millis(20);

/// File lengths of one run at its last checkpoint. Locked while a checkpoint is written.
pub type SharedLengths = Arc<Mutex<CheckpointLengths>>;

/// Registers SIGINT and SIGTERM and returns whether one has been received.
#[derive(Debug, Clone, Default)]
pub struct Signals {
    received: Arc<AtomicUsize>,
    runs: Arc<Mutex<Vec<SharedLengths>>>,
}

impl Signals {
    /// Installs the signal handlers. The first SIGINT or SIGTERM makes [`Self::check`] fail and
    /// ends the program within a second; a second signal ends it at once.
    ///
    /// # Errors
    /// The system refuses the handlers.
    pub fn watch() -> Result<Self> {
        let signals = Self::default();
        let impatient = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // The order matters: the second signal finds the flag that the first one sets.
            flag::register_conditional_shutdown(signal, exit_code(signal).into(), Arc::clone(&impatient))
                .and_then(|_| flag::register(signal, Arc::clone(&impatient)))
                .and_then(|_| flag::register_usize(signal, Arc::clone(&signals.received), signal as usize))
                .context("cannot watch for signals")?;
        }
        let watching = signals.clone();
        thread::Builder::new()
            .name("signals".to_owned())
            .spawn(move || watching.end_in_time())
            .context("cannot watch for signals")?;
        Ok(signals)
    }

    /// Registers a run whose files are truncated to its last checkpoint if the program must end
    /// between two checkpoints.
    pub fn register(&self, run: SharedLengths) {
        self.runs.lock().unwrap_or_else(PoisonError::into_inner).push(run);
    }

    /// Waits for a signal, then for [`GRACE`], and ends the program.
    fn end_in_time(&self) {
        let Interrupted { signal } = loop {
            match self.check() {
                Ok(()) => thread::sleep(PAUSE),
                Err(interrupted) => break interrupted,
            }
        };
        thread::sleep(GRACE);
        let deadline = Instant::now() + LAST_WRITES;
        let runs = self.runs.lock().unwrap_or_else(PoisonError::into_inner);
        // The locks are held until the process exits, so no later checkpoint is written.
        let mut cut = Vec::new();
        for run in runs.iter() {
            loop {
                if let Ok(kept) = run.try_lock() {
                    kept.cut_back();
                    cut.push(kept);
                    break;
                }
                if Instant::now() >= deadline {
                    break;
                }
                thread::sleep(PAUSE);
            }
        }
        eprintln!(
            "interrupted by {} before the next checkpoint; the last checkpoint is kept. Resume with\n  {}",
            name(signal),
            resume_command()
        );
        process::exit(exit_code(signal).into());
    }

    /// Returns an error if a signal has been received.
    ///
    /// # Errors
    /// [`Interrupted`].
    pub fn check(&self) -> Result<(), Interrupted> {
        match self.received.load(Ordering::Relaxed) {
            0 => Ok(()),
            signal => Err(Interrupted { signal: signal as i32 }),
        }
    }
}

/// The run received a signal and has written a checkpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("interrupted by {}; all results so far are kept. Resume with\n  {}", name(self.signal), resume_command())]
pub struct Interrupted {
    signal: i32,
}

impl Interrupted {
    /// Exit code of an interrupted program: 128 plus the number of the signal, the convention of
    /// shells.
    pub fn exit_code(self) -> u8 {
        exit_code(self.signal)
    }
}

fn exit_code(signal: i32) -> u8 {
    128 + signal as u8
}

fn name(signal: i32) -> &'static str {
    if signal == SIGINT { "SIGINT" } else { "SIGTERM" }
}

/// The command line with `--resume`.
fn resume_command() -> String {
    let given = env::args().skip(1).filter(|word| word != "--force" && word != "--resume");
    let quoted = |word: String| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+".contains(c);
        let is_plain = !word.is_empty() && word.chars().all(plain);
        if is_plain { word } else { format!("'{}'", word.replace('\'', "'\\''")) }
    };
    let words: Vec<String> = given.map(quoted).collect();
    format!("{} {} --resume", program(), words.join(" "))
}
