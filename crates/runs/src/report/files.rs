//! The files of a folder with what they hold, for the part of a page with the data.

use carom_tables::Table;

use crate::{
    file_names::{CHECKPOINT, GROWTH, KNOWN},
    measures,
};

/// More files are counted and not listed: a folder may hold thousands of snapshots.
const MAX_FILES: usize = 200;

/// Files and their content, in order of their names, without the page, checkpoints and temporary
/// files.
pub(super) fn listed(names: &[String], tables: &[Table]) -> Vec<(String, String)> {
    let is_data = |name: &&String| {
        let ending = ending(name);
        let is_page = ending == "html" && !name.contains('/');
        let is_state = [CHECKPOINT, GROWTH].contains(&name.as_str());
        !(is_page || is_state || ending == "part" || name.starts_with('.'))
    };
    let shown: Vec<&String> = names.iter().filter(is_data).collect();
    let mut files: Vec<(String, String)> = shown
        .iter()
        .take(MAX_FILES)
        .map(|name| ((*name).clone(), content(name, tables)))
        .collect();
    if shown.len() > MAX_FILES {
        files.push((
            ".".to_owned(),
            format!("{} more files", shown.len() - MAX_FILES),
        ));
    }
    files
}

/// The ending of a file's name, without its dot; empty without one.
pub(super) fn ending(name: &str) -> &str {
    name.rsplit_once('.').map_or("", |(_, ending)| ending)
}

fn content(name: &str, tables: &[Table]) -> String {
    if let Some(table) = tables
        .iter()
        .find(|table| measures::file_name(table) == name)
    {
        return table.title.clone();
    }
    if let Some((_, content)) = KNOWN.iter().find(|(known, _)| *known == name) {
        return (*content).to_owned();
    }
    match ending(name) {
        "html" => "page of a run",
        "record" => "sums of one replica",
        _ if name.starts_with("events") => "contacts, one a row",
        _ if name.starts_with("impulses") => "impulses, one a row",
        "csv" => "table",
        "svg" => "picture",
        "extxyz" => "states, for OVITO and ASE",
        "toml" => "scene",
        _ => "",
    }
    .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_are_listed_and_the_page_and_checkpoints_are_not() {
        let names = [
            "a/report.html",
            "checkpoint",
            "events-a.csv",
            "report.html",
            "x.csv",
            "y.csv.part",
            "y.svg",
        ];
        let table = Table::new("x", "Distribution of x");
        let files = listed(&names.map(str::to_owned), &[table]);
        let expected = [
            ("a/report.html", "page of a run"),
            ("events-a.csv", "contacts, one a row"),
            ("x.csv", "Distribution of x"),
            ("y.svg", "picture"),
        ];
        assert_eq!(
            files,
            expected.map(|(name, content)| (name.to_owned(), content.to_owned()))
        );
        let many: Vec<String> = (0..1000).map(|index| format!("{index:04}.csv")).collect();
        let files = listed(&many, &[]);
        assert_eq!(
            (files.len(), files[MAX_FILES].1.as_str()),
            (MAX_FILES + 1, "800 more files")
        );
    }
}
