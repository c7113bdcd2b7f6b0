//! A campaign: the molecules, their runs and times, and where the results go.

use carom_runs::resumable::Choices;

use super::{plan::Plan, setting::Setting};
use crate::common::Threads;

/// Runs of several molecules, each in its gas.
#[derive(Debug)]
pub struct Campaign<'a> {
    /// The molecules, at least one.
    pub settings: Vec<Setting>,
    /// Runs of each molecule, which differ in their random numbers only.
    pub replicas: u64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Times of each run.
    pub plan: Plan,
    /// Largest number of rows of `impulses.csv` in each run.
    pub impulses: u64,
    /// Folder, and whether to resume there.
    pub choices: &'a Choices,
    /// Default output folder.
    pub usual_folder: String,
    /// Number of threads.
    pub threads: Threads,
    /// Name of the command; with the scene, `from` and `impulses` it identifies a run in its
    /// checkpoint.
    pub program: &'static str,
    /// The command with every option that affects the results.
    pub command: String,
    /// Note that is printed and shown first; may be empty.
    pub note: String,
    /// `config.toml` of several runs: the options; each run's folder holds its scene.
    pub configuration: String,
    /// Title of the page of several runs.
    pub title: String,
}
