//! The marks of a panel at their places in the picture.

use std::{collections::HashSet, fmt::Write as _};

use super::{Ink, MarkedPoint, Panel, PanelMark, ROW, Vertical};
use crate::svg::Svg;

/// Least distance of two marks in a row that are drawn one by one (pixels).
const MIN_MARK_DISTANCE: f64 = 2.0;

/// A panel in its rectangle (pixels).
pub(super) struct PanelPlace<'a> {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
    pub(super) panel: &'a Panel,
}

impl PanelPlace<'_> {
    /// Places outside the axes are moved to just outside the panel, where they are clipped.
    pub(super) fn x(&self, value: f64) -> f64 {
        self.left + (self.right - self.left) * self.panel.x.share(value).clamp(-0.5, 1.5)
    }

    pub(super) fn y(&self, value: f64) -> f64 {
        match &self.panel.y {
            Vertical::Scale(axis) => {
                self.bottom - (self.bottom - self.top) * axis.share(value).clamp(-4.0, 5.0)
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

    pub(super) fn draw(&self, mark: &PanelMark, svg: &mut Svg) {
        match mark {
            PanelMark::Line(ink, stroke, points) => {
                let points = points.iter().filter(|(x, y)| !x.is_nan() && !y.is_nan());
                svg.line(
                    points.map(|&(x, y)| (self.x(x), self.y(y))),
                    *ink,
                    stroke.style(),
                );
            }
            PanelMark::Span(ink, from, to) => {
                self.rectangle((*from, *to), (self.top, self.bottom), *ink, svg);
            }
            PanelMark::Uprights(ink, stroke, times) => {
                let lines = self.apart(times).fold(String::new(), |mut path, x| {
                    let _ = write!(path, "M{x:.1} {:.1}V{:.1}", self.top, self.bottom);
                    path
                });
                svg.path(&lines, *ink, stroke.style());
            }
            PanelMark::Points(ink, point, places) => {
                // Points that cover each other are drawn once.
                let mut drawn = HashSet::new();
                for (x, y) in places.iter().filter(|(x, _)| self.is_inside(*x)) {
                    let (x, y) = (self.x(*x), self.y(*y));
                    if drawn.insert((x.round() as i32, y.round() as i32)) {
                        point.draw((x, y), *ink, svg);
                    }
                }
            }
            PanelMark::Bars(ink, row, bars) => {
                let (top, bottom) = (self.row(*row) + 5.0, self.row(*row) + ROW - 5.0);
                for &(from, to) in bars {
                    self.rectangle((from, to), (top, bottom), *ink, svg);
                }
            }
            PanelMark::Ticks(ink, row, times) => {
                self.ticks(
                    *ink,
                    (self.row(*row) + 5.0, self.row(*row) + ROW - 5.0),
                    times,
                    svg,
                );
            }
            PanelMark::Answer(ink, row, time) if self.is_inside(*time) => {
                let middle = self.row(*row) + 0.5 * ROW;
                MarkedPoint::Diamond.draw((self.x(*time), middle), *ink, svg);
            }
            PanelMark::Answer(..) => {}
        }
    }

    /// The places of ascending times inside the axes, without those too close to the last one.
    fn apart(&self, times: &[f64]) -> impl Iterator<Item = f64> {
        let mut last = f64::NEG_INFINITY;
        times
            .iter()
            .filter(|time| self.is_inside(**time))
            .map(|time| self.x(*time))
            .filter(move |x| {
                let is_apart = *x >= last + MIN_MARK_DISTANCE;
                last = if is_apart { *x } else { last };
                is_apart
            })
    }

    fn ticks(&self, ink: Ink, (top, bottom): (f64, f64), times: &[f64], svg: &mut Svg) {
        let mut sorted = times.to_vec();
        sorted.sort_by(f64::total_cmp);
        let path = self.apart(&sorted).fold(String::new(), |mut path, x| {
            let _ = write!(path, "M{x:.1} {top:.1}V{bottom:.1}");
            path
        });
        svg.path(&path, ink, "thin");
    }

    fn rectangle(
        &self,
        (from, to): (f64, f64),
        (top, bottom): (f64, f64),
        ink: Ink,
        svg: &mut Svg,
    ) {
        let (from, to) = (self.x(from), self.x(to));
        if to > from {
            svg.rectangle((from, top), (to, bottom), ink, "area");
        }
    }
}
