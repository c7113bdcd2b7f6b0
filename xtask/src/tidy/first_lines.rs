//! Checks that every source file opens with one sentence.

use std::path::Path;

use anyhow::Result;

use super::{Fault, files::sources, read};

/// Files that do not open with a sentence.
pub fn faults(root: &Path) -> Result<Vec<Fault>> {
    let mut faults = Vec::new();
    for path in sources(root)? {
        if !opens_with_a_sentence(&read(&root.join(&path))?) {
            faults.push(format!(
                "{}: the file must open with one sentence, `//! …`",
                path.display()
            ));
        }
    }
    Ok(faults)
}

/// Returns true if the file opens with a doc comment whose first paragraph ends like a sentence.
fn opens_with_a_sentence(text: &str) -> bool {
    let paragraph: Vec<&str> = text
        .lines()
        .map_while(|line| line.strip_prefix("//! "))
        .map(str::trim)
        .collect();
    let ends = |line: &&str| line.ends_with(['.', ':', '?', '!']) || line.contains(". ");
    paragraph.first().is_some_and(|line| !line.is_empty()) && paragraph.iter().any(ends)
}

#[cfg(test)]
mod tests {
    use super::opens_with_a_sentence;

    #[test]
    fn a_sentence_may_take_two_lines() {
        assert!(opens_with_a_sentence("//! Where bodies are.\n\nuse x;\n"));
        assert!(opens_with_a_sentence(
            "//! Where bodies are, if nothing\n//! happens.\n//!\n//! More.\n"
        ));
    }

    #[test]
    fn code_or_a_title_or_a_blank_line_is_not_a_sentence() {
        for text in [
            "",
            "use x;\n",
            "\n//! Late.\n",
            "// Not a doc comment.\n",
            "//! A title\n//!\n//! Text.\n",
            "//!\n",
        ] {
            assert!(!opens_with_a_sentence(text), "{text:?}");
        }
    }
}
