//! How accurate and how fast are whole simulations of four gases under different settings?
//!
//! `cargo xtask experiment tradeoff`: what `carom trade` measures, in four built-in scenes and with
//! a fixed amount of work, and rapier beside it.

mod options;
mod rapier;
mod report;
mod run;
mod scenes;
mod settle;

pub use options::Options;
pub use run::run;
