//! The folder of the saved runs: numbered ones that the user requests, and the automatic ones of
//! this session, of which the last complete one is kept.
//!
//! | path | content |
//! | --- | --- |
//! | `1`, `2`, … | runs saved on request, and at the end of a session |
//! | `auto-1`, `auto-2`, … | one for each session while it continues |
//! | `auto-1/1`, `auto-1/2`, … | its last save, and the next while that is written |
//!
//! A number is taken by creating its folder, which succeeds in one program alone. A run is written
//! beside its folder and renamed, and the save before it is removed only then.

use std::{
    fs::{self, File},
    io::{self, Write as _},
    path::{Path, PathBuf},
    sync::Arc,
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use anyhow::{Context, Result, anyhow};
use carom_runs::run::interactive::{InteractiveRun, MEASURED, MeasuredBefore, Saved};
use serde_json::{Value, json};

use crate::{
    reserve::Reserve,
    run_store::{RunState, RunStore},
};

/// Largest number of saved runs, and of sessions, in one folder.
const MAX_NUMBER: u32 = 100_000;

/// Largest share of the time that automatic saves take. Larger: a slower run of a large system.
/// Smaller: more of it is lost.
const SHARE_OF_SAVES: f64 = 0.05;

/// Size of the file by which the folder is tried (bytes): that of a small saved run.
const TRIAL: usize = 1 << 16;

/// Saves runs in one folder.
#[derive(Debug)]
pub struct SavedRuns {
    folder: PathBuf,
    /// Whether this program has created it.
    is_new: bool,
    reserve: Arc<Reserve>,
    /// No smaller number is free.
    next: u32,
    automatic: Automatic,
}

/// The automatic saves of this session.
#[derive(Debug)]
struct Automatic {
    folder: PathBuf,
    interval: Duration,
    due: Instant,
    /// Number of saves so far.
    count: u32,
    /// The state of the run that was saved last: it is not saved again.
    saved_state: Option<RunState>,
    writing: Option<JoinHandle<Written>>,
    /// The last complete save.
    last: Option<(PathBuf, Saved)>,
    /// Why the last attempt failed.
    error: Option<String>,
}

/// The end of an automatic save.
#[derive(Debug)]
struct Written {
    path: PathBuf,
    saved: Result<Saved>,
    took: Duration,
}

impl SavedRuns {
    /// Creates the folder if necessary, and tries to write into it. Runs are saved automatically at
    /// this interval.
    ///
    /// # Errors
    /// The folder cannot be created or written into, or the system grants too few file descriptors.
    pub fn open(folder: &Path, interval: Duration) -> Result<Self> {
        let reserve = Reserve::new().context(
            "too few files can be open to save the run later: raise the limit with `ulimit -n 1024`",
        )?;
        let is_new = !folder.exists();
        let session = start_session(folder).with_context(|| {
            format!(
                "runs cannot be saved in {}: make it writable, free space there, or choose another with --out",
                folder.display()
            )
        })?;
        let automatic = Automatic {
            folder: session,
            interval,
            due: Instant::now() + interval,
            count: 0,
            saved_state: None,
            writing: None,
            last: None,
            error: None,
        };
        Ok(Self {
            folder: folder.to_owned(),
            is_new,
            reserve: Arc::new(reserve),
            next: 1,
            automatic,
        })
    }

    /// Changes the interval of automatic saves.
    pub fn set_interval(&mut self, interval: Duration) {
        self.automatic.interval = interval;
        self.automatic.due = Instant::now() + interval;
    }

    /// The folder of the automatic saves of this session.
    pub fn automatic_folder(&self) -> &Path {
        &self.automatic.folder
    }

    /// The descriptors that are kept for saving.
    pub fn reserve(&self) -> Arc<Reserve> {
        Arc::clone(&self.reserve)
    }

    /// Saves a run under the next free number, with what was measured so far; returns its folder
    /// too.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn save(
        &mut self,
        run: &InteractiveRun,
        measured: &MeasuredBefore,
    ) -> Result<(PathBuf, Saved)> {
        let _room = self.reserve.release();
        let (number, path) =
            take_number(&self.folder, "", self.next).context("the run cannot be saved")?;
        self.next = number;
        let saved = run
            .save_with(&path, measured)
            .context("the run cannot be saved")?;
        Ok((path, saved))
    }

    /// Begins an automatic save in the background if one is due and the run has changed since the
    /// last. It works on a copy: the run itself does not change. `measured` returns what was
    /// measured so far.
    pub fn save_if_due(
        &mut self,
        run: &InteractiveRun,
        state: RunState,
        measured: impl FnOnce() -> MeasuredBefore,
    ) {
        let automatic = &mut self.automatic;
        automatic.take_written();
        let is_busy = automatic.writing.is_some() || Instant::now() < automatic.due;
        if is_busy || automatic.saved_state == Some(state) {
            return;
        }
        automatic.start(run.clone(), measured(), state, Arc::clone(&self.reserve));
    }

    /// Saves a run at the end of the session, with what was measured; the automatic saves are then
    /// removed. Without a run, a folder that this program has created and not used is
    /// removed.
    ///
    /// # Errors
    /// It cannot be written. The last automatic save is kept, and named.
    pub fn end(
        &mut self,
        run: Option<&InteractiveRun>,
        measured: &MeasuredBefore,
    ) -> Result<Option<Saved>> {
        let saved = run.map(|run| Ok(self.save(run, measured)?.1)).transpose();
        self.automatic.wait();
        match saved {
            Ok(saved) => {
                // Nothing depends on it.
                let _ = fs::remove_dir_all(&self.automatic.folder);
                if self.is_new && saved.is_none() {
                    let _ = fs::remove_dir(&self.folder);
                }
                Ok(saved)
            }
            Err(error) => Err(self.automatic.named_after(error)),
        }
    }

    /// Saves a run whose thread has ended by an internal error. All automatic saves are kept.
    pub fn rescue(&mut self, run: &InteractiveRun) -> anyhow::Error {
        let words = "the engine has ended by an internal error";
        // What is measured may be the cause.
        let saved = self.save(run, &MeasuredBefore::default());
        self.automatic.wait();
        match saved {
            Ok((_, Saved { time, command, .. })) => {
                let error =
                    anyhow!("{words}; the run was saved at t = {time}; continue with\n  {command}");
                self.automatic.named_after(error)
            }
            Err(error) => self.automatic.named_after(error.context(words)),
        }
    }
}

impl RunStore for SavedRuns {
    fn save(&mut self, run: &InteractiveRun, measured: &MeasuredBefore) -> Result<Value> {
        let (path, saved) = Self::save(self, run, measured)?;
        let folder = path.join(MEASURED);
        Ok(json!({
            "time": saved.time,
            "command": saved.command,
            "measures_from": saved.measures_from,
            "left_out": saved.left_out,
            "measured": (!measured.is_empty()).then(|| folder.to_string_lossy()),
        }))
    }

    fn status(&self) -> Value {
        let Automatic { last, error, .. } = &self.automatic;
        if last.is_none() && error.is_none() {
            return Value::Null;
        }
        let saved = last.as_ref().map(|(_, saved)| saved);
        json!({
            "time": saved.map(|saved| saved.time),
            "command": saved.map(|saved| saved.command.clone()),
            "error": error,
        })
    }
}

impl Automatic {
    /// Begins a save.
    fn start(
        &mut self,
        run: InteractiveRun,
        measured: MeasuredBefore,
        state: RunState,
        reserve: Arc<Reserve>,
    ) {
        self.count += 1;
        let path = self.folder.join(self.count.to_string());
        let save = move || {
            let (begun, _room) = (Instant::now(), reserve.release());
            let saved = run.save_with(&path, &measured);
            Written {
                path,
                saved,
                took: begun.elapsed(),
            }
        };
        match thread::Builder::new()
            .name("automatic save".to_owned())
            .spawn(save)
        {
            Ok(thread) => (self.writing, self.saved_state) = (Some(thread), Some(state)),
            Err(error) => self.has_failed(&error.into()),
        }
    }

    fn has_failed(&mut self, error: &anyhow::Error) {
        (self.error, self.saved_state) = (Some(format!("{error:#}")), None);
        self.due = Instant::now() + self.interval;
    }

    /// Takes the end of a save that has ended, and removes the one before it.
    fn take_written(&mut self) {
        if self.writing.as_ref().is_some_and(JoinHandle::is_finished) {
            self.wait();
        }
    }

    /// Waits for the save that is being written.
    fn wait(&mut self) {
        let Some(thread) = self.writing.take() else {
            return;
        };
        match thread.join() {
            Ok(Written {
                path,
                saved: Ok(saved),
                took,
            }) => {
                if let Some((before, _)) = self.last.replace((path, saved)) {
                    // If it stays, it takes space and is a good save still.
                    let _ = fs::remove_dir_all(before);
                }
                self.error = None;
                self.due = Instant::now() + self.interval.max(took.div_f64(SHARE_OF_SAVES));
            }
            Ok(Written {
                saved: Err(error), ..
            }) => self.has_failed(&error),
            Err(_) => self.has_failed(&anyhow!("an internal error while the run was saved")),
        }
    }

    /// An error with the last automatic save, which is kept.
    fn named_after(&self, error: anyhow::Error) -> anyhow::Error {
        let Some((_, Saved { time, command, .. })) = &self.last else {
            return error;
        };
        anyhow!(
            "{error:#}\nThe last automatic save, at t = {time}, is kept; continue with\n  {command}"
        )
    }
}

/// Creates the folder of the automatic saves of a session, and tries to write into it.
fn start_session(folder: &Path) -> Result<PathBuf> {
    fs::create_dir_all(folder).context("the folder cannot be created")?;
    let (_, session) = take_number(folder, "auto-", 1)?;
    let trial = session.join("trial");
    let written = write_trial(&trial).and_then(|()| fs::remove_file(&trial));
    if written.is_err() {
        // What was created is of no use; the cause is reported.
        let _ = fs::remove_dir_all(&session);
    }
    written.context("a file cannot be written there")?;
    Ok(session)
}

fn write_trial(path: &Path) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(&vec![0; TRIAL])?;
    file.sync_all()
}

/// Creates the folder of the first free number from `first` on; returns both. What exists under a
/// number, such as a link that leads nowhere, is left alone.
fn take_number(folder: &Path, prefix: &str, first: u32) -> Result<(u32, PathBuf)> {
    for number in first..=MAX_NUMBER {
        let path = folder.join(format!("{prefix}{number}"));
        match fs::create_dir(&path) {
            Ok(()) => return Ok((number, path)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => {
                return Err(error)
                    .with_context(|| format!("cannot create the folder {}", path.display()));
            }
        }
    }
    Err(anyhow!(
        "{} holds {MAX_NUMBER} saved runs, the most: choose another folder",
        folder.display()
    ))
}
