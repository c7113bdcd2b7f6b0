//! How accurate and how fast are whole simulations under different settings?
//!
//! `cargo xtask experiment tradeoff`: wrong contacts, overlaps, effective error, and physics of
//! each setting, and its processor time relative to the exact default run.

mod advice;
mod charts;
mod knobs;
mod measures;
mod observers;
mod options;
mod rapier;
mod replay;
mod report;
mod results;
mod reversal;
mod run;
mod scenes;
mod settle;

pub use options::Options;
pub use run::run;
