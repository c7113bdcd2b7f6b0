//! Test problems for detectors: pairs of molecules in flight, and molecules and walls, ordinary
//! ones and each kind that is known to be hard.
//!
//! Every case is a pure function of its [`Class`], a seed and an index, so these three identify a
//! failing case. Available with the cargo feature `encounters`.
//!
//! ```
//! use carom_detection::{Detection, Exact, encounters::{Class, Encounter}};
//!
//! for class in Class::ALL {
//!     let encounter = Encounter::draw(class, 2017, 0);
//!     let answer = encounter.first_contact(&Exact::default());
//!     assert_eq!(answer, Encounter::draw(class, 2017, 0).first_contact(&Exact::default()));
//! }
//! ```

mod class;
mod contacts;
mod edged_flights;
mod edged_grazes;
mod edged_insides;
mod edged_shapes;
mod fast;
mod flights;
mod grazes;
mod random;
mod shapes;
mod walls;

pub use class::Class;

use carom_geometry::Molecule;
use carom_kinematics::{Motion, RelativeMotion};
use glam::DVec2;

use crate::{Answer, Detection, natural_time, strip::window_of_bodies};

/// Two molecules in flight and a horizon.
#[derive(Debug, Clone)]
pub struct Encounter {
    /// The molecules A and B.
    pub molecules: [Molecule; 2],
    /// Motion of B relative to A from time 0 on.
    pub motion: RelativeMotion,
    /// The latest time of a contact; finite.
    pub horizon: f64,
}

impl Encounter {
    /// Returns case number `index` of a class. Each seed gives other cases of the same class.
    pub fn draw(class: Class, seed: u64, index: u64) -> Self {
        class.draw(&mut random::Draw::new(seed, class, index), index)
    }

    /// The answer of a detector.
    pub fn first_contact(&self, detector: &(impl Detection + ?Sized)) -> Answer {
        let [a, b] = &self.molecules;
        detector.first_contact(a.outline(), b.outline(), &self.motion, self.horizon)
    }

    /// The time in which the pair moves by its own size.
    pub fn natural_time(&self) -> f64 {
        natural_time(
            self.molecules[0].outline(),
            self.molecules[1].outline(),
            &self.motion,
        )
    }

    /// Sum of the bounding radii (length).
    pub fn size(&self) -> f64 {
        size(&self.molecules)
    }

    /// This encounter with the bodies exchanged.
    #[must_use]
    pub fn exchanged(self) -> Self {
        let [a, b] = self.molecules;
        Self {
            molecules: [b, a],
            motion: self.motion.exchanged(),
            horizon: self.horizon,
        }
    }

    /// The remaining encounter after `time`. The rounding of the new positions and angles is added
    /// to the error bounds.
    #[must_use]
    pub fn after(&self, time: f64) -> Self {
        let spins = self.motion.angular_velocity;
        let body = |index: usize| Motion {
            orientation: self.motion.orientation[index],
            angular_velocity: spins[index],
            ..Motion::at_rest(DVec2::ZERO)
        };
        let b = Motion {
            position: self.motion.separation,
            velocity: self.motion.velocity,
            ..body(1)
        };
        let moved = RelativeMotion::between(&body(0), &b, DVec2::ZERO, time);
        let before = &self.motion;
        let sum = |index: usize| moved.orientation_error[index] + before.orientation_error[index];
        let motion = RelativeMotion {
            separation_error: moved.separation_error + before.separation_error,
            velocity_error: moved.velocity_error + before.velocity_error,
            orientation_error: [sum(0), sum(1)],
            ..moved
        };
        Self {
            molecules: self.molecules.clone(),
            motion,
            horizon: self.horizon - time,
        }
    }

    /// The encounter up to the time at which the bounding circles separate, or up to `otherwise` if
    /// they never do.
    fn until_parted(molecules: [Molecule; 2], motion: RelativeMotion, otherwise: f64) -> Self {
        let [a, b] = molecules.each_ref().map(Molecule::outline);
        let window = window_of_bodies(a, b, &motion, f64::MAX);
        let horizon = window.map_or(otherwise, |window| window.end);
        let horizon = if horizon < f64::MAX {
            horizon
        } else {
            otherwise
        };
        Self {
            molecules,
            motion,
            horizon,
        }
    }
}

fn size(molecules: &[Molecule; 2]) -> f64 {
    molecules[0].bounding_radius() + molecules[1].bounding_radius()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Exact, Outcome, Touch};
    use carom_geometry::gap_between;

    /// Smallest gap at the start in units of the size of the pair.
    fn first_gap(encounter: &Encounter) -> f64 {
        let [a, b] = &encounter.molecules;
        let [turn_a, turn_b] = encounter
            .motion
            .orientation
            .map(carom_kinematics::Orientation::cos_sin);
        gap_between(a, turn_a, b, turn_b, encounter.motion.separation) / encounter.size()
    }

    #[test]
    fn cases_begin_apart_and_some_of_each_class_end_in_contact() {
        for class in Class::ALL {
            let cases: Vec<_> = (0..40)
                .map(|index| Encounter::draw(class, 1, index))
                .collect();
            for (index, case) in cases.iter().enumerate() {
                assert!(
                    case.horizon.is_finite() && case.horizon >= 0.0,
                    "{class} {index}: {case:?}"
                );
                assert!(case.natural_time() > 0.0);
                let gap = first_gap(case);
                // Rounding of positions 1e9 sizes away from the origin.
                let rounding = 1e-14 + case.motion.separation_error / case.size();
                assert!(
                    gap > -rounding,
                    "{class} {index} begins with a gap of {gap:e} sizes"
                );
            }
            let contacts = cases.iter().filter(|case| {
                case.first_contact(&Exact::default())
                    .outcome
                    .contact()
                    .is_some()
            });
            let contacts = contacts.count();
            let least = if class == Class::Concentric { 0 } else { 2 };
            assert!(contacts >= least, "{class}: {contacts} of 40 in contact");
        }
    }

    #[test]
    fn a_constructed_graze_has_the_depth_of_its_class() {
        for exponent in [6, 8, 10] {
            let class = Class::Graze(exponent);
            let deep = (0..50).filter(|&index| {
                let case = Encounter::draw(class, 3, index);
                case.first_contact(&Exact::default())
                    .outcome
                    .contact()
                    .is_some()
            });
            // 7 in 10 are constructed to overlap; in others, other atoms may touch.
            assert!((25..50).contains(&deep.count()), "depth 1e-{exponent}");
        }
    }

    #[test]
    fn the_rest_of_an_encounter_ends_in_the_same_contact() {
        for index in 0..50 {
            let case = Encounter::draw(Class::Generic, 5, index);
            let Some(contact) = case.first_contact(&Exact::default()).outcome.contact() else {
                continue;
            };
            let half = 0.5 * contact.time;
            let rest = case
                .after(half)
                .first_contact(&Exact::default())
                .outcome
                .contact()
                .expect("it lies ahead");
            assert_eq!(rest.touch, contact.touch);
            assert!(
                (rest.time + half - contact.time).abs()
                    < 1e-12 * case.natural_time().max(contact.time)
            );
        }
    }

    /// The outcome with the bits of its time, which is multiplied by a factor.
    fn bits(outcome: Outcome, factor: f64) -> (Option<Touch>, u64) {
        let time = match outcome {
            Outcome::Contact(contact) => contact.time,
            Outcome::FreeUntil(time) | Outcome::Unresolved(time) => time,
            Outcome::Free | Outcome::OutOfRange => f64::INFINITY,
        };
        let touch = outcome.contact().map(|contact| contact.touch);
        (touch, (factor * time).to_bits())
    }

    #[test]
    fn exchanged_bodies_and_faster_motions_give_the_same_bits() {
        const FASTER: f64 = 1024.0;
        for class in Class::ALL {
            for index in 0..100 {
                let case = Encounter::draw(class, 6, index);
                let answer = case.first_contact(&Exact::default());
                let (touch, time) = bits(answer.outcome, 1.0);
                let exchanged = case.clone().exchanged().first_contact(&Exact::default());
                let (mirrored, same) = bits(exchanged.outcome, 1.0);
                assert_eq!(same, time, "{class} {index}: {answer:?}, {exchanged:?}");
                // Parts that touch at one time may be reported in either order.
                assert_eq!(mirrored.is_some(), touch.is_some(), "{class} {index}");
                let mut fast = case.clone();
                fast.horizon /= FASTER;
                fast.motion.velocity *= FASTER;
                fast.motion.velocity_error *= FASTER;
                fast.motion.angular_velocity = case.motion.angular_velocity.map(|w| FASTER * w);
                let faster = fast.first_contact(&Exact::default());
                assert_eq!(
                    bits(faster.outcome, FASTER),
                    (touch, time),
                    "{class} {index}: {answer:?}, {faster:?}"
                );
            }
        }
    }

    #[test]
    fn classes_have_distinct_names() {
        let mut names: Vec<String> = Class::ALL.iter().map(Class::to_string).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), Class::ALL.len());
        for class in Class::ALL {
            assert_eq!(class.to_string().parse(), Ok(class));
        }
        assert!("graze_1e-99".parse::<Class>().is_err());
    }
}
