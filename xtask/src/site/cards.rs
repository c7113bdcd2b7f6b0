//! The list of the gallery's cards: which study each shows, with a sentence of physics and the
//! source of what is expected.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, ensure};
use carom_runs::examples::Example;
use serde::Deserialize;

/// The file of the list.
const LIST: &str = include_str!("gallery.toml");

/// The list.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    card: Vec<Card>,
}

/// What a card's small picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Picture {
    /// The bodies at the start of the first point.
    #[default]
    Start,
    /// The first chart on the page of the sweep.
    Chart,
}

/// A card of the gallery.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    /// Name of the study, by which `carom example` writes it.
    pub study: String,
    /// Title.
    pub title: String,
    /// The physics in one sentence.
    pub sentence: String,
    /// Where the expected values come from.
    pub source: String,
    /// Subjects by which the card is selected.
    pub subjects: Vec<String>,
    /// Further words by which it is found.
    #[serde(default)]
    pub words: String,
    /// Part of the name of the quantity that the card shows; default: the first that is judged.
    #[serde(default)]
    pub quantity: String,
    /// Part of the label of the point that the card shows; default: the first point.
    #[serde(default)]
    pub point: String,
    /// What the small picture shows.
    #[serde(default)]
    pub picture: Picture,
}

impl Card {
    /// All cards in their order.
    ///
    /// # Errors
    /// The list is invalid, see [`parse`].
    pub fn all() -> Result<Vec<Self>> {
        parse(LIST).context("xtask/src/site/gallery.toml")
    }

    /// The study that the program carries.
    ///
    /// # Errors
    /// There is none of this name.
    pub fn example(&self) -> Result<&'static Example> {
        Example::named(&self.study)
    }

    /// Name of its page and folder: that of the study without folders.
    pub fn name(&self) -> String {
        self.study.replace('/', "-")
    }

    /// Name of the file to which its commands write the study.
    pub fn file(&self) -> String {
        let stem = self.study.rsplit('/').next().unwrap_or(&self.study);
        format!("{stem}.toml")
    }

    /// Path of its page in the site.
    pub fn page(&self) -> String {
        format!("cards/{}.html", self.name())
    }

    /// The folder of its results in the site: short forms have folders of their own.
    pub fn results(&self, site: &Path, is_quick: bool) -> PathBuf {
        site.join(self.results_name(is_quick))
    }

    /// Path of that folder in the site.
    pub fn results_name(&self, is_quick: bool) -> String {
        let quick = if is_quick { "-quick" } else { "" };
        format!("results/{}{quick}", self.name())
    }
}

/// Reads and validates a list of cards.
///
/// # Errors
/// A key is unknown or missing, a study does not exist or occurs twice, or a text is empty.
fn parse(text: &str) -> Result<Vec<Card>> {
    let List { card: cards } = toml::from_str(text)?;
    let mut studies = BTreeSet::new();
    for card in &cards {
        let study = &card.study;
        let example = card.example()?;
        ensure!(
            example.name == study && example.command == "sweep",
            "'{study}' is no study: give its full name, as `carom example` lists it"
        );
        ensure!(studies.insert(study), "the study '{study}' has two cards");
        for (key, text) in [
            ("title", &card.title),
            ("sentence", &card.sentence),
            ("source", &card.source),
        ] {
            ensure!(
                !text.trim().is_empty(),
                "the card of '{study}' has no {key}"
            );
        }
        ensure!(
            card.sentence.ends_with('.') && !card.sentence.contains(". "),
            "the card of '{study}' needs one sentence, but has \"{}\"",
            card.sentence
        );
        ensure!(
            !card.subjects.is_empty(),
            "the card of '{study}' has no subject"
        );
    }
    Ok(cards)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CARD: &str = r#"
        [[card]]
        study = "fields/blast"
        title = "A blast"
        sentence = "A front."
        source = "Sedov (1946)"
        subjects = ["driven"]
    "#;

    #[test]
    fn the_gallery_has_forty_cards_of_studies_that_exist_each_with_a_source() {
        let cards = Card::all().unwrap();
        assert!(cards.len() >= 40, "{}", cards.len());
        let names: BTreeSet<String> = cards.iter().map(Card::name).collect();
        assert_eq!(names.len(), cards.len());
        let subjects: BTreeSet<&String> = cards.iter().flat_map(|card| &card.subjects).collect();
        assert!(subjects.len() < 20, "{subjects:?}");
    }

    #[test]
    fn a_card_without_source_of_an_unknown_study_or_of_two_sentences_is_refused() {
        assert_eq!(parse(CARD).unwrap()[0].file(), "blast.toml");
        for (from, to, reason) in [
            ("Sedov (1946)", " ", "has no source"),
            ("fields/blast", "fields/blats", "did you mean"),
            ("fields/blast", "mixture", "is no study"),
            ("A front.", "A front. It grows.", "one sentence"),
            ("[\"driven\"]", "[]", "has no subject"),
            ("title", "tilte", "unknown field"),
        ] {
            let error = parse(&CARD.replace(from, to)).unwrap_err();
            assert!(format!("{error:#}").contains(reason), "{reason}: {error:#}");
        }
        let twice = parse(&CARD.repeat(2)).unwrap_err();
        assert!(format!("{twice:#}").contains("two cards"));
    }
}
