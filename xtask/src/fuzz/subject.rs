//! What a fuzzer provides: cases from seeds, a check, smaller cases, and a file form; and what a
//! check returns.

use std::{
    any::Any,
    cell::RefCell,
    cmp::Ordering,
    panic::{self, AssertUnwindSafe},
    sync::Once,
};

use anyhow::Result;
use serde::{Deserialize, Serialize};

/// A fuzzer.
pub trait Subject {
    /// One input for the code under test.
    type Case: Clone;

    /// Its name on the command line.
    const NAME: &'static str;

    /// How long one case may take (seconds) before it counts as a hang.
    const TIME_LIMIT: u64;

    /// The case of a seed.
    fn draw(&self, seed: u64) -> Self::Case;

    /// Runs the code under test and compares it with the references.
    fn check(&self, case: &Self::Case) -> Report;

    /// Cases with less in them, those with the least first; empty if nothing can be left out.
    fn simpler(&self, case: &Self::Case) -> Vec<Self::Case>;

    /// The case as a file: what its name ends with, and its bytes.
    fn write(&self, case: &Self::Case) -> (String, Vec<u8>);

    /// The case from a file whose name ends with `ending`.
    ///
    /// # Errors
    /// The bytes are no case of this fuzzer.
    fn read(&self, ending: &str, bytes: &[u8]) -> Result<Self::Case>;
}

/// What a check found out.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// What was counted, by name; several entries of one name are added up.
    pub counts: Vec<(String, u64)>,
    /// The largest gap at a contact in units of its bound, and others of this kind: largest value
    /// by name.
    pub worst: Vec<(String, f64)>,
    /// What is wrong, if anything.
    pub failure: Option<Failure>,
}

/// Something that must not happen.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// The kind of failure: a case is reduced as long as this stays the same.
    pub kind: String,
    /// What was found, with numbers.
    pub detail: String,
}

impl Failure {
    /// A failure of a kind, with what was found.
    pub fn new(kind: &str, detail: impl Into<String>) -> Self {
        Self { kind: kind.to_owned(), detail: detail.into() }
    }
}

impl Report {
    /// Adds to a count.
    pub fn count(&mut self, name: &str, more: u64) {
        match self.counts.iter_mut().find(|(known, _)| known == name) {
            Some((_, count)) => *count += more,
            None => self.counts.push((name.to_owned(), more)),
        }
    }

    /// Keeps the largest value; NaN counts as the largest of all.
    pub fn keep_worst(&mut self, name: &str, value: f64) {
        let value = if value.is_nan() { f64::INFINITY } else { value };
        match self.worst.iter_mut().find(|(known, _)| known == name) {
            Some((_, worst)) => *worst = worst.max(value),
            None => self.worst.push((name.to_owned(), value)),
        }
    }

    /// Notes a failure; the first one is kept.
    pub fn fail(&mut self, kind: &str, detail: impl Into<String>) {
        if self.failure.is_none() {
            self.failure = Some(Failure::new(kind, detail));
        }
    }

    /// Adds the counts and worst values of another report.
    pub fn add(&mut self, other: &Self) {
        for (name, count) in &other.counts {
            self.count(name, *count);
        }
        for (name, value) in &other.worst {
            self.keep_worst(name, *value);
        }
    }
}

/// Whether a value is beyond a bound; NaN is beyond any.
///
/// ```
/// use xtask::fuzz::subject::exceeds;
///
/// assert!(exceeds(2.0, 1.0) && exceeds(f64::NAN, 1.0) && exceeds(0.0, f64::NAN));
/// assert!(!exceeds(1.0, 1.0));
/// ```
pub fn exceeds(value: f64, bound: f64) -> bool {
    value.partial_cmp(&bound).is_none_or(Ordering::is_gt)
}

thread_local! {
    static PANICKED: RefCell<Option<String>> = const { RefCell::new(None) };
    static CATCHING: RefCell<bool> = const { RefCell::new(false) };
}

/// Runs a check; a panic in it is a failure of the kind "panic", with its message and place.
pub fn check_and_catch(check: impl FnOnce() -> Report) -> Report {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if CATCHING.with(|catching| *catching.borrow()) {
                PANICKED.with(|panicked| *panicked.borrow_mut() = Some(info.to_string()));
            } else {
                previous(info);
            }
        }));
    });
    let outer = CATCHING.with(|catching| catching.replace(true));
    let result = panic::catch_unwind(AssertUnwindSafe(check));
    CATCHING.with(|catching| *catching.borrow_mut() = outer);
    result.unwrap_or_else(|payload| {
        let noted = PANICKED.with(|panicked| panicked.borrow_mut().take());
        let text = noted.unwrap_or_else(|| message(payload.as_ref()));
        Report { failure: Some(Failure::new("panic", text)), ..Report::default() }
    })
}

fn message(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "a panic".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_a_failure_with_its_message() {
        let report = check_and_catch(|| panic!("planted {}", 7));
        let failure = report.failure.expect("it failed");
        assert_eq!(failure.kind, "panic");
        assert!(failure.detail.contains("planted 7"), "{}", failure.detail);
    }

    #[test]
    fn counts_add_up_and_the_worst_value_stays() {
        let mut report = Report::default();
        report.count("contacts", 2);
        report.keep_worst("gap", 0.5);
        let mut other = Report::default();
        other.count("contacts", 3);
        other.keep_worst("gap", 0.25);
        report.add(&other);
        assert_eq!(report.counts, [("contacts".to_owned(), 5)]);
        assert_eq!(report.worst, [("gap".to_owned(), 0.5)]);
        report.keep_worst("gap", f64::NAN);
        assert_eq!(report.worst[0].1, f64::INFINITY);
    }
}
