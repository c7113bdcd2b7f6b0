//! A picture in SVG, written element by element.

use std::fmt::Write as _;

use crate::{
    ink::{Ink, STYLE},
    page::escape,
};

/// Width of a character in units of the size of a short text, on the safe side of sans-serif.
pub(crate) const CHARACTER: f64 = 0.6;

/// Least size of text that is made smaller to fit (pixels). Smaller: it cannot be read.
const MIN_SIZE: f64 = 9.0;

/// The size at which a text fits a width, at most `size` (pixels).
pub(crate) fn fitting(text: &str, size: f64, width: f64) -> f64 {
    let natural = CHARACTER * text.chars().count().max(1) as f64;
    (width / natural).clamp(MIN_SIZE, size.max(MIN_SIZE))
}

/// Where a text begins or ends.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// The elements of a picture.
#[derive(Debug, Default)]
pub(crate) struct Svg {
    body: String,
}

impl Svg {
    /// A text with its baseline at a place.
    pub fn text(&mut self, (x, y): (f64, f64), anchor: Anchor, ink: Ink, size: f64, text: &str) {
        self.placed(
            &format!("x=\"{x:.1}\" y=\"{y:.1}\""),
            anchor,
            ink,
            size,
            text,
        );
    }

    /// A text that runs upwards, with the middle of its baseline at a place.
    pub fn upwards(&mut self, (x, y): (f64, f64), ink: Ink, size: f64, text: &str) {
        let place = format!("transform=\"translate({x:.1} {y:.1}) rotate(-90)\"");
        self.placed(&place, Anchor::Middle, ink, size, text);
    }

    fn placed(&mut self, place: &str, anchor: Anchor, ink: Ink, size: f64, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let (ink, text) = (ink.drawn("fill"), escape(text));
        let _ = writeln!(
            self.body,
            "<text {place} font-size=\"{size:.1}\"{anchor} {ink}>{text}</text>"
        );
    }

    /// A path by its data.
    pub fn path(&mut self, data: &str, ink: Ink, style: &str) {
        let _ = writeln!(self.body, "<path d=\"{data}\" {}/>", ink.drawn(style));
    }

    /// A line through points.
    pub fn line(&mut self, points: impl IntoIterator<Item = (f64, f64)>, ink: Ink, style: &str) {
        let path = through(points);
        if !path.is_empty() {
            self.path(&path, ink, style);
        }
    }

    /// The area within points.
    pub fn area(&mut self, points: impl IntoIterator<Item = (f64, f64)>, ink: Ink, style: &str) {
        let path = through(points);
        if !path.is_empty() {
            self.path(&format!("{path}Z"), ink, style);
        }
    }

    /// A rectangle from its upper left to its lower right corner.
    pub fn rectangle(&mut self, from: (f64, f64), to: (f64, f64), ink: Ink, style: &str) {
        let _ = writeln!(
            self.body,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" {}/>",
            from.0,
            from.1,
            (to.0 - from.0).max(0.0),
            (to.1 - from.1).max(0.0),
            ink.drawn(style)
        );
    }

    /// A circle.
    pub fn circle(&mut self, (x, y): (f64, f64), radius: f64, ink: Ink, style: &str) {
        let ink = ink.drawn(style);
        let _ = writeln!(
            self.body,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" {ink}/>"
        );
    }

    /// Elements that are written already.
    pub fn raw(&mut self, elements: &str) {
        self.body.push_str(elements);
        self.body.push('\n');
    }

    /// The whole picture on a ground of the theme (pixels). With a fixed size it is not drawn
    /// larger.
    pub fn finish(self, (width, height): (f64, f64), is_fixed: bool) -> String {
        let size = if is_fixed {
            format!("width=\"{width:.0}\" height=\"{height:.0}\" ")
        } else {
            String::new()
        };
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" {size}viewBox=\"0 0 {width:.0} {height:.0}\" \
             font-family=\"sans-serif\">\n{STYLE}\n<rect width=\"100%\" height=\"100%\" class=\"ground\"/>\n{}</svg>\n",
            self.body
        )
    }
}

/// The data of a path through points; what is not a number is left out.
fn through(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut path = String::new();
    for (x, y) in points
        .into_iter()
        .filter(|(x, y)| x.is_finite() && y.is_finite())
    {
        let letter = if path.is_empty() { 'M' } else { 'L' };
        let _ = write!(path, "{letter}{x:.1} {y:.1}");
    }
    path
}
