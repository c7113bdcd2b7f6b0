//! Processes under attack: each has a time limit, is signalled by its number, and what it wrote is
//! kept.

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};

use crate::fuzz::worker::processor_time;

/// Interval between two looks at a process.
const POLL_INTERVAL: Duration = Duration::from_millis(2);

/// Time that a process has before it counts as hanging. Wall time, since a process may wait.
pub const LIMIT: Duration = Duration::from_mins(2);

/// Size of the address space of a process (KiB), where the shell can limit it.
const MAX_MEMORY: u64 = 8 << 20;

/// A running process.
#[derive(Debug)]
pub struct Process {
    child: Child,
    /// File with what it writes.
    said: PathBuf,
}

/// How a process ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProcessEnd {
    /// Its exit code; 128 and the number of the signal that killed it; `None` for one that was
    /// killed because its time was over.
    pub code: Option<i32>,
    /// What it wrote to standard output and standard error.
    pub said: String,
}

impl ProcessEnd {
    /// Whether a process ended as it should: with success, a failed check, an error or a signal
    /// that it was sent; not by a panic, an abort, a fault of memory, or the time limit.
    pub fn is_orderly(&self) -> bool {
        matches!(self.code, Some(0..=3 | 129 | 130 | 137 | 143))
            && !self.said.contains("panicked at")
    }
}

impl std::fmt::Display for ProcessEnd {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let end = self
            .code
            .map_or_else(|| "time-out".to_owned(), |code| format!("exit code {code}"));
        let words: Vec<&str> = self
            .said
            .lines()
            .filter(|line| !line.trim().is_empty())
            .collect();
        write!(
            formatter,
            "{end}: {}",
            words[words.len().saturating_sub(3)..].join(" / ")
        )
    }
}

impl Process {
    /// Starts a command whose output goes to the file `said`.
    ///
    /// # Errors
    /// It cannot be started.
    pub fn start(mut command: Command, said: PathBuf) -> Result<Self> {
        let out =
            File::create(&said).with_context(|| format!("cannot write {}", said.display()))?;
        let error = out
            .try_clone()
            .context("the file of the output cannot be shared")?;
        let child = command
            .stdin(Stdio::null())
            .stdout(out)
            .stderr(error)
            .spawn()
            .context("cannot start the program")?;
        Ok(Self { child, said })
    }

    /// Sends a signal by name; one to a process that has just ended has no effect.
    pub fn signal(&mut self, name: &str) {
        if name == "KILL" {
            let _ = self.child.kill();
        } else if self.child.try_wait().is_ok_and(|status| status.is_none()) {
            let mut kill = Command::new("kill");
            kill.args(["-s", name, &self.child.id().to_string()]);
            let _ = kill.stdout(Stdio::null()).stderr(Stdio::null()).status();
        }
    }

    /// Waits until it has ended, or for a time.
    ///
    /// # Errors
    /// The system does not know the process.
    pub fn wait_for(&mut self, time: Duration) -> Result<Option<ExitStatus>> {
        let begun = Instant::now();
        loop {
            let status = self
                .child
                .try_wait()
                .context("cannot wait for the program")?;
            if status.is_some() || begun.elapsed() >= time {
                return Ok(status);
            }
            thread::sleep(POLL_INTERVAL);
        }
    }

    /// Processor time used so far, where the system counts it.
    pub fn processor_time(&self) -> Option<Duration> {
        processor_time(&self.child)
    }

    /// Waits until it has ended, at most for the time limit, after which it is killed.
    ///
    /// # Errors
    /// The system does not know the process.
    pub fn end(mut self, limit: Duration) -> Result<ProcessEnd> {
        let status = self.wait_for(limit)?;
        if status.is_none() {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
        let said = fs::read(&self.said).unwrap_or_default();
        Ok(ProcessEnd {
            code: status.map(code),
            said: String::from_utf8_lossy(&said).into_owned(),
        })
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(unix)]
fn code(status: ExitStatus) -> i32 {
    use std::os::unix::process::ExitStatusExt as _;
    status
        .code()
        .or_else(|| status.signal().map(|signal| 128 + signal))
        .unwrap_or(-1)
}

#[cfg(not(unix))]
fn code(status: ExitStatus) -> i32 {
    status.code().unwrap_or(-1)
}

/// The command `carom` with these words, as a part of this program, in a folder.
pub fn carom(program: &Path, folder: &Path, words: &str) -> Command {
    let mut command = if cfg!(unix) {
        let mut shell = Command::new("sh");
        let script = format!("ulimit -v {MAX_MEMORY} 2>/dev/null; exec \"$0\" \"$@\"");
        shell.args(["-c", &script]).arg(program);
        shell
    } else {
        Command::new(program)
    };
    command
        .arg(COMMAND)
        .args(words.split_whitespace())
        .current_dir(folder);
    command
}

/// Name of the hidden command by which this program is `carom`.
pub const COMMAND: &str = "carom";
