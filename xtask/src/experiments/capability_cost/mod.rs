//! `cargo xtask experiment capability-cost`: what each capability costs where it is absent, idle, and used.

mod callgrind;
mod campaign;
mod capability;
mod dependencies;
mod options;
mod report;
mod results;
mod subject;

pub use campaign::{run, work};
pub use options::Options;

/// The name of the command that runs one variant to be counted.
pub const COMMAND: &str = "capability-worker";
