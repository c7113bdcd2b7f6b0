//! Checks that comments and Markdown are at most 100 columns wide; tables, headings and
//! code are not checked.

use std::path::Path;

use anyhow::Result;

use super::{Fault, files::text_files, read};

/// Widest comment or line of Markdown (columns).
const MAX_WIDTH: usize = 100;

/// Lines that are too wide, in all sources and pages.
pub fn faults(root: &Path) -> Result<Vec<Fault>> {
    let mut faults = Vec::new();
    for path in text_files(root)? {
        let text = read(&root.join(&path))?;
        let is_page = path.extension().is_some_and(|extension| extension == "md");
        let wide = if is_page {
            wide_lines_of_page(&text)
        } else {
            wide_comments(&text)
        };
        faults.extend(wide.into_iter().map(|(line, width)| {
            format!(
                "{}:{line}: {width} columns, at most {MAX_WIDTH} are allowed",
                path.display()
            )
        }));
    }
    Ok(faults)
}

/// Comment lines that are too wide, tables and code in them aside: number from 1, and columns.
fn wide_comments(source: &str) -> Vec<(usize, usize)> {
    let mut is_code = false;
    too_wide(source.lines().enumerate().filter(move |(_, line)| {
        let Some(comment) = line.trim_start().strip_prefix("//") else {
            is_code = false;
            return false;
        };
        let text = comment.trim_start_matches(['/', '!']).trim_start();
        is_code ^= text.starts_with("```");
        !is_code && !text.starts_with('|')
    }))
}

/// Lines of Markdown outside tables, headings and code that are too wide.
fn wide_lines_of_page(page: &str) -> Vec<(usize, usize)> {
    let mut is_code = false;
    too_wide(page.lines().enumerate().filter(move |(_, line)| {
        is_code ^= line.trim_start().starts_with("```");
        // A heading cannot be wrapped.
        !is_code && !line.starts_with(['|', '#'])
    }))
}

fn too_wide<'a>(lines: impl Iterator<Item = (usize, &'a str)>) -> Vec<(usize, usize)> {
    let widths = lines.map(|(index, line)| (index + 1, line.chars().count()));
    widths.filter(|&(_, width)| width > MAX_WIDTH).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_comments_are_found_and_wide_code_is_not() {
        let wide = "x".repeat(MAX_WIDTH);
        let source = format!(
            "let a = \"{wide}\";\n// {wide}\n    /// µ{}\n",
            "x".repeat(MAX_WIDTH - 9)
        );
        assert_eq!(wide_comments(&source), [(2, MAX_WIDTH + 3)]);
        let table_and_code = format!("/// | {wide} |\n/// ```\n/// {wide}\n/// ```\n/// {wide}\n");
        assert_eq!(wide_comments(&table_and_code), [(5, MAX_WIDTH + 4)]);
    }

    #[test]
    fn tables_and_code_of_a_page_may_be_wide() {
        let wide = "y".repeat(MAX_WIDTH + 1);
        let page = format!("| {wide} |\n```\n{wide}\n```\n{wide}\n");
        assert_eq!(wide_lines_of_page(&page), [(5, MAX_WIDTH + 1)]);
    }
}
