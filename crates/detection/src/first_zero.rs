//! Whether the contact that a search finds is the first zero of the gap, for tests with random
//! bodies.

use proptest::{prop_assert, test_runner::TestCaseError};

use crate::Outcome;

/// Samples of the gap before the contact, and the depth (length) below which each must not lie.
pub(crate) struct Samples {
    pub(crate) count: u32,
    pub(crate) depth: f64,
}

/// Fails unless the gap (length) as a function of time is zero at the contact to within `allowed`
/// of its time, and not negative at samples before it, or before `horizon` (time) without a
/// contact.
pub(crate) fn is_first_zero<T: Copy + std::fmt::Debug>(
    outcome: Outcome<T>,
    horizon: f64,
    gap: impl Fn(f64) -> f64,
    allowed: impl Fn(f64) -> f64,
    samples: &Samples,
) -> Result<(), TestCaseError> {
    let until = match outcome {
        Outcome::Contact(contact) => {
            let time = contact.time;
            prop_assert!(
                gap(time).abs() < allowed(time),
                "{:e} {contact:?}",
                gap(time)
            );
            time
        }
        Outcome::Free => horizon,
        other => return Err(TestCaseError::fail(format!("{other:?}"))),
    };
    for part in 0..samples.count {
        let time = until * f64::from(part) / f64::from(samples.count);
        let depth = -gap(time);
        prop_assert!(depth < samples.depth, "{depth:e} at {time} before {until}");
    }
    Ok(())
}
