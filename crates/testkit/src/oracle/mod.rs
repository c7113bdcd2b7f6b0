//! Reference oracle: the first contact of two molecules to about 25 digits, by a search that shares
//! no code with the detectors.
//!
//! **Definition.** A detector in double precision cannot resolve a gap smaller than its rounding
//! error. The oracle therefore searches the *deep* contact: the first time at which two atoms
//! overlap by more than 2 E, where E is the bound of [`ErrorBound`](carom_detection::ErrorBound).
//! An exact detector must have reported a contact by then. A pair that overlaps at the start may
//! overlap by that amount plus 2 E. [`judge`](ExclusionReference::judge) compares an answer with
//! the reference.
//!
//! **Method.** Interval exclusion for F(t) = |d|² − S² of one pair of atoms, with S = s minus the
//! allowance.
//! 1. **Bound.** From d'' = ω_A² r_A − ω_B² r_B follows F'' ≥ −M, so F ≥ F(m) − |F'(m)| h − M h²/2
//!    on an interval with centre m and half width h.
//! 2. **Exclusion.** An interval on which this bound is positive has no zero.
//! 3. **Monotonicity.** Where F' keeps its sign, there is a zero if F differs in sign at the ends,
//!    and none otherwise.
//! 4. **Bisection.** All other intervals are bisected, the earlier half first.
//!
//! No step samples, so no contact is missed; a search that exceeds its limit is reported as
//! unresolved.
//!
//! The end points of a wall are atoms; its edge is searched in a separate module, by the same
//! exclusion.
//!
//! The arithmetic is [`DoubleDouble`], or `dashu_float` at 200 bits to verify it.

mod assertions;
mod big;
mod double_double;
mod edge;
mod edge_sketch;
mod exclusion;
mod flight;
mod interval_search;
mod judgement;
mod number;
mod sketch;

pub use assertions::{assert_agreement, assert_guarantee};
pub use big::BigFloat;
pub use double_double::DoubleDouble;
pub use exclusion::{Deep, ExclusionReference, Oracle};
pub use judgement::{Judgement, OracleVerdict, gap_over_bound};
pub use number::Number;
