//! One scene put to the test, so that neither a panic nor a hang stops the others.

use std::{
    panic::catch_unwind,
    sync::mpsc::{RecvTimeoutError, channel},
    thread,
    time::Duration,
};

use anyhow::Result;

use super::cases::Finding;

/// How a trial has ended.
#[derive(Debug, Clone)]
pub enum Ending {
    /// With findings.
    Findings(Vec<Finding>),
    /// With a named error.
    Error(String),
    /// With a panic.
    Panic,
    /// Not within the time allowed.
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
            Self::Hang => "no end in the time allowed".to_owned(),
        }
    }
}

/// How near to its bound a finding is.
fn share(finding: &Finding) -> f64 {
    if finding.allowed == 0.0 { 0.0 } else { finding.found / finding.allowed }
}

/// Runs a trial on a thread of its own, and waits for it no longer than `patience`.
///
/// A trial that hangs is left behind: its thread ends with the program.
pub fn attempt(patience: Duration, trial: impl FnOnce() -> Result<Vec<Finding>> + Send + 'static) -> Ending {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        let ended = catch_unwind(std::panic::AssertUnwindSafe(trial));
        // Whoever has lost patience hears no more.
        let _ = sender.send(ended.map(|result| result.map_err(|error| format!("{error:#}"))));
    });
    match receiver.recv_timeout(patience) {
        Ok(Ok(Ok(findings))) => Ending::Findings(findings),
        Ok(Ok(Err(error))) => Ending::Error(error),
        Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => Ending::Panic,
        Err(RecvTimeoutError::Timeout) => Ending::Hang,
    }
}
