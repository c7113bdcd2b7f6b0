//! `carom report`: the page of a run folder from its data, so that old folders get the page of this
//! version.
//!
//! `carom run` and `carom merge` write their pages by the same functions from the files that they
//! have just written. So a page written again by the same version has the same bytes.

mod contents;
mod evidence;
mod experiment_page;
mod files;
mod read;
mod run_page;
mod stationarity_in_words;
mod tables_file;
mod tests_in_words;
mod verdict;

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use carom_report::{page::DataChart, table_chart};
use carom_tables::{Table, Verdict};
use clap::Args;

use contents::{FolderContents, FolderKind};
pub use contents::{FolderState, MEASURED_FROM, RUNS};
pub use stationarity_in_words::{few_samples_in_words, judged, stationarity_in_words};
pub use tables_file::write as write_tables;
pub use tests_in_words::tests_in_words;
pub(crate) use verdict::is_rate_of_kicks;
pub use verdict::{FIXED_BODIES, NOT_EXACT};

use crate::{
    output::{Folder, MANIFEST},
    print_line,
    progress::Progress,
};

/// Name of the page in a folder.
pub const PAGE: &str = "report.html";

/// The maps of a table over a grid, as SVG; none of a table with one abscissa.
///
/// # Errors
/// A map cannot be drawn.
pub fn maps_of(table: &Table) -> Result<Vec<String>> {
    if table.grid().is_none() {
        return Ok(Vec::new());
    }
    table_chart::charts(table)
}

/// Options of `carom report`.
#[derive(Debug, Clone, Args)]
pub struct ReportOptions {
    /// Folders of runs, merged runs, or experiments
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
}

/// Writes the pages of folders again. The page of a run or of merged runs is made from the data; an
/// incomplete folder gives a page that says so. Of an experiment, the page keeps its content and
/// gets the present layout.
///
/// # Errors
/// A folder holds no run, or a file cannot be read or written.
pub fn run(options: &ReportOptions) -> Result<Verdict> {
    let progress = Progress::items("folders", options.folders.len() as u64);
    for path in &options.folders {
        ensure!(
            path.join(MANIFEST).is_file(),
            "{} holds no run: it has no {MANIFEST}",
            path.display()
        );
        // A run in progress would write the same files.
        let (folder, lock) = Folder::claim_if(path, |_| Ok(()))?;
        let written = write_again(&folder);
        written.with_context(|| format!("cannot write the page of {}", path.display()))?;
        drop(lock);
        progress.count(1);
        print_line(&format!("{}", path.join(PAGE).display()));
    }
    Ok(Verdict::Passed)
}

fn write_again(folder: &Folder) -> Result<()> {
    let contents = FolderContents::read(folder, None)?.in_own_units();
    match contents.kind {
        FolderKind::Run | FolderKind::Merge => folder.write(PAGE, run_page::html(&contents)?),
        FolderKind::Sweep | FolderKind::Experiment => {
            folder.write(PAGE, experiment_page::html(folder, &contents)?)
        }
    }
}

/// Writes the page of a run or of merged runs from the files in the folder.
///
/// # Errors
/// A file cannot be read or written, or a table cannot be drawn.
pub fn write(folder: &Folder, state: FolderState) -> Result<()> {
    folder.write(
        PAGE,
        run_page::html(&FolderContents::read(folder, Some(state))?.in_own_units())?,
    )
}

/// The pictures and charts that carry the answer of a run or of merged runs, from the files of its
/// folder.
///
/// # Errors
/// A file cannot be read, or a table cannot be drawn.
pub fn evidence(folder: &Folder) -> Result<Vec<DataChart>> {
    run_page::evidence(&FolderContents::read(folder, Some(FolderState::Ended))?)
}

#[cfg(test)]
mod tests;
