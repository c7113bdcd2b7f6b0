//! `cargo xtask experiment brownian`: a small tee-shaped molecule in a dense gas of discs, and the
//! impulses on it (Montanari 2017, chapter 3).

mod campaign;
mod dilute;
mod distributions;
mod figures;
mod group;
mod kicks;
mod measurement;
mod options;
mod pooled;
mod prediction;
mod report;
mod snapshots;
mod system;
mod verdict;

pub use campaign::run;
pub use options::{OneOrAll, Options, Plan};
