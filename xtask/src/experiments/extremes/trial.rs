//! One scene put to the test, so that neither a panic nor a hang stops the others.

use std::{
    fs,
    panic::catch_unwind,
    path::PathBuf,
    sync::mpsc::{RecvTimeoutError, channel},
    thread,
    time::{Duration, Instant},
};

use anyhow::Result;
use carom_testkit::extremes::Finding;

/// How a trial has ended.
#[derive(Debug, Clone)]
pub enum Ending {
    /// With findings.
    Findings(Vec<Finding>),
    /// With a named error.
    Error(String),
    /// With a panic.
    Panic,
    /// Not within the processor time allowed.
    Hang,
}

impl Ending {
    /// Whether all that must hold does.
    pub fn holds(&self) -> bool {
        matches!(self, Self::Findings(findings) if findings.iter().all(Finding::holds))
    }

    /// What was seen, in words: the first that fails, or the finding nearest to its bound.
    pub fn seen(&self) -> String {
        match self {
            Self::Findings(findings) => {
                let say = |f: &Finding| format!("{}: {:.1e}, allowed {:.1e}", f.what, f.found, f.allowed);
                let failed = findings.iter().find(|finding| !finding.holds());
                let nearest = |a: &&Finding, b: &&Finding| share(a).total_cmp(&share(b));
                failed.or_else(|| findings.iter().max_by(nearest)).map_or_else(String::new, say)
            }
            Self::Error(error) => format!("error: {error}"),
            Self::Panic => "a panic".to_owned(),
            Self::Hang => "no end in the processor time allowed".to_owned(),
        }
    }

    /// Whether it is told of: by what was measured, or by an error with a name. A panic or a hang is not.
    pub fn is_told(&self) -> bool {
        matches!(self, Self::Findings(_) | Self::Error(_))
    }

    /// How it ended, in two words.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Findings(_) if self.holds() => "all holds",
            Self::Findings(_) => "bound exceeded",
            Self::Error(_) => "named error",
            Self::Panic => "panic",
            Self::Hang => "hang",
        }
    }
}

/// How near to its bound a finding is.
fn share(finding: &Finding) -> f64 {
    if finding.allowed == 0.0 { 0.0 } else { finding.found / finding.allowed }
}

/// Between two looks at the clock of a trial.
const LOOK: Duration = Duration::from_millis(50);

/// A trial that sleeps, or whose clock cannot be read, is given up after so many times its patience on the wall clock.
/// Smaller: a machine with other work to do makes trials seem to hang. Larger: one that has stopped is waited for in vain.
const ON_THE_WALL: u32 = 30;

/// Runs a trial on a thread of its own, and waits for it until it has used up `patience` of processor time.
///
/// A trial that hangs is left behind: its thread ends with the program.
pub fn attempt(patience: Duration, trial: impl FnOnce() -> Result<Vec<Finding>> + Send + 'static) -> Ending {
    let (tell_clock, hear_clock) = channel();
    let (sender, receiver) = channel();
    let begun = Instant::now();
    thread::spawn(move || {
        let _ = tell_clock.send(Clock::of_this_thread());
        let ended = catch_unwind(std::panic::AssertUnwindSafe(trial));
        // Whoever has lost patience hears no more.
        let _ = sender.send(ended.map(|result| result.map_err(|error| format!("{error:#}"))));
    });
    let clock = hear_clock.recv().ok().flatten();
    loop {
        match receiver.recv_timeout(LOOK.min(patience)) {
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

/// Clock of the processor time of a thread that another thread may read: Linux has one in a file (proc(5), `schedstat`).
/// Elsewhere there is none, and the wall clock decides.
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
        text.split_whitespace().next()?.parse().ok().map(Duration::from_nanos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_ends_by_what_it_does() {
        let long = Duration::from_mins(1);
        assert!(attempt(long, || Ok(vec![Finding::never("wrong", 0)])).holds());
        assert!(!attempt(long, || Ok(vec![Finding::never("wrong", 1)])).holds());
        assert!(
            matches!(attempt(long, || anyhow::bail!("a reason")), Ending::Error(why) if why == "a reason")
        );
        assert!(matches!(attempt(long, || panic!("a bug")), Ending::Panic));
    }

    #[test]
    fn a_hang_is_caught_by_the_time_it_uses_and_a_sleep_in_the_end_by_the_wall_clock() {
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
    fn time_spent_waiting_is_no_hang() {
        // Five times its patience on the wall clock, with next to no work.
        let patience = Duration::from_millis(40);
        let wait = || {
            thread::sleep(Duration::from_millis(200));
            Ok(Vec::new())
        };
        assert!(attempt(patience, wait).holds());
    }
}
