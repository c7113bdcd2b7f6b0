//! A judge of detectors: the first contact of two molecules to some 25 digits, by a search that shares nothing with
//! any of them.
//!
//! **What is asked.** A detector that works in doubles cannot see a gap that is smaller than its rounding. So the
//! oracle looks for the *deep* contact, the first moment at which two atoms overlap by more than 2 E, the printed
//! bound of [`ErrorBound`](carom_detection::ErrorBound); whoever claims to be exact must have reported by then. A pair
//! that begins in overlap may overlap by as much and 2 E more. [`judge`](Reference::judge) then tells what an answer
//! is worth.
//!
//! **How.** For S = s less what is allowed, F(t) = |d|² − S² of one atom pair is looked at in the middle m of an
//! interval of half width h. From d'' = ω_A² r_A − ω_B² r_B follows F'' ≥ −M, so F ≥ F(m) − |F'(m)| h − M h²/2 there:
//! if that is positive the interval is excluded. Where F' keeps its sign, there is a zero if the ends differ, and none
//! if not. All other intervals are halved, the earlier half first. Nothing is sampled, so nothing is passed over; a
//! search that does not end within its budget says so.
//!
//! Of a wall the end points are atoms; its face is looked at in a module of its own, by the same exclusion.
//!
//! The arithmetic is [`DoubleDouble`], or for a check of that `dashu_float` at 200 bits.

mod big;
mod double_double;
mod exclusion;
mod face;
mod flight;
mod judgement;
mod number;
mod search_end;
mod sketch;

pub use big::Big;
pub use double_double::DoubleDouble;
pub use exclusion::{Deep, Oracle, Reference};
pub use judgement::{Judgement, Verdict, gap_over_bound};
pub use number::Number;
