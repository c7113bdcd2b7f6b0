//! A gallery on a page: cards with a picture, a sentence and a result, which a reader filters by
//! words and by subject.

use std::{collections::BTreeSet, fmt::Write as _};

use carom_tables::grouped;

use super::{escape, picture};

/// A card of a gallery.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct GalleryCard {
    /// Its title.
    pub title: String,
    /// Path of its page, relative to the page of the gallery.
    pub link: String,
    /// The physics in one sentence.
    pub sentence: String,
    /// A picture (SVG).
    pub svg: String,
    /// The measured quantity, where it was measured, the value with its error, and what is
    /// expected.
    pub result: [String; 4],
    /// Where the expected value comes from.
    pub source: String,
    /// Whether all that is expected holds.
    pub passed: bool,
    /// The verdict in words, and the processor time.
    pub verdict: [String; 2],
    /// Subjects by which the card is selected.
    pub subjects: Vec<String>,
    /// Further words by which it is found.
    pub words: String,
}

/// Its style, which no other page needs.
const STYLE: &str = include_str!("gallery.css");

/// The script that filters the cards.
pub(super) const SCRIPT: &str = include_str!("../gallery.js");

/// The elements of a gallery.
pub(super) fn html(cards: &[GalleryCard]) -> String {
    // In the order of the alphabet, whatever the case.
    let subjects: BTreeSet<(String, &str)> = cards
        .iter()
        .flat_map(|card| &card.subjects)
        .map(|subject| (subject.to_lowercase(), subject.as_str()))
        .collect();
    let mut html = format!(
        "<style>\n{STYLE}</style>\n<div class=\"filter\">\n\
         <input type=\"search\" id=\"search\" placeholder=\"Search {} cards\" aria-label=\"Search\">\n\
         <div class=\"subjects\">\n<button type=\"button\" aria-pressed=\"true\" data-subject=\"\">all</button>\n",
        cards.len()
    );
    for (_, subject) in subjects {
        let _ = writeln!(
            html,
            "<button type=\"button\" aria-pressed=\"false\" data-subject=\"{0}\">{0}</button>",
            escape(subject)
        );
    }
    html.push_str(
        "</div>\n<p id=\"found\" role=\"status\"></p>\n</div>\n<div class=\"gallery\">\n",
    );
    for (index, card) in cards.iter().enumerate() {
        html.push_str(&card_html(index, card));
    }
    let _ = write!(html, "</div>\n<script>\n{SCRIPT}</script>\n");
    html
}

fn card_html(index: usize, card: &GalleryCard) -> String {
    let [quantity, point, measured, expected] =
        [0, 1, 2, 3].map(|part| escape(&grouped(&card.result[part])));
    let class = if card.passed { "good" } else { "bad" };
    let point = if point.is_empty() {
        String::new()
    } else {
        format!(" <span class=\"point\">{point}</span>")
    };
    let words = format!("{} {}", card.words, card.subjects.join(" "));
    format!(
        "<article class=\"card\" data-subjects=\"{subjects}\" data-words=\"{words}\">\n\
         <figure><a class=\"shown\" href=\"{link}\" tabindex=\"-1\" aria-hidden=\"true\">{svg}</a></figure>\n\
         <h3><a href=\"{link}\">{title}</a></h3>\n<p>{sentence}</p>\n\
         <dl>\n<dt>{quantity}{point}</dt>\n<dd class=\"number\">{measured}</dd>\n\
         <dd class=\"expected\">expected {expected}</dd>\n<dd class=\"source\">{source}</dd>\n</dl>\n\
         <p class=\"verdict-line\"><span class=\"{class}\">{verdict}</span> · {time}</p>\n</article>\n",
        subjects = escape(&card.subjects.join("|")),
        words = escape(&words),
        link = escape(&card.link),
        svg = picture(&with_own_names(&card.svg, index)),
        title = escape(&card.title),
        sentence = escape(&card.sentence),
        source = escape(&card.source),
        verdict = escape(&card.verdict[0]),
        time = escape(&card.verdict[1]),
    )
}

/// The picture with names of its clip paths that no other picture of the page has.
fn with_own_names(svg: &str, index: usize) -> String {
    svg.replace("id=\"", &format!("id=\"card{index}-"))
        .replace("url(#", &format!("url(#card{index}-"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn card(title: &str, svg: &str) -> GalleryCard {
        GalleryCard {
            title: title.to_owned(),
            svg: svg.to_owned(),
            subjects: vec!["heat & light".to_owned()],
            ..GalleryCard::default()
        }
    }

    #[test]
    fn cards_are_escaped_and_clip_paths_keep_apart() {
        let svg = "<svg><clipPath id=\"p0\"></clipPath><g clip-path=\"url(#p0)\"></g></svg>";
        let html = html(&[
            card("a < b", svg),
            card("c", svg),
            card("d", "<svg><script/></svg>"),
        ]);
        assert!(html.contains("a &lt; b") && html.contains("data-subject=\"heat &amp; light\""));
        for name in ["card0-p0", "card1-p0"] {
            assert_eq!(html.matches(name).count(), 2, "{name}");
        }
        assert!(html.contains("This picture is not shown") && !html.contains("<script/>"));
    }
}
