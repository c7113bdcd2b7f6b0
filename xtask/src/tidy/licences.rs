//! Checks that each dependency has a licence which `deny.toml` allows.

use std::collections::BTreeSet;

use anyhow::{Context, Result};
use toml::{Table, Value};

use super::Fault;
use crate::release::metadata::Metadata;

/// Faults of the packages of others, with the licences that the text of `deny.toml` allows.
///
/// # Errors
/// The text has no list of licences.
pub fn faults(metadata: &Metadata, policy: &str) -> Result<Vec<Fault>> {
    let allowed = allowed(policy)?;
    let others = metadata
        .packages()
        .iter()
        .filter(|package| !metadata.is_member(package));
    let faults = others.filter_map(|package| {
        let licence = package.license.as_deref().unwrap_or_default();
        let problem = match is_allowed(licence, &allowed) {
            Some(true) => return None,
            Some(false) => "is not allowed by deny.toml",
            None => "is no SPDX expression",
        };
        let (name, version) = (&package.name, &package.version);
        Some(format!(
            "{name} {version}: the licence '{licence}' {problem}"
        ))
    });
    Ok(faults.collect())
}

/// The list `licenses.allow`.
fn allowed(policy: &str) -> Result<BTreeSet<String>> {
    let policy: Table = policy.parse().context("deny.toml")?;
    let list = policy
        .get("licenses")
        .and_then(|licences| licences.get("allow"))
        .and_then(Value::as_array)
        .context("deny.toml has no list `licenses.allow`")?;
    let words = list.iter().filter_map(Value::as_str);
    Ok(words.map(str::to_owned).collect())
}

/// Whether a choice among the licences of an SPDX expression is allowed; `None` if it is no such
/// expression. A slash means `OR`, as in old manifests.
fn is_allowed(expression: &str, allowed: &BTreeSet<String>) -> Option<bool> {
    let spaced = expression
        .replace('(', " ( ")
        .replace(')', " ) ")
        .replace('/', " OR ");
    let mut words = spaced.split_whitespace().peekable();
    let found = alternatives(&mut words, allowed)?;
    words.next().is_none().then_some(found)
}

type Words<'a, 'w> = &'a mut std::iter::Peekable<std::str::SplitWhitespace<'w>>;

/// Terms joined by `OR`, which binds less than `AND`.
fn alternatives(words: Words<'_, '_>, allowed: &BTreeSet<String>) -> Option<bool> {
    let mut found = conjunction(words, allowed)?;
    while words.next_if_eq(&"OR").is_some() {
        found |= conjunction(words, allowed)?;
    }
    Some(found)
}

/// Terms joined by `AND`.
fn conjunction(words: Words<'_, '_>, allowed: &BTreeSet<String>) -> Option<bool> {
    let mut found = term(words, allowed)?;
    while words.next_if_eq(&"AND").is_some() {
        found &= term(words, allowed)?;
    }
    Some(found)
}

/// A licence with or without an exception, or an expression in parentheses.
fn term(words: Words<'_, '_>, allowed: &BTreeSet<String>) -> Option<bool> {
    let first = words.next()?;
    if first == "(" {
        let found = alternatives(words, allowed)?;
        return (words.next()? == ")").then_some(found);
    }
    if [")", "AND", "OR", "WITH"].contains(&first) {
        return None;
    }
    if words.next_if_eq(&"WITH").is_none() {
        return Some(allowed.contains(first));
    }
    Some(allowed.contains(&format!("{first} WITH {}", words.next()?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const POLICY: &str = "[licenses]\nallow = [\"MIT\", \"Zlib\", \"X WITH Y\"]";

    #[test]
    fn one_licence_of_each_choice_must_be_allowed() {
        let allowed = allowed(POLICY).unwrap();
        for (expression, expected) in [
            ("MIT", Some(true)),
            ("GPL-3.0", Some(false)),
            ("GPL-3.0 OR MIT", Some(true)),
            ("GPL-3.0/MIT", Some(true)),
            ("MIT AND GPL-3.0", Some(false)),
            // AND binds more than OR.
            ("GPL-3.0 AND MIT OR Zlib", Some(true)),
            ("(GPL-3.0 OR MIT) AND Zlib", Some(true)),
            ("(GPL-3.0 OR MIT) AND BSD-3-Clause", Some(false)),
            ("X WITH Y", Some(true)),
            ("X", Some(false)),
            ("MIT WITH Y", Some(false)),
            ("", None),
            ("MIT OR", None),
            ("(MIT", None),
            ("MIT)", None),
            ("MIT Zlib", None),
            ("AND MIT", None),
        ] {
            assert_eq!(is_allowed(expression, &allowed), expected, "{expression}");
        }
        assert!(super::allowed("[bans]").is_err());
    }
}
