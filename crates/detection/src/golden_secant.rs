//! The detector of Montanari (2017), chapter 2: skim, crop, golden section, secant.
//!
//! Each segment of the window is searched for a minimum of the squared gap f = |d|² − s² of each
//! atom pair. Where the minimum is negative, the zero before it is the contact time. Nothing is
//! certified: the crop makes it only likely that f has one minimum in a segment, and a golden
//! section does not find a dip narrower than √ε of its segment. Use [`Exact`](crate::Exact) for
//! simulations; this detector is the baseline for comparison.
//!
//! Corrections to the text of the thesis and to its program:
//! * **Earliest pair.** All pairs of a segment are searched and the earliest contact is returned,
//!   not the first one in the order of the loops.
//! * **Sign.** Algorithm 3 continues with the next pair where the minimum is negative. The text
//!   around it states the opposite, which is implemented here.
//! * **Crop.** Equation 2.4 gets absolute values, and nothing is divided by zero.
//! * **Golden section.** One evaluation per round. The ends of a segment are candidates, so that a
//!   segment at whose end f is negative is not missed because f rises first.
//! * **Secant.** It keeps its bracket. Where the atoms are apart at the start of the segment, the
//!   start is the positive end. A maximum is searched for only where the atoms touch at the start
//!   and separate.
//! * **Tolerance.** Five machine epsilon relative to the end of the segment, not absolute: an
//!   absolute tolerance cannot be reached late in a run, and is coarse for small, fast bodies.
//! * **Touching.** The window begins slightly earlier, so that contacts of circles that touch
//!   exactly when the atoms do are not lost. A pair that touches or overlaps, and closes, is in
//!   contact at once. A pair that separates is searched for a contact after its first maximum.
//! * **Walls**, which the thesis does not treat: an atom and the nearest point of the wall form one
//!   more pair.
//! * **Termination.** Rounds and segments are bounded; a search that reaches a limit is
//!   `Unresolved`.

use carom_geometry::Outline;
use carom_kinematics::RelativeMotion;

use crate::{
    Answer, Contact, Detection, Outcome, Parts, Phase, SearchWindow, Trace,
    crop::segment_length,
    golden_section::{SectionSample, golden_section},
    range::{OUT_OF_RANGE, Unit, unit},
    secant::{Bracket, bracketed_secant},
    squared_gap::{SquaredGap, all_pairs},
    strip::{is_not_searched, window_of_bodies},
    tolerance::{CROP_FACTOR, MAX_ROUNDS, MAX_SEGMENTS, THESIS_TOLERANCE, WINDOW_MARGIN},
    trace::{Recorder, SearchLog, SearchTally},
};

/// The detector of the thesis: skim, crop, golden section, secant; corrected but not certified.
///
/// Discs have no closed form here: a batch of discs is searched pair by pair.
///
/// ```
/// use carom_detection::{Detection, GoldenSecant};
/// use carom_geometry::{Molecule, Shape};
/// use carom_kinematics::RelativeMotion;
/// use glam::DVec2;
///
/// let tee = Molecule::named(Shape::Tee, 0.005, 2.0)?;
/// let disc = Molecule::disc(0.01, 1.0)?;
/// let pair = RelativeMotion {
///     angular_velocity: [3.0, 0.0],
///     ..RelativeMotion::exactly(DVec2::new(0.1, 0.0), DVec2::new(-1.0, 0.0))
/// };
/// let answer = GoldenSecant::default().first_contact(tee.outline(), disc.outline(), &pair, 1.0);
/// assert!(answer.outcome.contact().is_some());
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(alias = "NOCS")]
pub struct GoldenSecant {
    /// Length of a segment as a share of the shortest quarter period (positive); see
    /// [`CROP_FACTOR`].
    pub crop_factor: f64,
    /// Tolerance of golden section and secant, relative to the time at which the segment ends; see
    /// [`THESIS_TOLERANCE`].
    pub tolerance: f64,
    /// Limit of rounds of one golden section or one secant; see [`MAX_ROUNDS`].
    pub most_rounds: u32,
    /// Limit of segments of one window; see [`MAX_SEGMENTS`].
    pub most_segments: u32,
}

impl Default for GoldenSecant {
    fn default() -> Self {
        Self {
            crop_factor: CROP_FACTOR,
            tolerance: THESIS_TOLERANCE,
            most_rounds: MAX_ROUNDS,
            most_segments: MAX_SEGMENTS,
        }
    }
}

impl Detection for GoldenSecant {
    fn first_contact(
        &self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        self.search((), a, b, motion, horizon)
    }
}

/// The window with an earlier begin, so that atoms that touch at its original begin are apart
/// there.
fn widened(window: SearchWindow) -> SearchWindow {
    let end = window.end.min(f64::MAX);
    SearchWindow {
        begin: (window.begin - WINDOW_MARGIN * (end - window.begin)).max(0.0),
        end,
    }
}

/// The limit of rounds was reached.
struct RoundsUsedUp;

impl GoldenSecant {
    /// Searches like [`Detection::first_contact`] and records the segments and the evaluations.
    pub fn trace(
        &self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Trace {
        let mut log = SearchLog::new();
        let answer = self.search(&mut log, a, b, motion, horizon);
        log.trace(answer, 1.0)
    }

    fn search<R: Recorder>(
        &self,
        recorder: R,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        if let Unit::OutOfRange = unit(a, b, motion, horizon) {
            return OUT_OF_RANGE;
        }
        let mut tally = SearchTally::new(recorder);
        let outcome = match window_of_bodies(a, b, motion, horizon) {
            _ if is_not_searched(a, b, motion) => Outcome::Unresolved(0.0),
            Some(window) => self.crop_and_search(a, b, motion, widened(window), &mut tally),
            None => Outcome::Free,
        };
        Answer {
            outcome,
            evaluations: tally.evaluations,
        }
    }

    fn crop_and_search<R: Recorder>(
        &self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        window: SearchWindow,
        tally: &mut SearchTally<R>,
    ) -> Outcome {
        tally.recorder.window(window);
        let length = segment_length(motion.angular_velocity, self.crop_factor.max(0.0));
        let mut begin = window.begin;
        for _ in 0..self.most_segments {
            if begin > window.end {
                return Outcome::Free;
            }
            let segment = SearchWindow {
                begin,
                end: (begin + length).min(window.end),
            };
            tally.recorder.segment(segment);
            match self.earliest_in(segment, a, b, motion, tally) {
                Ok(Some(contact)) => return Outcome::Contact(contact),
                Ok(None) if segment.end == window.end => return Outcome::Free,
                Ok(None) => begin = segment.end,
                Err(RoundsUsedUp) => break,
            }
        }
        Outcome::Unresolved(begin)
    }

    /// The earliest contact of all atom pairs in one segment.
    fn earliest_in<R: Recorder>(
        &self,
        segment: SearchWindow,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        tally: &mut SearchTally<R>,
    ) -> Result<Option<Contact>, RoundsUsedUp> {
        let mut earliest: Option<Contact> = None;
        for (touch, gap) in all_pairs(a, b, motion) {
            tally.recorder.concerns(|| Parts::Pair(touch));
            let Some(time) = self.contact_of_pair(&gap, segment, tally)? else {
                continue;
            };
            if earliest.is_none_or(|found| time < found.time) {
                earliest = Some(Contact { time, touch });
            }
        }
        Ok(earliest)
    }

    /// The contact time of one atom pair in one segment.
    fn contact_of_pair<R: Recorder>(
        &self,
        gap: &SquaredGap<'_>,
        segment: SearchWindow,
        tally: &mut SearchTally<R>,
    ) -> Result<Option<f64>, RoundsUsedUp> {
        let width = self.tolerance * segment.end;
        let mut f = |phase, time| {
            tally.evaluated(phase, time);
            gap.at(time)
        };
        let start = SectionSample {
            time: segment.begin,
            value: f(Phase::SegmentEnd, segment.begin),
        };
        let end = SectionSample {
            time: segment.end,
            value: f(Phase::SegmentEnd, segment.end),
        };
        let apart = if start.value > gap.touching(start.time) {
            start
        } else if gap.closes(start.time) {
            return Ok(Some(start.time));
        } else {
            let top = golden_section(
                |t| -f(Phase::GoldenMaximum, t),
                segment,
                width,
                self.most_rounds,
            );
            let top = top.ok_or(RoundsUsedUp)?;
            SectionSample {
                value: -top.value,
                ..top
            }
        };
        let rest = SearchWindow {
            begin: apart.time,
            end: segment.end,
        };
        let dip = golden_section(
            |t| f(Phase::GoldenMinimum, t),
            rest,
            width,
            self.most_rounds,
        );
        let dip = dip.ok_or(RoundsUsedUp)?.lower(end);
        let Some(bracket) = Bracket::new(apart, dip) else {
            return Ok(None);
        };
        let time = bracketed_secant(|t| f(Phase::Secant, t), bracket, width, self.most_rounds);
        let time = time.ok_or(RoundsUsedUp)?;
        // At a zero where they do not close, the parts touch only by rounding.
        Ok(gap.closes(time).then_some(time))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DISC_LANES, DiscLanes, Touch};
    use carom_geometry::{Molecule, Shape};
    use carom_kinematics::Orientation;
    use glam::DVec2;

    fn discs(separation: DVec2, velocity: DVec2) -> Answer {
        let disc = Molecule::disc(0.5, 1.0).unwrap();
        let pair = RelativeMotion::exactly(separation, velocity);
        GoldenSecant::default().first_contact(disc.outline(), disc.outline(), &pair, 100.0)
    }

    #[test]
    fn discs_head_on_meet_where_the_window_begins() {
        let contact = discs(DVec2::new(3.0, 0.0), DVec2::new(-1.0, 0.0))
            .outcome
            .contact()
            .unwrap();
        assert!((contact.time - 2.0).abs() < 1e-14, "{contact:?}");
        assert_eq!(contact.touch, Touch::Atoms(0, 0));
    }

    #[test]
    fn a_pair_that_touches_collides_only_if_it_closes() {
        for gap in [-1e-3, -1e-16, 0.0, 1e-16] {
            let d = DVec2::new(1.0 + gap, 0.0);
            let closing = discs(d, DVec2::new(-1.0, 0.1)).outcome.contact().unwrap();
            assert!(closing.time <= 1e-15, "gap {gap}: {closing:?}");
            for parting in [DVec2::new(1.0, 0.1), DVec2::new(0.0, 1.0), DVec2::ZERO] {
                assert_eq!(
                    discs(d, parting).outcome,
                    Outcome::Free,
                    "gap {gap}, velocity {parting}"
                );
            }
        }
    }

    #[test]
    fn a_separating_pair_is_found_when_it_returns() {
        // A dumbbell turns on the spot in front of a disc at rest that one of its atoms has just
        // left. The other atom touches the disc half a turn later, less the angle within which the
        // first one still touches.
        let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0).unwrap();
        let disc = Molecule::disc(1.0, 1.0).unwrap();
        let (arm, distance) = (1.0, 2.5);
        let touching = f64::acos((arm * arm + distance * distance - 4.0) / (2.0 * arm * distance));
        let pair = RelativeMotion {
            angular_velocity: [1.0, 0.0],
            orientation: [Orientation::from_radians(touching), Orientation::default()],
            ..RelativeMotion::exactly(DVec2::new(distance, 0.0), DVec2::ZERO)
        };
        let answer =
            GoldenSecant::default().first_contact(dumbbell.outline(), disc.outline(), &pair, 10.0);
        let contact = answer.outcome.contact().unwrap();
        assert!(
            (contact.time - (std::f64::consts::PI - 2.0 * touching)).abs() < 1e-14,
            "{contact:?}"
        );
        assert_eq!(contact.touch, Touch::Atoms(0, 0));
    }

    #[test]
    fn searches_that_reach_their_limits_are_unresolved() {
        let tee = Molecule::named(Shape::Tee, 1.0, 1.0).unwrap();
        let near = RelativeMotion {
            angular_velocity: [1e9, 0.0],
            ..RelativeMotion::exactly(DVec2::new(7.5, 0.0), DVec2::new(1e-9, 0.0))
        };
        let ask = |detector: GoldenSecant| {
            detector.first_contact(tee.outline(), tee.outline(), &near, 10.0)
        };
        let few_segments = GoldenSecant {
            most_segments: 3,
            ..GoldenSecant::default()
        };
        let Outcome::Unresolved(time) = ask(few_segments).outcome else {
            panic!("three segments")
        };
        assert!(time > 0.0 && time < 1e-8);
        for detector in [
            GoldenSecant {
                most_rounds: 5,
                ..GoldenSecant::default()
            },
            GoldenSecant {
                tolerance: f64::NAN,
                ..GoldenSecant::default()
            },
            GoldenSecant {
                crop_factor: f64::NAN,
                ..GoldenSecant::default()
            },
            GoldenSecant {
                crop_factor: -1.0,
                ..GoldenSecant::default()
            },
        ] {
            assert_eq!(
                ask(detector).outcome,
                Outcome::Unresolved(0.0),
                "{detector:?}"
            );
        }
    }

    #[test]
    fn eight_discs_are_searched_pair_by_pair() {
        let mut lanes = DiscLanes::empty(0.0, 0.0);
        for lane in 0..DISC_LANES {
            lanes.set(
                lane,
                DVec2::new(3.0, 0.3 * lane as f64),
                DVec2::new(-1.0, 0.0),
                1.0,
            );
        }
        let times = GoldenSecant::default().disc_contacts(&lanes);
        for (lane, time) in times.into_iter().enumerate() {
            let answer = discs(DVec2::new(3.0, 0.3 * lane as f64), DVec2::new(-1.0, 0.0));
            assert_eq!(
                time,
                answer
                    .outcome
                    .contact()
                    .map_or(f64::INFINITY, |contact| contact.time)
            );
            assert_eq!(time.is_finite(), lane < 4);
        }
    }
}
