//! Kinetic theory as studies: each experiment sweeps a folder of `xtask/studies/theory`, as `carom
//! sweep` does, and compares what is measured with `[[expect]]` of the studies.

use std::path::{Path, PathBuf};

use anyhow::Result;
use carom_experiments::common::{Common, Threads};
use carom_runs::{
    output::{Destination, Resumption},
    resumable::Choices,
};
use carom_sweeps::{several, slurm, sweep};
use carom_tables::Verdict;
use clap::Args;

/// Options of an experiment that consists of studies.
#[derive(Debug, Clone, Args)]
#[command(
    mut_arg("quick", |arg| arg.help("The short form of each study, under two minutes (the default)")),
    mut_arg("paper", |arg| arg.help("The whole studies, for publication"))
)]
pub struct Options {
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
pub fn run(experiment: &str, options: &Options) -> Result<Verdict> {
    let choices = &options.common.destination;
    let resumption = &choices.resumption;
    let out = Some(resumption.folder(&format!("out/{experiment}")));
    let destination = Destination { out, ..resumption.destination.clone() };
    several::run(&sweep::Options {
        studies: vec![folder(experiment)],
        choices: Choices { resumption: Resumption { destination, ..resumption.clone() }, ..choices.clone() },
        replicas: None,
        quick: options.common.is_quick(),
        threads: options.threads.threads,
        shard: None,
        slurm: slurm::Options::default(),
    })
}

/// The folder with the studies of an experiment.
fn folder(experiment: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/theory").join(experiment)
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_sweeps::{Size, Study};

    #[test]
    fn all_studies_are_valid_in_both_forms_and_expect_something() {
        let list = |folder: PathBuf| folder.read_dir().unwrap().map(|entry| entry.unwrap().path());
        let folders = list(folder("")).filter(|path| path.is_dir());
        let studies: Vec<PathBuf> = folders.flat_map(list).collect();
        assert!(studies.len() >= 26, "{studies:?}");
        for study in studies {
            for is_quick in [false, true] {
                let read = Study::read(&study, Size { replicas: None, is_quick });
                let read = read.unwrap_or_else(|error| panic!("{}: {error:#}", study.display()));
                let answers = (0..read.points.len()).flat_map(|point| read.answers(point, &[], &[]));
                assert!(answers.count() > 0, "{}", study.display());
            }
        }
    }
}
