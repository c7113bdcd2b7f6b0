//! What does a capability of the engine cost a gas of discs if it is absent, idle, or used?
//!
//! `cargo xtask experiment capability-cost`: instructions under callgrind, processor time, and
//! memory.

mod callgrind;
mod capability;
mod dependencies;
mod options;
mod report;
mod results;
mod run;
mod subject;

pub use options::CapabilityCostOptions;
pub use run::{run, work};

/// Name of the command that runs one variant under callgrind.
pub const COMMAND: &str = "capability-worker";
