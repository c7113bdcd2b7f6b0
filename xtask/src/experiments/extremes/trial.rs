//! Isolated trial of one scene: neither a panic nor a hang stops the others.

use std::{
    fs,
    panic::catch_unwind,
    path::PathBuf,
    sync::mpsc::{RecvTimeoutError, channel},
    thread,
    time::{Duration, Instant},
};

use anyhow::Result;
use carom_testkit::extremes::ExtremeFinding;

/// Result of a trial.
#[derive(Debug, Clone)]
pub enum Ending {
    /// Findings.
    Findings(Vec<ExtremeFinding>),
    /// A named error.
    Error(String),
    /// A panic.
    Panic,
    /// No end within the allowed processor time.
    Hang,
}

impl Ending {
    /// Returns true if all bounds hold.
    pub fn holds(&self) -> bool {
        matches!(self, Self::Findings(findings) if findings.iter().all(ExtremeFinding::holds))
    }

    /// Summary: the first violation, or the finding nearest to its bound.
    pub fn seen(&self) -> String {
        match self {
            Self::Findings(findings) => {
                let describe = |f: &ExtremeFinding| {
                    format!("{}: {:.1e}, allowed {:.1e}", f.what, f.found, f.allowed)
                };
                let failed = findings.iter().find(|finding| !finding.holds());
                let nearest =
                    |a: &&ExtremeFinding, b: &&ExtremeFinding| share(a).total_cmp(&share(b));
                failed
                    .or_else(|| findings.iter().max_by(nearest))
                    .map_or_else(String::new, describe)
            }
            Self::Error(error) => format!("error: {error}"),
            Self::Panic => "a panic".to_owned(),
            Self::Hang => "no end in the allowed processor time".to_owned(),
        }
    }

    /// Returns true if a failure would be reported, by a measurement or a named error; false for a
    /// panic or a hang.
    pub fn is_reported(&self) -> bool {
        matches!(self, Self::Findings(_) | Self::Error(_))
    }

    /// Kind of result.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Findings(_) if self.holds() => "all bounds hold",
            Self::Findings(_) => "bound exceeded",
            Self::Error(_) => "named error",
            Self::Panic => "panic",
            Self::Hang => "hang",
        }
    }
}

/// Ratio of a finding to its bound.
fn share(finding: &ExtremeFinding) -> f64 {
    if finding.allowed == 0.0 {
        0.0
    } else {
        finding.found / finding.allowed
    }
}

/// Interval between two checks of the clock of a trial.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// A trial that sleeps, or whose clock is not available, ends after this multiple of its allowed
/// time on the wall clock. Smaller: on a busy machine trials seem to hang. Larger: a stopped trial
/// delays the experiment.
const ON_THE_WALL: u32 = 30;

/// Runs a trial on its own thread and waits until it has used `patience` of processor time.
///
/// A trial that hangs is abandoned: its thread ends with the program.
pub fn attempt(
    patience: Duration,
    trial: impl FnOnce() -> Result<Vec<ExtremeFinding>> + Send + 'static,
) -> Ending {
    let (clock_sender, clock_receiver) = channel();
    let (sender, receiver) = channel();
    let begun = Instant::now();
    thread::spawn(move || {
        let _ = clock_sender.send(Clock::of_this_thread());
        let ended = catch_unwind(std::panic::AssertUnwindSafe(trial));
        // The receiver is gone if the trial was abandoned.
        let _ = sender.send(ended.map(|result| result.map_err(|error| format!("{error:#}"))));
    });
    let clock = clock_receiver.recv().ok().flatten();
    loop {
        match receiver.recv_timeout(POLL_INTERVAL.min(patience)) {
            Ok(Ok(Ok(findings))) => return Ending::Findings(findings),
            Ok(Ok(Err(error))) => return Ending::Error(error),
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => return Ending::Panic,
            Err(RecvTimeoutError::Timeout) => {
                let used = clock.as_ref().and_then(Clock::read).unwrap_or_default();
                if used > patience || begun.elapsed() > ON_THE_WALL * patience {
                    return Ending::Hang;
                }
            }
        }
    }
}

/// Processor-time clock of a thread for other threads: on Linux a file (proc(5), `schedstat`).
/// Other systems have none; there the wall clock decides.
struct Clock(PathBuf);

impl Clock {
    fn of_this_thread() -> Option<Self> {
        let thread = fs::read_link("/proc/thread-self").ok()?;
        let clock = Self(PathBuf::from("/proc").join(thread).join("schedstat"));
        clock.read().map(|_| clock)
    }

    /// Processor time of the thread so far.
    fn read(&self) -> Option<Duration> {
        let text = fs::read_to_string(&self.0).ok()?;
        text.split_whitespace()
            .next()?
            .parse()
            .ok()
            .map(Duration::from_nanos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_reports_how_it_ends() {
        let long = Duration::from_mins(1);
        assert!(attempt(long, || Ok(vec![ExtremeFinding::never("wrong", 0)])).holds());
        assert!(!attempt(long, || Ok(vec![ExtremeFinding::never("wrong", 1)])).holds());
        assert!(
            matches!(attempt(long, || anyhow::bail!("a reason")), Ending::Error(why) if why == "a reason")
        );
        assert!(matches!(attempt(long, || panic!("a bug")), Ending::Panic));
    }

    #[test]
    fn a_hang_ends_by_processor_time_and_a_sleep_by_wall_time() {
        use std::sync::atomic::{AtomicBool, Ordering};
        static ENOUGH: AtomicBool = AtomicBool::new(false);
        let patience = Duration::from_millis(20);
        let spin = || {
            while !ENOUGH.load(Ordering::Relaxed) {
                std::hint::spin_loop();
            }
            Ok(Vec::new())
        };
        assert!(matches!(attempt(patience, spin), Ending::Hang));
        ENOUGH.store(true, Ordering::Relaxed);
        let sleep = || {
            thread::park();
            Ok(Vec::new())
        };
        assert!(matches!(attempt(patience, sleep), Ending::Hang));
    }

    #[test]
    fn time_spent_waiting_is_not_a_hang() {
        // Five times its allowed time on the wall clock, with almost no work.
        let patience = Duration::from_millis(40);
        let wait = || {
            thread::sleep(Duration::from_millis(200));
            Ok(Vec::new())
        };
        assert!(attempt(patience, wait).holds());
    }
}
