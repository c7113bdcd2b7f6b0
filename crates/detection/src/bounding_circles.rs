//! A coarser model: bodies are in contact when their bounding circles touch.

use carom_geometry::Outline;
use carom_kinematics::RelativeMotion;

use crate::{
    Answer, Contact, Detection, Outcome, Parts, Phase, Touch, Trace,
    disc::disc_contact,
    edges,
    range::{OUT_OF_RANGE, Unit, unit},
    strip::window_of_bodies,
    trace::{Recorder, SearchLog},
};

/// A model in which each body is its bounding circle; it does not approximate the contact times of
/// the molecules.
///
/// It costs as little as a pair of discs. Contacts are earlier than those of the molecules, and
/// bodies whose atoms would pass each other collide, too. The impulse is along the line of centres,
/// so no angular velocity changes. A wall keeps its shape, and the bounding circles collide with
/// it.
///
/// ```
/// use carom_detection::{BoundingCircles, Detection, Touch};
/// use carom_geometry::{Molecule, Shape};
/// use carom_kinematics::RelativeMotion;
/// use glam::DVec2;
///
/// let dumbbell = Molecule::named(Shape::Dumbbell, 0.5, 1.0)?;
/// let pair = RelativeMotion::exactly(DVec2::new(5.0, 0.0), DVec2::new(-1.0, 0.0));
/// let answer = BoundingCircles.first_contact(dumbbell.outline(), dumbbell.outline(), &pair, 10.0);
/// let contact = answer.outcome.contact().unwrap();
/// assert!((contact.time - 3.0).abs() < 1e-14);
/// assert_eq!(contact.touch, Touch::BoundingCircles);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BoundingCircles;

impl Detection for BoundingCircles {
    fn searches_curves(&self) -> bool {
        true
    }

    #[inline]
    fn decides_discs_in_closed_form(&self) -> bool {
        true
    }

    fn first_contact(
        &self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        if let Unit::OutOfRange = unit(a, b, motion, horizon) {
            return OUT_OF_RANGE;
        }
        if a.is_wall() || b.is_wall() {
            return edges::contact_of_circle(a, b, motion, horizon);
        }
        let errors = (motion.separation_error, motion.velocity_error);
        let sigma = a.bounding_radius + b.bounding_radius;
        let time = disc_contact(motion.separation, motion.velocity, sigma, errors);
        let contact = Contact {
            time,
            touch: Touch::BoundingCircles,
        };
        let outcome = if time <= horizon && time.is_finite() {
            Outcome::Contact(contact)
        } else {
            Outcome::Free
        };
        Answer {
            outcome,
            evaluations: 1,
        }
    }
}

impl BoundingCircles {
    /// The answer of [`Detection::first_contact`] and the window in which the bodies are within
    /// reach of each other.
    pub fn trace(
        self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Trace {
        let answer = self.first_contact(a, b, motion, horizon);
        let mut log = SearchLog::new();
        let mut recorder = &mut log;
        let is_in_range = answer.outcome != Outcome::OutOfRange;
        if let Some(window) = window_of_bodies(a, b, motion, horizon).filter(|_| is_in_range) {
            recorder.window(window);
        }
        if let Some(contact) = answer.outcome.contact() {
            recorder.concerns(|| Parts::Pair(contact.touch));
            recorder.step(Phase::ClosedForm, 0.0, Some(contact.time));
        }
        log.trace(answer, 1.0)
    }
}
