//! When do two bodies in free flight first touch? Reads motions, changes nothing.
//!
//! The question is one [`RelativeMotion`] (two bodies at a common
//! time 0 and one periodic image) and a horizon; the answer is a named [`Outcome`]. The seam is the
//! trait [`Detection`], with these ways to answer:
//!
//! | detector | what it is |
//! | --- | --- |
//! | [`Exact`] | certified: no contact deeper than twice the rounding bound is missed |
//! | [`GoldenSecant`] | Montanari (2017), chapter 2: skim, crop, golden section, secant |
//! | [`BoundingCircles`] | a coarser model: bodies are their bounding circles |
//! | [`FixedStep`] | what a time-stepped code does |
//!
//! ```
//! use carom_detection::{Detection, Exact, Outcome};
//! use carom_geometry::Molecule;
//! use carom_kinematics::RelativeMotion;
//! use glam::DVec2;
//!
//! let disc = Molecule::disc(0.5, 1.0)?;
//! let pair = RelativeMotion::exactly(DVec2::new(3.0, 0.0), DVec2::new(-1.0, 0.0));
//! let answer = Exact::default().first_contact(disc.outline(), disc.outline(), &pair, 10.0);
//! let Outcome::Contact(contact) = answer.outcome else { panic!("they meet") };
//! assert_eq!(contact.time, 2.0);
//! # Ok::<(), carom_geometry::GeometryError>(())
//! ```
//!
//! A wall, or a half-plane, is a body like any other, with a straight face; it must not turn:
//!
//! ```
//! use carom_detection::{Detection, Exact, Part, Touch};
//! use carom_geometry::{HalfPlane, Molecule, Shape};
//! use carom_kinematics::RelativeMotion;
//! use glam::DVec2;
//!
//! // A dumbbell of arms 1 and radii 1 turns 1.5 above the ground: an atom is down when sin θ = 1/2.
//! let ground = HalfPlane::new(DVec2::Y)?;
//! let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0)?;
//! let pair = RelativeMotion {
//!     angular_velocity: [0.0, 1.0],
//!     ..RelativeMotion::exactly(DVec2::new(0.0, 1.5), DVec2::ZERO)
//! };
//! let answer = Exact::default().first_contact(ground.outline(), dumbbell.outline(), &pair, 10.0);
//! let contact = answer.outcome.contact().expect("it comes down");
//! assert!((contact.time - std::f64::consts::FRAC_PI_6).abs() < 1e-15);
//! assert_eq!(contact.touch, Touch::FaceOfA(Part::Atom(0)));
//! # Ok::<(), carom_geometry::GeometryError>(())
//! ```

#![allow(
    clippy::inline_always,
    reason = "kernels must be compiled with the vector instructions of their callers"
)]

mod atom_block;
mod atom_pair;
mod atom_row;
mod bounding_circles;
mod circle_descent;
mod crop;
mod disc;
#[cfg(feature = "encounters")]
pub mod encounters;
mod error_bound;
mod exact;
mod face_error;
mod face_pair;
mod fixed_step;
mod flight;
mod gap_search;
mod golden_secant;
mod golden_section;
mod lanes;
mod outcome;
mod query_body;
mod range;
mod rectangle;
mod relative_disc;
mod resolved_speed;
mod safe_step;
mod search;
mod secant;
mod skimming;
mod squared_gap;
mod strip;
pub mod tolerance;
mod walls;

pub use bounding_circles::BoundingCircles;
pub use error_bound::ErrorBound;
pub use exact::Exact;
pub use face_error::FaceErrorBound;
pub use fixed_step::{FixedStep, natural_time};
pub use golden_secant::GoldenSecant;
pub use lanes::{DISC_LANES, DiscLanes};
pub use outcome::{Answer, Contact, Outcome, Part, Touch};
pub use query_body::QueryBody;
pub use resolved_speed::resolved_speed;
pub use skimming::{Window, skim};

use carom_geometry::{Atom, Outline};
use carom_kinematics::RelativeMotion;
use glam::DVec2;

/// The first contact of two moving bodies before a horizon: the seam of this layer.
///
/// An implementor must be a pure function of its arguments. The answer may not depend on which body
/// is called A, except that A's and B's parts are exchanged with them (ties between atom pairs
/// touching at one instant excepted: the caller keeps an order of its own).
pub trait Detection {
    /// The first contact of A and B after time 0 and no later than `horizon` (time).
    ///
    /// A pair that touches or overlaps at time 0 is in contact at once if it closes, and is left
    /// alone while it parts.
    ///
    /// A body with a [face](Outline::face) must not turn: what turns is answered by [`Outcome::Unresolved`] at time 0.
    fn first_contact(&self, a: Outline<'_>, b: Outline<'_>, motion: &RelativeMotion, horizon: f64) -> Answer;

    /// The same of a pair that is known to meet no sooner than `begin` (time), so that the search may begin there.
    fn first_contact_after(
        &self,
        begin: f64,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        let _ = begin;
        self.first_contact(a, b, motion, horizon)
    }

    /// When each of some bodies, taken for their bounding circles, may touch the asking one at the soonest (time from
    /// now, infinite for never): what is told without a search, to pass over most candidates for a first contact, and to
    /// search the others in order. What is at `horizon` or later need not be known better than that.
    ///
    /// Without further knowledge it is when the bounding circles meet, which every detector must respect.
    #[inline(always)]
    fn contact_time_lower_bounds<const N: usize>(
        &self,
        query: &QueryBody<'_>,
        lanes: &DiscLanes<N>,
        horizon: f64,
    ) -> [f64; N]
    where
        Self: Sized,
    {
        let _ = (query, horizon);
        lanes.entry_times()
    }

    /// The same of one disc alone, which comes into the asking body's bounding circle: it pays to look at it more closely
    /// before it is searched. What lies beyond `horizon` may be told wrongly, as above.
    ///
    /// Without further knowledge it may be touched at once.
    #[inline(always)]
    fn contact_time_lower_bound(&self, query: &QueryBody<'_>, lanes: &DiscLanes<1>, horizon: f64) -> f64
    where
        Self: Sized,
    {
        let _ = (query, lanes, horizon);
        0.0
    }

    /// Whether pairs of discs are decided in closed form: then a scheduler may compute it itself,
    /// in lanes, where it would have called [`Self::disc_contacts`].
    #[inline]
    fn decides_discs_in_closed_form(&self) -> bool {
        false
    }

    /// The same for one disc against eight others: the time of each contact, infinite for none.
    ///
    /// Times may lie beyond any horizon; the caller drops what it cannot use.
    fn disc_contacts(&self, lanes: &DiscLanes) -> [f64; DISC_LANES] {
        if self.decides_discs_in_closed_form() {
            return lanes.contact_times();
        }
        std::array::from_fn(|lane| {
            // What counts is the sum of the two radii: two discs of half of it each.
            let disc = Atom::new(DVec2::ZERO, 0.5 * lanes.contact_distance[lane], 1.0);
            let (Some(motion), Ok(disc)) = (lanes.relative_motion(lane), disc) else { return f64::INFINITY };
            let answer = self.first_contact(disc.outline(), disc.outline(), &motion, f64::MAX);
            answer.outcome.contact().map_or(f64::INFINITY, |contact| contact.time)
        })
    }
}
