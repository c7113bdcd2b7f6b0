//! Panels above each other on axes of their own, with marks of single times: SVG in the colours of
//! the reader's light or dark theme.

mod place;

use place::PanelPlace;

pub use crate::ink::Ink;
use crate::{
    axis::Axis,
    svg::{Anchor, CHARACTER, Svg},
};

/// Width of a picture (pixels). Its text stays readable at 400 pixels.
pub const WIDTH: f64 = 680.0;

/// Size of ordinary text (pixels).
const TEXT: f64 = 15.0;

/// Space left of a panel with a scale, for the numbers and the label (pixels).
const LEFT: f64 = 84.0;

/// Space left of a panel with rows, for their names (pixels).
const LEFT_OF_ROWS: f64 = 150.0;

/// Space right of a panel (pixels).
const RIGHT: f64 = 16.0;

/// Height of a panel with a scale (pixels).
const HEIGHT: f64 = 220.0;

/// Height of a row (pixels).
const ROW: f64 = 24.0;

/// Height of a line of text (pixels).
const LINE: f64 = 21.0;

/// Mean width of a character of a paragraph in units of its size: wide and narrow ones average out.
const CHARACTER_OF_PARAGRAPH: f64 = 0.53;

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// A thick line.
    Thick,
    /// A thin line.
    Thin,
    /// A dashed line.
    Dashed,
}

/// The shape of a mark at one point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarkedPoint {
    /// A small disc.
    Disc,
    /// A diamond.
    Diamond,
    /// A ring.
    Ring,
}

/// An element of a panel, in the units of its axes. What lies outside the axes is clipped.
#[derive(Debug, Clone)]
pub enum PanelMark {
    /// A line through points.
    Line(Ink, Stroke, Vec<(f64, f64)>),
    /// A shaded part of the horizontal axis.
    Span(Ink, f64, f64),
    /// Vertical lines.
    Uprights(Ink, Stroke, Vec<f64>),
    /// Marks at points.
    Points(Ink, MarkedPoint, Vec<(f64, f64)>),
    /// Intervals in a row, from 0 at the top.
    Bars(Ink, usize, Vec<(f64, f64)>),
    /// Single times in a row, from 0 at the top.
    Ticks(Ink, usize, Vec<f64>),
    /// One time in a row, as a diamond.
    Answer(Ink, usize, f64),
}

/// The vertical axis of a panel.
#[derive(Debug, Clone)]
pub enum Vertical {
    /// A scale.
    Scale(Axis),
    /// Rows with names, from above.
    Rows(Vec<String>),
}

/// An entry of a legend.
#[derive(Debug, Clone)]
pub enum ColumnSample {
    /// A line.
    Line(Ink, Stroke),
    /// A shaded area.
    Area(Ink),
    /// A point.
    Point(Ink, MarkedPoint),
}

/// One panel.
#[derive(Debug, Clone)]
pub struct Panel {
    /// Heading.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Vertical,
    /// From back to front.
    pub marks: Vec<PanelMark>,
    /// The meaning of the marks.
    pub legend: Vec<(ColumnSample, String)>,
}

/// A picture that is written from top to bottom.
#[derive(Debug, Default)]
pub struct PanelColumn {
    body: Svg,
    height: f64,
    panels: usize,
}

impl PanelColumn {
    /// Writes a paragraph, wrapped at the width of the picture.
    pub fn paragraph(&mut self, ink: Ink, size: f64, text: &str) {
        for line in wrapped(text, (WIDTH - 32.0) / (CHARACTER_OF_PARAGRAPH * size)) {
            self.height += 1.4 * size;
            self.body.text(
                (16.0, self.height - 0.3 * size),
                Anchor::Start,
                ink,
                size,
                &line,
            );
        }
    }

    /// Leaves an empty space (pixels).
    pub fn space(&mut self, height: f64) {
        self.height += height;
    }

    /// Draws SVG elements whose origin is at the left end of the present height, and that take
    /// `height` (pixels).
    pub fn drawing(&mut self, elements: &str, height: f64) {
        self.body.raw(&format!(
            "<g transform=\"translate(0 {:.1})\">{elements}</g>",
            self.height
        ));
        self.height += height;
    }

    /// Draws a panel.
    pub fn panel(&mut self, panel: &Panel) {
        self.paragraph(Ink::Text, 17.0, &panel.title);
        self.legend(&panel.legend);
        let top = self.height + 8.0;
        let (left, height) = match &panel.y {
            Vertical::Scale(_) => (LEFT, HEIGHT),
            Vertical::Rows(rows) => (LEFT_OF_ROWS, ROW * rows.len() as f64),
        };
        let place = PanelPlace {
            left,
            right: WIDTH - RIGHT,
            top,
            bottom: top + height,
            panel,
        };
        self.axes(&place);
        self.panels += 1;
        self.body.raw(&format!(
            "<clipPath id=\"p{0}\"><rect x=\"{1:.1}\" y=\"{2:.1}\" width=\"{3:.1}\" height=\"{4:.1}\"/>\
             </clipPath><g clip-path=\"url(#p{0})\">",
            self.panels,
            place.left,
            place.top - 5.0,
            place.right - place.left,
            height + 10.0
        ));
        for mark in &panel.marks {
            place.draw(mark, &mut self.body);
        }
        self.body.raw("</g>");
        self.height = place.bottom + 52.0;
    }

    /// The whole picture.
    pub fn svg(self) -> String {
        self.body.finish((WIDTH, self.height + 8.0), false)
    }

    fn legend(&mut self, entries: &[(ColumnSample, String)]) {
        let (mut x, size) = (16.0, 0.9 * TEXT);
        self.height += if entries.is_empty() { 0.0 } else { LINE };
        for (sample, name) in entries {
            let width = 30.0 + 0.9 * CHARACTER * size * name.chars().count() as f64 + 14.0;
            if x > 16.0 && x + width > WIDTH {
                x = 16.0;
                self.height += LINE;
            }
            let y = self.height - 9.0;
            match sample {
                ColumnSample::Line(ink, stroke) => {
                    self.body
                        .line([(x, y), (x + 24.0, y)], *ink, stroke.style());
                }
                ColumnSample::Area(ink) => {
                    self.body
                        .rectangle((x, y - 6.0), (x + 24.0, y + 6.0), *ink, "area");
                }
                ColumnSample::Point(ink, point) => point.draw((x + 12.0, y), *ink, &mut self.body),
            }
            self.body
                .text((x + 30.0, y + 5.0), Anchor::Start, Ink::Quiet, size, name);
            x += width;
        }
    }

    fn axes(&mut self, place: &PanelPlace<'_>) {
        let Panel { x, y, .. } = place.panel;
        let (size, svg) = (0.87 * TEXT, &mut self.body);
        for (mark, text) in x.marks((place.right - place.left) / (CHARACTER * size)) {
            let at = place.x(mark);
            svg.line([(at, place.top), (at, place.bottom)], Ink::Quiet, "grid");
            svg.text(
                (at, place.bottom + 17.0),
                Anchor::Middle,
                Ink::Quiet,
                size,
                &text,
            );
        }
        let middle = 0.5 * (place.left + place.right);
        svg.text(
            (middle, place.bottom + 36.0),
            Anchor::Middle,
            Ink::Text,
            TEXT,
            &x.label,
        );
        match y {
            Vertical::Scale(axis) => {
                for (mark, text) in axis.marks((place.bottom - place.top) / (CHARACTER * size)) {
                    let at = place.y(mark);
                    svg.line([(place.left, at), (place.right, at)], Ink::Quiet, "grid");
                    svg.text(
                        (place.left - 6.0, at + 4.5),
                        Anchor::End,
                        Ink::Quiet,
                        size,
                        &text,
                    );
                }
                svg.upwards(
                    (18.0, 0.5 * (place.top + place.bottom)),
                    Ink::Text,
                    TEXT,
                    &axis.label,
                );
            }
            Vertical::Rows(rows) => {
                for (index, name) in rows.iter().enumerate() {
                    let at = place.top + ROW * (index as f64 + 0.5) + 5.0;
                    svg.text((place.left - 8.0, at), Anchor::End, Ink::Text, size, name);
                }
            }
        }
        svg.rectangle(
            (place.left, place.top),
            (place.right, place.bottom),
            Ink::Quiet,
            "thin",
        );
    }
}

impl Stroke {
    fn style(self) -> &'static str {
        match self {
            Self::Thick => "thick",
            Self::Thin => "thin",
            Self::Dashed => "dashed",
        }
    }
}

impl MarkedPoint {
    fn draw(self, (x, y): (f64, f64), ink: Ink, svg: &mut Svg) {
        match self {
            Self::Disc => svg.circle((x, y), 3.2, ink, "fill"),
            Self::Ring => svg.circle((x, y), 4.5, ink, "thin"),
            Self::Diamond => {
                svg.path(
                    &format!("M{x:.1} {:.1}l5.5 5.5l-5.5 5.5l-5.5 -5.5z", y - 5.5),
                    ink,
                    "fill",
                );
            }
        }
    }
}

/// Lines of at most `most` characters, broken at spaces.
fn wrapped(text: &str, most: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if ((line.chars().count() + 1 + word.chars().count()) as f64) <= most => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(y: Vertical, marks: Vec<PanelMark>) -> Panel {
        let x = Axis::new("t (time)", (0.0, 1.0));
        let legend = vec![(
            ColumnSample::Line(Ink::Blue, Stroke::Thick),
            "a & b".to_owned(),
        )];
        Panel {
            title: "one <panel>".to_owned(),
            x,
            y,
            marks,
            legend,
        }
    }

    #[test]
    fn marks_far_outside_are_clipped_and_nothing_is_not_a_number() {
        let line = PanelMark::Line(
            Ink::Blue,
            Stroke::Thin,
            vec![(-1e300, 0.0), (f64::NAN, 0.5), (0.5, 1e300)],
        );
        let points =
            PanelMark::Points(Ink::Green, MarkedPoint::Disc, vec![(2.0, 0.0), (0.5, -1e9)]);
        let axis = Axis::new("gap (length)", (-1.0, 1.0));
        let mut column = PanelColumn::default();
        column.panel(&panel(Vertical::Scale(axis), vec![line, points]));
        let svg = column.svg();
        assert!(svg.contains("one &lt;panel&gt;") && svg.contains("a &amp; b"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(svg.matches("<circle").count(), 1);
    }

    #[test]
    fn marks_closer_than_a_line_are_drawn_once() {
        let ticks = PanelMark::Ticks(
            Ink::Text,
            0,
            (0..100_000).map(|index| f64::from(index) * 1e-5).collect(),
        );
        let mut column = PanelColumn::default();
        column.panel(&panel(Vertical::Rows(vec!["row".to_owned()]), vec![ticks]));
        assert!(column.svg().len() < 20_000);
    }

    #[test]
    fn lines_are_broken_at_spaces() {
        assert_eq!(wrapped("one two three", 8.0), ["one two", "three"]);
        assert_eq!(wrapped("unbreakable", 4.0), ["unbreakable"]);
    }
}
