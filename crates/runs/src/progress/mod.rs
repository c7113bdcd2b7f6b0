//! Progress of tasks: bars on a terminal, otherwise a line of text every few seconds; nothing in
//! the first two seconds of a program.
//!
//! A command creates a [`Progress`], or [`ProgressLines`] for tasks in parallel, and advances it;
//! nothing else is needed. [`show`] starts a thread that draws all tasks under way, and the
//! seconds of a command that has none. Without it, as in tests and in other programs, nothing is
//! drawn, and WebAssembly has no terminal.
#![cfg_attr(
    target_arch = "wasm32",
    allow(
        dead_code,
        unused_imports,
        reason = "nothing is drawn without a terminal"
    )
)]

#[cfg(not(target_arch = "wasm32"))]
mod screen;

#[cfg(not(target_arch = "wasm32"))]
use std::io::{IsTerminal as _, stderr};
use std::{
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, RecvTimeoutError, Sender, channel},
    },
    thread::{self, JoinHandle},
    time::Duration,
};

use carom_tables::grouped;
#[cfg(not(target_arch = "wasm32"))]
use indicatif::HumanDuration;

#[cfg(not(target_arch = "wasm32"))]
pub use self::screen::suspend;
#[cfg(not(target_arch = "wasm32"))]
use self::screen::{Bars, Screen, Text};

use crate::clock::Instant;

/// Nothing is drawn before this time: most commands end earlier.
const DELAY: Duration = Duration::from_secs(2);

/// Time between two looks at the tasks. Shorter: more work. Longer: bars that jump.
const TICK: Duration = Duration::from_millis(200);

/// The tasks that have not ended, while progress is shown.
static TASKS: Mutex<Vec<Arc<Task>>> = Mutex::new(Vec::new());

/// Whether progress is shown.
static IS_SHOWN: AtomicBool = AtomicBool::new(false);

/// Progress of runs that execute in parallel.
#[derive(Debug, Default)]
pub struct ProgressLines(());

/// Progress of one task: of a run in simulated time, or of items that are counted.
#[derive(Debug)]
pub struct Progress(Arc<Task>);

#[derive(Debug)]
struct Task {
    name: String,
    unit: Unit,
    state: Mutex<State>,
    has_ended: AtomicBool,
}

/// What is counted, and how much of it there is.
#[derive(Debug)]
enum Unit {
    /// Simulated time to this time.
    Time(f64),
    /// So many things of this name, in the plural; `None` if their number is unknown.
    Items(&'static str, Option<u64>),
}

#[derive(Debug, Default, Clone, Copy)]
struct State {
    /// Simulated time, or items.
    done: f64,
    /// Part that was done before this process; it is excluded from the speed.
    skipped: f64,
    collisions: u64,
    /// Start of the task; `None` while it waits.
    begun: Option<Instant>,
}

impl ProgressLines {
    /// Adds a line for a run that is queued and ends at `until` (simulated time).
    #[allow(
        clippy::unused_self,
        reason = "the lines of one experiment belong together"
    )]
    pub fn add(&self, name: &str, until: f64) -> Progress {
        Progress::with_unit(name, Unit::Time(until))
    }
}

impl Progress {
    /// Progress of work on many things under a name of its own, see [`Self::items`].
    pub fn of_items(name: &str, plural: &'static str, number: u64) -> Self {
        let progress = Self::with_unit(name, Unit::Items(plural, Some(number)));
        progress.skip(0.0);
        progress
    }

    /// Progress of a single run that ends at `until` (simulated time).
    pub fn new(until: f64) -> Self {
        Self::with_unit("", Unit::Time(until))
    }

    /// Progress of work on many things, such as `"pairs"`: their name in the plural, and their
    /// number if it is known.
    pub fn items(plural: &'static str, number: impl Into<Option<u64>>) -> Self {
        let progress = Self::with_unit("", Unit::Items(plural, number.into()));
        progress.skip(0.0);
        progress
    }

    fn with_unit(name: &str, unit: Unit) -> Self {
        let task = Arc::new(Task {
            name: name.to_owned(),
            unit,
            state: Mutex::default(),
            has_ended: AtomicBool::new(false),
        });
        if IS_SHOWN.load(Ordering::Relaxed) {
            lock(&TASKS).push(Arc::clone(&task));
        }
        Self(task)
    }

    /// Records that the run resumes at `time`, or that so many items were done before.
    pub fn skip(&self, time: f64) {
        let mut state = lock(&self.0.state);
        state.done += time;
        state.skipped += time;
        // The first call marks the end of its time in the queue; the replicas of a point all call.
        state.begun.get_or_insert_with(Instant::now);
    }

    /// Records that the run has advanced by this time and number of collisions.
    pub fn advance(&self, time: f64, collisions: u64) {
        let mut state = lock(&self.0.state);
        if state.done <= state.skipped {
            state.begun.get_or_insert_with(Instant::now);
        }
        state.done += time;
        state.collisions += collisions;
    }

    /// Records that so many items are done.
    pub fn count(&self, items: u64) {
        self.advance(items as f64, 0);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.has_ended.store(true, Ordering::Relaxed);
    }
}

impl Task {
    fn has_ended(&self) -> bool {
        self.has_ended.load(Ordering::Relaxed)
    }

    /// Share that is done, if it is known, and the state in words.
    fn words(&self, now: Instant) -> (Option<f64>, String) {
        let state = *lock(&self.state);
        let Some(begun) = state.begun else {
            return (Some(0.0), "waits".to_owned());
        };
        let elapsed = now.saturating_duration_since(begun).as_secs_f64();
        match self.unit {
            Unit::Time(until) => (
                Some((state.done / until).clamp(0.0, 1.0)),
                state.of_time(until, elapsed),
            ),
            Unit::Items(plural, None) => (None, format!("{} {plural}", whole(state.done))),
            Unit::Items(plural, Some(number)) => {
                let all = number as f64;
                let words = format!("{} of {} {plural}", whole(state.done), whole(all));
                let share = if number == 0 {
                    1.0
                } else {
                    (state.done / all).clamp(0.0, 1.0)
                };
                (
                    Some(share),
                    format!("{words}{}", state.remaining(all, elapsed)),
                )
            }
        }
    }

    /// The state as a line of text; `None` while the task waits.
    fn line(&self, now: Instant) -> Option<String> {
        lock(&self.state).begun?;
        let (share, words) = self.words(now);
        let name = if self.name.is_empty() {
            String::new()
        } else {
            format!("{}  ", self.name)
        };
        let share = share.map_or_else(String::new, |share| format!("{:5.1} %  ", 100.0 * share));
        Some(format!("{name}{share}{words}"))
    }
}

impl State {
    /// Collisions, rate and remaining time of a run after `elapsed` seconds.
    fn of_time(&self, until: f64, elapsed: f64) -> String {
        let collisions = rounded(self.collisions as f64);
        if self.done >= until {
            return format!("{collisions} collisions  done");
        }
        if self.done <= self.skipped || elapsed <= 0.0 {
            return "begins".to_owned();
        }
        let rate = rounded(self.collisions as f64 / elapsed);
        format!(
            "{collisions} collisions  {rate}/s{}",
            self.remaining(until, elapsed)
        )
    }

    /// The remaining time after `elapsed` seconds; empty where it is unknown or 0.
    fn remaining(&self, all: f64, elapsed: f64) -> String {
        let (done, left) = (self.done - self.skipped, all - self.done);
        if done <= 0.0 || left <= 0.0 {
            return String::new();
        }
        // At the start of a run the estimate is unbounded, so it is capped.
        let left = Duration::from_secs_f64((elapsed * left / done).min(1e9));
        #[cfg(not(target_arch = "wasm32"))]
        let left = HumanDuration(left);
        #[cfg(target_arch = "wasm32")]
        let left = format!("{} seconds", left.as_secs());
        format!("  {left} left")
    }
}

/// Progress is shown while this value lives.
#[derive(Debug)]
pub struct Shown {
    stop: Sender<()>,
    thread: Option<JoinHandle<()>>,
}

/// Shows the progress of all tasks, and the time of the command while it has none, on standard
/// error: as bars on a terminal, otherwise as text.
///
/// `None` if the system cannot start a thread for it.
#[cfg(not(target_arch = "wasm32"))]
pub fn show(command: &str) -> Option<Shown> {
    let (stop, stopped) = channel();
    let is_terminal =
        stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|kind| kind != "dumb");
    let command = command.to_owned();
    let watch = move || {
        if is_terminal {
            watch(&stopped, &mut Bars::new(&command));
        } else {
            watch(&stopped, &mut Text::new(&command, Instant::now(), stderr()));
        }
    };
    let thread = thread::Builder::new()
        .name("progress".to_owned())
        .spawn(watch)
        .ok()?;
    IS_SHOWN.store(true, Ordering::Relaxed);
    Some(Shown {
        stop,
        thread: Some(thread),
    })
}

/// Nothing is shown.
#[cfg(target_arch = "wasm32")]
pub fn show(_command: &str) -> Option<Shown> {
    None
}

/// Calls a function that writes to a terminal.
#[cfg(target_arch = "wasm32")]
pub fn suspend<T>(write: impl FnOnce() -> T) -> T {
    write()
}

impl Drop for Shown {
    fn drop(&mut self) {
        IS_SHOWN.store(false, Ordering::Relaxed);
        let _ = self.stop.send(());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        lock(&TASKS).clear();
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn watch(stopped: &Receiver<()>, screen: &mut dyn Screen) {
    let begun = Instant::now();
    while let Err(RecvTimeoutError::Timeout) = stopped.recv_timeout(TICK) {
        let tasks = {
            let mut tasks = lock(&TASKS);
            tasks.retain(|task| !task.has_ended());
            tasks.clone()
        };
        if begun.elapsed() >= DELAY {
            screen.draw(&tasks, Instant::now());
        }
    }
    screen.end();
}

/// Formats a number in thousands (k) or millions (M), so that its width hardly changes.
fn rounded(number: f64) -> String {
    if number >= 1e6 {
        format!("{:.2} M", number * 1e-6)
    } else {
        format!("{:.0} k", number * 1e-3)
    }
}

/// A whole number in groups of three digits.
fn whole(number: f64) -> String {
    grouped(&format!("{number:.0}"))
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_replicas_of_a_point_share_one_clock() {
        let progress = ProgressLines::default().add("point", 30.0);
        progress.skip(0.0);
        progress.advance(10.0, 1000);
        let begun = lock(&progress.0.state).begun;
        progress.skip(0.0);
        progress.advance(5.0, 500);
        let state = *lock(&progress.0.state);
        assert_eq!(
            (state.begun, state.done, state.collisions),
            (begun, 15.0, 1500)
        );
    }

    #[test]
    fn simulated_time_of_earlier_processes_does_not_count_as_speed() {
        let state = State {
            done: 60.0,
            skipped: 50.0,
            collisions: 3_000_000,
            begun: None,
        };
        // Ten units in five seconds, so that the remaining forty take twenty.
        assert_eq!(
            state.of_time(100.0, 5.0),
            "3.00 M collisions  600 k/s  20 seconds left"
        );
        assert_eq!(
            State {
                done: 100.0,
                ..state
            }
            .of_time(100.0, 5.0),
            "3.00 M collisions  done"
        );
        assert_eq!(
            State {
                done: 5.0,
                skipped: 5.0,
                ..State::default()
            }
            .of_time(100.0, 0.0),
            "begins"
        );
    }
}
