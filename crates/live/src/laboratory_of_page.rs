//! A laboratory for one page, whose host passes the messages and provides the clock.

use std::{path::Path, sync::Arc, time::Duration};

use anyhow::Result;
use base64::{Engine as _, engine::general_purpose::STANDARD};
use carom_runs::{
    interruption::Signals,
    run::interactive::{InteractiveRun, MEASURED, MeasuredBefore},
};
use serde_json::{Value, json};

use crate::{
    laboratory::Laboratory,
    requests::{self, hello},
    run_store::RunStore,
    viewers::{Outgoing, Viewer, Viewers},
    zip_file::archive,
};

/// The folder of a saved run, in its archive.
const FOLDER: &str = "run";

/// Saved runs are archives that the page downloads.
#[derive(Debug)]
struct Downloads;

impl RunStore for Downloads {
    fn save(&mut self, run: &InteractiveRun, measured: &MeasuredBefore) -> Result<Value> {
        let (saved, files) = run.files(Path::new(FOLDER), measured)?;
        let files: Vec<_> = files
            .into_iter()
            .map(|(name, content)| (format!("{FOLDER}/{name}"), content))
            .collect();
        Ok(json!({
            "time": saved.time,
            "command": saved.command,
            "measures_from": saved.measures_from,
            "left_out": saved.left_out,
            "measured": (!measured.is_empty()).then(|| format!("{FOLDER}/{MEASURED}")),
            "archive": STANDARD.encode(archive(&files)),
        }))
    }

    fn status(&self) -> Value {
        Value::Null
    }
}

/// A laboratory with one page and without threads, files and sockets.
pub struct LaboratoryOfPage {
    laboratory: Laboratory<Downloads>,
    viewers: Arc<Viewers>,
    viewer: Arc<Viewer>,
}

impl LaboratoryOfPage {
    /// A laboratory without an open scene; the first message greets the page.
    pub fn new() -> Option<Self> {
        let viewers = Arc::<Viewers>::default();
        let viewer = viewers.join()?;
        viewer.answer(&hello(true));
        let laboratory = Laboratory::new(Arc::clone(&viewers), Downloads, Signals::default());
        Some(Self {
            laboratory,
            viewers,
            viewer,
        })
    }

    /// Executes a request of the page (JSON).
    pub fn receive(&mut self, text: &str) {
        let laboratory = &mut self.laboratory;
        requests::receive(text, &self.viewer, &self.viewers, |message| {
            laboratory.obey(message);
            Ok(())
        });
    }

    /// Runs one piece and prepares the messages that are due; returns the time until there is
    /// something to do besides requests.
    pub fn advance(&mut self) -> Duration {
        let pause = self.laboratory.run_piece();
        self.laboratory.report();
        pause
    }

    /// The next message to the page, if one waits.
    pub fn next(&self) -> Option<Outgoing> {
        self.viewer.take().ok().flatten()
    }
}
