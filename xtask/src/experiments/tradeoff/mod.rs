//! `cargo xtask experiment tradeoff`: accuracy and speed of whole simulations under different
//! settings.

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
