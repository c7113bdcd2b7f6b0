//! The picture of a card: the bodies at the start of its first point, or the first chart of its
//! sweep, both drawn by the program.

use std::{fs, path::Path};

use anyhow::{Context, Result};
use carom_runs::{picture_of, run::interactive::InteractiveRun};
use carom_sweeps::{Size, Study};

use super::{
    cards::{Card, Picture},
    results::CardResults,
};

/// The longer side of a picture of bodies (pixels).
const SIZE: u32 = 420;

/// A longer picture (bytes) makes the page of all cards slow; the first chart is taken instead.
const MAX_LENGTH: usize = 150_000;

/// Scenes of more bodies are not placed for their picture alone.
const MAX_BODIES: usize = 20_000;

/// The pictures of a card.
#[derive(Debug, Default)]
pub struct Pictures {
    /// The bodies at the start; empty if there are too many.
    pub start: String,
    /// The charts that lead the page of the sweep.
    pub charts: Vec<String>,
}

impl Pictures {
    /// Draws the bodies of a card and reads the charts from the page of its sweep.
    ///
    /// # Errors
    /// The page of the sweep cannot be read, or the scene cannot be placed.
    pub fn new(results: &CardResults, site: &Path, is_quick: bool) -> Result<Self> {
        let card = &results.card;
        let page = card.results(site, is_quick).join("report.html");
        let charts = match fs::read_to_string(&page) {
            Ok(html) => leading_charts(&html),
            Err(_) if results.summary.is_none() => Vec::new(),
            Err(error) => {
                return Err(error).with_context(|| format!("cannot read {}", page.display()));
            }
        };
        let start = start(card, site).with_context(|| format!("the picture of {}", card.study))?;
        Ok(Self { start, charts })
    }

    /// The small picture of the card.
    pub fn small(&self, picture: Picture) -> &str {
        let chart = self.charts.first().map_or("", String::as_str);
        let is_start = !self.start.is_empty() && self.start.len() <= MAX_LENGTH;
        match picture {
            Picture::Start if is_start => &self.start,
            _ if !chart.is_empty() => chart,
            _ => &self.start,
        }
    }
}

/// The bodies at the start of the first point in the short form; empty if there are too many.
fn start(card: &Card, site: &Path) -> Result<String> {
    let size = Size {
        replicas: None,
        is_quick: true,
    };
    let study = Study::parse(card.example()?.text, site, size)?;
    let point = study.points.first().context("a study has a point")?;
    let scene = point.replica(1);
    if scene.expected_bodies()? > MAX_BODIES {
        return Ok(String::new());
    }
    let run = InteractiveRun::new(&scene)?;
    Ok(picture_of(&run.view(), SIZE))
}

/// The charts of the first rows of figures on a page.
fn leading_charts(html: &str) -> Vec<String> {
    let Some((_, rest)) = html.split_once("<div class=\"pictures\">") else {
        return Vec::new();
    };
    let row = rest.split("</figure>\n</div>").next().unwrap_or(rest);
    row.split("<svg")
        .skip(1)
        .filter_map(|svg| Some(format!("<svg{}</svg>", svg.split_once("</svg>")?.0)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_report::page::{DataChart, Page};

    #[test]
    fn the_charts_that_lead_a_page_are_found() {
        let chart = |text: &str| DataChart {
            svg: format!("<svg><text>{text}</text></svg>"),
            caption: String::new(),
            file: String::new(),
        };
        let mut page = Page::new("title", "");
        page.charts(&[chart("one"), chart("two")]);
        page.paragraph("between");
        page.charts(&[chart("three")]);
        let found = leading_charts(&page.html());
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[1].contains("two") && leading_charts("<html>").is_empty());
    }
}
