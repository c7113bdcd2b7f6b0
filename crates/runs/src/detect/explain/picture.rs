//! The panels of the picture: the gap over time, and what each detector evaluates and proves.

mod comparison;

use std::fmt::Write as _;

use carom_detection::{MAX_RECORDED, Part, Parts, Phase, SearchStep, SearchWindow, Touch};
use carom_geometry::{Contour, Molecule};
use carom_report::{
    axis::Axis,
    panels::{ColumnSample, Ink, MarkedPoint, Panel, PanelColumn, PanelMark, Stroke, Vertical},
    pose_picture::{self, DrawnPose},
};
use carom_tables::significant;

use super::{
    Course,
    curves::{Curves, Gaps},
};
use crate::encounters::EncounterRecord;

/// Most pairs with a curve and a row of their own.
const MAX_PAIRS: usize = 5;

/// A window of more crops than this is drawn in part.
const MAX_CROPS: f64 = 16.0;

/// Crops drawn before and after a contact in a window that is drawn in part.
const CROPS_AROUND: [f64; 2] = [8.0, 3.0];

/// More turns than this are not drawn as a curve of the atoms over the whole time.
const MAX_TURNS: f64 = 40.0;

/// Empty part of the horizontal axis on either side of the window, as a share of its length.
const MARGIN: f64 = 0.04;

/// The subject of a picture.
struct Subject<'a> {
    encounter: &'a EncounterRecord,
    courses: &'a [Course],
    gaps: Gaps<'a>,
    /// The time in which the bounding circles overlap.
    window: Option<SearchWindow>,
    contact: Option<(f64, Touch)>,
    /// The contours of the molecules that have straight edges.
    contours: [Vec<Contour>; 2],
}

/// Draws the searches of one pair.
pub(super) fn svg(encounter: &EncounterRecord, courses: &[Course]) -> String {
    let exact = &courses[0];
    let contact = exact.contact().and_then(|contact| match contact.touch {
        Touch::BoundingCircles
        | Touch::EdgeOfA {
            part: Part::BoundingCircle,
            ..
        }
        | Touch::EdgeOfB {
            part: Part::BoundingCircle,
            ..
        } => None,
        touch => Some((contact.time, touch)),
    });
    let gaps = Gaps::new(encounter);
    let subject = Subject {
        encounter,
        courses,
        gaps,
        window: exact.window,
        contact,
        contours: encounter.molecules.each_ref().map(drawn_contours),
    };
    let mut column = PanelColumn::default();
    let title = format!(
        "First contact of the pair {}/{}",
        encounter.class, encounter.id
    );
    column.paragraph(Ink::Text, 21.0, &title);
    for course in courses {
        column.paragraph(Ink::Quiet, 13.0, &course.sentence());
    }
    column.space(8.0);
    column.drawing(&pose_picture::row(&subject.poses()), pose_picture::HEIGHT);
    let caption = "The molecules seen from the centre of A. The arrow is the direction of B relative to A. \
                   Dashed: the bounding circles, within which a molecule stays as it turns.";
    column.paragraph(Ink::Quiet, 14.0, caption);
    column.space(10.0);
    column.panel(&subject.whole_time());
    if let Some(window) = subject.window {
        let view = subject.view(window);
        let curves = subject.gaps.curves(view.begin, view.end, MAX_PAIRS);
        let pairs = subject.pairs(&curves);
        column.panel(&subject.golden_secant(view, &curves, &pairs));
        column.panel(&subject.exact(subject.view_of_exact(view, window), &pairs));
        column.panel(&subject.rows(view, &pairs));
        if let Some((time, pair)) = subject.contact {
            column.panel(&subject.convergence(time, pair));
        }
        column.paragraph(Ink::Quiet, 14.0, &subject.caption(view, window));
    } else {
        let caption =
            "The bounding circles never overlap: skimming ends the search of every detector.";
        column.paragraph(Ink::Quiet, 14.0, caption);
    }
    column.svg()
}

impl Subject<'_> {
    /// The molecules at the start, where the window begins, and at the contact or at their closest.
    fn poses(&self) -> Vec<DrawnPose> {
        let mut moments = vec![("start".to_owned(), 0.0)];
        match self.window {
            Some(window) => moments.push(("begin of the window".to_owned(), window.begin)),
            None => moments.push(("centres closest".to_owned(), self.closest())),
        }
        match (self.contact, self.window) {
            (Some((time, _)), _) => moments.push(("contact".to_owned(), time)),
            (None, Some(window)) => {
                moments.push((
                    "atoms closest, no contact".to_owned(),
                    self.atoms_closest(window),
                ));
            }
            (None, None) => {}
        }
        let radii = self
            .encounter
            .molecules
            .each_ref()
            .map(Molecule::bounding_radius);
        let pose = |(what, time): (String, f64)| DrawnPose {
            label: [what, format!("t = {}", significant(time, 6))],
            atoms: self.discs(time),
            contours: self.contours.clone(),
            rotations: self.gaps.rotations(time),
            circles: [
                (glam::DVec2::ZERO, radii[0]),
                (self.gaps.separation(time), radii[1]),
            ],
            velocity: self.encounter.motions[1].velocity - self.encounter.motions[0].velocity,
        };
        moments.into_iter().map(pose).collect()
    }

    /// The atoms of both molecules at a time; none of one that is drawn by its contours.
    fn discs(&self, time: f64) -> [Vec<pose_picture::Disc>; 2] {
        let mut atoms = self.gaps.atoms(time);
        for (atoms, contours) in atoms.iter_mut().zip(&self.contours) {
            if !contours.is_empty() {
                atoms.clear();
            }
        }
        atoms
    }

    /// "atoms", or "atoms and edges" if a molecule has edges.
    fn parts(&self) -> &'static str {
        let has_edges = |molecule: &Molecule| !molecule.is_of_discs();
        if self.encounter.molecules.iter().any(has_edges) {
            "atoms and edges"
        } else {
            "atoms"
        }
    }

    /// The time at which the centres are closest.
    fn closest(&self) -> f64 {
        let motion = self.encounter.pair_at(0.0);
        let time = -motion.separation.dot(motion.velocity) / motion.velocity.length_squared();
        if time.is_finite() { time.max(0.0) } else { 0.0 }
    }

    /// The time in a window at which the atoms are closest, to the resolution of the curves.
    fn atoms_closest(&self, window: SearchWindow) -> f64 {
        let curves = self.gaps.curves(window.begin, window.end, 0);
        let least = curves
            .times
            .iter()
            .zip(&curves.least)
            .min_by(|one, other| one.1.total_cmp(other.1));
        least.map_or(window.begin, |(time, _)| *time)
    }

    /// Skimming: the gap of the bounding circles, and the window in which it is negative.
    fn whole_time(&self) -> Panel {
        let end = self
            .window
            .map_or_else(|| 2.0 * self.closest(), |window| 1.05 * window.end);
        let end = if end > 0.0 { end } else { 1.0 };
        let times = self.gaps.times(0.0, end);
        let circles: Vec<(f64, f64)> = times
            .iter()
            .map(|&time| (time, self.gaps.of_circles(time)))
            .collect();
        let mut marks = Vec::new();
        let mut legend = vec![(
            ColumnSample::Line(Ink::Purple, Stroke::Dashed),
            "gap of the bounding circles".to_owned(),
        )];
        let mut range = extent(circles.iter().map(|point| point.1));
        if let Some(window) = self.window {
            marks.push(PanelMark::Span(Ink::Purple, window.begin, window.end));
            legend.push((
                ColumnSample::Area(Ink::Purple),
                "window: the circles overlap".to_owned(),
            ));
        }
        if self.gaps.turns(0.0, end) <= MAX_TURNS {
            let curves = self.gaps.curves(0.0, end, 0);
            let least: Vec<(f64, f64)> = curves.times.iter().copied().zip(curves.least).collect();
            let atoms = extent(least.iter().map(|point| point.1));
            range = (range.0.min(atoms.0), range.1.max(atoms.1));
            marks.extend(self.met(Stroke::Thick, least));
            legend.push((
                ColumnSample::Line(Ink::Blue, Stroke::Thick),
                format!("least gap of the {}", self.parts()),
            ));
        }
        marks.push(PanelMark::Line(Ink::Purple, Stroke::Dashed, circles));
        self.finish(&mut marks, &mut legend, (0.0, end));
        Panel {
            title: "Skimming: when can the molecules touch at all?".to_owned(),
            x: time_axis((0.0, end)),
            y: gap_axis(widened((range.0.min(0.0), range.1.max(0.0)), 0.06)),
            marks,
            legend,
        }
    }

    /// The golden-section and secant evaluations.
    fn golden_secant(&self, view: SearchWindow, curves: &Curves, pairs: &[Touch]) -> Panel {
        let course = &self.courses[1];
        let (mut marks, mut legend) = self.gap_curves(view, curves, pairs);
        let mut borders: Vec<f64> = course
            .segments
            .iter()
            .map(|segment| segment.begin)
            .collect();
        borders.extend(course.segments.last().map(|segment| segment.end));
        marks.push(PanelMark::Uprights(Ink::Orange, Stroke::Thin, borders));
        legend.push((
            ColumnSample::Line(Ink::Orange, Stroke::Thin),
            "crop".to_owned(),
        ));
        for (ink, point, name, phases) in [
            (
                Ink::Text,
                MarkedPoint::Ring,
                "end of a crop",
                &[Phase::SegmentEnd][..],
            ),
            (
                Ink::Green,
                MarkedPoint::Disc,
                "golden section",
                &[Phase::GoldenMinimum, Phase::GoldenMaximum],
            ),
            (
                Ink::Purple,
                MarkedPoint::Diamond,
                "secant",
                &[Phase::Secant],
            ),
        ] {
            let places = self.evaluations(course, pairs, |step| phases.contains(&step.phase));
            if !places.is_empty() {
                legend.push((ColumnSample::Point(ink, point), name.to_owned()));
                marks.push(PanelMark::Points(ink, point, places));
            }
        }
        self.finish(&mut marks, &mut legend, (view.begin, view.end));
        Panel {
            title: "golden-secant: crop, find the minimum, find the zero before it".to_owned(),
            x: time_axis((view.begin, view.end)),
            y: gap_axis(gap_range(curves)),
            marks,
            legend,
        }
    }

    /// The certified steps as a staircase: from each evaluation at its height to the time up to
    /// which it certifies.
    fn exact(&self, view: SearchWindow, pairs: &[Touch]) -> Panel {
        let course = &self.courses[0];
        let curves = self.gaps.curves(view.begin, view.end, 0);
        let (mut marks, mut legend) = self.gap_curves(view, &curves, pairs);
        for (ink, stroke, name, phase) in [
            (
                Ink::Orange,
                Stroke::Thin,
                "step of all pairs at once",
                Phase::Shared,
            ),
            (Ink::Green, Stroke::Thick, "step of one pair", Phase::Single),
            (Ink::Green, Stroke::Thick, "closed form", Phase::ClosedForm),
        ] {
            let is_drawn = |step: &SearchStep| step.phase == phase;
            let places = self.evaluations(course, pairs, is_drawn);
            if places.is_empty() {
                continue;
            }
            let drawn = steps(course, pairs).filter(|(_, step)| is_drawn(step));
            for ((_, step), &(time, gap)) in drawn.zip(&places) {
                let until = step
                    .free_until
                    .unwrap_or(time)
                    .min(view.end + (view.end - view.begin));
                marks.push(PanelMark::Line(
                    ink,
                    stroke,
                    vec![(time, gap), (until, gap)],
                ));
            }
            marks.push(PanelMark::Points(ink, MarkedPoint::Disc, places));
            legend.push((ColumnSample::Line(ink, stroke), name.to_owned()));
        }
        self.finish(&mut marks, &mut legend, (view.begin, view.end));
        Panel {
            title: "exact: each evaluation (dot) proves a step free of contacts (line)".to_owned(),
            x: time_axis((view.begin, view.end)),
            y: gap_axis(gap_range(&curves)),
            marks,
            legend,
        }
    }

    fn caption(&self, view: SearchWindow, window: SearchWindow) -> String {
        let fixed = &self.courses[2];
        let mut text = format!(
            "Numbers of {} count from 0 in the order of the file. In a row of exact, lines are evaluations, \
             and the bar is the time for which they prove the pair free: all time up to the contact.",
            self.parts()
        );
        if let Some(step) = fixed
            .segments
            .iter()
            .rev()
            .find(|segment| segment.end > segment.begin)
        {
            let step = significant(step.end - step.begin, 6);
            let _ = write!(
                text,
                " fixed-step tests for overlap every {step}, {} times.",
                fixed.segments.len()
            );
        }
        if self
            .courses
            .iter()
            .any(|course| course.steps.len() == MAX_RECORDED)
        {
            let _ = write!(
                text,
                " Only the last {MAX_RECORDED} evaluations of a detector are drawn."
            );
        }
        if view.end < window.end || view.begin > window.begin {
            let _ = write!(
                text,
                " Of the window, from {} to {}, the lower panels show a part.",
                significant(window.begin, 6),
                significant(window.end, 6)
            );
        }
        text
    }

    /// The part of the time axis that the lower panels show: the window, or the crops around the
    /// contact.
    fn view(&self, window: SearchWindow) -> SearchWindow {
        let length = window.end - window.begin;
        let crop = self.courses[1]
            .segments
            .first()
            .map_or(length, |crop| crop.end - crop.begin);
        let (begin, end) = match self.contact {
            _ if length <= MAX_CROPS * crop => (window.begin, window.end),
            Some((time, _)) => (time - CROPS_AROUND[0] * crop, time + CROPS_AROUND[1] * crop),
            None => (window.begin, window.begin + MAX_CROPS * crop),
        };
        let (begin, end) = (begin.max(window.begin), end.min(window.end));
        let (begin, end) = widened((begin, end), MARGIN);
        // A window of length 0, where circles only touch.
        let least = 1e-9 * end.abs().max(f64::MIN_POSITIVE);
        SearchWindow {
            begin: begin.max(0.0),
            end: end.max(begin + least),
        }
    }

    /// The part of the time axis of the exact detector: from the start for the closed form, and
    /// otherwise up to a little after the contact.
    fn view_of_exact(&self, view: SearchWindow, window: SearchWindow) -> SearchWindow {
        let is_closed_form = self.courses[0]
            .steps
            .iter()
            .any(|step| step.phase == Phase::ClosedForm);
        let begin = if is_closed_form {
            0.0
        } else {
            view.begin.max(window.begin)
        };
        let Some((end, _)) = self.contact.filter(|contact| contact.0 > begin) else {
            return SearchWindow {
                begin: begin.min(view.begin),
                ..view
            };
        };
        let length = end - begin;
        SearchWindow {
            begin: (begin - 0.06 * length).max(0.0),
            end: end + 0.25 * length,
        }
    }

    /// The pairs that are drawn: the one that touches, and the nearest ones.
    fn pairs(&self, curves: &Curves) -> Vec<Touch> {
        let mut pairs: Vec<Touch> = self.contact.map(|contact| contact.1).into_iter().collect();
        for (pair, _) in &curves.nearest {
            if pairs.len() < MAX_PAIRS && !pairs.contains(pair) {
                pairs.push(*pair);
            }
        }
        pairs
    }

    /// Time and gap of the evaluations of the pairs.
    fn evaluations(
        &self,
        course: &Course,
        pairs: &[Touch],
        is_drawn: impl Fn(&SearchStep) -> bool,
    ) -> Vec<(f64, f64)> {
        let steps = steps(course, pairs).filter(|(_, step)| is_drawn(step));
        steps
            .map(|(pair, step)| (step.time, self.gaps.of_pair(pair, step.time)))
            .collect()
    }

    /// The least gap and the gaps of the pairs.
    fn gap_curves(
        &self,
        view: SearchWindow,
        curves: &Curves,
        pairs: &[Touch],
    ) -> (Vec<PanelMark>, Vec<(ColumnSample, String)>) {
        let mut marks = Vec::new();
        if let Some(window) = self.window {
            marks.push(PanelMark::Span(Ink::Purple, window.begin, window.end));
        }
        marks.push(PanelMark::Line(
            Ink::Text,
            Stroke::Thin,
            vec![(view.begin, 0.0), (view.end, 0.0)],
        ));
        if pairs.len() > 1 {
            for &pair in pairs {
                let points = curves
                    .times
                    .iter()
                    .map(|&time| (time, self.gaps.of_pair(pair, time)));
                marks.push(PanelMark::Line(Ink::Quiet, Stroke::Thin, points.collect()));
            }
        }
        let least = curves
            .times
            .iter()
            .copied()
            .zip(curves.least.iter().copied())
            .collect();
        marks.extend(self.met(Stroke::Thick, least));
        let mut legend = vec![(
            ColumnSample::Line(Ink::Blue, Stroke::Thick),
            format!("least gap of the {}", self.parts()),
        )];
        if pairs.len() > 1 {
            let all = self.gaps.pairs().len();
            let name = match self.parts() {
                "atoms" => format!("{} of {all} atom pairs", pairs.len()),
                parts => format!("{} of {all} pairs of {parts}", pairs.len()),
            };
            legend.push((ColumnSample::Line(Ink::Quiet, Stroke::Thin), name));
        }
        (marks, legend)
    }

    /// A curve, and its continuation after the contact, where the molecules would overlap, dashed.
    fn met(&self, stroke: Stroke, points: Vec<(f64, f64)>) -> Vec<PanelMark> {
        let Some((time, _)) = self.contact else {
            return vec![PanelMark::Line(Ink::Blue, stroke, points)];
        };
        let (mut before, mut after): (Vec<_>, Vec<_>) =
            points.into_iter().partition(|point| point.0 < time);
        before.push((time, 0.0));
        after.insert(0, (time, 0.0));
        vec![
            PanelMark::Line(Ink::Blue, Stroke::Dashed, after),
            PanelMark::Line(Ink::Blue, stroke, before),
        ]
    }

    /// Marks the contact.
    fn finish(
        &self,
        marks: &mut Vec<PanelMark>,
        legend: &mut Vec<(ColumnSample, String)>,
        (low, high): (f64, f64),
    ) {
        if let Some((time, _)) = self
            .contact
            .filter(|contact| (low..=high).contains(&contact.0))
        {
            marks.push(PanelMark::Uprights(
                Ink::Vermillion,
                Stroke::Dashed,
                vec![time],
            ));
            marks.push(PanelMark::Points(
                Ink::Vermillion,
                MarkedPoint::Diamond,
                vec![(time, 0.0)],
            ));
            legend.push((
                ColumnSample::Point(Ink::Vermillion, MarkedPoint::Diamond),
                "contact".to_owned(),
            ));
        }
    }
}

/// The range of the gap: all of the least gap, and as much of the pairs as is useful.
fn gap_range(curves: &Curves) -> (f64, f64) {
    let (low, high) = extent(curves.least.iter().copied());
    let (low, high) = (low.min(0.0), high.max(0.0));
    widened((low, high.max(-0.2 * low) * 1.3), 0.06)
}

/// The steps of a search that concern one of the pairs, with the pair.
fn steps<'a>(
    course: &'a Course,
    pairs: &'a [Touch],
) -> impl Iterator<Item = (Touch, &'a SearchStep)> {
    let pair_of = |step: &SearchStep| match step.parts {
        Parts::Pair(touch) if pairs.contains(&touch) => Some(touch),
        _ => None,
    };
    course
        .steps
        .iter()
        .filter_map(move |step| Some((pair_of(step)?, step)))
}

/// The contours of a molecule with edges; none of a union of discs.
fn drawn_contours(molecule: &Molecule) -> Vec<Contour> {
    if molecule.is_of_discs() {
        return Vec::new();
    }
    molecule.visible_contours()
}

fn time_axis(range: (f64, f64)) -> Axis {
    Axis::new("t (time from the start)", range)
}

fn gap_axis(range: (f64, f64)) -> Vertical {
    Vertical::Scale(Axis::new("gap (length)", range))
}

/// Least and largest of some numbers.
fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}

/// A range with `share` of its length more on either side; never empty.
fn widened((low, high): (f64, f64), share: f64) -> (f64, f64) {
    let span = high - low;
    let room = if span > 0.0 {
        share * span
    } else {
        low.abs().max(f64::MIN_POSITIVE) * 1e-9
    };
    (low - room, high + room)
}
