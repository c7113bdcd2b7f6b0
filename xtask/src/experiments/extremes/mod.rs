//! `cargo xtask experiment extremes`: where the numbers break, and what happens there.

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
