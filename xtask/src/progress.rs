//! How far a run is: a bar on a terminal, a line now and then where there is none.

use std::{
    io::{IsTerminal, stderr},
    sync::Mutex,
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressStyle};

/// Between two lines where there is no terminal.
const INTERVAL: Duration = Duration::from_secs(15);

/// Steps of the bar; it counts simulated time in these.
const STEPS: u64 = 10_000;

/// Progress of one run, or of several at once, in simulated time.
#[derive(Debug)]
pub struct Progress {
    total: f64,
    begun: Instant,
    bar: Option<ProgressBar>,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    time: f64,
    /// Of this, what was done before: it says nothing about how fast it goes now.
    skipped: f64,
    collisions: u64,
    line: Instant,
}

impl Progress {
    /// Progress towards `total` of simulated time, all runs together.
    pub fn new(total: f64) -> Self {
        let bar = stderr().is_terminal().then(|| {
            let template = "{bar:32} {percent:>3} %  {msg}  {eta} left";
            let style = ProgressStyle::with_template(template);
            ProgressBar::new(STEPS).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        let now = Instant::now();
        Self {
            total,
            begun: now,
            bar,
            state: Mutex::new(State { time: 0.0, skipped: 0.0, collisions: 0, line: now }),
        }
    }

    /// Some run resumes at `time`.
    pub fn skip(&self, time: f64) {
        let mut state = self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        state.time += time;
        state.skipped += time;
    }

    /// Some run has gone on by `time` with so many collisions.
    pub fn advance(&self, time: f64, collisions: u64) {
        let mut state = self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        state.time += time;
        state.collisions += collisions;
        let elapsed = self.begun.elapsed().as_secs_f64();
        let share = (state.time / self.total).clamp(0.0, 1.0);
        let rate = state.collisions as f64 / elapsed.max(1e-9);
        if let Some(bar) = &self.bar {
            bar.set_message(format!("{} collisions/s", rounded(rate)));
            bar.set_position((share * STEPS as f64) as u64);
        } else if state.line.elapsed() >= INTERVAL {
            state.line = Instant::now();
            let done = (state.time - state.skipped).max(1e-9 * self.total);
            let left = elapsed * (self.total - state.time).max(0.0) / done;
            eprintln!("{:5.1} %  {} collisions/s  {left:.0} s left", 100.0 * share, rounded(rate));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// A rate in words that do not dance.
fn rounded(rate: f64) -> String {
    if rate >= 1e6 { format!("{:.2} M", rate * 1e-6) } else { format!("{:.0} k", rate * 1e-3) }
}
