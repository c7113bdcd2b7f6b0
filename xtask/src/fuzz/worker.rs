//! The process that runs the cases: it is killed and restarted if a case hangs, aborts or exhausts
//! memory.
//!
//! Requests and answers are frames: a length of four bytes, little-endian, and that number of bytes
//! in postcard's encoding.

use std::{
    io::{self, BufReader, Read, Write},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, Command, Stdio},
    sync::mpsc::{Receiver, RecvTimeoutError, channel},
    thread,
    time::Duration,
};

use anyhow::{Context, Result};
use carom_runs::{
    checkpoint_file::{decode, encode},
    interruption::Signals,
};
use serde::{Deserialize, Serialize};

use super::subject::{Failure, Report, Subject, check_and_catch};

/// Name of the hidden command that starts the process.
pub const COMMAND: &str = "fuzz-worker";

/// Memory limit of the process (KiB of address space); exceeding it is a failure.
const MAX_MEMORY: u64 = 4 << 20;

/// Interval between checks for a signal while waiting.
const POLL_INTERVAL: Duration = Duration::from_millis(200);

/// Largest waiting time for a case, in units of its processor time limit.
const MAX_WAITS: u32 = 15;

/// Executes cases.
pub trait Runner {
    /// Runs the case of a seed.
    ///
    /// # Errors
    /// The process cannot be started, or a signal has been received.
    fn run_seed(&mut self, seed: u64) -> Result<Report>;

    /// Runs the case in a file.
    ///
    /// # Errors
    /// The process cannot be started, a signal has been received, or the bytes are no case.
    fn run_file(&mut self, ending: &str, bytes: &[u8]) -> Result<Report>;
}

/// Runs cases in this process, for tests.
#[derive(Debug)]
pub struct InProcess<S>(pub S);

impl<S: Subject> Runner for InProcess<S> {
    fn run_seed(&mut self, seed: u64) -> Result<Report> {
        Ok(check_and_catch(|| self.0.check(&self.0.draw(seed))))
    }

    fn run_file(&mut self, ending: &str, bytes: &[u8]) -> Result<Report> {
        let case = self.0.read(ending, bytes)?;
        Ok(check_and_catch(|| self.0.check(&case)))
    }
}

#[derive(Debug, Serialize, Deserialize)]
enum Request {
    Seed(u64),
    File { ending: String, bytes: Vec<u8> },
}

/// Runs cases in a separate process.
#[derive(Debug)]
pub struct Worker {
    program: PathBuf,
    name: &'static str,
    limit: Duration,
    signals: Signals,
    process: Option<Process>,
}

#[derive(Debug)]
struct Process {
    child: Child,
    requests: ChildStdin,
    answers: Receiver<Vec<u8>>,
}

impl Drop for Process {
    fn drop(&mut self) {
        // The process may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Worker {
    /// A worker for the fuzzer `name`; a case with more than `limit` of processor time is a hang.
    ///
    /// `program` is the path of `xtask`.
    pub fn new(program: PathBuf, name: &'static str, limit: Duration, signals: Signals) -> Self {
        Self {
            program,
            name,
            limit,
            signals,
            process: None,
        }
    }

    fn request(&mut self, request: &Request) -> Result<Report> {
        let bytes = encode(request)?;
        let process = match &mut self.process {
            Some(process) => process,
            none => none.insert(start(&self.program, self.name)?),
        };
        // A process that has ended closes its input; the missing answer shows the reason.
        let _ = send(&mut process.requests, &bytes);
        let before = processor_time(&process.child);
        let mut waited = Duration::ZERO;
        loop {
            match process.answers.recv_timeout(POLL_INTERVAL) {
                Ok(answer) => return Ok(decode(&answer)?),
                Err(RecvTimeoutError::Disconnected) => {
                    // Ctrl-C ends the worker too, which is not a failure of the case.
                    thread::sleep(POLL_INTERVAL);
                    self.signals.check()?;
                    let status = process.child.wait().context("cannot wait for the worker")?;
                    self.process = None;
                    let detail = format!(
                        "the process ended with {status}: out of {} GiB of memory, or an abort",
                        MAX_MEMORY >> 20
                    );
                    return Ok(Report {
                        failure: Some(Failure::new("crash", detail)),
                        ..Report::default()
                    });
                }
                Err(RecvTimeoutError::Timeout) => {
                    self.signals.check()?;
                    waited += POLL_INTERVAL;
                    // A process that waits for the processor does not hang.
                    let now = processor_time(&process.child);
                    let used = before
                        .zip(now)
                        .map_or(waited, |(before, now)| now.saturating_sub(before));
                    if used >= self.limit || waited >= MAX_WAITS * self.limit {
                        self.process = None;
                        let seconds = self.limit.as_secs();
                        let detail = format!("no answer within {seconds} s of processor time");
                        return Ok(Report {
                            failure: Some(Failure::new("hang", detail)),
                            ..Report::default()
                        });
                    }
                }
            }
        }
    }
}

impl Runner for Worker {
    fn run_seed(&mut self, seed: u64) -> Result<Report> {
        self.request(&Request::Seed(seed))
    }

    fn run_file(&mut self, ending: &str, bytes: &[u8]) -> Result<Report> {
        self.request(&Request::File {
            ending: ending.to_owned(),
            bytes: bytes.to_vec(),
        })
    }
}

/// Starts this program as a worker, with a memory limit if the shell supports it.
fn start(program: &Path, name: &str) -> Result<Process> {
    let mut command = if cfg!(unix) {
        let mut shell = Command::new("sh");
        let script = format!("ulimit -v {MAX_MEMORY} 2>/dev/null; exec \"$0\" \"$@\"");
        shell.args(["-c", &script]).arg(program);
        shell
    } else {
        Command::new(program)
    };
    let mut child = command
        .args([COMMAND, name])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .context("cannot start a worker")?;
    let requests = child.stdin.take().context("the worker has no input")?;
    let mut output = BufReader::new(child.stdout.take().context("the worker has no output")?);
    let (sender, answers) = channel();
    thread::spawn(move || {
        while let Ok(Some(answer)) = receive(&mut output) {
            if sender.send(answer).is_err() {
                break;
            }
        }
    });
    Ok(Process {
        child,
        requests,
        answers,
    })
}

/// Processor time of a process (user and system), where the system has `/proc`.
pub(crate) fn processor_time(process: &Child) -> Option<Duration> {
    // Fields 14 and 15, in hundredths of a second; field 2 may contain spaces.
    let text = std::fs::read_to_string(format!("/proc/{}/stat", process.id())).ok()?;
    let (_, fields) = text.rsplit_once(')')?;
    let mut fields = fields.split_whitespace().skip(11).map(str::parse::<u64>);
    let (user, system) = (fields.next()?.ok()?, fields.next()?.ok()?);
    Some(Duration::from_millis(10 * (user + system)))
}

/// Answers requests from standard input until it ends.
///
/// # Errors
/// Standard output cannot be written, or a request is invalid.
pub fn work<S: Subject>(subject: &S) -> Result<()> {
    let (mut input, mut output) = (io::stdin().lock(), io::stdout().lock());
    while let Some(bytes) = receive(&mut input)? {
        let report = match decode(&bytes)? {
            Request::Seed(seed) => check_and_catch(|| subject.check(&subject.draw(seed))),
            Request::File { ending, bytes } => match subject.read(&ending, &bytes) {
                Ok(case) => check_and_catch(|| subject.check(&case)),
                Err(error) => Report {
                    failure: Some(Failure::new("no case", format!("{error:#}"))),
                    ..Report::default()
                },
            },
        };
        send(&mut output, &encode(&report)?)?;
    }
    Ok(())
}

fn send(output: &mut impl Write, bytes: &[u8]) -> io::Result<()> {
    let length = u32::try_from(bytes.len()).map_err(io::Error::other)?;
    output.write_all(&length.to_le_bytes())?;
    output.write_all(bytes)?;
    output.flush()
}

/// The next frame; `None` at the end.
fn receive(input: &mut impl Read) -> io::Result<Option<Vec<u8>>> {
    let mut length = [0; 4];
    match input.read_exact(&mut length) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        other => other?,
    }
    let mut bytes = vec![0; u32::from_le_bytes(length) as usize];
    input.read_exact(&mut bytes)?;
    Ok(Some(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_received_as_it_was_sent() {
        let mut pipe = Vec::new();
        send(&mut pipe, b"one").unwrap();
        send(&mut pipe, b"").unwrap();
        let mut input = &pipe[..];
        assert_eq!(receive(&mut input).unwrap().as_deref(), Some(&b"one"[..]));
        assert_eq!(receive(&mut input).unwrap().as_deref(), Some(&b""[..]));
        assert_eq!(receive(&mut input).unwrap(), None);
    }
}
