//! Checks that the text contains no banned words from `words.txt`, except on allowed lines.

use std::{collections::BTreeSet, path::Path};

use anyhow::{Context, Result};

use super::{
    Fault,
    files::{configuration_files, text_files},
    read,
};

/// The list: one banned phrase a line, or `allow PATH: TEXT` for lines that contain TEXT.
const LIST: &str = "xtask/src/tidy/words.txt";

/// Banned words in comments, strings and pages, and in manifests, scenes and scripts.
pub fn faults(root: &Path) -> Result<Vec<Fault>> {
    let list = List::parse(&read(&root.join(LIST))?)?;
    let mut faults = Vec::new();
    let mut used = BTreeSet::new();
    for path in text_files(root)?
        .into_iter()
        .chain(configuration_files(root)?)
    {
        let name = path.display().to_string();
        let text = read(&root.join(&path))?;
        for (index, line) in text.lines().enumerate() {
            let Some(word) = list.banned_in(line) else {
                continue;
            };
            match list.exception(&name, line) {
                Some(exception) => {
                    used.insert(exception);
                }
                None => faults.push(format!("{name}:{}: `{word}`: {}", index + 1, line.trim())),
            }
        }
    }
    let unused = (0..list.exceptions.len()).filter(|exception| !used.contains(exception));
    faults.extend(unused.map(|exception| {
        let (path, text) = &list.exceptions[exception];
        format!("{LIST}: `allow {path}: {text}` allows nothing")
    }));
    Ok(faults)
}

struct List {
    words: Vec<String>,
    exceptions: Vec<(String, String)>,
}

impl List {
    fn parse(text: &str) -> Result<Self> {
        let mut list = Self {
            words: Vec::new(),
            exceptions: Vec::new(),
        };
        for line in text
            .lines()
            .map(str::trim)
            .filter(|line| !line.is_empty() && !line.starts_with('#'))
        {
            if let Some(exception) = line.strip_prefix("allow ") {
                let (path, text) = exception.split_once(": ").with_context(|| {
                    format!("{LIST}: `{line}` is not of the form allow PATH: TEXT")
                })?;
                list.exceptions.push((path.to_owned(), text.to_owned()));
            } else {
                list.words.push(line.to_lowercase());
            }
        }
        Ok(list)
    }

    /// The first banned phrase in a line, as whole words.
    fn banned_in(&self, line: &str) -> Option<&str> {
        let line = line.to_lowercase();
        let is_word =
            |character: Option<char>| character.is_some_and(|c| c.is_alphanumeric() || c == '_');
        let stands = |word: &&String| {
            line.match_indices(word.as_str()).any(|(at, _)| {
                !is_word(line[..at].chars().next_back())
                    && !is_word(line[at + word.len()..].chars().next())
            })
        };
        self.words.iter().find(stands).map(String::as_str)
    }

    fn exception(&self, path: &str, line: &str) -> Option<usize> {
        self.exceptions
            .iter()
            .position(|(file, text)| file == path && line.contains(text.as_str()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_words_are_banned_and_listed_lines_are_allowed() {
        let list =
            List::parse("# comment\nkettle\npot of tea\nallow a.md: kettle boils\n").unwrap();
        assert_eq!(list.banned_in("Kettle and cup"), Some("kettle"));
        assert_eq!(list.banned_in("a pot of tea"), Some("pot of tea"));
        assert_eq!(list.banned_in("KETTLE_IS, kettle1"), None);
        assert_eq!(list.exception("a.md", "here kettle boils."), Some(0));
        assert_eq!(list.exception("b.md", "here kettle boils."), None);
        assert!(List::parse("allow a.md").is_err());
    }
}
