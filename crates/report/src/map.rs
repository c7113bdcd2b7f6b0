//! A coloured map of a quantity in the cells of a grid, as SVG.

use std::{collections::BTreeMap, fmt::Write as _};

use crate::{
    chart::TEXT,
    ink::Ink,
    svg::{Anchor, CHARACTER, Svg},
};

/// Length of the longer side of the map, width of the colour bar beside it, and the spaces around
/// both (pixels).
const LONGER: f64 = 720.0;
const BAR: f64 = 22.0;
const TITLE: f64 = 40.0;
const LEFT: f64 = 12.0;
const GAP: f64 = 18.0;
const NUMBERS: f64 = 62.0;

/// Least height of the colour bar, also beside a flat map (pixels). Smaller: its labels overlap.
const MIN_BAR: f64 = 160.0;

/// Number of colours of a bar. More: larger files.
const SHADES: usize = 48;

/// Red, green and blue.
pub type Colour = [u8; 3];

/// The colours of numbers from 0 to 1, and what they stand for.
#[derive(Debug, Clone, PartialEq)]
pub struct ColourBar {
    /// Colours at equal distances, from 0 to 1.
    pub colours: Vec<Colour>,
    /// Places from 0 to 1 with their labels.
    pub labels: Vec<(f64, String)>,
}

impl ColourBar {
    /// Dark for 0, light for 1; colour-blind readers can tell them by lightness.
    pub fn sequence(labels: Vec<(f64, String)>) -> Self {
        let colours = vec![
            [48, 10, 90],
            [40, 90, 140],
            [40, 150, 130],
            [150, 195, 70],
            [250, 225, 60],
        ];
        Self { colours, labels }
    }

    /// A circle of colours for angles: 0 and 1 have the same one. Opposite angles differ in
    /// lightness or between blue and red.
    pub fn circle(labels: Vec<(f64, String)>) -> Self {
        let colours = vec![
            [235, 225, 235],
            [60, 110, 190],
            [50, 20, 60],
            [190, 75, 50],
            [235, 225, 235],
        ];
        Self { colours, labels }
    }

    /// The colour of a number; one that is out of range has that of the nearest end.
    pub fn colour(&self, share: f64) -> Colour {
        let shade = (share.clamp(0.0, 1.0) * (SHADES - 1) as f64).round() / (SHADES - 1) as f64;
        let last = self.colours.len().saturating_sub(1);
        let place = shade * last as f64;
        let first = (place as usize).min(last.saturating_sub(1));
        let [Some(from), Some(to)] =
            [first, (first + 1).min(last)].map(|index| self.colours.get(index))
        else {
            return [0; 3];
        };
        let share = place - first as f64;
        [0, 1, 2].map(|part| {
            (f64::from(from[part]) * (1.0 - share) + f64::from(to[part]) * share).round() as u8
        })
    }
}

/// A map of a rectangle.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Heading.
    pub title: String,
    /// Width and height (length), of which the ratio counts.
    pub sides: [f64; 2],
    /// Columns and rows.
    pub counts: [usize; 2],
    /// The colour of each cell, row by row from the lower left corner.
    pub colours: Vec<Colour>,
    /// The colours beside the map.
    pub bar: ColourBar,
}

impl Map {
    /// Draws the map as SVG.
    pub fn svg(&self) -> String {
        let [columns, rows] = self.counts;
        let longest = self.sides[0].max(self.sides[1]);
        let [width, height] = self.sides.map(|side| LONGER * side / longest);
        let bar_height = height.max(MIN_BAR);
        let title_width = CHARACTER * TEXT * self.title.chars().count() as f64;
        let full = (
            LEFT + (width + GAP + BAR + NUMBERS).max(title_width + LEFT),
            TITLE + bar_height + LEFT,
        );
        let mut svg = Svg::default();
        svg.text(
            (LEFT, TITLE - 14.0),
            Anchor::Start,
            Ink::Text,
            TEXT,
            &self.title,
        );
        svg.raw(&format!(
            "<svg x=\"{LEFT}\" y=\"{TITLE}\" width=\"{width:.2}\" height=\"{height:.2}\" viewBox=\"0 0 {columns} {rows}\" \
             preserveAspectRatio=\"none\" shape-rendering=\"crispEdges\">"
        ));
        for (colour, path) in self.paths() {
            // A line of width 1 along the middle of each row.
            svg.raw(&format!(
                "<path d=\"{path}\" stroke=\"{}\" fill=\"none\"/>",
                hex(colour)
            ));
        }
        svg.raw("</svg>");
        self.draw_bar(&mut svg, LEFT + width + GAP, bar_height);
        svg.finish(full, false)
    }

    /// For each colour the runs of cells that have it.
    fn paths(&self) -> BTreeMap<Colour, String> {
        let [columns, rows] = self.counts;
        let mut paths: BTreeMap<Colour, String> = BTreeMap::new();
        for (row, cells) in self.colours.chunks(columns.max(1)).enumerate().take(rows) {
            let mut column = 0;
            for run in cells.chunk_by(|one, other| one == other) {
                let path = paths.entry(run[0]).or_default();
                // y points upwards.
                line_to(
                    path,
                    format_args!("M{column} {}.5h{}", rows - 1 - row, run.len()),
                );
                column += run.len();
            }
        }
        paths
    }

    fn draw_bar(&self, svg: &mut Svg, left: f64, height: f64) {
        let step = height / SHADES as f64;
        for shade in 0..SHADES {
            let colour = hex(self.bar.colour(shade as f64 / (SHADES - 1) as f64));
            let top = TITLE + height - (shade + 1) as f64 * step;
            // Overlapping, so that no gaps appear between shades.
            svg.raw(&format!(
                "<rect x=\"{left:.1}\" y=\"{top:.2}\" width=\"{BAR}\" height=\"{:.2}\" fill=\"{colour}\"/>",
                step + 0.5
            ));
        }
        for (place, label) in &self.bar.labels {
            let y = (TITLE + height * (1.0 - place) + 0.35 * TEXT)
                .clamp(TITLE + 0.7 * TEXT, TITLE + height);
            svg.text((left + BAR + 6.0, y), Anchor::Start, Ink::Text, TEXT, label);
        }
    }
}

fn hex([red, green, blue]: Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn line_to(text: &mut String, more: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = text.write_fmt(more);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_is_drawn_once_in_its_colour() {
        let bar = ColourBar::sequence(vec![(0.0, "0".to_owned()), (1.0, "a < b".to_owned())]);
        let shares = [0.0, 0.0, 1.0, 1.0, 0.0, 1.0];
        let colours: Vec<Colour> = shares.iter().map(|&share| bar.colour(share)).collect();
        let map = Map {
            title: "t & u".to_owned(),
            sides: [3.0, 2.0],
            counts: [3, 2],
            colours,
            bar,
        };
        let paths = map.paths();
        assert_eq!(paths[&map.bar.colour(0.0)], "M0 1.5h2M1 0.5h1");
        assert_eq!(paths[&map.bar.colour(1.0)], "M2 1.5h1M0 0.5h1M2 0.5h1");
        let svg = map.svg();
        assert!(svg.contains("t &amp; u") && svg.contains("a &lt; b") && !svg.contains("NaN"));
    }

    #[test]
    fn a_flat_map_and_a_narrow_one_have_room_for_labels_and_title() {
        let bar = ColourBar::sequence(
            (0..5)
                .map(|k| (f64::from(k) / 4.0, k.to_string()))
                .collect(),
        );
        let title = "area fraction at t = 10".to_owned();
        let size = |sides: [f64; 2]| {
            let colours = vec![[0; 3]];
            let svg = Map {
                title: title.clone(),
                sides,
                counts: [1, 1],
                colours,
                bar: bar.clone(),
            }
            .svg();
            let view = svg
                .split_once("viewBox=\"0 0 ")
                .unwrap()
                .1
                .split_once('"')
                .unwrap()
                .0;
            let [width, height] =
                [0, 1].map(|n| view.split(' ').nth(n).unwrap().parse::<f64>().unwrap());
            let heights: Vec<f64> = svg
                .split("<text ")
                .skip(2)
                .map(|text| {
                    text.split_once("y=\"")
                        .unwrap()
                        .1
                        .split_once('"')
                        .unwrap()
                        .0
                        .parse()
                        .unwrap()
                })
                .collect();
            assert!(
                heights.windows(2).all(|pair| pair[0] - pair[1] > TEXT),
                "{heights:?}"
            );
            [width, height]
        };
        assert!(size([50.0, 1.0])[1] > MIN_BAR);
        assert!(size([1.0, 50.0])[0] > CHARACTER * TEXT * title.len() as f64);
    }

    #[test]
    fn the_most_colourful_map_makes_a_small_file() {
        let bar = ColourBar::sequence(Vec::new());
        let colours = (0..180 * 180)
            .map(|cell| bar.colour(f64::from(cell * 7 % 47) / 46.0))
            .collect();
        let map = Map {
            title: String::new(),
            sides: [1.0; 2],
            counts: [180, 180],
            colours,
            bar,
        };
        let bytes = map.svg().len();
        assert!((300_000..500_000).contains(&bytes), "{bytes}");
    }

    #[test]
    fn a_bar_begins_and_ends_with_its_colours() {
        let bar = ColourBar::circle(Vec::new());
        assert_eq!(bar.colour(0.0), bar.colour(1.0));
        assert_eq!(
            (bar.colour(-1.0), bar.colour(2.0)),
            (bar.colours[0], bar.colours[4])
        );
        assert!(
            bar.colour(f64::NAN).len() == 3
                && ColourBar {
                    colours: vec![],
                    ..bar
                }
                .colour(0.5)
                    == [0; 3]
        );
    }
}
