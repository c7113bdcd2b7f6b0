//! What all experiments begin and end with: a folder, a word on what is run, the choices, and a manifest.

use anyhow::{Context, Result};
use carom::Scene;
use cpu_time::ProcessTime;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::{
    manifest::Manifest,
    output::{Destination, Folder},
    say,
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
    /// What follows from the command, as further lines of `config.toml`.
    pub configuration: &'a str,
    /// The scenes whose random numbers are told of.
    pub scenes: &'a [&'a Scene],
}

/// An experiment that has begun.
#[derive(Debug)]
pub struct Experiment {
    /// Where it writes.
    pub folder: Folder,
    manifest: Manifest,
    begun: ProcessTime,
}

impl Experiment {
    /// Makes the folder, says what is run, and writes the choices and a manifest.
    ///
    /// # Errors
    /// A folder that is not empty or cannot be written.
    pub fn begin(destination: &Destination, opening: &Opening<'_>) -> Result<Self> {
        let folder = Folder::create(&destination.folder(opening.folder), destination.existing())?;
        if !opening.note.is_empty() {
            say(opening.note);
        }
        let Opening { command, configuration, .. } = opening;
        folder.write("config.toml", format!("command = \"{command}\"\n{configuration}"))?;
        let manifest = Manifest::begin(&folder, opening.command, opening.scenes)?;
        Ok(Self { folder, manifest, begun: ProcessTime::now() })
    }

    /// Notes that it has come to its end, and how much processor time it took.
    ///
    /// # Errors
    /// The manifest cannot be written.
    pub fn complete(self) -> Result<Folder> {
        self.manifest.complete(&self.folder, self.begun.elapsed().as_secs_f64())?;
        Ok(self.folder)
    }
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
            configuration: "seed = 1\n",
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
