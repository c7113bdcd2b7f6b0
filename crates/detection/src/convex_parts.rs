//! Contacts of two convex bodies of one's own, by their support functions.

use carom_geometry::Support;
use carom_kinematics::RelativeMotion;
use glam::DVec2;

use crate::{
    Answer, Outcome, Touch,
    flight::Flight,
    gap_search::GapFunction,
    range::{OUT_OF_RANGE, Unit, faster, later, unit_of_radii},
    search::Search,
    skim,
    support_pair::SupportPair,
    tolerance::MAX_STEPS,
};

/// The certified first contact of two convex bodies up to `horizon` (time), each about its centre
/// of mass; see [`Exact`](crate::Exact) for what is guaranteed. The contact names the parts 0 and
/// 0.
///
/// ```
/// use carom_detection::first_contact_of_convex;
/// use carom_geometry::Ellipse;
/// use carom_kinematics::RelativeMotion;
/// use glam::DVec2;
///
/// let ellipse = Ellipse::new([2.0, 1.0], DVec2::X)?;
/// let pair = RelativeMotion::exactly(DVec2::new(6.0, 0.0), DVec2::new(-1.0, 0.0));
/// let answer = first_contact_of_convex(&ellipse, &Ellipse::round(1.0), &pair, 10.0);
/// assert_eq!(answer.outcome.contact().map(|contact| contact.time), Some(3.0));
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
pub fn first_contact_of_convex<A: Support, B: Support>(
    a: &A,
    b: &B,
    motion: &RelativeMotion,
    horizon: f64,
) -> Answer {
    match unit_of_radii([a.reach(), b.reach()], motion, horizon) {
        Unit::Ordinary => search(a, b, motion, horizon.min(f64::MAX)),
        Unit::Scaled(factor) => {
            let horizon = (horizon / factor).min(f64::MAX);
            later(search(a, b, &faster(motion, factor), horizon), factor)
        }
        Unit::OutOfRange => OUT_OF_RANGE,
    }
}

fn search<A: Support, B: Support>(a: &A, b: &B, motion: &RelativeMotion, horizon: f64) -> Answer {
    let Some(window) = skim(motion, a.reach() + b.reach(), horizon) else {
        return Answer {
            outcome: Outcome::Free,
            evaluations: 0,
        };
    };
    let mut search = Search::new(window.end, MAX_STEPS, ());
    let flight = Flight::of_bodies([false; 2], motion);
    let pair = SupportPair::new(&flight, (a, b), [DVec2::ZERO; 2]);
    let limits = [f64::INFINITY, window.end];
    let outcome = pair.first_contact(window.begin, limits, &mut 0, &mut search);
    search.record_touch(outcome, Touch::Atoms(0, 0));
    search.answer()
}
