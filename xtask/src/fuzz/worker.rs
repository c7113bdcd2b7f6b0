//! The process that runs the cases: it is ended and started anew when a case hangs, aborts or takes
//! too much memory.
//!
//! Requests and answers are frames: four bytes with the length, little-endian, and as many bytes in
//! postcard's encoding.

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

/// The name of the hidden command that starts the process.
pub const COMMAND: &str = "fuzz-worker";

/// Most memory of the process (KiB of address space). More is taken for a failure.
const MOST_MEMORY: u64 = 4 << 20;

/// How often a wait looks whether the program has been asked to end.
const LOOK: Duration = Duration::from_millis(200);

/// A case is waited for no longer than this many times its limit of processor time.
const MOST_WAITS: u32 = 15;

/// Runs cases.
pub trait Runner {
    /// Runs the case of a seed.
    ///
    /// # Errors
    /// The process cannot be started, or the program has been asked to end.
    fn run_seed(&mut self, seed: u64) -> Result<Report>;

    /// Runs the case that a file holds.
    ///
    /// # Errors
    /// As [`Self::run_seed`], and bytes that are no case.
    fn run_file(&mut self, ending: &str, bytes: &[u8]) -> Result<Report>;
}

/// Runs cases in this process: for tests.
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

/// Runs cases in a process of their own.
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
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Worker {
    /// A worker for the fuzzer `name`; a case that takes longer than `limit`
    /// (processor time) is a hang.
    ///
    /// `program` is `xtask` itself.
    pub fn new(program: PathBuf, name: &'static str, limit: Duration, signals: Signals) -> Self {
        Self { program, name, limit, signals, process: None }
    }

    fn ask(&mut self, request: &Request) -> Result<Report> {
        let bytes = encode(request)?;
        let process = match &mut self.process {
            Some(process) => process,
            none => none.insert(start(&self.program, self.name)?),
        };
        // A process that has ended closes its input; the answer, or its absence, says why.
        let _ = send(&mut process.requests, &bytes);
        let before = processor_time(&process.child);
        let mut waited = Duration::ZERO;
        loop {
            match process.answers.recv_timeout(LOOK) {
                Ok(answer) => return Ok(decode(&answer)?),
                Err(RecvTimeoutError::Disconnected) => {
                    // Ctrl-C ends the worker as well: that is no failure of the case.
                    thread::sleep(LOOK);
                    self.signals.check()?;
                    let status = process.child.wait().context("cannot wait for the worker")?;
                    self.process = None;
                    let detail = format!(
                        "the process ended with {status}: out of {} GiB of memory, or an abort",
                        MOST_MEMORY >> 20
                    );
                    return Ok(Report { failure: Some(Failure::new("crash", detail)), ..Report::default() });
                }
                Err(RecvTimeoutError::Timeout) => {
                    self.signals.check()?;
                    waited += LOOK;
                    // A process that other work keeps from the processor does not hang.
                    let now = processor_time(&process.child);
                    let used = before.zip(now).map_or(waited, |(before, now)| now.saturating_sub(before));
                    if used >= self.limit || waited >= MOST_WAITS * self.limit {
                        self.process = None;
                        let seconds = self.limit.as_secs();
                        let detail = format!("no answer within {seconds} s of the processor");
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
        self.ask(&Request::Seed(seed))
    }

    fn run_file(&mut self, ending: &str, bytes: &[u8]) -> Result<Report> {
        self.ask(&Request::File { ending: ending.to_owned(), bytes: bytes.to_vec() })
    }
}

/// Starts this program as a worker, with bounded memory where the shell can bound it.
fn start(program: &Path, name: &str) -> Result<Process> {
    let mut command = if cfg!(unix) {
        let mut shell = Command::new("sh");
        let script = format!("ulimit -v {MOST_MEMORY} 2>/dev/null; exec \"$0\" \"$@\"");
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
    Ok(Process { child, requests, answers })
}

/// Processor time of a process (user and system), where the system has `/proc`.
fn processor_time(process: &Child) -> Option<Duration> {
    // Fields 14 and 15, of which the second may hold spaces, in hundredths of a second.
    let text = std::fs::read_to_string(format!("/proc/{}/stat", process.id())).ok()?;
    let (_, fields) = text.rsplit_once(')')?;
    let mut fields = fields.split_whitespace().skip(11).map(str::parse::<u64>);
    let (user, system) = (fields.next()?.ok()?, fields.next()?.ok()?);
    Some(Duration::from_millis(10 * (user + system)))
}

/// Answers requests on the standard input until it ends.
///
/// # Errors
/// The standard output cannot be written, or a request makes no sense.
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
    fn a_frame_comes_back_as_it_was_sent() {
        let mut pipe = Vec::new();
        send(&mut pipe, b"one").unwrap();
        send(&mut pipe, b"").unwrap();
        let mut input = &pipe[..];
        assert_eq!(receive(&mut input).unwrap().as_deref(), Some(&b"one"[..]));
        assert_eq!(receive(&mut input).unwrap().as_deref(), Some(&b""[..]));
        assert_eq!(receive(&mut input).unwrap(), None);
    }
}
