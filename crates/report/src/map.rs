//! A coloured map of a quantity in the cells of a grid, as SVG.

use std::{collections::BTreeMap, fmt::Write as _};

use carom_tables::significant;

use crate::{
    axis::range,
    chart::TEXT,
    ink::Ink,
    svg::{Anchor, CHARACTER, Svg},
};

/// Length of the longer side of a map that fills the page (pixels).
pub const WIDE: f64 = 720.0;
/// Length of the longer side of one of two maps side by side (pixels).
pub const NARROW: f64 = 400.0;

/// Width of the colour bar beside the map, and the spaces around both (pixels).
const BAR: f64 = 22.0;
const TITLE: f64 = 40.0;
const LEFT: f64 = 12.0;
const GAP: f64 = 18.0;
const NUMBERS: f64 = 62.0;

/// Least height of the colour bar, also beside a flat map (pixels). Smaller: its labels overlap.
const MIN_BAR: f64 = 160.0;

/// Number of colours of a bar. More: larger files.
const SHADES: usize = 48;

/// Digits of a number beside a colour bar.
const LABEL_DIGITS: u8 = 4;

/// The colour of a cell without a value.
pub const NO_VALUE: Colour = [178, 178, 178];

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

    /// Blue for 0, light for ½, red for 1: negative and positive numbers on a scale about 0.
    pub fn diverging(labels: Vec<(f64, String)>) -> Self {
        let colours = vec![
            [25, 70, 140],
            [115, 165, 205],
            [240, 238, 232],
            [225, 140, 100],
            [150, 30, 45],
        ];
        Self { colours, labels }
    }

    /// The bar of numbers, and the numbers at its ends: the least and the greatest, or ± the
    /// greatest magnitude if there are negative and positive ones. Equal numbers have a narrow
    /// range.
    pub fn of_values(values: impl IntoIterator<Item = f64>) -> (Self, [f64; 2]) {
        let (least, most) = range(values.into_iter()).unwrap_or((0.0, 1.0));
        let is_signed = least < 0.0 && most > 0.0;
        let ends = if is_signed {
            let most = most.max(-least);
            [-most, most]
        } else if most > least {
            [least, most]
        } else {
            let half = 1e-6 * most.abs().max(1e-6);
            [least - half, most + half]
        };
        let label = |share: f64| {
            let value = ends[0] + share * (ends[1] - ends[0]);
            (share, significant(value, LABEL_DIGITS))
        };
        let labels = [0.0, 0.25, 0.5, 0.75, 1.0].map(label).to_vec();
        let bar = if is_signed {
            Self::diverging(labels)
        } else {
            Self::sequence(labels)
        };
        (bar, ends)
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
    /// Length of the longer side of the picture, such as [`WIDE`] (pixels).
    pub longer: f64,
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
        let [width, height] = self.sides.map(|side| self.longer * side / longest);
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
            longer: WIDE,
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
                longer: WIDE,
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
            longer: WIDE,
            counts: [180, 180],
            colours,
            bar,
        };
        let bytes = map.svg().len();
        assert!((300_000..500_000).contains(&bytes), "{bytes}");
    }

    #[test]
    fn numbers_of_both_signs_have_a_bar_about_0_and_equal_ones_a_narrow_one() {
        let (bar, ends) = ColourBar::of_values([-1.0, 4.0]);
        assert_eq!((ends, bar.labels[2].1.as_str()), ([-4.0, 4.0], "0"));
        assert_eq!(bar.labels[0].1, "-4");
        let (bar, ends) = ColourBar::of_values([2.0, 3.0]);
        assert_eq!((ends, bar.labels[1].1.as_str()), ([2.0, 3.0], "2.25"));
        for equal in [0.0, 7.0, -1e-300] {
            let (bar, [low, high]) = ColourBar::of_values([equal; 3]);
            assert!(low < high && bar.labels.len() == 5, "{equal}");
        }
        assert_eq!(ColourBar::of_values([]).1, [0.0, 1.0]);
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
