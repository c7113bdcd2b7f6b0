//! Detection by overlap tests at regular times, as in a time-stepped code.

use carom_geometry::Outline;
use carom_kinematics::RelativeMotion;

use crate::{
    Answer, Contact, Detection, Outcome, Parts, Phase, SearchWindow, Trace,
    range::{OUT_OF_RANGE, Unit, unit},
    squared_gap::{SquaredGap, all_pairs},
    strip::{is_not_searched, window_of_bodies},
    tolerance::{FIXED_STEP, MAX_BISECTIONS, MAX_FIXED_STEPS},
    trace::{Recorder, SearchLog, SearchTally},
};

/// Tests for overlap at multiples of a step, and bisects back to the time of contact.
///
/// A contact that begins and ends between two tests is missed. A contact in which atoms pass
/// through each other is late. Event-driven simulation is free of these errors. The free flight of
/// the bodies is exact here, so these are the smallest errors of a time-stepped code with this
/// step.
///
/// ```
/// use carom_detection::{Detection, FixedStep};
/// use carom_geometry::Molecule;
/// use carom_kinematics::RelativeMotion;
/// use glam::DVec2;
///
/// let disc = Molecule::disc(0.5, 1.0)?;
/// let meets = |step: f64, miss: f64| {
///     let pair = RelativeMotion::exactly(DVec2::new(3.0, miss), DVec2::new(-1.0, 0.0));
///     let detector = FixedStep { step, ..FixedStep::default() };
///     detector.first_contact(disc.outline(), disc.outline(), &pair, 10.0).outcome.contact().is_some()
/// };
/// assert!(meets(1e-3, 0.999) && meets(0.7, 0.0));
/// // A graze that lasts 0.09 natural times is found only with the finer step.
/// assert!(!meets(0.7, 0.999));
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedStep {
    /// The step in [natural times](natural_time) of the pair; see [`FIXED_STEP`].
    pub step: f64,
    /// Step limit in one window; see [`MAX_FIXED_STEPS`].
    pub most_steps: u32,
}

impl Default for FixedStep {
    fn default() -> Self {
        Self {
            step: FIXED_STEP,
            most_steps: MAX_FIXED_STEPS,
        }
    }
}

/// The time in which a pair moves by its own size; infinite if nothing moves.
///
/// `(R_A + R_B) / (|V| + |ω_A| R_A + |ω_B| R_B)`, with the bounding radii R and the relative
/// velocity V. For a wall that does not turn R is 0, because its length may be arbitrary.
pub fn natural_time(a: Outline<'_>, b: Outline<'_>, motion: &RelativeMotion) -> f64 {
    let [spin_a, spin_b] = motion.angular_velocity.map(f64::abs);
    let [radius_a, radius_b] = [(a, spin_a), (b, spin_b)].map(|(body, spin)| {
        if body.is_wall() && spin == 0.0 {
            0.0
        } else {
            body.bounding_radius
        }
    });
    let rim_speed = spin_a * radius_a + spin_b * radius_b;
    (radius_a + radius_b) / (motion.velocity.length() + rim_speed)
}

impl Detection for FixedStep {
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

impl FixedStep {
    /// Searches like [`Detection::first_contact`] and records the steps between the tests, and the
    /// bisections.
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
        mut recorder: R,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        if let Unit::OutOfRange = unit(a, b, motion, horizon) {
            return OUT_OF_RANGE;
        }
        match window_of_bodies(a, b, motion, horizon) {
            _ if is_not_searched(a, b, motion) => Answer {
                outcome: Outcome::Unresolved(0.0),
                evaluations: 0,
            },
            Some(window) => {
                recorder.window(window);
                let step = self.step * natural_time(a, b, motion);
                let mut pairs = AtomPairs {
                    a,
                    b,
                    motion,
                    tally: SearchTally::new(recorder),
                };
                let outcome = pairs.walk(window, step, self.most_steps, horizon);
                Answer {
                    outcome,
                    evaluations: pairs.tally.evaluations,
                }
            }
            None => Answer {
                outcome: Outcome::Free,
                evaluations: 0,
            },
        }
    }
}

struct AtomPairs<'a, R> {
    a: Outline<'a>,
    b: Outline<'a>,
    motion: &'a RelativeMotion,
    tally: SearchTally<R>,
}

impl<R: Recorder> AtomPairs<'_, R> {
    /// Tests the multiples of `step`, beginning with the last one before the window.
    fn walk(&mut self, window: SearchWindow, step: f64, most_steps: u32, horizon: f64) -> Outcome {
        let first = if step == f64::INFINITY {
            0.0
        } else {
            (window.begin / step).floor()
        };
        let mut before = first * if first == 0.0 { 0.0 } else { step };
        let mut now = before;
        for count in 1..=most_steps {
            self.tally.recorder.segment(SearchWindow {
                begin: before,
                end: now,
            });
            match self.earliest_overlap(before, now) {
                Some(contact) if contact.time <= horizon => return Outcome::Contact(contact),
                Some(_) => return Outcome::Free,
                None if now >= window.end || step == f64::INFINITY => return Outcome::Free,
                None => {}
            }
            before = now;
            now = (first + f64::from(count)) * step;
            if now.is_nan() {
                break;
            }
        }
        Outcome::Unresolved(window.begin.max(before))
    }

    /// The earliest contact among the pairs that overlap at `now`.
    fn earliest_overlap(&mut self, before: f64, now: f64) -> Option<Contact> {
        let mut earliest: Option<Contact> = None;
        for (touch, gap) in all_pairs(self.a, self.b, self.motion) {
            self.tally.evaluations += 1;
            if gap.at(now) > 0.0 {
                continue;
            }
            let time = if before < now && gap.at(before) > 0.0 {
                self.tally.recorder.concerns(|| Parts::Pair(touch));
                first_touch(&gap, before, now, &mut self.tally)
            } else if gap.closes(now) {
                now
            } else {
                continue;
            };
            if earliest.is_none_or(|found| time < found.time) {
                earliest = Some(Contact { time, touch });
            }
        }
        earliest
    }
}

/// Bisects between a time without and a time with overlap, down to neighbouring floats.
fn first_touch<R: Recorder>(
    gap: &SquaredGap<'_>,
    mut apart: f64,
    mut overlap: f64,
    tally: &mut SearchTally<R>,
) -> f64 {
    for _ in 0..MAX_BISECTIONS {
        let middle = apart + 0.5 * (overlap - apart);
        if middle <= apart || middle >= overlap {
            break;
        }
        tally.evaluated(Phase::Bisection, middle);
        if gap.at(middle) > 0.0 {
            apart = middle;
        } else {
            overlap = middle;
        }
    }
    overlap
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Touch;
    use carom_geometry::{Molecule, Shape};
    use glam::DVec2;

    fn ask(detector: FixedStep, separation: DVec2, velocity: DVec2, spin: f64) -> Answer {
        let dumbbell = Molecule::named(Shape::Dumbbell, 0.5, 1.0).unwrap();
        let pair = RelativeMotion {
            angular_velocity: [spin, 0.0],
            ..RelativeMotion::exactly(separation, velocity)
        };
        detector.first_contact(dumbbell.outline(), dumbbell.outline(), &pair, 100.0)
    }

    #[test]
    fn a_plain_contact_is_found_to_rounding() {
        let answer = ask(
            FixedStep::default(),
            DVec2::new(5.0, 0.0),
            DVec2::new(-1.0, 0.0),
            0.0,
        );
        let contact = answer.outcome.contact().unwrap();
        assert!((contact.time - 3.0).abs() < 1e-14);
        assert_eq!(contact.touch, Touch::Atoms(1, 0));
    }

    #[test]
    fn touching_pairs_collide_only_if_they_close() {
        let closing = ask(
            FixedStep::default(),
            DVec2::new(2.0, 0.0),
            DVec2::new(-1.0, 0.0),
            0.0,
        );
        assert_eq!(closing.outcome.contact().unwrap().time, 0.0);
        for velocity in [DVec2::ZERO, DVec2::X, DVec2::Y] {
            let answer = ask(FixedStep::default(), DVec2::new(2.0, 0.0), velocity, 0.0);
            assert_eq!(answer.outcome, Outcome::Free, "{velocity}");
        }
    }

    #[test]
    fn a_search_that_reaches_its_step_limit_is_unresolved() {
        let detector = FixedStep {
            most_steps: 100,
            ..FixedStep::default()
        };
        // The bounding circles overlap for a long time, and the atoms never touch.
        let answer = ask(detector, DVec2::new(0.0, 1.8), DVec2::new(1e-6, 0.0), 1e3);
        assert!(
            matches!(answer.outcome, Outcome::Unresolved(_)),
            "{answer:?}"
        );
        for step in [0.0, f64::NAN] {
            let answer = ask(
                FixedStep { step, ..detector },
                DVec2::new(5.0, 0.0),
                DVec2::new(-1.0, 0.0),
                0.0,
            );
            assert!(
                matches!(answer.outcome, Outcome::Unresolved(_)),
                "step {step}: {answer:?}"
            );
        }
    }
}
