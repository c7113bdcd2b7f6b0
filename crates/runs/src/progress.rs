//! Progress of runs: a bar for each on a terminal, otherwise a line of text from time to time.

use std::{
    io::{IsTerminal, stderr},
    sync::Mutex,
    time::{Duration, Instant},
};

use indicatif::{HumanDuration, MultiProgress, ProgressBar, ProgressStyle};

/// Interval between two lines of text of one run.
const INTERVAL: Duration = Duration::from_secs(15);

/// Steps of the bar over the simulated time of a run.
const STEPS: u64 = 10_000;

/// Progress of runs that execute in parallel.
#[derive(Debug, Default)]
pub struct Lines {
    bars: MultiProgress,
}

/// Progress of one run, in simulated time.
#[derive(Debug)]
pub struct Progress {
    name: String,
    until: f64,
    bar: Option<ProgressBar>,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    time: f64,
    /// Simulated time before this process; it is excluded from the speed.
    skipped: f64,
    collisions: u64,
    /// Start of the run, and time of its last line of text.
    begun: Option<Instant>,
    printed: Option<Instant>,
}

impl Lines {
    /// Adds a line for a run that is queued.
    pub fn add(&self, name: &str, until: f64) -> Progress {
        let bar = ProgressBar::new(STEPS).with_style(style()).with_prefix(format!("{name:<16}"));
        let bar = stderr().is_terminal().then(|| self.bars.add(bar).with_message("waits"));
        if let Some(bar) = &bar {
            bar.tick();
        }
        Progress { name: name.to_owned(), until, bar, state: Mutex::default() }
    }
}

fn style() -> ProgressStyle {
    let template = "{prefix} {bar:24} {percent:>3} %  {msg}";
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

impl Progress {
    /// Progress of a single run that ends at `until`.
    pub fn new(until: f64) -> Self {
        Lines::default().add("", until)
    }

    /// Records that the run resumes at `time`.
    pub fn skip(&self, time: f64) {
        let mut state = self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        state.time += time;
        state.skipped += time;
        self.show(&mut state);
    }

    /// Records that the run has reached `time` with this number of collisions.
    pub fn advance(&self, time: f64, collisions: u64) {
        let mut state = self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        state.time += time;
        state.collisions += collisions;
        self.show(&mut state);
    }

    fn show(&self, state: &mut State) {
        let now = Instant::now();
        if state.time <= state.skipped {
            // The first call marks the end of its time in the queue.
            state.begun = Some(now);
        }
        let begun = *state.begun.get_or_insert(now);
        let printed = *state.printed.get_or_insert(now);
        let share = (state.time / self.until).clamp(0.0, 1.0);
        let words = state.words(self.until, now.duration_since(begun).as_secs_f64());
        if let Some(bar) = &self.bar {
            bar.set_message(words);
            bar.set_position((share * STEPS as f64) as u64);
        } else if now.duration_since(printed) >= INTERVAL {
            state.printed = Some(now);
            let name = if self.name.is_empty() { String::new() } else { format!("{}  ", self.name) };
            eprintln!("{name}{:5.1} %  {words}", 100.0 * share);
        }
    }
}

impl State {
    /// Collisions, rate and remaining time after `elapsed` seconds.
    fn words(&self, until: f64, elapsed: f64) -> String {
        let collisions = rounded(self.collisions as f64);
        let (done, left) = (self.time - self.skipped, (until - self.time).max(0.0));
        if left == 0.0 {
            return format!("{collisions} collisions  done");
        }
        if done <= 0.0 || elapsed <= 0.0 {
            return "begins".to_owned();
        }
        let rate = rounded(self.collisions as f64 / elapsed);
        // At the start of a run the estimate is unbounded, so it is capped.
        let left = HumanDuration(Duration::from_secs_f64((elapsed * left / done).min(1e9)));
        format!("{collisions} collisions  {rate}/s  {left} left")
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.abandon();
        }
    }
}

/// Formats a number in thousands (k) or millions (M), so that its width hardly changes.
fn rounded(number: f64) -> String {
    if number >= 1e6 { format!("{:.2} M", number * 1e-6) } else { format!("{:.0} k", number * 1e-3) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simulated_time_of_earlier_processes_does_not_count_as_speed() {
        let state = State { time: 60.0, skipped: 50.0, collisions: 3_000_000, ..State::default() };
        // Ten units in five seconds, so that the remaining forty take twenty.
        assert_eq!(state.words(100.0, 5.0), "3.00 M collisions  600 k/s  20 seconds left");
        assert_eq!(State { time: 100.0, ..state }.words(100.0, 5.0), "3.00 M collisions  done");
        assert_eq!(State { time: 5.0, skipped: 5.0, ..State::default() }.words(100.0, 0.0), "begins");
    }
}
