//! The record of one search: at which times a detector evaluated the gap, and what it proved there.

use std::collections::VecDeque;

use crate::{Answer, SearchWindow, Touch};

/// The most steps, and the most segments, that a [`Trace`] holds: some 10⁸ bytes. Smaller: the
/// search of a fast rotor by [`GoldenSecant`](crate::GoldenSecant) loses its beginning. Larger:
/// more memory.
pub const MAX_RECORDED: usize = 1 << 20;

/// The course of one search, with its answer.
///
/// ```
/// use carom_detection::{Detection, Exact, Parts, Touch};
/// use carom_geometry::{Molecule, Shape};
/// use carom_kinematics::RelativeMotion;
/// use glam::DVec2;
///
/// let tee = Molecule::named(Shape::Tee, 1.0, 1.0)?;
/// let disc = Molecule::disc(1.0, 1.0)?;
/// let pair = RelativeMotion {
///     angular_velocity: [0.5, 0.0],
///     ..RelativeMotion::exactly(DVec2::new(12.0, 0.0), DVec2::new(-1.0, 0.0))
/// };
/// let trace = Exact::default().trace(tee.outline(), disc.outline(), &pair, 100.0);
/// let contact = trace.answer.outcome.contact().expect("they meet");
/// // The last step of the atoms that touch ends at the time of the contact.
/// let last = trace.steps.iter().rfind(|step| step.parts == Parts::Pair(contact.touch)).unwrap();
/// assert_eq!(last.free_until, Some(contact.time));
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// The answer, equal to that of [`Detection::first_contact`](crate::Detection::first_contact)
    /// to the bit.
    pub answer: Answer,
    /// The time in which the bodies are within reach of each other; `None` if they never are, or if
    /// the detector does not search.
    pub window: Option<SearchWindow>,
    /// The crops of [`GoldenSecant`](crate::GoldenSecant), or the steps between the overlap tests
    /// of [`FixedStep`](crate::FixedStep), in the order of the search. The last
    /// [`MAX_RECORDED`] are kept.
    pub segments: Vec<SearchWindow>,
    /// The evaluations in the order of the search. The last [`MAX_RECORDED`] are kept.
    pub steps: Vec<SearchStep>,
}

/// One evaluation, or one conclusion without an evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchStep {
    /// The part of the method.
    pub phase: Phase,
    /// What was evaluated.
    pub parts: Parts,
    /// The time of the evaluation (from now).
    pub time: f64,
    /// The parts are certified free from `time` up to this time, which can be infinite, or the time
    /// of their contact. `None` if the step proves nothing.
    pub free_until: Option<f64>,
}

/// The parts of two bodies that a step concerns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Parts {
    /// One part of each body.
    Pair(Touch),
    /// Circles that hold these atoms of A and of B, by index.
    Circles([Vec<u32>; 2]),
}

impl Parts {
    /// Whether the step concerns the atoms `a` of A and `b` of B.
    pub fn contain(&self, a: u32, b: u32) -> bool {
        match self {
            Self::Pair(touch) => *touch == Touch::Atoms(a, b),
            Self::Circles([of_a, of_b]) => of_a.contains(&a) && of_b.contains(&b),
        }
    }
}

/// The parts of the methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// [`Exact`](crate::Exact): the bodies are too far apart for a contact of these parts.
    OutOfReach,
    /// [`Exact`](crate::Exact): a step of two circles of the trees.
    Circles,
    /// [`Exact`](crate::Exact): a step of all atom pairs from one placement.
    Shared,
    /// [`Exact`](crate::Exact): a step of one pair of parts.
    Single,
    /// [`Exact`](crate::Exact): the return of a pair that has just separated.
    Recontact,
    /// [`Exact`](crate::Exact), [`BoundingCircles`](crate::BoundingCircles): the closed form of two
    /// discs, or of a disc and a face.
    ClosedForm,
    /// [`GoldenSecant`](crate::GoldenSecant): an end of a segment.
    SegmentEnd,
    /// [`GoldenSecant`](crate::GoldenSecant): golden section for the largest gap.
    GoldenMaximum,
    /// [`GoldenSecant`](crate::GoldenSecant): golden section for the smallest gap.
    GoldenMinimum,
    /// [`GoldenSecant`](crate::GoldenSecant): an iterate of the secant method.
    Secant,
    /// [`FixedStep`](crate::FixedStep): bisection of the step that ends with an overlap.
    Bisection,
}

/// Receives the steps of a search. All calls are compiled away for `()`, which records nothing.
pub(crate) trait Recorder {
    /// Whether anything is recorded.
    const RECORDS: bool;

    /// Sets the parts of the steps that follow.
    fn concerns(&mut self, parts: impl FnOnce() -> Parts);

    /// Records a step.
    fn step(&mut self, phase: Phase, time: f64, free_until: Option<f64>);

    /// Records the window of a search.
    fn window(&mut self, window: SearchWindow);

    /// Records a segment.
    fn segment(&mut self, segment: SearchWindow);
}

impl Recorder for () {
    const RECORDS: bool = false;

    #[inline(always)]
    fn concerns(&mut self, _: impl FnOnce() -> Parts) {}

    #[inline(always)]
    fn step(&mut self, _: Phase, _: f64, _: Option<f64>) {}

    #[inline(always)]
    fn window(&mut self, _: SearchWindow) {}

    #[inline(always)]
    fn segment(&mut self, _: SearchWindow) {}
}

/// The recorder of a [`Trace`].
pub(crate) struct SearchLog {
    parts: Parts,
    window: Option<SearchWindow>,
    segments: VecDeque<SearchWindow>,
    steps: VecDeque<SearchStep>,
}

impl SearchLog {
    pub(crate) fn new() -> Self {
        Self {
            parts: Parts::Circles([Vec::new(), Vec::new()]),
            window: None,
            segments: VecDeque::new(),
            steps: VecDeque::new(),
        }
    }

    /// The trace of a search with times in units of `unit`.
    pub(crate) fn trace(self, answer: Answer, unit: f64) -> Trace {
        let scaled = |window: SearchWindow| SearchWindow {
            begin: window.begin * unit,
            end: window.end * unit,
        };
        let later = |step: SearchStep| SearchStep {
            time: step.time * unit,
            free_until: step.free_until.map(|time| time * unit),
            ..step
        };
        Trace {
            answer,
            window: self.window.map(scaled),
            segments: self.segments.into_iter().map(scaled).collect(),
            steps: self.steps.into_iter().map(later).collect(),
        }
    }
}

impl Recorder for &mut SearchLog {
    const RECORDS: bool = true;

    fn concerns(&mut self, parts: impl FnOnce() -> Parts) {
        self.parts = parts();
    }

    fn step(&mut self, phase: Phase, time: f64, free_until: Option<f64>) {
        let step = SearchStep {
            phase,
            parts: self.parts.clone(),
            time,
            free_until,
        };
        push(&mut self.steps, step);
    }

    fn window(&mut self, window: SearchWindow) {
        self.window = Some(window);
    }

    fn segment(&mut self, segment: SearchWindow) {
        push(&mut self.segments, segment);
    }
}

/// Appends `value`, and drops the first one where there are [`MAX_RECORDED`].
fn push<T>(list: &mut VecDeque<T>, value: T) {
    if list.len() == MAX_RECORDED {
        list.pop_front();
    }
    list.push_back(value);
}

/// The number of evaluations of a search that certifies nothing, and their recorder.
pub(crate) struct SearchTally<R> {
    pub(crate) evaluations: u32,
    pub(crate) recorder: R,
}

impl<R: Recorder> SearchTally<R> {
    pub(crate) fn new(recorder: R) -> Self {
        Self {
            evaluations: 0,
            recorder,
        }
    }

    /// Counts and records an evaluation.
    #[inline(always)]
    pub(crate) fn evaluated(&mut self, phase: Phase, time: f64) {
        self.evaluations += 1;
        self.recorder.step(phase, time, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Outcome;

    #[test]
    fn only_the_last_steps_of_a_long_search_are_kept() {
        let mut log = SearchLog::new();
        for index in 0..=MAX_RECORDED {
            (&mut log).step(Phase::Secant, index as f64, None);
        }
        let trace = log.trace(
            Answer {
                outcome: Outcome::Free,
                evaluations: 0,
            },
            2.0,
        );
        assert_eq!(trace.steps.len(), MAX_RECORDED);
        assert_eq!(
            (trace.steps[0].time, trace.steps[MAX_RECORDED - 1].time),
            (2.0, 2_097_152.0)
        );
    }
}
