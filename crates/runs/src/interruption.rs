//! Interruption by SIGINT (Ctrl-C), SIGTERM and SIGHUP (a terminal that closes): the program ends
//! within a second and loses as little work as possible.
//!
//! Guarantees:
//! - After the first signal each run has 0.8 s to reach the end of its epoch, where it writes a
//!   checkpoint and ends.
//! - The length of an epoch depends on the scene. After 0.8 s a separate thread truncates the files
//!   to the last checkpoint and ends the program.
//! - A second signal ends the program at once, with a message. A program that holds its results in
//!   memory ([`Signals::while_saving`]) has some seconds to save them first.
//! - A command that keeps nothing until its end ([`OnlyAtEnd`]) ends at the first signal.
//! - SIGHUP is left alone where it is ignored, as under `nohup`.
//!
//! Signals that arrive within 20 ms count as one: some programs (`timeout`) send each signal to the
//! process and to its group.

use std::{
    io::{self, Write as _, stderr},
    process,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
    time::Duration,
};

use anyhow::{Context, Result};
#[cfg(unix)]
use signal_hook::consts::SIGHUP;
#[cfg(any(unix, windows))]
use signal_hook::{
    consts::{SIGINT, SIGTERM},
    flag,
};
use thiserror::Error;

use crate::{
    append_file::CheckpointLengths,
    clock::Instant,
    command_line::{self, given},
    json_object,
    terminal::write_line,
};

/// Numbers of the signals where the system has none, as in WebAssembly.
#[cfg(not(any(unix, windows)))]
const SIGINT: i32 = 2;
#[cfg(not(any(unix, windows)))]
const SIGTERM: i32 = 15;

/// Time that runs have to reach a checkpoint after a signal. Longer: the program does not end
/// within a second. Shorter: more work is repeated.
const GRACE: Duration = Duration::from_millis(800);

/// Time after the first signal in which further ones do not end a program that saves its results.
/// Longer: a program whose disk does not answer cannot be ended. Shorter: impatience loses a run.
const TIME_TO_SAVE: Duration = Duration::from_secs(10);

/// Further time until files can be truncated, while they are still written.
const LAST_WRITES: Duration = Duration::from_millis(100);

/// Interval between two checks for a signal or for a free lock.
const PAUSE: Duration = Duration::from_millis(20);

/// File lengths of one run at its last checkpoint. Locked while a checkpoint is written.
pub type SharedLengths = Arc<Mutex<CheckpointLengths>>;

/// Registers the signals that end a program and returns whether one has been received.
#[derive(Debug, Clone, Default)]
pub struct Signals {
    /// Number of the last signal; 0 before the first.
    received: Arc<AtomicUsize>,
    /// Number of the last signal that [`Self::take`] has not returned; 0 if there is none.
    pending: Arc<AtomicUsize>,
    runs: Arc<Mutex<Vec<SharedLengths>>>,
}

impl Signals {
    /// Installs the signal handlers. The first signal makes [`Self::check`] fail and ends the
    /// program within a second; a second signal ends it at once.
    ///
    /// # Errors
    /// The system refuses the handlers.
    pub fn watch() -> Result<Self> {
        let signals = Self::registered()?;
        let watching = signals.clone();
        in_background(move || watching.end_in_time())?;
        Ok(signals)
    }

    /// Installs the signal handlers for a program that checks often, saves its results after the
    /// first signal, and ends by itself. A further signal in the next ten seconds is answered with
    /// a message; a later one ends the program. `remains` is the part of the last message that says
    /// what has been saved before.
    ///
    /// # Errors
    /// The system refuses the handlers.
    pub fn while_saving(remains: String) -> Result<Self> {
        let signals = Self::registered()?;
        let watching = signals.clone();
        in_background(move || {
            watching.next();
            let begun = Instant::now();
            loop {
                let signal = watching.next();
                let left = TIME_TO_SAVE.saturating_sub(begun.elapsed());
                if left.is_zero() {
                    let name = name(signal);
                    end_now(
                        format!("ended by a further {name} before the run was saved; {remains}"),
                        signal,
                    );
                }
                let left = left.as_secs_f64().ceil();
                let _ = writeln!(
                    stderr(),
                    "The run is being saved. A signal after {left} more seconds ends the program without that."
                );
            }
        })?;
        Ok(signals)
    }

    /// Installs the signal handlers: each signal makes [`Self::check`] fail and [`Self::take`]
    /// return it once.
    fn registered() -> Result<Self> {
        let signals = Self::default();
        for signal in watched() {
            for number in [&signals.received, &signals.pending] {
                set_on(signal, Arc::clone(number)).context("cannot watch for signals")?;
            }
        }
        Ok(signals)
    }

    /// A signal since the last call, if there was one.
    fn take(&self) -> Option<i32> {
        Some(self.pending.swap(0, Ordering::Relaxed) as i32).filter(|&signal| signal != 0)
    }

    /// Waits for the next signal and returns its number.
    fn next(&self) -> i32 {
        loop {
            match self.take() {
                Some(signal) => return signal,
                None => thread::sleep(PAUSE),
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

    /// Waits for a signal, then for [`GRACE`] or a second signal, and ends the program.
    fn end_in_time(&self) {
        let first = self.next();
        // Sent twice at once: one request, not impatience.
        thread::sleep(PAUSE);
        self.take();
        let second = try_until(Instant::now() + GRACE, || self.take());
        let signal = second.unwrap_or(first);
        let deadline = Instant::now() + LAST_WRITES;
        let runs = self.runs.lock().unwrap_or_else(PoisonError::into_inner);
        // The guards are held until the process exits: no later checkpoint is written, and nothing
        // is written to a file that has been truncated.
        let checkpoints: Vec<_> = runs
            .iter()
            .filter_map(|run| try_until(deadline, || run.try_lock().ok()))
            .collect();
        let _cut: Vec<_> = checkpoints
            .iter()
            .filter_map(|kept| try_until(deadline, || kept.cut_back()))
            .collect();
        let kept = if runs.is_empty() {
            "before the first checkpoint. Start again with"
        } else {
            "before the next checkpoint; the last checkpoint is kept. Resume with"
        };
        let words = format!(
            "interrupted by {}{} {kept}\n  {} --resume",
            if second.is_some() { "a second " } else { "" },
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
            signal => Err(Interrupted {
                signal: signal as i32,
            }),
        }
    }
}

/// Lets a signal store its number there.
#[cfg(any(unix, windows))]
fn set_on(signal: i32, number: Arc<AtomicUsize>) -> io::Result<()> {
    flag::register_usize(signal, number, signal as usize).map(drop)
}

/// Without signals of the system.
#[cfg(not(any(unix, windows)))]
fn set_on(_signal: i32, _number: Arc<AtomicUsize>) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// The signals that end a program.
fn watched() -> Vec<i32> {
    let signals = [SIGINT, SIGTERM].into_iter();
    #[cfg(unix)]
    let signals = signals.chain((!ignores_hangup()).then_some(SIGHUP));
    signals.collect()
}

/// Whether the program was started so that SIGHUP does not end it, as by `nohup`.
#[cfg(unix)]
fn ignores_hangup() -> bool {
    use std::{fs, io::IsTerminal as _};
    let status = fs::read_to_string("/proc/self/status").ok();
    let ignored = status.as_deref().and_then(|text| {
        let mask = text.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
        u64::from_str_radix(mask.trim(), 16).ok()
    });
    match ignored {
        Some(mask) => mask & (1 << (SIGHUP - 1)) != 0,
        // `nohup` redirects standard error if it is a terminal.
        None => !stderr().is_terminal(),
    }
}

/// Signals of a command that writes nothing until its end, and cannot be resumed.
#[derive(Debug)]
pub struct OnlyAtEnd {
    is_writing: Arc<Mutex<bool>>,
}

impl OnlyAtEnd {
    /// Installs the signal handlers. A signal ends the program at once until [`Self::write`] is
    /// called; from then on a second one does.
    ///
    /// # Errors
    /// The system refuses the handlers.
    pub fn watch() -> Result<Self> {
        let signals = Signals::registered()?;
        let is_writing = Arc::new(Mutex::new(false));
        let watched = Arc::clone(&is_writing);
        in_background(move || {
            let signal = signals.next();
            // Held until the process exits, so that no file is written meanwhile.
            let is_writing = watched.lock().unwrap_or_else(PoisonError::into_inner);
            if !*is_writing {
                let name = name(signal);
                let words = format!(
                    "interrupted by {name}; nothing is kept. Start again with\n  {}",
                    command()
                );
                end_now(words, signal);
            }
            drop(is_writing);
            let signal = signals.next();
            let name = name(signal);
            let words = format!(
                "interrupted by a second {name} while the results were written; start again with\n  {}",
                command()
            );
            end_now(words, signal);
        })?;
        Ok(Self { is_writing })
    }

    /// Marks the beginning of the output, which is short: a single signal no longer ends the
    /// program.
    pub fn write(&self) {
        *self
            .is_writing
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = true;
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
    thread
        .spawn(watch)
        .map(drop)
        .context("cannot watch for signals")
}

/// Ends the program with a message.
fn end_now(words: String, signal: i32) -> ! {
    let _ = writeln!(stderr(), "{words}");
    if let Some(object) = json_object::end(Err(words), exit_code(signal)) {
        write_line(&object);
    }
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
    match signal {
        SIGINT => "SIGINT",
        SIGTERM => "SIGTERM",
        _ => "SIGHUP",
    }
}

/// The command line without `--force` and `--resume`.
fn command() -> String {
    command_line::command(given().filter(|word| word != "--force" && word != "--resume"))
}
