//! Start and end of every experiment: folder, note to the user, configuration, and manifest.

use anyhow::{Context, Result};
use carom::Scene;
use carom_report::page::Page;
use carom_tables::{Summary, Verdict};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::{
    clock::ProcessTime,
    conclude,
    console::note,
    folder_lock::FolderLock,
    interruption::Signals,
    manifest::Manifest,
    output::{Destination, Folder, Resumption},
    work_items::WorkItems,
};

/// Texts and files at the start of an experiment.
#[derive(Debug)]
pub struct Opening<'a> {
    /// Default output folder.
    pub folder: &'a str,
    /// Note that is printed first; may be empty.
    pub note: &'a str,
    /// The command with every option that affects the results.
    pub command: &'a str,
    /// `config.toml`: everything necessary to repeat the experiment.
    pub configuration: String,
    /// Scenes whose random streams the manifest lists.
    pub scenes: &'a [&'a Scene],
}

/// An experiment in progress.
#[derive(Debug)]
pub struct Experiment {
    /// Output folder.
    pub folder: Folder,
    /// Finished work items, for experiments that consist of them.
    pub items: WorkItems,
    _alone: FolderLock,
    manifest: Manifest,
    begun: ProcessTime,
}

impl Experiment {
    /// Creates the folder, prints the note, and writes configuration and manifest.
    ///
    /// # Errors
    /// The folder is not empty, cannot be written, or is in use by another process.
    pub fn start(destination: &Destination, opening: &Opening<'_>) -> Result<Self> {
        let claimed = Folder::claim(&destination.folder(opening.folder), destination.existing())?;
        Self::start_in(claimed, opening, |_| Ok(WorkItems::default()))
    }

    /// Creates the folder for an experiment that writes all of its files at its end, also its
    /// configuration, by itself: the folder of one that does not end holds no result.
    ///
    /// # Errors
    /// The folder is not empty, cannot be created, or is in use by another process.
    pub fn reserve(destination: &Destination, opening: &Opening<'_>) -> Result<Self> {
        let (folder, alone) =
            Folder::claim(&destination.folder(opening.folder), destination.existing())?;
        if !opening.note.is_empty() {
            note(opening.note);
        }
        let manifest = Manifest::new(opening.command, opening.scenes, None);
        let (items, begun) = (WorkItems::default(), ProcessTime::now());
        Ok(Self {
            folder,
            items,
            _alone: alone,
            manifest,
            begun,
        })
    }

    /// Starts or resumes an experiment of work items. `what` identifies the run in its checkpoint.
    ///
    /// # Errors
    /// The folder is not empty, cannot be written, or is in use by another process; the checkpoint
    /// cannot be read or belongs to another run.
    pub fn start_resumable(
        resumption: &Resumption,
        what: String,
        opening: &Opening<'_>,
    ) -> Result<Self> {
        let signals = Signals::watch()?;
        let claimed = Folder::claim(&resumption.folder(opening.folder), resumption.existing())?;
        Self::start_in(claimed, opening, |folder| {
            WorkItems::find(folder, what, resumption, signals)
        })
    }

    fn start_in(
        (folder, alone): (Folder, FolderLock),
        opening: &Opening<'_>,
        find: impl FnOnce(&Folder) -> Result<WorkItems>,
    ) -> Result<Self> {
        let items = find(&folder)?;
        if !opening.note.is_empty() {
            note(opening.note);
        }
        // The manifest is the first file: a folder with any other and without it cannot be resumed.
        let manifest = Manifest::write_new(&folder, opening.command, opening.scenes)?;
        folder.write("config.toml", &opening.configuration)?;
        items.start()?;
        Ok(Self {
            folder,
            items,
            _alone: alone,
            manifest,
            begun: ProcessTime::now(),
        })
    }

    /// Writes page and summary, records the end in the manifest, prints totals and failed checks,
    /// and returns the verdict. `seconds` is the processor time, if other processes contributed to
    /// it.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish(self, page: &Page, summary: &Summary, seconds: Option<f64>) -> Result<Verdict> {
        self.folder.write("report.html", page.html())?;
        self.folder.write_json("summary.json", summary)?;
        let seconds = seconds.unwrap_or_else(|| self.begun.elapsed().as_secs_f64());
        conclude(&self.complete_after(seconds)?, summary, None);
        Ok(summary.verdict())
    }

    /// Records the end of the experiment and its processor time in the manifest.
    ///
    /// # Errors
    /// The manifest cannot be written.
    pub fn complete(self) -> Result<Folder> {
        let seconds = self.begun.elapsed().as_secs_f64();
        self.complete_after(seconds)
    }

    /// Records the end of the experiment and its processor time, to which earlier processes
    /// contributed `seconds`.
    ///
    /// # Errors
    /// The manifest cannot be written.
    pub fn complete_after(self, seconds: f64) -> Result<Folder> {
        self.items.end()?;
        self.manifest.complete(&self.folder, seconds)?;
        Ok(self.folder)
    }
}

/// Content of `config.toml`: the command as the first line, then `more`.
pub fn configuration(command: &str, more: &str) -> String {
    format!("command = {}\n{more}", toml::Value::from(command))
}

/// Creates a pool of `requested` threads, or of one for each processor.
///
/// # Errors
/// The system cannot create the threads.
pub fn threads(requested: Option<u16>) -> Result<ThreadPool> {
    ThreadPoolBuilder::new()
        .num_threads(usize::from(requested.unwrap_or(0)))
        .build()
        .context("threads")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_experiment_that_writes_at_its_end_leaves_its_folder_empty_until_then() {
        let root = tempfile::tempdir().unwrap();
        let destination = Destination {
            out: Some(root.path().to_owned()),
            force: false,
        };
        let opening = Opening {
            folder: "out/never",
            note: "",
            command: "carom trade none",
            configuration: String::new(),
            scenes: &[],
        };
        drop(Experiment::reserve(&destination, &opening).unwrap());
        let experiment = Experiment::reserve(&destination, &opening).unwrap();
        assert!(
            Experiment::reserve(&destination, &opening).is_err(),
            "another one holds the folder"
        );
        assert!(Manifest::is_complete(&experiment.complete().unwrap()));
        assert!(
            Experiment::reserve(&destination, &opening).is_err(),
            "nothing is overwritten"
        );
    }

    #[test]
    fn an_experiment_writes_its_configuration_and_a_manifest_with_its_state() {
        let root = tempfile::tempdir().unwrap();
        let destination = Destination {
            out: Some(root.path().to_owned()),
            force: false,
        };
        let opening = Opening {
            folder: "out/never",
            note: "",
            command: "cargo xtask experiment none",
            configuration: configuration("cargo xtask experiment none", "seed = 1\n"),
            scenes: &[],
        };
        let experiment = Experiment::start(&destination, &opening).unwrap();
        assert_eq!(
            experiment.folder.read("config.toml").unwrap(),
            "command = \"cargo xtask experiment none\"\nseed = 1\n"
        );
        assert!(!Manifest::is_complete(&experiment.folder));
        assert!(Manifest::is_complete(&experiment.complete().unwrap()));
        assert!(
            Experiment::start(&destination, &opening).is_err(),
            "nothing is overwritten without --force"
        );
        assert!(
            Experiment::start(
                &Destination {
                    force: true,
                    ..destination
                },
                &opening
            )
            .is_ok()
        );
    }

    #[test]
    fn a_command_with_quotes_stays_one_value_of_the_configuration() {
        let command = "carom run 'a \"b\" \\c.toml'";
        let table: toml::Table = configuration(command, "seed = 1\n").parse().unwrap();
        assert_eq!(
            (table["command"].as_str(), table["seed"].as_integer()),
            (Some(command), Some(1))
        );
    }

    /// The folder that a process leaves if it is killed before its manifest.
    #[test]
    fn an_experiment_killed_at_its_start_can_be_started_and_resumed() {
        let opening = Opening {
            folder: "out/never",
            note: "",
            command: "cargo xtask experiment none",
            configuration: "seed = 1\n".to_owned(),
            scenes: &[],
        };
        for resume in [false, true] {
            let root = tempfile::tempdir().unwrap();
            let destination = Destination {
                out: Some(root.path().to_owned()),
                force: false,
            };
            let (folder, lock) = Folder::claim(root.path(), destination.existing()).unwrap();
            folder.write("config.toml", "half").unwrap();
            std::fs::write(root.path().join("manifest.json.part"), "{").unwrap();
            // The file of the lock stays too after a kill.
            drop(lock);
            std::fs::write(root.path().join(crate::folder_lock::LOCK), "").unwrap();
            let resumption = Resumption {
                destination,
                resume,
            };
            let experiment =
                Experiment::start_resumable(&resumption, "none".to_owned(), &opening).unwrap();
            assert_eq!(experiment.folder.read("config.toml").unwrap(), "seed = 1\n");
        }
    }
}
