//! Being asked to end: SIGINT (Ctrl-C) and SIGTERM let a run come to its next checkpoint, for most
//! of a second.
//!
//! A run is asked at the end of each epoch, where it can be written down. How long an epoch takes
//! depends on the scene, so a thread of its own ends the program if that has not happened in time:
//! the last checkpoint then counts, and files that have grown since are cut back to it.

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

use crate::append_file::Kept;

/// How long runs have to come to a checkpoint after a signal. Longer: the program does not end
/// within a second. Shorter: more is run twice.
const GRACE: Duration = Duration::from_millis(800);

/// How long files may still be written after that, until they can be cut back.
const LAST_WRITES: Duration = Duration::from_millis(100);

/// Between two looks for a signal, and for files to be cut back.
const PAUSE: Duration = Duration::from_millis(20);

/// The files of one run, as its last checkpoint has them. Locked while a checkpoint is written.
pub type SharedKept = Arc<Mutex<Kept>>;

/// Tells whether the program has been asked to end.
#[derive(Debug, Clone, Default)]
pub struct Signals {
    received: Arc<AtomicUsize>,
    runs: Arc<Mutex<Vec<SharedKept>>>,
}

impl Signals {
    /// From now on the first SIGINT or SIGTERM is kept for [`Self::check`], and the program ends
    /// within a second; a second signal ends it at once.
    ///
    /// # Errors
    /// The system does not let signals be watched.
    pub fn watch() -> Result<Self> {
        let signals = Self::default();
        let impatient = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order: what the first one sets, the second one finds.
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

    /// Has the files of a run cut back to its last checkpoint where the program must end between
    /// two.
    pub fn register(&self, run: SharedKept) {
        self.runs.lock().unwrap_or_else(PoisonError::into_inner).push(run);
    }

    /// Waits for a signal, gives runs the time to end by themselves, and ends the program.
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
        // The locks are kept to the end: no checkpoint is written from here on.
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
            "interrupted by {} before the next checkpoint; what was done until the last one is kept. Go on with\n  {}",
            name(signal),
            again()
        );
        process::exit(exit_code(signal).into());
    }

    /// Fails if the program has been asked to end.
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

/// A run has been asked to end, and has left a checkpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("interrupted by {}; all that was done is kept. Go on with\n  {}", name(self.signal), again())]
pub struct Interrupted {
    signal: i32,
}

impl Interrupted {
    /// What the program answers to whoever started it: 128 and the number of the signal, as shells have it.
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

/// The command as it was given, to go on.
fn again() -> String {
    let given = env::args().skip(1).filter(|word| word != "--force" && word != "--resume");
    let quoted = |word: String| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+".contains(c);
        if word.chars().all(plain) { word } else { format!("'{word}'") }
    };
    let words: Vec<String> = given.map(quoted).collect();
    format!("cargo xtask {} --resume", words.join(" "))
}
