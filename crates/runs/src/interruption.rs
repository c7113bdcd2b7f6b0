//! Interruption by SIGINT (Ctrl-C) and SIGTERM: the program ends within a second and loses as
//! little work as possible.
//!
//! Guarantees:
//! - After the first signal each run has 0.8 s to reach the end of its epoch, where it writes a
//!   checkpoint and ends.
//! - The length of an epoch depends on the scene. After 0.8 s a separate thread truncates the files
//!   to the last checkpoint and ends the program.
//! - A second signal ends the program at once.
//! - A command that keeps nothing until its end ([`OnlyAtEnd`]) ends at the first signal.

use std::{
    io::{Write as _, stderr},
    process,
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

use crate::{
    append_file::CheckpointLengths,
    command_line::{self, given},
    json_object,
};

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
        let signals = Self::registered()?;
        let watching = signals.clone();
        in_background(move || watching.end_in_time())?;
        Ok(signals)
    }

    /// Installs the signal handlers: the first SIGINT or SIGTERM makes [`Self::check`] fail and
    /// does nothing else, for a program that looks often and ends by itself; a second signal ends
    /// it at once.
    ///
    /// # Errors
    /// The system refuses the handlers.
    pub fn registered() -> Result<Self> {
        let signals = Self::default();
        let impatient = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // The order matters: the second signal finds the flag that the first one sets.
            flag::register_conditional_shutdown(signal, exit_code(signal).into(), Arc::clone(&impatient))
                .and_then(|_| flag::register(signal, Arc::clone(&impatient)))
                .and_then(|_| flag::register_usize(signal, Arc::clone(&signals.received), signal as usize))
                .context("cannot watch for signals")?;
        }
        Ok(signals)
    }

    /// Waits for a signal and returns its number.
    fn wait(&self) -> i32 {
        loop {
            match self.check() {
                Ok(()) => thread::sleep(PAUSE),
                Err(Interrupted { signal }) => return signal,
            }
        }
    }

    /// Registers a run whose files are truncated to its last checkpoint if the program must end
    /// between two checkpoints.
    pub fn register(&self, run: SharedLengths) {
        let mut runs = self.runs.lock().unwrap_or_else(PoisonError::into_inner);
        // Runs that have ended have dropped theirs.
        runs.retain(|run| Arc::strong_count(run) > 1);
        runs.push(run);
    }

    /// Waits for a signal, then for [`GRACE`], and ends the program.
    fn end_in_time(&self) {
        let signal = self.wait();
        thread::sleep(GRACE);
        let deadline = Instant::now() + LAST_WRITES;
        let runs = self.runs.lock().unwrap_or_else(PoisonError::into_inner);
        // The guards are held until the process exits: no later checkpoint is written, and nothing
        // is written to a file that has been truncated.
        let checkpoints: Vec<_> =
            runs.iter().filter_map(|run| try_until(deadline, || run.try_lock().ok())).collect();
        let _cut: Vec<_> =
            checkpoints.iter().filter_map(|kept| try_until(deadline, || kept.cut_back())).collect();
        let words = format!(
            "interrupted by {} before the next checkpoint; the last checkpoint is kept. Resume with\n  {} --resume",
            name(signal),
            command()
        );
        end_now(words, signal);
    }

    /// Makes [`Self::check`] fail as after SIGINT, for a program that handles signals itself.
    pub fn interrupt(&self) {
        self.received.store(SIGINT as usize, Ordering::Relaxed);
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

/// Signals of a command that writes nothing until its end, and cannot be resumed.
#[derive(Debug)]
pub struct OnlyAtEnd {
    is_writing: Arc<Mutex<bool>>,
}

impl OnlyAtEnd {
    /// Installs the signal handlers. SIGINT or SIGTERM ends the program at once until
    /// [`Self::write`] is called.
    ///
    /// # Errors
    /// The system refuses the handlers.
    pub fn watch() -> Result<Self> {
        let signals = Signals::registered()?;
        let is_writing = Arc::new(Mutex::new(false));
        let watched = Arc::clone(&is_writing);
        in_background(move || {
            let signal = signals.wait();
            // Held until the process exits, so that no file is written meanwhile.
            let is_writing = watched.lock().unwrap_or_else(PoisonError::into_inner);
            if !*is_writing {
                let name = name(signal);
                let words =
                    format!("interrupted by {name}; nothing is kept. Start again with\n  {}", command());
                end_now(words, signal);
            }
        })?;
        Ok(Self { is_writing })
    }

    /// Marks the beginning of the output, which is short: a single signal no longer ends the
    /// program.
    pub fn write(&self) {
        *self.is_writing.lock().unwrap_or_else(PoisonError::into_inner) = true;
    }
}

/// Tries to get a lock until the deadline.
fn try_until<T>(deadline: Instant, lock: impl Fn() -> Option<T>) -> Option<T> {
    loop {
        let locked = lock();
        if locked.is_some() || Instant::now() >= deadline {
            return locked;
        }
        thread::sleep(PAUSE);
    }
}

fn in_background(watch: impl FnOnce() + Send + 'static) -> Result<()> {
    let thread = thread::Builder::new().name("signals".to_owned());
    thread.spawn(watch).map(drop).context("cannot watch for signals")
}

/// Ends the program with a message.
fn end_now(words: String, signal: i32) -> ! {
    let _ = writeln!(stderr(), "{words}");
    json_object::end(Err(words), exit_code(signal));
    process::exit(exit_code(signal).into());
}

/// The run received a signal and has written a checkpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("interrupted by {}; all results so far are kept. Resume with\n  {} --resume", name(self.signal), command())]
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

/// The command line without `--force` and `--resume`.
fn command() -> String {
    command_line::command(given().filter(|word| word != "--force" && word != "--resume"))
}
