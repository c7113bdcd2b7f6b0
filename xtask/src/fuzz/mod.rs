//! `cargo xtask fuzz`: tests detection, whole scenes, tiles and file readers with random input.
//!
//! Each fuzzer compares the code under test with independent references: kinematics between
//! reported events ([`scenes::kinematics`]), a search in extended precision
//! ([`carom_testkit::oracle`]), the run in the global order, and the rule that no input causes a
//! panic, a hang, a NaN or an overlap.
//!
//! A run has a seed. Each of its cases has its own seed, derived from the seed of the run and its
//! number, and is a pure function of it. Cases run in a separate process, so that a hang, an abort
//! or a lack of memory ends that process only. A failing case is minimised and written to a file
//! with the command to replay it.

pub mod campaign;
pub mod detection;
pub mod files;
pub mod minimise;
pub mod planted;
pub mod random;
pub mod scenes;
pub mod subject;
pub mod tiles;
pub mod worker;

use std::{env, path::PathBuf, time::Duration};

use anyhow::{Context as _, Result, bail, ensure};
use carom::Exact;
use carom_runs::interruption::Signals;
use carom_tables::Verdict;
use clap::{Args, Subcommand};

use self::{
    campaign::{Findings, FuzzPlan},
    detection::Queries,
    files::Mutations,
    planted::Planted,
    scenes::{Scenes, Sound},
    subject::Subject,
    tiles::TilesFuzzer,
    worker::Worker,
};

/// The fuzzers.
#[derive(Debug, Subcommand)]
pub enum Fuzz {
    /// Random scenes with edits, checked by independent kinematics between reported events
    Scenes(FuzzOptions),
    /// Random queries to the exact detector, checked by a search in extended precision
    Detection(FuzzOptions),
    /// Mutated scene files, encounter files and checkpoints
    Files(FuzzOptions),
    /// Random gases in tiles with narrow borders, compared with the run in order to the bit
    Tiles(FuzzOptions),
}

/// Options of a fuzzer.
#[derive(Debug, Clone, Args)]
pub struct FuzzOptions {
    /// Time during which cases are started (minutes)
    #[arg(long, default_value_t = 1.0)]
    pub minutes: f64,
    /// Seed of the run
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Largest number of cases
    #[arg(long, default_value_t = u64::MAX)]
    pub cases: u64,
    /// Run only the case of this number
    #[arg(long, conflicts_with_all = ["only", "replay"])]
    pub case: Option<u64>,
    /// Run only the case of this seed
    #[arg(long, value_name = "SEED", conflicts_with = "replay")]
    pub only: Option<u64>,
    /// Run the case in this file, written after a failure
    #[arg(long, value_name = "FILE")]
    pub replay: Option<PathBuf>,
    /// Folder for failing cases
    #[arg(long, default_value = "out/fuzz")]
    pub out: PathBuf,
}

/// Longest run (minutes): a week.
const MAX_MINUTES: f64 = 10_080.0;

/// Runs a fuzzer.
///
/// # Errors
/// An option is out of range, a file cannot be read or written, or a worker cannot be started.
pub fn run(fuzz: &Fuzz) -> Result<Verdict> {
    match fuzz {
        Fuzz::Scenes(options) => run_subject(&Scenes::<Sound>::default(), options),
        Fuzz::Detection(options) => run_subject(&Queries::<Exact>::default(), options),
        Fuzz::Files(options) => run_subject(&Mutations, options),
        Fuzz::Tiles(options) => run_subject(&TilesFuzzer, options),
    }
}

/// Runs the cases that the parent process sends.
///
/// # Errors
/// There is no such fuzzer, or the parent process has ended.
pub fn work(name: &str) -> Result<()> {
    match name {
        Scenes::<Sound>::NAME => worker::work(&Scenes::<Sound>::default()),
        Queries::<Exact>::NAME => worker::work(&Queries::<Exact>::default()),
        Mutations::NAME => worker::work(&Mutations),
        TilesFuzzer::NAME => worker::work(&TilesFuzzer),
        Planted::NAME => worker::work(&Planted),
        _ => bail!("there is no fuzzer '{name}'"),
    }
}

fn run_subject<S: Subject>(subject: &S, options: &FuzzOptions) -> Result<Verdict> {
    ensure!(
        options.minutes > 0.0 && options.minutes <= MAX_MINUTES,
        "--minutes must be positive and at most {MAX_MINUTES}, but is {}",
        options.minutes
    );
    let program = env::current_exe().context("cannot find this program")?;
    let mut worker = Worker::new(
        program,
        S::NAME,
        Duration::from_secs(S::TIME_LIMIT),
        Signals::watch()?,
    );
    let only = options.only.or(options
        .case
        .map(|index| random::case_seed(options.seed, index)));
    let Findings { failures, .. } = if let Some(file) = &options.replay {
        campaign::replay::<S>(&mut worker, file)?
    } else if let Some(seed) = only {
        campaign::run_only(subject, &mut worker, seed, &options.out)?
    } else {
        let plan = FuzzPlan {
            seed: options.seed,
            time: Duration::from_secs_f64(60.0 * options.minutes),
            most_cases: options.cases,
            out: options.out.clone(),
        };
        campaign::run(subject, &mut worker, &plan)?
    };
    Ok(if failures.is_empty() {
        Verdict::Passed
    } else {
        Verdict::Failed
    })
}
