//! `carom sweep` of one study: runs all replicas of all points, and continues what has begun.

use std::{
    collections::BTreeMap,
    fmt::Write as _,
    path::{Path, PathBuf},
};

use anyhow::{Error, Result, anyhow, bail};
use carom::engine::RunError;
use carom_runs::{
    command_line::{program, quoted},
    console::note,
    experiment::threads,
    interruption::Signals,
    manifest::Manifest,
    output::Existing,
    print_line,
    resumable::Choices,
};
use carom_tables::Verdict;
use clap::Args;
use rayon::{ThreadPool, prelude::*};

use crate::{
    cost, hosts,
    layout::{SweepFolder, by_point, is_sweep},
    report::{self, Remarks},
    results::damaged,
    shard::{Shard, Work, longest_first, split},
    slurm,
    stored::Found,
    study::{Size, Study},
    work::{Execution, ReplicaFailure, remove_folder},
};

/// Options of `carom sweep`.
#[derive(Debug, Clone, Args)]
pub struct SweepOptions {
    /// The study: a scene, the keys of it that vary, and the number of replicas. Of several
    /// studies, or of a folder of them, each has a folder inside, and one page has all verdicts
    #[arg(value_name = "STUDY.toml", required = true)]
    pub studies: Vec<PathBuf>,
    /// The short form of the study, from its table `quick`
    #[arg(long)]
    pub quick: bool,
    /// How the replicas are run
    #[command(flatten)]
    pub how: How,
}

/// How the replicas of a study are run, and where its results go.
#[derive(Debug, Clone, Args)]
pub struct How {
    /// Output folder and checkpoints. A sweep in the folder is continued, also without --resume
    #[command(flatten)]
    pub choices: Choices,
    /// Number of replicas of each point, instead of that of the study
    #[arg(long)]
    pub replicas: Option<u64>,
    /// Number of threads; default: one for each processor
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Do part I of N, from 1/N to N/N, in a folder of its own; `carom merge` joins the folders
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Job scripts instead of a run
    #[command(flatten)]
    pub slurm: slurm::SlurmOptions,
}

impl How {
    /// Whether the command does the whole work of a study, and so writes its results.
    pub(crate) fn is_whole(&self) -> bool {
        self.shard.is_none() && !self.slurm.is_requested()
    }

    /// The options that change the results or their folder, as words of a command.
    pub fn words(&self) -> String {
        let mut words = String::new();
        let mut add = |option: &str, value: Option<String>| {
            if let Some(value) = value {
                let _ = write!(words, " --{option} {value}");
            }
        };
        add("replicas", self.replicas.map(|number| number.to_string()));
        add("shard", self.shard.map(|shard| shard.to_string()));
        words
    }
}

/// A study with its names.
#[derive(Clone, Copy)]
#[expect(missing_debug_implementations, reason = "a function cannot be shown")]
pub struct Named<'a> {
    /// The study.
    pub study: &'a Study,
    /// Its name in job scripts.
    pub name: &'a str,
    /// Its folder without `--out`.
    pub folder: &'a str,
    /// The command that repeats the sweep into a folder.
    pub command: &'a dyn Fn(&Path) -> String,
}

impl SweepOptions {
    /// Reads a study in the requested size.
    ///
    /// # Errors
    /// Those of [`Study::read`].
    pub(crate) fn read(&self, study: &Path) -> Result<Study> {
        Study::read(
            study,
            Size {
                replicas: self.how.replicas,
                is_quick: self.quick,
            },
        )
    }
}

/// Runs all replicas of one study that have not ended, or those of a shard, and writes the results.
///
/// # Errors
/// The study is invalid, the folder holds another study, a replica ended with an error, a file
/// cannot be written, or a signal has been received. What has ended is kept.
pub(crate) fn run(path: &Path, options: &SweepOptions) -> Result<Verdict> {
    let (study, name) = (options.read(path)?, name(path, options));
    let (folder, command) = (format!("out/sweep-{name}"), |folder: &Path| {
        command(&[path], options, folder)
    });
    run_study(
        &Named {
            study: &study,
            name: &name,
            folder: &folder,
            command: &command,
        },
        &options.how,
    )
}

/// Runs all replicas of a study that have not ended, or those of a shard, and writes the results;
/// or writes job scripts that do.
///
/// # Errors
/// The folder holds another study, a replica ended with an error, a file cannot be written, or a
/// signal has been received. What has ended is kept.
pub fn run_study(named: &Named<'_>, how: &How) -> Result<Verdict> {
    let study = named.study;
    if let Some(list) = &how.slurm.hosts {
        hosts::write(study, named.name, &how.choices, list)?;
        return Ok(Verdict::Passed);
    }
    if how.slurm.slurm {
        slurm::write(study, named.name, &how.choices, &how.slurm)?;
        return Ok(Verdict::Passed);
    }
    let shard = how.shard.unwrap_or(Shard::WHOLE);
    let path = how
        .choices
        .resumption
        .folder(&usual_folder(named.folder, shard));
    let existing = how.choices.resumption.existing();
    let signals = Signals::watch()?;
    let pool = threads(how.threads)?;
    // All points are validated before anything is written.
    let work = planned(study, shard, &path, existing, &pool)?;
    signals.check()?;
    let (sweep, _lock) = SweepFolder::claim(&path, study, existing)?;
    if !is_sweep(&path) || sweep.study_text()? != study.text() {
        sweep.write_study(study)?;
    }
    let mut shards = sweep.shards()?;
    let own = by_point(work.iter().map(|(work, _)| *work));
    if shards.get(&shard) != Some(&own) {
        // Other splits are of an earlier number of replicas or of shards.
        shards.retain(|other, _| other.of == shard.of);
        shards.insert(shard, own);
        sweep.write_shards(&shards)?;
    }
    let again = (named.command)(&path);
    let manifest = Manifest::write_new(&sweep.folder, &again, &[])?;
    let failures = execute(&sweep, study, &work, how, (&signals, &pool))?;
    let remarks = Remarks {
        failures: failures.iter().map(words).collect(),
        ..Remarks::default()
    };
    let verdict = if shard == Shard::WHOLE {
        report::write(&sweep, study, &shards, (manifest, &again), remarks, &pool)?
    } else {
        manifest.complete(&sweep.folder, 0.0)?;
        print_line(&format!(
            "shard {shard}: {} of {} replicas have ended; `{} merge` joins the shards: {}",
            work.len() - failures.len(),
            work.len(),
            program(),
            path.display()
        ));
        Verdict::Passed
    };
    let count = failures.len();
    match failures.into_iter().next() {
        None => Ok(verdict),
        Some(first) => Err(error_of_all(first, count)),
    }
}

/// The error of all failed replicas, from that of the first and their number.
fn error_of_all(first: ReplicaFailure, count: usize) -> Error {
    let is_run = first
        .error
        .chain()
        .any(<dyn std::error::Error>::is::<RunError>);
    let error = first.error.context(format!(
        "{count} replicas ended with an error; the first is"
    ));
    // Only the error of a run keeps its kind, by which it counts as a failed check.
    if is_run { error } else { anyhow!("{error:#}") }
}

/// The name of a study in folders and jobs. The short form has other runs, and so another name.
pub(crate) fn name(study: &Path, options: &SweepOptions) -> String {
    let name = study
        .file_stem()
        .unwrap_or_else(|| "study".as_ref())
        .to_string_lossy();
    let quick = if options.quick { "-quick" } else { "" };
    format!("{name}{quick}")
}

/// The folder of a sweep, or of its shard, without `--out`.
fn usual_folder(whole: &str, shard: Shard) -> String {
    if shard == Shard::WHOLE {
        return whole.to_owned();
    }
    format!("{whole}/shard-{}-of-{}", shard.index, shard.of)
}

/// The command that repeats a sweep into its folder.
pub(crate) fn command(
    studies: &[impl AsRef<Path>],
    options: &SweepOptions,
    folder: &Path,
) -> String {
    let studies: Vec<String> = studies.iter().map(|study| quoted(study.as_ref())).collect();
    let quick = if options.quick { " --quick" } else { "" };
    let (studies, words) = (studies.join(" "), options.how.words());
    format!(
        "{} sweep {studies}{quick} --out {}{words}",
        program(),
        quoted(folder)
    )
}

/// The work of a shard with its costs, longest first. Places the bodies of each point that has work
/// left, and so validates it.
fn planned(
    study: &Study,
    shard: Shard,
    path: &Path,
    existing: Existing,
    pool: &ThreadPool,
) -> Result<Vec<(Work, u64)>> {
    let is_begun = is_sweep(path) && existing != Existing::Replace;
    let sweep = if is_begun {
        Some(SweepFolder::open(path)?)
    } else {
        None
    };
    let is_done = |work: Work| {
        sweep
            .as_ref()
            .is_some_and(|sweep| sweep.record(work).is_file())
    };
    let cost = |point: &crate::point::StudyPoint| -> Result<u64> {
        let is_needed = |replica| {
            !is_done(Work {
                key: point.key,
                replica,
            })
        };
        // A shard needs the costs of all points, which determine the split.
        let is_costed = shard.of > 1 || (1..=study.replicas).any(is_needed);
        if is_costed {
            cost::of_replica(point)
        } else {
            Ok(1)
        }
    };
    let costs: Vec<u64> =
        pool.install(|| study.points.par_iter().map(cost).collect::<Result<_>>())?;
    let of_point = |(point, cost): (&crate::point::StudyPoint, u64)| {
        let key = point.key;
        (1..=study.replicas).map(move |replica| (Work { key, replica }, cost))
    };
    let all = study.points.iter().zip(costs).flat_map(of_point).collect();
    Ok(split(all, shard))
}

/// Executes what has not ended.
fn execute(
    sweep: &SweepFolder,
    study: &Study,
    work: &[(Work, u64)],
    how: &How,
    (signals, pool): (&Signals, &ThreadPool),
) -> Result<Vec<ReplicaFailure>> {
    let points: BTreeMap<_, _> = study
        .points
        .iter()
        .map(|point| (point.key, point))
        .collect();
    let is_left = |&(work, cost): &(Work, u64)| -> Result<Option<(Work, u64)>> {
        let point = points[&work.key];
        match sweep.find(point, work.replica)? {
            Found::Finished(_) => {
                remove_folder(&sweep.partial(work))?;
                Ok(None)
            }
            Found::Nothing => Ok(Some((work, cost))),
            Found::Damaged(reason) => {
                note(&format!(
                    "{}; it is run again",
                    damaged(point, work.replica, &reason)
                ));
                Ok(Some((work, cost)))
            }
            Found::Newer(reason) => bail!(
                "{}: {reason}. Continue the sweep with the newer program, or choose another folder with --out",
                sweep.record(work).display()
            ),
        }
    };
    let left: Vec<Option<(Work, u64)>> =
        pool.install(|| work.par_iter().map(is_left).collect::<Result<_>>())?;
    let mut left: Vec<(Work, u64)> = left.into_iter().flatten().collect();
    longest_first(&mut left);
    let finished = (work.len() - left.len()) as u64;
    let work = left.into_iter().map(|(work, _)| work).collect();
    let checkpoint_every = how.choices.checkpoint_every;
    Execution {
        sweep,
        points,
        work,
        finished,
        checkpoint_every,
        signals,
    }
    .run(pool)
}

/// A failure for the page.
fn words(failure: &ReplicaFailure) -> String {
    let ReplicaFailure {
        point,
        replica,
        error,
    } = failure;
    format!(
        "Replica {replica} of {point} ended with an error: {}.",
        error.root_cause()
    )
}
