//! The placement of the bodies of a run: gases that grow are stored from time to time, so that a
//! run interrupted meanwhile continues from there.

use std::{fs, io, ops::ControlFlow, path::Path, time::Duration};

use anyhow::{Context, Result};
use carom::{
    Scene,
    engine::{Growth, SceneError},
};
use carom_methods::{AnySimulation, Method};

use crate::{
    checkpoint_file::{self, CheckpointBody, encode},
    clock::Instant,
    interruption::Signals,
    other_run::refuse_other_run,
    progress::{Progress, ProgressLines},
};

pub(crate) use crate::file_names::GROWTH;

/// Writes the state of a growth to the folder of a run with this description.
pub fn store(growth: &Growth, what: &str, folder: &Path) -> Result<()> {
    checkpoint_file::write(&folder.join(GROWTH), &[&encode(&what)?, &encode(growth)?])
}

/// Reads the growth in the folder of a run; `None` if there is none.
///
/// # Errors
/// The file is damaged or belongs to a run with another description.
pub fn stored(what: &str, folder: &Path) -> Result<Option<Growth>> {
    let path = folder.join(GROWTH);
    if !path.exists() {
        return Ok(None);
    }
    let read = || -> Result<Growth> {
        let mut body = CheckpointBody::read(&path)?;
        refuse_other_run(&body.take::<String>()?, what)?;
        Ok(body.take()?)
    };
    read()
        .map(Some)
        .with_context(|| format!("cannot resume from {}", path.display()))
}

/// Removes the growth from the folder of a run.
///
/// # Errors
/// The file cannot be removed.
pub fn remove(folder: &Path) -> Result<()> {
    let path = folder.join(GROWTH);
    match fs::remove_file(&path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("cannot remove {}", path.display()))
        }
        _ => Ok(()),
    }
}

/// Places the bodies of one run; shows and stores the progress of a growth.
pub struct BodyPlacement<'a> {
    method: &'a Method,
    signals: &'a Signals,
    /// Writes the growth where it is found again.
    store: &'a mut dyn FnMut(&Growth) -> Result<()>,
    store_every: Duration,
    last_stored: Instant,
    progress: Option<Progress>,
    /// Share of the placement that has been shown, and its collisions.
    reached: (f64, u64),
    error: Option<anyhow::Error>,
}

impl<'a> BodyPlacement<'a> {
    pub fn new(
        method: &'a Method,
        signals: &'a Signals,
        store_every: Duration,
        store: &'a mut dyn FnMut(&Growth) -> Result<()>,
    ) -> Self {
        let (last_stored, progress) = (Instant::now(), None);
        Self {
            method,
            signals,
            store,
            store_every,
            last_stored,
            progress,
            reached: (0.0, 0),
            error: None,
        }
    }

    /// Places the bodies of a scene from the beginning.
    ///
    /// # Errors
    /// The scene is invalid, the growth cannot be stored, or a signal has been received.
    pub fn place(mut self, scene: &Scene) -> Result<AnySimulation> {
        let method = self.method;
        let placed = AnySimulation::with_progress(scene, method, &mut |growth| self.watch(growth));
        self.result(placed)
    }

    /// Continues a growth.
    ///
    /// # Errors
    /// Those of [`Self::place`].
    pub fn resume(mut self, mut growth: Growth) -> Result<AnySimulation> {
        let placed = loop {
            if growth.is_done() {
                break AnySimulation::grown(growth, self.method);
            }
            match growth.step() {
                Err(error) => break Err(error),
                Ok(_) if self.watch(&growth).is_break() => break Err(SceneError::Interrupted),
                Ok(_) => {}
            }
        };
        self.result(placed)
    }

    fn watch(&mut self, growth: &Growth) -> ControlFlow<()> {
        let now = growth.progress();
        // Growth and relaxation take about the same time.
        let reached = 0.5 * (now.smallest_scale + now.relaxed);
        let progress = self
            .progress
            .get_or_insert_with(|| ProgressLines::default().add("placement", 1.0));
        progress.advance(reached - self.reached.0, now.collisions - self.reached.1);
        self.reached = (reached, now.collisions);
        let interrupted = self.signals.check();
        let mut ended = Ok(());
        if interrupted.is_err() || self.last_stored.elapsed() >= self.store_every {
            ended = (self.store)(growth);
            self.last_stored = Instant::now();
        }
        match ended.and(interrupted.map_err(Into::into)) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.error = Some(error);
                ControlFlow::Break(())
            }
        }
    }

    fn result(self, placed: Result<AnySimulation, SceneError>) -> Result<AnySimulation> {
        match self.error {
            Some(error) => Err(error),
            None => Ok(placed?),
        }
    }
}
