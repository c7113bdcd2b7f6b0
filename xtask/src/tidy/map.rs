//! Checks that the map of the crates in `crates/book/src/architecture.md` lists exactly the
//! existing crates.

use std::path::Path;

use anyhow::Result;

use super::{Fault, crates, read};

/// Crates that are only in the map or only in the folder.
pub fn faults(root: &Path) -> Result<Vec<Fault>> {
    let path = root.join("crates/book/src/architecture.md");
    if !path.is_file() {
        return Ok(vec![
            "crates/book/src/architecture.md: the page is missing".to_owned(),
        ]);
    }
    Ok(compare(&mapped(&read(&path)?), &crates(root)?))
}

fn compare(mapped: &[String], existing: &[String]) -> Vec<Fault> {
    let gone = mapped.iter().filter(|name| !existing.contains(name));
    let gone = gone.map(|name| {
        format!("crates/book/src/architecture.md: the map lists `{name}`, which is not a crate")
    });
    let missing = existing.iter().filter(|name| !mapped.contains(name));
    let missing = missing
        .map(|name| format!("crates/book/src/architecture.md: the map lacks the crate `{name}`"));
    gone.chain(missing).collect()
}

/// First column of the table whose first heading is "crate": names, with or without backticks, link
/// and `carom-`.
fn mapped(page: &str) -> Vec<String> {
    let first_cell = |line: &str| -> Option<String> {
        let cell = line
            .trim()
            .strip_prefix('|')?
            .split('|')
            .next()?
            .trim()
            .to_owned();
        let name = cell
            .split("](")
            .next()
            .unwrap_or(&cell)
            .trim_matches(['[', ']', '`', '*']);
        Some(
            name.trim_start_matches("crates/")
                .trim_start_matches("carom-")
                .to_owned(),
        )
    };
    page.lines()
        .map(first_cell)
        .skip_while(|cell| {
            cell.as_deref()
                .is_none_or(|name| !name.eq_ignore_ascii_case("crate"))
        })
        .skip(1)
        .map_while(|cell| cell)
        .filter(|name| !name.trim_matches(['-', ':', ' ']).is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "# Map\n\n| seam | lives in |\n| --- | --- |\n| detection | x |\n\n\
                        | crate | answers |\n| --- | --- |\n| `geometry` | shapes |\n\
                        | [`engine`](engine/src/lib.rs) | order |\n| carom-observers | looks |\n\nText | more\n";

    #[test]
    fn the_table_of_crates_is_found_and_read() {
        assert_eq!(mapped(PAGE), ["geometry", "engine", "observers"]);
        assert!(mapped("no table").is_empty());
    }

    #[test]
    fn both_too_many_and_too_few_are_faults() {
        let names = |list: &[&str]| list.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        assert!(compare(&mapped(PAGE), &names(&["engine", "geometry", "observers"])).is_empty());
        assert_eq!(
            compare(&mapped(PAGE), &names(&["engine", "geometry", "response"])).len(),
            2
        );
    }
}
