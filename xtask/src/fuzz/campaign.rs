//! One run of a fuzzer: cases within a time limit, minimised failures, and a line with the counts.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use carom_runs::{interruption::Interrupted, output::write_whole, print_line};

use super::{
    minimise::minimise,
    random::case_seed,
    subject::{Failure, Report, Subject},
    worker::Runner,
};

/// Further failures of one kind are counted, but neither minimised nor written.
const MAX_WRITTEN_PER_KIND: usize = 3;

/// Time limit for the minimisation of one case.
const MINIMISING: Duration = Duration::from_mins(1);

/// Plan of a run.
#[derive(Debug, Clone)]
pub struct FuzzPlan {
    /// Seed of the run.
    pub seed: u64,
    /// Time during which cases are started.
    pub time: Duration,
    /// Largest number of cases.
    pub most_cases: u64,
    /// The folder for failing cases.
    pub out: PathBuf,
}

/// Results of a run.
#[derive(Debug, Default)]
pub struct Findings {
    /// Number of cases.
    pub cases: u64,
    /// Counts and worst values of all cases.
    pub total: Report,
    /// Seeds of the failed cases, with their failures.
    pub failures: Vec<(u64, Failure)>,
}

/// Runs cases within the time limit and writes those that fail. A signal ends the campaign early.
///
/// # Errors
/// The worker cannot be started, or a file cannot be written.
pub fn run<S: Subject>(subject: &S, runner: &mut impl Runner, plan: &FuzzPlan) -> Result<Findings> {
    let mut begun = Instant::now();
    let mut findings = Findings::default();
    print_line(&format!("fuzz {}: seed {}", S::NAME, plan.seed));
    while begun.elapsed() < plan.time && findings.cases < plan.most_cases {
        let seed = case_seed(plan.seed, findings.cases);
        let report = match runner.run_seed(seed) {
            Err(error) if error.is::<Interrupted>() => {
                print_line("interrupted: the campaign ends here");
                break;
            }
            report => report?,
        };
        findings.cases += 1;
        findings.total.add(&report);
        let Some(failure) = report.failure else {
            continue;
        };
        let written = findings
            .failures
            .iter()
            .filter(|(_, known)| known.kind == failure.kind)
            .count();
        if written < MAX_WRITTEN_PER_KIND {
            let paused = Instant::now();
            note(subject, runner, seed, &failure, &plan.out)?;
            // The time of minimisation does not count.
            begun += paused.elapsed();
        }
        findings.failures.push((seed, failure));
    }
    print_line(&summary(S::NAME, &findings));
    Ok(findings)
}

/// Runs the case of one seed and minimises it if it fails.
///
/// # Errors
/// See [`run`].
pub fn run_only<S: Subject>(
    subject: &S,
    runner: &mut impl Runner,
    seed: u64,
    out: &Path,
) -> Result<Findings> {
    let report = runner.run_seed(seed)?;
    let findings = one(&report, seed);
    if let Some(failure) = &report.failure {
        note(subject, runner, seed, failure, out)?;
    }
    print_line(&summary(S::NAME, &findings));
    Ok(findings)
}

/// Runs the case in a file.
///
/// # Errors
/// See [`run`]; also a file that cannot be read or holds no case.
pub fn replay<S: Subject>(runner: &mut impl Runner, file: &Path) -> Result<Findings> {
    let report = run_file(runner, file)?;
    let findings = one(&report, 0);
    print_line(&summary(S::NAME, &findings));
    Ok(findings)
}

/// Runs the case in a file, prints its failure, and returns its report.
///
/// # Errors
/// See [`replay`].
pub fn run_file(runner: &mut impl Runner, file: &Path) -> Result<Report> {
    let bytes = fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
    let ending = file
        .extension()
        .map(|ending| ending.to_string_lossy().into_owned())
        .unwrap_or_default();
    let report = runner.run_file(&ending, &bytes)?;
    if let Some(failure) = &report.failure {
        print_line(&format!("FAILED: {}: {}", failure.kind, failure.detail));
    }
    Ok(report)
}

fn one(report: &Report, seed: u64) -> Findings {
    let failures = report
        .failure
        .clone()
        .map(|failure| (seed, failure))
        .into_iter()
        .collect();
    Findings {
        cases: 1,
        total: report.clone(),
        failures,
    }
}

/// Minimises a failing case, writes it to a file, and prints the commands to replay it.
fn note<S: Subject>(
    subject: &S,
    runner: &mut impl Runner,
    seed: u64,
    failure: &Failure,
    out: &Path,
) -> Result<()> {
    print_line(&format!("FAILED: {}: {}", failure.kind, failure.detail));
    print_line(&format!(
        "  cargo xtask {} {} --only {seed}",
        S::COMMAND,
        S::NAME
    ));
    let (case, left) = minimise(
        subject,
        runner,
        subject.draw(seed),
        failure.clone(),
        MINIMISING,
    );
    keep(subject, &case, &left, &format!("{}-{seed}", S::NAME), out)
}

/// Writes a minimised case to a file called `name` in the folder `out`, and prints the command to
/// replay it.
///
/// # Errors
/// The file cannot be written.
pub fn keep<S: Subject>(
    subject: &S,
    case: &S::Case,
    failure: &Failure,
    name: &str,
    out: &Path,
) -> Result<()> {
    let (ending, bytes) = subject.write(case);
    fs::create_dir_all(out)
        .with_context(|| format!("cannot create the folder {}", out.display()))?;
    let path = out.join(format!("{name}.{ending}"));
    write_whole(&path, &bytes)?;
    print_line(&format!("  minimised: {}", failure.detail));
    print_line(&format!(
        "  cargo xtask {} {} --replay {}",
        S::COMMAND,
        S::NAME,
        path.display()
    ));
    Ok(())
}

/// The line with the counts.
fn summary(name: &str, findings: &Findings) -> String {
    use std::fmt::Write as _;
    let Findings {
        cases,
        total,
        failures,
    } = findings;
    let mut line = format!("fuzz {name}: {cases} cases");
    for (name, count) in &total.counts {
        // Writing to a string cannot fail.
        let _ = write!(line, ", {count} {name}");
    }
    for (name, value) in &total.worst {
        let _ = write!(line, ", worst {name} {value:.3e}");
    }
    let _ = write!(line, "; {} failures", failures.len());
    let mut kinds = BTreeMap::new();
    for (_, failure) in failures {
        *kinds.entry(&failure.kind[..]).or_insert(0) += 1;
    }
    for (kind, count) in kinds {
        let _ = write!(line, ", {kind}: {count}");
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fuzz::worker::InProcess;

    /// Fails for one seed in `one_in`.
    struct Lottery {
        one_in: u64,
    }

    impl Subject for Lottery {
        type Case = u64;
        const NAME: &'static str = "lottery";
        const TIME_LIMIT: u64 = 1;

        fn draw(&self, seed: u64) -> u64 {
            seed
        }

        fn check(&self, case: &u64) -> Report {
            let mut report = Report::default();
            report.count("tickets", 2);
            if case.is_multiple_of(self.one_in) {
                report.fail("drawn", case.to_string());
            }
            report
        }

        fn simpler(&self, case: &u64) -> Vec<u64> {
            if *case == 0 { vec![] } else { vec![0] }
        }

        fn write(&self, case: &u64) -> (String, Vec<u8>) {
            ("txt".to_owned(), case.to_string().into_bytes())
        }

        fn read(&self, _: &str, bytes: &[u8]) -> Result<u64> {
            Ok(std::str::from_utf8(bytes)?.parse()?)
        }
    }

    fn plan(out: &Path) -> FuzzPlan {
        FuzzPlan {
            seed: 1,
            time: Duration::from_mins(1),
            most_cases: 200,
            out: out.to_owned(),
        }
    }

    #[test]
    fn failing_cases_are_minimised_and_written_with_their_replay_command() {
        let out = tempfile::tempdir().unwrap();
        let mut runner = InProcess(Lottery { one_in: 20 });
        let findings = run(&Lottery { one_in: 20 }, &mut runner, &plan(out.path())).unwrap();
        assert_eq!(findings.cases, 200);
        assert!(
            (3..30).contains(&findings.failures.len()),
            "{}",
            findings.failures.len()
        );
        assert!(findings.total.counts.contains(&("tickets".to_owned(), 400)));
        let seed = findings.failures[0].0;
        let file = out.path().join(format!("lottery-{seed}.txt"));
        assert_eq!(fs::read_to_string(&file).unwrap(), "0");
        assert_eq!(
            fs::read_dir(out.path()).unwrap().count(),
            MAX_WRITTEN_PER_KIND
        );
        assert_eq!(
            run_only(&Lottery { one_in: 20 }, &mut runner, seed, out.path())
                .unwrap()
                .failures
                .len(),
            1
        );
        assert_eq!(
            replay::<Lottery>(&mut runner, &file)
                .unwrap()
                .failures
                .len(),
            1
        );
    }

    #[test]
    fn a_run_without_failures_writes_nothing() {
        let out = tempfile::tempdir().unwrap();
        let mut runner = InProcess(Lottery { one_in: u64::MAX });
        let findings = run(
            &Lottery { one_in: u64::MAX },
            &mut runner,
            &plan(out.path()),
        )
        .unwrap();
        assert!(findings.failures.is_empty());
        assert_eq!(fs::read_dir(out.path()).unwrap().count(), 0);
    }
}
