//! The section of the changelog that belongs to a version.

use anyhow::{Result, bail};

/// The section of a version in a changelog; of an unreleased version the section `[Unreleased]`,
/// and true.
///
/// # Errors
/// The changelog has neither section, or an empty one.
pub fn section(changelog: &str, version: &str) -> Result<(String, bool)> {
    for (name, is_unreleased) in [(version, false), ("Unreleased", true)] {
        if let Some(text) = named(changelog, name) {
            if text.is_empty() {
                bail!("CHANGELOG.md: the section [{name}] is empty");
            }
            return Ok((text, is_unreleased));
        }
    }
    bail!("CHANGELOG.md has no section [{version}] and no section [Unreleased]")
}

/// The text below the heading `## [NAME]`, up to the next one of its level.
fn named(changelog: &str, name: &str) -> Option<String> {
    let heading = format!("## [{name}]");
    let mut lines = changelog
        .lines()
        .skip_while(|line| !line.starts_with(&heading));
    lines.next()?;
    let text: Vec<&str> = lines.take_while(|line| !line.starts_with("## ")).collect();
    Some(text.join("\n").trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_section_of_a_version_comes_before_the_unreleased_one() {
        let text =
            "# Changelog\n\n## [Unreleased]\n\n### Added\n- b\n\n## [0.1.0] - 2026-01-01\n\n- a\n";
        assert_eq!(section(text, "0.1.0").unwrap(), ("- a".to_owned(), false));
        assert_eq!(
            section(text, "0.2.0").unwrap(),
            ("### Added\n- b".to_owned(), true)
        );
        assert!(section("# Changelog\n", "0.1.0").is_err());
        assert!(section("## [0.1.0]\n\n## [0.0.1]\n- a\n", "0.1.0").is_err());
    }
}
