//! Checks that every relative link and picture in a Markdown file leads to a file.

use std::path::Path;

use anyhow::Result;

use super::{Fault, files::text_files, read};

/// Links that lead nowhere, in all Markdown files.
pub fn faults(root: &Path) -> Result<Vec<Fault>> {
    let mut faults = Vec::new();
    for path in text_files(root)? {
        if path.extension().is_none_or(|extension| extension != "md") {
            continue;
        }
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        for target in targets(&read(&root.join(&path))?) {
            if !root.join(folder).join(&target).exists() {
                faults.push(format!(
                    "{}: the link to {target} leads nowhere",
                    path.display()
                ));
            }
        }
    }
    Ok(faults)
}

/// The targets of relative links outside of code, without the part after `#`.
fn targets(page: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut is_code = false;
    for line in page.lines() {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
        }
        if is_code {
            continue;
        }
        for rest in line.split("](").skip(1) {
            let Some((target, _)) = rest.split_once(')') else {
                continue;
            };
            let file = target.split('#').next().unwrap_or_default();
            let is_elsewhere = target.contains("://") || target.starts_with("mailto:");
            if !file.is_empty() && !is_elsewhere && !file.contains([' ', '`']) {
                found.push(file.to_owned());
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_targets_are_found_outside_of_code() {
        let page = "See [a](a.md), [b](sub/b.md#part), [web](https://x.org), [here](#there).\n\
                    ```rust\nlet x = v[0](c.md);\n```\n![picture](p.svg)";
        assert_eq!(targets(page), ["a.md", "sub/b.md", "p.svg"]);
    }
}
