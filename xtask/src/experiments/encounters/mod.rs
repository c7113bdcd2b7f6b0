//! `cargo xtask experiment encounters`: what accuracy costs, and inaccuracy misses, in the search for a single contact.

mod campaign;
mod cases;
mod charts;
mod options;
mod overall;
pub mod parry;
mod recorder;
mod report;
mod results;
pub mod settings;
mod tally;
mod timing;

pub use campaign::run;
pub use options::Options;
