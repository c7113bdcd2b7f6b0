//! Independent work items of one experiment; the result of each finished item is kept in a
//! checkpoint.
//!
//! Guarantees:
//! - A finished item is not computed again after an interruption; its result returns to the bit.
//! - The checkpoint holds the description of the run and the results by name; a checkpoint with
//!   another description is refused.
//! - A kill loses the items in progress and those finished within the last 0.5 s. Items are short.

use std::{
    collections::BTreeMap,
    io,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, OnceLock, PoisonError},
    time::Duration,
};

use anyhow::{Context, Result};
use serde::{Serialize, de::DeserializeOwned};

use crate::{
    checkpoint_file::{self, CheckpointBody, FileError},
    clock::Instant,
    interruption::Signals,
    other_run::refuse_other,
    output::{Folder, Resumption},
    progress::Progress,
    resumable::CHECKPOINT,
};

/// Least time between two checkpoints. Shorter: more disk writes. Longer: a kill loses more work.
const INTERVAL: Duration = Duration::from_millis(500);

/// The finished items of one run. The default value keeps them in memory only.
#[derive(Debug, Default)]
pub struct WorkItems {
    path: Option<PathBuf>,
    what: String,
    signals: Signals,
    finished: Mutex<Finished>,
    progress: OnceLock<Progress>,
}

#[derive(Debug, Default)]
struct Finished {
    /// Encoded results.
    by_name: BTreeMap<String, Vec<u8>>,
    saved: Option<Instant>,
    is_saved: bool,
}

impl WorkItems {
    /// Reads the finished items of an earlier process if the run is to be resumed. Writes nothing.
    ///
    /// # Errors
    /// The checkpoint cannot be read or belongs to another run.
    pub fn find(
        folder: &Folder,
        what: String,
        resumption: &Resumption,
        signals: Signals,
    ) -> Result<Self> {
        let path = folder.path().join(CHECKPOINT);
        let by_name = if resumption.resume {
            read(&path, &what).with_context(|| format!("cannot resume from {}", path.display()))?
        } else {
            BTreeMap::new()
        };
        let finished = Finished {
            by_name,
            ..Finished::default()
        };
        let progress = OnceLock::new();
        Ok(Self {
            path: Some(path),
            what,
            signals,
            finished: Mutex::new(finished),
            progress,
        })
    }

    /// Replaces an older checkpoint.
    ///
    /// # Errors
    /// The checkpoint cannot be written.
    pub fn start(&self) -> Result<()> {
        let mut finished = self.lock();
        self.save(&mut finished)?;
        // Makes the first finished item write a checkpoint at once.
        finished.saved = None;
        Ok(())
    }

    /// Shows the progress of this number of items, for experiments without a [`Progress`] of their
    /// own. The first call counts.
    pub fn expect(&self, number: usize) {
        self.progress
            .get_or_init(|| Progress::items("parts", number as u64));
    }

    /// Returns true if the item has finished.
    pub fn has(&self, name: &str) -> bool {
        self.lock().by_name.contains_key(name)
    }

    /// Signals that end the program.
    pub fn signals(&self) -> &Signals {
        &self.signals
    }

    /// Returns the result of an item: the stored one, or else that of `work`, which is then stored.
    ///
    /// # Errors
    /// The work fails, a signal has been received, or a checkpoint cannot be written or does not
    /// fit this program.
    pub fn finish<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        work: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        if let Some(kept) = self.lock().by_name.get(name) {
            self.progress.get().inspect(|progress| progress.skip(1.0));
            return checkpoint_file::decode(kept)
                .with_context(|| format!("cannot read the stored result of {name}"));
        }
        let done = self
            .signals
            .check()
            .map_err(Into::into)
            .and_then(|()| work());
        let mut finished = self.lock();
        if let Ok(result) = &done {
            self.progress.get().inspect(|progress| progress.count(1));
            finished
                .by_name
                .insert(name.to_owned(), checkpoint_file::encode(result)?);
            finished.is_saved = false;
        }
        let timely = finished
            .saved
            .is_none_or(|saved| saved.elapsed() >= INTERVAL);
        // After a failure or a signal every thread saves, so the last one saves all results.
        if timely || done.is_err() || self.signals.check().is_err() {
            self.save(&mut finished)?;
        }
        done
    }

    /// Writes the results that are not yet in the checkpoint.
    ///
    /// # Errors
    /// The checkpoint cannot be written.
    pub fn end(&self) -> Result<()> {
        self.save(&mut self.lock())
    }

    fn save(&self, finished: &mut Finished) -> Result<()> {
        if let Some(path) = self.path.as_ref().filter(|_| !finished.is_saved) {
            let parts = [
                checkpoint_file::encode(&self.what)?,
                checkpoint_file::encode(&finished.by_name)?,
            ];
            checkpoint_file::write(path, &[&parts[0], &parts[1]])?;
            finished.is_saved = true;
            finished.saved = Some(Instant::now());
        }
        Ok(())
    }

    fn lock(&self) -> MutexGuard<'_, Finished> {
        self.finished.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn read(path: &Path, what: &str) -> Result<BTreeMap<String, Vec<u8>>> {
    let mut body = match CheckpointBody::read(path) {
        // The run was killed before its first checkpoint.
        Err(FileError::Unreadable(error)) if error.kind() == io::ErrorKind::NotFound => {
            return Ok(BTreeMap::new());
        }
        body => body?,
    };
    let there: String = body.take()?;
    refuse_other(&there, what)?;
    Ok(body.take()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Existing;
    use anyhow::bail;

    fn items(folder: &Folder, what: &str, resume: bool) -> Result<WorkItems> {
        let resumption = Resumption {
            resume,
            ..Resumption::default()
        };
        WorkItems::find(folder, what.to_owned(), &resumption, Signals::default())
    }

    #[test]
    fn a_finished_item_is_not_computed_again_and_returns_to_the_bit() {
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let first = items(&folder, "a run", false).unwrap();
        first.start().unwrap();
        let sum: f64 = 0.1 + 0.2;
        assert_eq!(
            first.finish("a", || Ok(vec![sum, -0.0])).unwrap(),
            [sum, -0.0]
        );
        assert!(first.finish::<u8>("b", || bail!("broken")).is_err());
        drop(first);

        let again = items(&folder, "a run", true).unwrap();
        assert!(again.has("a") && !again.has("b"));
        let kept: Vec<f64> = again.finish("a", || bail!("done again")).unwrap();
        assert_eq!(
            kept.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
            [sum.to_bits(), (-0.0f64).to_bits()]
        );
        assert_eq!(again.finish("b", || Ok(7u8)).unwrap(), 7);
        assert!(
            again.finish::<String>("b", || Ok(String::new())).is_err(),
            "it is a number"
        );
    }

    #[test]
    fn a_checkpoint_of_another_run_is_refused_unless_the_run_starts_anew() {
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let first = items(&folder, "a run", false).unwrap();
        first.finish("a", || Ok(1u8)).unwrap();
        first.end().unwrap();
        let refused = format!("{:#}", items(&folder, "another", true).unwrap_err());
        assert!(
            refused.contains("another run: its line `a run` differs from `another`"),
            "{refused}"
        );
        let forced = items(&folder, "another", false).unwrap();
        assert!(!forced.has("a"));
        forced.start().unwrap();
        assert!(items(&folder, "another", true).is_ok());
    }
}
