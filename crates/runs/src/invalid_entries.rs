//! Several independent faults of one scene in one message, so that a user need not find them one
//! after another.

use std::fmt;

use anyhow::{Error, Result};

/// Most faults that a message names. Larger: the first ones leave the screen.
const MAX_NAMED: usize = 8;

/// The words of two faults or more.
#[derive(Debug, thiserror::Error)]
pub struct InvalidEntries(Vec<String>);

impl InvalidEntries {
    /// Faults in these words.
    pub fn new(words: Vec<String>) -> Self {
        Self(words)
    }
}

impl fmt::Display for InvalidEntries {
    /// A line for each fault.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(faults) = self;
        write!(f, "{} entries are invalid:", faults.len())?;
        for fault in faults.iter().take(MAX_NAMED) {
            write!(f, "\n- {fault}")?;
        }
        if faults.len() > MAX_NAMED {
            write!(f, "\n- and {} more", faults.len() - MAX_NAMED)?;
        }
        Ok(())
    }
}

/// Returns the only one of some errors as it is, and several as one error with a line for each;
/// equal ones count once.
///
/// # Errors
/// There is an error.
pub fn refuse_all(faults: impl IntoIterator<Item = Error>) -> Result<()> {
    let mut faults: Vec<Error> = faults.into_iter().collect();
    let mut all: Vec<String> = Vec::new();
    for fault in &faults {
        let words = match fault.downcast_ref::<InvalidEntries>() {
            Some(InvalidEntries(words)) => words.clone(),
            None => vec![format!("{fault:#}")],
        };
        for words in words {
            if !all.contains(&words) {
                all.push(words);
            }
        }
    }
    if all.len() > 1 {
        return Err(InvalidEntries(all).into());
    }
    faults.pop().map_or(Ok(()), Err)
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::anyhow;

    fn refused(faults: &[&str]) -> String {
        let faults = faults.iter().map(|&fault| anyhow!(fault.to_owned()));
        format!("{:#}", refuse_all(faults).unwrap_err())
    }

    #[test]
    fn one_fault_stands_alone_and_several_in_a_list() {
        assert!(refuse_all([]).is_ok());
        assert_eq!(refused(&["a is 1"]), "a is 1");
        assert_eq!(refused(&["a is 1", "a is 1"]), "a is 1");
        assert_eq!(
            refused(&["a is 1", "b is 2"]),
            "2 entries are invalid:\n- a is 1\n- b is 2"
        );
        // A list in a list is part of it.
        let two = refuse_all([anyhow!("b is 2"), anyhow!("c is 3")]).unwrap_err();
        let three = refuse_all([anyhow!("a is 1"), two]).unwrap_err();
        assert_eq!(
            three.to_string(),
            "3 entries are invalid:\n- a is 1\n- b is 2\n- c is 3"
        );
        let numbers: Vec<String> = (0..10).map(|number| number.to_string()).collect();
        let many = refused(&numbers.iter().map(String::as_str).collect::<Vec<_>>());
        assert!(many.starts_with("10 entries") && many.ends_with("\n- 7\n- and 2 more"));
    }
}
