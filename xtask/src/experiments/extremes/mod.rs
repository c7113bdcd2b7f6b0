//! `cargo xtask experiment extremes`: limits of the guarantees, and the behaviour beyond them.

mod campaign;
mod drift;
mod edges;
mod gaps;
mod options;
mod report;
mod results;
mod reversal;
mod trial;

pub use campaign::run;
pub use options::Options;
