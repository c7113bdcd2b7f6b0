//! The reference page of scene files: all keys, and all quantities that a run can measure.

mod keys;
mod measures;

use anyhow::Result;

use carom_tables::Verdict;
use clap::Args;
use serde_json::Value;

use crate::{
    console::{is_json, put},
    print_line,
    schema::{self, scene_schema},
};

/// Widest line of text (columns).
const MAX_WIDTH: usize = 100;

/// Head of the page.
const HEAD: &str = "\
# Scene files

Every key of a scene file, and every quantity that a run can measure. The page is generated from the
types of the program. To change it, change their documentation, and run
`cargo run -p carom-cli -- schema --page > crates/book/src/keys.md`. `carom schema` prints the JSON
Schema.

A scene file is TOML. Units of length, mass and time are free; those of other quantities follow.
Angles are in radians, counter-clockwise. A key without a default may be left out, unless it is
marked as required. An unknown key is refused with its line, the keys allowed there, and the nearest
of them.
";

/// Options of `carom schema`.
#[derive(Debug, Clone, Args)]
pub struct ReferenceOptions {
    /// Print the reference page instead: all keys, ranges, units and measures, as Markdown
    #[arg(long)]
    pub page: bool,
}

/// Prints the schema of scene files, or their page.
///
/// # Errors
/// See [`page`].
pub fn run(options: &ReferenceOptions) -> Result<Verdict> {
    print(&scene_schema(), options.page.then(page).transpose()?);
    Ok(Verdict::Passed)
}

/// Prints a page, or without one the schema.
pub fn print(schema: &Value, page: Option<String>) {
    match page {
        Some(page) => print_line(page.trim_end()),
        None if is_json() => put("schema", schema),
        None => print_line(schema::text(schema).trim_end()),
    }
}

/// Returns the page as Markdown. It runs two small gases, to list what the measures write.
///
/// # Errors
/// A measure cannot be run.
pub fn page() -> Result<String> {
    Ok(page_of(HEAD, &scene_schema()) + &measures::section()?)
}

/// Returns the keys of a file with this schema as Markdown, after a head.
pub fn page_of(head: &str, schema: &Value) -> String {
    head.to_owned() + &keys::outermost(schema) + &keys::sections(schema).concat()
}

/// Text in lines of at most [`MAX_WIDTH`] columns, after the first with an indent.
fn wrapped(text: &str, indent: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is always a line");
        if line.chars().count() + 1 + word.chars().count() > MAX_WIDTH {
            lines.push(format!("{indent}{word}"));
        } else {
            *line += if line.is_empty() { "" } else { " " };
            *line += word;
        }
    }
    lines.join("\n")
}

/// A row of a table.
fn row(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    format!("| {} |\n", cells.join(" | "))
}

/// A table with its headings.
fn table(headings: &[&str], rows: &[Vec<String>]) -> String {
    let rule = vec!["---".to_owned(); headings.len()];
    let headings: Vec<String> = headings.iter().map(|&heading| heading.to_owned()).collect();
    let rows = rows.iter().map(|cells| row(cells));
    [row(&headings), row(&rule)]
        .into_iter()
        .chain(rows)
        .collect()
}

#[cfg(test)]
mod tests;
