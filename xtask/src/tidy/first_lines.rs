//! Every source file opens with one sentence that says what is in it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::{Fault, read};

/// Folders whose sources are looked at.
const FOLDERS: [&str; 4] = ["crates", "xtask", "tests", "benches"];

/// Files that do not open with a sentence.
pub fn faults(root: &Path) -> Result<Vec<Fault>> {
    let mut faults = Vec::new();
    for folder in FOLDERS {
        for path in sources(&root.join(folder))? {
            if !opens_with_a_sentence(&read(&path)?) {
                let path = path.strip_prefix(root).unwrap_or(&path).display();
                faults.push(format!("{path}: the file must open with one sentence, `//! …`"));
            }
        }
    }
    Ok(faults)
}

/// All Rust sources in a folder and below, in alphabetical order.
fn sources(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        if !folder.is_dir() {
            continue;
        }
        for entry in
            std::fs::read_dir(&folder).with_context(|| format!("cannot look into {}", folder.display()))?
        {
            let path = entry?.path();
            if path.is_dir() && !path.ends_with("target") {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// Whether the first paragraph is a doc comment of the file that ends like a sentence.
fn opens_with_a_sentence(text: &str) -> bool {
    let paragraph: Vec<&str> =
        text.lines().map_while(|line| line.strip_prefix("//! ")).map(str::trim).collect();
    let ends = |line: &&str| line.ends_with(['.', ':', '?', '!']) || line.contains(". ");
    paragraph.first().is_some_and(|line| !line.is_empty()) && paragraph.iter().any(ends)
}

#[cfg(test)]
mod tests {
    use super::opens_with_a_sentence;

    #[test]
    fn a_sentence_may_take_two_lines() {
        assert!(opens_with_a_sentence("//! Where bodies are.\n\nuse x;\n"));
        assert!(opens_with_a_sentence("//! Where bodies are, if nothing\n//! happens.\n//!\n//! More.\n"));
    }

    #[test]
    fn code_or_a_title_or_a_blank_is_no_sentence() {
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
