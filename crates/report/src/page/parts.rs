//! The parts of a page in the order in which a reader needs them, whatever the order of writing.

use std::fmt::Write as _;

use super::escape;

/// A part of a page. Pages show them in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PagePart {
    /// The answer: what carries the verdict, such as two charts or a summary table.
    Answer,
    /// The moving picture.
    Motion,
    /// Figures, charts and tables.
    Results,
    /// Files.
    Data,
    /// How to run it again.
    Again,
    /// Totals and checks.
    Checks,
}

impl PagePart {
    const ALL: [Self; 6] = [
        Self::Answer,
        Self::Motion,
        Self::Results,
        Self::Data,
        Self::Again,
        Self::Checks,
    ];

    /// Whether the part opens on demand: what a reader seldom needs.
    fn is_folded(self) -> bool {
        matches!(self, Self::Data | Self::Checks)
    }

    /// Heading of the part; the answer needs none, and results have headings of their own.
    fn heading(self) -> &'static str {
        match self {
            Self::Answer | Self::Results => "",
            Self::Motion => "Moving picture",
            Self::Data => "Data",
            Self::Again => "Run it again",
            Self::Checks => "Checks",
        }
    }
}

/// A piece of a part.
#[derive(Debug, Clone)]
enum Block {
    /// A heading of level 2 or 3.
    Heading(u8, String),
    /// Elements.
    Html(String),
}

/// The contents of all parts.
#[derive(Debug, Clone, Default)]
pub(super) struct PageParts([Vec<Block>; PagePart::ALL.len()]);

impl PageParts {
    pub(super) fn heading(&mut self, part: PagePart, level: u8, text: &str) {
        self.0[part as usize].push(Block::Heading(level, text.to_owned()));
    }

    pub(super) fn push(&mut self, part: PagePart, html: &str) {
        match self.0[part as usize].last_mut() {
            Some(Block::Html(last)) => last.push_str(html),
            _ => self.0[part as usize].push(Block::Html(html.to_owned())),
        }
    }

    /// The parts in their order; one without content is left out, and so is a heading without.
    pub(super) fn html(&self) -> String {
        let mut html = String::new();
        for part in PagePart::ALL {
            let blocks = &self.0[part as usize];
            if !blocks.iter().any(|block| matches!(block, Block::Html(_))) {
                continue;
            }
            html.push_str("<section>\n");
            if part.is_folded() {
                // What has failed is open.
                let has_failed = |block: &Block| matches!(block, Block::Html(html) if html.contains("class=\"bad\""));
                let open = if blocks.iter().any(has_failed) {
                    " open"
                } else {
                    ""
                };
                let _ = writeln!(
                    html,
                    "<details{open}>\n<summary><h2>{}</h2></summary>",
                    part.heading()
                );
            } else if !part.heading().is_empty() {
                let _ = writeln!(html, "<h2>{}</h2>", part.heading());
            }
            for (index, block) in blocks.iter().enumerate() {
                match block {
                    Block::Html(elements) => html.push_str(elements),
                    Block::Heading(level, text) if has_content(&blocks[index + 1..], *level) => {
                        let _ = writeln!(html, "<h{level}>{}</h{level}>", escape(text));
                    }
                    Block::Heading(..) => (),
                }
            }
            html.push_str(if part.is_folded() {
                "</details>\n</section>\n"
            } else {
                "</section>\n"
            });
        }
        html
    }
}

/// Whether anything but headings of lower level comes before the next heading of this level.
fn has_content(after: &[Block], level: u8) -> bool {
    let own = after
        .iter()
        .take_while(|block| !matches!(block, Block::Heading(next, _) if *next <= level));
    own.into_iter().any(|block| matches!(block, Block::Html(_)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_one_order_and_headings_without_content_are_left_out() {
        let mut parts = PageParts::default();
        parts.push(PagePart::Checks, "<p>checks</p>");
        parts.heading(PagePart::Results, 2, "Empty");
        parts.heading(PagePart::Results, 2, "Outer");
        parts.heading(PagePart::Results, 3, "Inner & more");
        parts.push(PagePart::Results, "<p>results</p>");
        parts.heading(PagePart::Results, 3, "Last");
        parts.push(PagePart::Answer, "<p>answer</p>");
        let html = parts.html();
        let at = |text: &str| {
            html.find(text)
                .unwrap_or_else(|| panic!("no {text} in {html}"))
        };
        assert!(at("answer") < at("Outer") && at("Outer") < at("Inner &amp; more"));
        assert!(at("results") < at("<h2>Checks") && at("<h2>Checks") < at("<p>checks"));
        for absent in ["Empty", "Last", "Data", "Run it again", "Moving"] {
            assert!(!html.contains(absent), "{absent}");
        }
    }
}
