//! How tasks are drawn: bars on a terminal, or lines of text.

use std::{
    io::Write,
    sync::{Arc, Mutex},
    time::Duration,
};

use indicatif::{HumanDuration, MultiProgress, ProgressBar, ProgressStyle};

use super::{Task, Unit, lock};
use crate::clock::Instant;

/// Least and longest time between two lines of text.
const INTERVALS: [Duration; 2] = [Duration::from_secs(5), Duration::from_mins(1)];

/// Lines of text in the time that a program has taken so far. More: long logs of long runs.
const LINES: u32 = 20;

/// Steps of a bar.
const STEPS: u64 = 10_000;

/// The bars on the terminal, if progress is shown there.
static BARS: Mutex<Option<MultiProgress>> = Mutex::new(None);

/// Calls `write`, which writes to the terminal, without bars in its way.
pub fn suspend<T>(write: impl FnOnce() -> T) -> T {
    let bars = lock(&BARS).clone();
    match bars {
        Some(bars) => bars.suspend(write),
        None => write(),
    }
}

/// A way to draw tasks.
pub(super) trait Screen {
    /// Draws the tasks that have not ended.
    fn draw(&mut self, tasks: &[Arc<Task>], now: Instant);

    /// Ends the drawing.
    fn end(&mut self);
}

/// Lines of text.
pub(super) struct Text<W> {
    command: String,
    begun: Instant,
    printed: Option<Instant>,
    out: W,
}

impl<W: Write> Text<W> {
    pub(super) fn new(command: &str, begun: Instant, out: W) -> Self {
        Self {
            command: command.to_owned(),
            begun,
            printed: None,
            out,
        }
    }
}

impl<W: Write> Screen for Text<W> {
    fn draw(&mut self, tasks: &[Arc<Task>], now: Instant) {
        let elapsed = now.saturating_duration_since(self.begun);
        let interval = (elapsed / LINES).clamp(INTERVALS[0], INTERVALS[1]);
        if self
            .printed
            .is_some_and(|printed| now.saturating_duration_since(printed) < interval)
        {
            return;
        }
        self.printed = Some(now);
        let running = tasks.iter().filter(|task| !task.has_ended());
        let mut lines: Vec<String> = running.filter_map(|task| task.line(now)).collect();
        if lines.is_empty() {
            lines.push(since(&self.command, elapsed));
        }
        for line in lines {
            // A closed pipe is ignored: the files hold all results.
            let _ = writeln!(self.out, "{line}");
        }
    }

    fn end(&mut self) {}
}

/// Bars on a terminal.
pub(super) struct Bars {
    command: String,
    begun: Instant,
    terminal: MultiProgress,
    drawn: Vec<(Arc<Task>, ProgressBar)>,
    /// The time of the command, while it has no task.
    clock: Option<ProgressBar>,
}

impl Bars {
    pub(super) fn new(command: &str) -> Self {
        let terminal = MultiProgress::new();
        *lock(&BARS) = Some(terminal.clone());
        Self {
            command: command.to_owned(),
            begun: Instant::now(),
            terminal,
            drawn: Vec::new(),
            clock: None,
        }
    }

    fn add(&self, task: &Task) -> ProgressBar {
        let bar = match task.unit {
            Unit::Items(_, None) => ProgressBar::new_spinner().with_style(style("{prefix}{msg}")),
            _ => {
                ProgressBar::new(STEPS).with_style(style("{prefix}{bar:24} {percent:>3} %  {msg}"))
            }
        };
        let name = if task.name.is_empty() {
            String::new()
        } else {
            format!("{:<16} ", task.name)
        };
        self.terminal.add(bar.with_prefix(name))
    }

    /// Sets all bars to the state of their tasks.
    fn renew(&self, now: Instant) {
        for (task, bar) in &self.drawn {
            let (share, words) = task.words(now);
            bar.set_message(words);
            bar.set_position((share.unwrap_or(0.0) * STEPS as f64) as u64);
        }
    }
}

impl Screen for Bars {
    fn draw(&mut self, tasks: &[Arc<Task>], now: Instant) {
        for task in tasks {
            if !self.drawn.iter().any(|(drawn, _)| Arc::ptr_eq(drawn, task)) && !task.has_ended() {
                let bar = self.add(task);
                self.drawn.push((Arc::clone(task), bar));
            }
        }
        self.renew(now);
        self.drawn.retain(|(task, bar)| {
            if task.has_ended() {
                bar.finish_and_clear();
            }
            !task.has_ended()
        });
        if self.drawn.is_empty() {
            let add = || {
                self.terminal
                    .add(ProgressBar::new_spinner().with_style(style("{msg}")))
            };
            let clock = self.clock.get_or_insert_with(add);
            clock.set_message(since(
                &self.command,
                now.saturating_duration_since(self.begun),
            ));
        } else if let Some(clock) = self.clock.take() {
            clock.finish_and_clear();
        }
    }

    fn end(&mut self) {
        if let Some(clock) = self.clock.take() {
            clock.finish_and_clear();
        }
        self.drawn
            .iter()
            .for_each(|(_, bar)| bar.finish_and_clear());
        *lock(&BARS) = None;
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// The time that a command has taken so far.
fn since(command: &str, elapsed: Duration) -> String {
    format!("{command}: {} so far", HumanDuration(elapsed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::{Progress, ProgressLines};

    #[test]
    fn lines_of_text_name_each_task_and_keep_their_distance() {
        let begun = Instant::now();
        let mut text = Text::new("carom run", begun, Vec::new());
        let at = |seconds| begun + Duration::from_secs(seconds);
        let waits = ProgressLines::default().add("second", 1.0);
        let tasks = [Arc::clone(&waits.0)];
        text.draw(&tasks, at(2));
        text.draw(&tasks, at(6));
        let [first, pairs] = [
            ProgressLines::default().add("first", 4.0),
            Progress::items("pairs", 12_000),
        ];
        first.advance(1.0, 5000);
        pairs.count(3000);
        pairs.count(6000);
        let frames = Progress::items("frames", None);
        frames.count(1_234_567);
        let tasks = [&first, &waits, &pairs, &frames].map(|progress| Arc::clone(&progress.0));
        text.draw(&tasks, at(7));
        drop(first);
        text.draw(&tasks, at(10));
        text.draw(&tasks[..1], at(4000));
        text.draw(&tasks[..1], at(4059));
        let said = String::from_utf8(text.out).unwrap();
        let lines: Vec<&str> = said.lines().collect();
        assert_eq!(lines.len(), 5, "{said}");
        assert_eq!(lines[0], "carom run: 2 seconds so far");
        assert!(
            lines[1].starts_with("first   25.0 %  5 k collisions  "),
            "{said}"
        );
        assert!(
            lines[2].starts_with(" 75.0 %  9000 of 12\u{202f}000 pairs  "),
            "{said}"
        );
        assert_eq!(lines[3], "1\u{202f}234\u{202f}567 frames");
        assert_eq!(lines[4], "carom run: 67 minutes so far");
    }
}
