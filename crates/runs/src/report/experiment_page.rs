//! The page of an experiment in the present layout. Its text and charts are those of the page that
//! the experiment wrote; without one, the page shows what every folder has.

use std::fs;

use anyhow::{Context, Result};
use carom_report::page::{DataChart, Page, PagePart, checks_in_words, relaid};

use super::{
    contents::{FolderContents, FolderState},
    files,
};
use crate::output::Folder;

/// The page.
///
/// # Errors
/// A file of the folder cannot be read.
pub(super) fn html(folder: &Folder, contents: &FolderContents) -> Result<String> {
    let written = fs::read_to_string(folder.path().join(super::PAGE)).ok();
    match written.as_deref().and_then(relaid) {
        Some(page) => Ok(page),
        None => plain(folder, contents),
    }
}

/// What every folder has: figures, pictures, files, command and checks.
fn plain(folder: &Folder, contents: &FolderContents) -> Result<String> {
    let summary = contents.summary.as_ref();
    let mut page = Page::new(
        summary.map_or(&contents.again, |summary| &summary.title),
        "",
    );
    if contents.state != FolderState::Ended {
        page.error("This folder is incomplete: the experiment has not ended.");
    }
    if let Some(summary) = summary {
        page.verdict(&checks_in_words(&summary.checks));
        if !summary.note.is_empty() {
            page.note(&summary.note);
        }
        page.heading("Figures");
        page.figures(&summary.figures);
        page.checks(&summary.checks);
        page.totals(&summary.totals);
    }
    page.heading("Pictures");
    for name in contents
        .names
        .iter()
        .filter(|name| files::ending(name) == "svg")
    {
        let svg = folder
            .read(name)
            .with_context(|| format!("cannot show {name}"))?;
        page.charts(&[DataChart {
            svg,
            caption: String::new(),
            file: name.clone(),
        }]);
    }
    page.part(PagePart::Data);
    page.files(&files::listed(&contents.names, &[]));
    page.code(&contents.again);
    Ok(page.html())
}
