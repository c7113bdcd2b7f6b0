//! `carom merge` of sweep folders: the replicas of all of them in one folder.
//!
//! The sums of a point are added in the order of its replicas, whatever the order of the folders.
//! Each thread holds one point at a time.

use std::{collections::BTreeMap, fs, path::PathBuf};

use anyhow::{Context, Result, bail, ensure};
use carom_runs::{
    experiment::threads,
    folder_lock::FolderLock,
    left_out::{Damaged, command_of},
    manifest::Manifest,
    merge,
    output::{self, Destination, is_same_folder},
    progress::Progress,
};
use carom_tables::Verdict;
use rayon::{ThreadPool, prelude::*};

use crate::{
    layout::{Shards, SweepFolder, is_sweep, refuse_other_text},
    point::StudyPoint,
    report::{self, Remarks},
    shard::Work,
    stored::{Found, Stored},
    study::Study,
};

/// Merges folders of runs, or of sweeps of one study, in whole or in parts.
///
/// # Errors
/// Folders of sweeps and of runs are mixed, or are of different studies or scenes; a replica is
/// there twice with different content; a file cannot be read or written.
pub fn run(options: &merge::MergeOptions) -> Result<Verdict> {
    let sweeps = options
        .folders
        .iter()
        .filter(|folder| is_sweep(folder))
        .count();
    if sweeps == 0 {
        return merge::run(options);
    }
    if let Some(other) = options.folders.iter().find(|folder| !is_sweep(folder)) {
        bail!(
            "{} holds no sweep, but other folders do: sweeps are merged with sweeps",
            other.display()
        );
    }
    merge_sweeps(&options.folders, &options.destination)
}

fn merge_sweeps(paths: &[PathBuf], destination: &Destination) -> Result<Verdict> {
    let sources = paths
        .iter()
        .map(|path| SweepFolder::open(path))
        .collect::<Result<Vec<_>>>()?;
    // Held to the end: no other process begins to write there.
    let (_locks, in_use) = locked(&sources);
    let (study, shards) = common(&sources)?;
    let path = destination.folder("out/merge");
    if let Some(same) = sources
        .iter()
        .find(|source| is_same_folder(source.folder.path(), &path))
    {
        bail!(
            "{} is one of the folders to merge: choose another with --out",
            same.folder.path().display()
        );
    }
    if !destination.force && is_sweep(&path) {
        bail!(
            "{} holds a sweep: choose another folder with --out, or replace it with --force",
            path.display()
        );
    }
    let (target, _lock) = SweepFolder::claim(&path, &study, destination.existing())?;
    target.write_study(&study)?;
    target.write_shards(&shards)?;
    let again = merge::again(paths, &path);
    let manifest = Manifest::write_new(&target.folder, &again, &[])?;
    let pool = threads(None)?;
    let mut remarks = copy(&study, &sources, &target, &pool)?;
    remarks.notes.extend(in_use);
    report::write(&target, &study, &shards, (manifest, &again), remarks, &pool)
}

/// Locks the folders that are read, and notes those in which another process is writing: their
/// finished replicas do not change, and can be merged.
fn locked(sources: &[SweepFolder]) -> (Vec<FolderLock>, Vec<String>) {
    let (mut locks, mut in_use) = (Vec::new(), Vec::new());
    for source in sources {
        match FolderLock::shared(source.folder.path()) {
            Ok(lock) => locks.push(lock),
            Err(error) => in_use.push(format!("{error:#}: only its finished replicas are merged.")),
        }
    }
    (locks, in_use)
}

/// The study and the shards of all folders.
fn common(sources: &[SweepFolder]) -> Result<(Study, Shards)> {
    let Some(first) = sources.first() else {
        bail!("there are no folders")
    };
    let text = first.study_text()?;
    let mut shards = Shards::new();
    for source in sources {
        let path = source.folder.path().display();
        refuse_other_text(&text, &source.study_text()?).with_context(|| {
            format!("cannot merge {path} with {}", first.folder.path().display())
        })?;
        shards.extend(
            source
                .shards()
                .with_context(|| format!("cannot merge {path}"))?,
        );
    }
    Ok((first.study()?, shards))
}

/// Copies all finished replicas.
fn copy(
    study: &Study,
    sources: &[SweepFolder],
    target: &SweepFolder,
    pool: &ThreadPool,
) -> Result<Remarks> {
    let holders = pool.install(|| holders(sources))?;
    let progress = Progress::items("points", study.points.len() as u64);
    let of_point = |point: &StudyPoint| -> Result<(usize, Vec<Damaged>)> {
        let mut found = (0, Vec::new());
        for replica in 1..=study.replicas {
            let own = holders
                .get(&Work {
                    key: point.key,
                    replica,
                })
                .map_or(&[][..], Vec::as_slice);
            let own: Vec<&SweepFolder> = own.iter().map(|&source| &sources[source]).collect();
            copy_replica(point, replica, &own, target, &mut found)?;
        }
        progress.count(1);
        Ok(found)
    };
    let found: Vec<(usize, Vec<Damaged>)> =
        pool.install(|| study.points.par_iter().map(of_point).collect::<Result<_>>())?;
    let twice: usize = found.iter().map(|(twice, _)| twice).sum();
    let damaged = found.into_iter().flat_map(|(_, damaged)| damaged).collect();
    let mut notes = Vec::new();
    if twice > 0 {
        notes.push(format!(
            "{twice} replicas are in several folders, with the same content: they count once."
        ));
    }
    Ok(Remarks {
        notes,
        damaged,
        ..Remarks::default()
    })
}

/// The sources of each replica, by their indices in ascending order. Each folder is listed once: a
/// look for each replica in each source takes minutes on a shared file system.
fn holders(sources: &[SweepFolder]) -> Result<BTreeMap<Work, Vec<usize>>> {
    let listed: Vec<Vec<Work>> = sources
        .par_iter()
        .map(SweepFolder::records)
        .collect::<Result<_>>()?;
    let mut holders: BTreeMap<Work, Vec<usize>> = BTreeMap::new();
    for (source, records) in listed.into_iter().enumerate() {
        for work in records {
            holders.entry(work).or_default().push(source);
        }
    }
    Ok(holders)
}

/// Copies a replica from the first of the folders that have it. Counts further equal ones, and
/// lists damaged files.
fn copy_replica(
    point: &StudyPoint,
    replica: u64,
    sources: &[&SweepFolder],
    target: &SweepFolder,
    (twice, damaged): &mut (usize, Vec<Damaged>),
) -> Result<()> {
    let work = Work {
        key: point.key,
        replica,
    };
    let mut first: Option<(Box<Stored>, &SweepFolder)> = None;
    for &source in sources {
        match source.find(point, replica)? {
            Found::Nothing => (),
            Found::Damaged(reason) | Found::Newer(reason) => damaged.push(Damaged {
                file: source.record(work),
                content: format!("Replica {replica} of point {}", point.label),
                reason,
                again: command_of(source.folder.path()),
            }),
            Found::Finished(stored) => match &first {
                None => first = Some((stored, source)),
                Some((other, before)) => {
                    ensure!(
                        stored.is_same(other)?,
                        "point {}, replica {replica}: {} and {} have different results",
                        point.label,
                        before.record(work).display(),
                        source.record(work).display()
                    );
                    *twice += 1;
                }
            },
        }
    }
    if let Some((_, source)) = first {
        target.point(point.key)?;
        let bytes = fs::read(source.record(work))
            .with_context(|| source.record(work).display().to_string())?;
        output::write_lasting(&target.record(work), &[&bytes])?;
    }
    Ok(())
}
