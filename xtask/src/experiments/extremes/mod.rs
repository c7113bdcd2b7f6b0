//! Up to which limits do the guarantees hold, and how does a run end beyond them?
//!
//! `cargo xtask experiment extremes`: extreme scenes with the bounds that must hold, parameters
//! increased until a bound fails, time reversal, and energy drift.

mod drift;
mod gaps;
mod limits;
mod options;
mod report;
mod results;
mod reversal;
mod run;
mod trial;

pub use options::ExtremesOptions;
pub use run::run;
