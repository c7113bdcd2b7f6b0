//! Interface of a fuzzer: cases from seeds, a check, simpler cases, and a file format; and the
//! report of a check.

use std::{
    any::Any,
    cell::RefCell,
    cmp::Ordering,
    panic::{self, AssertUnwindSafe},
    sync::Once,
};

use anyhow::{Result, ensure};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// A fuzzer.
pub trait Subject {
    /// One input for the code under test.
    type Case: Clone;

    /// The words before its name on the command line.
    const COMMAND: &'static str = "fuzz";

    /// Its name on the command line.
    const NAME: &'static str;

    /// Processor time of one case (seconds) above which it counts as a hang.
    const TIME_LIMIT: u64;

    /// The case of a seed.
    fn draw(&self, seed: u64) -> Self::Case;

    /// Runs the code under test and compares it with the references.
    fn check(&self, case: &Self::Case) -> Report;

    /// Simpler cases, the simplest first; empty if there are none.
    fn simpler(&self, case: &Self::Case) -> Vec<Self::Case>;

    /// Encodes the case as a file: extension and content.
    fn write(&self, case: &Self::Case) -> (String, Vec<u8>);

    /// Decodes the case from a file with the extension `ending`.
    ///
    /// # Errors
    /// The content is no case of this fuzzer.
    fn read(&self, ending: &str, bytes: &[u8]) -> Result<Self::Case>;
}

/// Encodes a case as a file in TOML: see [`Subject::write`].
///
/// # Panics
/// A case that TOML cannot represent.
pub fn write_toml<T: Serialize>(case: &T) -> (String, Vec<u8>) {
    let text = toml::to_string(case).expect("a case is plain data that TOML can represent");
    ("toml".to_owned(), text.into_bytes())
}

/// Decodes a case from a file in TOML: see [`Subject::read`].
///
/// # Errors
/// The file is not in TOML, or holds no case.
pub fn read_toml<T: DeserializeOwned>(ending: &str, bytes: &[u8]) -> Result<T> {
    ensure!(
        ending == "toml",
        "a case file must end with toml, not {ending:?}"
    );
    Ok(toml::from_str(std::str::from_utf8(bytes)?)?)
}

/// Result of a check.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Counts by name; entries with one name are summed.
    pub counts: Vec<(String, u64)>,
    /// Largest values by name, such as the largest gap at a contact in units of its bound.
    pub worst: Vec<(String, f64)>,
    /// The failure, if any.
    pub failure: Option<Failure>,
}

/// A failure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// Kind of the failure; minimisation preserves it.
    pub kind: String,
    /// Description with numbers.
    pub detail: String,
}

impl Failure {
    /// A failure of a kind with its description.
    pub fn new(kind: &str, detail: impl Into<String>) -> Self {
        Self {
            kind: kind.to_owned(),
            detail: detail.into(),
        }
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

    /// Updates a largest value; NaN is larger than all numbers.
    pub fn keep_worst(&mut self, name: &str, value: f64) {
        let value = if value.is_nan() { f64::INFINITY } else { value };
        match self.worst.iter_mut().find(|(known, _)| known == name) {
            Some((_, worst)) => *worst = worst.max(value),
            None => self.worst.push((name.to_owned(), value)),
        }
    }

    /// Records a failure; the first one is kept.
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

/// Returns true if a value exceeds a bound; NaN always does.
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

/// Runs a check; a panic becomes a failure of the kind "panic", with message and location.
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
        Report {
            failure: Some(Failure::new("panic", text)),
            ..Report::default()
        }
    })
}

fn message(payload: &(dyn Any + Send)) -> String {
    let text = payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "a panic".to_owned())
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
