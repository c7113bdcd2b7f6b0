//! Does a small tee-shaped molecule in a dense gas of discs receive a net force along its body axes
//! (Montanari 2017, chapter 3)?
//!
//! `cargo xtask experiment brownian`: every impulse on the molecule is recorded by direction and
//! by atom; quantities that vanish at equilibrium are tested. Runs of several cases, sizes and
//! replicas are executed in parallel.

mod analysis;
mod charts;
mod dilute;
mod distributions;
mod equilibrium;
mod figures;
mod group;
mod kicks;
mod measurement;
mod options;
mod pooled;
mod prediction;
mod report;
mod results;
mod run;
mod snapshots;
mod system;

pub use options::{OneOrAll, Options, Plan};
pub use run::run;
