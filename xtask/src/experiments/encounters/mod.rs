//! What does accuracy cost in the search for one contact, and which errors do inaccurate detectors
//! make?
//!
//! `cargo xtask experiment encounters`: all detectors on all classes of encounters, compared with a
//! reference in extended precision.

mod cases;
mod charts;
mod cost;
mod options;
mod overall;
pub mod parry;
mod recorder;
mod report;
mod results;
mod run;
pub mod settings;
mod tally;
mod timing;

pub use options::Options;
pub use run::run;
