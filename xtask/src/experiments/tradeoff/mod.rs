//! `cargo xtask experiment tradeoff`: whole simulations with each knob turned, what that buys, and what it costs.

mod advice;
mod campaign;
mod charts;
mod epochs;
mod knobs;
mod measures;
mod observers;
mod options;
mod rapier;
mod replay;
mod report;
mod results;
mod reversal;
mod runner;
mod scenes;
mod settle;

pub use campaign::run;
pub use options::Options;
