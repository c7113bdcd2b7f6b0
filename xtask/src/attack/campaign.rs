//! One attack: its cases, run on several threads, the rows of its table, and the files of the cases
//! that failed.

use std::{
    collections::BTreeMap,
    fs,
    path::Path,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
    time::Duration,
};

use anyhow::{Context, Result};
use carom_runs::print_line;

use crate::fuzz::{
    campaign::{keep, run_file},
    minimise::minimise,
    subject::{Failure, Report, Subject, check_and_catch},
    worker::Runner,
};

/// Further failures of one kind are counted, but neither minimised nor written.
const MAX_WRITTEN_PER_KIND: usize = 3;

/// Time limit for the minimisation of one case.
const MINIMISING: Duration = Duration::from_secs(30);

/// An attack on the program as a process.
pub trait Attack: Subject<Case: Send + Sync> + Sync {
    /// Number of cases of the whole attack.
    const FULL: u64;

    /// Returns about `count` cases, which depend only on the seed and on the number of calls of an
    /// undisturbed run.
    ///
    /// # Errors
    /// An undisturbed run fails.
    fn cases(&self, seed: u64, count: u64) -> Result<Vec<Self::Case>>;

    /// Row of the table in which a case counts, and its number of disturbances.
    fn row(&self, case: &Self::Case) -> (String, u64);
}

/// A row of the table: what was attacked, and how often it held.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AttackRow {
    /// Disturbances tried.
    pub tried: u64,
    /// Cases that failed.
    pub failed: u64,
}

/// Rows by name.
pub type Rows = BTreeMap<String, AttackRow>;

/// Runs cases in this process.
struct Here<'a, A>(&'a A);

impl<A: Attack> Runner for Here<'_, A> {
    fn run_seed(&mut self, seed: u64) -> Result<Report> {
        Ok(check_and_catch(|| self.0.check(&self.0.draw(seed))))
    }

    fn run_file(&mut self, ending: &str, bytes: &[u8]) -> Result<Report> {
        let case = self.0.read(ending, bytes)?;
        Ok(check_and_catch(|| self.0.check(&case)))
    }
}

/// Runs all cases, and writes those that fail to the folder `out`.
///
/// # Errors
/// A file cannot be written.
pub fn run<A: Attack>(attack: &A, cases: &[A::Case], threads: usize, out: &Path) -> Result<Rows> {
    let failures = failures(attack, cases, threads);
    let mut rows = Rows::new();
    for case in cases {
        let (name, number) = attack.row(case);
        rows.entry(format!("{}: {name}", A::NAME))
            .or_default()
            .tried += number;
    }
    let mut written = Counts::new();
    for (index, failure) in failures {
        let case = &cases[index];
        rows.entry(format!("{}: {}", A::NAME, attack.row(case).0))
            .or_default()
            .failed += 1;
        if is_among_first(&mut written, &failure) {
            let name = format!("{}-{index}", A::NAME);
            let (case, failure) =
                minimise(attack, &mut Here(attack), case.clone(), failure, MINIMISING);
            keep(attack, &case, &failure, &name, out)?;
        }
    }
    Ok(rows)
}

/// Numbers of failures by kind.
type Counts = BTreeMap<String, usize>;

/// Counts a failure, and returns whether it is one of the first of its kind.
fn is_among_first(counts: &mut Counts, failure: &Failure) -> bool {
    let number = counts.entry(failure.kind.clone()).or_default();
    *number += 1;
    *number <= MAX_WRITTEN_PER_KIND
}

/// The failures, by the index of the case. The first of each kind are printed at once.
fn failures<A: Attack>(attack: &A, cases: &[A::Case], threads: usize) -> BTreeMap<usize, Failure> {
    let next = AtomicUsize::new(0);
    let failures = Mutex::new((BTreeMap::new(), Counts::new()));
    let work = || {
        while let index = next.fetch_add(1, Ordering::Relaxed)
            && let Some(case) = cases.get(index)
        {
            let Some(failure) = check_and_catch(|| attack.check(case)).failure else {
                continue;
            };
            let mut found = failures.lock().unwrap_or_else(PoisonError::into_inner);
            if is_among_first(&mut found.1, &failure) {
                print_line(&format!(
                    "FAILED: {} {}: {}",
                    A::NAME,
                    failure.kind,
                    failure.detail
                ));
            }
            // Without a machine for the attack every case fails in the same way.
            if failure.kind == BROKEN {
                next.store(cases.len(), Ordering::Relaxed);
            }
            found.0.insert(index, failure);
        }
    };
    thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(work);
        }
    });
    failures
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner)
        .0
}

/// Kind of failures of the attack itself.
pub const BROKEN: &str = "broken attack";

/// The report of a case: the difference that it found in words, or an error of the attack itself.
pub fn report(found: Result<Option<Failure>>) -> Report {
    match found {
        Ok(failure) => Report {
            failure,
            ..Report::default()
        },
        Err(error) => Report {
            failure: Some(Failure::new(BROKEN, format!("{error:#}"))),
            ..Report::default()
        },
    }
}

/// Runs the case in a file, and returns its row.
///
/// # Errors
/// The file cannot be read or holds no case.
pub fn replay<A: Attack>(attack: &A, file: &Path) -> Result<Rows> {
    let bytes = fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
    let ending = file
        .extension()
        .and_then(|ending| ending.to_str())
        .unwrap_or_default();
    let (name, tried) = attack.row(&attack.read(ending, &bytes)?);
    let failed = u64::from(run_file(&mut Here(attack), file)?.failure.is_some());
    Ok(Rows::from([(
        format!("{}: {name}", A::NAME),
        AttackRow { tried, failed },
    )]))
}
