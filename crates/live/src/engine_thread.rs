//! The thread of the laboratory of a server: it receives commands and saves the run.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Arc,
        mpsc::{Receiver, RecvTimeoutError},
    },
};

use anyhow::{Result, anyhow};
use carom::Scene;
use carom_runs::{interruption::Signals, run::interactive::Saved};

use crate::{
    laboratory::{Laboratory, Message, OpenRun},
    saved_runs::SavedRuns,
    viewers::Viewers,
};

/// Commands that are executed one after another without a frame.
const MAX_COMMANDS: usize = 32;

/// How the laboratory has ended.
#[derive(Debug, Default)]
pub struct LaboratoryEnd {
    /// The run as it was then; `None` if no scene was open.
    pub saved: Option<Saved>,
}

/// A laboratory that saves its runs in folders and ends with a signal.
pub struct EngineThread {
    laboratory: Laboratory<SavedRuns>,
    signals: Signals,
}

impl EngineThread {
    /// A laboratory for these pages.
    pub fn new(viewers: Arc<Viewers>, saved_runs: SavedRuns, signals: Signals) -> Self {
        Self {
            laboratory: Laboratory::new(viewers, saved_runs, signals.clone()),
            signals,
        }
    }

    /// Opens the scene, if one is given, and runs until a signal is received or no page can come
    /// any more; then the run is saved, also after a panic.
    ///
    /// # Errors
    /// The scene is invalid, the run cannot be saved, or there was a panic; then the error names
    /// the saved run.
    pub fn run(
        &mut self,
        scene: Option<(String, Scene)>,
        messages: &Receiver<Message>,
    ) -> Result<LaboratoryEnd> {
        self.guard(|thread| {
            let laboratory = &mut thread.laboratory;
            let opened = scene.map_or(Ok(()), |(name, scene)| laboratory.open(name, &scene));
            if opened.is_ok() {
                thread.serve(messages);
            }
            let (open, saved_runs) = thread.laboratory.run_and_store();
            let measured = open.map(OpenRun::measured).unwrap_or_default();
            let saved = saved_runs.end(open.map(OpenRun::run), &measured)?;
            // A scene whose bodies were being placed when a signal came is no invalid one.
            if thread.signals.check().is_ok() {
                opened.map(|()| LaboratoryEnd { saved })
            } else {
                Ok(LaboratoryEnd { saved })
            }
        })
    }

    /// Executes `serve`; if it panics, saves the run.
    fn guard(
        &mut self,
        serve: impl FnOnce(&mut Self) -> Result<LaboratoryEnd>,
    ) -> Result<LaboratoryEnd> {
        let served = catch_unwind(AssertUnwindSafe(|| serve(self)));
        served.unwrap_or_else(|_| {
            let rescued = catch_unwind(AssertUnwindSafe(|| {
                let (open, saved_runs) = self.laboratory.run_and_store();
                open.map(|open| saved_runs.rescue(open.run()))
            }));
            Err(rescued.ok().flatten().unwrap_or_else(panicked))
        })
    }

    /// Runs until a signal is received or no page can come any more.
    fn serve(&mut self, messages: &Receiver<Message>) {
        loop {
            let pause = self.laboratory.run_piece();
            match messages.recv_timeout(pause) {
                Ok(message) => {
                    self.laboratory.obey(message);
                    for message in messages.try_iter().take(MAX_COMMANDS) {
                        if self.signals.check().is_err() {
                            break;
                        }
                        self.laboratory.obey(message);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            self.laboratory.report();
            if let (Some(open), saved_runs) = self.laboratory.run_and_store() {
                saved_runs.save_if_due(open.run(), open.state(), || open.measured());
            }
            if self.signals.check().is_err() {
                break;
            }
        }
    }
}

/// The error of a thread that has panicked.
pub fn panicked() -> anyhow::Error {
    anyhow!("the engine has ended by an internal error")
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_panic_of_the_engine_leaves_a_saved_run_that_the_error_names() {
        let root = tempfile::tempdir().unwrap();
        let saved_runs =
            SavedRuns::open(&root.path().join("saved"), Duration::from_secs(30)).unwrap();
        let mut thread = EngineThread::new(Arc::default(), saved_runs, Signals::default());
        let gas = "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 20";
        let ended = thread.guard(|thread| {
            thread
                .laboratory
                .open("gas".to_owned(), &Scene::from_toml(gas)?)?;
            panic!("a fault of the engine");
        });
        let words = ended.unwrap_err().to_string();
        assert!(
            words.contains("internal error") && words.contains("--resume"),
            "{words}"
        );
        assert!(root.path().join("saved/1/checkpoint").exists());
    }
}
