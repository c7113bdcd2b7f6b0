//! The execution of replicas on all processors; each is kept as soon as it has ended.

use std::{
    collections::BTreeMap,
    fs, io,
    path::Path,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    time::Duration,
};

use anyhow::{Context, Error, Result};
use carom_runs::{
    folder_lock::Ousted,
    interruption::{Interrupted, Signals},
    progress::{Progress, ProgressLines},
    run::replica::ReplicaRun,
};
use rayon::ThreadPool;

use crate::{
    layout::SweepFolder,
    point::{Key, StudyPoint},
    shard::Work,
    stored::Stored,
};

/// A replica that ended with an error.
#[derive(Debug)]
pub struct ReplicaFailure {
    /// The point in words.
    pub point: String,
    /// The number of the replica.
    pub replica: u64,
    /// Why it ended.
    pub error: Error,
}

/// Replicas to execute.
#[derive(Debug)]
pub struct Execution<'a> {
    /// Where they are kept.
    pub sweep: &'a SweepFolder,
    /// The points by key.
    pub points: BTreeMap<Key, &'a StudyPoint>,
    /// What is left to do; the first begins first.
    pub work: Vec<Work>,
    /// Number of replicas that earlier processes have finished.
    pub finished: u64,
    /// Time between two checkpoints of a replica.
    pub checkpoint_every: Duration,
    /// Signals that end the program.
    pub signals: &'a Signals,
}

/// The state that threads share.
struct Shared<'a> {
    next: AtomicUsize,
    whole: Progress,
    points: BTreeMap<Key, PointProgress<'a>>,
    failures: Mutex<Vec<ReplicaFailure>>,
    /// An error after which nothing more can be kept.
    broken: Mutex<Option<Error>>,
}

/// The progress of one point, shown from its first replica to its last.
struct PointProgress<'a> {
    point: &'a StudyPoint,
    shown: Mutex<Shown>,
}

struct Shown {
    progress: Option<Arc<Progress>>,
    left: usize,
}

impl Execution<'_> {
    /// Executes all replicas and returns those that ended with an error.
    ///
    /// # Errors
    /// A file cannot be written, or a signal has been received. What has ended is kept.
    pub fn run(&self, pool: &ThreadPool) -> Result<Vec<ReplicaFailure>> {
        let all = self.work.len() as u64 + self.finished;
        let whole = Progress::of_items("all", "replicas", all);
        whole.skip(self.finished as f64);
        let mut points: BTreeMap<Key, PointProgress<'_>> = BTreeMap::new();
        for work in &self.work {
            let point = self.points[&work.key];
            let shown = || {
                Mutex::new(Shown {
                    progress: None,
                    left: 0,
                })
            };
            let entry = points.entry(work.key).or_insert_with(|| PointProgress {
                point,
                shown: shown(),
            });
            lock(&entry.shown).left += 1;
        }
        let shared = Shared {
            next: AtomicUsize::new(0),
            whole,
            points,
            failures: Mutex::default(),
            broken: Mutex::default(),
        };
        pool.broadcast(|_| {
            // The list of work bounds the loop.
            while let Some(&work) = self.work.get(shared.next.fetch_add(1, Ordering::Relaxed)) {
                if self.signals.check().is_err() || lock(&shared.broken).is_some() {
                    break;
                }
                self.one(work, &shared);
            }
        });
        self.signals.check()?;
        if let Some(error) = shared
            .broken
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
        {
            return Err(error);
        }
        let mut failures = shared
            .failures
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        failures.sort_by(|a, b| (&a.point, a.replica).cmp(&(&b.point, b.replica)));
        Ok(failures)
    }

    fn one(&self, work: Work, shared: &Shared<'_>) {
        let of_point = &shared.points[&work.key];
        let done = self.replica(work, &of_point.start());
        of_point.end();
        let Err(error) = done else {
            return shared.whole.count(1);
        };
        if error
            .chain()
            .any(<dyn std::error::Error>::is::<Interrupted>)
        {
            return;
        }
        // Nothing can be kept on a full disk, or beside another process: no further replica begins.
        if error
            .chain()
            .any(|cause| cause.is::<io::Error>() || cause.is::<Ousted>())
        {
            lock(&shared.broken).get_or_insert(error);
            return;
        }
        let point = of_point.point.label.clone();
        lock(&shared.failures).push(ReplicaFailure {
            point,
            replica: work.replica,
            error,
        });
    }

    /// Executes one replica, from its checkpoint if there is one, and keeps its result.
    fn replica(&self, work: Work, progress: &Progress) -> Result<()> {
        let point = self.points[&work.key];
        let name = || format!("point {}, replica {}", point.label, work.replica);
        let folder = self.sweep.partial_folder(work)?;
        let scene = point.replica(work.replica);
        let (checkpoint_every, signals) = (self.checkpoint_every, self.signals);
        let replica = ReplicaRun {
            scene: &scene,
            folder: &folder,
            checkpoint_every,
            signals,
            progress,
        };
        let finished = replica.run().with_context(name)?;
        let stored = Stored {
            work,
            record: finished.record,
            seconds: finished.seconds,
        };
        stored.write(&self.sweep.record(work))?;
        remove_folder(folder.path())
    }
}

/// Removes a folder, if it is there.
///
/// # Errors
/// It cannot be removed.
pub fn remove_folder(path: &Path) -> Result<()> {
    match fs::remove_dir_all(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("cannot remove {}", path.display()))
        }
        _ => Ok(()),
    }
}

impl PointProgress<'_> {
    fn start(&self) -> Arc<Progress> {
        let mut shown = lock(&self.shown);
        let all = self.point.scene.run.until * shown.left as f64;
        let new = || Arc::new(ProgressLines::default().add(&self.point.short_label(), all));
        Arc::clone(shown.progress.get_or_insert_with(new))
    }

    fn end(&self) {
        let mut shown = lock(&self.shown);
        shown.left -= 1;
        if shown.left == 0 {
            shown.progress = None;
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
