//! `cargo xtask site`: the book, the reference of the Rust crates, and a gallery of studies with
//! their measured results, as static pages.

mod cards;
mod pages;
mod picture;
mod results;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use carom_runs::{console::put, print_line};
use carom_tables::Verdict;
use clap::Args;

use crate::{
    repository::{self, Shell},
    web,
};
use cards::Card;
use pages::{GALLERY, SiteParts, VALIDATION};
use picture::Pictures;
use results::{CardResults, Making, write};

/// Options of `cargo xtask site`.
#[derive(Debug, Clone, Args)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "each is an option of the command"
)]
pub struct SiteOptions {
    /// Folder of the site; finished results in it are kept
    #[arg(long, value_name = "FOLDER", default_value = "target/site")]
    pub out: PathBuf,
    /// The short forms of the studies
    #[arg(long)]
    pub quick: bool,
    /// Only the cards of these studies, such as `fields/blast`
    #[arg(long, value_name = "STUDY")]
    pub only: Vec<String>,
    /// Run all studies anew, also those with finished results
    #[arg(long)]
    pub force: bool,
    /// Number of threads; default: one for each processor
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Also write the reference of the Rust crates, which takes minutes
    #[arg(long)]
    pub reference: bool,
    /// Also write the laboratory of `carom live` as a page, which takes minutes
    #[arg(long)]
    pub web: bool,
}

/// Sweeps the studies of the gallery, and writes the site. [`Verdict::Failed`] if a result does not
/// hold.
///
/// # Errors
/// The list of cards is invalid, a file cannot be written, a step cannot be started, or a signal
/// has been received.
pub fn run(options: &SiteOptions) -> Result<Verdict> {
    let cards = selected(Card::all()?, &options.only)?;
    let site = &options.out;
    let parts = parts(options)?;
    let making = Making {
        is_quick: options.quick,
        force: options.force,
        threads: options.threads,
    };
    let mut all = Vec::new();
    for (index, card) in cards.iter().enumerate() {
        print_line(&format!(
            "site: card {} of {}: {}",
            index + 1,
            cards.len(),
            card.study
        ));
        let results = CardResults::make(card, site, making)?;
        let pictures = Pictures::new(&results, site, options.quick)?;
        all.push((results, pictures));
    }
    let command = command(options);
    for (results, pictures) in &all {
        let page = pages::of_card(results, pictures, &parts, options.quick);
        write(&site.join(results.card.page()), &page)?;
    }
    let gallery = pages::gallery(&all, &parts, options.quick, &command);
    write(&site.join(GALLERY), &gallery)?;
    let validation = pages::validation(&all, &parts, options.quick, &command);
    write(&site.join(VALIDATION), &validation)?;
    Ok(conclude(&all, site))
}

/// The cards of these studies; all without any.
///
/// # Errors
/// A study has no card.
fn selected(mut cards: Vec<Card>, only: &[String]) -> Result<Vec<Card>> {
    for study in only {
        ensure!(
            cards.iter().any(|card| card.study == *study),
            "--only: no card shows '{study}'; `carom example` lists the studies"
        );
    }
    if !only.is_empty() {
        cards.retain(|card| only.contains(&card.study));
    }
    Ok(cards)
}

/// Prints what does not hold, and the path of the site.
fn conclude(all: &[(CardResults, Pictures)], site: &Path) -> Verdict {
    let failed = all.iter().filter(|(results, _)| !results.passed());
    let mut verdict = Verdict::Passed;
    for (results, _) in failed {
        verdict = Verdict::Failed;
        for fault in &results.faults {
            print_line(&format!("site: FAILED: {}: {fault}", results.card.study));
        }
    }
    let page = site.join(GALLERY);
    put("page", &page);
    print_line(&format!("site: {} cards: {}", all.len(), page.display()));
    verdict
}

/// The command with the options that change the site.
fn command(options: &SiteOptions) -> String {
    let quick = if options.quick { " --quick" } else { "" };
    let mut command = format!("cargo xtask site{quick}");
    for study in &options.only {
        command.push_str(" --only ");
        command.push_str(study);
    }
    command
}

/// Writes the book and the reference where that is possible and wanted, and says what is skipped.
/// Returns the parts that the site has.
fn parts(options: &SiteOptions) -> Result<SiteParts> {
    let root = repository::root()?;
    let site = std::path::absolute(&options.out).context("the current folder is unknown")?;
    let mut parts = vec![
        (GALLERY.to_owned(), "Gallery".to_owned()),
        (
            VALIDATION.to_owned(),
            "How results were validated".to_owned(),
        ),
    ];
    let shell = Shell { root };
    if repository::has_program("mdbook") {
        let book = site.join("book");
        let book = book.to_string_lossy();
        shell.succeed("mdbook", &["build", "crates/book", "--dest-dir", &book])?;
        parts.push(("book/index.html".to_owned(), "Book".to_owned()));
    } else {
        print_line("site: skipped: the book: mdbook is not installed");
    }
    if options.reference {
        shell.succeed("cargo", &["doc", "--workspace", "--no-deps"])?;
        let written = repository::target_folder()?.join("doc");
        repository::copy_folder(&written, &site.join("reference"))?;
        parts.push((
            "reference/carom/index.html".to_owned(),
            "Rust reference".to_owned(),
        ));
    } else {
        print_line("site: skipped: the reference of the Rust crates: --reference writes it");
    }
    if !options.web {
        print_line("site: skipped: the laboratory as a page: --web writes it");
    } else if web::pages(&site.join("live"))?.is_some() {
        parts.push(("live/index.html".to_owned(), "Laboratory".to_owned()));
    }
    for (path, name) in &parts[2..] {
        if !site.join(path).is_file() {
            bail!("{name}: {} was not written", site.join(path).display());
        }
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A summary with one judged result, which holds or does not.
    fn summary(passed: bool) -> String {
        format!(
            r#"{{
                "title": "A blast", "collisions": 600, "collisions_per_second": 300.0,
                "points_wanted": 1, "points_complete": 1,
                "checks": [{{ "name": "power of time: difference from 0.5", "passed": {passed} }}],
                "points": [{{ "label": "gas.0.radius = 0.1", "answers": [{{
                    "quantity": "power of time of the front", "unit": "1", "value": 0.4949,
                    "standard_error": 0.0001, "expected": "0.5", "allowed": 0.0204,
                    "difference": 0.0051, "passed": {passed}, "source": "Sedov (1946)"
                }}] }}]
            }}"#
        )
    }

    fn results(passed: bool) -> Vec<(CardResults, Pictures)> {
        let folder = tempfile::tempdir().unwrap();
        write(&folder.path().join("summary.json"), &summary(passed)).unwrap();
        let cards = selected(Card::all().unwrap(), &["fields/blast".to_owned()]).unwrap();
        let results = CardResults::read(&cards[0], folder.path(), "abc".to_owned());
        vec![(results, Pictures::default())]
    }

    #[test]
    fn a_result_that_does_not_hold_fails_the_command_and_stands_first_on_the_page() {
        let site = Path::new("site");
        for passed in [true, false] {
            let all = results(passed);
            let verdict = conclude(&all, site);
            assert_eq!(verdict == Verdict::Passed, passed);
            let page = pages::gallery(&all, &Vec::new(), true, "cargo xtask site --quick");
            assert_eq!(page.contains("FAILED"), !passed);
            assert!(page.contains("0.49490 ± 0.00010") && page.contains("Sedov (1946)"));
            assert!(page.contains("2.0 s of processor time"));
            let own = pages::of_card(&all[0].0, &all[0].1, &Vec::new(), true);
            assert!(own.contains("carom example fields/blast --out blast.toml"));
            let validation = pages::validation(&all, &Vec::new(), true, "cargo xtask site");
            assert!(validation.contains("0.25") && validation.contains("Sedov (1946)"));
        }
    }

    #[test]
    fn a_sweep_without_summary_and_a_quantity_that_is_not_there_are_faults() {
        let folder = tempfile::tempdir().unwrap();
        let mut card = Card::all().unwrap().remove(0);
        let none = CardResults::read(&card, folder.path(), String::new());
        assert!(!none.passed() && none.faults[0].contains("summary.json"));
        write(&folder.path().join("summary.json"), &summary(true)).unwrap();
        card.quantity = "entropy".to_owned();
        let other = CardResults::read(&card, folder.path(), String::new());
        assert!(other.faults[0].contains("'entropy'"), "{:?}", other.faults);
    }

    #[test]
    fn unknown_cards_are_refused() {
        let error = selected(Card::all().unwrap(), &["blast".to_owned()]).unwrap_err();
        assert!(
            error.to_string().contains("no card shows 'blast'"),
            "{error}"
        );
    }
}
