//! Where runs are saved: folders of the machine, or files for the page.

use anyhow::Result;
use carom_runs::run::interactive::{InteractiveRun, MeasuredBefore};
use serde_json::Value;

/// What distinguishes two states of the runs of a session: time, collisions, and the version of the
/// list of bodies, which changes with each edit.
#[cfg(feature = "server")]
pub type RunState = (carom::EpochTime, u64, u32);

/// A place for saved runs.
pub trait RunStore {
    /// Saves a run on request, with what was measured so far; returns what the page shows
    /// of it.
    ///
    /// # Errors
    /// It cannot be saved.
    fn save(&mut self, run: &InteractiveRun, measured: &MeasuredBefore) -> Result<Value>;

    /// The last save without a request, for the page; null if there is none.
    fn status(&self) -> Value;
}
