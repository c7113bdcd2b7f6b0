//! When do two bodies in free flight first touch? Reads motions, changes nothing.
//!
//! The question is one [`RelativeMotion`](carom_kinematics::RelativeMotion) (two bodies at a common
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

mod atom_block;
mod atom_pair;
mod bounding_circles;
mod circle_descent;
mod crop;
mod disc;
#[cfg(feature = "encounters")]
pub mod encounters;
mod error_bound;
mod exact;
mod fixed_step;
mod flight;
mod golden_secant;
mod golden_section;
mod lanes;
mod outcome;
mod recontact;
mod safe_step;
mod search;
mod secant;
mod skimming;
mod squared_gap;
pub mod tolerance;

pub use bounding_circles::BoundingCircles;
pub use disc::{DiscBatch, LANES, disc_contact};
pub use error_bound::ErrorBound;
pub use exact::Exact;
pub use fixed_step::{FixedStep, natural_time};
pub use golden_secant::GoldenSecant;
pub use lanes::{DISC_LANES, DiscLanes};
pub use outcome::{Answer, Contact, Outcome, Touch};
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
    fn first_contact(&self, a: Outline<'_>, b: Outline<'_>, motion: &RelativeMotion, horizon: f64) -> Answer;

    /// The same for one disc against a batch of discs: the time of each contact, infinite for none.
    ///
    /// Times may lie beyond any horizon; the caller drops what it cannot use.
    fn disc_contacts(&self, batch: &DiscBatch, times: &mut [f64; LANES]) {
        *times = [f64::INFINITY; LANES];
        let disc = |radius| Atom::new(DVec2::ZERO, radius, 1.0);
        for (lane, time) in times.iter_mut().enumerate().take(batch.count) {
            let motion = batch.relative_motion(lane);
            let (Ok(a), Ok(b)) = (disc(batch.radius), disc(batch.radii[lane])) else { continue };
            let answer = self.first_contact(a.outline(), b.outline(), &motion, f64::MAX);
            if let Outcome::Contact(contact) = answer.outcome {
                *time = contact.time;
            }
        }
    }
}
