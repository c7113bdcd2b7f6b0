//! Checks that names are those of Rust: bounds are called MAX_ and MIN_, constructors `new` or
//! `from_…`, and no two types of the crates share a name.

use std::{collections::BTreeMap, path::Path};

use anyhow::Result;

use super::{Fault, files::with_extensions, read};

/// First words of bounds that Rust calls MAX_ or MIN_.
const SUPERLATIVES: [&str; 10] = [
    "MOST", "LEAST", "LARGEST", "SMALLEST", "LONGEST", "SHORTEST", "FEWEST", "FINEST", "WIDEST",
    "DEEPEST",
];

/// Types that share a name: the command lines of both programs, and one type of tests alone.
const SHARED: [&str; 2] = ["Cli", "Random"];

/// Faults in all sources of the crates and of xtask, apart from tests and the package for Python.
pub fn faults(root: &Path) -> Result<Vec<Fault>> {
    let mut faults = Vec::new();
    let mut homes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for folder in ["crates", "xtask"] {
        for path in with_extensions(&root.join(folder), &["rs"])? {
            let name = path
                .strip_prefix(root)
                .unwrap_or(&path)
                .display()
                .to_string();
            if name.contains("/tests") || name.contains("crates/python/") {
                continue;
            }
            let source = read(&path)?;
            let end = source
                .find("#[cfg(test)]\nmod tests {")
                .unwrap_or(source.len());
            for (index, line) in source[..end].lines().enumerate() {
                if let Some(problem) = problem(line) {
                    faults.push(format!("{name}:{}: {problem}", index + 1));
                }
                if let Some(declared) = declared_type(line) {
                    homes
                        .entry(declared.to_owned())
                        .or_default()
                        .push(name.clone());
                }
            }
        }
    }
    for (declared, places) in homes {
        if places.len() > 1 && !SHARED.contains(&declared.as_str()) {
            faults.push(format!(
                "the type {declared} has several homes: {}",
                places.join(", ")
            ));
        }
    }
    Ok(faults)
}

/// What is wrong with the name that a line declares.
fn problem(line: &str) -> Option<String> {
    let words: Vec<&str> = line
        .split(|c: char| !c.is_alphanumeric() && c != '_')
        .filter(|word| !word.is_empty())
        .collect();
    let after = |keyword: &str| {
        let place = words.iter().position(|word| *word == keyword)?;
        words.get(place + 1).copied()
    };
    if line.trim_start().starts_with("//") {
        return None;
    }
    if let Some(name) = after("const").or_else(|| after("static")) {
        let first = name.split('_').next().unwrap_or_default();
        if SUPERLATIVES.contains(&first) {
            return Some(format!("`{name}`: call a bound MAX_… or MIN_…"));
        }
    }
    let name = after("fn").filter(|name| ["of", "begin"].contains(name))?;
    Some(format!("`fn {name}`: call it new, from_… or start"))
}

/// The type that a line declares for other modules.
fn declared_type(line: &str) -> Option<&str> {
    let rest = line.trim_start().strip_prefix("pub")?;
    let rest = match rest.strip_prefix('(') {
        Some(inner) => inner.split_once(')')?.1,
        None => rest,
    };
    let (keyword, rest) = rest.trim_start().split_once(' ')?;
    let is_type = ["struct", "enum", "trait", "type"].contains(&keyword);
    let end = rest
        .find(|c: char| !c.is_alphanumeric() && c != '_')
        .unwrap_or(rest.len());
    (is_type && end > 0).then(|| &rest[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn superlatives_and_short_constructors_are_found() {
        assert!(problem("pub const MOST_ROWS: usize = 3;").is_some());
        assert!(problem("    pub fn of(scene: &Scene) -> Self {").is_some());
        assert!(problem("const MAX_ROWS: usize = 3; // MOST_ROWS").is_none());
        assert!(problem("/// const MOST_ROWS").is_none());
        assert!(problem("fn offset(self) -> f64 {").is_none());
    }

    #[test]
    fn declared_types_are_found() {
        assert_eq!(declared_type("pub struct Body {"), Some("Body"));
        assert_eq!(declared_type("    pub(crate) enum Kind<T> {"), Some("Kind"));
        assert_eq!(declared_type("pub fn body() {}"), None);
        assert_eq!(declared_type("struct Private;"), None);
    }
}
