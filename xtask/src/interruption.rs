//! Being asked to end: SIGINT (Ctrl-C) and SIGTERM let a run come to its next checkpoint.

use std::{
    env,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
};

use anyhow::{Context, Result};
use signal_hook::{
    consts::{SIGINT, SIGTERM},
    flag,
};
use thiserror::Error;

/// Tells whether the program has been asked to end.
#[derive(Debug, Clone, Default)]
pub struct Signals {
    received: Arc<AtomicUsize>,
}

impl Signals {
    /// From now on the first SIGINT or SIGTERM is kept for [`Self::check`]; a second ends the program at once.
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
        Ok(signals)
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
