//! Configuration of the property tests: number of cases, and storage of failures.

use proptest::{prelude::ProptestConfig, test_runner::FileFailurePersistence};

/// Runs `cases` cases. A failing case is written to `NAME.failures` next to the test program.
pub fn cases(cases: u32) -> ProptestConfig {
    let beside = FileFailurePersistence::WithSource("failures");
    ProptestConfig {
        cases,
        failure_persistence: Some(Box::new(beside)),
        ..ProptestConfig::default()
    }
}
