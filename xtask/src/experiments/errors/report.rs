//! The page: the ratio of each quantity, and its band.

use anyhow::Result;
use carom_report::page::{Page, Part};
use carom_runs::output::Folder;
use carom_tables::{Summary, Verdict};

use super::results::Compared;

/// Writes the table of ratios and returns the page.
///
/// # Errors
/// A file cannot be written.
pub fn write(folder: &Folder, compared: &[Compared], summary: &Summary, command: &str) -> Result<Page> {
    let header = ["quantity", "rows", "ratio", "least", "most"];
    let rows = compared.iter().map(|one| (&one.name, one.rows, one.ratio, one.band[0], one.band[1]));
    folder.write_table("ratios.csv", &header, rows)?;
    let verdict = match summary.verdict() {
        Verdict::Passed => "The standard errors agree with the scatter of the replicas.".to_owned(),
        Verdict::Failed | Verdict::Incomplete => {
            "Some standard errors do not agree with the scatter of the replicas.".to_owned()
        }
    };
    let mut page = Page::new(&summary.title, "Each quantity is measured in many replicas.");
    page.verdict(&verdict);
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.part(Part::Answer);
    let cells = compared.iter().map(|one| {
        let numbers = [one.ratio, one.band[0], one.band[1]].map(|number| format!("{number:.3}"));
        [vec![one.name.clone(), one.rows.to_string()], numbers.to_vec()].concat()
    });
    page.table(
        &["quantity", "rows", "⟨error²⟩/variance", "99 % band from", "to"],
        &cells.collect::<Vec<_>>(),
    );
    page.paragraph(
        "Each run estimates the error of its means from the scatter of its blocks. The variance is that of the \
         means among the replicas. Ratios are averaged over the rows of a curve.",
    );
    page.totals(&summary.totals);
    page.checks(&summary.checks);
    page.code(command);
    page.links(["ratios.csv", "scene.toml", "summary.json", "manifest.json", "config.toml"]);
    Ok(page)
}
