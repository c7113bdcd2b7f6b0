//! Computes the time of the first contact (time of impact) of two rigid bodies in free flight.
//!
//! Stable: its public items follow the policy of versions in the book (*Versions and releases*).
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
//! The input is one [`RelativeMotion`] (two bodies at a common time 0, in one periodic image) and a
//! horizon. The result is an [`Outcome`]. The crate changes no state. Every detector implements the
//! trait [`Detection`]:
//!
//! | detector | method |
//! | --- | --- |
//! | [`Exact`] | certified: it misses no contact deeper than twice the rounding bound |
//! | [`GoldenSecant`] | Montanari (2017), chapter 2: skim, crop, golden section, secant |
//! | [`BoundingCircles`] | a coarser model: each body is its bounding circle |
//! | [`FixedStep`] | overlap tests at regular times, as in a time-stepped code |
//!
//! The method `trace` of each detector also returns the steps of its search ([`Trace`]).
//!
//! Atoms may be ellipses, which [`Exact`] alone searches; [`first_contact_of_convex`] takes any
//! convex bodies. A body may have straight edges between atoms, as capsules and polygons do. A wall
//! is an edge of infinite mass, and a half-plane one of infinite length, which must not turn:
//!
//! ```
//! use carom_detection::{Detection, Exact, Part, Touch};
//! use carom_geometry::{HalfPlane, Molecule, Shape};
//! use carom_kinematics::RelativeMotion;
//! use glam::DVec2;
//!
//! // A dumbbell of arms 1 and radii 1 turns 1.5 above the ground. An atom touches at sin θ = 1/2.
//! let ground = HalfPlane::new(DVec2::Y)?;
//! let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0)?;
//! let pair = RelativeMotion {
//!     angular_velocity: [0.0, 1.0],
//!     ..RelativeMotion::exactly(DVec2::new(0.0, 1.5), DVec2::ZERO)
//! };
//! let answer = Exact::default().first_contact(ground.outline(), dumbbell.outline(), &pair, 10.0);
//! let contact = answer.outcome.contact().expect("it comes down");
//! assert!((contact.time - std::f64::consts::FRAC_PI_6).abs() < 1e-15);
//! assert_eq!(contact.touch, Touch::EdgeOfA { edge: 0, part: Part::Atom(0) });
//! # Ok::<(), carom_geometry::GeometryError>(())
//! ```

#![allow(
    clippy::inline_always,
    reason = "kernels must be compiled with the vector instructions of their callers"
)]

mod arc_pair;
mod atom_block;
mod atom_pair;
mod atom_row;
mod bounding_circles;
mod circle_descent;
mod convex_parts;
mod crop;
mod disc;
mod driven;
mod edge_error;
mod edge_pair;
mod edges;
mod ellipses;
#[cfg(feature = "encounters")]
pub mod encounters;
mod error_bound;
mod exact;
#[cfg(test)]
mod first_zero;
mod fixed_step;
mod flight;
mod gap_search;
mod golden_secant;
mod golden_section;
mod lanes;
mod lines;
mod molecule_pair;
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
mod support_edge;
mod support_pair;
mod tether;
pub mod tolerance;
mod trace;

pub use bounding_circles::BoundingCircles;
pub use convex_parts::first_contact_of_convex;
pub use exact::Exact;
pub use fixed_step::{FixedStep, natural_time};
pub use golden_secant::GoldenSecant;
pub use lanes::{DISC_LANES, DiscLanes};
pub use outcome::{Answer, Contact, Outcome, Part, Touch};
pub use query_body::QueryBody;
pub use tether::{Tether, TetherBound, TetherError};
pub use trace::{MAX_RECORDED, Parts, Phase, SearchStep, Trace};

// Parts that the other layers and tests of accuracy share; no user of the library needs them.
#[doc(hidden)]
pub use edge_error::EdgeErrorBound;
#[doc(hidden)]
pub use error_bound::ErrorBound;
#[doc(hidden)]
pub use resolved_speed::resolved_speed;
#[doc(hidden)]
pub use skimming::{SearchWindow, skim};

use carom_geometry::{Atom, Outline};
use carom_kinematics::{Drive, RelativeMotion};
use glam::DVec2;

/// Detection of the first contact of two moving bodies before a horizon.
///
/// An implementation must be a pure function of its arguments. Exchanging A and B must exchange the
/// parts of A and B in the answer and change nothing else. The only exception is a tie
/// between atom pairs that touch at the same time; the caller must order these itself. Several
/// threads may call it at once.
pub trait Detection: Sync {
    /// Returns the first contact of A and B after time 0 and no later than `horizon` (time).
    ///
    /// A pair that touches or overlaps at time 0 is in contact at once if it closes. It is not in
    /// contact while it separates.
    ///
    /// A half-plane must not turn: the outcome is then [`Outcome::Unresolved`] at time 0.
    fn first_contact(
        &self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer;

    /// Returns the first contact of a pair that is certified free before `begin` (time), where the
    /// search may start.
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

    /// Broad phase: lower bounds on the contact times of up to `N` discs with the query body (time
    /// from now; infinite if there is no contact).
    ///
    /// Each lane holds the bounding circle of one candidate. A scheduler skips candidates whose
    /// bound is late and searches the others in the order of their bounds. A value of `horizon` or
    /// later only excludes contacts before `horizon`. The default returns the times at which the
    /// bounding circles meet, which are lower bounds for every detector.
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

    /// A tighter lower bound for one disc that enters the query body's bounding circle (time from
    /// now).
    ///
    /// A value past `horizon` only excludes contacts before `horizon`. The default is 0: always
    /// search.
    #[inline(always)]
    fn contact_time_lower_bound(
        &self,
        query: &QueryBody<'_>,
        lanes: &DiscLanes<1>,
        horizon: f64,
    ) -> f64
    where
        Self: Sized,
    {
        let _ = (query, lanes, horizon);
        0.0
    }

    /// Returns the first contact of a pair of which B has a drive from `from` (time) on, beside its
    /// uniform motion relative to A; it is certified free before `begin` (time).
    ///
    /// `motion` holds what the drive has added to position and velocity before. The default is
    /// [`Outcome::Unresolved`] at time 0.
    fn first_contact_driven(
        &self,
        begin: f64,
        bodies: [Outline<'_>; 2],
        motion: &RelativeMotion,
        drive: (&Drive, f64),
        horizon: f64,
    ) -> Answer {
        let _ = (begin, bodies, motion, drive, horizon);
        Answer {
            outcome: Outcome::Unresolved(0.0),
            evaluations: 0,
        }
    }

    /// Whether driven bodies are searched ([`Self::first_contact_driven`]), but for those with
    /// arcs.
    fn searches_driven_bodies(&self) -> bool {
        false
    }

    /// Whether ellipses and arcs are searched; else every search that concerns one ends as
    /// [`Outcome::Unresolved`] at time 0.
    fn searches_curves(&self) -> bool {
        false
    }

    /// Whether walls that turn are searched, for bodies without ellipses; else a search that
    /// concerns one may end as [`Outcome::Unresolved`] at time 0.
    fn searches_turning_walls(&self) -> bool {
        false
    }

    /// Whether contact times of pairs of discs are those of the closed form
    /// ([`DiscLanes::contact_times`]). A scheduler may then evaluate it itself, in SIMD lanes,
    /// instead of calling [`Self::disc_contacts`].
    #[inline]
    fn decides_discs_in_closed_form(&self) -> bool {
        false
    }

    /// Returns the contact times of one disc with up to eight others (time from now; infinite if
    /// there is no contact).
    ///
    /// Times may lie beyond any horizon; the caller discards those.
    fn disc_contacts(&self, lanes: &DiscLanes) -> [f64; DISC_LANES] {
        if self.decides_discs_in_closed_form() {
            return lanes.contact_times();
        }
        std::array::from_fn(|lane| {
            // The contact depends only on the sum of the two radii, so each disc gets half of it.
            let disc = Atom::new(DVec2::ZERO, 0.5 * lanes.contact_distance[lane], 1.0);
            let (Some(motion), Ok(disc)) = (lanes.relative_motion(lane), disc) else {
                return f64::INFINITY;
            };
            let answer = self.first_contact(disc.outline(), disc.outline(), &motion, f64::MAX);
            answer
                .outcome
                .contact()
                .map_or(f64::INFINITY, |contact| contact.time)
        })
    }
}
