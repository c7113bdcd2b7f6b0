//! `cargo xtask experiment encounters`: cost of accuracy and errors of inaccurate detectors in the
//! search for one contact.

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
