//! The marks of a panel at their places in the picture.

use std::{collections::HashSet, fmt::Write as _};

use super::{Ink, Mark, Panel, Point, ROW, Vertical};

/// Least distance of two marks in a row that are drawn one by one (pixels).
const CLOSEST: f64 = 2.0;

/// A panel in its rectangle (pixels).
pub(super) struct Place<'a> {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
    pub(super) panel: &'a Panel,
}

impl Place<'_> {
    /// Places outside the axes are moved to just outside the panel, where they are clipped.
    pub(super) fn x(&self, value: f64) -> f64 {
        let (low, high) = self.panel.x.range;
        self.left + (self.right - self.left) * ((value - low) / (high - low)).clamp(-0.5, 1.5)
    }

    pub(super) fn y(&self, value: f64) -> f64 {
        match &self.panel.y {
            Vertical::Scale(axis) => {
                let (low, high) = axis.range;
                self.bottom - (self.bottom - self.top) * ((value - low) / (high - low)).clamp(-4.0, 5.0)
            }
            Vertical::Rows(_) => self.bottom,
        }
    }

    fn row(&self, row: usize) -> f64 {
        self.top + ROW * row as f64
    }

    fn is_inside(&self, x: f64) -> bool {
        (self.panel.x.range.0..=self.panel.x.range.1).contains(&x)
    }

    pub(super) fn draw(&self, mark: &Mark, svg: &mut String) {
        match mark {
            Mark::Line(ink, stroke, points) => {
                let mut path = String::new();
                for (index, &(x, y)) in points.iter().filter(|(x, y)| !x.is_nan() && !y.is_nan()).enumerate()
                {
                    let letter = if index == 0 { 'M' } else { 'L' };
                    let _ = write!(path, "{letter}{:.1} {:.1}", self.x(x), self.y(y));
                }
                let _ = writeln!(svg, "<path d=\"{path}\" class=\"{} {}\"/>", ink.class(), stroke.class());
            }
            Mark::Span(ink, from, to) => {
                self.rectangle((*from, *to), (self.top, self.bottom), &format!("{} area", ink.class()), svg);
            }
            Mark::Uprights(ink, stroke, times) => {
                let lines = self.apart(times).fold(String::new(), |mut path, x| {
                    let _ = write!(path, "M{x:.1} {:.1}V{:.1}", self.top, self.bottom);
                    path
                });
                let _ = writeln!(svg, "<path d=\"{lines}\" class=\"{} {}\"/>", ink.class(), stroke.class());
            }
            Mark::Points(ink, point, places) => {
                // Points that cover each other are drawn once.
                let mut drawn = HashSet::new();
                for (x, y) in places.iter().filter(|(x, _)| self.is_inside(*x)) {
                    let (x, y) = (self.x(*x), self.y(*y));
                    if drawn.insert((x.round() as i32, y.round() as i32)) {
                        svg.push_str(&point.drawn((x, y), *ink));
                    }
                }
                svg.push('\n');
            }
            Mark::Bars(ink, row, bars) => {
                let (top, bottom) = (self.row(*row) + 5.0, self.row(*row) + ROW - 5.0);
                for &(from, to) in bars {
                    self.rectangle((from, to), (top, bottom), &format!("{} area", ink.class()), svg);
                }
            }
            Mark::Ticks(ink, row, times) => {
                self.ticks(*ink, (self.row(*row) + 5.0, self.row(*row) + ROW - 5.0), times, svg);
            }
            Mark::Answer(ink, row, time) if self.is_inside(*time) => {
                let middle = self.row(*row) + 0.5 * ROW;
                svg.push_str(&Point::Diamond.drawn((self.x(*time), middle), *ink));
                svg.push('\n');
            }
            Mark::Answer(..) => {}
        }
    }

    /// The places of ascending times inside the axes, without those too close to the last one.
    fn apart(&self, times: &[f64]) -> impl Iterator<Item = f64> {
        let mut last = f64::NEG_INFINITY;
        times.iter().filter(|time| self.is_inside(**time)).map(|time| self.x(*time)).filter(move |x| {
            let is_apart = *x >= last + CLOSEST;
            last = if is_apart { *x } else { last };
            is_apart
        })
    }

    fn ticks(&self, ink: Ink, (top, bottom): (f64, f64), times: &[f64], svg: &mut String) {
        let mut sorted = times.to_vec();
        sorted.sort_by(f64::total_cmp);
        let path = self.apart(&sorted).fold(String::new(), |mut path, x| {
            let _ = write!(path, "M{x:.1} {top:.1}V{bottom:.1}");
            path
        });
        let _ = writeln!(svg, "<path d=\"{path}\" class=\"{} thin\"/>", ink.class());
    }

    fn rectangle(&self, (from, to): (f64, f64), (top, bottom): (f64, f64), class: &str, svg: &mut String) {
        let (from, to) = (self.x(from), self.x(to));
        if to > from {
            let _ = writeln!(
                svg,
                "<rect x=\"{from:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" class=\"{class}\"/>",
                to - from,
                bottom - top
            );
        }
    }
}
