//! How the property tests of these programs draw cases and keep those that fail.

use proptest::{prelude::ProptestConfig, test_runner::FileFailurePersistence};

/// So many cases. A case that fails is written beside the test program, `NAME.failures`.
pub fn cases(cases: u32) -> ProptestConfig {
    let beside = FileFailurePersistence::WithSource("failures");
    ProptestConfig { cases, failure_persistence: Some(Box::new(beside)), ..ProptestConfig::default() }
}
