//! Experiments that consist of studies: each sweeps those that belong to it, as `carom sweep` does,
//! and compares what is measured with `[[expect]]` of the studies.

use std::path::{Path, PathBuf};

use crate::experiments::common::{Common, Threads};
use anyhow::Result;
use carom_runs::resumable::Choices;
use carom_sweeps::{
    several, slurm,
    sweep::{self, How},
};
use carom_tables::Verdict;
use clap::Args;

/// Options of an experiment that consists of studies.
#[derive(Debug, Clone, Args)]
#[command(
    mut_arg("quick", |arg| arg.help("The short form of each study, under two minutes (the default)")),
    mut_arg("paper", |arg| arg.help("The whole studies, for publication"))
)]
pub struct StudiesOptions {
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<Choices>,
    /// Threads.
    #[command(flatten)]
    pub threads: Threads,
}

/// Runs the studies of an experiment.
///
/// # Errors
/// Those of [`several::run`].
pub fn run(experiment: &str, options: &StudiesOptions) -> Result<Verdict> {
    let mut choices = options.common.destination.clone();
    choices.resumption.destination.out =
        Some(choices.resumption.folder(&format!("out/{experiment}")));
    let (threads, slurm) = (options.threads.threads, slurm::SlurmOptions::default());
    several::run(&sweep::SweepOptions {
        studies: studies(experiment),
        quick: options.common.is_quick(),
        how: How {
            choices,
            replicas: None,
            threads,
            shard: None,
            slurm,
        },
    })
}

/// Folder of the studies that are compared with theory, which the program carries as examples.
fn theory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/runs/examples/theory")
}

/// The studies of an experiment: a folder of `crates/runs/examples/theory`, or the files of
/// `xtask/studies` that begin with its name.
fn studies(experiment: &str) -> Vec<PathBuf> {
    let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies");
    let folder = theory().join(experiment);
    if folder.is_dir() {
        return vec![folder];
    }
    let has_name = |path: &PathBuf| {
        path.file_stem()
            .is_some_and(|stem| stem.to_string_lossy().split('-').next() == Some(experiment))
    };
    let entries = studies.read_dir().into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(has_name).collect();
    files.sort();
    files
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_sweeps::{Size, Study};

    #[test]
    fn all_studies_are_valid_in_both_forms_and_expect_something() {
        let list = |folder: PathBuf| {
            folder
                .read_dir()
                .unwrap()
                .map(|entry| entry.unwrap().path())
        };
        let mut all: Vec<PathBuf> = list(theory())
            .filter(|path| path.is_dir())
            .flat_map(list)
            .collect();
        all.extend(["brownian", "billiard"].into_iter().flat_map(studies));
        assert!(all.len() >= 29, "{all:?}");
        for study in all {
            for is_quick in [false, true] {
                let read = Study::read(
                    &study,
                    Size {
                        replicas: None,
                        is_quick,
                    },
                );
                let read = read.unwrap_or_else(|error| panic!("{}: {error:#}", study.display()));
                let answers =
                    (0..read.points.len()).flat_map(|point| read.answers(point, &[], &[]));
                assert!(answers.count() > 0, "{}", study.display());
            }
        }
    }
}
