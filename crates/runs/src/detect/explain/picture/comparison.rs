//! The panels that compare the detectors: where they look, and how fast their errors fall.

use carom::engine::DetectorName;
use carom_detection::{Parts, Phase, SearchStep, SearchWindow, Touch};
use carom_report::{
    axis::Axis,
    panels::{ColumnSample, Ink, MarkedPoint, Panel, PanelMark, Stroke, Vertical},
};

use super::{Subject, extent, time_axis, widened};
use crate::detect::cells;

/// Most evaluations of one detector in the panel of errors, the last ones.
const MAX_ERRORS: usize = 150;

impl Subject<'_> {
    /// What each detector looks at, a row a detector, and a row for each pair for the exact
    /// one.
    pub(super) fn rows(&self, view: SearchWindow, pairs: &[Touch]) -> Panel {
        let (mut rows, mut marks) = (Vec::new(), Vec::new());
        if let Some(window) = self.window {
            marks.push(PanelMark::Span(Ink::Purple, window.begin, window.end));
        }
        for &pair in pairs {
            marks.extend(self.pair_marks(pair, rows.len()));
            let [a, b] = cells(pair);
            rows.push(format!("exact, {a} and {b}"));
        }
        for course in &self.courses[1..] {
            let row = rows.len();
            let window = course.window.map(|window| (window.begin, window.end));
            if course.detector == DetectorName::BoundingCircles {
                marks.push(PanelMark::Bars(
                    Ink::Purple,
                    row,
                    window.into_iter().collect(),
                ));
            }
            let times = if course.detector == DetectorName::FixedStep {
                course.segments.iter().map(|segment| segment.end).collect()
            } else {
                let evaluated = course
                    .steps
                    .iter()
                    .filter(|step| step.phase != Phase::ClosedForm);
                evaluated.map(|step| step.time).collect()
            };
            marks.push(PanelMark::Ticks(Ink::Blue, row, times));
            if let Some(contact) = course.contact() {
                marks.push(PanelMark::Answer(Ink::Vermillion, row, contact.time));
            }
            rows.push(course.name().to_owned());
        }
        let legend = vec![
            (ColumnSample::Area(Ink::Green), "certified free".to_owned()),
            (
                ColumnSample::Line(Ink::Blue, Stroke::Thin),
                "evaluation".to_owned(),
            ),
            (ColumnSample::Area(Ink::Purple), "window".to_owned()),
            (
                ColumnSample::Point(Ink::Vermillion, MarkedPoint::Diamond),
                "contact found".to_owned(),
            ),
        ];
        Panel {
            title: "Where each detector looks, and what it finds".to_owned(),
            x: time_axis((view.begin, view.end)),
            y: Vertical::Rows(rows),
            marks,
            legend,
        }
    }

    /// What the exact detector looks at for a pair, and what it finds, in this row.
    fn pair_marks(&self, pair: Touch, row: usize) -> Vec<PanelMark> {
        let of_pair: Vec<&SearchStep> = self.courses[0]
            .steps
            .iter()
            .filter(|step| concern(&step.parts, pair))
            .collect();
        let times = of_pair.iter().map(|step| step.time).collect();
        let mut marks = vec![
            PanelMark::Bars(Ink::Green, row, self.certified(&of_pair)),
            PanelMark::Ticks(Ink::Green, row, times),
        ];
        if let Some((time, _)) = self.contact.filter(|contact| contact.1 == pair) {
            marks.push(PanelMark::Answer(Ink::Vermillion, row, time));
        }
        marks
    }

    /// The intervals for which a pair is certified free, in order and disjoint: before the window,
    /// and from each evaluation on.
    fn certified(&self, steps: &[&SearchStep]) -> Vec<(f64, f64)> {
        let mut bars: Vec<(f64, f64)> = self
            .window
            .map(|window| (0.0, window.begin))
            .into_iter()
            .collect();
        let mut free: Vec<(f64, f64)> = steps
            .iter()
            .filter_map(|step| Some((step.time, step.free_until?)))
            .collect();
        free.sort_by(|one, other| one.0.total_cmp(&other.0));
        for (from, to) in free {
            match bars.last_mut() {
                Some(last) if from <= last.1 => last.1 = last.1.max(to),
                _ => bars.push((from, to)),
            }
        }
        bars
    }

    /// How far the evaluations of the pair that touches are from the contact, one after another.
    pub(super) fn convergence(&self, contact: f64, pair: Touch) -> Panel {
        let (mut marks, mut legend) = (Vec::new(), Vec::new());
        let mut longest = 2;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (course, ink, point) in [
            (&self.courses[2], Ink::Orange, MarkedPoint::Ring),
            (&self.courses[1], Ink::Purple, MarkedPoint::Disc),
            (&self.courses[0], Ink::Green, MarkedPoint::Diamond),
        ] {
            let of_pair = course
                .steps
                .iter()
                .filter(|step| step.parts == Parts::Pair(pair));
            // An evaluation of exact ends at a later time than its own.
            let error = |step: &SearchStep| (step.free_until.unwrap_or(step.time) - contact).abs();
            let digits =
                |step: &SearchStep| error(step).max(0.5 * f64::EPSILON * contact.abs()).log10();
            let all: Vec<f64> = of_pair
                .map(digits)
                .filter(|digits| digits.is_finite())
                .collect();
            let last = &all[all.len().saturating_sub(MAX_ERRORS)..];
            let points: Vec<(f64, f64)> = (1..).map(f64::from).zip(last.iter().copied()).collect();
            longest = longest.max(points.len());
            let range = extent(last.iter().copied());
            (low, high) = (low.min(range.0), high.max(range.1));
            marks.push(PanelMark::Line(ink, Stroke::Thin, points.clone()));
            marks.push(PanelMark::Points(ink, point, points));
            legend.push((ColumnSample::Point(ink, point), course.name().to_owned()));
        }
        let (low, high) = if low < high {
            (low, high)
        } else {
            (-17.0, 0.0)
        };
        let label = "log₁₀ of the error (time)".to_owned();
        Panel {
            title: format!(
                "Error of the contact time, evaluation by evaluation of the {} that touch",
                match pair {
                    Touch::Atoms(..) => "atoms",
                    _ => "parts",
                }
            ),
            x: Axis::new("evaluation", (0.0, longest as f64 + 1.0)),
            y: Vertical::Scale(Axis::new(label, widened((low, high), 0.06))),
            marks,
            legend,
        }
    }
}

/// Whether a step concerns a pair.
fn concern(parts: &Parts, pair: Touch) -> bool {
    match pair {
        Touch::Atoms(a, b) => parts.contain(a, b),
        _ => *parts == Parts::Pair(pair),
    }
}
