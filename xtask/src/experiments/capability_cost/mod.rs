//! `cargo xtask experiment capability-cost`: the cost of each capability that is absent, idle, or
//! used.

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

/// Name of the command that runs one variant under callgrind.
pub const COMMAND: &str = "capability-worker";
