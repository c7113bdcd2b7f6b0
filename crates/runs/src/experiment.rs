//! What all experiments begin and end with: a folder, a word on what is run, the choices, and a manifest.

use std::fs::File;

use anyhow::{Context, Result};
use carom::Scene;
use cpu_time::ProcessTime;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::{
    interruption::Signals,
    manifest::Manifest,
    output::{Destination, Folder, Resumption},
    say,
    work_items::Pieces,
};

/// What is said and written before an experiment begins.
#[derive(Debug)]
pub struct Opening<'a> {
    /// Folder to write to, if no other is asked for.
    pub folder: &'a str,
    /// What is to be known of the plan before anything else, if anything.
    pub note: &'a str,
    /// The command with every choice written out that the results depend on.
    pub command: &'a str,
    /// `config.toml`: all that is needed to run it again.
    pub configuration: String,
    /// The scenes whose random numbers are told of.
    pub scenes: &'a [&'a Scene],
}

/// An experiment that has begun.
#[derive(Debug)]
pub struct Experiment {
    /// Where it writes.
    pub folder: Folder,
    /// What is finished of it, where its work comes in pieces.
    pub pieces: Pieces,
    _alone: Option<File>,
    manifest: Manifest,
    begun: ProcessTime,
}

impl Experiment {
    /// Makes the folder, says what is run, and writes the choices and a manifest.
    ///
    /// # Errors
    /// A folder that is not empty or cannot be written, or that another process writes into.
    pub fn begin(destination: &Destination, opening: &Opening<'_>) -> Result<Self> {
        let folder = Folder::create(&destination.folder(opening.folder), destination.existing())?;
        Self::begin_in(folder, opening, |_| Ok(Pieces::default()))
    }

    /// Begins or goes on with an experiment whose work comes in pieces. `what` tells runs apart that must not be mixed.
    ///
    /// # Errors
    /// The same, or a checkpoint that cannot be read or is of another run.
    pub fn begin_in_pieces(resumption: &Resumption, what: String, opening: &Opening<'_>) -> Result<Self> {
        let signals = Signals::watch()?;
        let folder = Folder::create(&resumption.folder(opening.folder), resumption.existing())?;
        Self::begin_in(folder, opening, |folder| Pieces::find(folder, what, resumption, signals))
    }

    fn begin_in(
        folder: Folder,
        opening: &Opening<'_>,
        find: impl FnOnce(&Folder) -> Result<Pieces>,
    ) -> Result<Self> {
        let alone = folder.lock()?;
        let pieces = find(&folder)?;
        if !opening.note.is_empty() {
            say(opening.note);
        }
        folder.write("config.toml", &opening.configuration)?;
        let manifest = Manifest::begin(&folder, opening.command, opening.scenes)?;
        pieces.begin()?;
        Ok(Self { folder, pieces, _alone: alone, manifest, begun: ProcessTime::now() })
    }

    /// Notes that it has come to its end, and how much processor time it took.
    ///
    /// # Errors
    /// The manifest cannot be written.
    pub fn complete(self) -> Result<Folder> {
        let seconds = self.begun.elapsed().as_secs_f64();
        self.complete_after(seconds)
    }

    /// The same, where earlier processes have taken a part of the processor time (seconds).
    ///
    /// # Errors
    /// As [`Self::complete`].
    pub fn complete_after(self, seconds: f64) -> Result<Folder> {
        self.pieces.end()?;
        self.manifest.complete(&self.folder, seconds)?;
        Ok(self.folder)
    }
}

/// A command as the first line of `config.toml`, before what follows from it.
pub fn configuration(command: &str, more: &str) -> String {
    format!("command = \"{command}\"\n{more}")
}

/// So many threads, or as many as there are processors.
///
/// # Errors
/// The system does not give them.
pub fn threads(wanted: Option<u16>) -> Result<ThreadPool> {
    ThreadPoolBuilder::new().num_threads(usize::from(wanted.unwrap_or(0))).build().context("threads")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_experiment_leaves_its_choices_and_a_manifest_that_tells_whether_it_has_ended() {
        let root = tempfile::tempdir().unwrap();
        let destination = Destination { out: Some(root.path().to_owned()), force: false };
        let opening = Opening {
            folder: "out/never",
            note: "",
            command: "cargo xtask experiment none",
            configuration: configuration("cargo xtask experiment none", "seed = 1\n"),
            scenes: &[],
        };
        let experiment = Experiment::begin(&destination, &opening).unwrap();
        assert_eq!(
            experiment.folder.read("config.toml").unwrap(),
            "command = \"cargo xtask experiment none\"\nseed = 1\n"
        );
        assert!(!Manifest::is_complete(&experiment.folder));
        assert!(Manifest::is_complete(&experiment.complete().unwrap()));
        assert!(Experiment::begin(&destination, &opening).is_err(), "nothing is overwritten unasked");
        assert!(Experiment::begin(&Destination { force: true, ..destination }, &opening).is_ok());
    }
}
