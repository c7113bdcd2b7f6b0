//! Minimisation of failing cases: repeatedly, the first simpler form that fails in the same way
//! replaces the case.

use std::time::{Duration, Instant};

use super::{
    subject::{Failure, Subject},
    worker::Runner,
};

/// Largest number of simpler cases tried.
const MAX_TRIES: u32 = 20_000;

/// Reduces a failing case within the time limit `time`.
///
/// Returns the smallest failing case found and its failure.
pub fn minimise<S: Subject>(
    subject: &S,
    runner: &mut impl Runner,
    mut case: S::Case,
    mut failure: Failure,
    time: Duration,
) -> (S::Case, Failure) {
    let begun = Instant::now();
    let mut tries = 0;
    'smaller: loop {
        for simpler in subject.simpler(&case) {
            tries += 1;
            if tries > MAX_TRIES || begun.elapsed() > time {
                return (case, failure);
            }
            let (ending, bytes) = subject.write(&simpler);
            let Ok(report) = runner.run_file(&ending, &bytes) else {
                return (case, failure);
            };
            if let Some(found) = report.failure.filter(|found| found.kind == failure.kind) {
                (case, failure) = (simpler, found);
                continue 'smaller;
            }
        }
        return (case, failure);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fuzz::{subject::Report, worker::InProcess};
    use anyhow::Result;

    /// Fails if the list holds both 3 and 7.
    struct Lists;

    impl Subject for Lists {
        type Case = Vec<u8>;
        const NAME: &'static str = "lists";
        const TIME_LIMIT: u64 = 1;

        fn draw(&self, _: u64) -> Vec<u8> {
            (0..20).collect()
        }

        fn check(&self, case: &Vec<u8>) -> Report {
            let mut report = Report::default();
            if case.contains(&3) && case.contains(&7) {
                report.fail("both", format!("{case:?}"));
            } else if case.len() == 1 {
                report.fail("another", "");
            }
            report
        }

        fn simpler(&self, case: &Vec<u8>) -> Vec<Vec<u8>> {
            let without = |index: usize| {
                let mut less = case.clone();
                less.remove(index);
                less
            };
            (0..case.len()).map(without).collect()
        }

        fn write(&self, case: &Vec<u8>) -> (String, Vec<u8>) {
            ("list".to_owned(), case.clone())
        }

        fn read(&self, _: &str, bytes: &[u8]) -> Result<Vec<u8>> {
            Ok(bytes.to_vec())
        }
    }

    #[test]
    fn a_minimised_case_fails_in_the_same_way_and_is_minimal() {
        let mut runner = InProcess(Lists);
        let failure = Failure::new("both", "");
        let (case, failure) = minimise(
            &Lists,
            &mut runner,
            Lists.draw(0),
            failure,
            Duration::from_secs(10),
        );
        assert_eq!(case, [3, 7]);
        assert_eq!(failure.detail, "[3, 7]");
    }
}
